"""Pacing of frames, and of snapshots for displays: by the wall clock, outside of the run's results."""

from __future__ import annotations

import time
from collections.abc import Callable

Now = Callable[[], float]

STATE_EVERY = 1 / 12  # s of wall time, between two states for a display
PICTURE_EVERY = 1 / 8  # s, between two pictures
SHARE = 12.0  # a display may cost one part in so many of the time


class FramePacer:
    """Due times of frames. Time that was paused, and a speed that changes, are not caught up with.

    Args:
        factor: 1 real time, 2 twice as fast; 0 as fast as the machine can.
        now: the wall clock, in seconds.

    Attributes:
        paused: whether no frame is due until it goes on.
    """

    def __init__(self, factor: float, now: Now = time.monotonic) -> None:
        self._now = now
        self._factor = factor
        self._steps = 0
        self._anchor = (now(), 0)  # a wall time, and the run's time (µs) of then
        self.paused = False

    @property
    def stands(self) -> bool:
        """True while the run stands still: paused, and no single step is wanted."""
        return self.paused and not self._steps

    def left(self, due_us: int) -> float:
        """Return the seconds that are left until the frame of `due_us`; not more than 0 when it is due."""
        if self._steps or not self._factor:
            return 0.0
        wall, us = self._anchor
        return wall + (due_us - us) / 1e6 / self._factor - self._now()

    def went(self) -> None:
        """A frame goes on."""
        if self.paused and self._steps:
            self._steps -= 1

    def pause(self) -> None:
        """Stand still."""
        self.paused, self._steps = True, 0

    def resume(self, us: int) -> None:
        """Go on from where the run stands (µs)."""
        self.paused, self._steps = False, 0
        self._anchor = (self._now(), us)

    def step(self) -> None:
        """Go on for one frame."""
        self._steps += 1

    def speed(self, factor: float, us: int) -> None:
        """Be so fast from where the run stands (µs)."""
        self._factor = factor
        self._anchor = (self._now(), us)


class SnapshotThrottle:
    """Due times of snapshots for a display: of the world's state, and of what the robot sees.

    Attributes:
        wanted: whether anybody looks at all.
        look: whether they want pictures.
    """

    def __init__(self, now: Now = time.monotonic) -> None:
        self._now = now
        self._state_at = self._picture_at = now()
        self.wanted = False
        self.look = False

    def want(self, wanted: bool | None, look: bool | None) -> None:
        """Say what is wanted from now on; None leaves it as it is."""
        self.wanted = self.wanted if wanted is None else wanted
        self.look = self.look if look is None else look
        self.again()

    def due(self) -> bool | None:
        """Return None when no snapshot is due, else whether it should have a picture."""
        now = self._now()
        if not self.wanted or now < self._state_at:
            return None
        picture = self.look and now >= self._picture_at
        self._state_at = max(self._state_at + STATE_EVERY, now)
        if picture:
            self._picture_at = max(self._picture_at + PICTURE_EVERY, now)
        return picture

    def cost(self, seconds: float) -> None:
        """Showing took so long: on a slow machine it comes less often."""
        self._state_at = max(self._state_at, self._now() + seconds * SHARE)

    def again(self) -> None:
        """Show it as soon as can be: something was changed by hand."""
        self._state_at = self._picture_at = self._now()
