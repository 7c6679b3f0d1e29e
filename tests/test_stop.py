"""Stop goes to the robot by a way of its own: slow rows, a frozen engine or simulator, a supervisor that has died.

The limits of time here are wide, for a busy machine; `tests/benchmarks/bench_stop.py` holds the real ones.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pybullet")

import forked
from busy import Span, within
from motion import use
from PIL import Image
from play import rows
from test_watchdog import EVENT_LOOP, head_top

from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.model.exchange import Arrivals, Command, Notice
from rrp_sheets.recording.messages import as_message
from rrp_sheets.robots import load_robot
from rrp_sheets.runs.run_data import RunSettings
from rrp_sheets.runs.run_process import RunOutcome, RunProcess
from rrp_sheets.sim.process import REQUESTS, Simulator, Spec
from rrp_sheets.sim.sounds import espeak
from rrp_sheets.texts import translate
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, encode

CONNECTORS = """
import os, time
from dataclasses import replace
from rrp_sheets.connectors.map import MAP

def build(wiring):
    def take(value):
        open(os.environ["BEGUN"], "w").close()
        until = time.thread_time() + 0.1
        while time.thread_time() < until:
            pass
        return value
    from reactivex import operators as ops
    return wiring.inputs[0].pipe(ops.map(take))

def provide():
    from rrp_sheets.connectors.spec import Parameter
    yield "slow", replace(MAP, name="slow", build=build, parameter=Parameter.NONE, synonyms=())
"""
ENGINES = pytest.mark.parametrize("engine", ["frame", pytest.param("event loop", marks=pytest.mark.slow)])
COARSE = 0.02  # s: the clock of a file system is behind by a tick of the kernel's
FILES = {"trace.jsonl", "run.xlsx", "diagram.svg", "protocol.xlsx"}
SLOW = "\n".join(f"| Red ball | slow | | S{n} |\n| S{n} | subscribe | | Print |" for n in range(40))
FAST = "| Red ball | subscribe | | Head tracker |"
CIRCLING = """
## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0 | Red ball | appears | at 1.2, 0, 0.42 |
| 0.1 | Red ball | circles | radius 0.3 around 1.2, 0, 0.42 period 2 s |
"""
"""The head then moves all the time, so that each moment until the rest is in the record of poses."""


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that is there as soon as a slow row is at work; its connector is installed."""
    place = tmp_path / "site"
    about = place / "slow-1.0.dist-info"
    about.mkdir(parents=True)
    (place / "slowly.py").write_text(textwrap.dedent(CONNECTORS))
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: slow\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[rrp_sheets.connectors]\nslow = slowly:provide\n")
    monkeypatch.setenv("PYTHONPATH", str(place))
    monkeypatch.setenv("BEGUN", str(tmp_path / "begun"))
    start = partial(forked.start_worker, forked.Forked)  # the fork server of all tests does not know this environment
    monkeypatch.setattr("rrp_sheets.workers.worker_process._start_process", start)
    return tmp_path / "begun"


class Panel(RunObserver):
    """Notes when something was told."""

    def __init__(self) -> None:
        self.began = 0.0
        self.us = 0
        self.finished: list[float] = []
        self.notes: list[str] = []

    def started(self, start: Any) -> None:
        """It runs."""
        self.began = time.monotonic()

    def frame(self, us: int) -> None:
        """A frame has gone."""
        self.us = us

    def finishing(self) -> None:
        """The robot has begun its rest."""
        self.finished.append(time.monotonic())

    def notice(self, us: int, notice: Notice) -> None:
        """Something is told."""
        self.notes.append(notice.text)


class Running:
    """A run of some rows that is listened to on a thread."""

    def __init__(self, tmp_path: Path, body: str, *more: str, **settings: Any) -> None:
        book = tmp_path / "b.md"
        book.write_text(rows(body, *more))
        self.out = tmp_path / "out"
        self.panel = Panel()
        self.run = RunProcess(book, RunSettings(**{"film": False, "seconds": 600, "out": self.out, **settings}))
        self.ended: list[RunOutcome] = []
        self.thread = threading.Thread(target=lambda: self.ended.append(self.run.listen(self.panel)), daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """Stop it, and wait until it has ended."""
        self.run.stop("Aya")
        self.thread.join(300)

    def summary(self) -> dict[str, Any]:
        """The last line of its trace."""
        return dict(json.loads((self.out / "trace.jsonl").read_text("utf-8").splitlines()[-1]))


def wait_until(holds: Callable[[], object]) -> None:
    until = time.monotonic() + 300
    while not holds():
        assert time.monotonic() < until
        threading.Event().wait(0.02)


@ENGINES
def test_stop_does_not_wait_for_slow_rows(engine: str, tmp_path: Path, begun: Path) -> None:
    more = [EVENT_LOOP] if engine == "event loop" else []
    running = Running(tmp_path, SLOW, *more, film=engine == "frame")
    wait_until(begun.exists)
    span = Span()
    running.stop()
    assert running.panel.finished[0] - span.began < 0.5 * span.crowded(), "the robot is on its way to rest"
    result = running.ended[0].result
    assert result is not None and result.broken is None
    assert (result.summary.ended, result.summary.stopped_by) == ("stopped", "Aya") and len(running.panel.finished) == 1
    assert running.summary() == {"type": "summary", **result.summary.as_dict(wall=False)}
    assert set(result.files) >= FILES and not result.problems
    notes = [note for note in running.panel.notes if "so the engine was stopped while row T!" in note]
    assert notes and all(note.endswith("The recording is saved.") for note in notes)
    assert translate(as_message(notes[0]), "ja").endswith("記録は保存されています。"), "also when the recording is read"
    if engine == "frame":
        assert {"film.gif", "strip.png"} <= set(result.files)
        assert head_top(running.out, -1) > head_top(running.out, 0) + 20, "it crouches, as after an orderly stop"


def test_stop_does_not_wait_for_a_frozen_engine(tmp_path: Path) -> None:
    running = Running(tmp_path, "| Chest button | subscribe | | Print |")  # nobody presses it: there are no values
    wait_until(lambda: running.panel.us > 500_000)
    os.kill(running.run.pid, signal.SIGSTOP)
    span = Span()
    running.stop()
    assert running.panel.finished[0] - span.began < 0.5 * span.crowded()
    result = running.ended[0].result
    assert result is not None and result.broken is None and running.summary()["ended"] == "stopped"
    assert set(result.files) >= FILES
    assert result.summary.simulated == running.panel.us / 1e6, "as long as the run, not as its last value"
    assert running.summary()["simulated_seconds"] == result.summary.simulated


@ENGINES
def test_of_a_frozen_simulator_no_rest_is_claimed(engine: str, tmp_path: Path) -> None:
    running = Running(tmp_path, FAST, *([EVENT_LOOP] if engine == "event loop" else []))
    wait_until(lambda: running.panel.us > 500_000)
    os.kill(running.run.simulator_pid, signal.SIGSTOP)
    with within(3):
        running.stop()
    result = running.ended[0].result
    assert result is not None and result.broken is not None
    assert (
        "did not react to Stop" in result.broken.message and "did not reach its rest position" in result.broken.message
    )
    assert running.panel.finished == [] and set(result.files) >= FILES
    assert running.summary()["why"] == result.broken.message and running.summary()["ended"] == "broken"
    assert len([note for note in running.panel.notes if "imulator" in note]) == 0, "the cause is told once"


@pytest.mark.soak
def test_a_frozen_simulator_and_a_frozen_engine_are_both_ended(tmp_path: Path) -> None:
    running = Running(tmp_path, FAST)
    wait_until(lambda: running.panel.us > 500_000)
    for pid in (running.run.simulator_pid, running.run.pid):
        os.kill(pid, signal.SIGSTOP)
    with within(4):
        running.stop()
    result = running.ended[0].result
    assert result is not None and result.broken is not None and "did not react to Stop" in result.broken.message
    assert running.panel.finished == [] and set(result.files) >= FILES


@pytest.mark.slow
def test_an_instant_that_takes_too_long_is_ended_with_its_costliest_rows(
    tmp_path: Path, begun: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rrp_sheets.runs.run_process.INSTANT_WITHIN", 1.0)
    running = Running(tmp_path, SLOW)
    running.thread.join(300)
    result = running.ended[0].result
    assert result is not None and result.broken is not None
    assert "more than 1 s. The slowest are T!" in result.broken.message and result.summary.ended == "broken"
    assert len(running.panel.finished) == 1, "the robot comes to its rest"


class Requests:
    """The engine's connection to a simulator."""

    def __init__(self, simulator: Simulator) -> None:
        self.link = simulator.requests
        self.answers = iter(MessageReader(self.link))

    def send(self, number: int, request: str, *arguments: object) -> None:
        parts = (pack(part, hint) for part, hint in zip(arguments, REQUESTS[request][0], strict=True))
        self.link.sendall(encode([number, request, *parts]))


def test_an_engine_that_floods_the_simulator_does_not_delay_its_rest() -> None:
    simulator = Simulator()
    requests = Requests(simulator)
    with requests.link:
        requests.send(0, "open", Spec(load_robot()))
        assert next(requests.answers) == [0, None]
        flood = threading.Thread(target=lambda: [requests.send(n, "state") for n in range(200)])
        flood.start()
        assert next(requests.answers)[0] == 0
        with within(0.5):
            simulator.rest()
            while not simulator.resting:
                simulator.hear()
                assert not simulator.failure()
        for n in range(1, 200):
            assert next(requests.answers)[0] == n, "and it goes on answering"
        flood.join()
    simulator.close(20)


def test_stop_does_not_wait_until_a_long_text_has_become_sound() -> None:
    simulator = Simulator()
    requests = Requests(simulator)
    with requests.link:
        requests.send(0, "open", Spec(load_robot(), actuators=(use("say", "SayInput"),)))
        assert next(requests.answers) == [0, None]
        requests.send(1, "start")
        next(requests.answers)
        wait_until(lambda: not simulator.working)
        requests.send(2, "advance", 33_333, (Command("say", "1234567 " * 250),))
        wait_until(lambda: simulator.working)
        with within(0.3):
            simulator.rest()
            wait_until(lambda: simulator.hear() or simulator.resting)
        outcome = unpack(Arrivals, next(requests.answers)[1])
    simulator.close(20)
    assert [notice.kind for notice in outcome.notices][:1] == ["say"]


def test_no_more_of_a_text_becomes_sound_after_stop() -> None:
    library = espeak()
    assert len(library.say("1234567 " * 20, 200, 100)) > 10 * library.rate
    assert len(library.say("1234567 " * 20, 200, 100, halted=lambda: True)) < library.rate


def test_a_simulator_without_a_robot_is_not_taken_for_a_frozen_one() -> None:
    simulator = Simulator()
    simulator.rest()
    wait_until(lambda: simulator.hear() or simulator.resting)
    assert not simulator.failure()
    simulator.close()


@pytest.mark.slow
def test_a_simulator_that_is_killed_leaves_its_film(tmp_path: Path) -> None:
    running = Running(tmp_path, FAST, film=True)
    wait_until(lambda: running.panel.us > 2_000_000)
    os.kill(running.run.simulator_pid, signal.SIGKILL)
    running.thread.join(300)
    result = running.ended[0].result
    assert result is not None and result.broken is not None and "(signal 9)" in result.broken.message
    assert running.panel.notes == [] and result.problems == (), "the cause is told, and nothing that follows from it"
    with Image.open(running.out / "film.gif") as film:
        assert getattr(film, "n_frames", 1) >= 5
        film.seek(4)
        film.load()


@contextmanager
def command(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run of the command line that has gone on for half a second."""
    book, out = tmp_path / "b.md", tmp_path / "out"
    book.write_text(rows(FAST, CIRCLING))
    arguments = [*forked.COMMAND, "run", str(book), "--for", "600", "--out", str(out)]
    with forked.Forked(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as running:
        wait_until(lambda: (out / "trace.jsonl").is_file() and '"t":0.5' in (out / "trace.jsonl").read_text())
        yield running


@pytest.mark.soak
def test_ctrl_c_ends_the_command_soon_with_all_files(tmp_path: Path) -> None:
    with command(tmp_path) as running, within(3):
        running.send_signal(signal.SIGINT)
        running.communicate(timeout=300)
    assert running.returncode == 130
    assert {p.name for p in (tmp_path / "out").iterdir()} >= FILES | {"film.gif", "strip.png", "poses.jsonl"}


def test_the_robot_rests_at_once_when_its_supervisor_is_killed(tmp_path: Path) -> None:
    poses = tmp_path / "out" / "poses.jsonl"
    with command(tmp_path) as running:
        killed, span = time.time(), Span()
        running.kill()
    trace = tmp_path / "out" / "trace.jsonl"
    wait_until(lambda: '"summary"' in trace.read_text().splitlines()[-1])
    assert -COARSE < poses.stat().st_mtime - killed < 1 * span.crowded(), (
        "the record of poses is closed when the rest begins"
    )
    summary = json.loads(trace.read_text().splitlines()[-1])
    assert summary["ended"] == "stopped" and "the end of the program" in summary["stopped_by"]


# ---- no process outlives its supervisor
STUCK = """
import os, re, socket, sys
open(os.environ["BEGUN"], "w").close()
re.match("(a+)+$", "a" * 64 + "b")  # native code that does not let go of the interpreter
"""
STARTER = """
import os
from rrp_sheets.workers.worker_process import Task, WorkerProcess
child = WorkerProcess(Task("stuck.task", *[float(os.environ["GRACE"])] * 2))
open(os.environ["BEGUN"]).close()  # a named pipe: until the child opens it, too
print(child.pid, flush=True)
os._exit(1)
"""
SIMULATOR = """
import os
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.sounds import espeak
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.process import Simulator
from rrp_sheets.workers.codec import pack
from rrp_sheets.workers.transport import encode
simulator = Simulator()
requests = simulator.requests.dup()
requests.sendall(encode([1, "open", pack(Spec(load_robot()))]))
open(os.environ["BEGUN"]).close()
print(simulator.pid, flush=True)
os._exit(1)
"""
CV2 = """
import os, re
open(os.environ["BEGUN"], "w").close()
re.match("(a+)+$", "a" * 64 + "b")
"""


@contextmanager
def outlived(program: str) -> Iterator[tuple[float, float]]:
    """Let a starter die; how many seconds its child outlived it, and how crowded the machine was."""
    starter = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert starter.stdout is not None
    handle = None
    with starter, suppress(ProcessLookupError):
        handle = os.pidfd_open(int(starter.stdout.readline()))
    span = Span()
    if handle is not None:
        ended, _, _ = select.select([handle], [], [], 300)
        if not ended:
            signal.pidfd_send_signal(handle, signal.SIGKILL)
        os.close(handle)
    yield span.seconds(), span.crowded()


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waiting for a process that is not a child needs Linux")
@pytest.mark.parametrize("grace", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_native_code_that_never_ends_does_not_outlive_its_starter(
    grace: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stuck.py").write_text(STUCK)
    package = str(Path(__file__).parent.parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path), package)))
    os.mkfifo(tmp_path / "begun")
    monkeypatch.setenv("BEGUN", str(tmp_path / "begun"))
    monkeypatch.setenv("GRACE", str(grace))
    with outlived(STARTER) as (seconds, crowded):
        assert grace - 0.3 < seconds < (grace + 1) * crowded


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waiting for a process that is not a child needs Linux")
def test_a_simulator_stuck_in_native_code_ends_soon_after_its_supervisor(
    begun: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.mkfifo(begun)
    (tmp_path / "site" / "cv2.py").write_text(CV2)
    package = str(Path(__file__).parent.parent)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path / "site"), package)))
    with outlived(SIMULATOR) as (seconds, crowded):
        assert 4 < seconds < 6 * crowded
