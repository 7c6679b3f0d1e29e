"""Reads the Scene sheet: times, things, verbs, values and order of its rows. Their words are in `scene_words`."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from rrp_sheets.diagnostics.report import Report, meant
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import meant_duration
from rrp_sheets.model.exchange import ROW_ABOVE, RandomRange, SceneAction
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Cell, SceneRow
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.robots.media_files import check_pictures
from rrp_sheets.scene import scene_words
from rrp_sheets.scene.scene_words import KINDS, Amount, BadValueError, Part, ThingKind, Verb, find_verb, normalize_signs
from rrp_sheets.texts import N_, LazyMessage, listed, sentences

_ANY = N_("Write for example Red ball, Blue cup, Table, Wall, Person, Child, a name, Light, Noise or Operator.")
_PROPOSES = 0.8  # how like a known thing a word must be to be taken for a typing mistake


def parse_scene(
    rows: Sequence[SceneRow], report: Report, robot: Robot, folder: Path | None = None
) -> tuple[SceneAction, ...]:
    """The actions of a Scene sheet, in the order of their times; what is not understood goes into the report.

    Rows that wait for an event come where they would if it came at once. Numbers may be ranges: a run draws them.
    Pictures are looked for in the workbook's `folder`; without one none is found.
    """
    found = [action for row in rows if (action := _action(row, report, robot)) is not None]
    cells = {row.thing.address.row: row for row in rows}
    actions = check_pictures(in_order(found), cells, folder, report)
    check_presence(actions, cells, report)
    return actions


def _action(row: SceneRow, report: Report, robot: Robot) -> SceneAction | None:
    when = read_time(row.time.text)
    if when is None:
        _check_time(row.time, report)
    kind = _kind(row.thing, row.does, report)
    if kind is None:
        return None
    verb = _verb(kind[0], row.does, report)
    if verb is None:
        return None
    values = _values(*kind, verb, row, report)
    if values is None or (verb.action == "touch" and not _known_zone(row.value, values, row.does, report, robot)):
        return None
    if when is None:
        return None
    return SceneAction(
        when.us, row.thing.text, verb.action, values, row.thing.address.row, kind[0].name, when.cue, when.span_us
    )


def _check_time(time: Cell, report: Report) -> None:
    duration = meant_duration(time.text, "s")
    remedy: str = N_("Write seconds from the start of the run, for example {value}.", value=duration or "2.5")
    if "+" in time.text:
        remedy = N_("Write seconds after +: Ask done + 2.")
    elif time.text and not duration:
        remedy = sentences(remedy, N_("Or a stream, and seconds after its event: Say done + 2."))
    report.add("SCENE001", time.address, text=time.text or N_("blank"), remedy=remedy)


def _values(kind: ThingKind, colour: str, verb: Verb, row: SceneRow, report: Report) -> dict[str, Value] | None:
    try:
        return read_value(kind, verb, row.value.text, colour)
    except BadValueError as error:
        example = verb.example
        written = N_("Write it like this: {example}.", example=N_(example, msgctxt="scene"))
        remedy = written if example else N_("Leave the cell blank.")
        report.add("SCENE004", row.value.address, text=row.value.typed or N_("blank"), does=row.does.typed,
                   remedy=sentences(*error.args, remedy))  # fmt: skip
        return None


def check_presses(
    rows: Sequence[SceneRow], actions: Sequence[SceneAction], buttons: Sequence[str], report: Report
) -> None:
    """Warn of presses of buttons whose labels are not among those of the workbook's operator buttons."""
    cells = {row.value.address.row: row.value for row in rows}
    for action in actions:
        label = str(action.values.get("label", ""))
        if action.verb != "press" or key(label) in {key(b) for b in buttons}:
            continue
        near = nearest(label, buttons)
        otherwise = N_("The buttons are: {buttons}.", buttons=", ".join(buttons))
        if not buttons:
            otherwise = N_("Declare it in the sheet Devices: Device Operator button, Label “{label}”.", label=label)
        report.add("SCENE006", cells[action.row].address, label=label, **meant(near, otherwise, quoted=True))


def _kind(thing: Cell, does: Cell, report: Report) -> tuple[ThingKind, str] | None:
    text = thing.text.strip()
    found = scene_words.kind_of(text)
    if found is not None:
        return KINDS[found[0]], found[1]
    person = KINDS["person"]
    near = _nearest_thing(text)
    misspelt = near is not None and difflib.SequenceMatcher(None, key(text), key(near)).ratio() >= _PROPOSES
    # Any other word is a person's name, when it does what persons do and is not a misspelt known thing.
    if not misspelt and text and text[0].isalpha() and not _is_thing(text) and find_verb(person, does.text) is not None:
        return person, ""
    if not text:
        report.add("SCENE012", thing.address)
    else:
        report.add("SCENE002", thing.address, text=thing.typed, **meant(near, _ANY, quoted=True))
    return None


def _is_thing(text: str) -> bool:
    """Return whether a name has the form of a thing's: `Left wall` is no person."""
    return "ball" in key(text) or key(text.rsplit(maxsplit=1)[-1]).rstrip("0123456789") in {*KINDS, "lamp"}


def _known_zone(value: Cell, values: dict[str, Value], does: Cell, report: Report, robot: Robot) -> bool:
    said = str(values["zone"])
    if key(said) in map(key, robot.touch_zones):
        return True
    near = nearest(said, [*robot.touch_zones, *japanese.words_for(japanese.ZONES, *robot.touch_zones)])
    names = listed([N_(zone, msgctxt="value") for zone in robot.touch_zones])
    otherwise = N_("{title} feels a touch on: {names}.", title=robot.title, names=names)
    report.add("SCENE004", value.address, text=value.typed, does=does.typed, **meant(near, otherwise, quoted=True))
    return False


@lru_cache(maxsize=1024)
def _nearest_thing(text: str) -> str | None:
    return nearest(text, [*scene_words.known_things(), *japanese.THINGS])


def _verb(kind: ThingKind, does: Cell, report: Report) -> Verb | None:
    verb = find_verb(kind, does.text)
    if verb is None:
        known = [n for v in kind.verbs for n in (v.name, *v.also)]
        near = nearest(does.text, [*known, *japanese.words_for(japanese.VERBS, *known)])
        names = listed([N_(v.name, msgctxt="scene") for v in kind.verbs])
        otherwise = N_("It can do this: {names}.", names=names)
        remedy = meant(near, otherwise, quoted=True)
        report.add("SCENE003", does.address, text=does.typed or N_("blank"), kind=kind.name, **remedy)
    return verb


_AFTER = re.compile(r"(.*?)\s*\+\s*([^+]*)", re.DOTALL)


@dataclass(frozen=True)
class When:
    """Time at which something happens."""

    us: int  # on the run's clock, or after what it waits for, microseconds
    span_us: int = 0  # how much later it may be
    cue: str = ""  # what it waits for: a stream as it is named in the cell, `+` for the row above, empty for nothing


def read_time(text: str) -> When | None:
    """Return the time in a Time cell; None when it is no time. Whether its stream exists is not checked here.

    >>> read_time("2.5"), read_time("2..4 s")
    (When(us=2500000, span_us=0, cue=''), When(us=2000000, span_us=2000000, cue=''))
    >>> read_time("Ask done + 2"), read_time("+ 500 ms"), read_time("soon")
    (When(us=2000000, span_us=0, cue='Ask done'), When(us=500000, span_us=0, cue='+'), None)
    """
    text = normalize_signs(text)
    after = _AFTER.fullmatch(text)
    times = scene_words.span(after[2] if after else text)
    if times is None:
        return None
    return When(times[0], times[1] - times[0], (after[1] or ROW_ABOVE) if after else "")


SEATED_FACE, STANDING_FACE = 0.52, 0.92  # of a person's height: where the face is
LONGEST_SEEN = 31 * 24 * 3600.0  # s
_PLAIN_COLOURS = {"ball": "red", "cup": "white", "box": "brown"}
_EVERYWHERE = frozenset(p.word for k in KINDS.values() for v in k.verbs for p in v.parts if p.word)
ValueParts = dict[str, Value]


def read_value(kind: ThingKind, verb: Verb, text: str, colour: str = "") -> ValueParts:
    """Return the values in the Value cell of a Scene row, by name; raises BadValueError if it is not understood."""
    if verb.action == "seen":
        return _seen(text)
    if any(part.kind == "rest" for part in verb.parts):
        said: ValueParts = {verb.parts[0].name: text.strip()} if text.strip() else {}
    else:
        said = {}
        for part, words in _cut(verb, normalize_signs(text)):
            if part.name in said:
                raise BadValueError("Write “{value}” once.", value=LazyMessage(part.word or words, msgctxt="scene"))
            said[part.name] = _READERS[part.kind](part, words)
    for part in verb.parts:
        if part.needed and part.name not in said:
            raise BadValueError
        if part.default is not None:
            said.setdefault(part.name, part.default)
    if verb.action == "appear":
        _complete(kind, said, colour)
    elif "on" in said:
        _stand_on(said, "to")
    return said


def _cut(verb: Verb, text: str) -> Iterator[tuple[Part, str]]:
    """The text cut at its words: `to 1, 0, 0 in 2 s` is `to` and `in`; what comes before any word is the first part."""
    for part in verb.parts:
        if part.kind == "file" and (found := _file_of(part).search(text)):
            yield part, found[1].strip('"“”,;')
            text = f"{text[: found.start()]} {text[found.end() :]}".strip(" ,;")
    words = _words(verb)
    first, *pieces = _splitter(frozenset(words)).split(text)
    if first.strip(" ,;"):
        if not verb.parts or verb.parts[0].kind == "flag":
            raise BadValueError
        yield verb.parts[0], first.strip(" ,;")
    for word, rest in zip(pieces[::2], pieces[1::2], strict=True):
        known, said = words.get(word.casefold()), rest.strip(" ,;")
        if known is None or (known.kind == "flag" and said):
            raise BadValueError
        yield known, word if known.kind == "flag" else said


def _words(verb: Verb) -> dict[str, Part]:
    words: dict[str, Part] = {}
    for part in verb.parts:
        names = (w or part.word for w in part.choices) if part.kind == "flag" else (part.word, *part.also)
        words.update((word, part) for word in names if word)
    return words


@lru_cache(maxsize=64)
def _splitter(words: frozenset[str]) -> re.Pattern[str]:
    """Return what splits a value at the words of a verb, and at those of all other verbs, which mean nothing for it."""
    longest_first = sorted(_EVERYWHERE | words, key=lambda w: (-len(w), w))
    return re.compile(rf"(?<!\w)({'|'.join(map(re.escape, longest_first))})(?!\w)", re.IGNORECASE)


def _file_of(part: Part) -> re.Pattern[str]:
    names = "|".join(re.escape(w) for w in (*part.also, part.word))
    return re.compile(rf"(?<!\w)(?:{names})\s+(\"[^\"]*\"|“[^”]*”|[^\s,;]+)", re.IGNORECASE)


# ---- readers of one part


def _lengths(part: Part, text: str) -> tuple[Amount, ...]:
    sizes = scene_words.many(text, part.least, part.most)
    wanted = len(part.default) if isinstance(part.default, tuple) else 1
    if len(sizes) == 1 and part.name == "size" and wanted == 3:  # a cube
        sizes *= 3
    if len(sizes) != wanted:
        raise BadValueError
    return sizes


def _whole(part: Part, text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,6}", text):
        raise BadValueError
    return int(text)


def _choice(part: Part, text: str) -> Value:
    choices = {key(word): value for word, value in part.choices.items()}
    if key(text) not in choices:
        words: dict[object, str] = {}
        for word, value in part.choices.items():
            words.setdefault(value, word)  # one for each
        names = listed([LazyMessage(word, msgctxt="scene") for word in words.values()])
        before = LazyMessage(part.word, msgctxt="scene")
        raise BadValueError("You can write after “{word}”: {names}.", word=before, names=names)
    return choices[key(text)]


def _text(part: Part, text: str) -> str:
    if not text:
        raise BadValueError
    return text


_READERS: dict[str, Callable[[Part, str], Value]] = {
    "place": lambda part, text: scene_words.place(text, int(part.least), int(part.most), scene_words.FARTHEST),
    "length": lambda part, text: scene_words.one(text, scene_words.METRES, part.least, part.most, "m"),
    "lengths": _lengths,
    "seconds": lambda part, text: scene_words.seconds(text, part.least, part.most),
    "share": lambda part, text: scene_words.one(text, scene_words.SHARES, 0, 1, "%"),
    "angle": lambda part, text: scene_words.one(text, scene_words.RADIANS, -7, 7, "rad"),
    "whole": _whole, "choice": _choice, "text": _text, "file": _text, "zone": _text,
    "flag": lambda part, word: part.choices.get(word.casefold(), part.choices.get("")),
}  # fmt: skip


def _seen(text: str) -> ValueParts:
    pieces = [piece.strip() for piece in text.split(",")]
    if len(pieces) != 3:
        raise BadValueError
    said: ValueParts = {"id": _whole(Part("", "id", "whole"), pieces[0]), "name": pieces[1]}
    return {**said, "seconds": scene_words.seconds(pieces[2], 0, LONGEST_SEEN)}


# ---- what goes without saying


def _complete(kind: ThingKind, said: ValueParts, colour: str) -> None:
    if kind.coloured:
        said["colour"] = colour or _PLAIN_COLOURS[kind.name]
    if kind.name == "ball":
        return
    if kind.name == "person":
        _face(said)
        return
    if "on" in said:
        _stand_on(said, "at")
    elif len(said["at"]) == 2:
        said["at"] = (*said["at"], 0.0)
    if kind.name == "table":
        said["size"] = (*said["size"], said.pop("height"))


def _face(said: ValueParts) -> None:
    """Add the height of somebody's face to their place, if it is not given: it depends on height and posture."""
    if "tall" in said:
        if isinstance(said["tall"], RandomRange):
            raise BadValueError("Write one height, not a range.")
        said.setdefault("posture", "standing")
    if len(said["at"]) == 3:
        return
    face: Amount = scene_words.FACE_HEIGHT
    if "posture" in said:
        share = STANDING_FACE if said["posture"] == "standing" else SEATED_FACE
        face = round(share * said.setdefault("tall", scene_words.CHILD), 3)
    said["at"] = (*said["at"], face)


def _stand_on(said: ValueParts, name: str) -> None:
    """`on table`: how high that is, is known when it happens; on the floor is 0."""
    if len(said[name]) == 3:
        raise BadValueError("Write two numbers, or leave out “on”.")
    said[name] = (*said[name], 0.0)
    if not said["on"]:
        del said["on"]


MOST_THINGS = 100  # at once: more make the simulator slow, and nobody could tell them apart
WAITING_US = 10_000_000  # how long a row is taken to wait for its event, when nobody says how long a run shall be
_NEEDS = ("move", "circle", "away", "look", "disappear")  # verbs of things that must be there


def in_order(actions: Sequence[SceneAction]) -> tuple[SceneAction, ...]:
    """Put the actions of a sheet in the order of their times; those that wait for an event as if it came at once."""
    starts = _times(actions, 0)
    return tuple(actions[i] for i in sorted(range(len(actions)), key=lambda i: starts[i][0]))


def scene_end_us(actions: Sequence[SceneAction]) -> int:
    """Return when the last action is over; circling counts one round, and a row waits ten seconds at most."""
    rows = sorted(actions, key=lambda a: a.row)
    last = 0
    for action, (_, latest) in zip(rows, _times(rows, WAITING_US), strict=True):
        lasting = action.values.get("seconds") or action.values.get("period") or 0.0
        last = max(last, latest + math.ceil(scene_words.ends(lasting)[1] * 1e6))
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
    """Report things that move before they have come, come twice, or stand on a table that is not there."""
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
