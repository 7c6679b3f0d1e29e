"""`rrp-sheets run` and the other commands, as a person uses them: real processes, real files, real signals.

Most processes are forked from one that has the program imported (`support/forked.py`), some are started.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import forked
import pytest
from click.testing import CliRunner
from PIL import Image
from processes import workers

from rrp_sheets.cli.main import group
from rrp_sheets.resources import bundled
from rrp_sheets.workbook.files import make_workbook

BOOK = bundled("workbooks", "simple-tracking.xlsx")
COMMAND = forked.COMMAND
ENV = {**os.environ, "PYTHONIOENCODING": "utf-8"}
PIPES = {"env": ENV, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "encoding": "utf-8"}


def rrp(*arguments, cwd=None, env=None, process=forked.run):
    done = process([*COMMAND, *map(str, arguments)], cwd=cwd, env=env or ENV, capture_output=True, text=True,
                   encoding="utf-8", timeout=300)  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    return done


def started(*arguments):
    """The same by an interpreter of its own, as a shell does it."""
    return rrp(*arguments, process=subprocess.run)


def events(folder: Path) -> list[str]:
    """The lines of a trace after its header."""
    return (folder / "trace.jsonl").read_text(encoding="utf-8").splitlines()[1:]


@contextmanager
def one_core():
    """Let the processes that are started or forked meanwhile share one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


@contextmanager
def limited(process):
    """A process that is killed when it goes on after its test, or has not ended after five minutes."""
    timer = threading.Timer(300, process.kill)
    timer.start()
    try:
        with process:
            try:
                yield process
            except BaseException:
                process.kill()
                raise
    finally:
        timer.cancel()


def acts(process):
    """Wait until a run's robot does something."""
    assert any("Head tracker" in line for line in process.stdout)


@pytest.mark.slow
def test_a_forked_process_has_the_cores_of_its_starter():
    command = [sys.executable, "-c", "import os; print(*os.sched_getaffinity(0))"]

    def cores():
        return forked.run(command, capture_output=True, text=True).stdout.split()

    with one_core():
        assert len(cores()) == 1
    assert len(cores()) == len(os.sched_getaffinity(0))


TALKING = """
## T
| Input | Connector | Formula | Output |
|---|---|---|---|
| Red ball | subscribe | | Head and body tracker |
| Red ball | sample | 1 s | Red seen |
| Red seen | subscribe | | Say red |
| Green ball | sample | 1 s | Green seen |
| Green seen | subscribe | | Say green |

## Devices
| Stream | Device | Text |
|---|---|---|
| Say red | SayParameter | Red |
| Say green | SayParameter | Green |

## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0 | Red ball | appears | at 0.7, 0.1, 0.42 |
| 0.1 | Red ball | circles | radius 0.3 around 0.9, 0, 0.42 period 2 s |
"""


def twice(book: Path, seconds: float, folder: Path):
    """Run a workbook by a started and by a forked process, each of which keeps the other waiting, into a and b."""
    one, other = folder / "a", folder / "b"
    command = [*COMMAND, "run", str(book), "--fast", "--for", f"{seconds}s"]
    with (
        one_core(),
        limited(subprocess.Popen([*command, "--out", str(one)], **PIPES)) as started,
        limited(forked.Forked([*command, "--out", str(other)], env=ENV, stdout=subprocess.DEVNULL)) as quicker,
    ):
        _, errors = started.communicate()
    assert "Traceback" not in errors, errors
    assert (started.returncode, quicker.returncode) == (0, 0)
    return one, other


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run of a second and a half in the default folder: what it has printed, its errors and its folder."""
    folder = tmp_path_factory.mktemp("ran") / "実験 1 (a & b)"
    folder.mkdir()
    book = folder / "追跡 one.md"
    book.write_text(TALKING)
    done = started("run", book, "--fast", "--for", "1.5s", "--json", "--participant", "Anna Smith")
    assert done.returncode == 0
    (out,) = (folder / "runs").iterdir()
    return done.stdout, done.stderr, out


@pytest.mark.slow
def test_the_same_run_gives_the_same_bytes_however_busy_the_machine(tmp_path):
    (tmp_path / "talking.md").write_text(TALKING)
    one, other = twice(tmp_path / "talking.md", 1.5, tmp_path)
    assert events(one) == events(other) and len(events(one)) > 30


@pytest.mark.soak
def test_a_longer_run_gives_the_same_bytes_however_busy_the_machine(tmp_path):
    one, other = twice(bundled("workbooks", "complex-tracking.xlsx"), 4, tmp_path)
    assert events(one) == events(other) and len(events(one)) > 120


def test_a_run_tells_what_happens_and_what_it_left(ran):
    output, _, out = ran
    assert "says “Red”" in output and "trace.jsonl" in output
    summary = json.loads(output.splitlines()[-1])
    assert summary["simulated_seconds"] == 1.5 and summary["wall_seconds"] > 0 and summary["errors"] == {}
    commands = summary["actuator_commands"]
    assert commands.pop("Head and body tracker") > 10 and commands == {"Say red": 1, "Say green": 0}
    assert summary["events"]["Red ball"] > 10 and summary["folder"] == str(out)


def test_a_path_with_spaces_and_japanese_letters_and_the_default_folder(ran):
    _, _, out = ran
    assert out.name.endswith("追跡-one") and json.loads(events(out)[-1])["ended"] == "time"
    assert {"run.xlsx", "strip.png", "film.gif", "diagram.svg"} <= {p.name for p in out.iterdir()}


@pytest.mark.slow
def test_a_run_goes_on_when_the_reader_of_its_output_goes_away(tmp_path):
    out = tmp_path / "o"
    command = [*COMMAND, "run", str(BOOK), "--fast", "--for", "0.7s", "--out", str(out)]
    with limited(forked.Forked(command, cwd="/", **PIPES)) as process:
        process.stdout.readline()
        process.stdout.close()  # the run goes on nevertheless
        errors = process.stderr.read()
    assert process.returncode == 0 and errors == ""
    assert json.loads(events(out)[-1])["ended"] == "time"
    assert {"run.xlsx", "strip.png", "film.gif", "diagram.svg"} <= {p.name for p in out.iterdir()}


@pytest.mark.slow
def test_ctrl_c_stops_in_order_and_leaves_everything(tmp_path):
    out = tmp_path / "o"
    with limited(
        forked.Forked([*COMMAND, "run", str(BOOK), "--out", str(out)], start_new_session=True, **PIPES)
    ) as process:
        acts(process)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to every process of the group
        output, errors = process.communicate()
    assert process.returncode == 130 and "Traceback" not in errors
    assert "Stopped" in output
    assert json.loads(events(out)[-1])["ended"] == "stopped"
    assert {"run.xlsx", "strip.png", "film.gif", "diagram.svg"} <= {p.name for p in out.iterdir()}


def test_a_killed_simulator_breaks_the_run_off_with_a_readable_trace(tmp_path):
    out = tmp_path / "o"
    with limited(forked.Forked([*COMMAND, "run", str(BOOK), "--out", str(out)], **PIPES)) as process:
        acts(process)
        (simulator,) = workers(process.pid, "server")
        os.kill(simulator, signal.SIGKILL)
        _, errors = process.communicate()
    assert process.returncode == 3 and "stopped unexpectedly" in errors and "Traceback" not in errors
    assert json.loads(events(out)[-1])["ended"] == "broken"
    assert (out / "run.xlsx").is_file()
    with Image.open(out / "film.gif") as film:
        film.load()


@pytest.mark.parametrize(
    ("command", "limited"), [("explain", True), ("set", True), ("diagram", True), ("marbles", True), ("run", False)]
)
def test_what_evaluates_formulas_in_its_own_process_has_a_memory_limit(command, limited):
    script = "import resource\nfrom rrp_sheets.cli.main import main\ntry:\n    main()\nexcept SystemExit:\n    "
    script += "print(resource.getrlimit(resource.RLIMIT_AS)[0])"
    done = subprocess.run([sys.executable, "-c", script, command, "--help"], capture_output=True, text=True, check=True)
    assert (0 < int(done.stdout.splitlines()[-1]) < 1 << 32) is limited


def children(pid: int) -> list[int]:
    """The numbers of a process's children."""
    return [int(c) for c in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def child_of(pid: int, module: str) -> int:
    """The number of the child that runs a module."""
    (found,) = (c for c in children(pid) if module.encode() in Path(f"/proc/{c}/cmdline").read_bytes())
    return found


@pytest.mark.slow
@pytest.mark.parametrize("who", ["program", "engine"])
def test_no_process_is_left_behind(who, tmp_path):
    out = tmp_path / "o"
    command = [*COMMAND, "run", str(BOOK), "--out", str(out)]
    with limited(subprocess.Popen(command, start_new_session=True, **PIPES)) as process:
        acts(process)
        engine, simulator = (
            child_of(process.pid, f"rrp_sheets.{name}") for name in ("runs.engine_process", "sim.server")
        )
        left = {engine, simulator, *children(engine), *children(simulator)}
        assert len(left) == 4, "each has a guard"
        ends = {os.pidfd_open(pid) for pid in left}
        os.kill(process.pid if who == "program" else engine, signal.SIGKILL)  # without a word: the others notice
        deadline = time.monotonic() + 300
        while ends and (ended := select.select(ends, [], [], max(0, deadline - time.monotonic()))[0]):
            ends -= set(ended)
            for end in ended:
                os.close(end)
        assert not ends
        process.communicate()
    assert process.returncode == (-signal.SIGKILL if who == "program" else 3)
    assert (out / "film.gif").is_file() and (out / "run.xlsx").is_file()  # the robot has come to its rest
    assert json.loads(events(out)[-1])["ended"] == ("stopped" if who == "program" else "broken")


def test_without_the_simulator_one_line_says_what_is_needed(tmp_path):
    hide = "import sys; sys.modules['pybullet'] = None; from rrp_sheets.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", hide, "run", str(BOOK), "--out", str(tmp_path / "o")], env=ENV,
                          capture_output=True, text=True, encoding="utf-8", timeout=300)  # fmt: skip
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert "simulator" in done.stderr and "3.11" in done.stderr
    assert not (tmp_path / "o").exists()
    checked = subprocess.run(
        [sys.executable, "-c", hide, "check", str(BOOK)], env=ENV, capture_output=True, timeout=300
    )
    assert checked.returncode == 0


def test_a_workbook_with_errors_does_not_run(tmp_path):
    book = tmp_path / "b.md"
    book.write_text(
        "## T\n| Input | Connector | Formula | Output |\n|---|---|---|---|\n| Red bal | subscribe | | Say |\n"
    )
    done = rrp("run", book, "--out", tmp_path / "o", "--json")
    assert done.returncode == 1 and "Red ball" in done.stderr and not (tmp_path / "o").exists()
    assert json.loads(done.stdout.splitlines()[-1])["findings"][0]["code"] == "GRAPH001"


def test_a_name_as_the_participants_code_is_warned_of(ran):
    _, errors, out = ran
    assert "“Anna Smith” looks like a name. Recordings should have a code, such as P-07." in errors
    assert json.loads((out / "trace.jsonl").read_text().splitlines()[0])["participant"] == "Anna Smith"


def test_a_run_never_overwrites_another(ran):
    _, _, out = ran
    before = {p.name: p.read_bytes() for p in out.iterdir()}
    assert rrp("run", BOOK, "--fast", "--for", "1s", "--out", out).returncode == 2
    assert {p.name: p.read_bytes() for p in out.iterdir()} == before


@pytest.mark.parametrize("wrong", ["soon", "0", "-3s"])
def test_a_wrong_duration_says_how_to_write_one(wrong):
    done = rrp("run", BOOK, f"--for={wrong}")
    assert done.returncode == 2 and "20s" in done.stderr


def test_check_json_and_its_exit_codes(tmp_path):
    fine = started("check", BOOK, "--json")
    assert fine.returncode == 0 and json.loads(fine.stdout)["findings"] == [] and json.loads(fine.stdout)["complete"]
    assert fine.stdout == rrp("check", BOOK, "--json").stdout
    gone = rrp("check", tmp_path / "gone.xlsx", "--json")
    assert gone.returncode == 2 and json.loads(gone.stdout)["findings"][0]["code"] == "FILE001"
    (tmp_path / "wrong.md").write_text(
        "## T\n| Input | Connector | Formula | Output |\n|---|---|---|---|\n| Red ball | map | redBall.q | X |\n"
    )
    wrong = rrp("check", tmp_path / "wrong.md", "--json")
    found = json.loads(wrong.stdout)["findings"]
    assert wrong.returncode == 1 and not json.loads(wrong.stdout)["complete"]
    said = "Some checks need the errors fixed first, so more problems may appear."
    assert rrp("check", tmp_path / "wrong.md").stdout.splitlines()[-1] == f"1 error, 1 warning. {said}"
    entries = {"code", "severity", "sheet", "cell", "message", "remedy", "span", "fixes", "details"}
    assert [set(f) for f in found] == [entries] * len(found)
    assert (found[0]["code"], found[0]["sheet"], found[0]["cell"]) == ("FORM007", "T", "C2")


def test_new_makes_a_workbook_that_checks_draws_and_explains(tmp_path):
    book = tmp_path / "my first.xlsx"
    assert rrp("new", book).returncode == 0
    assert rrp("new", book).returncode == 2  # never overwritten
    assert rrp("check", book).stdout.strip() == "Everything is in order."
    for suffix, begins in ((".svg", b"<"), (".pdf", b"%PDF"), (".png", b"\x89PNG")):
        target = tmp_path / f"drawn{suffix}"
        assert rrp("diagram", book, "-o", target).returncode == 0
        assert target.read_bytes().startswith(begins)
    assert "red ball" in rrp("explain", book).stdout


def test_new_from_a_workbook_that_comes_along(tmp_path):
    assert rrp("new", tmp_path / "g.xlsx", "--template", "greeter").returncode == 0
    assert rrp("check", tmp_path / "g.xlsx").returncode == 0
    assert "greeter" in rrp("new", tmp_path / "h.xlsx", "--template", "greter").stderr


@pytest.mark.parametrize(
    "topic", ["connectors", "functions", "devices", "scene", "FORM007", "Red ball", "clamp", "sample"]
)
def test_help_on(topic):
    done = CliRunner().invoke(group, ["help", topic])
    assert done.exit_code == 0 and len(done.stdout) > 40 and "{" not in done.stdout


def test_help_on_what_there_is_not_proposes_the_nearest():
    assert "Did you mean clamp" in rrp("help", "clmp").stderr.replace("CLAMP", "clamp")


def test_a_wrong_workbook_is_drawn_and_explained_with_exit_code_1(tmp_path):
    book = tmp_path / "b.md"
    book.write_text("## T\n| Input | Connector | Formula | Output |\n|---|---|---|---|\n| Red ball | sample | fast | X |\n"
                    "| X | subscribe | | Print |\n")  # fmt: skip
    assert rrp("diagram", book, "-o", tmp_path / "d.svg").returncode == 1 and (tmp_path / "d.svg").is_file()
    assert rrp("explain", book).returncode == 1
    assert rrp("explain", BOOK, "-o", tmp_path / "gone" / "x.txt").returncode == 2


def test_diagrams_do_without_a_system_graphviz(tmp_path):
    env = {**ENV, "PATH": str(tmp_path)}
    done = rrp("diagram", BOOK, "-o", tmp_path / "d.svg", env=env)
    assert done.returncode == 0 and (tmp_path / "d.svg").stat().st_size > 1000


@pytest.mark.parametrize("command", ["new", "check", "diagram", "explain", "run", "serve", "help"])
def test_every_command_has_help(command):
    done = CliRunner().invoke(group, [command, "--help"])
    assert done.exit_code == 0 and len(done.stdout) > 200


def test_an_unknown_command_proposes_the_nearest():
    done = rrp("chek", BOOK)
    assert done.returncode == 2 and "check" in done.stderr


def test_a_full_disk_under_the_output_is_told():
    with open("/dev/full", "w") as full:
        done = forked.run([*COMMAND, "help", "devices"], env=ENV, stdout=full, stderr=subprocess.PIPE, text=True,
                          timeout=300)  # fmt: skip
    assert done.returncode == 2 and "Traceback" not in done.stderr and "full" in done.stderr


def test_a_device_is_never_replaced_by_a_file():
    done = rrp("explain", BOOK, "-o", "/dev/null")
    assert done.returncode == 2 and Path("/dev/null").is_char_device()


@pytest.mark.slow
def test_a_file_name_that_is_no_proper_text_and_what_a_stranger_writes_cannot_steer_the_terminal(tmp_path):
    book = os.fsencode(tmp_path) + b"/n\xf6.xlsx"
    rows = [["Head yaw", "map", '"a" + MID("\u202eb", 1, 2)', "X"], ["X", "subscribe", "", "Print"]]
    made = make_workbook({"T": [["Input", "Connector", "Formula", "Output"], *rows]}, tmp_path / "b.xlsx")
    Path(os.fsdecode(book)).write_bytes(made.read_bytes())
    done = forked.run([*COMMAND, "run", book, "--fast", "--for", "0.2s", "--out", str(tmp_path / "o")], env=ENV,
                      capture_output=True, timeout=300)  # fmt: skip
    assert done.returncode == 0 and b"Traceback" not in done.stderr
    assert "\u202e".encode() not in done.stdout
    assert b"\x1b" not in done.stdout
    assert "Print ← “a\ufffdb”".encode() in done.stdout
    assert json.loads((tmp_path / "o" / "trace.jsonl").read_text().splitlines()[0])["type"] == "header"
