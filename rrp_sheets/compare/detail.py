"""Changed behaviours of a comparison, row by row and stream by stream, as they are drawn."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from rrp_sheets.compare.changes import Change
from rrp_sheets.compare.match import Match
from rrp_sheets.compare.side import BehaviourView, DeviceView, RowView, Side
from rrp_sheets.compare.tokens import helpers_in
from rrp_sheets.formulas import HelperDef
from rrp_sheets.model import changed as c
from rrp_sheets.model.changed import ChangedBehaviour, ChangedRow, ChangedStream, ComparableText, Link, same
from rrp_sheets.model.names import key

_SHOWN = frozenset(("changed", "on", "off"))  # kinds that make a row a changed one
_BLANK = "blank"


def detail(first: Side, second: Side, found: Match, changes: Sequence[Change]) -> tuple[ChangedBehaviour, ...]:
    """Return the behaviours in which something changed, in the order of the second workbook, then the removed ones."""
    maker = _Maker(first, second, found, changes)
    out = []
    for b, behaviour in enumerate(second.behaviours):
        a = found.behaviours.back.get(b)
        out.append(maker.alone(behaviour, c.ADDED) if a is None else maker.both(a, b))
    out += [maker.alone(first.behaviours[a], c.REMOVED) for a in found.behaviours.left]
    return tuple(b for b in out if b.rows and _has_changed(b))


def _has_changed(behaviour: ChangedBehaviour) -> bool:
    return any(r.sign for r in behaviour.rows) or any(s.sign for s in behaviour.streams.values())


class _Maker:
    def __init__(self, first: Side, second: Side, found: Match, changes: Sequence[Change]) -> None:
        self.first, self.second, self.found = first, second, found
        self.rows: dict[tuple[str, int, int], list[Change]] = defaultdict(list)
        self.settings: dict[str, list[tuple[str, ComparableText]]] = defaultdict(list)
        self.renamed = dict[str, tuple[str, str]]()  # devices that are called otherwise, by their keys now
        self.helpers: set[str] = set()
        for change in changes:
            if change.part == "row":
                self.rows[key(change.sheet), *change.rows].append(change)
            elif change.part == "device" and change.kind == "changed":
                words = ComparableText(change.before or _BLANK, change.after or _BLANK)
                self.settings[key(change.name)].append((change.what, words))
            elif change.part == "stream" and key(change.after) in second.devices:
                self.renamed[key(change.after)] = change.before, change.after
            elif change.part == "helper" and change.kind == "changed":
                self.helpers.add(key(change.name))

    # ---- behaviours
    def alone(self, behaviour: BehaviourView, sign: str) -> ChangedBehaviour:
        """Return the changed behaviour for one that only one workbook has."""
        side = self.second if sign == c.ADDED else self.first
        rows = [self._one_sided(view, sign) for view in behaviour.rows]
        views = {(sign, view.row.number): view for view in behaviour.rows}
        return ChangedBehaviour(behaviour.name, sign, tuple(rows), self._streams(rows, views, side, side))

    def both(self, a: int, b: int) -> ChangedBehaviour:
        """Return the changed behaviour for two that are paired."""
        old, new, pairs = self.first.behaviours[a], self.second.behaviours[b], self.found.rows[a, b]
        placed = []
        for j, view in enumerate(new.rows):
            i = pairs.back.get(j)
            row = self._one_sided(view, c.ADDED) if i is None else self._pair(old.rows[i], view)
            placed.append((view.row.number, 0, row))
        below = 0
        for i, view in enumerate(old.rows):
            if i in pairs.to:
                below = new.rows[pairs.to[i]].row.number
            else:
                placed.append((below, 1, self._one_sided(view, c.REMOVED)))
        placed.sort(key=lambda entry: entry[:2])
        rows = tuple(row for *_, row in placed)
        views = {("", v.row.number): v for v in new.rows} | {(c.REMOVED, v.row.number): v for v in old.rows}
        return ChangedBehaviour(new.name, c.SAME, rows, self._streams(rows, views, self.first, self.second))

    # ---- rows
    def _one_sided(self, view: RowView, sign: str) -> ChangedRow:
        def words(text: str) -> ComparableText:
            return ComparableText("", text) if sign == c.ADDED else ComparableText(text, "")

        ident = self._old if sign == c.REMOVED else str
        row, number = view.row, view.row.number
        takes = tuple(Link(ident(i), sign) for i in dict.fromkeys(view.inputs))
        texts = [words(t.text) for t in (row.inputs_cell, row.connector, row.formula, row.output)]
        return ChangedRow(
            sign, number, number if sign == c.REMOVED else 0, texts[0], texts[1], texts[2], texts[3], takes,
            (Link(ident(view.output), sign),), () if view.on else ("switched off",), off=not view.on,
        )  # fmt: skip

    def _pair(self, a: RowView, b: RowView) -> ChangedRow:
        found = self.rows.get((key(b.sheet), a.row.number, b.row.number), [])
        cells = {change.what: change for change in found if change.kind == "changed"}
        remarks = [*self._remarks(a, b, found, cells), *self._helper_remarks(b)]
        moved = any(change.kind == "moved" and change.effect for change in found)
        sign = c.CHANGED if remarks or moved or any(change.kind in _SHOWN for change in found) else c.SAME
        row = b.row
        inputs, formula = cells.get("inputs"), cells.get("formula")
        return ChangedRow(
            sign, row.number, a.row.number,
            ComparableText(inputs.before, inputs.after) if inputs else same(row.inputs_cell.text),
            _words(cells.get("connector"), b.row.connector.text),
            _words(formula, row.formula.text), _words(cells.get("output"), row.output.text),
            _links([self._old(i) for i in a.inputs], b.inputs), _links([self._old(a.output)], [b.output]),
            tuple(remarks), off=not b.on,
        )  # fmt: skip

    def _remarks(self, a: RowView, b: RowView, found: Iterable[Change], cells: Mapping[str, Change]) -> Iterable[str]:
        for change in found:
            if change.kind in ("on", "off"):
                yield f"switched {change.kind}"
            elif change.kind == "moved" and change.effect:
                yield f"moved, was row {a.row.number}"
        if "priority" in cells:
            yield f"priority {cells['priority'].before} → {cells['priority'].after}"
        if cells and not (a.on or b.on):
            yield "off in both"

    def _helper_remarks(self, b: RowView) -> Iterable[str]:
        if b.formula is None or not self.helpers:
            return
        called: dict[str, HelperDef] = {}
        helpers_in(b.formula.tree, called)
        for name in sorted(self.helpers & called.keys()):
            yield f"helper {called[name].shown} changed"

    # ---- streams
    def _old(self, stream: str) -> str:
        """Return the id that a stream of the first workbook has in the second; a marked one if it has none there."""
        if stream in self.found.streams.to:
            return self.found.streams.to[stream]
        if "!#" in stream or self.found.streams.of(stream).startswith("\0"):
            return f"{c.REMOVED}{stream}"
        return self.found.streams.of(stream)

    def _streams(
        self, rows: Iterable[ChangedRow], views: Mapping[tuple[str, int], RowView], first: Side, second: Side
    ) -> dict[str, ChangedStream]:
        """Return every stream that a row reads or writes, now or before, by id."""
        signs: dict[str, set[str]] = {}
        driven: set[str] = set()
        for row in rows:
            for link in (*row.takes, *row.gives):
                signs.setdefault(link.stream, set()).add(link.sign)
            view = views.get((row.sign, row.number)) or views.get(("", row.number))
            if view is not None and view.drives:
                driven |= {link.stream for link in row.gives}
        back = self.found.streams.back
        out = {}
        for stream, met in signs.items():
            sign = next(iter(met)) if len(met) == 1 and met < {c.ADDED, c.REMOVED} else c.SAME
            mine = back.get(stream, stream.removeprefix(c.REMOVED))
            side, there = (first, mine) if sign == c.REMOVED and stream not in second.streams else (second, stream)
            out[stream] = self._stream(stream, sign, _kind(side, there, stream in driven), (first, mine), (side, there))
        return out

    def _stream(
        self, stream: str, sign: str, kind: str, before: tuple[Side, str], now: tuple[Side, str]
    ) -> ChangedStream:
        name = same(now[0].shown(now[1]) if kind != "anonymous" else "")
        settings: tuple[tuple[str, ComparableText], ...] = ()
        if sign == c.SAME:
            was = before[0].streams.get(before[1])
            if stream in self.renamed:
                name = ComparableText(*self.renamed[stream])
            elif was is not None and key(was.name) != key(name.after) and kind != "anonymous":
                name = ComparableText(was.name or "unnamed", name.after)
            settings = tuple(self.settings.get(key(name.after), ())) if kind in ("sensor", "actuator") else ()
            sign = c.CHANGED if settings or name.changed else sign
        return ChangedStream(stream, kind, sign, name, settings)


def _links(old: Iterable[str], new: Iterable[str]) -> tuple[Link, ...]:
    before, after = dict.fromkeys(old), dict.fromkeys(new)
    kept = [Link(s, c.SAME if s in before else c.ADDED) for s in after]
    return (*kept, *(Link(s, c.REMOVED) for s in before if s not in after))


def _words(change: Change | None, text: str) -> ComparableText:
    if change is None:
        return same(text)
    return ComparableText(change.before, change.after, tuple((p.kind, p.text) for p in change.pieces))


def _kind(side: Side, stream: str, driven: bool) -> str:
    """Return the kind of a stream, derived from its device or id where the graph has refused it."""
    found = side.streams.get(stream)
    if found is not None:
        return found.kind.value
    if "!#" in stream:
        return "anonymous"
    view: DeviceView | None = side.devices.get(stream)
    if view is not None and view.found is not None:
        return view.found.type.kind
    return "actuator" if driven else "stream" if "!" in stream else "sensor"
