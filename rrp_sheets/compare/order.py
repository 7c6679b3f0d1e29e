"""Where the order of rows has an effect.

Rows are a graph: what a row gets does not depend on where it stands. Order matters only between rows that drive the
same actuator, or the same part of the robot, with the same priority: of two commands of one instant the later has the
last word. Engines other than `frame` work on events in the order of the rows, so there every row's place matters.
"""

from __future__ import annotations

from collections import defaultdict

from rrp_sheets.compare.match import Match
from rrp_sheets.compare.pairing import out_of_order
from rrp_sheets.compare.side import RowView, Side
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.names import key

_Place = tuple[str, int]  # a behaviour's key and a row's number, in the second workbook
_Both = tuple[RowView, RowView, _Place]


def reordered(first: Side, second: Side, found: Match) -> dict[_Place, str]:
    """The rows whose order among others has changed with an effect, and what the effect is."""
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
            out[place] = Phrase("of two commands for {name} in one instant another one comes last now", name=name)
    if key(second.workbook.protocol.text("Engine", "frame")) != "frame":
        for place in _late(rows, found.turned):
            out.setdefault(place, "this engine works in the order of the rows")
    return out


def _late(rows: list[_Both], turned: bool) -> set[_Place]:
    """The places of the fewest rows without which all act in the order in which they did."""
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
    """What a command for an actuator stream needs: the stream itself, and the parts of the robot."""
    found = side.streams.get(stream)
    if found is None or found.device is None:
        return {stream}
    return {stream, *found.device.type.resources_for(found.settings)}
