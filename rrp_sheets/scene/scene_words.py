"""The words of the Scene sheet: kinds of things, their verbs, the parts of a Value cell, and numbers with their ranges.

These tables are all there is: the parser reads by them, `rrp-sheets help scene` prints them, the grid and the templates
offer them, and a test plays every example.
"""

from __future__ import annotations

import math
import random
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.exchange import RandomRange, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_, LazyMessage, MessageError, listed

FARTHEST = 20.0  # m; farther is surely a typing mistake


@dataclass(frozen=True)
class Part:
    """A part of a Value cell: a word and what follows it."""

    word: str  # before it; `also` are further ones. The first part of a verb may come without its word.
    name: str  # of what it says, in the action's values
    # how it is read: `place`, `length`, `lengths`, `seconds`, `share`, `angle`, `text`, `rest`, `whole`, `flag`,
    # `choice`, `file`, `zone`
    kind: str
    # least, most: limits of a number, or how many numbers a place or a size has
    least: float = 0.0
    most: float = FARTHEST
    also: tuple[str, ...] = ()
    # of `choice` and `flag`: the words, and what each means
    choices: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    default: object = None  # when the cell does not say it; None: then it is left out
    needed: bool = False  # whether the cell must say it
    help: str = ""  # for people


@dataclass(frozen=True)
class Verb:
    """Something that a kind of thing can do."""

    name: str  # as people write it; `also` are further ways
    action: str  # what it is to the simulator
    parts: tuple[Part, ...] = ()  # of the Value cell; the first may come without its word
    # of the Value cell, each with a line of help; the first is the one in messages
    examples: tuple[tuple[str, str], ...] = (("", ""),)
    also: tuple[str, ...] = ()

    @property
    def example(self) -> str:
        """A Value cell as one would write it; empty where nothing is needed."""
        return self.examples[0][0]


@dataclass(frozen=True)
class ThingKind:
    """Persons, balls, cups, …: what they can do in a scene."""

    name: str  # `ball`, `person`, …
    title: str  # as help calls it
    things: tuple[str, ...]  # names that drop-downs offer; the first is the one in examples
    verbs: tuple[Verb, ...]
    coloured: bool = False  # whether a colour may stand before the name
    help: str = ""


COLOURS = (
    "red", "green", "blue", "yellow", "orange", "pink", "purple", "violet", "magenta", "cyan", "turquoise", "brown",
    "white", "black", "grey",
)  # fmt: skip
LONGEST = 3_600.0  # s
BALL_SIZE = 0.06  # m: the size that the robot takes every ball to have
FACE_HEIGHT = 0.62  # m: of a child who sits on the floor; a standing NAO sees it without moving its head
CHILD = 1.2  # m: how tall somebody is who is only said to sit or to stand

_IN = Part("in", "seconds", "seconds", 0, LONGEST, default=2.0, help="how long it takes; 2 s")
_FOR = Part("for", "seconds", "seconds", 0.05, LONGEST, help="how long; half a second")
_TURNED = Part("turned", "turned", "angle", help="turned to the left, seen from above")
_ON = Part("on", "on", "choice", choices={"table": "table", "the table": "table", "floor": "", "the floor": ""})
_LEAVES = Verb("disappears", "disappear", also=("leaves", "goes away"))


def _at(least: int, most: int, default: object, help: str) -> Part:
    return Part("at", "at", "place", least, most, default=default, help=help)


def _to(least: int, help: str = "") -> Part:
    return Part("to", "to", "place", least, 3, needed=True, help=help)


def _set_to(*examples: tuple[str, str]) -> Verb:
    parts = (Part("", "share", "share", needed=True), Part("in", "seconds", "seconds", 0, LONGEST))
    return Verb("set to", "set", parts, examples, also=("is", "is set to"))


_BALL = ThingKind(
    LazyMessage("ball", msgctxt="scene"), "A ball", ("Red ball", "Green ball", "Blue ball", "Yellow ball"),
    (
        Verb("appears", "appear",
             (_at(3, 3, (0.8, 0.0, 0.4), "its middle"),
              Part("size", "size", "length", 0.01, 1.0, default=BALL_SIZE, help="its width")),
             (("at 1, 0.2, 0.4", "metres: ahead, to the left, above the floor"),
              ("at 1, 0.2, 0.4 size 10 cm", "without a size it is 6 cm"),
              ("at 0.8..1.2, 0, 0.4", "two dots: every run draws a number between both, by its seed"))),
        Verb("moves", "move", (_to(3), _IN), (("to 0.5, 0, 0.4 in 2 s", "without a time it takes 2 s"),)),
        Verb("circles", "circle",
             (Part("radius", "radius", "length", 0.01, FARTHEST, default=0.2),
              Part("period", "period", "seconds", 0.1, LONGEST, default=4.0),
              Part("around", "around", "place", 3, 3), Part("flat", "flat", "flag", choices={"": True})),
             (("radius 0.3 period 4 s", "upright, before the robot"),
              ("radius 0.3 period 4 s around 0.8, 0, 0.4 flat", "around a place; flat: a level circle"))),
        _LEAVES,
    ),
    coloured=True, help="Any colour; without one it is red. The ball sensors know red, green and blue.",
)  # fmt: skip
_CUP = ThingKind(
    LazyMessage("cup", msgctxt="scene"), "A cup", ("Red cup", "Blue cup", "Yellow cup"),
    (
        Verb("appears", "appear",
             (_at(2, 3, (1.2, 0.0), "where it stands"), _ON,
              Part("size", "size", "length", 0.02, 0.5, default=0.09, help="its height")),
             (("at 0.5, 0.1 on table", "it stands on the table"),
              ("at 1.2, 0.1", "on the floor, where a standing robot sees it; a third number is how high it stands"),
              ("at 1.2, 0.1 size 12 cm", "without a size it is 9 cm high"))),
        Verb("moves", "move", (_to(2), _ON, _IN), (("to 1.2, -0.1 in 2 s", "it stays as high as it is"),
                                                    ("to 0.5, -0.1 on table in 2 s", "onto the table"))),
        _LEAVES,
    ),
    coloured=True,
    help="Any colour; without one it is white. The sensor Blob sees it by its colour; a ball sensor sometimes takes it "
    "for a ball.",
)  # fmt: skip
_BOX = ThingKind(
    LazyMessage("box", msgctxt="scene"), "A box", ("Box", "Green box"),
    (
        Verb("appears", "appear",
             (_at(2, 3, (0.8, 0.0), "where it stands"), _ON, _TURNED,
              Part("size", "size", "lengths", 0.02, 2.0, default=(0.2, 0.2, 0.2), help="wide, deep, high")),
             (("at 0.8, 0.3 size 20 cm", "a cube"),
              ("at 0.8, 0.3 size 30 x 20 x 25 cm", "how wide, deep and high"),
              ("at 0.4, 0 on table size 10 cm", "it stands on the table"))),
        Verb("moves", "move", (_to(2), _ON, _IN), (("to 0.6, 0.3 in 2 s", "it stays as high as it is"),)),
        _LEAVES,
    ),
    coloured=True, help="Any colour; without one it is brown.",
)  # fmt: skip
_TABLE = ThingKind(
    LazyMessage("table", msgctxt="scene"), "A table", ("Table",),
    (
        Verb("appears", "appear",
             (_at(2, 2, (0.55, 0.0), "its middle"),
              Part("size", "size", "lengths", 0.1, 5.0, default=(0.7, 0.4), help="wide, deep"),
              Part("height", "height", "length", 0.05, 1.5, default=0.28, help="of its top"), _TURNED),
             (("at 0.55, 0", "before the robot, 70 x 40 cm, 28 cm high: a standing NAO looks over it"),
              ("at 0.6, 0 size 100 x 50 cm height 25 cm", "how wide and deep; how high"))),
        Verb("moves", "move", (_to(2), _IN), (("to 0.7, 0 in 3 s", "what stands on it does not come along"),)),
        _LEAVES,
    ),
)  # fmt: skip
_WALL = ThingKind(
    LazyMessage("wall", msgctxt="scene"), "A wall", ("Wall",),
    (
        Verb("appears", "appear",
             (_at(2, 2, (2.0, 0.0), "its middle"),
              Part("size", "size", "lengths", 0.1, FARTHEST, default=(2.0, 0.8), help="wide, high"), _TURNED),
             (("at 2, 0", "across, 2 m wide and 80 cm high"),
              ("at 1, 1 size 2 x 1 m turned 90°", "how wide and high; 90°: along the robot's way"))),
        Verb("moves", "move", (_to(2), _IN), (("to 1, 0 in 4 s", ""),)),
        _LEAVES,
    ),
)  # fmt: skip
_POSTURES = Part("", "posture", "flag", choices={"seated": "seated", "sitting": "seated", "standing": "standing"})
_PERSON = ThingKind(
    LazyMessage("person", msgctxt="scene"), "A person", ("Person", "Child", "Adult", "Therapist", "Parent", "Visitor"),
    (
        Verb("enters", "appear",
             (_at(2, 3, (1.0, 0.0), "where they are; a third number is the height of the face"), _POSTURES,
              Part("height", "tall", "length", 0.5, 2.2, help="of the person"),
              Part("name", "name", "text"), Part("id", "id", "whole"),
              Part("voice", "voice", "choice", choices={"child": "child", "female": "female", "male": "male"}),
              Part("picture", "picture", "file", also=("with picture",))),
             (("at 1, 0", "without more it is a child who sits on the floor"),
              ("at 1, 0, 0.62", "the height of the face"),
              ("at 1.2, 0.3 standing height 120 cm", "standing or seated; how tall"),
              ("at 1, 0 voice female", "how they speak: child, female or male"),
              ("at 1, 0 name Emma id 2", "a name: the robot knows this person already"),
              ("at 1, 0 with picture anna.png", "the face, from a picture beside the workbook")),
             also=("appears", "comes")),
        Verb("moves", "move", (_to(2), _IN), (("to 1, 0.5 in 3 s", ""),), also=("walks", "goes")),
        Verb("looks away", "away"),
        Verb("looks back", "look", also=("looks at the robot",)),
        Verb("is seen", "seen", (), (("1, Emma, 6", "id, name, seconds: 1 m in front for that long"),)),
        Verb("touches", "touch", (Part("", "zone", "zone", needed=True), _FOR),
             (("Left hand", "a place where the robot feels a touch"), ("Head for 2 s", "how long; half a second"))),
        Verb("says", "say", (Part("", "words", "rest", needed=True),), (("hello", "a word or a sentence"),)),
        Verb("pushes", "push",
             (Part("from", "from", "choice", choices={
                 "the left": "left", "left": "left", "the right": "right", "right": "right", "behind": "behind",
                 "the back": "behind", "the front": "front", "front": "front"}, default="front"),
              Part("", "how", "flag", choices={"gently": "gently", "hard": "hard"})),
             (("from behind gently", "from the front, behind, the left or the right"),
              ("from the left hard", "gently or hard: a hard push may make the robot fall"))),
        Verb("leaves", "disappear", also=("disappears", "goes away")),
    ),
    help="Any other name is a person's: Mia enters. They look at the robot until they look away.",
)  # fmt: skip
_LIGHT = ThingKind(
    LazyMessage("light", msgctxt="scene"), "The light", ("Light",),
    (_set_to(("40 %", "100 % is a bright room, 0 % is dark"), ("20 % in 3 s", "slowly")),),
)  # fmt: skip
_NOISE = ThingKind(
    LazyMessage("noise", msgctxt="scene"), "The noise", ("Noise",),
    (_set_to(("30 %", "0 % is a quiet room; words are heard worse the louder it is"), ("60 % in 5 s", "slowly")),),
)  # fmt: skip
_OPERATOR = ThingKind(
    LazyMessage("operator", msgctxt="scene"), "Operator", ("Operator",),
    (Verb("presses", "press", (Part("", "label", "rest", needed=True),), (("Start", "the label of a button"),)),),
)  # fmt: skip
KINDS: Mapping[str, ThingKind] = {
    k.name: k for k in (_BALL, _CUP, _BOX, _TABLE, _WALL, _PERSON, _OPERATOR, _LIGHT, _NOISE)
}  # fmt: skip
OPERATOR = "Operator"
PERSONS = _PERSON.things


def thing_names() -> list[str]:
    """Return the names that a drop-down offers for Thing.

    >>> thing_names()[:2], "Operator" in thing_names()
    (['Red ball', 'Green ball'], True)
    """
    return [name for kind in KINDS.values() for name in kind.things]


def verb_names() -> list[str]:
    """Return the verbs that a drop-down offers for Does."""
    return list(dict.fromkeys(v.name for kind in KINDS.values() for v in kind.verbs))


def verbs_of(kind: str) -> dict[str, str]:
    """Return the verbs of a kind of thing, each with an example of its value (empty where it needs none).

    >>> verbs_of("ball")["moves"], "says" in verbs_of("person")
    ('to 0.5, 0, 0.4 in 2 s', True)
    """
    return {verb.name: verb.example for verb in KINDS[kind].verbs}


def find_verb(kind: ThingKind, text: str) -> Verb | None:
    """The verb that a text means, with or without the s of the third person."""
    verbs = {key(name): verb for verb in kind.verbs for name in (verb.name, *verb.also)}
    return {**{k.removesuffix("s"): v for k, v in verbs.items()}, **verbs}.get(key(text))


def kind_of(text: str) -> tuple[str, str] | None:
    """The kind and colour of a thing, by its name; None when it is a person's name, or nothing.

    >>> kind_of("Red ball 2"), kind_of("Table"), kind_of("Mia")
    (('ball', 'red'), ('table', ''), None)
    """
    name = re.sub(r"\d+$", "", key(text))
    for kind in KINDS.values():
        if kind.name == "person":
            if name in {key(p) for p in PERSONS}:
                return kind.name, ""
        elif name.endswith(kind.name):
            colour = name.removesuffix(kind.name)
            if not colour or (kind.coloured and colour in COLOURS):
                return kind.name, colour
    return None


def known_things() -> Sequence[str]:
    """Every name that is known, for guesses."""
    coloured = [f"{c.capitalize()} {k.name}" for k in KINDS.values() if k.coloured for c in COLOURS]
    return [*coloured, *(t for k in KINDS.values() for t in k.things), "Ball", "Cup"]


def choose_random_numbers(
    actions: Sequence[SceneAction], seed: int
) -> tuple[tuple[SceneAction, ...], tuple[tuple[int, str], ...]]:
    """Return the actions with a number for each range, and by row in words which; the same numbers for the same seed.

    Each number depends on the seed and its own cell alone: a row more or less changes no other.

    >>> action = SceneAction(0, "Red ball", "appear", {"at": (RandomRange(0.8, 1.2), 0.0, 0.4)}, row=4)
    >>> (one,), ((row, told),) = choose_random_numbers([action], 7)
    >>> 0.8 <= one.values["at"][0] <= 1.2, row, choose_random_numbers([action], 7)[0][0] == one
    (True, 4, True)
    """
    found, told = [], []
    for one in actions:
        action, drawer = one, _Drawer(seed, one.row)
        values = {name: drawer.value(name, value) for name, value in action.values.items()}
        time_us = action.time_us
        if action.span_us:
            time_us = round(1e6 * drawer.number("time", RandomRange(time_us / 1e6, (time_us + action.span_us) / 1e6)))
        if drawer.told:
            told.append((action.row, N_("Random numbers of this run: {numbers}.", numbers=listed(drawer.told))))
            action = replace(action, time_us=time_us, span_us=0, values=values)
        found.append(action)
    return tuple(found), tuple(told)


class _Drawer:
    def __init__(self, seed: int, row: int) -> None:
        self._name = f"{seed}\nScene!{row}"
        self.told: list[str] = []

    def value(self, name: str, value: Value) -> Value:
        if isinstance(value, tuple):
            return tuple(self.value(name if i == 0 else f"{name} {i + 1}", part) for i, part in enumerate(value))
        return self.number(name, value) if isinstance(value, RandomRange) else value

    def number(self, name: str, among: RandomRange) -> float:
        # seeded with a text, Python hashes it the same way everywhere; only random() stays the same for ever
        chance = random.Random(f"{self._name}\n{name}").random()
        number = among.low + chance * (among.high - among.low)
        number = min(max(round(number, 3), among.low), among.high)
        self.told.append(N_("{name} {number:g} of {range}", name=name, number=number, range=str(among)))
        return number


Amount = float | RandomRange
METRES: Mapping[str, float] = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001}
RADIANS: Mapping[str, float] = {
    "°": math.pi / 180, "deg": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180, "rad": 1.0,
}  # fmt: skip
SHARES: Mapping[str, float] = {"%": 0.01, "": 1.0}
"""A number alone is at most 1: a spreadsheet makes 0.4 of 40 % that is typed as a number."""
_NUMBER = r"[-+]?(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)"
_ONE = re.compile(rf"(?P<low>{_NUMBER})(?:\.\.(?P<high>{_NUMBER}))?(?:\s*(?P<unit>[^\W\d_]+|%|°))?")
_GAP = re.compile(r"\s*[,;]\s*|\s+|$")
_DOTS = re.compile(r"\s*(?:\.{2,3}|…|‥)\s*")
_TIMES = re.compile(r"\s*[x×*]\s*", re.IGNORECASE)
_LETTER = re.compile(r"[^\W\d_]")


class BadValueError(MessageError):
    """A cell cannot be understood. Its text says what to do; empty where only an example helps."""


def normalize_signs(text: str) -> str:
    """A text with its minus signs and dots as they are typed without help.

    >>> normalize_signs("at \N{MINUS SIGN}1 … 1, 0")
    'at -1..1, 0'
    """
    return _DOTS.sub("..", text.replace("\N{MINUS SIGN}", "-")).strip(" ,;\n\t")


def ends(amount: Amount) -> tuple[float, float]:
    """The least and the most that an amount can be.

    >>> ends(0.5), ends(RandomRange(0.4, 0.6))
    ((0.5, 0.5), (0.4, 0.6))
    """
    return (amount.low, amount.high) if isinstance(amount, RandomRange) else (amount, amount)


def between(low: float, high: float) -> Amount:
    """A number, or a range when both ends differ, whichever is given first.

    >>> between(2.0, 1.0), between(1.0, 1.0)
    (RandomRange(low=1.0, high=2.0), 1.0)
    """
    return low if low == high else RandomRange(min(low, high), max(low, high))


def one(text: str, units: Mapping[str, float], least: float, most: float, unit: str) -> Amount:
    """A number with its unit, in the unit whose factor is 1; raises BadValueError for none, or one beyond its limits.

    >>> one("5..10 cm", METRES, 0.01, 1, "m")
    RandomRange(low=0.05, high=0.1)
    """
    match = _ONE.fullmatch(_folded(text))
    if not match:
        raise BadValueError
    return _within(_scaled(match, match["unit"] or "", units), least, most, unit)


def many(text: str, least: float, most: float) -> tuple[Amount, ...]:
    """Lengths (m) with a cross between them; a unit at the end is that of all. Raises BadValueError as `one` does.

    >>> many("60 x 40 cm", 0.1, 1)
    (0.6, 0.4)
    """
    matches = [_ONE.fullmatch(piece) for piece in _TIMES.split(_folded(text))]
    found = [m for m in matches if m is not None]
    if len(found) < len(matches):
        raise BadValueError
    return tuple(_within(_scaled(m, m["unit"] or found[-1]["unit"] or "", METRES), least, most, "m") for m in found)


def place(text: str, least: int, most: int, farthest: float) -> tuple[Amount, ...]:
    """A position in m: so many numbers, with commas or blanks between them; raises BadValueError as `one` does.

    >>> place("(1, 0.4..0.6 20 cm)", 3, 3, 20)
    (1.0, RandomRange(low=0.4, high=0.6), 0.2)
    """
    rest, numbers = _folded(text).removeprefix("(").removesuffix(")").strip(), list[Amount]()
    while rest:
        match = _ONE.match(rest)
        # of “1, 0 5”, “1 m” and “1 m, 0” the unit is what stands before the gap
        gap = _GAP.match(rest, match.end()) if match else None
        if match is None or gap is None:
            raise BadValueError
        numbers.append(_within(_scaled(match, match["unit"] or "", METRES), -farthest, farthest, "m"))
        rest = rest[gap.end() :]
    if not least <= len(numbers) <= most:
        raise BadValueError
    return tuple(numbers)


def span(text: str) -> tuple[int, int] | None:
    """A time, or a range of times, in microseconds; a number alone is in seconds. None when it is none.

    >>> span("2 s"), span("500..700 ms"), span("1..2"), span("soon")
    ((2000000, 2000000), (500000, 700000), (1000000, 2000000), None)
    """
    first, dots, last = (part.strip() for part in text.partition(".."))
    if not dots:
        us = parse_duration(first, bare="s")
        return None if us is None else (us, us)
    if not _LETTER.search(first):
        unit = _LETTER.search(last)
        first += last[unit.start() :] if unit else ""
    low, high = parse_duration(first, bare="s"), parse_duration(last, bare="s")
    return None if low is None or high is None else (min(low, high), max(low, high))


def seconds(text: str, least: float, most: float) -> Amount:
    """A time in seconds; raises BadValueError for none, or one beyond its limits."""
    us = span(text)
    if us is None:
        raise BadValueError
    return _within(between(us[0] / 1e6, us[1] / 1e6), least, most, "s")


def _folded(text: str) -> str:
    """Full-width digits and signs are digits and signs."""
    return unicodedata.normalize("NFKC", text).strip()


def _scaled(match: re.Match[str], unit: str, units: Mapping[str, float]) -> Amount:
    factor = units.get(unit.casefold())
    if factor is None or len(match["low"]) > 20 or len(match["high"] or "") > 20:
        raise BadValueError
    low = float(match["low"])
    high = low if match["high"] is None else float(match["high"])
    return between(round(low * factor, 9) + 0.0, round(high * factor, 9) + 0.0)


def _within(amount: Amount, least: float, most: float, unit: str) -> Amount:
    low, high = ends(amount)
    if not (least <= low and high <= most):
        scale = 100 if unit == "%" else 1
        least, most = least * scale, most * scale
        raise BadValueError("Write from {value:g} to {value2:g} {unit}.", value=least, value2=most, unit=unit)
    return amount
