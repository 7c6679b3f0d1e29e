"""The loop of a run: world and engine in lockstep, paced to real time or as fast as the machine can."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence

from rrp_sheets.engine.command_handler import CommandHandler
from rrp_sheets.engine.command_queue import CommandQueue
from rrp_sheets.engine.engine import Engine
from rrp_sheets.engine.ports import World
from rrp_sheets.engine.realtime import FramePacer, SnapshotThrottle
from rrp_sheets.engine.run_events import FrameEnd, NoticeEvent, PictureEvent, RunObserver, StandingEvent, StateEvent
from rrp_sheets.model.exchange import Arrivals, Notice, SceneAction

STANDING = 0.25  # s between two looks while the run is paused: whether its watcher has gone
LONGEST_WAIT = 1.0  # s between two signs of life, however slow a run is


class FrameRunner:
    """A run in frames, one after the other, and what people do between them.

    It starts the world and then wires the engine; a run that is paced waits, so that it is not faster than real time.
    """

    def __init__(
        self, world: World, wire: Callable[[], Engine], *, paced: bool = False, control: CommandQueue | None = None
    ) -> None:
        self._world = world
        self._arrivals = world.start()
        self.engine = wire()
        self._control = control or CommandQueue()
        self._paced = paced
        self._showing = SnapshotThrottle()
        self._things: Collection[str] | None = None  # what a display has last seen in the world
        self._pace = FramePacer(0.0)

    def go(self, until_us: int, observer: RunObserver) -> tuple[int, str]:
        """Run frames until the time is over, a row ends the run or the user stops; the time (µs) and how it ended."""
        engine, world, control = self.engine, self._world, self._control
        arrivals = self._arrivals
        handler = CommandHandler(engine, self, observer, control)
        rate = engine.plan.checked.run.frame_rate
        frame = now = 0
        self._pace = FramePacer(1.0 if self._paced else 0.0)
        while True:
            commands = engine.settle(now, arrivals.events)
            if cued := engine.triggers.take():
                world.act(cued)
            for happening in (*arrivals.notices, *engine.take_happenings()):
                observer.handle(NoticeEvent(now, happening))
            observer.handle(FrameEnd(now))
            if engine.ended_by:
                return now, "end run"
            if control.stopped or observer.stopped():
                return now, "stopped"
            if now >= until_us:
                return now, "time"
            frame += 1
            due = frame * 1_000_000 // rate
            if not self._wait(now, due, handler, observer):
                return now, "stopped"
            now = due
            arrivals = world.advance(now, commands)
            if control.stopped:  # meanwhile: the robot rests already, and the rows of this frame may take long
                for happening in arrivals.notices:
                    observer.handle(NoticeEvent(now, happening))
                return now, "stopped"

    def stop(self) -> list[Notice]:
        """Stop the world; returns what happened meanwhile."""
        self.engine.close()
        left = self._world.stop() or Arrivals()
        self.engine.finish(left.events)
        return list(left.notices)

    def _wait(self, now: int, due: int, handler: CommandHandler, observer: RunObserver) -> bool:
        """Do what people want until the next frame is due; False when the run is to stop."""
        control, pace = self._control, self._pace
        self._show(now, observer)
        while True:
            if handler.between(now):
                self._show(now, observer)
            if control.stopped:
                return False
            if not pace.stands and (left := pace.left(due)) <= 0:
                pace.went()
                return True
            control.wait(STANDING if pace.stands else min(left, LONGEST_WAIT))
            if pace.stands or left > LONGEST_WAIT:
                if observer.stopped():
                    return False
                observer.handle(StandingEvent(now))
                if self._showing.wanted:
                    self._world.show(False)  # whether it is still there: nothing else asks it anything

    def _show(self, now: int, observer: RunObserver) -> None:
        picture = self._showing.due()
        if picture is not None:
            began = time.monotonic()
            shown = self._world.show(picture)
            self._things = shown.state.things
            observer.handle(StateEvent(now, shown.state))
            if shown.picture:
                observer.handle(PictureEvent(now, shown.picture))
            self._showing.cost(time.monotonic() - began)

    # ---- the run controller of the command handler
    def pause(self, us: int) -> bool:
        """Let the frames stand still; False when they do already."""
        if self._pace.paused:
            return False
        self._pace.pause()
        self._showing.again()
        return True

    def resume(self, us: int) -> bool:
        """Let the frames go on; False when they do already."""
        if not self._pace.paused:
            return False
        self._pace.resume(us)
        return True

    def step(self, us: int) -> None:
        """Let one frame go on."""
        self._pace.step()
        self._showing.again()

    def speed(self, factor: float, us: int) -> None:
        """Be so fast from now on; 0 is as fast as the machine can."""
        self._pace.speed(factor, us)

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen in the world."""
        self._world.act(actions)
        if self._pace.paused:
            self._showing.again()

    def things(self) -> Collection[str] | None:
        """Return the things in the world now."""
        if self._things is None or not self._showing.wanted:
            self._things = self._world.show(False).state.things
        return self._things

    def watch(self, *, wanted: bool | None = None, look: bool | None = None) -> None:
        """Set whether a display wants the world, and pictures; None changes nothing."""
        self._showing.want(wanted, look)
