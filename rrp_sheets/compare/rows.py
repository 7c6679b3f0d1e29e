"""Changes of the behaviours: sheets, rows, streams, and rows whose new order has an effect."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from rrp_sheets.compare.changes import Change, meanings, pieces, shape
from rrp_sheets.compare.match import Match, out_of_order
from rrp_sheets.compare.side import BehaviourView, RowView, Side, different, formula_name
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import N_, listed

OFF = N_("the row is switched off in both")
RENAMED = N_("the same stream under another name")
WRITTEN = N_("it means the same")
_CELLS = {
    "connector": N_("connector"), "inputs": N_("inputs"), "formula": N_("formula"), "output": N_("output"),
    "priority": N_("priority"),
}  # fmt: skip
_DRAWS = N_("what PICK draws from one seed goes with the row's number")
_PLACE = N_("the row stands elsewhere, which changes nothing")


def row_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of all behaviours, in the order of the second workbook's sheets and rows."""
    out: list[Change] = []
    late = reordered(first, second, found)
    for b, behaviour in enumerate(second.behaviours):
        a = found.behaviours.back.get(b)
        if a is None:
            out += _whole("added", behaviour)
            continue
        old = first.behaviours[a]
        if old.key != behaviour.key:
            out.append(Change("renamed", "behaviour", behaviour.name, before=old.name, after=behaviour.name,
                              effect=False, note=N_("the same rows under another name")))  # fmt: skip
        elif old.name != behaviour.name:
            out.append(Change("written", "behaviour", behaviour.name, what=N_("name"), before=old.name,
                              after=behaviour.name, effect=False, note=WRITTEN))  # fmt: skip
        out += _Pair(first, second, found, a, b, late).changes()
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
    count = N_("{n} row" if n == 1 else "{n} rows", n=n)
    before, after = ("", count) if kind == "added" else (count, "")
    on = any(row.on for row in behaviour.rows)
    note = "" if on else N_("none of its rows is switched on")
    yield Change(kind, "behaviour", behaviour.name, before=before, after=after, effect=on, note=note)
    for row in behaviour.rows:
        yield _one_sided(kind, row)


def _one_sided(kind: str, view: RowView) -> Change:
    number, text = view.row.number, row_text(view)
    rows, before, after = ((0, number), "", text) if kind == "added" else ((number, 0), text, "")
    note = "" if view.on else N_("the row is switched off")
    return Change(kind, "row", view.sheet, rows=rows, before=before, after=after, effect=view.on, note=note)


def row_text(view: RowView) -> str:
    """Return the cells of a row on one line, as in the sheet."""
    row = view.row
    return " | ".join(c.text for c in (row.inputs_cell, row.connector, row.formula, row.output))


class _Pair:
    """Comparison of two behaviours that are paired."""

    def __init__(
        self, first: Side, second: Side, found: Match, a: int, b: int, late: dict[tuple[str, int], str]
    ) -> None:
        self.first, self.second, self.found, self.late = first, second, found, late
        self.old, self.new = first.behaviours[a], second.behaviours[b]
        self.pairs = found.rows[a, b]

    def changes(self) -> list[Change]:
        placed: list[tuple[int, int, list[Change]]] = []
        moved = self.pairs.moved(self.found.turned)
        for a, b in self.pairs.to.items():
            found = self._row(self.old.rows[a], self.new.rows[b], a in moved)
            if found:
                placed.append((self.new.rows[b].row.number, 1, found))
        for b in self.pairs.right:
            placed.append((self.new.rows[b].row.number, 1, [_one_sided("added", self.new.rows[b])]))
        below = 0  # a removed row is listed where it stood: after the row above it that is still there
        for a, view in enumerate(self.old.rows):
            if a in self.pairs.to:
                below = self.new.rows[self.pairs.to[a]].row.number
            else:
                placed.append((below, 2, [_one_sided("removed", view)]))
        placed.sort(key=lambda entry: entry[:2])
        return [change for _, _, found in placed for change in found]

    def _row(self, a: RowView, b: RowView, moved: bool) -> list[Change]:
        out: list[Change] = []
        if a.on != b.on:
            out.append(self._change(a, b, "on" if b.on else "off"))
        out += self._connector(a, b)
        inputs = self._inputs(a, b)
        formula = self._formula(a, b)
        out += [*inputs, *formula, *self._output(a, b), *self._priority(a, b)]
        late = self.late.get((self.new.key, b.row.number), "")
        if late or (moved and (a.row.number, a.sheet) != (b.row.number, b.sheet)):
            out.append(self._change(a, b, "moved", effect=bool(late), note=late or _PLACE))
        elif _draws(a) and _draws(b) and (a.row.number, a.sheet) != (b.row.number, b.sheet):
            out.append(self._change(a, b, "moved", effect=False, note=_DRAWS))
        for column, before, after in different(a.row.remarks, b.row.remarks):
            out.append(self._change(a, b, "notes", "", before, after, effect=False, what=column))
        return out if a.on or b.on else [c.harmless(OFF) for c in out]

    def _change(self, a: RowView, b: RowView, kind: str, field: str = "", before: str = "", after: str = "",
                effect: bool = True, note: str = "", what: str = "") -> Change:  # fmt: skip
        return Change(
            kind, "row", b.sheet, rows=(a.row.number, b.row.number), what=_CELLS.get(field, what), before=before,
            after=after, effect=effect, note=note, field=field,
        )  # fmt: skip

    def _written(self, a: RowView, b: RowView, field: str, before: str, after: str) -> list[Change]:
        if before == after:
            return []
        return [self._change(a, b, "written", field, before, after, effect=False, note=WRITTEN)]

    def _connector(self, a: RowView, b: RowView) -> list[Change]:
        before, after = a.row.connector.text, b.row.connector.text
        if a.connector != b.connector:
            return [self._change(a, b, "changed", "connector", before, after)]
        return self._written(a, b, "connector", before, after)

    def _inputs(self, a: RowView, b: RowView) -> list[Change]:
        before, after = _said(a, self.first), _said(b, self.second)
        mine = self.found.inputs(a)
        if mine != b.inputs:
            change = self._change(a, b, "changed", "inputs", before, after)
            if self._same_by_names(a, b):
                return [change.harmless(N_("the order of these inputs changes nothing"))]
            return [change]
        if [key(c.text) for c in a.row.inputs] == [key(c.text) for c in b.row.inputs] or not self._renames(a, b):
            return self._written(a, b, "inputs", before, after)
        return []

    def _same_by_names(self, a: RowView, b: RowView) -> bool:
        """Return whether two `combineLatest` rows differ in the order of their inputs only."""
        if a.formula is None or b.formula is None or not a.connector == b.connector == "combineLatest":
            return False
        if sorted(self.found.inputs(a)) != sorted(b.inputs):
            return False
        mine = dict(zip(a.formula.names[-len(a.inputs) :], self.found.inputs(a), strict=False))
        other = dict(zip(b.formula.names[-len(b.inputs) :], b.inputs, strict=False))
        return shape(a.formula.tree, mine, self.found.helpers) == shape(b.formula.tree, other)

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
            return [] if explained and names else self._written(a, b, "formula", before, after)
        if self._same_by_fields(a, b):
            return []  # the stream's new name is told
        found = pieces(before, after, names) if before and after else ()
        return [replace(self._change(a, b, "changed", "formula", before, after), pieces=found)]

    def _same_by_fields(self, a: RowView, b: RowView) -> bool:
        """Return whether only fields differ that a combineLatest without formula names after its streams."""
        if a.formula is None or b.formula is None or not self.fields:
            return False
        fields = self.fields
        mine = {name: str(i) for i, name in enumerate(a.formula.names[-len(a.inputs) :])}
        return shape(a.formula.tree, mine, self.found.helpers, fields) == b.shape

    @cached_property
    def fields(self) -> dict[str, str]:
        """New keys of fields that are named after streams, by the old ones, where they differ."""
        if not self.first.field_names:
            return {}
        names = {
            key(argument_name(self.first.shown(i))): key(argument_name(self.second.shown(j)))
            for i, j in self.found.streams.to.items()
        }
        return {old: new for old, new in names.items() if old != new}

    def _output(self, a: RowView, b: RowView) -> list[Change]:
        before, after = a.row.output.text, b.row.output.text
        if a.drives != b.drives:
            return [self._change(a, b, "changed", "output", before, after)] if key(before) != key(after) else []
        if a.drives:
            if self.found.streams.of(a.output) != b.output:
                return [self._change(a, b, "changed", "output", before, after)]
            return self._written(a, b, "output", before, after) if key(before) == key(after) else []
        if key(before) == key(after):
            return self._written(a, b, "output", before, after)
        return [Change("renamed", "stream", b.sheet, rows=(a.row.number, b.row.number), before=before, after=after,
                       effect=False, note=RENAMED)]  # fmt: skip

    def _priority(self, a: RowView, b: RowView) -> list[Change]:
        if a.row.priority == b.row.priority:
            return []
        change = self._change(a, b, "changed", "priority", f"{a.row.priority:g}", f"{b.row.priority:g}")
        return [change if a.drives or b.drives else change.harmless(N_("only rows that drive an actuator use it"))]


def _draws(view: RowView) -> bool:
    return "pick" in view.tokens


def _said(view: RowView, side: Side) -> str:
    """Return the text of the input cell, or words for a blank one."""
    if view.row.inputs_cell.text or not view.inputs:
        return view.row.inputs_cell.text or N_("the row above")
    names = [side.shown(i) or N_("unnamed") for i in view.inputs]
    return N_("the row above ({names})", names=listed(names))


_Place = tuple[str, int]  # a behaviour's key and a row's number, in the second workbook
_Both = tuple[RowView, RowView, _Place]


def reordered(first: Side, second: Side, found: Match) -> dict[_Place, str]:
    """Return the rows whose changed order has an effect, with a description of the effect."""
    rows: list[_Both] = []
    for (i, j), pairs in found.rows.items():
        old, new = first.behaviours[i], second.behaviours[j]
        both = ((old.rows[a], new.rows[b]) for a, b in pairs.to.items())
        rows += [(a, b, (new.key, b.row.number)) for a, b in both if _takes_part(a) and _takes_part(b)]
    groups: dict[tuple[str, float], list[_Both]] = defaultdict(list)
    for a, b, place in rows:
        if a.drives and b.drives and a.row.priority == b.row.priority:
            for use in _uses(second, b.output):
                groups[use, b.row.priority].append((a, b, place))
    out: dict[_Place, str] = {}
    for (use, _), members in groups.items():
        for place in _late(members, found.turned):
            name = second.shown(use) if use in second.streams else use
            out[place] = N_("of two commands for {name} in one instant another one comes last now", name=name)
    if key(second.workbook.protocol.text("Engine", "frame")) != "frame":
        for place in _late(rows, found.turned):
            out.setdefault(place, N_("this engine works in the order of the rows"))
    return out


def _late(rows: list[_Both], turned: bool) -> set[_Place]:
    """Return the places of the fewest rows without which all others act in the same order as before."""
    ranks = [(_rank(a), _rank(b), place) for a, b, place in rows]
    if turned:
        ranks = [(new, old, place) for old, new, place in ranks]
    ranks.sort()
    return out_of_order([place for _, _, place in ranks], [new for _, new, _ in ranks])


def _rank(view: RowView) -> int:
    return view.step.rank if view.step is not None else 0


def _takes_part(view: RowView) -> bool:
    return view.on and view.step is not None


def _uses(side: Side, stream: str) -> set[str]:
    """Return the resources of a command for an actuator stream: the stream itself, and the parts of the robot."""
    found = side.streams.get(stream)
    if found is None or found.device is None:
        return {stream}
    return {stream, *found.device.type.resources_for(found.settings)}
