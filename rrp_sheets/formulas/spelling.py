"""From what the user typed to Python's spelling. The cell keeps what was typed.

Folded here: a leading `=`, full-width characters, smart quotes, dashes and minus signs, no-break spaces, and
TRUE/FALSE/BLANK in any case. Texts between quotes stay as they are.
"""

from __future__ import annotations

import re
import unicodedata

from rrp_sheets.formulas.limits import LONGEST_FORMULA
from rrp_sheets.formulas.problems import FormulaProblem

_QUOTES = {"“": '"', "”": '"', "„": '"', "‟": '"', "‘": "'", "’": "'", "‚": "'", "＂": '"', "＇": "'"}
_CLOSERS = {'"': '"“”„‟＂', "'": "'‘’‚＇"}
_SIGNS = {
    "–": "-",
    "—": "-",
    "−": "-",
    "‐": "-",
    "‑": "-",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "×": "*",
    "÷": "/",
    "\u00a0": " ",
    "\u202f": " ",
    "\u3000": " ",
}
_WORDS = {"true": "True", "false": "False", "blank": "None", "none": "None"}
_WORD = re.compile(r"(?<![\w.])(true|false|blank|none)(?![\w(])", re.IGNORECASE)


def to_python(typed: str) -> str:
    """The formula in Python's spelling.

    Raises:
        FormulaProblem: when it is too long, empty, or holds characters that cannot be typed.

    >>> to_python("=distance – 1")
    'distance - 1'
    >>> to_python("“I see RED”")
    '"I see RED"'
    """
    text = typed.strip()
    text = text[1:].lstrip() if text.startswith("=") and not text.startswith("==") else text
    if not text:
        raise FormulaProblem("FORM001", 0, reason="there is nothing in it", remedy="Write a formula.")
    if len(text) > LONGEST_FORMULA:
        raise FormulaProblem("FORM002", LONGEST_FORMULA, reason=f"it has more than {LONGEST_FORMULA} characters")
    for i, c in enumerate(text):
        if unicodedata.category(c) in ("Cc", "Cs", "Co", "Cn") and c not in "\n\t":
            raise FormulaProblem("FORM001", i, reason="there is a character in it that cannot be seen",
                                 remedy="Type the formula again.")  # fmt: skip
    return "".join(_fold(piece) if not quoted else piece for quoted, piece in _pieces(text)).replace("\n", " ")


def _pieces(text: str) -> list[tuple[bool, str]]:
    """The text cut into what is between quotes (with straight quotes around it) and what is not."""
    pieces: list[tuple[bool, str]] = []
    plain = ""
    i = 0
    while i < len(text):
        quote = _QUOTES.get(text[i], text[i])
        if quote not in "\"'":
            plain += text[i]
            i += 1
            continue
        closers = _CLOSERS[quote] if text[i] != quote else quote
        end = i + 1
        while end < len(text) and text[end] not in closers:
            end += 2 if text[end] == "\\" else 1
        body = text[i + 1 : end]
        if quote != text[i]:
            body = body.replace(quote, "\\" + quote)
        pieces += [(False, plain), (True, quote + body + (quote if end < len(text) else ""))]
        plain = ""
        i = end + 1
    return [*pieces, (False, plain)]


def _fold(text: str) -> str:
    folded = unicodedata.normalize("NFKC", "".join(_SIGNS.get(c, c) for c in text))
    return _WORD.sub(lambda m: _WORDS[m[0].casefold()], folded)
