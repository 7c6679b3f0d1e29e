"""Comparing two workbooks by what they mean.

Two workbooks have the *same behaviour* when their rows resolve to the same graph (the same connectors, formulas and
devices with the same settings, joined in the same way), with the same priorities, helpers, tables, gestures and scene,
and are run in the same way; and when of two rows that drive one part of the robot with one priority the same comes
last. Names of streams, helpers and sheets, the order of rows and sheets otherwise, spelling, notes, tests, fields of
the Protocol that are for people, rows that are switched off, and devices and helpers that nothing uses make no other
behaviour. They are told all the same.
"""

from __future__ import annotations

from rrp_sheets.checks import Checked
from rrp_sheets.compare.changes import Change, Comparison, Version
from rrp_sheets.compare.declared import device_changes, helper_changes
from rrp_sheets.compare.detail import detail
from rrp_sheets.compare.lists import gesture_changes, scene_changes, table_changes, test_changes
from rrp_sheets.compare.match import Match, match
from rrp_sheets.compare.own import sheet_changes
from rrp_sheets.compare.protocol import protocol_changes
from rrp_sheets.compare.rows import row_changes
from rrp_sheets.compare.side import Side
from rrp_sheets.model.changed import ChangedBehaviour
from rrp_sheets.workbook import Reading


def compare(first: tuple[Reading, Checked], second: tuple[Reading, Checked]) -> Comparison:
    """What is different between two workbooks, each read and checked; either may have errors."""
    return _compare(Side(*first), Side(*second))[0]


def compare_in_detail(
    first: tuple[Reading, Checked], second: tuple[Reading, Checked]
) -> tuple[Comparison, tuple[ChangedBehaviour, ...]]:
    """The comparison, and the behaviours that changed as they are drawn."""
    old, new = Side(*first), Side(*second)
    comparison, found = _compare(old, new)
    return comparison, detail(old, new, found, comparison.changes)


def _compare(old: Side, new: Side) -> tuple[Comparison, Match]:
    found = match(old, new)
    changes = [
        *row_changes(old, new, found),
        *device_changes(old, new, found),
        *helper_changes(old, new, found),
        *table_changes(old, new, found),
        *gesture_changes(old, new, found),
        *scene_changes(old, new, found),
        *protocol_changes(old, new, found),
        *test_changes(old, new, found),
        *sheet_changes(old, new),
        *_notes(old, new),
    ]
    return Comparison(_version(old), _version(new), tuple(changes)), found


def _version(side: Side) -> Version:
    reading = side.reading
    return Version(side.workbook.source, reading.digest, reading.format, len(side.checked.report.errors))


def _notes(old: Side, new: Side) -> list[Change]:
    """Changed notes of devices and helpers; the other parts tell their own."""
    out = []
    for part in ("device", "helper"):
        places = []
        for side in (old, new):
            book = side.workbook
            cells = [d.stream for d in book.devices] if part == "device" else [h.name for h in book.helpers]
            places.append({c.text: c.address for c in cells})
        for name in places[0].keys() & places[1].keys():
            at = [p[name] for p in places]
            before, after = (s.note(a.sheet, a.row) for s, a in zip((old, new), at, strict=True))
            if before != after:
                rows = (at[0].row, at[1].row)
                out.append(Change("notes", part, at[1].sheet, name, rows, "notes", before, after, effect=False))
    return sorted(out, key=lambda c: (c.part, c.rows[1]))
