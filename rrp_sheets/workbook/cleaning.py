"""Cleaning of cells' texts before the program works with them. Tolerant, never guessing; the original is kept."""

from __future__ import annotations

import bisect
import re
from collections.abc import Mapping

_DROPPED = dict.fromkeys(map(ord, "\u200b\u200c\u200d\u2060\ufeff\u200e\u200f\u00ad"))
_SPACES = dict.fromkeys((0x09, 0xA0, 0x1680, *range(0x2000, 0x200B), 0x202F, 0x205F, 0x3000), " ")
_LINES = {ord(c): "\n" for c in "\u2028\u2029\u0085\v\f"}
_ALWAYS = {**_DROPPED, **_SPACES, **_LINES}
_FULL_WIDTH = {code: chr(code - 0xFEE0) for code in range(0xFF01, 0xFF5F)}
_DOUBLE, _SINGLE = "“”„‟", "‘’‚‛"
_QUOTES = {**{ord(c): '"' for c in _DOUBLE}, **{ord(c): "'" for c in _SINGLE}}
_QUOTE_KINDS = {
    **{'"': '"', "＂": '"', "'": "'", "＇": "'"},
    **dict.fromkeys(_DOUBLE, _DOUBLE),
    **dict.fromkeys(_SINGLE, _SINGLE),
}
_QUOTE = re.compile(f"[{''.join(_QUOTE_KINDS)}]")
_LONGEST_FORMULA = 2_000  # longer ones are refused later on, so their quotes do not matter
_NAME = {**_FULL_WIDTH, **_QUOTES}
_ALWAYS_ONE, _NAME_ONE, _FULL_WIDTH_ONE = (
    re.compile(f"[{re.escape(''.join(map(chr, codes)))}]") for codes in (_ALWAYS, _NAME, _FULL_WIDTH)
)
_EXCEL_TOKENS = re.compile(r'"(?:[^"]|"")*"|_xlfn\.SINGLE\(|_xl(?:fn|ws|pm|udf)\.|[()]', re.IGNORECASE)
_FIELDS = re.compile(r"\w[\w -]*[=＝]")

_ERRORS = "NAME? REF! VALUE! DIV/0! N/A NUM! NULL! SPILL! CALC! FIELD! BLOCKED! CONNECT! BUSY! UNKNOWN! GETTING_DATA"
ERROR_VALUES = frozenset(f"#{name}" for name in _ERRORS.split())


def _changed(text: str, by: Mapping[int, str | None], one: re.Pattern[str]) -> str:
    """The text with characters changed; to look whether it has `one` of them takes a fiftieth of changing it."""
    return text.translate(by) if one.search(text) else text


def clean_spaces(text: str) -> str:
    """No-break and other wide spaces become spaces, invisible marks go, edges are stripped.

    >>> clean_spaces("  Red\u00a0ball ")
    'Red ball'
    """
    return _changed(text, _ALWAYS, _ALWAYS_ONE).strip()


def clean_name(text: str) -> str:
    """A name, a number or a duration: full-width characters and smart quotes are folded too.

    >>> clean_name("’Ｒｅｄ　ｂａｌｌ１")
    'Red ball1'
    """
    text = clean_spaces(text)
    return _without_apostrophe(text if text.isascii() else clean_spaces(_changed(text, _NAME, _NAME_ONE)))


def clean_prose(text: str) -> str:
    """A text for people: its quotes and its full-width characters stay, unless all of it is full-width Latin.

    >>> clean_prose("１２"), clean_prose("「何？」"), clean_prose("Don’t")
    ('12', '「何？」', 'Don’t')
    """
    text = clean_spaces(text)
    if not text.isascii():
        folded = _changed(text, _FULL_WIDTH, _FULL_WIDTH_ONE)
        if folded.isascii():
            text = folded.strip()
    return _without_apostrophe(text)


def clean_fields(text: str) -> str:
    """A value to send or expect: fields are written like formulas (`zone="Head"`), all else is a text for people.

    >>> clean_fields("zone＝“Head”"), clean_fields("Don’t “go”")
    ('zone="Head"', 'Don’t “go”')
    """
    text = clean_spaces(text)
    return clean_formula(text) if _FIELDS.match(text) else clean_prose(text)


def clean_formula(text: str) -> str:
    r"""A formula: one leading apostrophe and then one leading `=` go; inside its texts the letters stay.

    >>> clean_formula("'=ball.x > ３"), clean_formula("“don’t” & ‘a’"), clean_formula("'a' & 'b'")
    ('ball.x > 3', '"don’t" & \'a\'', "'a' & 'b'")
    """
    text = _without_apostrophe(clean_spaces(text))
    text = text if text.isascii() or len(text) > _LONGEST_FORMULA else _fold_formula(text)
    return text[1:].lstrip() if text.startswith("=") else text


def from_excel(formula: str) -> str:
    """A formula as Excel stores it, as the user typed it.

    >>> from_excel('_xlfn.SINGLE(ball)+_xlfn._xlws.FILTER(a,"SINGLE(b)")')
    'ball+FILTER(a,"SINGLE(b)")'
    """
    if "_xl" not in formula.casefold():
        return formula
    out: list[str] = []
    brackets: list[int] = []  # where in `out` the open ones stand
    last = 0
    for match in _EXCEL_TOKENS.finditer(formula):
        token = match[0]
        out.append(formula[last : match.start()])
        last = match.end()
        if token.casefold().endswith("single("):
            brackets.append(len(out))
            out.append("")
        elif token == "(":
            brackets.append(-1)
            out.append(token)
        elif token == ")":
            out.append("" if brackets and brackets.pop() >= 0 else token)
        elif token.startswith('"'):
            out.append(token)
    for at in brackets:
        if at >= 0:  # never closed: as it stands
            out[at] = "SINGLE("
    return "".join([*out, formula[last:]])


def _without_apostrophe(text: str) -> str:
    """Without the leading apostrophe by which spreadsheets mark a text; the quote of a `'text'` stays."""
    if re.match(r"[‘’]\s*[=＝]", text):  # a smart one before a formula can be nothing else
        return text[1:].lstrip()
    if not text.startswith("'"):
        return text
    outside = re.sub(r'"[^"]*"', "", text)
    return text[1:].lstrip() if outside.count("'") % 2 else text


def _fold_formula(text: str) -> str:
    """Smart quotes that serve as quotes become straight ones; everything outside of texts is folded.

    A text that begins with a straight quote ends with one; one that begins with a smart quote ends with the next
    smart quote of its kind, or if there is none with a straight one. An apostrophe after a letter begins no text.
    """
    closers = _closers(text)
    out: list[str] = []
    i = 0
    while match := _QUOTE.search(text, i):
        start = match.start()
        out.append(text[i:start].translate(_FULL_WIDTH))
        opener = text[start]
        kind = _QUOTE_KINDS[opener]
        straight = '"' if kind in ('"', _DOUBLE) else "'"
        if straight == "'" and start and text[start - 1].isalnum():
            out.append(opener)  # an apostrophe
            i = start + 1
            continue
        end = -1 if kind == straight else _next(closers[kind], start)
        end = _next(closers[straight], start) if end < 0 else end
        inner = text[start + 1 : end if end >= 0 else len(text)]
        if kind != straight and end >= 0 and _QUOTE_KINDS[text[end]] != straight:
            inner = inner.replace(straight, straight * 2)
        out.append(straight + inner + (straight if end >= 0 else ""))
        i = end + 1 if end >= 0 else len(text)
    return "".join([*out, text[i:].translate(_FULL_WIDTH)])


def _closers(text: str) -> dict[str, list[int]]:
    """Return the places of quotes that can end a text, by kind: no escaped ones, no apostrophes between two letters."""
    found: dict[str, list[int]] = {'"': [], "'": [], _DOUBLE: [], _SINGLE: []}
    for match in _QUOTE.finditer(text):
        i = match.start()
        kind = _QUOTE_KINDS[match[0]]
        if text[i - 1 : i] == "\\":
            continue
        if kind in ('"', _DOUBLE) or not (text[i - 1 : i].isalnum() and text[i + 1 : i + 2].isalnum()):
            found[kind].append(i)
    return found


def _next(places: list[int], after: int) -> int:
    """The first place after another one; -1 if there is none."""
    at = bisect.bisect_right(places, after)
    return places[at] if at < len(places) else -1
