"""The loop of a run: world and engine in lockstep, paced to real time or as fast as the machine can."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.model.exchange import Happening
from rrp_sheets.runtime.engine import Engine
from rrp_sheets.runtime.ports import Arrivals, World
from rrp_sheets.runtime.trace import TraceWriter


@dataclass
class Summary:
    """What a run amounted to.

    Attributes:
        events: how many values each stream had, by its name in the trace.
        errors: how often each row's formula failed.
        commands: how many commands each actuator stream was given.
        simulated: seconds of the run's clock.
        wall: seconds that passed meanwhile.
        ended: `time` (its time was over), `stopped` (by the user), `end run` (by a row), `broken`.
        ended_by: the row that ended the run, or was being worked out when it broke off; empty where there is none.
    """

    events: dict[str, int] = field(default_factory=dict)
    errors: dict[str, int] = field(default_factory=dict)
    commands: dict[str, int] = field(default_factory=dict)
    simulated: float = 0.0
    wall: float = 0.0
    ended: str = "time"
    ended_by: str = ""

    def as_dict(self, *, wall: bool) -> dict[str, Any]:
        """As JSON; without the wall clock for the trace, whose bytes must not depend on it."""
        entry: dict[str, Any] = {
            "ended": self.ended, **({"by": self.ended_by} if self.ended_by else {}),
            "simulated_seconds": self.simulated, "events": self.events, "errors": self.errors,
            "actuator_commands": self.commands,
        }  # fmt: skip
        return {**entry, "wall_seconds": round(self.wall, 3)} if wall else entry


def run_loop(
    engine: Engine,
    world: World,
    arrivals: Arrivals,
    until_us: int,
    *,
    trace: TraceWriter | None = None,
    paced: bool = False,
    stopped: Callable[[], bool] = lambda: False,
    tell: Callable[[int, Happening], None] = lambda us, happening: None,
    tick: Callable[[int], None] = lambda us: None,
) -> tuple[int, str]:
    """Run frames until the time is over, a row ends the run or the user stops; the reached time (µs) and how it ended.

    Args:
        engine: with its rows wired.
        world: started and stopped by the caller.
        arrivals: what its start gave: those of time 0.
        until_us: the last frame is the first at or after this time.
        trace: flushed once per frame.
        paced: wait so that the run is not faster than real time.
        stopped: asked before each frame.
        tell: called with each happening.
        tick: called after each frame.
    """
    rate = engine.plan.checked.run.frame_rate
    frame = now = 0
    began = time.monotonic()
    while True:
        commands = engine.settle(now, arrivals.events)
        for happening in (*arrivals.happenings, *engine.take_happenings()):
            if trace is not None:
                trace.happening(now, happening)
            tell(now, happening)
        if trace is not None:
            trace.flush()
        tick(now)
        if engine.ended_by:
            return now, "end run"
        if stopped():
            return now, "stopped"
        if now >= until_us:
            return now, "time"
        frame += 1
        now = frame * 1_000_000 // rate
        if paced:
            time.sleep(max(0.0, began + now / 1e6 - time.monotonic()))
        arrivals = world.advance(now, commands)
