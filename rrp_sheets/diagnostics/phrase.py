"""A phrase: an English text that still knows how it was made, so that it can be said in another language.

The program thinks in English: what it finds is a text like any other, to be sorted, compared and shown. A language is
a table from English templates to its own (`languages.py`), and a phrase has kept its template and what was
put into it.
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
    """A text made from a `str.format` template; as a text it is English.

    >>> str(Phrase("Did you mean {guess}?", guess="redBall"))
    'Did you mean redBall?'
    """

    template: str
    places: Mapping[str, Any]

    def __new__(cls, template: str, /, **places: Any) -> Phrase:
        """A template with its places filled."""
        self = super().__new__(cls, template.format(**places))
        self.template = template
        self.places = places
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.template, dict(self.places))


def _made(template: str, places: Mapping[str, Any]) -> Phrase:
    return Phrase(template, **places)


def sentences(*parts: str) -> str:
    """Sentences one after the other, without the empty ones."""
    return _chain([part for part in parts if part], "{before} {after}")


def listed(things: Sequence[str], joiner: str = "") -> str:
    """`a, b and c`; without joiner `a, b, c`; with one that begins with a comma `a, then b, then c`.

    >>> listed(["a", "b", "c"], "and")
    'a, b and c'
    """
    if not joiner or len(things) < 2:
        return _chain(things, "{before}, {after}")
    if joiner.startswith(","):
        return _chain(things, "{before}" + joiner + " {after}")
    return _chain([_chain(things[:-1], "{before}, {after}"), things[-1]], "{before} " + joiner + " {after}")


def counted(counts: Mapping[str, int]) -> str:
    """How many there are of each, by their English words; without any that everything is in order.

    >>> counted({"error": 2, "warning": 1}), counted({"error": 0})
    ('2 errors, 1 warning', 'Everything is in order.')
    """
    some = [Phrase(f"{{n}} {word}{'s' if n != 1 else ''}", n=n) for word, n in counts.items() if n]
    return listed(some) if some else "Everything is in order."


def _chain(things: Sequence[str], template: str) -> str:
    """Joined half by half: joined one by one, some hundred would be a phrase in a phrase too many times."""
    if len(things) < 2:
        return things[0] if things else ""
    half = len(things) // 2
    return Phrase(template, before=_chain(things[:half], template), after=_chain(things[half:], template))


def capital(text: str) -> str:
    """The text as it stands at the beginning of a sentence."""
    return _recased(text, str.upper)


def small(text: str) -> str:
    """The text as it stands within a sentence."""
    return _recased(text, str.lower)


def _recased(text: str, case: Callable[[str], str]) -> str:
    if not isinstance(text, Phrase):
        return case(text[:1]) + text[1:]
    first = _FIRST.match(text.template)
    if first is None:
        return Phrase(case(text.template[:1]) + text.template[1:], **text.places)
    return Phrase(text.template, **{**text.places, first[1]: _recased(str_of(text.places[first[1]]), case)})


def str_of(value: object) -> str:
    """A place's value as a text; a phrase stays one."""
    return value if isinstance(value, str) else str(value)
