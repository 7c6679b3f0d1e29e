"""Interfaces between the loop of a run and its observers, whichever the engine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rrp_sheets.model.exchange import Notice, OperatorAction, WorldSnapshot

if TYPE_CHECKING:
    from rrp_sheets.engine.engine import Engine


class RunObserver:
    """Observer of a run's loop, which the loop also asks whether to stop; subclass it."""

    def happening(self, us: int, happening: Notice) -> None:
        """Something besides the events."""

    def frame(self, us: int) -> None:
        """A frame is over, or some 30 ms of an event loop."""

    def acted(self, us: int, act: OperatorAction) -> None:
        """Somebody did something, after the frame of `us`."""

    def refused(self, kind: str, message: str, remedy: str) -> None:
        """Report that a command (`send`, `apply`, …) cannot be carried out."""

    def paused(self, us: int, is_paused: bool) -> None:
        """The run stands still, or goes on."""

    def standing(self, us: int) -> None:
        """Nothing goes on: the run is paused, or very slow. Told now and then, as a sign of life."""

    def shown(self, us: int, shown: WorldSnapshot) -> None:
        """The world, for a display."""

    def stopped(self) -> bool:
        """Return whether the run should stop now; asked after each frame."""
        return False


class Runner(Protocol):
    """A run that has been started, whichever its engine."""

    @property
    def engine(self) -> Engine:
        """Give access to the rows that this run works out."""
        ...

    def go(self, until_us: int, observer: RunObserver) -> tuple[int, str]:
        """Run until the time is over, a row ends the run or the user stops; the time (µs) and how it ended.

        Raises:
            RunBroken: when a device has broken.
        """
        ...

    def stop(self) -> list[Notice]:
        """Bring everything to its rest, in bounded time; what could not be stopped is reported.

        Raises:
            RunBroken: when something broke while stopping.
        """
        ...
