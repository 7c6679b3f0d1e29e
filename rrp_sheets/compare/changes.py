"""Changes between two workbooks, each of which does or does not alter the behaviour, and tokens of formulas.

A formula is compared by its tokens, and by its shape without its spelling.
"""

from __future__ import annotations

import ast
import difflib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.formulas import Formula, HelperDef
from rrp_sheets.formulas.parsing import Join
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import key


@dataclass(frozen=True, slots=True)
class Change:
    """One difference.

    Attributes:
        kind: `added`, `removed`, `renamed`, `moved`, `changed`, `on`, `off`, `notes`, or `written` (the same, in
            another spelling or at another place).
        part: `behaviour`, `row`, `stream`, `device`, `helper`, `scene`, `gesture`, `protocol`, `test`, `table`,
            `sheet`, `risk`.
        sheet: the sheet's name, that of the second workbook where both have it.
        name: the stream, helper or field in question; empty for rows.
        rows: its row in the first and in the second workbook, 0 where there is none.
        what: the column, setting or field that changed, in words.
        before, after: its content in the first and in the second workbook.
        effect: it alters the behaviour.
        note: why it has no effect, or what the effect is.
        pieces: of a formula, the kept, removed and added parts.
        field: of a row, the cell that changed: `connector`, `inputs`, `formula`, `output`, `priority`.
    """

    kind: str
    part: str
    sheet: str = ""
    name: str = ""
    rows: tuple[int, int] = (0, 0)
    what: str = ""
    before: str = ""
    after: str = ""
    effect: bool = True
    note: str = ""
    pieces: tuple[FormulaPiece, ...] = ()
    field: str = ""

    def harmless(self, note: str) -> Change:
        """Return the change as one without effect, with the reason as its note if it has none."""
        return replace(self, effect=False, note=self.note or note) if self.effect else self


def one_sided(
    kind: str, part: str, sheet: str, text: str, row: int = 0, effect: bool = True, note: str = "", name: str = ""
) -> Change:
    """Return the change for what only one workbook has: the second one when `kind` is `added`, else the first."""
    if kind == "added":
        return Change(kind, part, sheet, name, (0, row), after=text, effect=effect, note=note)
    return Change(kind, part, sheet, name, (row, 0), before=text, effect=effect, note=note)


@dataclass(frozen=True, slots=True)
class ComparedWorkbook:
    """One of the two workbooks, as the comparison identifies it."""

    source: str
    digest: str
    format: str
    errors: int


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences between two workbooks, the older one first; those of behaviours come first, sheet by sheet."""

    first: ComparedWorkbook
    second: ComparedWorkbook
    changes: tuple[Change, ...]

    @property
    def same(self) -> bool:
        """True if both workbooks have the same behaviour."""
        return not any(c.effect for c in self.changes)

    @property
    def effects(self) -> Sequence[Change]:
        """Changes that alter the behaviour."""
        return [c for c in self.changes if c.effect]

    @property
    def others(self) -> Sequence[Change]:
        """Changes that do not alter the behaviour."""
        return [c for c in self.changes if not c.effect]


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
class FormulaPiece:
    """A part of a formula: `kind` is `same`, `gone` or `new`."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class ComparedToken:
    """Token of a formula: its meaning whatever the spelling, and its text with the space before it."""

    meaning: str
    written: str


def tokens(formula: str, names: Mapping[str, str] | None = None) -> list[ComparedToken]:
    """Return the tokens of a formula; `names` are new names for old ones, both as keys.

    >>> [t.meaning for t in tokens("Red_Ball.x <> 50%")]
    ['redball', '.', 'x', '!=', '0.5']
    """
    if len(formula) > LONGEST:
        return [ComparedToken(" ".join(formula.split()), formula)]
    return [ComparedToken(_meaning(m, names or {}), m[0]) for m in _TOKEN.finditer(formula)]


def _meaning(match: re.Match[str], names: Mapping[str, str]) -> str:
    if match["text"]:
        inside = match["text"][1:-1]
        return "“" + (inside.replace('""', '"') if match["text"][0] == '"' else inside)
    if bare := match["number"]:
        return f"{float(bare.rstrip('% ')) / (100 if bare.endswith('%') else 1):.15g}"
    if match["name"]:
        return names.get(key(match["name"]), key(match["name"]))
    return _SIGNS.get(match["sign"], match["sign"])


def meanings(formula: str, names: Mapping[str, str] | None = None) -> tuple[str, ...]:
    """Return the meanings of the tokens: equal for two formulas that differ in spelling only."""
    return tuple(t.meaning for t in tokens(formula, names))


def as_typed(text: str) -> tuple[str, ...]:
    """Return the meanings of a cell in which words are texts: only spaces and the spelling of numbers are ignored.

    >>> as_typed("0.50; Hello") == as_typed(".5;Hello"), as_typed("Hello") == as_typed("hello")
    (True, False)
    """
    if len(text) > LONGEST:
        return (text,)
    return tuple(_meaning(m, {}) if m["number"] else m[0].strip() for m in _TOKEN.finditer(text))


def pieces(before: str, after: str, names: Mapping[str, str] | None = None) -> tuple[FormulaPiece, ...]:
    """Return the kept, removed and added parts of a formula.

    >>> [(p.kind, p.text) for p in pieces("distance < 20", "distance < 15")]
    [('same', 'distance < '), ('gone', '20'), ('new', '15')]
    """
    left, right = tokens(before, names), tokens(after)
    if not left or not right or max(len(left), len(right)) > MOST:
        return tuple(FormulaPiece(kind, text) for kind, text in (("gone", before), ("new", after)) if text)
    matcher = difflib.SequenceMatcher(None, [t.meaning for t in left], [t.meaning for t in right], autojunk=False)
    parts: list[tuple[str, Sequence[ComparedToken]]] = []
    for op, a, b, c, d in matcher.get_opcodes():
        parts += [("same", right[c:d])] if op == "equal" else [("gone", left[a:b]), ("new", right[c:d])]
    return tuple(_spaced([FormulaPiece(kind, "".join(t.written for t in part)) for kind, part in parts if part]))


def _spaced(found: list[FormulaPiece]) -> list[FormulaPiece]:
    """Return the pieces with the spaces at their edges moved to the pieces that stay."""
    out: list[FormulaPiece] = []
    for piece in found:
        bare = piece.text.strip()
        if piece.kind == "same" or bare == piece.text:
            out.append(piece)
            continue
        lead = piece.text[: len(piece.text) - len(piece.text.lstrip())]
        last = out[-1] if out else None
        if last is not None and last.kind == "same":
            out[-1] = FormulaPiece("same", last.text.rstrip() + lead)
        elif last is None or last.kind == piece.kind:
            out.append(FormulaPiece("same", lead))
        out.append(FormulaPiece(piece.kind, bare))
    return out


def single(found: Sequence[FormulaPiece]) -> tuple[str, str] | None:
    """Return the old and the new token when exactly one differs; else None.

    >>> single(pieces("distance < 20", "distance < 15"))
    ('20', '15')
    """
    changed = [p for p in found if p.kind != "same"]
    if [p.kind for p in changed] != ["gone", "new"] or any(len(tokens(p.text)) != 1 for p in changed):
        return None
    return changed[0].text, changed[1].text


_NO_NAMES: Mapping[str, str] = {}


def shape(
    tree: ast.AST, names: Mapping[str, str], helpers: Mapping[str, str] = _NO_NAMES,
    fields: Mapping[str, str] = _NO_NAMES,
) -> str:  # fmt: skip
    """Return a tree, resolved by `compile_formula`, as text without places and spellings.

    `names` are what stands for each input's name: its place, or the stream it is; `helpers` and `fields` are new keys
    by the old ones.

    >>> from rrp_sheets.formulas import compile_formula, make_scope
    >>> one = compile_formula("IF(Near > 3, 1, 0)", make_scope([("Near", None)])).tree
    >>> two = compile_formula("1 if near > 3.0 else 0", make_scope([("Near", None)])).tree
    >>> shape(one, {"near": "0"}) == shape(two, {"near": "0"})
    True
    """
    return _Shaper(names, helpers, fields).of(tree)


def shape_of(formula: Formula, inputs: int, helpers: Mapping[str, str] = _NO_NAMES) -> str:
    """Return the shape of a row's formula, with its inputs named by their places.

    In some connectors a formula has further names before its inputs (`total`); these stay as they are.
    """
    mine = formula.names[len(formula.names) - inputs :] if inputs else ()
    return shape(formula.tree, {name: str(i) for i, name in enumerate(mine)}, helpers)


class _Shaper:
    def __init__(self, names: Mapping[str, str], helpers: Mapping[str, str], fields: Mapping[str, str]) -> None:
        self.names, self.helpers, self.fields = names, helpers, fields
        self.local: dict[str, str] = {}  # names of list comprehensions, in the order in which they are bound

    def of(self, node: object, compared: bool = False) -> str:
        if isinstance(node, list):
            return f"[{' '.join(self.of(n, compared) for n in node)}]"
        if not isinstance(node, ast.AST):
            return repr(node)
        if isinstance(node, ast.Constant):
            value: object = node.value
            if compared and isinstance(value, int) and not isinstance(value, bool):
                return repr(float(value))  # compared 1 and 1.0 are the same; elsewhere they may be said aloud
            return f"table {key(value.name)}" if isinstance(value, Table) else repr(value)
        if isinstance(node, ast.Name):
            return "$" + (self.local.get(node.id) or self.names.get(node.id, node.id))
        if (found := _field(node)) is not None:
            owner, name = found
            return f"({self.of(owner)}.{self.fields.get(name, name)})"
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, (Join, ast.JoinedStr)):
            return f"(text {' '.join(self._text(node.values))})"
        if isinstance(node, ast.ListComp):
            for loop in node.generators:
                for target in loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]:
                    if isinstance(target, ast.Name):
                        self.local.setdefault(target.id, f"%{len(self.local)}")
        inside = isinstance(node, ast.Compare)
        parts = " ".join(self.of(getattr(node, f, None), inside) for f in node._fields if f != "ctx")
        return f"({type(node).__name__} {parts})"

    def _text(self, values: Sequence[ast.expr]) -> list[str]:
        """Return the parts of a text joined by `&` or written as `f"…"`; adjacent constant texts become one."""
        parts: list[str] = []
        text = ""
        for part in values:
            bare = part.value if isinstance(part, ast.FormattedValue) and part.format_spec is None else part
            if isinstance(bare, ast.Constant) and isinstance(bare.value, str):
                text += bare.value
                continue
            inner = self._text(bare.values) if isinstance(bare, (Join, ast.JoinedStr)) else [self.of(bare)]
            parts += [repr(text), *inner] if text else inner
            text = ""
        return [*parts, repr(text)] if text else parts

    def _call(self, node: ast.Call) -> str:
        helper: HelperDef | None = getattr(node, "helper", None)
        given = [a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, (int, float))]
        if isinstance(node.func, ast.Name) and node.func.id == "RADIANS" and helper is None and given:
            return repr(math.radians(given[0]))  # as 30° is
        name = node.func.id if isinstance(node.func, ast.Name) else self.of(node.func)
        if helper is not None:
            k = key(helper.shown)
            name = "helper " + self.helpers.get(k, k)
        return f"({name} {self.of(node.args)})"


def _field(node: ast.AST) -> tuple[ast.expr, str] | None:
    """Return the owner and the key of a field, as in `ball.x` or `ball['X']`; None for other nodes."""
    if isinstance(node, ast.Attribute):
        return node.value, key(node.attr)
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str):
        return node.value, key(node.slice.value)
    return None


def helpers_in(tree: ast.AST, found: dict[str, HelperDef]) -> None:
    """Add the helpers that a tree calls, and those that they call, to `found`, by key."""
    todo: list[ast.AST] = [tree]
    while todo:
        for node in ast.walk(todo.pop()):
            helper: HelperDef | None = getattr(node, "helper", None)
            if helper is not None and key(helper.shown) not in found:
                found[key(helper.shown)] = helper
                if helper.tree is not None:
                    todo.append(helper.tree)
