"""Pairs the behaviours, rows, streams and helpers of two workbooks that correspond to each other."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field

from rrp_sheets.compare.pairing import Pairs
from rrp_sheets.compare.side import BehaviourView, RowView, Side
from rrp_sheets.compare.tokens import shape, shape_of
from rrp_sheets.model.names import key

_ALIKE = 0.55  # of 1: inputs 0.3, formula 0.35, connector 0.2, output 0.15
_SAME_SHEET = 0.5  # of its rows must a sheet with another name share


@dataclass
class StreamMap:
    """Mapping between the corresponding streams of two workbooks."""

    to: dict[str, str] = field(default_factory=dict)
    back: dict[str, str] = field(default_factory=dict)
    sheets: dict[str, str] = field(default_factory=dict)

    def add(self, a: str, b: str) -> None:
        """Record that two streams correspond, unless one of them already has a partner."""
        if a not in self.to and b not in self.back:
            self.to[a], self.back[b] = b, a

    def of(self, a: str) -> str:
        """Return the id that a stream has in the second workbook; an impossible one when that id is taken."""
        if a in self.to:
            return self.to[a]
        sheet, mark, name = a.partition("!")
        b = f"{self.sheets.get(sheet, sheet)}!{name}" if mark else a
        return f"\0{a}" if b in self.back else b

    def inverse(self) -> StreamMap:
        """Return the mapping from the second workbook to the first."""
        return StreamMap(self.back, self.to, {b: a for a, b in self.sheets.items()})


@dataclass
class Match:
    """Corresponding parts of two workbooks. `rows` has the pairs of rows for each pair of behaviours."""

    behaviours: Pairs
    rows: dict[tuple[int, int], Pairs]
    streams: StreamMap
    helpers: dict[str, str]
    turned: bool = False  # the second workbook was taken as the first, so that both ways round the same is found

    def inverse(self) -> Match:
        """Return the match from the second workbook to the first."""
        return Match(
            self.behaviours.inverse(),
            {(b, a): pairs.inverse() for (a, b), pairs in self.rows.items()},
            self.streams.inverse(),
            {b: a for a, b in self.helpers.items()},
            not self.turned,
        )

    def shape(self, a: RowView) -> Hashable:
        """Return the shape of the formula of a row of the first workbook, with the helpers' names of the second."""
        if not self.helpers or a.formula is None:
            return a.shape
        return shape_of(a.formula, len(a.inputs), self.helpers)

    def inputs(self, a: RowView) -> tuple[str, ...]:
        """Return the inputs of a row of the first workbook as streams of the second."""
        return tuple(self.streams.of(i) for i in a.inputs)


def match(first: Side, second: Side) -> Match:
    """Find the corresponding parts of two workbooks; swapping the workbooks gives the same pairs."""
    if first.reading.digest > second.reading.digest:
        return _match(second, first).inverse()
    return _match(first, second)


def _match(first: Side, second: Side) -> Match:
    behaviours = _behaviours(first.behaviours, second.behaviours)
    streams = StreamMap()
    for a, b in behaviours.to.items():
        streams.sheets[first.behaviours[a].key] = second.behaviours[b].key
    _devices(first, second, streams)
    found = Match(behaviours, {}, streams, _helpers(first, second))
    for a, b in sorted(behaviours.to.items()):
        found.rows[a, b] = _rows(first.behaviours[a].rows, second.behaviours[b].rows, found)
    return found


def _behaviours(first: Sequence[BehaviourView], second: Sequence[BehaviourView]) -> Pairs:
    pairs = Pairs(len(first), len(second))
    pairs.by_key(first, second, lambda b: b.key, lambda b: b.key)

    def said(b: BehaviourView) -> set[Hashable]:
        home = b.key + "!"
        return {(r.connector, r.row.formula.text, r.output.removeprefix(home)) for r in b.rows if r.row.output}

    def score(a: BehaviourView, b: BehaviourView) -> float:
        mine, other = said(a), said(b)
        return len(mine & other) / max(len(mine), len(other), 1)

    pairs.by_likeness(first, second, said, score, _SAME_SHEET)
    return pairs


def _devices(first: Side, second: Side, streams: StreamMap) -> None:
    """Map renamed device streams: those in one workbook only, with the same device and settings."""

    def by_meaning(mine: Side, other: Side, sheets: dict[str, str]) -> dict[tuple[object, ...], list[str]]:
        found: dict[tuple[object, ...], list[str]] = {}
        for k, device in mine.devices.items():
            if k not in other.devices and k not in other.streams:
                found.setdefault(device.meaning(sheets), []).append(k)
        return found

    here, there = by_meaning(first, second, streams.sheets), by_meaning(second, first, {})
    for meaning, names in here.items():
        for a, b in zip(sorted(names), sorted(there.get(meaning, ())), strict=False):
            streams.add(a, b)
    dones = {s.done_of: s.id for s in second.streams.values() if s.done_of}
    for stream in first.streams.values():
        if stream.done_of in streams.to and streams.to[stream.done_of] in dones:
            streams.add(stream.id, dones[streams.to[stream.done_of]])


def _helpers(first: Side, second: Side) -> dict[str, str]:
    """Return the new keys of renamed helpers by the old ones."""
    renamed: dict[str, str] = {}
    mine = {key(h.name.text) for h in first.workbook.helpers}
    other = {key(h.name.text) for h in second.workbook.helpers}
    gone, new = sorted(mine - other), sorted(other - mine)
    there = {meaning: k for k in new if (meaning := helper_meaning(second, k, {})) is not None}
    for _ in range(3):  # helpers that call helpers
        for k in gone:
            meaning = helper_meaning(first, k, renamed)
            if k not in renamed and meaning in there and there[meaning] not in renamed.values():
                renamed[k] = there[meaning]
    return renamed


def helper_meaning(side: Side, k: str, renamed: dict[str, str]) -> tuple[int, str] | None:
    """Return the number of a helper's inputs and the shape of its formula; None when they are not known."""
    helper = side.helpers.get(k)
    if helper is None or helper.tree is None:
        return None
    names = {p.name: str(i) for i, p in enumerate(helper.parameters)}
    return len(names), shape(helper.tree, names, renamed)


def _rows(first: Sequence[RowView], second: Sequence[RowView], found: Match) -> Pairs:
    """Pair rows: equal ones, then by their output, then those of one meaning, then those that are similar."""
    pairs = Pairs(len(first), len(second))
    pairs.by_key(first, second, lambda r: r.deep, lambda r: r.deep)
    for a, b in pairs.to.items():
        _same_output(first[a], second[b], found.streams)

    def along(of_first: Callable[[RowView], Hashable], of_second: Callable[[RowView], Hashable]) -> None:
        waiting: dict[Hashable, list[int]] = {}
        for b in reversed(pairs.right):
            waiting.setdefault(of_second(second[b]), []).append(b)
        for a in sorted(pairs.left, key=lambda i: (first[i].step.rank if first[i].step else i, i)):  # type: ignore[union-attr]
            queue = waiting.get(of_first(first[a]))
            if queue:
                b = queue.pop()
                pairs.add(a, b)
                _same_output(first[a], second[b], found.streams)

    def by_meaning() -> None:
        along(lambda r: (r.connector, found.inputs(r), found.shape(r)), lambda r: (r.connector, r.inputs, r.shape))

    streams = found.streams
    along(
        lambda r: (r.connector, found.inputs(r), found.shape(r), _named(streams.of(r.output))),
        lambda r: (r.connector, r.inputs, r.shape, _named(r.output)),
    )
    before = dict(pairs.to), dict(pairs.back), dict(streams.to), dict(streams.back)
    by_meaning()
    if pairs.left or pairs.right:  # not all rows are the same under other names: then a name says more than a meaning
        pairs.to, pairs.back, streams.to, streams.back = before
    taken = len(pairs.to)
    pairs.by_key(
        first, second,
        lambda r: None if r.drives or not r.row.output else streams.of(r.output),
        lambda r: None if r.drives or not r.row.output else r.output,
    )  # fmt: skip
    for a, b in list(pairs.to.items())[taken:]:
        _same_output(first[a], second[b], streams)
    by_meaning()
    taken = len(pairs.to)
    pairs.by_likeness(first, second, _features, lambda a, b: _likeness(a, b, streams), _ALIKE)
    for a, b in list(pairs.to.items())[taken:]:
        _same_output(first[a], second[b], streams)
    return pairs


def _named(stream: str) -> str:
    return "" if "!#" in stream else stream


def _same_output(a: RowView, b: RowView, streams: StreamMap) -> None:
    if not a.drives and not b.drives:
        streams.add(a.output, b.output)


def _features(row: RowView) -> list[Hashable]:
    texts = (row.row.inputs_cell.text, row.row.formula.text, row.row.output.text, row.row.notes)
    return [(i, key(text)) for i, text in enumerate(texts) if text]


def _likeness(a: RowView, b: RowView, streams: StreamMap) -> float:
    """Score the likeness of two rows, from 0 to 1."""
    if a.row.inputs and b.row.inputs:
        mine, other = {streams.of(i) for i in a.inputs}, set(b.inputs)
        inputs = len(mine & other) / max(len(mine | other), 1)
    else:
        inputs = float(bool(a.row.inputs) == bool(b.row.inputs))
    total = len(a.tokens) + len(b.tokens)
    formula = 2 * len(a.tokens & b.tokens) / total if total else 1.0
    output = float(streams.of(a.output) == b.output or key(a.row.output.text) == key(b.row.output.text))
    return 0.3 * inputs + 0.35 * formula + 0.2 * (a.connector == b.connector) + 0.15 * output
