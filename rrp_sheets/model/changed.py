"""Changes in a behaviour, row by row and stream by stream, as they are drawn and set in tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SAME, ADDED, REMOVED, CHANGED = "", "+", "−", "~"  # the signs, as they are shown
SIGN_NAMES = {
    ADDED: ("added", "new"), REMOVED: ("removed", "gone"), CHANGED: ("changed", "changed"), SAME: ("kept", "as before"),
}  # fmt: skip
"""The kind of change and the adjective for what changed, by sign."""
MarkedText = tuple[bool, str]  # a part of a text: whether it is marked as gone or new, and its words


@dataclass(frozen=True, slots=True)
class ComparableText:
    """A text before and after; equal when it means the same."""

    before: str = ""
    after: str = ""
    # what stayed (`same`), went (`gone`) and came (`new`); empty when the whole of it changed
    pieces: tuple[tuple[str, str], ...] = ()

    @property
    def changed(self) -> bool:
        """True when the texts before and after differ."""
        return self.before != self.after

    def was(self) -> tuple[MarkedText, ...]:
        """The text before, with what went marked.

        >>> ComparableText("x < 20", "x < 15", (("same", "x < "), ("gone", "20"), ("new", "15"))).was()
        ((False, 'x < '), (True, '20'))
        """
        return self._side("gone", self.before)

    def now(self) -> tuple[MarkedText, ...]:
        """The text after, with what came marked."""
        return self._side("new", self.after)

    def _side(self, kind: str, whole: str) -> tuple[MarkedText, ...]:
        if not self.changed or not any(k == "same" for k, _ in self.pieces):
            return ((self.changed, whole),) if whole else ()
        return tuple((k == kind, text) for k, text in self.pieces if k in ("same", kind) and text)


def same(text: str) -> ComparableText:
    """A text that did not change."""
    return ComparableText(text, text)


@dataclass(frozen=True, slots=True)
class Link:
    """A stream that a row reads or writes; `sign` tells whether it does so since, or no more."""

    stream: str
    sign: str = SAME


@dataclass(frozen=True, slots=True)
class ChangedStream:
    """A stream of either workbook."""

    id: str  # the same for both where it is the same stream
    kind: str  # `sensor`, `stream`, `actuator`, `anonymous` or `done`
    sign: str  # what became of it
    name: ComparableText  # as people know it
    # of its device, those that changed, each with the setting's name
    settings: tuple[tuple[str, ComparableText], ...] = ()


@dataclass(frozen=True, slots=True)
class ChangedRow:
    """A row of either workbook."""

    sign: str  # what became of it
    number: int  # its row now; of a removed one the row where it stood
    was: int  # its row before, 0 when it is new
    inputs: ComparableText
    connector: ComparableText
    formula: ComparableText
    output: ComparableText
    # takes, gives: the streams that it reads and writes, or did
    takes: tuple[Link, ...]
    gives: tuple[Link, ...]
    remarks: tuple[str, ...] = ()  # what else there is to know: switched off, moved, a helper that changed
    off: bool = False  # whether it is switched off

    @property
    def id(self) -> str:
        """Unique among the rows of both workbooks: `r4`, or `x4` for the removed row 4."""
        return f"{'x' if self.sign == REMOVED else 'r'}{self.number}"


@dataclass(frozen=True, slots=True)
class ChangedBehaviour:
    """A behaviour of both workbooks, or of one."""

    name: str
    sign: str
    rows: tuple[ChangedRow, ...]  # all of them, in their order; removed ones where they stood
    streams: Mapping[str, ChangedStream]  # by id
