"""Formulas as trees, written so that two of one meaning are equal: `IF(x>3; 1; 0)` and `1 if x > 3 else 0`."""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping, Sequence

from rrp_sheets.formulas import Formula, HelperDef
from rrp_sheets.formulas.nodes import Join
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import key

_NO_NAMES: Mapping[str, str] = {}


def shape(
    tree: ast.AST,
    names: Mapping[str, str],
    helpers: Mapping[str, str] = _NO_NAMES,
    fields: Mapping[str, str] = _NO_NAMES,
) -> str:
    """A tree as text, without places and spellings.

    Args:
        tree: resolved, as `compile_formula` gives it.
        names: what stands for each input's name: its place, or the stream it is.
        helpers: new keys of helpers that are called otherwise now, by the old.
        fields: new keys of fields, by the old.

    >>> from rrp_sheets.formulas import compile_formula, make_scope
    >>> one = compile_formula("IF(Near > 3, 1, 0)", make_scope([("Near", None)])).tree
    >>> two = compile_formula("1 if near > 3.0 else 0", make_scope([("Near", None)])).tree
    >>> shape(one, {"near": "0"}) == shape(two, {"near": "0"})
    True
    """
    return _Shaper(names, helpers, fields).of(tree)


def shape_of(formula: Formula, inputs: int, helpers: Mapping[str, str] = _NO_NAMES) -> str:
    """The shape of a row's formula, its inputs named by their places.

    A formula sees other names before its inputs in some connectors (`total`); they keep their names.
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
            return self._constant(node.value, compared)
        if isinstance(node, ast.Name):
            return "$" + self._name(node.id)
        found = _field(node)
        if found is not None:
            owner, name = found
            return f"({self.of(owner)}.{self.fields.get(name, name)})"
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, (Join, ast.JoinedStr)):
            return f"(text {' '.join(self._text(node.values))})"
        if isinstance(node, ast.ListComp):
            for loop in node.generators:
                targets = loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]
                for target in targets:
                    if isinstance(target, ast.Name):
                        self.local.setdefault(target.id, f"%{len(self.local)}")
        inside = isinstance(node, ast.Compare)
        parts = " ".join(self.of(getattr(node, f, None), inside) for f in node._fields if f != "ctx")
        return f"({type(node).__name__} {parts})"

    def _constant(self, value: object, compared: bool) -> str:
        # where two numbers are compared, 1 and 1.0 are the same; elsewhere they may be said aloud
        if compared and isinstance(value, int) and not isinstance(value, bool):
            return repr(float(value))
        if isinstance(value, Table):
            return f"table {key(value.name)}"
        return repr(value)

    def _text(self, values: Sequence[ast.expr]) -> list[str]:
        """The parts of a text, joined by `&` or written as `f"…"`: texts that stand beside each other are one."""
        parts: list[str] = []
        text = ""
        for part in values:
            bare = part
            if isinstance(part, ast.FormattedValue) and part.format_spec is None:
                bare = part.value
            if isinstance(bare, ast.Constant) and isinstance(bare.value, str):
                text += bare.value
                continue
            inner = self._text(bare.values) if isinstance(bare, (Join, ast.JoinedStr)) else [self.of(bare)]
            parts += [repr(text), *inner] if text else inner
            text = ""
        return [*parts, repr(text)] if text else parts

    def _name(self, name: str) -> str:
        return self.local.get(name) or self.names.get(name, name)

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
    """What has a field, and the field's key: `ball.x` is `ball['X']`."""
    if isinstance(node, ast.Attribute):
        return node.value, key(node.attr)
    by_name = isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and node.slice.value
    return (node.value, key(by_name)) if isinstance(node, ast.Subscript) and isinstance(by_name, str) else None


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
