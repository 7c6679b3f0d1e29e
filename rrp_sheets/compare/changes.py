"""Result of a comparison: a list of changes, each of which does or does not alter the behaviour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rrp_sheets.compare.tokens import FormulaPiece


@dataclass(frozen=True, slots=True)
class Change:
    """One difference.

    Attributes:
        kind: `added`, `removed`, `renamed`, `moved`, `changed`, `on`, `off`, `notes`, or `written` (the same, in
            another spelling or at another place).
        part: `behaviour`, `row`, `stream`, `device`, `helper`, `scene`, `gesture`, `protocol`, `test`, `table`,
            `sheet`.
        sheet: the sheet's name, that of the second workbook where both have it.
        name: the stream, helper or field in question; empty for rows.
        rows: its row in the first and in the second workbook, 0 where there is none.
        field: of a row, the cell that changed: `connector`, `inputs`, `formula`, `output`, `priority`.
        what: the column, setting or field that changed, in words.
        before: what the first workbook says there.
        after: what the second says.
        effect: True when the change alters the behaviour.
        note: why it has no effect, or what the effect is.
        pieces: of a formula, the kept, removed and added parts.
    """

    kind: str
    part: str
    sheet: str = ""
    name: str = ""
    rows: tuple[int, int] = (0, 0)
    what: str = ""
    before: str = ""
    after: str = ""
    effect: bool = True
    note: str = ""
    pieces: tuple[FormulaPiece, ...] = ()
    field: str = ""

    def harmless(self, note: str) -> Change:
        """Return the change as one without effect, with the reason as its note if it has none."""
        return replace(self, effect=False, note=self.note or note) if self.effect else self


@dataclass(frozen=True, slots=True)
class ComparedWorkbook:
    """One of the two workbooks, as the comparison identifies it."""

    source: str
    digest: str
    format: str
    errors: int


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences between two workbooks, the older one first.

    The changes of the behaviours come before the others, sheet by sheet.
    """

    first: ComparedWorkbook
    second: ComparedWorkbook
    changes: tuple[Change, ...]

    @property
    def same(self) -> bool:
        """True if both workbooks have the same behaviour."""
        return not any(c.effect for c in self.changes)

    @property
    def effects(self) -> Sequence[Change]:
        """Changes that alter the behaviour."""
        return [c for c in self.changes if c.effect]

    @property
    def others(self) -> Sequence[Change]:
        """Changes that do not alter the behaviour."""
        return [c for c in self.changes if not c.effect]
