"""Making a resolved tree ready to run."""

from __future__ import annotations

import ast
import operator
import sys
from collections.abc import Callable
from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas.compare import ORDER
from rrp_sheets.formulas.functions.maths import power
from rrp_sheets.formulas.nodes import Pick
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import HelperDef
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.values import Value

_ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: power,
}  # fmt: skip
_QUICK = {**ORDER, ast.Eq: operator.eq, ast.NotEq: operator.ne}


class Binder:
    """Copies a resolved tree, and those of its helpers, with every node's handler on it, ready to run."""

    def __init__(self, handlers: dict[type, Callable[[Any], Value]]) -> None:
        self.handlers = handlers
        self.entries: dict[int, list[ast.expr]] = {}  # the trees of helpers, by the helper's id
        self.waiting: list[HelperDef] = []
        self.owner = ""

    def bind(self, tree: ast.expr) -> ast.expr:
        """The copy; raises FormulaProblem FORM015 when a helper that it calls has no tree."""
        bound: ast.expr = self._copy(tree)
        while self.waiting:
            helper = self.waiting.pop()
            if helper.tree is None:
                raise FormulaProblem("FORM015", name=helper.shown)
            self.owner = helper.shown
            self.entries[id(helper)].append(self._copy(helper.tree))
        return bound

    def _copy(self, original: Any) -> Any:
        kind: Any = type(original)
        node = kind.__new__(kind)  # copy.copy takes ten times as long, which thousands of rows would feel
        held = node.__dict__
        held.update(original.__dict__)
        for name in kind._fields:
            value = held.get(name)
            if isinstance(value, (ast.expr, ast.comprehension)):
                held[name] = self._copy(value)
            elif type(value) is list and kind is not ast.Constant:
                held[name] = [self._copy(v) if isinstance(v, (ast.expr, ast.comprehension)) else v for v in value]
        node.handler = self.handlers.get(kind)
        if kind is ast.Compare:
            node.chain = [(_QUICK.get(type(op)), op, c) for op, c in zip(node.ops, node.comparators, strict=True)]
            node.single = _QUICK.get(type(node.ops[0])) if len(node.ops) == 1 else None
        elif kind is ast.BinOp:
            node.apply = _ARITHMETIC[type(node.op)]
            node.divides = isinstance(node.op, (ast.Div, ast.FloorDiv, ast.Mod))
        elif kind is Pick:
            # those that draw from the same list share its draws: never the same twice running in one row
            node.site = f"{self.owner}#{' '.join(map(_written, original.members))}"
        elif kind is ast.Call:
            self._link(node)
        return node

    def _link(self, node: Any) -> None:
        helper: HelperDef | None = getattr(node, "helper", None)
        node.entry = None
        if helper is None:
            return
        if id(helper) not in self.entries:
            self.entries[id(helper)] = []
            self.waiting.append(helper)
        node.entry = self.entries[id(helper)]
        node.parameters = [p.name for p in helper.parameters]


def _written(node: ast.expr) -> str:
    """What an argument is, as a text; a table by its name, however many rows it has."""
    if isinstance(node, ast.Constant) and isinstance(node.value, Table):
        return Phrase("the table {name}", name=node.value.name)
    # The text seeds the draws, so it must be the same in every Python: 3.13 adds the context that our own nodes lack,
    # and leaves out what is empty.
    for inner in ast.walk(node):
        if "ctx" in inner._fields and not hasattr(inner, "ctx"):
            inner.ctx = ast.Load()  # type: ignore[attr-defined]  # a Name, an Attribute, a Subscript or a list
    if sys.version_info >= (3, 13):
        return ast.dump(node, show_empty=True)
    return ast.dump(node)
