"""Texts."""

from __future__ import annotations

import re

from rrp_sheets.formulas.functions.define import define, listing, number, shown, text, whole
from rrp_sheets.formulas.limits import LONGEST_TEXT
from rrp_sheets.formulas.problems import FormulaProblem, wrong_kind
from rrp_sheets.model.values import Value

_NUMBER = re.compile(r"\s*[+-]?(\d{1,16}(\.\d{0,16})?|\.\d{1,16})\s*", re.ASCII)


def len_(value: Value) -> int:
    """How many characters a text has, or how many places a list.

    >>> len_("Kim"), len_([1, 2])
    (3, 2)
    """
    return len(value) if isinstance(value, str) else len(listing(value))


def upper(value: Value) -> str:
    """A text in capitals.

    >>> upper("Kim")
    'KIM'
    """
    return text(value).upper()


def lower(value: Value) -> str:
    """A text in small letters.

    >>> lower("Kim")
    'kim'
    """
    return text(value).lower()


def trim(value: Value) -> str:
    """A text without spaces at its ends and with single spaces inside.

    >>> trim("  red   ball ")
    'red ball'
    """
    return " ".join(text(value).split())


def concat(*values: Value) -> str:
    """Texts and numbers joined to one text.

    >>> concat("Kim", " ", 5)
    'Kim 5'
    """
    return "".join(shown(v) for v in values)


def str_(value: Value) -> str:
    """A number, or TRUE or FALSE, as a text.

    >>> str_(5)
    '5'
    """
    return shown(value)


def value(text_: Value) -> int | float:
    """The number that a text shows.

    >>> value("2.5")
    2.5
    """
    if isinstance(text_, (int, float)):
        return text_
    if not _NUMBER.fullmatch(text(text_)):
        raise FormulaProblem("FORM107", what="This text is not a number")
    return float(text(text_)) if "." in text(text_) else int(text(text_))


def left(value: Value, count: Value = 1) -> str:
    """The first characters of a text.

    >>> left("robot", 2)
    'ro'
    """
    return text(value)[: max(whole(count), 0)]


def right(value: Value, count: Value = 1) -> str:
    """The last characters of a text.

    >>> right("robot", 2)
    'ot'
    """
    n = max(whole(count), 0)
    return text(value)[-n:] if n else ""


def mid(value: Value, start: Value, count: Value) -> str:
    """Characters from the middle of a text; the first has number 1.

    >>> mid("robot", 2, 3)
    'obo'
    """
    first = max(whole(start), 1) - 1
    return text(value)[first : first + max(whole(count), 0)]


def substitute(value: Value, old: Value, new: Value) -> str:
    """A text with every `old` in it replaced by `new`.

    >>> substitute("red ball", "red", "blue")
    'blue ball'
    """
    if not text(old):
        return text(value)
    if text(value).count(text(old)) * len(text(new)) > LONGEST_TEXT:
        raise FormulaProblem("FORM105", reason=f"texts have at most {LONGEST_TEXT} characters")
    return text(value).replace(text(old), text(new))


def exact(first: Value, second: Value) -> bool:
    """Whether two texts are the same, capitals included (== takes “Red” and “red” for the same).

    >>> exact("Red", "red")
    False
    """
    return text(first) == text(second)


def fixed(value: Value, places: Value = 2) -> str:
    """A number as a text with so many decimal places.

    >>> fixed(0.5, 1)
    '0.5'
    """
    if isinstance(value, str):
        raise wrong_kind("a number", value)
    return format(number(value), f".{max(0, min(15, whole(places)))}f")


FUNCTIONS = (
    define(len_), define(upper), define(lower), define(trim), define(concat, "CONCATENATE"), define(str_),
    define(value, "NUMBER"), define(left), define(right), define(mid), define(substitute), define(exact), define(fixed),
)  # fmt: skip
