"""English texts that keep their template and its values, so that they can be translated.

Findings are made in English, as strings that can be sorted, compared and shown. A language is a table from English
templates to its own (`languages.py`), which is applied to the template and the values that a phrase has kept.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

_FIRST = re.compile(r"\{(\w+)\}")

SLOTS = frozenset((
    "after", "are", "at", "before", "between", "can", "come", "describe", "example", "first", "gets", "help", "hint",
    "how", "kind", "kind2", "leave", "limit", "longest", "meant", "message", "named", "needed", "needs", "part",
    "problem", "reason", "remedy", "resource", "rows", "second", "shown", "takes", "then", "usage", "use", "values",
    "wants", "what", "when", "why",
))  # fmt: skip
"""The places that hold the program's words. In the others stands what the user typed, which is never translated."""


class Phrase(str):
    """Text made from a `str.format` template; as a string it is English.

    >>> str(Phrase("Did you mean {guess}?", guess="redBall"))
    'Did you mean redBall?'
    """

    template: str
    places: Mapping[str, Any]

    def __new__(cls, template: str, /, **places: Any) -> Phrase:
        """Fill the places of a template."""
        self = super().__new__(cls, template.format(**places))
        self.template = template
        self.places = places
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.template, dict(self.places))


def _made(template: str, places: Mapping[str, Any]) -> Phrase:
    return Phrase(template, **places)


def sentences(*parts: str) -> str:
    """Join sentences, without the empty ones."""
    return _chain([part for part in parts if part], "{before} {after}")


def listed(things: Sequence[str], joiner: str = "") -> str:
    """Return `a, b and c`; without joiner `a, b, c`; with one that begins with a comma `a, then b, then c`.

    >>> listed(["a", "b", "c"], "and")
    'a, b and c'
    """
    if not joiner or len(things) < 2:
        return _chain(things, "{before}, {after}")
    if joiner.startswith(","):
        return _chain(things, "{before}" + joiner + " {after}")
    return _chain([_chain(things[:-1], "{before}, {after}"), things[-1]], "{before} " + joiner + " {after}")


def counted(counts: Mapping[str, int]) -> str:
    """Return the counts with their English words, or a text that everything is in order if all are zero.

    >>> counted({"error": 2, "warning": 1}), counted({"error": 0})
    ('2 errors, 1 warning', 'Everything is in order.')
    """
    some = [Phrase(f"{{n}} {word}{'s' if n != 1 else ''}", n=n) for word, n in counts.items() if n]
    return listed(some) if some else "Everything is in order."


def _chain(things: Sequence[str], template: str) -> str:
    """Join texts half by half, as joining hundreds of them one by one would nest phrases too deeply."""
    if len(things) < 2:
        return things[0] if things else ""
    half = len(things) // 2
    return Phrase(template, before=_chain(things[:half], template), after=_chain(things[half:], template))


def capital(text: str) -> str:
    """Return the text as it is written at the beginning of a sentence."""
    return _recased(text, str.upper)


def small(text: str) -> str:
    """Return the text as it is written within a sentence."""
    return _recased(text, str.lower)


def _recased(text: str, case: Callable[[str], str]) -> str:
    if not isinstance(text, Phrase):
        return case(text[:1]) + text[1:]
    first = _FIRST.match(text.template)
    if first is None:
        return Phrase(case(text.template[:1]) + text.template[1:], **text.places)
    return Phrase(text.template, **{**text.places, first[1]: _recased(str_of(text.places[first[1]]), case)})


def str_of(value: object) -> str:
    """Return a place's value as a text; a phrase stays one."""
    return value if isinstance(value, str) else str(value)
