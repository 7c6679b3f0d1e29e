"""Tokens of a formula as the user typed it, each with its place in the typed text.

Folded here, outside of texts: full-width characters, dashes and minus signs, no-break spaces. Texts may stand between
straight or smart quotes; a quote is doubled, or has a backslash before it, to stand in a text.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rrp_sheets.formulas.limits import LARGEST_NUMBER, MOST_TEXTS_DEEP
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_

_DOUBLE, _SINGLE = '"“”„‟＂', "'‘’‚‛＇"
QUOTES = _DOUBLE + _SINGLE
PAIRS = {
    "“": '”"＂', "„": '“”"', "‟": '”"', "”": '”"', "＂": '＂"',
    "‘": "’'＇", "‚": "‘’'", "‛": "’'", "’": "’'", "＇": "＇'",
}  # fmt: skip
_ESCAPES = {"n": "\n", "t": "\t", "\\": "\\", '"': '"', "'": "'", "\n": ""}
_CODED = {"x": 2, "u": 4, "U": 8}
_SAME_QUOTE = N_("Close the text with the same quote as at its beginning.")


def closing(typed: str, at: int) -> int:
    """Return the place of the quote that ends the text which begins at a place."""
    opener = typed[at]
    # The second turn is for a text of which one quote was made a smart one, or the wrong one.
    for closers in (PAIRS.get(opener, opener), _DOUBLE if opener in _DOUBLE else _SINGLE):
        if (end := _next(typed, at, closers)) >= 0:
            return end
    remedy = _SAME_QUOTE
    if opener == "'" and typed[at - 1 : at].isalnum():
        remedy = N_('Put a text with an apostrophe between double quotes: "it\'s".')
    if typed.endswith("\\" + opener):
        remedy = N_("The backslash makes the last quote a part of the text: write two backslashes.")
    problem = _unclosed(typed, at, remedy)
    if remedy is _SAME_QUOTE:
        problem.written = typed[at:].rstrip() + PAIRS.get(opener, opener)[0]
    raise problem


def _unclosed(typed: str, at: int, remedy: str = _SAME_QUOTE) -> FormulaProblem:
    reason = N_("a quote is missing at the end of a text")
    return FormulaProblem("FORM001", at, max(len(typed) - at, 1), reason=reason, remedy=remedy, quotes=True)


def _refuse_triple_quote(typed: str, at: int) -> None:
    """Refuse Python's triple quote; to a spreadsheet it is a quote at the beginning of a text."""
    if typed.startswith(typed[at] * 3, at):
        raise FormulaProblem("FORM003", at, 3, what=N_("A triple quote"), remedy=N_("Write one quote on each side."))


def _next(typed: str, at: int, closers: str) -> int:
    if typed[at] == "'":
        _refuse_triple_quote(typed, at)
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
    """Return the characters of a text: doubled quotes become one, and backslashes give a meaning to what follows."""
    body = typed[start:end]
    kind = PAIRS.get(typed[opener], typed[opener])
    if "\\" not in body and not any(c in body for c in kind):
        return body
    found: list[str] = []
    i = 0
    while i < len(body):
        c, used = body[i], 1
        if c == "\\":
            c, used = _escape(body, i, start)
        elif c in kind and body[i + 1 : i + 2] == c:
            used = 2
        found.append(c)
        i += used
    return "".join(found)


def _escape(body: str, i: int, start: int) -> tuple[str, int]:
    following = body[i + 1 : i + 2]
    if following in _ESCAPES or following in QUOTES:
        return _ESCAPES.get(following, following), 2
    if following in _CODED:
        digits = body[i + 2 : i + 2 + _CODED[following]]
        if re.fullmatch(r"[0-9a-fA-F]+", digits) and len(digits) == _CODED[following] and int(digits, 16) < 0x110000:
            return chr(int(digits, 16)), 2 + len(digits)
    if following and following in "xuUN01234567abfrv":
        raise FormulaProblem("FORM003", start + i, 2, what=N_("“\\{following}” in a text", following=following),
                             remedy=N_("Write the character itself; for a backslash, write two."))  # fmt: skip
    return "\\", 1


_NUMBER = r"(?P<number>0[xXoObB]\w+|(?:\d+(?:_\d+)*\.?(?:\d+(?:_\d+)*)?|\.\d+(?:_\d+)*)(?:[eE][+-]?\d+)?)"
_NAME = r"(?P<name>[A-Za-z_]\w*)"
_SIGN = r"(?P<sign>\*\*|//|<=|>=|<>|!=|==|=<|=>|><|:=|&&|\|\||<<|>>|[-+*/%^&=<>()\[\]{},;:.~|!@?$\\`°≤≥≠])"
_TOKEN = re.compile(rf"\s*(?:{_NUMBER}|{_NAME}|{_SIGN})", re.ASCII)
_SPACE = re.compile(r"\s*", re.ASCII)
_ERROR_VALUE = re.compile(r"#[A-Z][A-Z0-9_]*[/!?A]")

_FOLDED = {
    **dict.fromkeys("–—−‐‑﹣", "-"),
    **dict.fromkeys("\u00a0\u202f\u2007\u2009\u200b\u200c\u200d\u2060\ufeff\u00ad", " "),
    "×": "*", "÷": "/", "º": "°", "˚": "°", "∕": "/", "⁄": "/", "∧": "^", "‹": "<", "›": ">",
}  # fmt: skip
_KEPT = frozenset("²³¹⁴⁵⁶⁷⁸⁹⁰½¼¾…≤≥≠" + QUOTES)  # folding these would change what they mean
_LETTERS = frozenset("fFbBrRuU")


class Token(NamedTuple):
    """A number, text, name or sign of a formula, with its place.

    Attributes:
        kind: `number`, `name`, `sign`, `text`, `texts` (a text with values in it), `column` (of a table), or `end`.
        text: folded; of a text, what stands between its quotes.
        start, end: its place in the typed text.
        parts: of `texts`: texts and :class:`Hole`s in turn. Of `column`: the table's name and the column's.
    """

    kind: str
    text: str
    start: int
    end: int
    parts: tuple[str | Hole, ...] = ()


@dataclass(frozen=True)
class Hole:
    """A value in a text, as in `f"{distance:.1f} m"`: its tokens and its format."""

    tokens: list[Token]
    format: str | None
    start: int
    end: int


def tokenize(typed: str, is_table: Callable[[str], bool] = lambda _name: False) -> list[Token]:
    """Return the tokens of a formula, without a leading `=`.

    `is_table` tells whether a name is a table's: what stands in brackets behind it is a column's name as it is.

    Raises:
        FormulaProblem: FORM001 or FORM003 at a character that nothing can begin with, or a text that does not end.

    >>> [t.text for t in tokenize("=distance – 1 ≤ 50%")]
    ['distance', '-', '1', '≤', '50', '%', '']
    >>> [(t.kind, t.text) for t in tokenize("“say ””hi””” & X")][0]
    ('text', 'say ”hi”')
    """
    lexer = _Lexer(typed, is_table)
    start = len(typed) - len(lexer.plain.lstrip())
    if lexer.plain.startswith("=", start) and not lexer.plain.startswith("==", start):
        start += 1
    tokens, end = lexer.read(start, False)
    assert end == len(typed)
    return tokens


def fold(text: str) -> str:
    """Return the text with every character that has a plain form in that form; its length stays the same."""
    if text.isascii():
        return text
    plain = (_FOLDED.get(c) or (c if c in _KEPT else unicodedata.normalize("NFKC", c)) for c in text)
    return "".join(folded if len(folded) == 1 else c for folded, c in zip(plain, text, strict=True))


class _Lexer:
    def __init__(self, typed: str, is_table: Callable[[str], bool]) -> None:
        self.typed = typed
        self.plain = fold(typed)
        self.is_table = is_table
        self.holes = 0  # texts with values within each other

    def read(self, at: int, in_text: bool) -> tuple[list[Token], int]:
        """Return the tokens from a place on (in a text's hole, up to what ends the hole), and the place behind them."""
        tokens: list[Token] = []
        plain, size, deep = self.plain, len(self.plain), 0
        while True:
            found = _TOKEN.match(plain, at)
            if found is None:
                at = _SPACE.match(plain, at).end()  # type: ignore[union-attr]
                if at < size and plain[at] == "#" and not _ERROR_VALUE.match(plain, at):  # a comment
                    at = plain.find("\n", at) if "\n" in plain[at:] else size
                    continue
                if at >= size:
                    tokens.append(Token("end", "", size, size))
                    return tokens, size
                token = self._odd(at)
            else:
                kind = found.lastgroup or ""
                token = Token(kind, found[kind], found.start(kind), found.end())
                if kind == "sign":
                    sign = token.text
                    if in_text and not deep and (sign in ("}", ":", "!") or sign == ":="):
                        tokens.append(Token("end", "", token.start, token.start))
                        return tokens, token.start
                    deep += (sign in "([{") - (sign in ")]}") if len(sign) == 1 else 0
                elif kind == "name":
                    token = self._name(token)
            tokens.append(token)
            at = token.end

    def _odd(self, at: int) -> Token:
        """Return the token that begins with another character: a text, or a name that is not Latin."""
        if self.typed[at] in QUOTES:
            end = closing(self.typed, at)
            return Token("text", decode(self.typed, at, at + 1, end), at, end + 1)
        if self.plain[at].isidentifier():
            return self._name(Token("name", "", at, at))
        raise _strange(self.typed, at)

    def _name(self, token: Token) -> Token:
        """Return the token of a whole name; before a quote, a text with values; before [, maybe a table's column."""
        end, plain = token.end, self.plain
        while end < len(plain) and not plain[end].isascii() and f"a{plain[end]}".isidentifier():
            end += 1
            while end < len(plain) and f"a{plain[end]}".isidentifier():
                end += 1
        name = plain[token.start : end]
        following = self.typed[end : end + 1]
        if following and following in QUOTES and set(name) <= _LETTERS:
            if name not in "fF":
                what = N_("The letter {name} before a text", name=name)
                raise FormulaProblem("FORM003", token.start, len(name), what=what, remedy=N_("Leave it out."))
            parts, end = self._text_with_values(end)
            return Token("texts", "", token.start, end, parts)
        if following == "[" and self.is_table(name):
            return self._column(name, token.start, end)
        return Token("name", name, token.start, end)

    def _column(self, name: str, start: int, at: int) -> Token:
        depth, end = 0, at
        while end < len(self.typed):
            depth += {"[": 1, "]": -1}.get(self.typed[end], 0)
            end += 1
            if not depth:
                title = self.typed[at + 1 : end - 1].strip()
                quoted = len(title) > 1 and title[0] in QUOTES and title[-1] in QUOTES
                return Token("column", title[1:-1] if quoted else title, start, end, (name,))
        remedy = N_("Write {name}[Column].", name=name)
        raise FormulaProblem("FORM001", at, reason=N_("a closing bracket is missing"), remedy=remedy)

    # ---- texts with values in them
    def _text_with_values(self, at: int) -> tuple[tuple[str | Hole, ...], int]:
        """Return the parts of a text with values in it, and the place behind it; `at` is the place of its quote."""
        typed, opener = self.typed, self.typed[at]
        closers = PAIRS.get(opener, opener)
        _refuse_triple_quote(typed, at)
        parts: list[str | Hole] = []
        begin = i = at + 1
        while i < len(typed):
            c = typed[i]
            if c == "\\":
                i += 2
            elif c in "{}" and typed[i + 1 : i + 2] == c:
                parts += [decode(typed, at, begin, i), c]
                begin = i = i + 2
            elif c == "{":
                parts += [decode(typed, at, begin, i), hole := self._hole(i)]
                begin = i = hole.end
            elif c == "}":
                remedy = N_("Write }} to show one }.")
                raise FormulaProblem("FORM001", i, reason=N_("there is a } without {"), remedy=remedy)
            elif c not in closers:
                i += 1
            elif typed[i + 1 : i + 2] == c:
                i += 2
            else:
                parts.append(decode(typed, at, begin, i))
                return tuple(parts), i + 1
        raise _unclosed(typed, at)

    def _hole(self, start: int) -> Hole:
        self.holes += 1
        if self.holes > MOST_TEXTS_DEEP:
            raise FormulaProblem("FORM002", start, reason=N_("its texts with values are nested too deeply"))
        tokens, end = self.read(start + 1, True)
        self.holes -= 1
        if self.typed.startswith("!", end):
            remedy = N_("Write the value alone, or with a format such as {distance:.1f}.")
            raise FormulaProblem("FORM003", end, 2, what=N_("“!” in a text"), remedy=remedy)
        spec = None
        if self.typed.startswith(":", end):
            begin = end + 1
            end = min((p for p in (self.typed.find(c, begin) for c in "{}") if p >= 0), default=len(self.typed))
            spec = self.typed[begin:end]
            if self.typed.startswith("{", end):
                raise FormulaProblem("FORM010", begin, max(end - begin, 1), spec=spec + "{…}")
        if not self.typed.startswith("}", end):
            raise FormulaProblem("FORM001", start, reason=N_("a } is missing in a text with values"),
                                 remedy=N_('Write for example f"It is {distance} away".'))  # fmt: skip
        return Hole(tokens, spec, start, end + 1)


def replace_names(
    typed: str, new: Mapping[str, str], fields: Mapping[str, Mapping[str, str]] = {}, tables: Container[str] = (),
) -> str | None:  # fmt: skip
    """Return a formula in which names have other names; None where that cannot be done safely.

    Texts stay as they are, the values within them do not (`f"{far} m"`). None is for a formula that cannot be read, and
    for one whose own loop has such a name.

    Args:
        typed: the formula as typed.
        new: the new text by the key of the old name.
        fields: the same for the fields of a name, by its key: `joined.far`.
        tables: keys of the tables, whose columns are no names: `Trials[Far]`.

    >>> replace_names('ballX & "ballX" & ball.ballX & f"{BALL_X}"', {"ballx": "newX"})
    'newX & "ballX" & ball.ballX & f"{newX}"'
    >>> replace_names("far + joined.far + ball.far", {}, {"joined": {"far": "near"}})
    'far + joined.near + ball.far'
    >>> replace_names("[far for far in Trials]", {"far": "near"}) is None
    True
    """
    try:
        tokens = tokenize(typed, lambda name: key(name) in tables and key(name) not in new)
    except FormulaProblem:
        return None
    parts: list[str] = []
    end = 0
    for token in _replaced(tokens, new, fields):
        if token is None:
            return None
        parts += [typed[end : token.start], token.text]
        end = token.end
    return "".join([*parts, typed[end:]])


def _replaced(
    tokens: Sequence[Token], new: Mapping[str, str], fields: Mapping[str, Mapping[str, str]]
) -> Iterator[Token | None]:
    """Yield the names to be replaced, with their new texts; None for one to which a loop gives another meaning."""
    in_target = False
    owner, last = "", ""  # the key of the name before a dot, and what stands before the token
    for token in tokens:
        text = key(token.text) if token.kind == "name" else token.text
        if token.kind == "texts":
            for part in token.parts:
                if isinstance(part, Hole):
                    yield from _replaced(part.tokens, new, fields)
        elif token.kind == "name":
            in_target = text == "for" or (in_target and text != "in")
            names = fields.get(owner, {}) if last == "." else new
            if text in names:
                yield None if in_target else token._replace(text=names[text])
        if token.kind == "name":
            owner = text if last != "." else ""
        elif text != ".":
            owner = ""
        last = text


_QUOTED = N_('Put texts between quotes: "red".')
_LEAVE_OUT = N_("Leave it out. Texts stand in quotes.")
_REMEDIES = {
    "²": N_("Write ^2 for a square."), "³": N_("Write ^3."), "√": N_("Write SQRT(…)."), "∛": N_("Write (…) ^ (1/3)."),
    "½": N_("Write 0.5."), "¼": N_("Write 0.25."), "¾": N_("Write 0.75."), "∞": N_("Infinite numbers cannot be used."),
    "·": N_("Write * to multiply."), "•": N_("Write * to multiply."), "«": _QUOTED,
    "»": _QUOTED, "「": _QUOTED, "€": N_("Write the number alone."),
    "、": N_("Write ; or , between values."), "…": N_("Write all of it."), "¬": N_("Write NOT(…)."),
    "→": N_("Write IF(…; …; …)."), "$": N_("Write the number alone."), "‰": N_("Write for example 0.005."),
}  # fmt: skip


def _strange(typed: str, at: int) -> FormulaProblem:
    """Return the problem of a character with which nothing can begin."""
    c = typed[at]
    if found := _ERROR_VALUE.match(typed, at):
        reason = N_("it contains the error value {value} of a spreadsheet", value=found[0])
        remedy = N_("Type the formula again; write the streams' names instead of cells.")
        return FormulaProblem("FORM001", at, len(found[0]), reason=reason, remedy=remedy)
    if unicodedata.category(c) in ("Cc", "Cs", "Co", "Cn", "Cf"):
        return FormulaProblem("FORM001", at, reason=N_("it contains an invisible character"),
                              remedy=N_("Type the formula again."))  # fmt: skip
    remedy = _REMEDIES.get(c, _LEAVE_OUT)
    about = {"quotes": True} if remedy in (_QUOTED, _LEAVE_OUT) else {}
    return FormulaProblem("FORM001", at, reason=N_("“{c}” has no meaning in a formula", c=c), remedy=remedy, **about)


def parse_number(token: Token) -> int | float:
    """Return the number that a token shows; raises FormulaProblem FORM001 or FORM008."""
    text = token.text.replace("_", "")
    try:
        based = text[1:2].casefold() in ("x", "o", "b")
        found = int(text, 0 if based else 10) if based or text.isdecimal() else float(text)
    except ValueError:
        reason = N_("“{text}” is not a number", text=token.text)
        remedy = N_("Write a number such as 0.5.")
        raise FormulaProblem("FORM001", token.start, token.end - token.start, reason=reason, remedy=remedy) from None
    if abs(found) > LARGEST_NUMBER:
        shown = token.text if len(token.text) <= 13 else token.text[:12] + "…"
        raise FormulaProblem("FORM008", token.start, token.end - token.start, number=shown)
    return found
