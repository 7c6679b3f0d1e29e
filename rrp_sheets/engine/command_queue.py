"""What people want of a run while it goes on: any thread asks, and the loop does it between two frames."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class OperatorCommand:
    """Something that somebody wants of a run.

    Attributes:
        kind: a name that `CommandHandler` knows.
        by: who wants it.
        what: plain data, by name.
    """

    kind: str
    by: str = ""
    what: Mapping[str, Any] = field(default_factory=dict)


class CommandQueue:
    """Wishes on their way to the loop. Stop overtakes all of them; of two places for one thing only the newer counts.

    Attributes:
        stopped: whether the run is to stop now.
        stopped_by: who wanted that, where it is known.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._wishes: list[OperatorCommand] = []
        self.stopped = False
        self.stopped_by = ""

    def stop(self, by: str = "") -> None:
        """Let the run stop, whatever it is doing."""
        with self._changed:
            if not self.stopped:
                self.stopped, self.stopped_by = True, by
            self._changed.notify_all()

    def ask(self, wish: OperatorCommand) -> None:
        """Let a wish be fulfilled between this frame and the next."""
        with self._changed:
            last = self._wishes[-1] if self._wishes else None
            if wish.kind == "put" and last is not None and _same_thing(last, wish):
                self._wishes[-1] = wish
            else:
                self._wishes.append(wish)
            self._changed.notify_all()

    def take(self) -> list[OperatorCommand]:
        """The wishes that have come, in their order; each is given out once."""
        if not self._wishes:  # asked in every frame
            return []
        with self._changed:
            wishes, self._wishes = self._wishes, []
            return wishes

    def wait(self, seconds: float) -> None:
        """Wait until somebody wants something, at most so long."""
        with self._changed:
            if not self._wishes and not self.stopped:
                self._changed.wait(seconds)


def _same_thing(one: OperatorCommand, other: OperatorCommand) -> bool:
    return one.kind == other.kind and one.what.get("thing") == other.what.get("thing") and one.by == other.by
