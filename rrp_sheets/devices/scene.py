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
from collections.abc import Callable, Mapping, Sequence

from rrp_sheets.devices.catalogue import Robot
from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import SceneRow

BALL_COLOURS = (
    "red", "green", "blue", "yellow", "orange", "pink", "purple", "violet", "magenta", "cyan", "turquoise", "brown",
    "white", "black", "grey",
)  # fmt: skip
PERSONS = ("Person", "Child", "Adult", "Visitor", "Therapist", "Parent")
OPERATOR = "Operator"
BALL_SIZE = 0.06  # m: the size that the robot takes every ball to have
FACE_HEIGHT = 0.62  # m: of a child who sits on the floor; a standing NAO sees it without moving its head
MOVING = 2.0  # s, when a row does not say how long a move takes
FARTHEST = 20.0  # m; farther is surely a typing mistake
SIZES = (0.01, 1.0)  # m, of balls
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
_WORD = re.compile(r"\b(at|to|in|size|radius|period|around|name|id|flat)\b", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)")
_LENGTH = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(mm|cm|m|)\s*", re.IGNORECASE)


class _BadValueError(Exception):
    """The Value cell cannot be understood."""


def thing_names() -> list[str]:
    """What a drop-down offers for Thing."""
    return [*(f"{c.capitalize()} ball" for c in BALL_COLOURS[:3]), *PERSONS[:2], OPERATOR]


def verb_names() -> list[str]:
    """What a drop-down offers for Does."""
    return list(dict.fromkeys(verb for verbs in _VERBS.values() for verb in verbs))


def parse_scene(rows: Sequence[SceneRow], report: Report, robot: Robot) -> tuple[SceneAction, ...]:
    """The actions of a Scene sheet, in the order of their times; what is not understood goes into the report.

    Args:
        rows: as they stand in the sheet.
        report: takes the findings, each with its cell.
        robot: whose touch zones a touch may name.
    """
    actions = [action for row in rows if (action := _action(row, report)) is not None]
    actions.sort(key=lambda a: a.time_us)
    present: set[str] = set()
    cells = {row.thing.address.row: row.thing for row in rows}
    for action in actions:
        name = key(action.thing)
        if action.verb in ("move", "circle", "away", "look", "disappear") and name not in present:
            report.add("SCENE005", cells[action.row].address, thing=action.thing)
        if action.verb == "appear":
            present.add(name)
        elif action.verb == "disappear":
            present.discard(name)
    return tuple(actions)


def _action(row: SceneRow, report: Report) -> SceneAction | None:
    time_us = parse_duration(row.time.text, bare="s")
    if time_us is None:
        report.add("SCENE001", row.time.address, text=row.time.text or "blank")
    kind = _kind(row.thing, row.does, report)
    if kind is None:
        return None
    verb = _verb(kind, row.does, report)
    if verb is None:
        return None
    try:
        values = _values(kind, verb, row.value.text, row.thing.text)
    except _BadValueError:
        example = _EXAMPLES.get(f"{kind} {verb}") or _EXAMPLES.get(verb, "")
        remedy = f"Write it like this: {example}." if example else "Leave the cell blank."
        report.add("SCENE004", row.value.address, text=row.value.text or "blank", does=row.does.text, remedy=remedy)
        return None
    if time_us is None:
        return None
    return SceneAction(time_us, row.thing.text, verb, values, row.thing.address.row)


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


def _values(kind: str, verb: str, text: str, thing: str) -> dict[str, Value]:
    if verb in ("press", "touch", "say"):
        if not text.strip():
            raise _BadValueError
        return {{"press": "label", "touch": "zone", "say": "words"}[verb]: text.strip()}
    if verb == "seen":
        return _seen(text)
    parts = _parts(text, {"appear": "at", "move": "to", "circle": "radius"}.get(verb, ""))
    readers: Mapping[str, Callable[[dict[str, str], str, str], dict[str, Value]]] = {
        "appear": _appears, "move": _moves, "circle": _circles,
    }  # fmt: skip
    values = readers[verb](parts, kind, thing) if verb in readers else {}
    if parts:  # words that say nothing here
        raise _BadValueError
    return values


def _parts(text: str, first: str) -> dict[str, str]:
    """The text cut at its words: `to 1, 0, 0 in 2 s` is `to` and `in`; what has no word is `first`."""
    pieces = _WORD.split(text)
    parts: dict[str, str] = {}
    if pieces[0].strip(" ,;"):
        if not first:
            raise _BadValueError
        parts[first] = pieces[0].strip(" ,;")
    for word, rest in zip(pieces[1::2], pieces[2::2], strict=True):
        if word.casefold() in parts:
            raise _BadValueError
        parts[word.casefold()] = rest.strip(" ,;")
    return parts


def _appears(parts: dict[str, str], kind: str, thing: str) -> dict[str, Value]:
    default = "0.8, 0, 0.4" if kind == "ball" else "1, 0"
    place = _place(parts.pop("at", default), FACE_HEIGHT if kind == "person" else None)
    values: dict[str, Value] = {"at": place}
    if kind == "ball":
        values["size"] = _length(parts.pop("size"), *SIZES) if "size" in parts else BALL_SIZE
        values["colour"] = key(thing)[: -len("ball")] or "red"
        return values
    if "name" in parts:
        values["name"] = parts.pop("name")
    if "id" in parts:
        values["id"] = _whole(parts.pop("id"))
    return values


def _moves(parts: dict[str, str], kind: str, thing: str) -> dict[str, Value]:
    place = _place(parts.pop("to", ""), None, two=kind == "person")
    return {"to": place, "seconds": _seconds(parts.pop("in")) if "in" in parts else MOVING}


def _circles(parts: dict[str, str], kind: str, thing: str) -> dict[str, Value]:
    values: dict[str, Value] = {
        "radius": _length(parts.pop("radius", "0.2"), 0.01, FARTHEST),
        "period": _seconds(parts.pop("period", "4 s")),
    }
    if values["period"] <= 0:
        raise _BadValueError
    if "around" in parts:
        values["around"] = _place(parts.pop("around"), None)
    if "flat" in parts:
        if parts.pop("flat"):
            raise _BadValueError
        values["flat"] = True
    return values


def _seen(text: str) -> dict[str, Value]:
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3:
        raise _BadValueError
    return {"id": _whole(parts[0]), "name": parts[1], "seconds": _seconds(parts[2])}


def _place(text: str, height: float | None, two: bool = False) -> tuple[float, ...]:
    """A position in m: three numbers; two when a height is given or not needed."""
    pieces = [p for p in re.split(r"[,;\s]+", text.strip().strip("()")) if p]
    if not all(_NUMBER.fullmatch(p) for p in pieces):
        raise _BadValueError
    numbers = [float(p) for p in pieces]
    if len(numbers) == 2 and height is not None:
        numbers.append(height)
    if len(numbers) not in ((2, 3) if two else (3,)) or any(abs(n) > FARTHEST for n in numbers):
        raise _BadValueError
    return tuple(numbers)


def _length(text: str, least: float, most: float) -> float:
    match = _LENGTH.fullmatch(text)
    if not match:
        raise _BadValueError
    metres = float(match[1]) * {"mm": 0.001, "cm": 0.01}.get(match[2].casefold(), 1.0)
    if not least <= metres <= most:
        raise _BadValueError
    return metres


def _seconds(text: str) -> float:
    us = parse_duration(text, bare="s")
    if us is None:
        raise _BadValueError
    return us / 1e6


def _whole(text: str) -> int:
    if not re.fullmatch(r"\d{1,6}", text):
        raise _BadValueError
    return int(text)


def scene_end_us(actions: Sequence[SceneAction]) -> int:
    """When the last action is over; circling has no end and counts one round."""
    ends = [0]
    for action in actions:
        seconds = action.values.get("seconds") or action.values.get("period") or 0.0
        ends.append(action.time_us + math.ceil(float(seconds) * 1e6))
    return max(ends)


def default_scene(sensors: Sequence[str], robot: Robot) -> tuple[SceneAction, ...]:
    """A small scene in which these sensors (device names) have something to see.

    Places suit a robot of NAO's height and grow with the robot.
    """
    found = [f.type for name in dict.fromkeys(sensors) if (f := robot.find(name)) is not None]
    shows = {"RedBall": ["red"], "GreenBall": ["green"], "BlueBall": ["blue"], "Ball": ["red", "blue"], "Blob": ["red"]}
    colours = [colour for device in found for colour in shows.get(device.name, [])]
    grow = float(robot.data["robot"].get("height", 0.574)) / 0.574
    actions: list[SceneAction] = []
    for number, colour in enumerate(dict.fromkeys(colours)):
        actions += _ball_play(colour, number, grow)
    if any(device.name == "FaceDetection" for device in found):
        actions += _visit(grow)
    return tuple(sorted(actions, key=lambda a: a.time_us))


def _ball_play(colour: str, number: int, grow: float) -> list[SceneAction]:
    """A ball comes near, goes to both sides and away; a second one does so mirrored and later."""
    thing, side, late = f"{colour.capitalize()} ball", (1, -1)[number % 2], 1_500_000 * number
    moves = ((2, (0.42, 0.10, 0.42), 2), (6, (0.9, 0.45, 0.5), 2), (10, (0.8, -0.45, 0.36), 3), (15, (0.45, 0, 0.4), 2))

    def place(x: float, y: float, z: float) -> tuple[float, float, float]:
        return round(x * grow, 3), round(side * y * grow, 3), round(z * grow, 3)

    values: dict[str, Value] = {"at": place(1.0, 0.2, 0.4), "size": BALL_SIZE, "colour": colour}
    play = [SceneAction(late, thing, "appear", values)]
    for second, to, seconds in moves:
        play.append(SceneAction(late + second * 1_000_000, thing, "move", {"to": place(*to), "seconds": seconds}))
    return [*play, SceneAction(late + 19_000_000, thing, "disappear")]


def _visit(grow: float) -> list[SceneAction]:
    """Somebody comes, moves a little, looks away for a moment and leaves; somebody else comes."""
    face = FACE_HEIGHT * grow
    first: dict[str, Value] = {"at": (1.1, 0.15, face), "id": 1}
    second: dict[str, Value] = {"at": (1.2, -0.2, face), "id": 2}
    return [
        SceneAction(1_000_000, "Person", "appear", first),
        SceneAction(6_000_000, "Person", "move", {"to": (1.0, -0.2), "seconds": 2.0}),
        SceneAction(10_000_000, "Person", "away"),
        SceneAction(12_000_000, "Person", "look"),
        SceneAction(15_000_000, "Person", "disappear"),
        SceneAction(17_000_000, "Person 2", "appear", second),
        SceneAction(24_000_000, "Person 2", "disappear"),
    ]
