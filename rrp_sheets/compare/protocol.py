"""What changed in the Protocol sheet: fields that say how to run, and fields that tell people something."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace

from rrp_sheets.compare.changes import Change
from rrp_sheets.compare.match import Match
from rrp_sheets.compare.rows import WRITTEN
from rrp_sheets.compare.side import Side
from rrp_sheets.model.names import key

FOR_PEOPLE = "for people; the robot does not act on it"
DEFAULT = "this is what a blank field means"

# What the fields that have an effect mean, their defaults filled in.
_ACTED_ON: Mapping[str, Callable[[Side], Hashable]] = {
    "robot": lambda side: side.checked.robot.name,
    "engine": lambda side: key(side.workbook.protocol.text("Engine", "frame")),
    "framerate": lambda side: side.checked.run.frame_rate,
    "seed": lambda side: side.checked.run.seed,
    "timelimit": lambda side: side.checked.run.time_limit_us,
    "run": lambda side: side.checked.run.behaviours,
    "facememory": lambda side: key(side.workbook.protocol.text("Face memory", "ends with the run")),
    "camerapictures": lambda side: key(side.workbook.protocol.text("Camera pictures", "kept")),
}


def protocol_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """The changes of the Protocol's fields, in the order of the second workbook, then what is gone."""
    old, new = first.workbook.protocol, second.workbook.protocol
    out: list[Change] = []
    for k in dict.fromkeys([*new.fields, *old.fields]):
        mine, other = old.fields.get(k), new.fields.get(k)
        before, after = mine.text if mine else "", other.text if other else ""
        cells = [c for c in (other, mine) if c is not None]
        rows = (mine.address.row if mine else 0, other.address.row if other else 0)
        place = cells[0].address.sheet
        name = new.names.get(k) or old.names[k]
        base = Change("changed", "protocol", place, name, rows, "", before, after)
        out += _field(base, k, first, second, found)
        was, now = (s.note(place, row) if row else "" for s, row in zip((first, second), rows, strict=True))
        if was != now:
            out.append(Change("notes", "protocol", place, name, rows, "notes", was, now, effect=False))
    return out


def _field(base: Change, k: str, first: Side, second: Side, found: Match) -> list[Change]:
    if base.before == base.after:
        return []
    meaning = _ACTED_ON.get(k)
    if meaning is None:
        return [base.harmless(FOR_PEOPLE)]
    mine, other = meaning(first), meaning(second)
    if k == "run":
        mine, other = _run(first, found), second.checked.run.behaviours
    errors = base.before and base.after and _refused(first, k) and _refused(second, k)
    if mine != other or errors:
        return [base]
    note = WRITTEN if base.before and base.after else DEFAULT
    return [replace(base, kind="written", effect=False, note=note)]


def _run(side: Side, found: Match) -> frozenset[str]:
    """The behaviours that the first workbook runs, called as in the second."""
    return frozenset(found.streams.sheets.get(k, k) for k in side.checked.run.behaviours)


def _refused(side: Side, k: str) -> bool:
    """Whether the value of a field was refused by the check."""
    cell = side.workbook.protocol.fields.get(k)
    return cell is not None and any(d.address == cell.address for d in side.checked.report.errors)
