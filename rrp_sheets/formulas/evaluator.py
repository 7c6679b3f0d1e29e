"""The guarded evaluator: asteval's interpreter over a prepared tree; the only import of asteval.

asteval is a deny-list and no sandbox. So nothing reaches it that the allow-list has not passed, its symbol table
holds the row's inputs and nothing else, functions are bound to their nodes before the run, attributes are looked up in
records and nowhere else, every result is bounded, and the handlers that formulas do not need are gone.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Sequence
from typing import Any

from asteval import Interpreter

from rrp_sheets.formulas.compare import NUMBERS, ORDER, compare
from rrp_sheets.formulas.functions.define import bounded, listing, shown, weighed
from rrp_sheets.formulas.functions.maths import power
from rrp_sheets.formulas.functions.tables import Pick, members_of
from rrp_sheets.formulas.limits import LARGEST_NUMBER, LONGEST_LIST, LONGEST_TEXT, STEPS
from rrp_sheets.formulas.pick import Picker
from rrp_sheets.formulas.problems import FormulaProblem, kind_of, wrong_kind
from rrp_sheets.formulas.scope import HelperDef
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import nearest
from rrp_sheets.model.values import Failure, Record, Value

_ARITHMETIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: power,
}  # fmt: skip
_PLAIN = frozenset((float, bool, int, str, type(None)))
_SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**"}


class OutOfSteps(FormulaProblem):
    """The evaluation used up its steps; nothing in the formula can catch this."""


class GuardedInterpreter(Interpreter):  # type: ignore[misc]  # asteval has no types
    """One per thread. Use :meth:`prepare` once per formula and the callable it returns per event."""

    def __init__(self) -> None:
        super().__init__(minimal=True, use_numpy=False, symtable={}, writer=None, err_writer=None)
        self.symtable: dict[str, Value] = {}
        handlers = ("constant", "name", "binop", "unaryop", "boolop", "compare", "ifexp", "list", "tuple",
                    "subscript", "slice", "attribute", "call", "listcomp", "joinedstr", "formattedvalue")  # fmt: skip
        self.node_handlers = {name: getattr(self, f"on_{name}") for name in handlers}
        self.node_handlers["iferror"] = self.on_iferror
        self.node_handlers["pick"] = self.on_pick
        self.steps = 0
        self.picker: Picker | None = None

    # ---- preparing and running
    def prepare(self, tree: ast.expr, names: Sequence[str], picker: Picker | None = None) -> Callable[..., Value]:
        """A callable for a resolved tree: the inputs' values in order in, the value or a Failure out."""
        self._bind(tree, "")
        handler: Callable[[Any], Value] = tree.handler  # type: ignore[attr-defined]
        if len(names) == 1:
            name = names[0]

            def evaluate_one(value: Value) -> Value:
                self.symtable = {name: value}
                self.picker = picker
                self.steps = STEPS
                return self._conclude(handler, tree)

            return evaluate_one

        def evaluate(*values: Value) -> Value:
            self.symtable = dict(zip(names, values, strict=True))
            self.picker = picker
            self.steps = STEPS
            return self._conclude(handler, tree)

        return evaluate

    def _conclude(self, handler: Callable[[Any], Value], tree: ast.expr) -> Value:
        try:
            result = handler(tree)
            return result if type(result) in _PLAIN else weighed(result)
        except Exception as error:
            return self._failure(error)

    def _bind(self, tree: ast.AST, owner: str) -> None:
        """Give every node its handler, so that running it needs no look-up, and helpers' trees too."""
        picks = 0
        for node in ast.walk(tree):
            handler = self.node_handlers.get(type(node).__name__.lower())
            if handler is None:
                continue
            if isinstance(node, ast.Compare):
                node.single = ORDER.get(type(node.ops[0])) if len(node.ops) == 1 else None  # type: ignore[attr-defined]
            if isinstance(node, ast.BinOp):
                node.apply = _ARITHMETIC[type(node.op)]  # type: ignore[attr-defined]
                node.divides = isinstance(node.op, (ast.Div, ast.FloorDiv, ast.Mod))  # type: ignore[attr-defined]
            if isinstance(node, Pick):
                picks += 1
                node.site = f"{owner}#{picks}"
            node.handler = handler  # type: ignore[attr-defined]
            helper: HelperDef | None = getattr(node, "helper", None)
            if helper is not None and helper.tree is not None and getattr(helper.tree, "handler", None) is None:
                self._bind(helper.tree, helper.shown)

    def run(self, node: Any, expr: str | None = None, lineno: int | None = None, with_raise: bool = True) -> Value:
        """Evaluate a prepared node. asteval's own `run` looks handlers up and swallows errors; this does neither."""
        self.steps -= 1
        if self.steps < 0:
            self.charge(0)
        return node.handler(node)

    def charge(self, steps: int) -> None:
        """Count work that a handler or a function does in one go."""
        self.steps -= steps
        if self.steps < 0:
            raise OutOfSteps("FORM105", reason="it takes too long to work out")

    def _failure(self, error: Exception) -> Failure:
        column = -1
        trace = error.__traceback__
        while trace is not None:  # the innermost node that was being evaluated
            node = trace.tb_frame.f_locals.get("node")
            column = node.col_offset if isinstance(node, ast.expr) and hasattr(node, "col_offset") else column
            trace = trace.tb_next
        if isinstance(error, FormulaProblem):
            return error.failure(column)
        if isinstance(error, ZeroDivisionError):
            return FormulaProblem("FORM101").failure(column)
        if isinstance(error, (OverflowError, MemoryError, RecursionError)):
            return FormulaProblem("FORM105", reason="numbers go up to 1e15").failure(column)
        if isinstance(error, (TypeError, ValueError, ArithmeticError)):
            # a mistake of ours in a library function: the session goes on, and the tests hold that it never happens
            return FormulaProblem("FORM109").failure(column)
        raise error

    # ---- handlers; those for constants, lists and tuples are asteval's own
    def on_name(self, node: Any) -> Value:
        """An input, a helper's parameter, or the name of a comprehension."""
        return self.symtable[node.id]

    def on_attribute(self, node: Any) -> Value:
        """A field of a record; nothing else has attributes."""
        return self._field(self.run(node.value), node.attr)

    def _field(self, owner: Value, name: str) -> Value:
        if type(owner) is not Record:
            if owner is None:
                raise FormulaProblem("FORM102", needed=f"something with a field “{name}”")
            raise FormulaProblem("FORM103", what=f"{kind_of(owner).capitalize()} has no field “{name}”")
        values = owner.values
        if name in values:
            return values[name]
        try:
            return owner.get(name)
        except KeyError:
            guess = nearest(name, [f.name for f in owner.type.fields])
            remedy = f"Did you mean {guess}?" if guess else "Check its fields."
            raise FormulaProblem("FORM104", record=owner.type.name, field=name, remedy=remedy) from None

    def on_subscript(self, node: Any) -> Value:
        """A place in a list or text, a slice of one, or a field in brackets."""
        owner = self.run(node.value)
        index = self.run(node.slice)
        if type(owner) is Record:
            if isinstance(index, str):
                return self._field(owner, index)
            if type(index) is int and owner.type.positions:
                try:
                    return owner.get(index)
                except KeyError:
                    raise FormulaProblem("FORM106", index=index, count=len(owner.type.positions)) from None
            raise FormulaProblem("FORM103", what="Write a field's name between the brackets")
        if not isinstance(owner, (list, tuple, str)):
            raise wrong_kind("a list", owner)
        if isinstance(index, slice):
            self.charge(len(owner) // 10)
            return owner[index]
        if type(index) is not int:
            raise wrong_kind("a whole number as the place in a list", index)
        if not -len(owner) <= index < len(owner):
            raise FormulaProblem("FORM106", index=index, count=len(owner))
        return owner[index]

    def on_slice(self, node: Any) -> slice:
        """The part `[first:end]`."""
        parts = [None if p is None else self.run(p) for p in (node.lower, node.upper, node.step)]
        if any(p is not None and type(p) is not int for p in parts):
            raise FormulaProblem("FORM103", what="Places in a list are whole numbers")
        if parts[2] == 0:
            raise FormulaProblem("FORM107", what="A step of 0 never ends")
        return slice(*parts)

    def on_binop(self, node: Any) -> Value:
        """Arithmetic on numbers; `+` joins two texts or two lists; `*` repeats within bounds."""
        left = self.run(node.left)
        right = self.run(node.right)
        if type(left) in NUMBERS and type(right) in NUMBERS:
            if node.divides and not right:
                raise FormulaProblem("FORM101")
            result = node.apply(left, right)
            if -LARGEST_NUMBER <= result <= LARGEST_NUMBER:
                return result
            return bounded(result)
        kind = type(node.op)
        if kind is ast.Add and isinstance(left, (str, list, tuple)) and type(left) is type(right):
            if len(left) + len(right) > (LONGEST_TEXT if isinstance(left, str) else LONGEST_LIST):
                raise FormulaProblem("FORM105", reason="it becomes too long")
            joined: Any = left
            return joined + right
        if kind is ast.Mult:
            pair = (left, right) if isinstance(left, (str, list, tuple)) else (right, left)
            if isinstance(pair[0], (str, list, tuple)) and type(pair[1]) is int:
                if len(pair[0]) * max(pair[1], 0) > (LONGEST_TEXT if isinstance(pair[0], str) else LONGEST_LIST):
                    raise FormulaProblem("FORM105", reason="it becomes too long")
                self.steps -= len(pair[0]) * max(pair[1], 0)
                return pair[0] * pair[1]
        if left is None or right is None:
            raise FormulaProblem("FORM102", needed=f"a value beside {_SIGNS[kind]}")
        what = f"{_SIGNS[kind]} cannot work with {kind_of(left)} and {kind_of(right)}"
        raise FormulaProblem("FORM103", what=what)

    def on_unaryop(self, node: Any) -> Value:
        """`-x`, `+x`, `not x`."""
        value = self.run(node.operand)
        if isinstance(node.op, ast.Not):
            return not self._truth(value, node.operand)
        if type(value) not in NUMBERS:
            raise wrong_kind("a number", value)
        return -value if isinstance(node.op, ast.USub) else +value

    def _truth(self, value: Value, node: ast.AST) -> bool:
        if type(value) in NUMBERS or value is None:
            return bool(value)
        raise FormulaProblem("FORM108", what=kind_of(value), example="== or <")

    def on_boolop(self, node: Any) -> bool:
        """`and`, `or`: TRUE or FALSE, evaluated only as far as needed."""
        wanted = isinstance(node.op, ast.Or)
        return next((wanted for v in node.values if self._truth(self.run(v), v) is wanted), not wanted)

    def on_ifexp(self, node: Any) -> Value:
        """The conditional expression; IF is one."""
        return self.run(node.body if self._truth(self.run(node.test), node.test) else node.orelse)

    def on_iferror(self, node: Any) -> Value:
        """IFERROR: the other value when the first fails. Running out of steps is not forgiven."""
        try:
            return self.run(node.value)
        except OutOfSteps:
            raise
        except (FormulaProblem, ArithmeticError, TypeError, ValueError):
            return self.run(node.otherwise)

    def on_compare(self, node: Any) -> bool:
        """Comparisons, chained ones too (`0 < x < 10` means between)."""
        left = self.run(node.left)
        if node.single is not None:
            right = self.run(node.comparators[0])
            if type(left) in NUMBERS and type(right) in NUMBERS:
                held: bool = node.single(left, right)
                return held
            return compare(node.ops[0], left, right, self.charge)
        for op, comparator in zip(node.ops, node.comparators, strict=True):
            right = self.run(comparator)
            if not compare(op, left, right, self.charge):
                return False
            left = right
        return True

    def on_call(self, node: Any) -> Value:
        """A library function bound to the node, or a helper."""
        args = [self.run(a) for a in node.args]
        helper: HelperDef | None = getattr(node, "helper", None)
        if helper is None:
            for arg in args:  # what a function is given it will walk through
                if type(arg) is list or type(arg) is tuple or type(arg) is Table:
                    self.charge(len(arg))
            call = node.bound
            result = bounded(call(*args, charge=self.charge) if node.charges else call(*args))
            if type(result) is list:  # lists of lists could grow without bound: their length counts as steps
                self.steps -= len(result)
            return result
        outer = self.symtable
        self.symtable = {p.name: a for p, a in zip(helper.parameters, args, strict=True)}
        try:
            return self.run(helper.tree)
        finally:
            self.symtable = outer

    def on_pick(self, node: Any) -> Value:
        """PICK: the next of its draws, or the first member where nothing runs."""
        members = members_of([self.run(m) for m in node.members])
        self.charge(len(members))
        return members[0] if self.picker is None else self.picker.pick(node.site, members)

    def on_listcomp(self, node: Any) -> list[Value]:
        """A list comprehension; its names live in a table of their own."""
        found: list[Value] = []
        outer = self.symtable
        self.symtable = dict(outer)
        try:
            self._loop(node, 0, found)
        finally:
            self.symtable = outer
        return found

    def _loop(self, comprehension: Any, level: int, found: list[Value]) -> None:
        if level == len(comprehension.generators):
            found.append(self.run(comprehension.elt))
            if len(found) > LONGEST_LIST:
                raise FormulaProblem("FORM105", reason=f"lists have at most {LONGEST_LIST} places")
            return
        loop = comprehension.generators[level]
        members = self.run(loop.iter)
        for member in listing(members):
            self.steps -= 1
            self._assign(loop.target, member)
            if all(self._truth(self.run(i), i) for i in loop.ifs):
                self._loop(comprehension, level + 1, found)

    def _assign(self, target: Any, member: Value) -> None:
        if isinstance(target, ast.Name):
            self.symtable[target.id] = member
            return
        if not isinstance(member, (list, tuple)) or len(member) != len(target.elts):
            raise FormulaProblem("FORM103", what=f"Each member must be a list of {len(target.elts)} values")
        for name, value in zip(target.elts, member, strict=True):
            self.symtable[name.id] = value

    def on_joinedstr(self, node: Any) -> str:
        """A text with values in it: `f"I see {colour}"`."""
        return bounded("".join(self.run(v) for v in node.values))  # type: ignore[no-any-return]

    def on_formattedvalue(self, node: Any) -> str:
        """One value in such a text, with its format."""
        value = self.run(node.value)
        if node.format_spec is None:
            return shown(value)
        spec = "".join(part.value for part in node.format_spec.values)
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            return format(shown(value), spec)
        try:
            return format(value, spec)
        except ValueError:
            raise FormulaProblem("FORM107", what=f"The format “{spec}” does not fit {kind_of(value)}") from None
