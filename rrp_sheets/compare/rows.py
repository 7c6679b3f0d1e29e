"""Changes of the behaviours: sheets, rows, streams, and rows whose new order has an effect."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

from rrp_sheets.compare.changes import Change, meanings, one_sided, pieces, shape
from rrp_sheets.compare.match import Match, Pairs, changed_order
from rrp_sheets.compare.side import BehaviourView, RowView, Side, different, formula_name
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_, listed

OFF = N_("the row is switched off in both")
RENAMED = N_("the same stream under another name")
WRITTEN = N_("it means the same")
_CELLS: dict[str, str] = {n: n for n in (N_("connector"), N_("inputs"), N_("formula"), N_("output"), N_("priority"))}
_DRAWS = N_("the random choices of PICK depend on the row's number")
_PLACE = N_("the row moved, which changes nothing")


def row_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of all behaviours, in the order of the second workbook's sheets and rows."""
    out: list[Change] = []
    rows = _RowComparison(first, second, found)
    for b, behaviour in enumerate(second.behaviours):
        a = found.behaviours.back.get(b)
        if a is None:
            out += _whole("added", behaviour)
            continue
        old = first.behaviours[a]
        named = Change("renamed", "behaviour", behaviour.name, before=old.name, after=behaviour.name, effect=False)
        if old.key != behaviour.key:
            out.append(replace(named, note=N_("the same rows under another name")))
        elif old.name != behaviour.name:
            out.append(replace(named, kind="written", what=N_("name"), note=WRITTEN))
        out += rows.changes(old, behaviour, found.rows[a, b])
    for a in found.behaviours.left:
        out += _whole("removed", first.behaviours[a])
    if found.behaviours.moved(found.turned):
        names = tuple(", ".join(b.name for b in side.behaviours) for side in (first, second))
        out.append(Change("moved", "sheet", what=N_("order of the sheets"), before=names[0], after=names[1],
                          effect=False, note=N_("the rows are the same")))  # fmt: skip
    return out


def _whole(kind: str, behaviour: BehaviourView) -> Iterator[Change]:
    """Yield the changes for a behaviour that only one workbook has, and for its rows."""
    n = len(behaviour.rows)
    on = any(view.row.on for view in behaviour.rows)
    note = "" if on else N_("none of its rows is switched on")
    yield one_sided(kind, "behaviour", behaviour.name, N_("{n} row" if n == 1 else "{n} rows", n=n), 0, on, note)
    yield from (_one_sided(kind, view) for view in behaviour.rows)


def _one_sided(kind: str, view: RowView) -> Change:
    row = view.row
    text = " | ".join(c.text for c in (row.inputs_cell, row.connector, row.formula, row.output))
    return one_sided(kind, "row", view.sheet, text, row.number, row.on, "" if row.on else N_("the row is switched off"))


def in_sheet_order(
    old: Sequence[RowView], new: Sequence[RowView], pairs: Pairs
) -> list[tuple[RowView | None, RowView | None]]:
    """Return the paired rows, and those of one workbook only; a removed row stands below the last kept one above it."""
    placed: list[tuple[int, int, RowView | None, RowView | None]] = []
    for j, view in enumerate(new):
        placed.append((view.row.number, 1, old[pairs.back[j]] if j in pairs.back else None, view))
    below = 0
    for i, view in enumerate(old):
        if i in pairs.to:
            below = new[pairs.to[i]].row.number
        else:
            placed.append((below, 2, view, None))
    placed.sort(key=lambda entry: entry[:2])
    return [(a, b) for _, _, a, b in placed]


class _RowComparison:
    def __init__(self, first: Side, second: Side, found: Match) -> None:
        self.first, self.second, self.found = first, second, found
        self.late = reordered(first, second, found)

    def changes(self, old: BehaviourView, new: BehaviourView, pairs: Pairs) -> Iterator[Change]:
        moved = {old.rows[a].row.number for a in pairs.moved(self.found.turned)}
        for a, b in in_sheet_order(old.rows, new.rows, pairs):
            if a is not None and b is not None:
                yield from self._row(a, b, a.row.number in moved)
            elif b is not None:
                yield _one_sided("added", b)
            elif a is not None:
                yield _one_sided("removed", a)

    def _row(self, a: RowView, b: RowView, moved: bool) -> list[Change]:
        out = [self._change(a, b, "on" if b.row.on else "off")] if a.row.on != b.row.on else []
        connectors = a.row.connector.text, b.row.connector.text
        out += self._cell(a, b, "connector", *connectors, same=a.connector == b.connector)
        out += [*self._inputs(a, b), *self._formula(a, b), *self._output(a, b)]
        if a.row.priority != b.row.priority:
            change = self._change(a, b, "changed", "priority", f"{a.row.priority:g}", f"{b.row.priority:g}")
            used = a.drives or b.drives
            out.append(change if used else change.harmless(N_("only rows that control an actuator use it")))
        late = self.late.get((key(b.sheet), b.row.number), "")
        elsewhere = (a.row.number, a.sheet) != (b.row.number, b.sheet)
        if late or (moved and elsewhere):
            out.append(self._change(a, b, "moved", effect=bool(late), note=late or _PLACE))
        elif elsewhere and "pick" in a.tokens and "pick" in b.tokens:
            out.append(self._change(a, b, "moved", effect=False, note=_DRAWS))
        for column, before, after in different(a.row.remarks, b.row.remarks):
            out.append(self._change(a, b, "notes", "", before, after, effect=False, what=column))
        return out if a.row.on or b.row.on else [c.harmless(OFF) for c in out]

    def _change(self, a: RowView, b: RowView, kind: str, field: str = "", before: str = "", after: str = "",
                effect: bool = True, note: str = "", what: str = "") -> Change:  # fmt: skip
        return Change(
            kind, "row", b.sheet, rows=(a.row.number, b.row.number), what=_CELLS.get(field, what), before=before,
            after=after, effect=effect, note=note, field=field,
        )  # fmt: skip

    def _cell(self, a: RowView, b: RowView, field: str, before: str, after: str, *, same: bool) -> list[Change]:
        if not same:
            return [self._change(a, b, "changed", field, before, after)]
        if before == after:
            return []
        return [self._change(a, b, "written", field, before, after, effect=False, note=WRITTEN)]

    def _inputs(self, a: RowView, b: RowView) -> list[Change]:
        before, after = _said(a, self.first), _said(b, self.second)
        if self.found.inputs(a) != b.inputs:
            change = self._change(a, b, "changed", "inputs", before, after)
            harmless = self._same_by_names(a, b)
            return [change.harmless(N_("the order of these inputs changes nothing")) if harmless else change]
        if [key(c.text) for c in a.row.inputs] != [key(c.text) for c in b.row.inputs] and self._renames(a, b):
            return []
        return self._cell(a, b, "inputs", before, after, same=True)

    def _same_by_names(self, a: RowView, b: RowView) -> bool:
        """Return whether two `combineLatest` rows differ in the order of their inputs only."""
        if a.formula is None or b.formula is None or not a.connector == b.connector == "combineLatest":
            return False
        inputs = self.found.inputs(a)
        mine = dict(zip(a.formula.names[-len(a.inputs) :], inputs, strict=False))
        other = dict(zip(b.formula.names[-len(b.inputs) :], b.inputs, strict=False))
        same_shape = shape(a.formula.tree, mine, self.found.helpers) == shape(b.formula.tree, other)
        return same_shape and sorted(inputs) == sorted(b.inputs)

    def _renames(self, a: RowView, b: RowView) -> dict[str, str]:
        """Return the new keys of a row's input streams in its formula by the old ones, where they differ."""
        names = {}
        for i in a.inputs:
            j = self.found.streams.of(i)
            old = formula_name(self.first.shown(i)) or "value"
            new = formula_name(self.second.shown(j)) or "value"
            if j in b.inputs and old != new:
                names[old] = new
        return names

    def _formula(self, a: RowView, b: RowView) -> list[Change]:
        before, after = a.row.formula.text, b.row.formula.text
        names = {**self._renames(a, b), **self.found.helpers}
        if before == after and not names:
            return []
        explained = meanings(before, names) == meanings(after)
        if explained or self.found.shape(a) == b.shape or self._same_by_names(a, b):
            return [] if explained and names else self._cell(a, b, "formula", before, after, same=True)
        if a.formula is not None and b.formula is not None and self.fields:
            places = {name: str(i) for i, name in enumerate(a.formula.names[-len(a.inputs) :])}
            if shape(a.formula.tree, places, self.found.helpers, self.fields) == b.shape:
                return []  # only fields that a combineLatest without formula names after its streams: these are told
        found = pieces(before, after, names) if before and after else ()
        return [replace(self._change(a, b, "changed", "formula", before, after), pieces=found)]

    @cached_property
    def fields(self) -> dict[str, str]:
        """New keys of fields that are named after streams, by the old ones, where they differ."""
        if not self.first.field_names:
            return {}
        streams = self.found.streams.to.items()
        names = {formula_name(self.first.shown(i)): formula_name(self.second.shown(j)) for i, j in streams}
        return {old: new for old, new in names.items() if old != new}

    def _output(self, a: RowView, b: RowView) -> list[Change]:
        before, after = a.row.output.text, b.row.output.text
        alike = key(before) == key(after)
        if a.drives != b.drives:
            return [] if alike else self._cell(a, b, "output", before, after, same=False)
        if a.drives and self.found.streams.of(a.output) != b.output:
            return self._cell(a, b, "output", before, after, same=False)
        if alike:
            return self._cell(a, b, "output", before, after, same=True)
        if a.drives:
            return []
        return [Change("renamed", "stream", b.sheet, rows=(a.row.number, b.row.number), before=before, after=after,
                       effect=False, note=RENAMED)]  # fmt: skip


def _said(view: RowView, side: Side) -> str:
    """Return the text of the input cell, or words for a blank one."""
    if view.row.inputs_cell.text or not view.inputs:
        return view.row.inputs_cell.text or N_("the row above")
    names = [side.shown(i) or N_("unnamed") for i in view.inputs]
    return N_("the row above ({names})", names=listed(names))


_Place = tuple[str, int]  # a behaviour's key and a row's number, in the second workbook
_Ranked = list[tuple[int, int, _Place]]  # ranks of rows in the first and in the second workbook


def reordered(first: Side, second: Side, found: Match) -> dict[_Place, str]:
    """Return the rows whose changed order has an effect, with a description of the effect."""
    rows: _Ranked = []
    groups: dict[tuple[str, float], _Ranked] = defaultdict(list)
    for (i, j), pairs in found.rows.items():
        old, new = first.behaviours[i], second.behaviours[j]
        for a, b in ((old.rows[x], new.rows[y]) for x, y in pairs.to.items()):
            if not (a.row.on and b.row.on) or a.step is None or b.step is None:
                continue
            rows.append((a.step.rank, b.step.rank, (new.key, b.row.number)))
            if a.drives and b.drives and a.row.priority == b.row.priority:
                for use in _uses(second, b.output):
                    groups[use, b.row.priority].append(rows[-1])
    out: dict[_Place, str] = {}
    for (use, _), members in groups.items():
        for place in changed_order(members, found.turned):
            name = second.shown(use) if use in second.streams else use
            out[place] = N_("of two commands for {name} at the same moment, another one now comes last", name=name)
    if key(second.workbook.protocol.text("Engine", "frame")) != "frame":
        for place in changed_order(rows, found.turned):
            out.setdefault(place, N_("this engine follows the order of the rows"))
    return out


def _uses(side: Side, stream: str) -> list[str]:
    """Return the resources of a command for an actuator stream: the stream itself, and the parts of the robot."""
    found = side.streams.get(stream)
    if found is None or found.device is None:
        return [stream]
    return list(dict.fromkeys([stream, *sorted(found.device.type.resources_for(found.settings))]))
