"""Log of the run panel: the robot's commands and speech, failures, and actions of users."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from rrp_sheets.model.values import Value
from rrp_sheets.recording.timeline import Drag, dragged
from rrp_sheets.runs.run_data import QUIET_US, Commands
from rrp_sheets.texts import N_

KEPT = 400  # lines
_MOST_NEW = 60  # lines that are told at once; of more the last
_LONGEST = 300  # letters
_SETTLED = 0.7  # seconds of the wall clock after which a thing that was dragged stands where it was put
_AGAIN_US = 10_000_000  # the same trouble of the same row
Line = dict[str, Any]


class RunLog:
    """Log lines with a serial number each; the newest are kept.

    Args:
        rows: the ids of the rows by their refs.
        now: seconds of the wall clock.
    """

    def __init__(self, rows: Mapping[str, str], now: Callable[[], float] = time.monotonic) -> None:
        self._rows = rows
        self._now = now
        self._drag = Drag()
        self._dragged: Line | None = None
        self._moved: float | None = None  # when the thing was put to a place that no page was told of
        self._lines: deque[Line] = deque(maxlen=KEPT)
        self._count = 0
        self._told = 0
        self._last: dict[str, int] = {}
        self._commands = Commands()
        self._troubles: dict[tuple[str, str, str], int] = {}

    def add(
        self, us: int, kind: str, text: str, *, row: str = "", by: str = "", stream: str = "", sound: str = ""
    ) -> None:
        """Append a line; one for a user's action or the end also ends a drag."""
        if by or kind == "end":  # somebody does something else
            self._settle()
            self._drag.over()
        self._count += 1
        line = {"i": self._count, "t": us / 1e6, "row": row, "id": self._rows.get(row, ""), "kind": kind,
                "text": _short(text), "by": by, "stream": stream, "sound": sound}  # fmt: skip
        self._lines.append(line)

    def command(self, us: int, row: str, stream: str, value: Value, text: str) -> None:
        """Log a command for an actuator, unless it continues a series of similar commands."""
        if self._commands.tell(us, row, value, stream):
            self.add(us, "command", N_("stops") if value is None else text, row=row, stream=stream)

    def trouble(self, us: int, kind: str, text: str, row: str, stream: str = "") -> None:
        """Log a problem that may recur with every value; the same one is logged again only after a while."""
        key = (kind, row, text if not row else "")
        if us - self._troubles.get(key, -_AGAIN_US) >= _AGAIN_US:
            self._troubles[key] = us
            self.add(us, kind, text, row=row, stream=stream)
        if len(self._troubles) > KEPT:
            self._troubles = {k: at for k, at in self._troubles.items() if us - at < _AGAIN_US}

    def again(self, us: int, what: str, kind: str, text: str, by: str) -> None:
        """Log the first of many small steps of an action; the next one only after a pause."""
        last = self._last.get(what, -QUIET_US)
        self._last[what] = us
        if us - last >= QUIET_US:
            self.add(us, kind, text, by=by)

    def put(self, us: int, thing: str, text: str, by: str) -> None:
        """Log that a thing was put somewhere; a drag has one line, with the last place when it has ended."""
        line = self._dragged
        if self._drag.goes_on(us / 1e6, thing, by) and line is not None:
            line["text"], line["t"], self._moved = _short(dragged(thing, text)), us / 1e6, self._now()
            return
        self.add(us, "scene", text, by=by)
        self._dragged = self._lines[-1]
        self._drag.goes_on(us / 1e6, thing, by)

    def _settle(self) -> None:
        """Replace the line of a drag, if it was sent already, by one with the last place."""
        line, moved = self._dragged, self._moved
        self._moved = None
        if line is None or moved is None or line["i"] > self._told or line not in self._lines:
            return
        self._lines.remove(line)
        self._count += 1
        self._dragged = {**line, "i": self._count, "instead": line["i"]}
        self._lines.append(self._dragged)

    def news(self) -> list[Line]:
        """Return the lines added since the last call."""
        if self._moved is not None and self._now() - self._moved > _SETTLED:
            self._settle()
        fresh = [line for line in self._lines if line["i"] > self._told][-_MOST_NEW:]
        self._told = self._count
        return fresh

    def all(self) -> list[Line]:
        """Return the kept lines that were sent already."""
        return [line for line in self._lines if line["i"] <= self._told]


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST else text[:_LONGEST]
