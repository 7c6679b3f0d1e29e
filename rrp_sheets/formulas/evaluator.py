"""The guarded evaluator: asteval's interpreter over a prepared tree; the only import of asteval.

asteval is a deny-list and no sandbox. So nothing reaches it that the allow-list has not passed, its symbol table
holds the row's inputs and nothing else, functions are bound to their nodes before the run, attributes are looked up in
records and nowhere else, every result is bounded, and the handlers that formulas do not need are gone.
"""

from __future__ import annotations

import ast
import operator
import sys
from collections.abc import Callable, Sequence
from typing import Any

from asteval import Interpreter

from rrp_sheets.formulas.functions.define import bounded, listing, shown, too_many, truth, weighed
from rrp_sheets.formulas.functions.maths import power
from rrp_sheets.formulas.functions.table_functions import members_of
from rrp_sheets.formulas.limits import DEEPEST_HELPERS, LARGEST_NUMBER, LONGEST_LIST, STEPS
from rrp_sheets.formulas.operations import NUMBERS, ORDER, Picker, arithmetic, at_place, compare, field, formatted, same
from rrp_sheets.formulas.parsing import IfError, Join, Pick, Switch
from rrp_sheets.formulas.problems import FormulaProblem, problem_of, wrong_kind
from rrp_sheets.formulas.scope import HelperDef
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.values import Failure, Record, Value
from rrp_sheets.texts import N_

_PLAIN = frozenset((float, bool, int, str, type(None)))


class OutOfSteps(FormulaProblem):
    """Raised when the evaluation has used up its steps; nothing in the formula can catch this."""


class GuardedInterpreter(Interpreter):  # type: ignore[misc]  # asteval has no types
    """Interpreter for one thread: call :meth:`prepare` once per formula, and its result once per event."""

    def __init__(self) -> None:
        super().__init__(minimal=True, use_numpy=False, symtable={}, writer=None, err_writer=None)
        self.symtable: dict[str, Value] = {}
        self.handlers: dict[type, Callable[[Any], Value]] = {
            ast.Constant: self.on_constant, ast.Name: self.on_name, ast.BinOp: self.on_binop,
            ast.UnaryOp: self.on_unaryop, ast.BoolOp: self.on_boolop, ast.Compare: self.on_compare,
            ast.IfExp: self.on_ifexp, ast.List: self.on_list, ast.Tuple: self.on_tuple, ast.Slice: self.on_slice,
            ast.Subscript: self.on_subscript, ast.Attribute: self.on_attribute, ast.Call: self.on_call,
            ast.ListComp: self.on_listcomp, ast.JoinedStr: self.on_joinedstr, Join: self.on_join, Pick: self.on_pick,
            ast.FormattedValue: self.on_formattedvalue, IfError: self.on_iferror, Switch: self.on_switch,
        }  # fmt: skip
        self.node_handlers: dict[str, Any] = {}
        self.steps = 0
        self.helpers_deep = 0
        self.picker: Picker | None = None

    # ---- preparing and running
    def prepare(self, tree: ast.expr, names: Sequence[str], picker: Picker | None = None) -> Callable[..., Value]:
        """Return a callable for a resolved tree, from the inputs' values in order to a value or a Failure.

        The tree itself is not changed, so it may be prepared on several interpreters.
        """
        tree = Binder(self.handlers).bind(tree)
        handler: Callable[[Any], Value] = tree.handler  # type: ignore[attr-defined]
        name = names[0] if len(names) == 1 else None

        def evaluate(*values: Value) -> Value:
            self.symtable = {name: values[0]} if name is not None else dict(zip(names, values, strict=True))
            self.picker = picker
            self.helpers_deep = 0
            self.steps = STEPS
            try:
                result = handler(tree)
                return result if type(result) in _PLAIN else weighed(result)
            except Exception as error:
                return failure_of(error)

        return evaluate

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
            raise OutOfSteps("FORM105", reason=N_("it takes too long to calculate"))

    # ---- values; the handlers of constants, lists and tuples are asteval's own
    def on_name(self, node: Any) -> Value:
        """Return an input, a helper's parameter, or a variable of a comprehension."""
        return self.symtable[node.id]

    def on_attribute(self, node: Any) -> Value:
        """Return a field of a record; nothing else has attributes."""
        owner = self.run(node.value)
        if type(owner) is Record and node.attr in owner.values:
            return owner.values[node.attr]
        return field(owner, node.attr)

    def on_subscript(self, node: Any) -> Value:
        """Return a place in a list or text, a slice of one, or a field in brackets."""
        return at_place(self.run(node.value), self.run(node.slice), self.charge)

    def on_slice(self, node: Any) -> slice:
        """Return the slice for `[first:end]`."""
        parts = [None if p is None else self.run(p) for p in (node.lower, node.upper, node.step)]
        if any(p is not None and type(p) is not int for p in parts):
            raise FormulaProblem("FORM103", what=N_("Positions in a list are whole numbers"))
        if parts[2] == 0:
            raise FormulaProblem("FORM107", what=N_("A step of 0 never ends"))
        return slice(*parts)

    # ---- operators
    def on_binop(self, node: Any) -> Value:
        """Calculate with numbers; `+` also joins two texts or two lists, and `*` repeats within bounds."""
        left = self.run(node.left)
        right = self.run(node.right)
        if type(left) in NUMBERS and type(right) in NUMBERS:
            if node.divides and not right:
                raise FormulaProblem("FORM101")
            result = node.apply(left, right)
            if -LARGEST_NUMBER <= result <= LARGEST_NUMBER:
                return result
            return bounded(result)
        return arithmetic(type(node.op), left, right, self.charge)

    def on_join(self, node: Any) -> str:
        """Join all values of `&` as a text, numbers as people read them."""
        return self._text([shown(self.run(v)) for v in node.values])

    def _text(self, parts: list[str]) -> str:
        joined: str = bounded("".join(parts))
        self.steps -= len(joined) // 100
        return joined

    def on_unaryop(self, node: Any) -> Value:
        """Evaluate `-x`, `+x` or `not x`."""
        value = self.run(node.operand)
        if isinstance(node.op, ast.Not):
            return not truth(value)
        if type(value) not in NUMBERS:
            raise wrong_kind(N_("a number"), value)
        return -value if isinstance(node.op, ast.USub) else +value

    def on_boolop(self, node: Any) -> bool:
        """Evaluate `and` or `or` to TRUE or FALSE, only as far as needed."""
        wanted = isinstance(node.op, ast.Or)
        return next((wanted for v in node.values if truth(self.run(v)) is wanted), not wanted)

    def on_compare(self, node: Any) -> bool:
        """Evaluate comparisons, chained ones too (`0 < x < 10` means between)."""
        left = self.run(node.left)
        if node.single is not None:
            right = self.run(node.comparators[0])
            if type(left) in NUMBERS and type(right) in NUMBERS:
                held: bool = node.single(left, right)
                return held
            return compare(node.ops[0], left, right, self.charge)
        for quick, op, comparator in node.chain:
            right = self.run(comparator)
            if quick is not None and type(left) in NUMBERS and type(right) in NUMBERS:
                if not quick(left, right):
                    return False
            elif not compare(op, left, right, self.charge):
                return False
            left = right
        return True

    # ---- choices
    def on_ifexp(self, node: Any) -> Value:
        """Evaluate the conditional expression, which IF is too."""
        return self.run(node.body if truth(self.run(node.test)) else node.orelse)

    def on_iferror(self, node: Any) -> Value:
        """Evaluate IFERROR and ISERROR; running out of steps is not caught."""
        try:
            value = self.run(node.value)
            return value if node.otherwise is not None else False
        except OutOfSteps:
            raise
        except (FormulaProblem, ArithmeticError):
            return self.run(node.otherwise) if node.otherwise is not None else True

    def on_switch(self, node: Any) -> Value:
        """Evaluate SWITCH and IFS: return the result of the first case that fits."""
        value = None if node.value is None else self.run(node.value)
        for case, result in zip(node.cases, node.results, strict=True):
            found = self.run(case)
            if truth(found) if node.value is None else same(value, found, self.charge):
                return self.run(result)
        if node.otherwise is None:
            raise FormulaProblem("FORM113")
        return self.run(node.otherwise)

    def on_pick(self, node: Any) -> Value:
        """Evaluate PICK: return its next draw, or the first member when there is no picker."""
        members = members_of([self.run(m) for m in node.members])
        self.charge(len(members))
        return members[0] if self.picker is None else self.picker.pick(node.site, members, self.charge)

    # ---- calls
    def on_call(self, node: Any) -> Value:
        """Call a library function bound to the node, or a helper."""
        args = [self.run(a) for a in node.args]
        if node.entry is not None:
            return self._helper(node, args)
        for arg in args:  # what a function is given it will walk through
            kind = type(arg)
            if kind is list or kind is tuple or kind is Table:
                self.charge(len(arg))
            elif kind is str:
                self.steps -= len(arg) // 100
        result = bounded(node.bound(*args, charge=self.charge) if node.charges else node.bound(*args))
        if type(result) is list:  # lists of lists could grow without bound: their length counts as steps
            self.steps -= len(result)
        return result

    def _helper(self, node: Any, args: list[Value]) -> Value:
        outer = self.symtable
        self.helpers_deep += 1
        if self.helpers_deep > DEEPEST_HELPERS:
            reason = N_("helpers call each other more than {most} deep", most=DEEPEST_HELPERS)
            raise OutOfSteps("FORM105", reason=reason)
        self.symtable = dict(zip(node.parameters, args, strict=True))
        try:
            return self.run(node.entry[0])
        finally:
            self.symtable = outer
            self.helpers_deep -= 1

    def on_listcomp(self, node: Any) -> list[Value]:
        """Evaluate a list comprehension, whose variables stand in a symbol table of their own."""
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
                raise too_many()
            return
        loop = comprehension.generators[level]
        for member in listing(self.run(loop.iter)):
            self.steps -= 1
            if isinstance(loop.target, ast.Name):
                self.symtable[loop.target.id] = member
            else:
                names = [name.id for name in loop.target.elts]
                if not isinstance(member, (list, tuple)) or len(member) != len(names):
                    what = N_("Each member must be a list of {count} values", count=len(names))
                    raise FormulaProblem("FORM103", what=what)
                self.symtable.update(zip(names, member, strict=True))
            if all(truth(self.run(i)) for i in loop.ifs):
                self._loop(comprehension, level + 1, found)

    # ---- texts with values in them
    def on_joinedstr(self, node: Any) -> str:
        """Return a text with values in it: `f"I see {colour}"`."""
        return self._text([self.run(v) for v in node.values])

    def on_formattedvalue(self, node: Any) -> str:
        """Return one value in such a text, with its format."""
        value = self.run(node.value)
        return shown(value) if node.format_spec is None else formatted(value, node.format_spec.values[0].value)


def failure_of(error: Exception) -> Failure:
    """Return the failure for an exception of an evaluation; raise it again when it is none of a formula's."""
    problem = problem_of(error)
    if problem is None:
        raise error
    column, helper = -1, ""
    trace = error.__traceback__
    while trace is not None and not helper:  # the innermost node, but of this formula, not of its helpers
        node = trace.tb_frame.f_locals.get("node")
        if isinstance(node, ast.expr) and hasattr(node, "col_offset"):
            column = node.col_offset
            inside = "outer" in trace.tb_frame.f_locals and hasattr(node, "helper")
            helper = node.helper.shown if inside else ""  # type: ignore[attr-defined]
        trace = trace.tb_next
    failure = problem.failure(column)
    if not helper:
        return failure
    message = N_("In the helper {helper}: {message}", helper=helper, message=failure.message)
    return Failure(failure.code, message, column)


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
        """Return the copy; raises FormulaProblem FORM015 when a helper that it calls has no tree."""
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
            helper: HelperDef | None = getattr(node, "helper", None)
            node.entry = None
            if helper is not None:
                if id(helper) not in self.entries:
                    self.entries[id(helper)] = []
                    self.waiting.append(helper)
                node.entry = self.entries[id(helper)]
                node.parameters = [p.name for p in helper.parameters]
        return node


def _written(node: ast.expr) -> str:
    """Return an argument of PICK as a text, which seeds its draws; a table by its name alone."""
    if isinstance(node, ast.Constant) and isinstance(node.value, Table):
        return f"the table {node.value.name}"
    # The text seeds the draws, so it must be the same in every Python: 3.13 adds the context that our own nodes lack,
    # and leaves out what is empty.
    for inner in ast.walk(node):
        if "ctx" in inner._fields and not hasattr(inner, "ctx"):
            inner.ctx = ast.Load()  # type: ignore[attr-defined]  # a Name, an Attribute, a Subscript or a list
    if sys.version_info >= (3, 13):
        return ast.dump(node, show_empty=True)
    return ast.dump(node)
