"""The Value cells of the Scene sheet: places, lengths, times (the grammar is told in `scene`)."""

from __future__ import annotations

import re

from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value

BALL_SIZE = 0.06  # m: the size that the robot takes every ball to have
FACE_HEIGHT = 0.62  # m: of a child who sits on the floor; a standing NAO sees it without moving its head
MOVING = 2.0  # s, when a row does not say how long a move takes
FARTHEST = 20.0  # m; farther is surely a typing mistake
SIZES = (0.01, 1.0)  # m, of balls
_WORD = re.compile(r"\b(at|to|in|size|radius|period|around|name|id|flat)\b", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)")
_LENGTH = re.compile(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(mm|cm|m|)\s*", re.IGNORECASE)


class BadValueError(Exception):
    """The Value cell cannot be understood."""


def read_value(kind: str, verb: str, text: str, thing: str) -> dict[str, Value]:
    """What the Value cell of a Scene row says, by name.

    Args:
        kind: of the thing: `ball`, `person` or `operator`.
        verb: what it does: `appear`, `move`, …
        text: the cell's.
        thing: the Thing cell's, which says the colour of a ball.

    Raises:
        BadValueError: it cannot be understood.
    """
    if verb in ("press", "touch", "say"):
        if not text.strip():
            raise BadValueError
        return {{"press": "label", "touch": "zone", "say": "words"}[verb]: text.strip()}
    if verb == "seen":
        return _seen(text)
    parts = _parts(text, {"appear": "at", "move": "to", "circle": "radius"}.get(verb, ""))
    values: dict[str, Value] = {}
    if verb == "appear":
        values = _appears(parts, kind, thing)
    elif verb == "move":
        values = _moves(parts, two=kind == "person")
    elif verb == "circle":
        values = _circles(parts)
    if parts:  # words that say nothing here
        raise BadValueError
    return values


def _parts(text: str, first: str) -> dict[str, str]:
    """The text cut at its words: `to 1, 0, 0 in 2 s` is `to` and `in`; what has no word is `first`."""
    pieces = _WORD.split(text)
    parts: dict[str, str] = {}
    if pieces[0].strip(" ,;"):
        if not first:
            raise BadValueError
        parts[first] = pieces[0].strip(" ,;")
    for word, rest in zip(pieces[1::2], pieces[2::2], strict=True):
        if word.casefold() in parts:
            raise BadValueError
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


def _moves(parts: dict[str, str], two: bool) -> dict[str, Value]:
    place = _place(parts.pop("to", ""), None, two=two)
    return {"to": place, "seconds": _seconds(parts.pop("in")) if "in" in parts else MOVING}


def _circles(parts: dict[str, str]) -> dict[str, Value]:
    values: dict[str, Value] = {
        "radius": _length(parts.pop("radius", "0.2"), 0.01, FARTHEST),
        "period": _seconds(parts.pop("period", "4 s")),
    }
    if values["period"] <= 0:
        raise BadValueError
    if "around" in parts:
        values["around"] = _place(parts.pop("around"), None)
    if "flat" in parts:
        if parts.pop("flat"):
            raise BadValueError
        values["flat"] = True
    return values


def _seen(text: str) -> dict[str, Value]:
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3:
        raise BadValueError
    return {"id": _whole(parts[0]), "name": parts[1], "seconds": _seconds(parts[2])}


def _place(text: str, height: float | None, two: bool = False) -> tuple[float, ...]:
    """A position in m: three numbers; two when a height is given or not needed."""
    pieces = [p for p in re.split(r"[,;\s]+", text.strip().strip("()")) if p]
    if not all(_NUMBER.fullmatch(p) for p in pieces):
        raise BadValueError
    numbers = [float(p) for p in pieces]
    if len(numbers) == 2 and height is not None:
        numbers.append(height)
    if len(numbers) not in ((2, 3) if two else (3,)) or any(abs(n) > FARTHEST for n in numbers):
        raise BadValueError
    return tuple(numbers)


def _length(text: str, least: float, most: float) -> float:
    match = _LENGTH.fullmatch(text)
    if not match:
        raise BadValueError
    metres = float(match[1]) * {"mm": 0.001, "cm": 0.01}.get(match[2].casefold(), 1.0)
    if not least <= metres <= most:
        raise BadValueError
    return metres


def _seconds(text: str) -> float:
    us = parse_duration(text, bare="s")
    if us is None:
        raise BadValueError
    return us / 1e6


def _whole(text: str) -> int:
    if not re.fullmatch(r"\d{1,6}", text):
        raise BadValueError
    return int(text)
