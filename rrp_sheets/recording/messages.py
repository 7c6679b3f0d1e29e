"""Messages of the program in recordings: a trace has them in English, a reader gets them in another language."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from string import Formatter
from typing import Any, NamedTuple

from rrp_sheets.texts import N_, LazyMessage, message_templates, sentences

_FEWEST_LETTERS = 8  # of a template apart from its places; a shorter one would fit too many texts of users
_SHORTEST = 5  # letters of a text without places
_FEWEST_WORDS = 3  # of a value in a message that may be a message itself, and not a name
_SENTENCE = re.compile(r"(?<=[.!?]) ")
_PLACE = re.compile(r"\{\w+[^{}]*\}")
_ODD = re.compile(r"\(\?P[<=](?![a-z_]+[>)])")  # a place without a plain name


class _Template(NamedTuple):
    text: str
    literal: str  # the longest part of it without places, by which it is looked for
    pattern: re.Pattern[str]
    letters: int
    numbers: frozenset[str]  # places that are formatted as numbers


def as_message(text: str) -> str:
    """Return the message of the program that a recorded English text is; any other text stays as it is.

    >>> as_message("Red ball appears at 1.00, 0.00, 0.40 m.").places["thing"]
    'Red ball'
    >>> as_message("The rows did not end within 0.15 s of Stop, so the engine was stopped.").places["before"].places
    {'seconds': 0.15}
    >>> type(as_message("Anna laughs")).__name__
    'str'
    """
    found = _message(text)
    if found is not None:
        return found
    parts = _SENTENCE.split(text)
    told = [_message(part) for part in parts] if len(parts) > 1 else []
    return sentences(*(part for part in told if part is not None)) if told and None not in told else text


@lru_cache(maxsize=2_000)
def _message(text: str) -> LazyMessage | None:
    by_text, by_literal = _known()
    if text in by_text:
        return LazyMessage(text)
    for template in by_literal:
        if template.literal in text and (match := template.pattern.fullmatch(text)):
            given = match.groupdict()
            places = {name: _number(v) if name in template.numbers else _value(v) for name, v in given.items()}
            try:
                found = LazyMessage(template.text, **places)
            except (ValueError, TypeError):  # a format that the value does not take
                continue
            if found == text:
                return found
    if text.endswith(".") and (without := _message(text[:-1])) is not None:  # its full stop was added
        return N_("{before}.", before=without)
    return None


def _number(text: str) -> Any:
    plain = text.replace(",", "")
    return float(plain) if "." in plain else int(plain)


def _value(text: str) -> str:
    return as_message(text) if len(text.split()) >= _FEWEST_WORDS else text


@lru_cache(maxsize=1)
def _known() -> tuple[frozenset[str], list[_Template]]:
    """Return the messages without places, and those with places, the most telling ones first."""
    every = message_templates()
    plain = frozenset(text for text in every if "{" not in text and len(text) >= _SHORTEST)
    placed = [template for text in every if _PLACE.search(text) for template in _template(text)]
    return plain, sorted(placed, key=lambda template: template.letters, reverse=True)


def _template(text: str) -> Iterator[_Template]:
    pattern, literals = "", [""]
    try:
        parts = list(Formatter().parse(text))
    except ValueError:  # a text in which braces are nothing special
        return
    for literal, name, _, _ in parts:
        pattern += re.escape(literal)
        literals.append(literal)
        if name:
            pattern += f"(?P={name})" if f"(?P<{name}>" in pattern else f"(?P<{name}>.+?)"
    letters = sum(letter.isalpha() for literal in literals for letter in literal)
    if letters >= _FEWEST_LETTERS and not _ODD.search(pattern):
        numbers = frozenset(name for _, name, spec, _ in parts if name and spec)
        yield _Template(text, max(literals, key=len), re.compile(pattern, re.DOTALL), letters, numbers)
