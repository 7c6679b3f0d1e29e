"""The tokens of a formula, and what stayed, went and came between two formulas."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.model.names import key

LONGEST = 2_000  # characters; longer formulas are refused anyway and are compared as a whole
MOST = 400  # tokens that are compared one by one
_TOKEN = re.compile(
    r"""\s*(?: (?P<text>"(?:[^"\\]|\\.|"")*" | '(?:[^'\\]|\\.)*')
            |  (?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:e[+-]?\d+)?\s*%?)
            |  (?P<name>\w+)
            |  (?P<sign><>|<=|>=|!=|==|\*\*|//|\S) )""",
    re.VERBOSE | re.IGNORECASE,
)
_SIGNS = {"<>": "!=", "=": "==", "^": "**", ";": ","}


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a formula: `kind` is `same`, `gone` or `new`."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Token:
    """A token: what it means whatever its spelling, and how it is written, with the space before it."""

    meaning: str
    written: str


def tokens(formula: str, names: Mapping[str, str] | None = None) -> list[Token]:
    """The tokens of a formula; `names` are new names for old ones, both as keys.

    >>> [t.meaning for t in tokens("Red_Ball.x <> 50%")]
    ['redball', '.', 'x', '!=', '0.5']
    """
    if len(formula) > LONGEST:
        return [Token(" ".join(formula.split()), formula)]
    return [Token(_meaning(m, names or {}), m[0]) for m in _TOKEN.finditer(formula)]


def _meaning(match: re.Match[str], names: Mapping[str, str]) -> str:
    if match["text"]:
        inside = match["text"][1:-1]
        return "“" + (inside.replace('""', '"') if match["text"][0] == '"' else inside)
    if match["number"]:
        bare = match["number"]
        number = float(bare.rstrip("% ")) / (100 if bare.endswith("%") else 1)
        return f"{number:.15g}"
    if match["name"]:
        return names.get(key(match["name"]), key(match["name"]))
    return _SIGNS.get(match["sign"], match["sign"])


def meanings(formula: str, names: Mapping[str, str] | None = None) -> tuple[str, ...]:
    """What the tokens mean: equal for two formulas that differ in spelling only."""
    return tuple(t.meaning for t in tokens(formula, names))


def as_typed(text: str) -> tuple[str, ...]:
    """The same for a cell in which words are texts: only the spaces and the spelling of numbers do not count.

    >>> as_typed("0.50; Hello") == as_typed(".5;Hello"), as_typed("Hello") == as_typed("hello")
    (True, False)
    """
    if len(text) > LONGEST:
        return (text,)
    return tuple(_meaning(m, {}) if m["number"] else m[0].strip() for m in _TOKEN.finditer(text))


def pieces(before: str, after: str, names: Mapping[str, str] | None = None) -> tuple[Piece, ...]:
    """What stayed, went and came.

    >>> [(p.kind, p.text) for p in pieces("distance < 20", "distance < 15")]
    [('same', 'distance < '), ('gone', '20'), ('new', '15')]
    """
    left, right = tokens(before, names), tokens(after)
    if not left or not right or max(len(left), len(right)) > MOST:
        return tuple(Piece(kind, text) for kind, text in (("gone", before), ("new", after)) if text)
    matcher = difflib.SequenceMatcher(None, [t.meaning for t in left], [t.meaning for t in right], autojunk=False)
    out: list[Piece] = []
    for op, a, b, c, d in matcher.get_opcodes():
        if op == "equal":
            out.append(Piece("same", _joined(right[c:d])))
            continue
        if b > a:
            out.append(Piece("gone", _joined(left[a:b])))
        if d > c:
            out.append(Piece("new", _joined(right[c:d])))
    return tuple(_spaced(out))


def _joined(part: Sequence[Token]) -> str:
    return "".join(t.written for t in part)


def _spaced(found: list[Piece]) -> list[Piece]:
    """The pieces with the spaces at their edges given to the pieces that stay."""
    out: list[Piece] = []
    for piece in found:
        bare = piece.text.strip()
        if piece.kind == "same" or bare == piece.text:
            out.append(piece)
            continue
        lead = piece.text[: len(piece.text) - len(piece.text.lstrip())]
        last = out[-1] if out else None
        if last is not None and last.kind == "same":
            out[-1] = Piece("same", last.text.rstrip() + lead)
        elif last is None or last.kind == piece.kind:
            out.append(Piece("same", lead))
        out.append(Piece(piece.kind, bare))
    return out


def single(found: Sequence[Piece]) -> tuple[str, str] | None:
    """The old and the new token when exactly one differs.

    >>> single(pieces("distance < 20", "distance < 15"))
    ('20', '15')
    """
    changed = [p for p in found if p.kind != "same"]
    if [p.kind for p in changed] != ["gone", "new"]:
        return None
    old, new = changed[0].text, changed[1].text
    return (old, new) if len(tokens(old)) == len(tokens(new)) == 1 else None
