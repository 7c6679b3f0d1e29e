"""A run whose engine cannot be trusted: it is ended, the row is named, the robot is in its safe stop."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import textwrap
from pathlib import Path

import pytest

pytest.importorskip("pybullet")

import forked
from busy import within
from PIL import Image
from play import rows

from rrp_sheets.runs.run_process import (
    INSTANT_WITHIN,
    PREPARED_AFTER,
    ROW_WITHIN,
    ROWS_STILL_WITHIN,
    SILENT_AFTER,
    Watchdog,
)

COMMAND = forked.COMMAND

CONNECTORS = """
import os
from dataclasses import replace
from rrp_sheets.connectors.map import MAP

def after(count, what):
    def build(wiring):
        seen = []
        def take(value):
            seen.append(value)
            if len(seen) > count:
                what(seen)
            return value
        from reactivex import operators as ops
        return wiring.inputs[0].pipe(ops.map(take))
    return build

def hang(seen):
    while True:
        pass

def hoard(seen):
    while True:
        seen.append(bytes(50_000_000))

def crash(seen):
    raise RuntimeError("a bug of this connector")

def vanish(seen):
    os._exit(9)

def provide():
    from rrp_sheets.connectors.spec import Parameter
    for name, what in (("hang", hang), ("hoard", hoard), ("crash", crash), ("vanish", vanish)):
        yield name, replace(MAP, name=name, build=after(20, what), parameter=Parameter.NONE, synonyms=())
"""


@pytest.fixture
def environment(tmp_path):
    """An environment in which a package with such connectors is installed."""
    place = tmp_path / "site"
    about = place / "wicked-1.0.dist-info"
    about.mkdir(parents=True)
    (place / "wicked.py").write_text(textwrap.dedent(CONNECTORS))
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: wicked\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[rrp_sheets.connectors]\nwicked = wicked:provide\n")
    return {**os.environ, "PYTHONPATH": str(place), "PYTHONIOENCODING": "utf-8"}


EVENT_LOOP = "## Protocol\n| Field | Value |\n|---|---|\n| Engine | event loop |\n"


def run_book(connector, tmp_path, environment, *arguments, engine="frame"):
    book = tmp_path / f"{connector}.md"
    arguments = ["--fast", *arguments] if engine == "frame" else arguments
    book.write_text(rows(f"| Red ball | subscribe | | Head tracker |\n| Red ball | {connector} | | X |\n"
                         "| X | map | 1 | Y |\n| Y | subscribe | | Print |",
                         *([EVENT_LOOP] if engine != "frame" else [])))  # fmt: skip
    out = tmp_path / f"out-{connector}"
    done = forked.run([*COMMAND, "run", str(book), "--out", str(out), "--json", *arguments], text=True,
                      env=environment, capture_output=True, encoding="utf-8", timeout=300)  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    return done, out


def head_top(out: Path, place: int) -> int:
    """Distance (pixels) of the robot's head from the top in the film's first or last (-1) picture; the ball is right of it."""
    with Image.open(out / "film.gif") as film:
        film.seek(place % film.n_frames)
        robot = film.convert("L").crop((60, 0, 240, 320))
    rows = (robot.crop((0, y, 180, y + 1)).getextrema() for y in range(320))
    return next(y for y, (dark, light) in enumerate(rows) if light - dark > 60)


def check_broken(done, out):
    """Exit code 3, a trace that can be read to its end, table and diagram, the row named, nothing left running."""
    assert done.returncode == 3
    assert "T!3" in done.stderr, done.stderr
    lines = [json.loads(line) for line in (out / "trace.jsonl").read_text("utf-8").splitlines()]
    assert lines[-1]["type"] == "summary" and lines[-1]["ended"] == "broken" and lines[-1]["by"] == "T!3"
    assert lines[-1]["events"]["Red ball"] >= 20
    assert {"run.xlsx", "diagram.svg", "film.gif", "strip.png", "protocol.xlsx"} <= {p.name for p in out.iterdir()}
    assert json.loads(done.stdout.splitlines()[-1])["broken"]


@pytest.mark.parametrize("engine", ["frame", pytest.param("event loop", marks=pytest.mark.slow)])
def test_a_stuck_row_is_ended_and_named_and_the_robot_stops_safely(engine, tmp_path, environment):
    with within(30):
        done, out = run_book("hang", tmp_path, environment, engine=engine)
    check_broken(done, out)
    assert head_top(out, -1) > head_top(out, 0) + 20  # it crouches, as after an orderly stop


def test_a_row_that_eats_memory_is_ended_and_named(tmp_path, environment):
    done, out = run_book("hoard", tmp_path, environment)
    check_broken(done, out)
    assert "memory" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("connector", ["crash", "vanish"])
def test_a_row_that_takes_the_engine_down_is_named(connector, tmp_path, environment):
    done, out = run_book(connector, tmp_path, environment)
    check_broken(done, out)
    assert "ended unexpectedly" in done.stderr


def test_ctrl_c_need_not_wait_for_a_check_that_never_ends(tmp_path, environment):
    site = Path(environment["PYTHONPATH"])
    begun = tmp_path / "begun"
    os.mkfifo(begun)
    (site / "wicked.py").write_text(f"open({str(begun)!r}, 'w').close()\nwhile True:\n    pass\n")
    book = tmp_path / "b.md"
    book.write_text(rows("| Red ball | subscribe | | Head tracker |"))
    process = forked.Forked([*COMMAND, "run", str(book), "--out", str(tmp_path / "o")], env=environment,
                            stderr=subprocess.PIPE, text=True, encoding="utf-8")  # fmt: skip
    begun.open().close()  # until the check opens it, too
    with within(15):
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=300)
    assert process.returncode == 130 and errors == "" and not (tmp_path / "o").exists()


class Clock:
    """Looks at a watchdog's cell at made-up times, with made-up processor time."""

    def __init__(self):
        self.cell = [0, 0, -1]
        self.now = self.cpu = 0.0
        self.dog = Watchdog(self.cell, lambda: self.cpu, lambda: self.now)
        self.failure, self.slow = "", False
        self.look()

    def look(self, **how):
        rows = {n: f"T!{n}" for n in range(100)}
        self.failure, self.slow = self.dog.failure(**{"heard": False, "rows": rows, **how}) or ("", False)
        return self.failure

    def after(self, seconds, *, load=1.0, step=0.1, **how):
        """True when it must be ended within some seconds, of which it gets a share of the processor."""
        end = self.now + seconds
        while self.now < end:
            self.now += step
            self.cpu += step * load
            if self.look(**how):
                return True
        return False


def test_a_row_may_take_two_seconds_and_no_longer():
    clock = Clock()
    clock.cell[:] = [1, 1, 5]
    assert not clock.after(ROW_WITHIN - 0.2)
    assert clock.after(0.5) and "T!5" in clock.failure and not clock.slow


def test_a_row_that_gets_little_of_a_busy_machine_is_given_the_time_that_it_needs():
    clock = Clock()
    clock.cell[:] = [1, 1, 5]
    assert not clock.after(ROW_WITHIN * 18, load=0.05)
    assert clock.after(ROW_WITHIN * 4, load=0.05)


def test_a_row_that_waits_for_nothing_is_ended():
    clock = Clock()
    clock.cell[:] = [1, 1, 5]
    assert not clock.after(ROWS_STILL_WITHIN - 0.3, load=0)
    assert clock.after(1, load=0) and "been stuck" in clock.failure and "T!5" in clock.failure


def test_an_instant_has_a_limit_as_a_whole_and_its_costliest_rows_are_named():
    clock = Clock()
    for row in range(40):
        clock.cell[:] = [1, 1, row]
        if clock.after(0.9 if row == 2 else 0.3):
            break
    assert clock.now == pytest.approx(INSTANT_WITHIN, abs=0.5)
    assert "one moment" in clock.failure and "The slowest are T!2 (0.9 s), T!" in clock.failure
    assert clock.failure.count("T!") == 3 and clock.slow


def test_many_slow_instants_are_not_one():
    clock = Clock()
    for frame in range(20):
        clock.cell[:] = [frame, 1, 5]
        assert not clock.after(ROW_WITHIN - 0.3)
        clock.cell[:] = [frame, 0, -1]
        assert not clock.after(0.2, heard=True)


def test_a_paced_wait_is_no_stall_but_silence_is():
    clock = Clock()
    clock.cell[:] = [1, 0, -1]
    assert not clock.after(600, load=0, heard=True)
    assert not clock.after(SILENT_AFTER - 1, load=0)
    assert clock.after(2, load=0) and "T!" not in clock.failure
    clock = Clock()
    assert not clock.after(SILENT_AFTER - 1)
    assert clock.after(2)


def test_an_engine_that_waits_for_the_simulator_may_be_silent():
    clock = Clock()
    clock.cell[:] = [1, 0, -1]
    assert not clock.after(600, load=0, waits=True)
    assert clock.after(SILENT_AFTER + 1, load=0)


def test_what_may_take_long_is_given_time():
    clock = Clock()
    assert not clock.after(PREPARED_AFTER - 1, silent_after=PREPARED_AFTER)
    assert clock.after(2, silent_after=PREPARED_AFTER)


def test_a_machine_that_slept_has_nobody_stuck():
    clock = Clock()
    clock.cell[:] = [1, 1, 5]
    assert not clock.after(3600, step=3600, load=0)
