"""Speed and memory of the simulated robot on one core, for the benchmarks."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.robots import load_robot

SECONDS, RATE = 20, 30


@dataclass(frozen=True)
class Went:
    """Measures of a world's run, the start and the stop not counted.

    Attributes:
        ratio: simulated seconds per second of the processor, both processes together: on one idle core that is time.
        wall: simulated seconds per second of the clock, with whatever else the machine did.
        megabytes: the most memory of the simulator.
        events: how many sensor values came.
    """

    ratio: float
    wall: float
    megabytes: float
    events: int


@contextmanager
def one_core() -> Iterator[str]:
    """Pin this process, and thereby the simulator's, to one core; says what was done."""
    if not hasattr(os, "sched_setaffinity"):  # a Mac
        yield "not pinned"
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield "one core"
    finally:
        os.sched_setaffinity(0, before)


def go(sensor: DeviceUse, mode: str, scene: tuple[SceneAction, ...], film: bool) -> Went:
    """Let the robot follow what a sensor sees."""
    tracker = DeviceUse("tracker", "Tracker", "Tracker", {"mode": mode, "effector": "None"})
    with TemporaryDirectory() as folder:
        world = SimulatedWorld(load_robot(), (sensor,), (tracker,), scene, out=Path(folder), film=film, record=film)
        count = 0
        try:
            arrivals = world.start()
            before, used = time.perf_counter(), _used(world.pid)
            for frame in range(1, SECONDS * RATE + 1):
                orders = [Command("tracker", True, "Bench!1", (sensor.stream,)) for _ in arrivals.events]
                arrivals = world.advance(frame * 1_000_000 // RATE, orders)
                count += len(arrivals.events)
            passed, worked = time.perf_counter() - before, _used(world.pid) - used
            status = Path(f"/proc/{world.pid}/status")
            peak = status.read_text() if status.is_file() else ""
        finally:
            world.stop()
    kilobytes = next((line.split()[1] for line in peak.splitlines() if line.startswith("VmHWM")), "0")
    return Went(SECONDS / (worked or passed), SECONDS / passed, int(kilobytes) / 1024, count)


def _used(pid: int | None) -> float:
    """Seconds of the processor that this process and that one have used; 0 where that is not told."""
    stat = Path(f"/proc/{pid}/stat")
    if not stat.is_file():
        return 0.0
    fields = stat.read_text().rpartition(")")[2].split()
    return time.process_time() + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
