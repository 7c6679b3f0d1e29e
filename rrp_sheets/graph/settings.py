"""Parses the texts of device settings: their values, or a description of what is expected instead."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from rrp_sheets.devices import Robot, Setting
from rrp_sheets.devices.sound_files import is_plain
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.truths import truth_of
from rrp_sheets.model.values import Value

_HEX = re.compile(r"#[0-9a-f]{6}", re.IGNORECASE)
_DEGREES = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)\s*°")
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_WEAK, _STRONG = re.compile("[,，、]"), re.compile("[;；\n]")
_ENDS = frozenset(
    {"please", "thanks", "thank you", "robot", "nao", "too", "sir", "madam", "darling", "everybody", "everyone"}
)
_QUOTED = re.compile(r"""["“”„«][^"“”„«»]*["“”»]""")
LONGEST_SETTING = 1_000  # characters: minutes of speech
COLOURS = ("white", "red", "green", "blue", "yellow", "magenta", "cyan", "orange", "purple", "pink", "black")


def understand(setting: Setting, text: str, robot: Robot, mine: Sequence[str] = ()) -> tuple[Value, str]:
    """Return the value of a setting's text and, if it is not understood, what is expected (else an empty text).

    Args:
        setting: as the catalogue has it.
        text: what the cell says.
        robot: whose joints, postures, gestures and zones it may name.
        mine: names of the workbook's own that it may be: behaviours, gestures.
    """
    if setting.kind == "number":
        return _number(setting, text)
    if setting.kind == "truth":
        meant = truth_of(text)
        return meant, "" if meant is not None else "TRUE or FALSE (yes and no do as well)"
    if setting.kind == "angle":
        return _number(
            setting, str(math.radians(float(text.strip()[:-1]))) if _DEGREES.fullmatch(text.strip()) else text
        )
    names = _names_for(setting, robot, mine)
    if names is not None:
        by_key = {key(n): n for n in reversed(names)}
        return by_key.get(key(text)), "" if key(text) in by_key else _one_of(text, names)
    if setting.kind == "joint":
        k = key(text)
        if k in robot.joints:
            return robot.joints[k].name, ""
        if k in robot.groups:
            return next(g for g in robot.data["groups"] if key(g) == k), ""
        guess = nearest(text, [j.name for j in robot.joints.values()] + list(robot.data["groups"]))
        return None, Phrase("a joint such as {value}", value=guess or "HeadYaw")
    if setting.kind == "colour":
        if _HEX.fullmatch(text):
            return text.casefold(), ""
        wants = Phrase("a colour such as {value} or #ff8000", value=nearest(text, COLOURS) or "red")
        return key(text), "" if key(text) in COLOURS else wants
    if setting.kind == "words":
        words = tuple(dict.fromkeys(phrases(text)))
        good = bool(words) and len(text) <= LONGEST_SETTING
        return words, "" if good else "words with commas between them, for example yes, no"
    if setting.kind in ("language", "sound file"):
        return _language(text, robot) if setting.kind == "language" else _sound_file(text.strip())
    if setting.kind == "duration":
        us = parse_duration(text, bare="s")
        return us, "" if us is not None else Phrase("a time such as {value}", value=meant_duration(text, "s") or "2 s")
    return text, "" if len(text) <= LONGEST_SETTING else Phrase(
        "a text of at most {most} characters", most=LONGEST_SETTING
    )


def phrases(text: str) -> list[str]:
    """Return the words and phrases of a list.

    Semicolons or line breaks divide it where there are any, else commas. A phrase in quotation marks is one phrase.

    >>> phrases("yes, no"), phrases('"yes, please", no'), phrases("yes, please; no")
    (['yes', 'no'], ['yes, please', 'no'], ['yes, please', 'no'])
    """
    divider = _STRONG if _STRONG.search(_QUOTED.sub("", text)) else _WEAK
    found, at = [], 0
    marks = [m.span() for m in divider.finditer(_QUOTED.sub(lambda m: "x" * len(m[0]), text))]
    for start, end in [*marks, (len(text), len(text))]:
        piece = text[at:start].strip(" \t\n,，、")
        found.append(piece[1:-1].strip() if _QUOTED.fullmatch(piece) else piece)
        at = end
    return [phrase for phrase in found if phrase]


def doubtful_phrase(text: str) -> str:
    """Return the first phrase that keeps a comma only because semicolons or line breaks divide the list.

    >>> doubtful_phrase("yes, please; no"), doubtful_phrase('"yes, please"; no'), doubtful_phrase("yes, no")
    ('yes, please', '', '')
    """
    bare = _QUOTED.sub("", text)
    if not _STRONG.search(bare) or not _WEAK.search(bare):
        return ""
    quoted = {m[0][1:-1].strip() for m in _QUOTED.finditer(text)}
    return next((phrase for phrase in phrases(text) if _WEAK.search(phrase) and phrase not in quoted), "")


def divided_phrase(text: str) -> tuple[str, int]:
    """Return a list that commas divide although it may be one phrase, and the number of its parts; else a blank one.

    A part such as `please` is seldom a word of its own.

    >>> divided_phrase("yes, please"), divided_phrase("yes, no"), divided_phrase('"yes, please"')
    (('yes, please', 2), ('', 0), ('', 0))
    """
    bare = _QUOTED.sub("", text)
    if _STRONG.search(bare) or not _WEAK.search(bare):
        return "", 0
    parts = phrases(text)
    return (text.strip(), len(parts)) if any(part.casefold() in _ENDS for part in parts[1:]) else ("", 0)


def _sound_file(name: str) -> tuple[Value, str]:
    wants = "the name of a .wav file beside the workbook, such as song.wav, without a folder"
    return name, "" if is_plain(name) else wants


def _language(text: str, robot: Robot) -> tuple[Value, str]:
    """Return the code of a language, given its code or name (`German`); a robot without a list takes any."""
    languages = robot.languages
    code = text.strip().casefold().replace("_", "-")
    if code in languages or not languages:
        return code, ""
    names = {key(name): code for code, name in reversed(list(languages.items()))}
    if key(text) in names:
        return names[key(text)], ""
    guess = nearest(text, languages.values()) or nearest(text, languages)
    near = names.get(key(guess), guess) if guess else "de"
    return None, Phrase("a language such as {near} ({value})", near=near, value=languages[near])


def _names_for(setting: Setting, robot: Robot, mine: Sequence[str]) -> tuple[str, ...] | None:
    """Return the names that are allowed as a setting's value; None when its kind has no such list."""
    if setting.kind == "choice":
        return setting.choices
    if setting.kind == "zone":
        return robot.touch_zones
    if setting.kind == "posture":
        return robot.postures
    if setting.kind == "gesture":
        return (*mine, *robot.gestures)
    return tuple(mine) if setting.kind == "behaviour" else None


def _one_of(text: str, names: Sequence[str]) -> str:
    guess = nearest(text, names)
    listed = ", ".join(names)
    if not names:
        return "the name of a sheet with rows"
    if guess and len(names) > 3:
        return Phrase("{guess} (it can be {listed})", guess=guess, listed=listed)
    return Phrase("one of {listed}", listed=listed) if len(names) > 1 else listed


def _number(setting: Setting, text: str) -> tuple[Value, str]:
    low, high = setting.lower, setting.upper
    wants = Phrase("a number ({unit})", unit=setting.unit) if setting.unit else "a number"
    if low is not None and high is not None:
        unit = f" ({setting.unit})" if setting.unit else ""
        wants = Phrase("a number from {low:g} to {high:g}{unit}", low=low, high=high, unit=unit)
    bare = text.strip().removesuffix(setting.unit).strip() if setting.unit else text.strip()
    if not _NUMBER.fullmatch(bare):
        pointed = bare.replace(",", ".")
        return None, Phrase("{pointed}, with a decimal point", pointed=pointed) if _NUMBER.fullmatch(pointed) else wants
    number = float(bare)
    if not math.isfinite(number):
        return None, wants
    inside = (low is None or number >= low) and (high is None or number <= high)
    return (int(number) if number == int(number) else number), "" if inside else wants
