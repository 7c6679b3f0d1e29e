"""Compares two workbooks by their meaning; finds the changes of sheets, Protocol, devices and helpers itself.

Two workbooks have the *same behaviour* when their rows resolve to the same graph (the same connectors, formulas and
devices with the same settings, joined in the same way), with the same priorities, helpers, tables, gestures and scene,
and are run in the same way; and when of two rows that drive one part of the robot with one priority the same comes
last. Names of streams, helpers and sheets, the order of rows and sheets otherwise, spelling, notes, tests, fields of
the Protocol that are for people, rows that are switched off, and devices and helpers that nothing uses make no other
behaviour. Such differences are reported all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import replace

from rrp_sheets.checks import Checked
from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison, meanings, one_sided, pieces
from rrp_sheets.compare.detail import detail, gesture_changes, risk_changes, scene_changes, table_changes, test_changes
from rrp_sheets.compare.match import Match, helper_meaning, match
from rrp_sheets.compare.rows import RENAMED, WRITTEN, row_changes
from rrp_sheets.compare.side import DeviceView, Side, different
from rrp_sheets.model.changed import ChangedBehaviour
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Helper
from rrp_sheets.texts import N_, LazyMessage, listed
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.schema import FIELDS, recognise
from rrp_sheets.workbook.sheet_readers import words

# Notes of changes without effect.
OWN = N_("your own sheet, which the robot does not read")
EMPTY = N_("it has no rows")
FOR_PEOPLE = N_("for people; the robot ignores it")
DEFAULT = N_("a blank field means the same")
UNUSED = N_("no row that is switched on uses it")
_BY_NAME = N_("the name alone means the same device")
_OURS = ("devices", "helpers", "gestures", "risks")
_LISTS = ("lists", "listsfordropdowns", "リスト")  # with what drop-downs offer: made by the program, not by people


def compare(first: tuple[Reading, Checked], second: tuple[Reading, Checked]) -> Comparison:
    """Compare two workbooks, each read and checked; either may have errors."""
    return _compare(Side(*first), Side(*second))[0]


def compare_in_detail(
    first: tuple[Reading, Checked], second: tuple[Reading, Checked]
) -> tuple[Comparison, tuple[ChangedBehaviour, ...]]:
    """Compare two workbooks, and return the changed behaviours as well, as they are drawn."""
    old, new = Side(*first), Side(*second)
    comparison, found = _compare(old, new)
    return comparison, detail(old, new, found, comparison.changes)


def _compare(old: Side, new: Side) -> tuple[Comparison, Match]:
    found = match(old, new)
    makers = (
        row_changes, device_changes, helper_changes, table_changes, gesture_changes, scene_changes, protocol_changes,
        test_changes, risk_changes,
    )  # fmt: skip
    changes = [change for make in makers for change in make(old, new, found)]
    changes += [*sheet_changes(old, new), *_notes(old, new)]
    return Comparison(_version(old), _version(new), tuple(changes)), found


def _version(side: Side) -> ComparedWorkbook:
    reading = side.reading
    return ComparedWorkbook(side.workbook.source, reading.digest, reading.format, len(side.checked.report.errors))


def _notes(old: Side, new: Side) -> list[Change]:
    """Return the changed notes of devices and helpers; the other parts report theirs themselves."""
    out = []
    for part in ("device", "helper"):
        places = []
        for side in (old, new):
            book = side.workbook
            cells = [d.stream for d in book.devices] if part == "device" else [h.name for h in book.helpers]
            places.append({c.text: c.address for c in cells})
        for name in places[0].keys() & places[1].keys():
            a, b = (p[name] for p in places)
            for column, was, now in different(old.remarks_of(a.sheet, a.row), new.remarks_of(b.sheet, b.row)):
                out.append(Change("notes", part, b.sheet, name, (a.row, b.row), column, was, now, effect=False))
    return sorted(out, key=lambda c: (c.part, c.rows[1]))


def sheet_changes(first: Side, second: Side) -> list[Change]:
    """Return the sheets that only one workbook has, if the robot does not read them or they have no rows."""
    out = []
    for word, here, other in (("added", second, first), ("removed", first, second)):
        there = {key(name) for name in other.workbook.sheets}
        for name, note in _untold(here).items():
            if key(name) not in there:
                out.append(Change(word, "sheet", name, effect=False, note=note))
    return out


def _untold(side: Side) -> dict[str, str]:
    found: dict[str, str] = {}
    for sheet in side.reading.sheets:
        what = recognise(sheet)
        if what.kind is None and key(sheet.name) not in {*side.workbook.tables, *_LISTS} and sheet.cells:
            found[sheet.name] = OWN
        elif what.kind is not None and what.kind.name in _OURS and not any(row > what.row for row, _ in sheet.cells):
            found[sheet.name] = EMPTY
    return found


# What the fields that have an effect mean, their defaults filled in.
_ACTED_ON: Mapping[str, Callable[[Side], Hashable]] = {
    "robot": lambda side: side.checked.robot.name,
    "engine": lambda side: key(side.workbook.protocol.text("Engine", "frame")),
    "framerate": lambda side: side.checked.run.frame_rate,
    "seed": lambda side: side.checked.run.seed,
    "timelimit": lambda side: side.checked.run.time_limit_us,
    "run": lambda side: side.checked.run.behaviours,
    "facememory": lambda side: _chosen(side, "Face memory", "ends with the run"),
    "camerapictures": lambda side: _chosen(side, "Camera pictures", "kept"),
}


def _chosen(side: Side, name: str, usual: str) -> str:
    text = side.workbook.protocol.text(name, usual)
    return FIELDS[key(name)].meaning(text) or key(text)


def protocol_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the Protocol's fields, in the order of the second workbook, then the removed ones."""
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
        for column, was, now in different(first.remarks_of(place, rows[0]), second.remarks_of(place, rows[1])):
            out.append(replace(base, kind="notes", what=column, before=was, after=now, effect=False))
    return out


def _field(base: Change, k: str, first: Side, second: Side, found: Match) -> list[Change]:
    if base.before == base.after:
        return []
    meaning = _ACTED_ON.get(k)
    if meaning is None:
        return [base.harmless(FOR_PEOPLE)]
    mine, other = meaning(first), meaning(second)
    if k == "run":  # by the keys that the behaviours have in the second workbook
        mine = frozenset(found.streams.sheets.get(b, b) for b in first.checked.run.behaviours)
    errors = base.before and base.after and _refused(first, k) and _refused(second, k)
    if mine != other or errors:
        return [base]
    note = WRITTEN if base.before and base.after else DEFAULT
    return [replace(base, kind="written", effect=False, note=note)]


def _refused(side: Side, k: str) -> bool:
    cell = side.workbook.protocol.fields.get(k)
    return cell is not None and any(d.address == cell.address for d in side.checked.report.errors)


# ---- devices
def device_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the device streams, in the order of the second workbook, then the removed ones."""
    partner = {found.streams.of(k): k for k in first.devices}
    told: list[tuple[list[Change], bool]] = []
    for k, new in second.devices.items():
        was = partner.get(k)
        changes = _only_device("added", new) if was is None else [*_device(first.devices[was], new, found)]
        told.append((changes, k in second.used or was in first.used))
    gone = ((k, old) for k, old in first.devices.items() if found.streams.of(k) not in second.devices)
    told += [(_only_device("removed", old), k in first.used) for k, old in gone]
    return [c if used else c.harmless(UNUSED) for changes, used in told for c in changes]


def _only_device(kind: str, view: DeviceView) -> list[Change]:
    """Return the change for a declared device that only one workbook has; others show at the rows that name them."""
    settings = (N_("{name} {value}", name=_name(view, k), value=text) for k, text in view.texts.items())
    said = listed([view.device, *settings])
    return [one_sided(kind, "device", view.sheet, said, view.row, name=view.name)] if view.row else []


def _change(old: DeviceView, new: DeviceView, kind: str, what: str, before: str, after: str, note: str = "") -> Change:
    """Return a change of a device: one with effect, unless there is a note why it has none."""
    sheet = new.sheet if new.row or not old.row else old.sheet
    return Change(kind, "device", sheet, new.name, (old.row, new.row), what, before, after, not note, note)


def _device(old: DeviceView, new: DeviceView, found: Match) -> Iterator[Change]:
    if key(old.name) != key(new.name):
        yield Change("renamed", "stream", new.sheet, "", (old.row, new.row), "", old.name, new.name, False, RENAMED)
    elif old.name != new.name and old.row and new.row:
        yield _change(old, new, "written", N_("stream"), old.name, new.name, WRITTEN)
    mine, other = (view.found.type.name if view.found else key(view.device) for view in (old, new))
    presets = [view.found.preset if view.found else {} for view in (old, new)]
    if mine == other and bool(old.row) != bool(new.row):
        if old.meaning(found.streams.sheets) == new.meaning({}) and key(old.name) == key(new.name):
            before, after = (N_("declared"), "") if old.row else ("", N_("declared"))
            yield _change(old, new, "written", N_("declaration"), before, after, _BY_NAME)
    elif mine != other or (presets[0] != presets[1] and old.row):
        yield _change(old, new, "changed", N_("device"), old.device, new.device)
    elif old.device != new.device and old.row:
        yield _change(old, new, "written", N_("device"), old.device, new.device, WRITTEN)
    yield from _settings(old, new, found)


def _settings(old: DeviceView, new: DeviceView, found: Match) -> Iterator[Change]:
    kept = old.found is None or new.found is None or old.found.type.name == new.found.type.name
    for k in dict.fromkeys([*old.settings, *new.settings, *old.texts, *new.texts]):
        view = new if new.found is not None and k in new.found.type.settings else old
        name = _name(view, k)
        before, after = old.value(k, found.streams.sheets), new.value(k, {})
        texts = old.texts.get(k, ""), new.texts.get(k, "")
        known = k in old.settings or k in new.settings
        same = before == after if known and kept else texts[0] == texts[1]
        if not same:
            was, now = texts[0] or _default(before), texts[1] or _default(after)
            yield _change(old, new, "changed", name, was, now)
        elif texts[0] != texts[1]:
            note = WRITTEN if texts[0] and texts[1] else N_("a blank cell means the same")
            yield _change(old, new, "written", name, texts[0], texts[1], note)


def _name(view: DeviceView, k: str) -> str:
    setting = view.found.type.settings.get(k) if view.found is not None else None
    return LazyMessage(setting.name, msgctxt="setting") if setting is not None else k


def _default(value: Value) -> str:
    if value is None or value == "":
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)


# ---- helpers
def helper_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the helpers, in the order of the second workbook, then the removed ones."""
    old, new = _helpers(first), _helpers(second)
    back = {b: a for a, b in found.helpers.items()}
    called = _called(first) | _called(second)
    told: list[tuple[list[Change], set[str]]] = []
    for k, helper in new.items():
        was = back.get(k, k)
        changes = [*_helper(first, second, old[was], helper, found)] if was in old else [_only_helper("added", helper)]
        told.append((changes, {k, was}))
    gone = ((k, helper) for k, helper in old.items() if found.helpers.get(k, k) not in new)
    told += [([_only_helper("removed", helper)], {k}) for k, helper in gone]
    return [c if names & called else c.harmless(UNUSED) for changes, names in told for c in changes]


def _helpers(side: Side) -> dict[str, Helper]:
    found: dict[str, Helper] = {}
    for helper in side.workbook.helpers:
        found.setdefault(key(helper.name.text), helper)
    return found


def _called(side: Side) -> set[str]:
    """Return the names in the formulas of rows that are on and of helpers."""
    rows = [view.row.formula.text for b in side.behaviours for view in b.rows if view.row.on]
    return words([*rows, *(h.formula.text for h in side.workbook.helpers)])


def _only_helper(kind: str, helper: Helper) -> Change:
    at = helper.name.address
    return one_sided(kind, "helper", at.sheet, helper.formula.text, at.row, name=helper.name.text)


def _helper(first: Side, second: Side, old: Helper, new: Helper, found: Match) -> Iterator[Change]:
    at, k, now = new.name.address, key(old.name.text), key(new.name.text)
    change = Change("changed", "helper", at.sheet, new.name.text, (old.name.address.row, at.row))
    if k != now:
        renamed = replace(change, kind="renamed", before=old.name.text, after=new.name.text)
        yield renamed.harmless(N_("the same helper under another name"))
    meanings_known = helper_meaning(first, k, found.helpers), helper_meaning(second, now, {})
    inputs = ", ".join(c.text for c in old.inputs), ", ".join(c.text for c in new.inputs)
    before, after = old.formula.text, new.formula.text
    if None not in meanings_known:
        same_inputs = same = meanings_known[0] == meanings_known[1]
    else:
        same_inputs = [key(c.text) for c in old.inputs] == [key(c.text) for c in new.inputs]
        same = meanings(before, found.helpers) == meanings(after)
    yield from _cell(change, N_("inputs"), *inputs, same_inputs or inputs[0] == inputs[1], {})
    yield from _cell(change, N_("formula"), before, after, same, found.helpers)


def _cell(change: Change, what: str, before: str, after: str, same: bool, names: Mapping[str, str]) -> list[Change]:
    if before == after or (same and names and meanings(before, names) == meanings(after)):
        return []
    change = replace(change, what=what, before=before, after=after)
    if same:
        return [replace(change, kind="written", effect=False, note=WRITTEN)]
    return [replace(change, pieces=pieces(before, after, names) if before and after else ())]
