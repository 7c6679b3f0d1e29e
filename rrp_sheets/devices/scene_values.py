"""The Value cells of the Scene sheet, read by the tables in `scene_words`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import lru_cache

from rrp_sheets.devices.scene_amounts import METRES, RADIANS, SHARES, Amount, BadValueError, many, one, plain
from rrp_sheets.devices.scene_amounts import place as read_place
from rrp_sheets.devices.scene_amounts import seconds as read_seconds
from rrp_sheets.devices.scene_kinds import FARTHEST, Kind, Part, Verb
from rrp_sheets.devices.scene_words import CHILD, FACE_HEIGHT, KINDS
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.names import key
from rrp_sheets.model.scene import Range
from rrp_sheets.model.values import Value

SEATED_FACE, STANDING_FACE = 0.52, 0.92  # of a person's height: where the face is
LONGEST_SEEN = 31 * 24 * 3600.0  # s
_PLAIN_COLOURS = {"ball": "red", "cup": "white", "box": "brown"}
_EVERYWHERE = frozenset(p.word for k in KINDS.values() for v in k.verbs for p in v.parts if p.word)
Said = dict[str, Value]


def read_value(kind: Kind, verb: Verb, text: str, colour: str = "") -> Said:
    """What the Value cell of a Scene row says, by name.

    Args:
        kind: of the thing.
        verb: what it does.
        text: the cell's.
        colour: of the thing, as its name says.

    Raises:
        BadValueError: it cannot be understood.
    """
    if verb.action == "seen":
        return _seen(text)
    if any(part.kind == "rest" for part in verb.parts):
        said: Said = {verb.parts[0].name: text.strip()} if text.strip() else {}
    else:
        said = _parts(verb, plain(text))
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


def _parts(verb: Verb, text: str) -> Said:
    said: Said = {}
    for part, words in _cut(verb, text):
        if part.name in said:
            raise BadValueError(Phrase("Write “{value}” once.", value=part.word or words))
        said[part.name] = _READERS[part.kind](part, words)
    return said


def _cut(verb: Verb, text: str) -> Iterator[tuple[Part, str]]:
    """The text cut at its words: `to 1, 0, 0 in 2 s` is `to` and `in`; what comes before any word is the first part."""
    for part in verb.parts:
        if part.kind == "file" and (found := _file_of(part).search(text)):
            yield part, found[1].strip('"“”,;')
            text = f"{text[: found.start()]} {text[found.end() :]}".strip(" ,;")
    words = _words(verb)
    first, *pieces = _splitter(verb).split(text)
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


def _splitter(verb: Verb) -> re.Pattern[str]:
    """Cuts at the words of this verb, and at those of any other: these say nothing here."""
    return _any_of(tuple(sorted(_EVERYWHERE.union(_words(verb)), key=lambda w: (-len(w), w))))


@lru_cache(maxsize=64)
def _any_of(words: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile(rf"(?<!\w)({'|'.join(map(re.escape, words))})(?!\w)", re.IGNORECASE)


def _file_of(part: Part) -> re.Pattern[str]:
    names = "|".join(re.escape(w) for w in (*part.also, part.word))
    return re.compile(rf"(?<!\w)(?:{names})\s+(\"[^\"]*\"|“[^”]*”|[^\s,;]+)", re.IGNORECASE)


# ---- readers of one part


def _lengths(part: Part, text: str) -> tuple[Amount, ...]:
    sizes = many(text, part.least, part.most)
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
    meant = {key(word): value for word, value in part.choices.items()}
    if key(text) not in meant:
        words: dict[object, str] = {}
        for word, value in part.choices.items():
            words.setdefault(value, word)  # one for each
        raise BadValueError(
            Phrase("Behind “{word}” may stand: {names}.", word=part.word, names=", ".join(words.values()))
        )
    return meant[key(text)]


def _text(part: Part, text: str) -> str:
    if not text:
        raise BadValueError
    return text


_READERS: dict[str, Callable[[Part, str], Value]] = {
    "place": lambda part, text: read_place(text, int(part.least), int(part.most), FARTHEST),
    "length": lambda part, text: one(text, METRES, part.least, part.most, "m"),
    "lengths": _lengths,
    "seconds": lambda part, text: read_seconds(text, part.least, part.most),
    "share": lambda part, text: one(text, SHARES, 0, 1, "%"),
    "angle": lambda part, text: one(text, RADIANS, -7, 7, "rad"),
    "whole": _whole, "choice": _choice, "text": _text, "file": _text, "zone": _text,
    "flag": lambda part, word: part.choices.get(word.casefold(), part.choices.get("")),
}  # fmt: skip


def _seen(text: str) -> Said:
    pieces = [piece.strip() for piece in text.split(",")]
    if len(pieces) != 3:
        raise BadValueError
    whole = Part("", "id", "whole")
    return {"id": _whole(whole, pieces[0]), "name": pieces[1], "seconds": read_seconds(pieces[2], 0, LONGEST_SEEN)}


# ---- what goes without saying


def _complete(kind: Kind, said: Said, colour: str) -> None:
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


def _face(said: Said) -> None:
    """Where the face of somebody is who sits or stands, if its height is not given."""
    if "tall" in said:
        if isinstance(said["tall"], Range):
            raise BadValueError("Write one height, no range.")
        said.setdefault("posture", "standing")
    if len(said["at"]) == 3:
        return
    face: Amount = FACE_HEIGHT
    if "posture" in said:
        share = STANDING_FACE if said["posture"] == "standing" else SEATED_FACE
        face = round(share * said.setdefault("tall", CHILD), 3)
    said["at"] = (*said["at"], face)


def _stand_on(said: Said, name: str) -> None:
    """`on table`: how high that is, is known when it happens; on the floor is 0."""
    if len(said[name]) == 3:
        raise BadValueError("Write two numbers, or leave out “on”.")
    said[name] = (*said[name], 0.0)
    if not said["on"]:
        del said["on"]
