"""Functions that search, cut, join and convert texts."""

from __future__ import annotations

import re

from rrp_sheets.formulas.functions.define import (
    bounded,
    define,
    islist,
    listing,
    number,
    shown,
    text,
    too_long,
    truth,
    whole,
)
from rrp_sheets.formulas.functions.maths import round_
from rrp_sheets.formulas.limits import LONGEST_TEXT, Charge, free, searching
from rrp_sheets.formulas.problems import FormulaProblem, wrong_kind
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_

_LAYOUT = re.compile(r"(?P<digits>(?P<thousands>#,##)?[#0]{1,15})(?P<places>\.0{1,15})?(?P<percent>%?)")
_NUMBER = re.compile(r"\s*[+-]?(\d{1,16}(\.\d{0,16})?|\.\d{1,16})\s*", re.ASCII)


def len_(value: Value) -> int:
    """The number of characters of a text, or of places of a list.

    >>> len_("Kim"), len_([1, 2])
    (3, 2)
    """
    if isinstance(value, str) or islist(value):
        return len(value)
    raise wrong_kind(N_("a text or a list"), value)


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
    """Texts and numbers, and those in lists, joined to one text.

    >>> concat("Kim", " ", 5), concat(["a", "b"])
    ('Kim 5', 'ab')
    """
    parts = [shown(m) for v in values for m in (listing(v) if islist(v) else [v])]
    if sum(map(len, parts)) > LONGEST_TEXT:
        raise too_long()
    return "".join(parts)


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
        raise FormulaProblem("FORM107", what=N_("This text is not a number"))
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


def substitute(value: Value, old: Value, new: Value, which: Value = None, *, charge: Charge = free) -> str:
    """A text with every `old` in it replaced by `new`, or only the first, second, … one.

    >>> substitute("red ball", "red", "blue"), substitute("a-b-c", "-", "+", 2)
    ('blue ball', 'a-b+c')
    """
    given, before, after = text(value), text(old), shown(new)
    if not before:
        return given
    charge(2 * searching(before, given))
    if given.count(before) * len(after) > LONGEST_TEXT:
        raise too_long()
    if which is None:
        return given.replace(before, after)
    parts = given.split(before)
    n = whole(which)
    if n < 1:
        raise FormulaProblem("FORM107", what=N_("The first one has the number 1"))
    if n >= len(parts):
        return given
    return before.join(parts[:n]) + after + before.join(parts[n:])


def find(what: Value, value: Value, start: Value = 1, *, charge: Charge = free) -> int:
    """The place of a text in another, capitals considered; the first letter has number 1. Not there: an error.

    >>> find("ball", "red ball")
    5
    """
    return _find(text(what), text(value), start, "FIND", charge)


def search(what: Value, value: Value, start: Value = 1, *, charge: Charge = free) -> int:
    """The place of a text in another, without regard to capitals; the first letter has number 1. Not there: an error.

    >>> search("BALL", "red ball")
    5
    """
    return _find(text(what).casefold(), text(value).casefold(), start, "SEARCH", charge)


def _find(what: str, value: str, start: Value, name: str, charge: Charge) -> int:
    if whole(start) < 1:
        raise FormulaProblem("FORM107", what=N_("The first letter has the number 1"))
    charge(searching(what, value))
    at = value.find(what, whole(start) - 1)
    if at < 0:
        advice = N_("{name} does not find the text; to ask whether it is there, write what in text", name=name)
        raise FormulaProblem("FORM107", what=advice)
    return at + 1


def startswith(value: Value, what: Value) -> bool:
    """TRUE when a text begins with another, without regard to capitals.

    >>> startswith("Red ball", "red")
    True
    """
    return text(value).casefold().startswith(text(what).casefold())


def endswith(value: Value, what: Value) -> bool:
    """TRUE when a text ends with another, without regard to capitals.

    >>> endswith("Red ball", "BALL")
    True
    """
    return text(value).casefold().endswith(text(what).casefold())


def proper(value: Value, *, charge: Charge = free) -> str:
    """A text with a capital at the beginning of each word.

    >>> proper("red ball, kim's")
    "Red Ball, Kim's"
    """
    charge(len(text(value)) // 5)  # each word is changed by itself
    return re.sub(r"[^\W\d_]+('[^\W\d_]+)?", lambda m: m[0][:1].upper() + m[0][1:].lower(), text(value))


def rept(value: Value, times: Value) -> str:
    """A text so many times.

    >>> rept("ha", 3)
    'hahaha'
    """
    n = whole(times)
    if n < 0:
        raise FormulaProblem("FORM107", what=N_("A text cannot be repeated less than 0 times"))
    if len(text(value)) * n > LONGEST_TEXT:
        raise too_long()
    return text(value) * n


def textjoin(between: Value, skip_blanks: Value, *values: Value) -> str:
    """Texts and numbers joined with something between them; blanks are left out when the second value is TRUE.

    >>> textjoin(", ", True, ["red", None, "blue"], 3)
    'red, blue, 3'
    """
    skip, members = truth(skip_blanks), [m for v in values for m in (listing(v) if islist(v) else [v])]
    parts = ["" if m is None else shown(m) for m in members if not (skip and m in (None, ""))]
    if sum(len(p) + len(text(between)) for p in parts) > LONGEST_TEXT + len(text(between)):
        raise too_long()
    return text(between).join(parts)


def textsplit(value: Value, between: Value = " ", *, charge: Charge = free) -> list[Value]:
    """The parts of a text, which something stands between.

    >>> textsplit("red, blue", ", ")
    ['red', 'blue']
    """
    if not text(between):
        raise FormulaProblem("FORM107", what=N_("TEXTSPLIT needs the separator between the parts"))
    charge(searching(text(between), text(value)))
    return bounded(text(value).split(text(between)))  # type: ignore[no-any-return]


def exact(first: Value, second: Value) -> bool:
    """TRUE when two texts are the same, capitals included (== takes “Red” and “red” for the same).

    >>> exact("Red", "red")
    False
    """
    return text(first) == text(second)


def text_(value: Value, layout: Value) -> str:
    """A number as a text in a layout: digits as in `0.00`, a separator for thousands as in `#,##0`, or percent `0%`.

    >>> text_(2.5, "0.00"), text_(1234.5, "#,##0"), text_(0.256, "0.0%")
    ('2.50', '1,235', '25.6%')
    """
    if isinstance(value, str):
        raise wrong_kind(N_("a number"), value)
    found = _LAYOUT.fullmatch(text(layout))
    if not found:
        raise FormulaProblem("FORM107", what=N_("TEXT knows layouts such as 0.00, #,##0 and 0%"))
    places = len((found["places"] or ".")[1:])
    n = round_(number(value) * (100 if found["percent"] else 1), places)
    shown_ = format(n, f"{',' if found['thousands'] else ''}.{places}f")
    whole_digits = found["digits"].replace(",", "").replace("#", "")
    sign, digits = ("-", shown_[1:]) if shown_.startswith("-") else ("", shown_)
    missing = len(whole_digits) - len(digits.split(".")[0].replace(",", ""))
    return f"{sign}{'0' * max(missing, 0)}{digits}{found['percent']}"


def fixed(value: Value, places: Value = 2) -> str:
    """A number as a text with so many decimal places.

    >>> fixed(0.5, 1), fixed(2.345, 2)
    ('0.5', '2.35')
    """
    if isinstance(value, str):
        raise wrong_kind(N_("a number"), value)
    n = max(0, min(15, whole(places)))
    return format(round_(number(value), n), f".{n}f")


FUNCTIONS = (
    define(len_, bounds=(0, 2_000)), define(upper), define(lower), define(proper), define(trim),
    define(concat, "CONCATENATE"), define(textjoin), define(textsplit), define(str_), define(value, "NUMBER"),
    define(text_), define(fixed),
    define(left), define(right), define(mid), define(find), define(search), define(startswith), define(endswith),
    define(substitute), define(rept), define(exact),
)  # fmt: skip
