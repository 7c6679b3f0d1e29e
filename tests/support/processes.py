"""Processes of the program, as Linux shows them."""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from rrp_sheets.drivers.simulated import SimulatedWorld


def descendants(pid: int) -> Iterator[int]:
    """The processes that a process has started, and those that these have started."""
    with suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in map(int, (task / "children").read_text().split()):
                yield child
                yield from descendants(child)


def workers(pid: int, module: str) -> set[int]:
    """The worker processes below a process whose task is in a module; not their guards, which are called so too."""
    parents = {}
    for each in descendants(pid):
        with suppress(OSError):  # it may have ended meanwhile
            if Path(f"/proc/{each}/comm").read_text().strip() == module:
                parents[each] = int(Path(f"/proc/{each}/stat").read_text().rsplit(")", 1)[1].split()[1])
    return {each for each, parent in parents.items() if parent not in parents}


def killed(pid: int) -> None:
    """Kill a process, and wait until it is gone."""
    end = os.pidfd_open(pid)
    os.kill(pid, signal.SIGKILL)
    assert select.select([end], [], [], 300)[0]
    os.close(end)


def end_simulator(world: SimulatedWorld) -> None:
    """End the simulator of a world without its robot's rest, which would take longer than most tests."""
    if world.pid is not None:
        os.kill(world.pid, signal.SIGKILL)
    world.kill()
