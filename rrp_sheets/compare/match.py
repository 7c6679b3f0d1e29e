"""Pairs the behaviours, rows, streams and helpers of two workbooks that correspond to each other."""

from __future__ import annotations

import bisect
import difflib
from collections import defaultdict, deque
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeVar

from rrp_sheets.compare.changes import shape, shape_of
from rrp_sheets.compare.side import BehaviourView, RowView, Side
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

    def cue(self, a: str) -> str:
        """Return the id, in the second workbook, of a stream that the scene waits for; no row may read it."""
        actuator = a.removesuffix("done")
        return f"{self.to[actuator]}done" if a not in self.to and actuator != a and actuator in self.to else self.of(a)

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
    turned: bool = False  # the workbooks were exchanged, so that the result does not depend on their order

    def inverse(self) -> Match:
        """Return the match from the second workbook to the first."""
        rows = {(b, a): pairs.inverse() for (a, b), pairs in self.rows.items()}
        helpers = {b: a for a, b in self.helpers.items()}
        return Match(self.behaviours.inverse(), rows, self.streams.inverse(), helpers, not self.turned)

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
    streams = StreamMap(sheets={first.behaviours[a].key: second.behaviours[b].key for a, b in behaviours.to.items()})
    _devices(first, second, streams)
    found = Match(behaviours, {}, streams, _helpers(first, second))
    for a, b in sorted(behaviours.to.items()):
        found.rows[a, b] = _rows(first.behaviours[a].rows, second.behaviours[b].rows, found)
    return found


def _behaviours(first: Sequence[BehaviourView], second: Sequence[BehaviourView]) -> Pairs:
    pairs = Pairs(len(first), len(second))
    pairs.by_key(first, second, lambda b: b.key)

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
    pairs, streams = Pairs(len(first), len(second)), found.streams

    def add_outputs() -> None:  # of all pairs: adding one again changes nothing
        for a, b in pairs.to.items():
            _same_output(first[a], second[b], streams)

    pairs.by_key(first, second, lambda r: r.deep)
    add_outputs()

    def along(of_first: Callable[[RowView], Hashable], of_second: Callable[[RowView], Hashable]) -> None:
        waiting: dict[Hashable, list[int]] = {}
        for b in reversed(pairs.right):
            waiting.setdefault(of_second(second[b]), []).append(b)
        for a in sorted(pairs.left, key=lambda i: (first[i].step.rank if first[i].step else i, i)):  # type: ignore[union-attr]
            if queue := waiting.get(of_first(first[a])):
                b = queue.pop()
                pairs.add(a, b)
                _same_output(first[a], second[b], streams)

    def by_meaning() -> None:
        along(lambda r: (r.connector, found.inputs(r), found.shape(r)), lambda r: (r.connector, r.inputs, r.shape))

    along(
        lambda r: (r.connector, found.inputs(r), found.shape(r), _named(streams.of(r.output))),
        lambda r: (r.connector, r.inputs, r.shape, _named(r.output)),
    )
    before = dict(pairs.to), dict(pairs.back), dict(streams.to), dict(streams.back)
    by_meaning()
    if pairs.left or pairs.right:  # not all rows are the same under other names: then a name says more than a meaning
        pairs.to, pairs.back, streams.to, streams.back = before
    pairs.by_key(
        first, second,
        lambda r: None if r.drives or not r.row.output else streams.of(r.output),
        lambda r: None if r.drives or not r.row.output else r.output,
    )  # fmt: skip
    add_outputs()
    by_meaning()
    pairs.by_likeness(first, second, _features, lambda a, b: _likeness(a, b, streams), _ALIKE)
    add_outputs()
    return pairs


def _named(stream: str) -> str:
    return "" if "!#" in stream else stream


def _same_output(a: RowView, b: RowView, streams: StreamMap) -> None:
    if not a.drives and not b.drives:
        streams.add(a.output, b.output)


def _features(row: RowView) -> list[Hashable]:
    texts = enumerate((row.row.inputs_cell.text, row.row.formula.text, row.row.output.text))
    return [(place, key(text)) for place, text in (*texts, *row.row.remarks.items()) if text]


def _likeness(a: RowView, b: RowView, streams: StreamMap) -> float:
    if a.row.inputs and b.row.inputs:
        mine, other = {streams.of(i) for i in a.inputs}, set(b.inputs)
        inputs = len(mine & other) / max(len(mine | other), 1)
    else:
        inputs = float(bool(a.row.inputs) == bool(b.row.inputs))
    total = len(a.tokens) + len(b.tokens)
    formula = 2 * len(a.tokens & b.tokens) / total if total else 1.0
    output = float(streams.of(a.output) == b.output or key(a.row.output.text) == key(b.row.output.text))
    return 0.3 * inputs + 0.35 * formula + 0.2 * (a.connector == b.connector) + 0.15 * output


A = TypeVar("A")

_CANDIDATES = 10  # looked at for each thing: the nearest of those that share something with it
_NEAR = 2
_MOST_ORDERED = 400  # things that are compared each with each


class Pairs:
    """Pairs of indexes into two lists, found in several passes."""

    def __init__(self, first: int, second: int) -> None:
        self.to: dict[int, int] = {}
        self.back: dict[int, int] = {}
        self._sizes = (first, second)

    def add(self, a: int, b: int) -> None:
        """Pair an index of the first list with one of the second."""
        self.to[a], self.back[b] = b, a

    def inverse(self) -> Pairs:
        """Return the same pairs, from the second list to the first."""
        other = Pairs(self._sizes[1], self._sizes[0])
        other.to, other.back = self.back, self.to
        return other

    @property
    def left(self) -> list[int]:
        """Indexes of the first list that have no partner yet."""
        return [i for i in range(self._sizes[0]) if i not in self.to]

    @property
    def right(self) -> list[int]:
        """Indexes of the second list that have no partner yet."""
        return [i for i in range(self._sizes[1]) if i not in self.back]

    def by_key(
        self, first: Sequence[A], second: Sequence[A], of_first: Callable[[A], Hashable],
        of_second: Callable[[A], Hashable] | None = None,
    ) -> None:  # fmt: skip
        """Pair elements with the same key, in order; a key of None pairs nothing."""
        waiting: dict[Hashable, deque[int]] = defaultdict(deque)
        for j in self.right:
            if (k := (of_second or of_first)(second[j])) is not None:
                waiting[k].append(j)
        for i in self.left:
            if queue := waiting.get(of_first(first[i])):
                self.add(i, queue.popleft())

    def in_order(self, first: Sequence[Hashable], second: Sequence[Hashable]) -> None:
        """Pair equal elements at the beginning and at the end, and between them those in the same order."""
        begin, end = 0, 0
        least = min(len(first), len(second))
        while begin < least and first[begin] == second[begin]:
            self.add(begin, begin)
            begin += 1
        while end < least - begin and first[-1 - end] == second[-1 - end]:
            end += 1
            self.add(len(first) - end, len(second) - end)
        a, b = first[begin : len(first) - end], second[begin : len(second) - end]
        if max(len(a), len(b)) > _MOST_ORDERED:
            return
        for block in difflib.SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks():
            for n in range(block.size):
                self.add(begin + block.a + n, begin + block.b + n)

    def between(self, alike: Callable[[int, int], bool]) -> None:
        """Pair, by position, elements between the same partners: a single one, or those that `alike` accepts."""
        for (i, j), (k, m) in pairwise([(-1, -1), *sorted(self.to.items()), self._sizes]):
            for n in range(1, k - i) if k - i == m - j else ():
                if (k - i == 2 or alike(i + n, j + n)) and i + n not in self.to and j + n not in self.back:
                    self.add(i + n, j + n)

    def by_likeness(
        self, first: Sequence[A], second: Sequence[A], features: Callable[[A], Iterable[Hashable]],
        score: Callable[[A, A], float], least: float,
    ) -> None:  # fmt: skip
        """Pair similar elements, the most similar first; only those that share a feature or stand near are scored."""
        left, right = self.left, self.right
        if not left or not right:
            return
        places: dict[Hashable, list[int]] = defaultdict(list)  # places within `right`, ascending
        for place, j in enumerate(right):
            for feature in features(second[j]):
                places[feature].append(place)
        found: list[tuple[float, int, int, int]] = []
        for place, i in enumerate(left):
            here = place * len(right) // len(left)
            near = set(range(max(0, here - _NEAR), min(len(right), here + _NEAR + 1)))
            for feature in features(first[i]):
                found_at = places.get(feature, ())
                middle = bisect.bisect_left(found_at, here)
                start = max(0, min(middle - _CANDIDATES // 2, len(found_at) - _CANDIDATES))
                near.update(found_at[start : start + _CANDIDATES])
            for other in near:
                alike = score(first[i], second[right[other]])
                if alike >= least:
                    found.append((-alike, abs(other - here), i, right[other]))
        for _, _, i, j in sorted(found):
            if i not in self.to and j not in self.back:
                self.add(i, j)

    def moved(self, turned: bool = False) -> set[int]:
        """Return the indexes of the first list whose partners changed their order among the others' partners."""
        return changed_order(((i, j, i) for i, j in self.to.items()), turned)


def changed_order(ranked: Iterable[tuple[int, int, A]], turned: bool) -> set[A]:
    """Return the fewest names without which all others keep their order; each comes with its rank before and after.

    With `turned` it looks from after to before. Of two that were swapped one has moved: it is to be the same one
    whichever list is the first.
    """
    ordered = sorted((after, before, name) if turned else (before, after, name) for before, after, name in ranked)
    return out_of_order([name for _, _, name in ordered], [place for _, place, _ in ordered])


def out_of_order(names: Sequence[A], places: Sequence[int]) -> set[A]:
    """Return the fewest names without which the places ascend.

    >>> sorted(out_of_order("abcd", [0, 2, 3, 1]))
    ['d']
    """
    tails: list[int] = []  # the last place of the best run of each length
    at: list[int] = []  # and whose it is
    before: list[int] = [-1] * len(places)
    for i, place in enumerate(places):
        length = bisect.bisect_left(tails, place)
        before[i] = at[length - 1] if length else -1
        if length == len(tails):
            tails.append(place)
            at.append(i)
        else:
            tails[length], at[length] = place, i
    keep: set[int] = set()
    i = at[-1] if at else -1
    while i >= 0:
        keep.add(i)
        i = before[i]
    return {name for i, name in enumerate(names) if i not in keep}
