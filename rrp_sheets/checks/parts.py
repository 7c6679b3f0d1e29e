"""Reads the parts of the cells Send and Expect of a test: plain values, values of fields, and formulas."""

from __future__ import annotations

import re

from rrp_sheets.formulas import Formula, FormulaProblem, Scope, compile_formula
from rrp_sheets.formulas.limits import LARGEST_NUMBER
from rrp_sheets.model.values import Value

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE | re.ASCII)
_WORDS: dict[str, Value] = {"true": True, "false": False, "blank": None}
_QUOTES = {'"': '"', "'": "'", "“": "”", "„": "“"}
_FIELD = re.compile(r"\s*(?P<name>[^\W\d][\w \-]*?)\s*=(?!=)\s*(?P<value>.*?)\s*", re.DOTALL)
_OPEN, _CLOSE = "([{", ")]}"
_MINUS = str.maketrans("−–", "--")


class TooLarge(ValueError):
    """Raised for a number beyond those that formulas work with."""


def literal(text: str) -> tuple[bool, Value]:
    """Return whether a text is a number, TRUE, FALSE, blank or a text in quotes, and its value.

    Raises:
        TooLarge: a number beyond what formulas can work with.

    >>> literal("0.5"), literal('"Head"'), literal("true"), literal("Hello")
    ((True, 0.5), (True, 'Head'), (True, True), (False, None))
    """
    short = text.strip()
    if short.casefold() in _WORDS:
        return True, _WORDS[short.casefold()]
    digits = short.translate(_MINUS)
    if _NUMBER.fullmatch(digits):
        return True, _number(digits)
    quoted = in_quotes(short)
    return (False, None) if quoted is None else (True, quoted)


def _number(digits: str) -> int | float:
    found = float(digits)
    if abs(found) > LARGEST_NUMBER:
        raise TooLarge(digits)
    return found if any(c in digits for c in ".eE") else int(digits)


def in_quotes(text: str) -> str | None:
    """Return the text between quotes, or None when it is not one text in quotes; a quote within it is written twice.

    >>> in_quotes('"Hello"'), in_quotes('"a ""b"" c"'), in_quotes('"a" & "b"')
    ('Hello', 'a "b" c', None)
    """
    closer = _QUOTES.get(text[:1], "")
    if not closer or len(text) < 2 or text[-1] not in (closer, text[0]):
        return None
    inner = text[1:-1]
    for quote in {text[0], closer}:
        inner = inner.replace(quote * 2, "\0") if quote in "\"'" else inner
        if quote in inner:
            return None
    return None if "\\" in inner else inner.replace("\0", text[0])


def fields(text: str) -> list[tuple[str, str]] | None:
    """Return the fields that a text gives values, or None when not every part of it is `field=value`.

    Parts are separated by `;` (or line breaks), or by commas where that is the only reading.

    >>> fields('x=0.1; zone="a;b"'), fields("x=1, y=[1, 2]"), fields("x == 1"), fields("Hello")
    ([('x', '0.1'), ('zone', '"a;b"')], [('x', '1'), ('y', '[1, 2]')], None, None)
    """
    if "=" not in text:
        return None
    for separators in (";\n,", ";\n"):
        found = [_FIELD.fullmatch(p) for p in _split(text, separators) if p.strip()]
        if found and all(found):
            return [(m["name"], m["value"]) for m in found if m]
    return None


def _split(text: str, separators: str) -> list[str]:
    """Return the parts between separators that stand outside of quotes and brackets."""
    parts, start, depth, quote = [], 0, 0, ""
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in _QUOTES and not (c == "'" and i and text[i - 1].isalnum()):
            quote = _QUOTES[c]
        elif c in _OPEN:
            depth += 1
        elif c in _CLOSE:
            depth = max(0, depth - 1)
        elif c in separators and not depth:
            parts.append(text[start:i])
            start = i + 1
    return [*parts, text[start:]]


def without_equals(text: str) -> str:
    """Return the text without the `=` that people write before formulas by habit.

    >>> without_equals("= 5"), without_equals("== 5")
    ('5', '== 5')
    """
    return text[1:].lstrip() if text.startswith("=") and not text.startswith("==") else text


def compiled(text: str, scope: Scope) -> Formula | FormulaProblem:
    """Return the formula, or the problem with it."""
    try:
        return compile_formula(text, scope)
    except FormulaProblem as problem:
        return problem
