"""The Scene sheet: what its rows may say, and what they mean (design: 5-robot, Scenes).

| Thing | Does | Value |
|---|---|---|
| a colour and `ball` | appears | `at 1, 0.2, 0.4` and, if not 6 cm, `size 10 cm` |
| | moves | `to 0.5, 0, 0.4 in 2 s` |
| | circles | `radius 0.3 period 4 s`, with `around 0.8, 0, 0.4`, and `flat` for a level circle |
| | disappears | |
| `Person`, `Child` or a name | enters | `at 1, 0` or `at 1, 0, 0.62` (height of the face), with `name Emma`, `id 2` |
| | moves, leaves | as for a ball |
| | looks away, looks back | |
| | is seen | `id, name, seconds`: in view, 1 m in front, for that long; a name makes the person known |
| | touches, says | a zone of the robot; a word |
| `Operator` | presses | a button's label |
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping, Sequence

from rrp_sheets.devices.catalogue import Robot
from rrp_sheets.devices.scene_values import BadValueError, read_value
from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.workbook import SceneRow

BALL_COLOURS = (
    "red", "green", "blue", "yellow", "orange", "pink", "purple", "violet", "magenta", "cyan", "turquoise", "brown",
    "white", "black", "grey",
)  # fmt: skip
PERSONS = ("Person", "Child", "Adult", "Visitor", "Therapist", "Parent")
OPERATOR = "Operator"
_VERBS: Mapping[str, Mapping[str, str]] = {
    "ball": {"appears": "appear", "moves": "move", "circles": "circle", "disappears": "disappear"},
    "person": {
        "enters": "appear", "appears": "appear", "moves": "move", "leaves": "disappear", "disappears": "disappear",
        "looks away": "away", "looks back": "look", "looks at the robot": "look", "is seen": "seen",
        "touches": "touch", "says": "say",
    },
    "operator": {"presses": "press"},
}  # fmt: skip
_EXAMPLES = {
    "ball appear": "at 1, 0.2, 0.4", "person appear": "at 1, 0", "ball move": "to 0.5, 0, 0.4 in 2 s",
    "person move": "to 1, 0.5 in 3 s", "circle": "radius 0.3 period 4 s", "seen": "1, Emma, 6",
    "press": "Start", "touch": "Left hand", "say": "hello",
}  # fmt: skip
_PROPOSES = 0.8  # how like a known thing a word must be to be taken for a typing mistake


def thing_names() -> list[str]:
    """What a drop-down offers for Thing."""
    return [*(f"{c.capitalize()} ball" for c in BALL_COLOURS[:3]), *PERSONS[:2], OPERATOR]


def verb_names() -> list[str]:
    """What a drop-down offers for Does."""
    return list(dict.fromkeys(verb for verbs in _VERBS.values() for verb in verbs))


def verbs_of(kind: str) -> dict[str, str]:
    """What a kind of thing can do, each with an example of its value (empty where it needs none).

    >>> verbs_of("ball")["moves"], "says" in verbs_of("person")
    ('to 0.5, 0, 0.4 in 2 s', True)
    """
    verbs = {meaning: verb for verb, meaning in reversed(list(_VERBS[kind].items()))}
    return {v: _EXAMPLES.get(f"{kind} {m}") or _EXAMPLES.get(m, "") for m, v in reversed(list(verbs.items()))}


def parse_scene(rows: Sequence[SceneRow], report: Report, robot: Robot) -> tuple[SceneAction, ...]:
    """The actions of a Scene sheet, in the order of their times; what is not understood goes into the report.

    Args:
        rows: as they stand in the sheet.
        report: takes the findings, each with its cell.
        robot: whose touch zones a touch may name.
    """
    actions = [action for row in rows if (action := _action(row, report, robot)) is not None]
    actions.sort(key=lambda a: a.time_us)
    present: set[str] = set()
    cells = {row.thing.address.row: row.thing for row in rows}
    for action in actions:
        name = key(action.thing)
        if action.verb in ("move", "circle", "away", "look", "disappear") and name not in present:
            ball = key(action.thing).endswith("ball")
            report.add("SCENE005", cells[action.row].address, thing=action.thing,
                       are="it is" if ball else "they are", come="it appears" if ball else "they enter")  # fmt: skip
            present.add(name)  # told once
        if action.verb == "appear":
            present.add(name)
        elif action.verb == "disappear":
            present.discard(name)
    return tuple(actions)


def _action(row: SceneRow, report: Report, robot: Robot) -> SceneAction | None:
    time_us = parse_duration(row.time.text, bare="s")
    if time_us is None:
        meant = meant_duration(row.time.text, "s") or "2.5"
        report.add("SCENE001", row.time.address, text=row.time.text or "blank", meant=meant)
    kind = _kind(row.thing, row.does, report)
    if kind is None:
        return None
    verb = _verb(kind, row.does, report)
    if verb is None:
        return None
    try:
        values = read_value(kind, verb, row.value.text, row.thing.text)
    except BadValueError:
        example = _EXAMPLES.get(f"{kind} {verb}") or _EXAMPLES.get(verb, "")
        remedy = f"Write it like this: {example}." if example else "Leave the cell blank."
        report.add("SCENE004", row.value.address, text=row.value.text or "blank", does=row.does.text, remedy=remedy)
        return None
    if verb == "touch" and not _known_zone(row.value, row.does, report, robot):
        return None
    if time_us is None:
        return None
    return SceneAction(time_us, row.thing.text, verb, values, row.thing.address.row)


def check_presses(
    rows: Sequence[SceneRow], actions: Sequence[SceneAction], buttons: Sequence[str], report: Report
) -> None:
    """Warn of presses of buttons that the workbook does not have.

    Args:
        rows: as they stand in the sheet.
        actions: what was understood of them.
        buttons: the labels of the workbook's operator buttons.
        report: takes the findings.
    """
    cells = {row.value.address.row: row.value for row in rows}
    for action in actions:
        label = str(action.values.get("label", ""))
        if action.verb != "press" or key(label) in {key(b) for b in buttons}:
            continue
        near = nearest(label, buttons)
        remedy = f"Did you mean “{near}”?" if near else f"The buttons are: {', '.join(buttons)}."
        if not buttons:
            remedy = f"Declare it in the sheet Devices: Device Operator button, Label “{label}”."
        report.add("SCENE006", cells[action.row].address, label=label, remedy=remedy)


def _kind(thing: Cell, does: Cell, report: Report) -> str | None:
    """`ball`, `person` or `operator`; None when it is unknown (and told)."""
    text = thing.text.strip()
    name = key(text)
    if name == key(OPERATOR):
        return "operator"
    if name.endswith("ball") and name[: -len("ball")] in ("", *BALL_COLOURS):
        return "ball"
    if re.sub(r"\d+$", "", name) in {key(p) for p in PERSONS}:
        return "person"
    known = [*(f"{c.capitalize()} ball" for c in BALL_COLOURS), *PERSONS, OPERATOR]
    near = _near(text, known)
    # Any other word is a person's name, when it does what persons do and is not a misspelt known thing.
    is_name = bool(text) and text[0].isalpha() and "ball" not in name and key(does.text) in _by_key("person")
    if near is None and is_name:
        return "person"
    near = near or nearest(text, known)
    remedy = (
        f"Did you mean “{near}”?" if near else "Write a ball such as Red ball, Person, Child or a name, or Operator."
    )
    report.add("SCENE002", thing.address, text=text or "blank", remedy=remedy)
    return None


def _known_zone(value: Cell, does: Cell, report: Report, robot: Robot) -> bool:
    zones = robot.touch_zones
    if key(value.text) in {key(zone) for zone in zones}:
        return True
    near = nearest(value.text, zones)
    remedy = f"Did you mean “{near}”?" if near else f"{robot.title} feels a touch on: {', '.join(zones)}."
    report.add("SCENE004", value.address, text=value.text, does=does.text, remedy=remedy)
    return False


def _near(text: str, known: Sequence[str]) -> str | None:
    close = nearest(text, known)
    if close is None:
        return None
    alike = difflib.SequenceMatcher(None, key(text), key(close)).ratio()
    return close if alike >= _PROPOSES else None


def _by_key(kind: str) -> dict[str, str]:
    """The verbs by key, with and without the s of the third person."""
    verbs = {key(verb): meaning for verb, meaning in _VERBS[kind].items()}
    verbs.update({k[:-1]: v for k, v in list(verbs.items()) if k.endswith("s")})
    return verbs


def _verb(kind: str, does: Cell, report: Report) -> str | None:
    verb = _by_key(kind).get(key(does.text))
    if verb is None:
        near = nearest(does.text, _VERBS[kind])
        verbs = ", ".join(_VERBS[kind])
        remedy = f"Did you mean “{near}”?" if near else f"It can do this: {verbs}."
        report.add("SCENE003", does.address, text=does.text or "blank", kind=kind, remedy=remedy)
    return verb


def scene_end_us(actions: Sequence[SceneAction]) -> int:
    """When the last action is over; circling has no end and counts one round."""
    ends = [0]
    for action in actions:
        seconds = action.values.get("seconds") or action.values.get("period") or 0.0
        ends.append(action.time_us + math.ceil(float(seconds) * 1e6))
    return max(ends)
