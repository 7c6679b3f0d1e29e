"""The loop of a run: world and engine in lockstep, paced to real time or as fast as the machine can."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from rrp_sheets.model.exchange import Happening
from rrp_sheets.runtime.engine import Engine
from rrp_sheets.runtime.ports import Arrivals, World


class Hooks:
    """What a loop tells and asks as it goes; subclass it."""

    def happening(self, us: int, happening: Happening) -> None:
        """Something besides the events."""

    def frame(self, us: int) -> None:
        """A frame is over, or some 30 ms of an event loop."""

    def stopped(self) -> bool:
        """Whether the run should stop now; asked after each frame."""
        return False


class Course(Protocol):
    """A run that has been started, whichever its engine."""

    @property
    def engine(self) -> Engine:
        """The engine."""
        ...

    def go(self, until_us: int, hooks: Hooks) -> tuple[int, str]:
        """Run until the time is over, a row ends the run or the user stops; the time (µs) and how it ended.

        Raises:
            RunBroken: when a device has broken.
        """
        ...

    def stop(self) -> list[Happening]:
        """Bring everything to its rest, in bounded time; what could not be stopped is told.

        Raises:
            RunBroken: when something broke while stopping.
        """
        ...


class FrameCourse:
    """A run in frames.

    Args:
        world: started here.
        wire: makes the engine.
        paced: wait so that the run is not faster than real time.
    """

    def __init__(self, world: World, wire: Callable[[], Engine], *, paced: bool) -> None:
        self._world = world
        self._arrivals = world.start()
        self._paced = paced
        self.engine = wire()

    def go(self, until_us: int, hooks: Hooks) -> tuple[int, str]:
        """Run frames."""
        return run_loop(self.engine, self._world, self._arrivals, until_us, hooks=hooks, paced=self._paced)

    def stop(self) -> list[Happening]:
        """Stop the world."""
        self.engine.close()
        self.engine.finish(self._world.stop() or ())
        return []


def run_loop(
    engine: Engine,
    world: World,
    arrivals: Arrivals,
    until_us: int,
    *,
    hooks: Hooks | None = None,
    paced: bool = False,
) -> tuple[int, str]:
    """Run frames until the time is over, a row ends the run or the user stops; the time (µs) and how it ended.

    Args:
        engine: with its rows wired.
        world: started and stopped by the caller.
        arrivals: what its start gave: those of time 0.
        until_us: the last frame is the first at or after this time.
        hooks: told and asked after each frame.
        paced: wait so that the run is not faster than real time.
    """
    hooks = hooks or Hooks()
    rate = engine.plan.checked.run.frame_rate
    frame = now = 0
    began = time.monotonic()
    while True:
        commands = engine.settle(now, arrivals.events)
        for happening in (*arrivals.happenings, *engine.take_happenings()):
            hooks.happening(now, happening)
        hooks.frame(now)
        if engine.ended_by:
            return now, "end run"
        if hooks.stopped():
            return now, "stopped"
        if now >= until_us:
            return now, "time"
        frame += 1
        now = frame * 1_000_000 // rate
        if paced:
            time.sleep(max(0.0, began + now / 1e6 - time.monotonic()))
        arrivals = world.advance(now, commands)
