"""The order in which a scene happens, and what cannot happen in it: a thing that is not there, or there already."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rrp_sheets.devices.scene_amounts import ends
from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.names import key
from rrp_sheets.model.scene_actions import SceneAction
from rrp_sheets.model.workbook import SceneRow

MOST_THINGS = 100  # at once: more make the simulator slow, and nobody could tell them apart
WAITING_US = 10_000_000  # how long a row is taken to wait for its event, when nobody says how long a run shall be
_NEEDS = ("move", "circle", "away", "look", "disappear")  # verbs of things that must be there


def in_order(actions: Sequence[SceneAction]) -> tuple[SceneAction, ...]:
    """Actions in the order of their times; those that wait for an event as if it came at once.

    Args:
        actions: in the order of the sheet.
    """
    starts = _times(actions, 0)
    return tuple(actions[i] for i in sorted(range(len(actions)), key=lambda i: starts[i][0]))


def scene_end_us(actions: Sequence[SceneAction]) -> int:
    """Return when the last action is over; circling counts one round, and a row waits ten seconds at most."""
    rows = sorted(actions, key=lambda a: a.row)
    last = 0
    for action, (_, latest) in zip(rows, _times(rows, WAITING_US), strict=True):
        lasting = action.values.get("seconds") or action.values.get("period") or 0.0
        last = max(last, latest + math.ceil(ends(lasting)[1] * 1e6))
    return last


def _times(actions: Sequence[SceneAction], waiting_us: int) -> list[tuple[int, int]]:
    """Return the earliest and the latest beginning of each action, if a row waits so long for its event."""
    times: list[tuple[int, int]] = []
    for action in actions:
        early, late = times[-1] if action.cue and times else (0, 0)
        late += waiting_us if action.cue not in ("", "+") else 0
        times.append((early + action.time_us, late + action.time_us + action.span_us))
    return times


def check_presence(actions: Sequence[SceneAction], rows: Mapping[int, SceneRow], report: Report) -> None:
    """Report things that move before they have come, come twice, or stand on a table that is not there.

    Args:
        actions: in their order.
        rows: of the sheet, by number.
        report: takes the findings.
    """
    present: dict[str, str] = {}  # the kind of each thing that is there
    twice: set[str] = set()  # told once
    many = False
    for action in actions:
        name, row = key(action.thing), rows[action.row]
        they = action.what == "person"
        if action.verb in _NEEDS and name not in present:
            report.add("SCENE005", row.thing.address, thing=action.thing, are="they are" if they else "it is",
                       come="they enter" if they else "it appears")  # fmt: skip
            present[name] = action.what  # told once, and not that it comes twice
            twice.add(name)
        if action.verb == "appear" and name in present and name not in twice:
            twice.add(name)
            report.add("SCENE009", row.thing.address, thing=action.thing, are="they are" if they else "it is",
                       leave="them leave" if they else "it disappear")  # fmt: skip
        if action.values.get("on") == "table" and "table" not in present.values():
            report.add("SCENE010", row.value.address, thing=action.thing)
        if action.verb == "appear":
            present[name] = action.what
        elif action.verb == "disappear":
            present.pop(name, None)
        if len(present) > MOST_THINGS and not many:
            report.add("SCENE011", row.thing.address, most=MOST_THINGS)
            many = True
