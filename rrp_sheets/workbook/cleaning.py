"""What a cell's text becomes before the program works with it. Tolerant, never guessing; the original is kept."""

from __future__ import annotations

import re

_DROPPED = dict.fromkeys(map(ord, "\u200b\u200c\u200d\u2060\ufeff\u200e\u200f\u00ad"))
_SPACES = {
    ord(c): " "
    for c in "\u00a0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000\t"
}
_LINES = {ord(c): "\n" for c in "\u2028\u2029\u0085\v\f"}
_ALWAYS = {**_DROPPED, **_SPACES, **_LINES}
_FULL_WIDTH = {code: chr(code - 0xFEE0) for code in range(0xFF01, 0xFF5F)}
_DOUBLE, _SINGLE = "“”„‟", "‘’‚‛"
_QUOTES = {**{ord(c): '"' for c in _DOUBLE}, **{ord(c): "'" for c in _SINGLE}}
_NAME = {**_FULL_WIDTH, **_QUOTES}
_EXCEL_PREFIXES = re.compile(r"_xl(?:fn|ws|pm|udf)\.", re.IGNORECASE)
_SINGLE_CALL = re.compile(r"\bSINGLE\(")

ERROR_VALUES = frozenset(
    f"#{name}"
    for name in (
        *("NAME?", "REF!", "VALUE!", "DIV/0!", "N/A", "NUM!", "NULL!", "SPILL!", "CALC!", "FIELD!", "BLOCKED!"),
        *("CONNECT!", "BUSY!", "UNKNOWN!", "GETTING_DATA"),
    )
)


def clean_spaces(text: str) -> str:
    """No-break and other wide spaces become spaces, invisible marks go, edges are stripped.

    >>> clean_spaces("  Red\u00a0ball ")
    'Red ball'
    """
    if text.isascii() and "\t" not in text and "\v" not in text and "\f" not in text:
        return text.strip()
    return text.translate(_ALWAYS).strip()


def clean_name(text: str) -> str:
    """A name, a number or a duration: full-width characters and smart quotes are folded too.

    >>> clean_name("’Ｒｅｄ　ｂａｌｌ１")
    'Red ball1'
    """
    text = clean_spaces(text)
    return _without_apostrophe(text if text.isascii() else clean_spaces(text.translate(_NAME)))


def clean_prose(text: str) -> str:
    """A text for people: its quotes and its full-width characters stay, unless all of it is full-width Latin.

    >>> clean_prose("１２"), clean_prose("「何？」"), clean_prose("Don’t")
    ('12', '「何？」', 'Don’t')
    """
    text = clean_spaces(text)
    if not text.isascii():
        folded = text.translate(_FULL_WIDTH)
        if folded.isascii():
            text = folded.strip()
    return _without_apostrophe(text)


def clean_formula(text: str) -> str:
    r"""A formula: one leading apostrophe and then one leading `=` go; inside its texts the letters stay.

    >>> clean_formula("'=ball.x > ３"), clean_formula("“don’t” & ‘a’"), clean_formula("'a' & 'b'")
    ('ball.x > 3', '"don’t" & \'a\'', "'a' & 'b'")
    """
    text = _without_apostrophe(clean_spaces(text))
    text = text if text.isascii() else _fold_formula(text)
    return text[1:].lstrip() if text.startswith("=") else text


def from_excel(formula: str) -> str:
    """A formula as Excel stores it, as the user typed it.

    >>> from_excel('_xlfn.SINGLE(ball)+_xlfn._xlws.FILTER(a,"SINGLE(b)")')
    'ball+FILTER(a,"SINGLE(b)")'
    """
    if "_xl" not in formula.casefold() and "SINGLE(" not in formula:
        return formula
    pieces = re.split(r'("(?:[^"]|"")*")', formula)  # texts stand at the odd places
    pieces[::2] = [_EXCEL_PREFIXES.sub("", p) for p in pieces[::2]]
    joined = "".join(pieces)
    for _ in range(50):
        start = next((m.start() for m in _SINGLE_CALL.finditer(joined) if joined.count('"', 0, m.start()) % 2 == 0), -1)
        end = _closing(joined, start + 6) if start >= 0 else -1
        if end < 0:
            break
        joined = joined[:start] + joined[start + 7 : end] + joined[end + 1 :]
    return joined


def _closing(text: str, opening: int) -> int:
    """Where the bracket at `opening` is closed; -1 if nowhere. Brackets inside texts do not count."""
    depth, in_text = 0, False
    for i in range(opening, len(text)):
        c = text[i]
        if c == '"':
            in_text = not in_text
        elif not in_text:
            depth += (c == "(") - (c == ")")
            if depth == 0:
                return i
    return -1


def _without_apostrophe(text: str) -> str:
    """Without the leading apostrophe by which spreadsheets mark a text; the quote of a `'text'` stays."""
    if not text.startswith("'"):
        return text
    outside = re.sub(r'"[^"]*"', "", text)
    return text[1:].lstrip() if outside.count("'") % 2 else text


def _fold_formula(text: str) -> str:
    """Smart quotes that serve as quotes become straight ones; everything outside of texts is folded.

    A text that begins with a straight quote ends with one; one that begins with a smart quote ends with the next
    smart quote of its kind, or if there is none with a straight one. An apostrophe after a letter begins no text.
    """
    out: list[str] = []
    i = 0
    while i < len(text):
        c = text[i].translate(_FULL_WIDTH) if text[i] in "＂＇" else text[i]
        double = c == '"' or c in _DOUBLE
        if not double and ((c not in _SINGLE and c != "'") or (i > 0 and text[i - 1].isalnum())):
            out.append(c.translate(_FULL_WIDTH))
            i += 1
            continue
        straight = '"' if double else "'"
        end = _end_of_text(text, i + 1, c, straight, _DOUBLE if double else _SINGLE)
        inner = text[i + 1 : end]
        if c != straight and end < len(text) and text[end] != straight and straight in inner:
            inner = inner.replace(straight, straight * 2)
        out.append(straight + inner + (straight if end < len(text) else ""))
        i = end + 1
    return "".join(out)


def _end_of_text(text: str, start: int, opener: str, straight: str, smart: str) -> int:
    """Where a text ends that begins before `start`; the formula's end if it is never closed."""

    def find(closers: str) -> int:
        for i in range(start, len(text)):
            if text[i] in closers and text[i - 1] != "\\":
                apostrophe = straight == "'" and text[i - 1].isalnum() and text[i + 1 : i + 2].isalnum()
                if not apostrophe:
                    return i
        return len(text)

    if opener == straight:
        return find(straight + ("＂" if straight == '"' else "＇"))
    end = find(smart)
    return end if end < len(text) else find(straight)
