"""Texts between quotes: where they end, and what they say. Quotes may be straight or smart."""

from __future__ import annotations

import re

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas.problems import FormulaProblem

_DOUBLE, _SINGLE = '"“”„‟＂', "'‘’‚‛＇"
QUOTES = _DOUBLE + _SINGLE
PAIRS = {
    "“": '”"＂',
    "„": '“”"',
    "‟": '”"',
    "”": '”"',
    "＂": '＂"',
    "‘": "’'＇",
    "‚": "‘’'",
    "‛": "’'",
    "’": "’'",
    "＇": "＇'",
}
_ESCAPES = {"n": "\n", "t": "\t", "\\": "\\", '"': '"', "'": "'", "\n": ""}
_CODED = {"x": 2, "u": 4, "U": 8}
_HEX = re.compile(r"[0-9a-fA-F]+")


def closing(typed: str, at: int) -> int:
    """The place of the quote that ends the text which begins at a place."""
    opener = typed[at]
    kind = _DOUBLE if opener in _DOUBLE else _SINGLE
    end = _next(typed, at, PAIRS.get(opener, opener))
    if end < 0:  # one of the quotes was made a smart one, or the wrong one
        end = _next(typed, at, kind)
    if end >= 0:
        return end
    remedy = "Close the text with the same quote as at its beginning."
    if opener == "'" and typed[at - 1 : at].isalnum():
        remedy = 'Put a text with an apostrophe between double quotes: "it\'s".'
    if typed.endswith("\\" + opener):
        remedy = "The backslash makes the last quote a part of the text: write two backslashes."
    raise FormulaProblem("FORM001", at, max(len(typed) - at, 1),
                         reason="a quote is missing at the end of a text", remedy=remedy)  # fmt: skip


def _next(typed: str, at: int, closers: str) -> int:
    if typed[at] == "'" and typed.startswith("'''", at):
        raise FormulaProblem("FORM003", at, 3, what="A triple quote", remedy="Write one quote on each side.")
    end = at + 1
    while end < len(typed):
        c = typed[end]
        if c == "\\":
            end += 2
        elif c not in closers:
            end += 1
        elif typed[end + 1 : end + 2] == c:  # doubled: a part of the text
            end += 2
        elif c in "’＇" and typed[end - 1].isalnum() and typed[end + 1 : end + 2].isalnum():
            end += 1  # an apostrophe
        else:
            return end
    return -1


def decode(typed: str, opener: int, start: int, end: int) -> str:
    """The characters of a text: doubled quotes are one, and a backslash gives what follows it a meaning."""
    body = typed[start:end]
    kind = PAIRS.get(typed[opener], typed[opener])
    if "\\" not in body and not any(c in body for c in kind):
        return body
    found: list[str] = []
    i = 0
    while i < len(body):
        c, following = body[i], body[i + 1 : i + 2]
        if c == "\\":
            value, used = _escape(body, i, start)
            found.append(value)
            i += used
            continue
        found.append(c)
        i += 2 if c in kind and following == c else 1
    return "".join(found)


def _escape(body: str, i: int, start: int) -> tuple[str, int]:
    following = body[i + 1 : i + 2]
    if following in _ESCAPES:
        return _ESCAPES[following], 2
    if following in QUOTES:
        return following, 2
    if following in _CODED:
        digits = body[i + 2 : i + 2 + _CODED[following]]
        if re.fullmatch(r"[0-9a-fA-F]+", digits) and len(digits) == _CODED[following] and int(digits, 16) < 0x110000:
            return chr(int(digits, 16)), 2 + len(digits)
    if following and following in "xuUN01234567abfrv":
        raise FormulaProblem("FORM003", start + i, 2, what=Phrase("“\\{following}” in a text", following=following),
                             remedy="Write the character itself; for a backslash, write two.")  # fmt: skip
    return "\\", 1
