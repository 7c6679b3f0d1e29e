"""The simulator's process: how it ends, and what it says when it cannot be."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from busy import within

pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.errors import MissingPart, RunBroken
from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.robots import load_robot

ROBOT = load_robot()
RED = DeviceUse("redball", "Red ball", "RedBall", {"rate": 10})


@pytest.mark.slow
@pytest.mark.usefixtures("process_start")
def test_a_dead_simulator_is_told_at_once() -> None:
    world = SimulatedWorld(ROBOT, (RED,), (), ())
    world.start()
    assert world.pid is not None
    os.kill(world.pid, signal.SIGKILL)
    with within(5):
        with pytest.raises(RunBroken, match="simulator ended unexpectedly"):
            world.advance(10_000_000, ())
        world.stop()  # has nothing left to do, and does not complain a second time
    assert world.pid is None


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waiting for a process that is not a child needs Linux")
def test_the_simulator_ends_with_its_program(tmp_path: Path) -> None:
    program = tmp_path / "program.py"  # has no guard for __main__, and dies without stopping anything
    program.write_text(
        "import os\nfrom rrp_sheets.robots import load_robot\n"
        "from rrp_sheets.drivers.simulated import SimulatedWorld\n"
        "w = SimulatedWorld(load_robot(), (), ())\nw.start()\nprint(w.pid, flush=True)\nos._exit(1)\n"
    )
    done = subprocess.run(
        [sys.executable, str(program)], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parent.parent)},
    )  # fmt: skip
    try:
        handle = os.pidfd_open(int(done.stdout))
    except ProcessLookupError:
        return  # it has ended already
    with os.fdopen(handle, "rb"):
        ended, _, _ = select.select([handle], [], [], 300)
    assert ended, "the simulator still runs"


def test_ctrl_c_stops_the_robot_properly(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        "from pathlib import Path\nfrom rrp_sheets.robots import load_robot\n"
        "from rrp_sheets.drivers.simulated import SimulatedWorld\n"
        "w = SimulatedWorld(load_robot(), (), (), (), out=Path('run'), film=True)\nw.start()\n"
        "try:\n    for frame in range(1, 10**6):\n        w.advance(frame * 100_000, ())\n"
        "        if frame == 3:\n            print('running', flush=True)\n"
        "except KeyboardInterrupt:\n    w.stop()\n    print('stopped', w.pid)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent.parent)}
    running = subprocess.Popen(
        [sys.executable, str(program)], stdout=subprocess.PIPE, text=True, env=environment, cwd=tmp_path
    )
    assert running.stdout is not None
    assert running.stdout.readline() == "running\n"
    with within(15):
        running.send_signal(signal.SIGINT)  # in the middle of an advance, as it does nothing else
        out, _ = running.communicate(timeout=300)
    assert out == "stopped None\n"
    assert (tmp_path / "run" / "film.gif").is_file()


def test_without_the_simulator_it_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rrp_sheets.sim.process.NEEDED", {"no_such_module": "pybullet"})
    with pytest.raises(MissingPart, match=r"needs pybullet.*work without it"):
        SimulatedWorld(ROBOT, (), (), ())


def test_the_physics_library_writes_nothing_to_the_standard_output() -> None:
    program = (
        "from rrp_sheets.robots import load_robot\nfrom rrp_sheets.sim.process import Spec\n"
        "from rrp_sheets.sim.world import SimWorld\nSimWorld(Spec(load_robot())).close()\nprint('done')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parent.parent)},
    )  # fmt: skip
    assert done.stdout == "done\n"
