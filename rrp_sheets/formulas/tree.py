"""The static allow-list: what is not expressly allowed is refused, with its position.

The tree that comes out is ready for the evaluator: names are resolved, functions and helpers are bound to their
nodes, `IF`, `AND`, `OR`, `NOT` and `IFERROR` have become nodes of their own.
"""

from __future__ import annotations

import ast
import builtins
import re
import unicodedata
from collections.abc import Callable

from rrp_sheets.formulas.functions import Function
from rrp_sheets.formulas.limits import DEEPEST, LARGEST_NUMBER, LONGEST_TEXT, MOST_LOOPS, MOST_NODES
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import HelperDef, Scope
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import argument_name, key, nearest
from rrp_sheets.model.values import RecordType

_SPEC = re.compile(r"[<>^]?[+ -]?0?\d{0,2},?(\.\d{1,2})?[defgs%]?")
_NAMES = {
    ast.Lambda: "A lambda", ast.Dict: "A dictionary", ast.Set: "A set", ast.NamedExpr: "An assignment",
    ast.GeneratorExp: "A generator", ast.SetComp: "A set", ast.DictComp: "A dictionary", ast.Starred: "A star",
    ast.Await: "await", ast.Yield: "yield", ast.YieldFrom: "yield",
}  # fmt: skip
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)
_COMPARISONS = (ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn, ast.Is, ast.IsNot)
_AMBIGUOUS = {  # where spreadsheets and Python disagree: never guess
    "log": "Write LN(…) for the natural logarithm, or LOG10(…).",
    "atan2": "Write ANGLE(x, y): the direction of a point, x ahead and y to the left.",
}
_ADVICE = "Formulas are built of inputs, numbers, texts, operators and the library's functions."


def resolve(tree: ast.expr, scope: Scope, source: str) -> ast.expr:
    """Check a tree against the allow-list and bind its names; raises FormulaProblem at the first violation."""
    nodes = sum(1 for _ in ast.walk(tree))
    # operators and contexts are nodes to Python but not to a reader; 2 to 1 is about the share they have
    if nodes > 2 * MOST_NODES:
        raise FormulaProblem("FORM002", 0, reason=f"it has more than {MOST_NODES} parts")
    return _Resolver(scope, source).visit_at(tree, 0)


class _Resolver:
    def __init__(self, scope: Scope, source: str) -> None:
        self.scope = scope
        self.source = source.encode()  # Python's columns count bytes
        self.local: list[str] = []  # names bound by list comprehensions around
        self.count = 0

    def visit_at(self, node: ast.expr, depth: int) -> ast.expr:
        self.count += 1
        if depth > DEEPEST or self.count > MOST_NODES:
            raise FormulaProblem("FORM002", node.col_offset, reason=f"more than {MOST_NODES} parts, or {DEEPEST} deep")
        method: Callable[[ast.expr, int], ast.expr] | None = getattr(self, "_" + type(node).__name__.lower(), None)
        if method is None:
            self.refuse(node, _NAMES.get(type(node), "This"))
        assert method is not None
        return method(node, depth + 1)

    def refuse(self, node: ast.AST, what: str, remedy: str = _ADVICE) -> None:
        start = getattr(node, "col_offset", 0)
        length = max(getattr(node, "end_col_offset", start + 1) - start, 1)
        raise FormulaProblem("FORM003", start, length, what=what, remedy=remedy)

    # ---- plain values
    def _constant(self, node: ast.Constant, depth: int) -> ast.expr:
        value = node.value
        if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) > LARGEST_NUMBER:
            raise FormulaProblem(
                "FORM008", node.col_offset, number=str(value)[:12] + "…" if isinstance(value, int) else f"{value:.3g}"
            )
        if isinstance(value, str) and any(unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\t" for c in value):
            self.refuse(node, "A character that cannot be shown", "Leave out what begins with a backslash.")
        if isinstance(value, str) and len(value) > LONGEST_TEXT:
            raise FormulaProblem("FORM002", node.col_offset, reason="its text is too long")
        if value is not None and not isinstance(value, (bool, int, float, str)):
            self.refuse(node, "This kind of value")
        return node

    def _name(self, node: ast.Name, depth: int) -> ast.expr:
        name = node.id
        if name in self.local:
            return node
        k = key(name)
        if "__" in name or name.startswith("_"):
            raise FormulaProblem("FORM004", node.col_offset, len(name), name=name, remedy="Names start with a letter.")
        if k in self.scope.inputs:
            node.id = self.scope.inputs[k].name
            return node
        helper = self.scope.helpers.get(k)
        if helper is not None:
            if helper.parameters:
                raise FormulaProblem("FORM006", node.col_offset, len(name), name=helper.shown, gets="none",
                                     takes=_count(len(helper.parameters)), usage=_usage(helper))  # fmt: skip
            return self._bind_helper(node, helper, [])
        if k in self.scope.constants:
            return ast.copy_location(ast.Constant(self.scope.constants[k]), node)
        table = self.scope.table(name)
        if table is not None:
            return ast.copy_location(plain_node(table), node)
        if self.scope.functions.get(name):
            raise FormulaProblem("FORM003", node.col_offset, len(name), what=f"The function {name} without brackets",
                                 remedy=f"Write {name}(…) with what it works on.")  # fmt: skip
        raise FormulaProblem("FORM004", node.col_offset, len(name), name=name, remedy=self._propose(name))

    def _propose(self, name: str) -> str:
        guess = nearest(name, self.scope.known())
        if guess:
            return f'Did you mean {argument_name(guess)}? (A text needs quotes: "{name}".)'
        mine = list(dict.fromkeys(i.name for i in self.scope.inputs.values()))
        if not mine:
            return "Put a text between quotes."
        named = f"The inputs are called {', '.join(mine)}" if len(mine) > 1 else f"The input is called {mine[0]}"
        return f'{named} here. (A text needs quotes: "{name}".)'

    # ---- operators
    def _binop(self, node: ast.BinOp, depth: int) -> ast.expr:
        if not isinstance(node.op, _OPERATORS):
            advice = 'Write for example f"It is {distance}".' if isinstance(node.op, ast.BitAnd) else _ADVICE
            advice = "Write ** for a power." if isinstance(node.op, ast.BitXor) else advice
            self.refuse(node, "This operator", advice)
        if isinstance(node.op, ast.Pow) and self._bare_power(node.right):
            self.refuse(node, "A power of a power without brackets", "Write (2 ** 3) ** 2 or 2 ** (3 ** 2).")
        node.left = self.visit_at(node.left, depth)
        node.right = self.visit_at(node.right, depth)
        return node

    def _bare_power(self, node: ast.expr) -> bool:
        """Whether a node is a power that no bracket stands around."""
        if not isinstance(node, ast.BinOp) or not isinstance(node.op, ast.Pow):
            return False
        return not self.source[: node.col_offset].rstrip().endswith(b"(")

    def _unaryop(self, node: ast.UnaryOp, depth: int) -> ast.expr:
        if isinstance(node.op, ast.Invert):
            self.refuse(node, "The sign ~")
        if isinstance(node.op, ast.USub) and self._bare_power(node.operand):
            self.refuse(node, "A minus before a power without brackets", "Write -(x ** 2) or (-x) ** 2.")
        node.operand = self.visit_at(node.operand, depth)
        return node

    def _boolop(self, node: ast.BoolOp, depth: int) -> ast.expr:
        node.values = [self.visit_at(v, depth) for v in node.values]
        return node

    def _compare(self, node: ast.Compare, depth: int) -> ast.expr:
        for op, right in zip(node.ops, node.comparators, strict=True):
            if not isinstance(op, _COMPARISONS):
                self.refuse(node, "This comparison")
            if isinstance(op, (ast.Is, ast.IsNot)) and not (isinstance(right, ast.Constant) and right.value is None):
                self.refuse(node, "“is”", "Write == to ask whether two things are equal.")
        node.left = self.visit_at(node.left, depth)
        node.comparators = [self.visit_at(c, depth) for c in node.comparators]
        return node

    def _ifexp(self, node: ast.IfExp, depth: int) -> ast.expr:
        node.test, node.body, node.orelse = (self.visit_at(n, depth) for n in (node.test, node.body, node.orelse))
        return node

    # ---- collections
    def _list(self, node: ast.List, depth: int) -> ast.expr:
        node.elts = [self.visit_at(e, depth) for e in node.elts]
        return node

    def _tuple(self, node: ast.Tuple, depth: int) -> ast.expr:
        if self.source[node.col_offset : node.col_offset + 1] != b"(":
            digits = [str(e.value) for e in node.elts if isinstance(e, ast.Constant) and isinstance(e.value, int)]
            advice = "Put brackets around values that belong together."
            if any(isinstance(e, ast.Constant) for e in node.elts):
                number = f"{digits[0]}.{digits[1]}" if len(digits) == 2 else "0.8"
                advice = f"Write decimal numbers with a point, such as {number}."
            self.refuse(node, "A comma without brackets", advice)
        node.elts = [self.visit_at(e, depth) for e in node.elts]
        return node

    def _listcomp(self, node: ast.ListComp, depth: int) -> ast.expr:
        if len(node.generators) > MOST_LOOPS:
            raise FormulaProblem("FORM002", node.col_offset, reason=f"it has more than {MOST_LOOPS} loops")
        before = len(self.local)
        for loop in node.generators:
            if loop.is_async:
                self.refuse(node, "async")
            loop.iter = self.visit_at(loop.iter, depth)
            targets = loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]
            for target in targets:
                if not isinstance(target, ast.Name) or target.id.startswith("_"):
                    self.refuse(loop.target, "This after “for”", "Write a new name after “for”.")
                    continue
                taken = key(target.id) in self.scope.inputs or key(target.id) in self.scope.helpers
                taken = taken or hasattr(builtins, target.id)
                if taken or self.scope.functions.get(target.id) or key(target.id) in self.scope.constants:
                    self.refuse(target, f"“{target.id}” after “for”", "Choose a name that is not in use yet.")
                self.local.append(target.id)
            loop.ifs = [self.visit_at(i, depth) for i in loop.ifs]
        node.elt = self.visit_at(node.elt, depth)
        del self.local[before:]
        return node

    def _column(self, node: ast.Subscript, table: Table) -> ast.expr:
        """A column of a table: the list of its values."""
        wanted = node.slice.id if isinstance(node.slice, ast.Name) else getattr(node.slice, "value", "")
        name = wanted if isinstance(wanted, str) else str(wanted)
        if key(name) in table.type.keys:
            return ast.copy_location(plain_node(table.column(name)), node)
        names = [f.name for f in table.type.fields]
        guess = nearest(name, names)
        remedy = f"Did you mean {table.name}[{guess}]?" if guess else f"Its columns are {', '.join(names)}."
        raise FormulaProblem("FORM017", node.slice.col_offset, max(len(name), 1), table=table.name, title=name,
                             remedy=remedy)  # fmt: skip

    def _subscript(self, node: ast.Subscript, depth: int) -> ast.expr:
        table = self.scope.table(node.value.id) if isinstance(node.value, ast.Name) else None
        if table is not None and node.value.id not in self.local:  # type: ignore[attr-defined]
            return self._column(node, table)
        node.value = self.visit_at(node.value, depth)
        if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str):
            self._check_field(node.value, node.slice.value, node.slice)
        node.slice = self.visit_at(node.slice, depth)
        return node

    def _slice(self, node: ast.Slice, depth: int) -> ast.expr:
        for part in ("lower", "upper", "step"):
            value = getattr(node, part)
            if value is not None:
                setattr(node, part, self.visit_at(value, depth))
        return node

    def _attribute(self, node: ast.Attribute, depth: int) -> ast.expr:
        if node.attr.startswith("_") or node.attr.endswith("_"):
            self.refuse(node, f"“.{node.attr}”")
        node.value = self.visit_at(node.value, depth)
        self._check_field(node.value, node.attr, node)
        node.attr = key(node.attr)
        return node

    def _check_field(self, owner: ast.expr, field: str, at: ast.expr) -> None:
        record = self._record_of(owner)
        if record is None or key(field) in record.keys:
            return
        guess = nearest(field, [f.name for f in record.fields] + list(record.aliases))
        names = ", ".join(f.name for f in record.fields)
        column = (at.end_col_offset or 0) - len(field) if isinstance(at, ast.Attribute) else at.col_offset
        raise FormulaProblem("FORM007", column, len(field), record=record.name, field=field,
                             remedy=f"Did you mean {guess}?" if guess else f"It has {names}.")  # fmt: skip

    def _record_of(self, owner: ast.expr) -> RecordType | None:
        """The record type of a name, or of a field that is itself a record (`ball.value.x`)."""
        if isinstance(owner, ast.Name) and owner.id not in self.local:
            found = self.scope.inputs.get(key(owner.id))
            return found.record if found else None
        if isinstance(owner, ast.Attribute):
            outer = self._record_of(owner.value)
            if outer:
                wanted = outer.keys.get(key(owner.attr))
                example = next((f.example for f in outer.fields if key(f.name) == wanted), None)
                return getattr(example, "type", None)
        return None

    # ---- texts with values in them
    def _joinedstr(self, node: ast.JoinedStr, depth: int) -> ast.expr:
        node.values = [self.visit_at(v, depth) for v in node.values]
        return node

    def _formattedvalue(self, node: ast.FormattedValue, depth: int) -> ast.expr:
        if node.conversion != -1:
            self.refuse(node, "“!” in a text", "Write the value alone, or with a format such as {distance:.1f}.")
        if node.format_spec is not None:
            parts = getattr(node.format_spec, "values", [])
            spec = "".join(str(p.value) if isinstance(p, ast.Constant) else "{…}" for p in parts)
            if any(not isinstance(p, ast.Constant) for p in parts) or not _SPEC.fullmatch(spec):
                raise FormulaProblem("FORM010", node.col_offset, spec=spec)
        node.value = self.visit_at(node.value, depth)
        return node

    # ---- calls
    def _call(self, node: ast.Call, depth: int) -> ast.expr:
        if isinstance(node.func, ast.Attribute):
            name = node.func.attr
            known = self.scope.functions.get(name)
            advice = f"Write {name.upper()}(…) instead." if known else _ADVICE
            self.refuse(node.func, f"“.{name}( )”", advice)
        if not isinstance(node.func, ast.Name) or node.func.id in self.local:
            self.refuse(node, "A call of something that is not a function")
        assert isinstance(node.func, ast.Name)
        name = node.func.id
        if node.keywords:
            self.refuse(node.keywords[0], f"{node.keywords[0].arg}= inside the brackets", "Write the value alone.")
        helper = self.scope.helpers.get(key(name))
        function = self.scope.functions.get(name)
        alias = key(name) == "value" and self.scope.inputs.get("value") and key(self.scope.order[0]) != "value"
        if key(name) in self.scope.inputs and not alias:
            self.refuse(node, f"The input {name} followed by brackets", "An input is a value: write it without ( ).")
        if helper is None and key(name) in _AMBIGUOUS:
            raise FormulaProblem("FORM005", node.col_offset, len(name), name=name, remedy=_AMBIGUOUS[key(name)])
        if helper is None and function is None:
            guess = nearest(name, [h.shown for h in self.scope.helpers.values()] + self.scope.functions.names())
            advice = f"Did you mean {guess}?" if guess else "See `rrp-sheets help functions`."
            raise FormulaProblem("FORM005", node.col_offset, len(name), name=name, remedy=advice)
        args = [self.visit_at(a, depth) for a in node.args]
        if helper is not None:
            if len(args) != len(helper.parameters):
                raise FormulaProblem("FORM006", node.col_offset, len(name), name=helper.shown, gets=_given(len(args)),
                                     takes=_count(len(helper.parameters)), usage=_usage(helper))  # fmt: skip
            return self._bind_helper(node, helper, args)
        assert function is not None
        if not function.least <= len(args) <= function.most:
            raise FormulaProblem("FORM006", node.col_offset, len(name), name=function.name, gets=_given(len(args)),
                                 takes=function.takes, usage=function.usage)  # fmt: skip
        if function.make is not None:  # IF, AND, …: syntax rather than calls, their arguments are evaluated lazily
            return ast.copy_location(function.make(args), node)
        return self._bind_function(node, function, args)

    def _bind_function(self, node: ast.expr, function: Function, args: list[ast.expr]) -> ast.expr:
        call = ast.copy_location(ast.Call(ast.Name(function.name), args, []), node)
        call.bound = function.call  # type: ignore[attr-defined]
        call.charges = function.charges  # type: ignore[attr-defined]
        return call

    def _bind_helper(self, node: ast.expr, helper: HelperDef, args: list[ast.expr]) -> ast.expr:
        call = ast.copy_location(ast.Call(ast.Name(helper.shown), args, []), node)
        call.helper = helper  # type: ignore[attr-defined]
        return call


def plain_node(value: object) -> ast.Constant:
    """A node of a value that is no literal of Python: a table, or a column of one."""
    node = ast.Constant(None)
    node.value = value  # type: ignore[assignment]
    return node


def _given(n: int) -> str:
    return "none" if n == 0 else str(n)


def _count(n: int) -> str:
    return {0: "no arguments", 1: "one argument"}.get(n, f"{n} arguments")


def _usage(helper: HelperDef) -> str:
    return f"{helper.shown}({', '.join(p.name for p in helper.parameters)})" if helper.parameters else helper.shown
