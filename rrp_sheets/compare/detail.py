"""Changed behaviours as they are drawn, and changes of sheets that are lists: scene, tests and tables."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial

from rrp_sheets.compare.changes import Change, as_typed, helpers_in, one_sided
from rrp_sheets.compare.match import Match, Pairs, changed_order
from rrp_sheets.compare.rows import WRITTEN, in_sheet_order
from rrp_sheets.compare.side import BehaviourView, RowView, Side, different
from rrp_sheets.formulas import HelperDef
from rrp_sheets.formulas.tables import value_of
from rrp_sheets.model import changed as c
from rrp_sheets.model.changed import ChangedBehaviour, ChangedRow, ChangedStream, ComparableText, Link, same
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Cell, TestRow
from rrp_sheets.texts import N_
from rrp_sheets.workbook.cleaning import clean_name

_SHOWN = frozenset(("changed", "on", "off"))  # kinds that make a row a changed one
_BLANK = N_("blank")


def detail(first: Side, second: Side, found: Match, changes: Sequence[Change]) -> tuple[ChangedBehaviour, ...]:
    """Return the behaviours in which something changed, in the order of the second workbook, then the removed ones."""
    builder = _BehaviourBuilder(first, second, found, changes)
    out = []
    for b, behaviour in enumerate(second.behaviours):
        a = found.behaviours.back.get(b)
        out.append(builder.alone(behaviour, c.ADDED) if a is None else builder.both(a, b))
    out += [builder.alone(first.behaviours[a], c.REMOVED) for a in found.behaviours.left]
    return tuple(b for b in out if b.rows and (any(r.sign for r in b.rows) or any(s.sign for s in b.streams.values())))


class _BehaviourBuilder:
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
        side = self.second if sign == c.ADDED else self.first
        rows = [(self._one_sided(view, sign), view.drives) for view in behaviour.rows]
        return ChangedBehaviour(behaviour.name, sign, tuple(row for row, _ in rows), self._streams(rows, side, side))

    def both(self, a: int, b: int) -> ChangedBehaviour:
        old, new = self.first.behaviours[a], self.second.behaviours[b]
        rows: list[tuple[ChangedRow, bool]] = []
        for mine, now in in_sheet_order(old.rows, new.rows, self.found.rows[a, b]):
            if mine is not None and now is not None:
                rows.append((self._pair(mine, now), now.drives))
            elif now is not None:
                rows.append((self._one_sided(now, c.ADDED), now.drives))
            elif mine is not None:
                rows.append((self._one_sided(mine, c.REMOVED), mine.drives))
        streams = self._streams(rows, self.first, self.second)
        return ChangedBehaviour(new.name, c.SAME, tuple(row for row, _ in rows), streams)

    # ---- rows
    def _one_sided(self, view: RowView, sign: str) -> ChangedRow:
        def words(text: str) -> ComparableText:
            return ComparableText("", text) if sign == c.ADDED else ComparableText(text, "")

        ident = self._old if sign == c.REMOVED else str
        row, number = view.row, view.row.number
        takes = tuple(Link(ident(i), sign) for i in dict.fromkeys(view.inputs))
        return ChangedRow(
            sign, number, number if sign == c.REMOVED else 0, words(row.inputs_cell.text), words(row.connector.text),
            words(row.formula.text), words(row.output.text), takes, (Link(ident(view.output), sign),),
            () if row.on else (N_("switched off"),), off=not row.on,
        )  # fmt: skip

    def _pair(self, a: RowView, b: RowView) -> ChangedRow:
        found = self.rows.get((key(b.sheet), a.row.number, b.row.number), [])
        cells = {change.field: change for change in found if change.kind == "changed"}
        remarks = tuple(self._remarks(a, b, found, cells))
        moved = any(change.kind == "moved" and change.effect for change in found)
        sign = c.CHANGED if remarks or moved or any(change.kind in _SHOWN for change in found) else c.SAME
        row = b.row
        return ChangedRow(
            sign, row.number, a.row.number, _words(cells.get("inputs"), row.inputs_cell.text),
            _words(cells.get("connector"), row.connector.text), _words(cells.get("formula"), row.formula.text),
            _words(cells.get("output"), row.output.text), _links([self._old(i) for i in a.inputs], b.inputs),
            _links([self._old(a.output)], [b.output]), remarks, off=not row.on,
        )  # fmt: skip

    def _remarks(self, a: RowView, b: RowView, found: Iterable[Change], cells: Mapping[str, Change]) -> Iterable[str]:
        for change in found:
            if change.kind in ("on", "off"):
                yield N_("switched on") if change.kind == "on" else N_("switched off")
            elif change.kind == "moved" and change.effect:
                yield N_("moved, was row {n}", n=a.row.number)
        if priority := cells.get("priority"):
            yield N_("priority {before} → {after}", before=priority.before, after=priority.after)
        if cells and not (a.row.on or b.row.on):
            yield N_("off in both")
        called: dict[str, HelperDef] = {}
        if b.formula is not None and self.helpers:
            helpers_in(b.formula.tree, called)
        for name in sorted(self.helpers & called.keys()):
            yield N_("helper {name} changed", name=called[name].shown)

    # ---- streams
    def _old(self, stream: str) -> str:
        """Return the id that a stream of the first workbook has in the second; a marked one if it has none there."""
        now = self.found.streams.of(stream)
        if stream not in self.found.streams.to and ("!#" in stream or now.startswith("\0")):
            return f"{c.REMOVED}{stream}"
        return now

    def _streams(self, rows: Iterable[tuple[ChangedRow, bool]], first: Side, second: Side) -> dict[str, ChangedStream]:
        """Return every stream that a row reads or writes, now or before, by id; with each row whether it drives."""
        signs: dict[str, set[str]] = {}
        driven: set[str] = set()
        for row, drives in rows:
            for link in (*row.takes, *row.gives):
                signs.setdefault(link.stream, set()).add(link.sign)
            if drives:
                driven |= {link.stream for link in row.gives}
        out = {}
        for stream, met in signs.items():
            sign = next(iter(met)) if len(met) == 1 and met < {c.ADDED, c.REMOVED} else c.SAME
            mine = self.found.streams.back.get(stream, stream.removeprefix(c.REMOVED))
            side, there = (first, mine) if sign == c.REMOVED and stream not in second.streams else (second, stream)
            kind = _kind(side, there, stream in driven)
            name = same(side.shown(there) if kind != "anonymous" else "")
            settings: tuple[tuple[str, ComparableText], ...] = ()
            if sign == c.SAME:
                was = first.streams.get(mine)
                if stream in self.renamed:
                    name = ComparableText(*self.renamed[stream])
                elif was is not None and key(was.name) != key(name.after) and kind != "anonymous":
                    name = ComparableText(was.name or N_("unnamed"), name.after)
                settings = tuple(self.settings.get(key(name.after), ())) if kind in ("sensor", "actuator") else ()
                sign = c.CHANGED if settings or name.changed else sign
            out[stream] = ChangedStream(stream, kind, sign, name, settings)
        return out


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
    if (view := side.devices.get(stream)) is not None and view.found is not None:
        return view.found.type.kind
    return "actuator" if driven else "stream" if "!" in stream else "sensor"


_HALF = 0.5
RISK = N_("for people; the robot ignores it")
TEST = N_("a test only checks the behaviour and does not change it")


@dataclass(frozen=True)
class ListRow:
    """Row of a list: the meaning and the text of each cell, by the cell's name."""

    sheet: str
    row: int
    meaning: Mapping[str, Hashable]
    said: Mapping[str, str]
    remarks: Mapping[str, str] = field(default_factory=dict)
    time: float = 0.0

    @property
    def whole(self) -> tuple[tuple[str, Hashable], ...]:
        """Meanings of all cells, to compare whole rows."""
        return tuple(self.meaning.items())

    def part(self, names: Sequence[str]) -> Hashable:
        """Return the meanings of some cells."""
        return tuple(self.meaning.get(n, "") for n in names)


@dataclass(frozen=True)
class ListKind:
    """Rules by which rows of one kind of sheet are paired and their changes reported.

    Attributes:
        keys: cells that together tell a line from others, the best first.
        effect: whether a change alters the behaviour.
        note: why it does not.
        ordered: whether the order of the lines matters.
        names: of cells, in words; a cell that has none is called as in `ListRow.said`.
    """

    part: str
    keys: Sequence[tuple[str, ...]]
    effect: bool = True
    note: str = ""
    ordered: bool = False
    names: Mapping[str, str] = field(default_factory=dict)


def scene_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the scene: what happens in the simulated world, and when."""
    kind = ListKind(
        "scene", (("time", "thing", "does"), ("thing", "does", "value"), ("time", "thing"), ("thing", "does")),
        names={"time": N_("time"), "thing": N_("thing"), "does": N_("does"), "value": N_("value")},
    )  # fmt: skip
    old, new = _scene(first, found.streams.cue), _scene(second, lambda cue: cue)
    if not old and not new:  # a scene without rows is an empty world, none at all is the default scene
        if (first.workbook.scene is None) == (second.workbook.scene is None):
            return []
        return [one_sided("removed" if second.workbook.scene is None else "added", "sheet", "Scene", N_("empty"))]
    out, pairs = list_changes(old, new, kind, found.turned)
    places = [{i: n for n, i in enumerate(sorted(range(len(s)), key=lambda i: (s[i].time, i)))} for s in (old, new)]
    ranked = [(places[0][i], places[1][j], (i, j)) for i, j in pairs.to.items()]  # in the order of the times
    for i, j in sorted(changed_order(ranked, found.turned), key=lambda pair: places[0][pair[0]]):
        if old[i].time == new[j].time:  # else its time is told
            note = N_("of several events at the same time, another comes first")
            out.append(_change(kind, "moved", old[i], new[j], note=note))
    return out


def _scene(side: Side, rename: Callable[[str], str]) -> list[ListRow]:
    actions = {a.row: a for a in side.checked.scene or ()}
    lines = []
    for row in side.workbook.scene or ():
        cells = {"time": row.time, "thing": row.thing, "does": row.does, "value": row.value}
        place = row.thing.address
        us = parse_duration(row.time.text, bare="s")
        meaning: dict[str, Hashable] = {n: key(c.text) for n, c in cells.items()}
        action = actions.get(place.row)
        if action is not None:
            rest = {f.name: getattr(action, f.name) for f in fields(action) if f.name not in ("thing", "row", "kind")}
            verb, values = rest.pop("verb"), rest.pop("values")
            rest["cue"] = rename(action.cue)
            meaning |= {"time": repr(rest), "does": verb, "value": repr(sorted(values.items()))}
        time = us / 1e6 if us is not None else math.inf
        lines.append(_list_row(side, place.sheet, place.row, meaning, cells, time))
    return lines


def _list_row(
    side: Side, sheet: str, row: int, meaning: Mapping[str, Hashable], cells: Mapping[str, Cell], time: float = 0.0
) -> ListRow:
    return ListRow(sheet, row, meaning, {n: c.typed for n, c in cells.items()}, side.remarks_of(sheet, row), time)


def gesture_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the user's own gestures."""
    kind = ListKind("gesture", (("name", "time"), ("name",)), names={"name": N_("name"), "time": N_("time")})
    return list_changes(_gestures(first), _gestures(second), kind, found.turned)[0]


def risk_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the sheet Risks, on which the robot does not act."""
    names = {"risk": N_("risk"), "whom": N_("for whom"), "likely": N_("how likely"), "reduces": N_("what reduces it"),
             "ends": N_("who ends the session when")}  # fmt: skip
    kind = ListKind("risk", (("risk",),), effect=False, note=RISK, names=names)
    return list_changes(_risks(first), _risks(second), kind, found.turned)[0]


def _risks(side: Side) -> list[ListRow]:
    lines = []
    for row in side.workbook.risks.rows if side.workbook.risks else ():
        place = row.risk.address
        cells = {"risk": row.risk, "whom": row.whom, "likely": row.likely, "reduces": row.reduces, "ends": row.ends}
        lines.append(_list_row(side, place.sheet, place.row, {n: key(c.text) for n, c in cells.items()}, cells))
    return lines


def _gestures(side: Side) -> list[ListRow]:
    lines = []
    for row in side.workbook.gestures:
        meaning: dict[str, Hashable] = {"name": key(row.name.text), "time": _duration(row.time, "s")}
        meaning |= {k: _angle(c.text) for k, c in sorted(row.joints.items())}
        place = row.name.address
        cells = {"name": row.name, "time": row.time, **row.joints}
        lines.append(_list_row(side, place.sheet, place.row, meaning, cells))
    return lines


def _duration(cell: Cell, bare: str) -> Hashable:
    us = parse_duration(cell.text, bare=bare)
    return key(cell.text) if us is None else us


def _angle(text: str) -> Hashable:
    bare = text.strip().removesuffix("rad").strip().replace("−", "-")
    try:
        value = float(bare.removesuffix("°"))
    except ValueError:
        return key(text)
    return round(math.radians(value) if bare.endswith("°") else value, 9)


def test_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the test sheets, which never alter the behaviour."""
    kind = ListKind(
        "test", (("time", "stream", "send"), ("time", "stream"), ("stream", "send", "expect"), ("time", "expect")),
        effect=False, note=TEST,
        names={"time": N_("time"), "stream": N_("stream"), "send": N_("send"), "expect": N_("expect")},
    )  # fmt: skip
    old, new = ({key(t.name): t for t in side.workbook.tests} for side in (first, second))
    out: list[Change] = []
    for k in dict.fromkeys([*new, *old]):
        mine, other = old.get(k), new.get(k)
        if mine is None or other is None:
            word, sheet = ("added", new[k]) if mine is None else ("removed", mine)
            count = N_("{n} rows", n=len(sheet.rows))
            out.append(one_sided(word, "sheet", sheet.name, count, effect=False, note=TEST))
        lines = [_test(mine.name, r, found.streams.of, first) for r in mine.rows] if mine else []
        now = [_test(other.name, r, lambda s: s, second) for r in other.rows] if other else []
        out += list_changes(lines, now, kind, found.turned)[0]
    return out


def _test(sheet: str, row: TestRow, rename: Callable[[str], str], side: Side) -> ListRow:
    cells = {"time": row.time, "stream": row.stream, "send": row.send, "expect": row.expect}
    home, mark, name = row.stream.text.partition("!")
    stream = f"{key(home)}!{key(name)}" if mark else key(home)
    if not mark and stream not in side.streams:  # an ordinary stream without its sheet: that of the first that has it
        stream = next((i for i in side.streams if i.endswith(f"!{stream}") and "!#" not in i), stream)
    meaning: dict[str, Hashable] = {
        "time": _duration(row.time, "ms"), "stream": rename(stream), "send": as_typed(row.send.text),
        "expect": as_typed(row.expect.text),
    }  # fmt: skip
    return _list_row(side, sheet, row.time.address.row, meaning, cells)


def table_changes(first: Side, second: Side, found: Match) -> list[Change]:
    """Return the changes of the user's own sheets that formulas name as tables."""
    out: list[Change] = []
    old, new = first.workbook.tables, second.workbook.tables
    names = {key(n): n for side in (first, second) for n in side.workbook.sheets}
    for k in dict.fromkeys([*new, *old]):
        name = names.get(k, k)
        if k not in old or k not in new:
            word, table = ("added", new[k]) if k in new else ("removed", old[k])
            out.append(one_sided(word, "table", name, N_("{n} rows", n=max(len(table) - 1, 0))))
        else:
            out += _table(name, old[k], new[k], found.turned)
    return out


def _table(name: str, old: Sequence[Sequence[str]], new: Sequence[Sequence[str]], turned: bool) -> list[Change]:
    heads = [tuple(table[0]) if table else () for table in (old, new)]
    kind = ListKind("table", (tuple(key(h) for h in heads[1][:1]),), ordered=True)
    out, _ = list_changes(_table_lines(name, old, heads[0]), _table_lines(name, new, heads[1]), kind, turned)
    mine, other = ([key(h) for h in head] for head in heads)
    if mine != other:
        before, after = (", ".join(h) for h in heads)
        out.insert(0, Change("changed", "table", name, rows=(1, 1), what=N_("columns"), before=before, after=after))
    return out


def _table_lines(name: str, table: Sequence[Sequence[str]], head: Sequence[str]) -> list[ListRow]:
    keys = [key(h) or f"column {i}" for i, h in enumerate(head, 1)]
    lines = []
    for number, row in enumerate(table[1:], 2):
        said = dict(zip(keys, row, strict=False))
        lines.append(ListRow(name, number, {k: _value(t) for k, t in said.items()}, said))
    return lines


def _value(text: str) -> Hashable:
    """Return what formulas get of a table's cell; a truth value as a text, since 1 and TRUE are equal in Python."""
    value = value_of(text)
    if value is None:
        return ""
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)


# ---- any list
def list_changes(
    old: Sequence[ListRow], new: Sequence[ListRow], kind: ListKind, turned: bool
) -> tuple[list[Change], Pairs]:
    """Return the changes of a list and the pairs of its rows; swapping the lists gives the same pairs."""
    pairs = _pair(new, old, kind).inverse() if turned else _pair(old, new, kind)
    moved = pairs.moved(turned) if kind.ordered else set()
    placed = [(new[j].row, 1, _line(kind, old[i], new[j], i in moved)) for i, j in pairs.to.items()]
    placed += [(new[j].row, 1, [_one_sided(kind, "added", new[j])]) for j in pairs.right]
    placed += [(old[i].row, 2, [_one_sided(kind, "removed", old[i])]) for i in pairs.left]
    placed.sort(key=lambda entry: entry[:2])
    return [change for _, _, found in placed for change in found], pairs


def _pair(old: Sequence[ListRow], new: Sequence[ListRow], kind: ListKind) -> Pairs:
    pairs = Pairs(len(old), len(new))
    if kind.ordered:
        pairs.in_order([n.whole for n in old], [n.whole for n in new])
    pairs.by_key(old, new, lambda n: n.whole)
    if kind.ordered:
        pairs.between(lambda i, j: _alike(old[i], new[j]) >= _HALF)
    for names in filter(None, kind.keys):
        pairs.by_key(old, new, partial(ListRow.part, names=names))
    pairs.by_likeness(old, new, lambda n: [e for e in n.whole if e[1] not in ("", ())], _alike, _HALF)
    return pairs


def _alike(a: ListRow, b: ListRow) -> float:
    names = {**a.meaning, **b.meaning}
    filled = [n for n in names if a.meaning.get(n) or b.meaning.get(n)]
    return sum(a.meaning.get(n) == b.meaning.get(n) for n in filled) / max(len(filled), 1)


def _line(kind: ListKind, a: ListRow, b: ListRow, moved: bool) -> list[Change]:
    out = []
    for n in dict.fromkeys([*a.said, *b.said]):
        name = kind.names.get(n, n)
        before, after = a.said.get(n, ""), b.said.get(n, "")
        if a.meaning.get(n, "") != b.meaning.get(n, ""):
            out.append(_change(kind, "changed", a, b, name, before, after))
        elif clean_name(before) != clean_name(after):
            out.append(_change(kind, "written", a, b, name, before, after, note=WRITTEN))
    if moved and a.row != b.row:
        out.append(_change(kind, "moved", a, b))
    out += [_change(kind, "notes", a, b, *told) for told in different(a.remarks, b.remarks)]
    return out


def _change(kind: ListKind, word: str, a: ListRow, b: ListRow, what: str = "", before: str = "", after: str = "",
            note: str = "") -> Change:  # fmt: skip
    effect = kind.effect and word not in ("written", "notes")
    note = note or ("" if effect or word == "notes" else kind.note)
    return Change(word, kind.part, b.sheet, "", (a.row, b.row), what, before, after, effect, note)


def _one_sided(kind: ListKind, word: str, row: ListRow) -> Change:
    note = "" if kind.effect else kind.note
    return one_sided(word, kind.part, row.sheet, " | ".join(row.said.values()), row.row, kind.effect, note)
