"""The static allow-list: what is not expressly allowed is refused, with its position.

The tree that comes out is ready for the evaluator: names are resolved, functions and helpers are bound to their
nodes, `IF`, `AND`, `OR`, `NOT`, `IFERROR`, `SWITCH` and `PICK` have become nodes of their own.
"""

from __future__ import annotations

import ast
import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NoReturn

from rrp_sheets.diagnostics.report import meant
from rrp_sheets.formulas.functions.define import arguments
from rrp_sheets.formulas.hints import AMBIGUOUS, cell, cell_reference, function_here, name_here
from rrp_sheets.formulas.limits import DEEPEST, LARGEST_NUMBER, MOST_LOOPS, MOST_NODES
from rrp_sheets.formulas.parsing import Join, Pick, Switch, unread
from rrp_sheets.formulas.problems import KINDS, FormulaProblem, together
from rrp_sheets.formulas.scope import HelperDef, Scope
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.names import argument_name, key, nearest
from rrp_sheets.model.values import RecordType
from rrp_sheets.texts import N_

_SPEC = re.compile(r"[<>^]?[+ -]?0?\d{0,2},?(\.\d{1,2})?[defgs%]?")
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)
_SIGNS = (ast.UAdd, ast.USub, ast.Not)
_COMPARISONS = (ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn, ast.Is, ast.IsNot)
_TABLE_ARGUMENT = {"INDEX": 0, "XLOOKUP": 2, "FIRST": 0, "LAST": 0}
"""Functions that give a row of the table which is their argument at that place."""
_DECIMAL_COMMA = re.compile(r"(?<![\w.])\d+,\d+")
_ADVICE = N_("Formulas are built of inputs, numbers, texts, operators and the library's functions.")
_RESERVED = frozenset((
    "print", "open", "eval", "exec", "dir", "id", "type", "object", "input", "vars", "globals", "locals", "getattr",
    "setattr", "hasattr", "compile", "exit", "quit", "repr", "self", "true", "false", "none", "blank", "null",
))  # fmt: skip


def resolve(tree: ast.expr, scope: Scope, typed: str, problems: Iterable[FormulaProblem] = ()) -> ast.expr:
    """Check a tree against the allow-list and bind its names.

    Raises:
        FormulaProblem: the first violation or problem, with the others that do not follow from it.
    """
    resolver = _Resolver(scope, typed)
    resolved = resolver.visit_at(tree, 0)
    if found := [*problems, *resolver.problems]:
        raise together(found)
    table = _table_of(resolved)
    if table is not None:
        raise FormulaProblem("FORM020", tree.col_offset, len(table.name), table=table.name)
    for what, text, node in texts_compared(resolved):
        if isinstance(what, ast.Attribute) and (record := resolver.record_of(what.value)):
            node.value = record.standard(what.attr, text)
    return resolved


def texts_compared(tree: ast.AST) -> Iterator[tuple[ast.Name | ast.Attribute, str, ast.Constant]]:
    """Yield the names and fields that a formula compares with texts, these texts and their nodes."""
    for node in ast.walk(tree):
        pairs: list[tuple[ast.AST | None, ast.AST]] = []
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            left, right = node.left, node.comparators[0]
            if isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
                pairs = [(left, right), (right, left)]
            elif isinstance(right, (ast.List, ast.Tuple)):
                pairs = [(left, one) for one in right.elts]
        elif isinstance(node, Switch):
            pairs = [(node.value, case) for case in node.cases]
        for what, text in pairs:
            if not isinstance(what, (ast.Name, ast.Attribute)) or not isinstance(text, ast.Constant):
                continue
            if isinstance(text.value, str):
                yield what, text.value, text


class _Resolver:
    def __init__(self, scope: Scope, typed: str) -> None:
        self.scope = scope
        self.typed = typed
        self.local: dict[str, str] = {}  # names bound by list comprehensions around, by key
        self.problems: list[FormulaProblem] = []  # after which looking went on
        self.count = 0
        self._visited: list[ast.expr] = []

    def visit_at(self, node: ast.expr, depth: int) -> ast.expr:
        self.count += 1
        if depth > DEEPEST or self.count > MOST_NODES:
            reason = N_("more than {most} parts, or {deepest} deep", most=MOST_NODES, deepest=DEEPEST)
            raise FormulaProblem("FORM002", node.col_offset, reason=reason)
        if hasattr(node, "unread"):
            return node
        self._visited.append(node)
        names = dict(self.local)
        method = _METHODS.get(type(node))
        try:
            if method is None:
                self.refuse(node, N_("This"))
            return method(self, node, depth + 1)
        except FormulaProblem as problem:
            if problem.code == "FORM002":  # of a formula that is too large nothing else is said
                raise
            self.local = names
            self.problems.append(problem)
            for arg in node.args if isinstance(node, ast.Call) else ():  # they may be right or wrong by themselves
                if not any(arg is one for one in self._visited):
                    self.visit_at(arg, depth + 1)
            return unread(ast.copy_location(ast.Constant(None), node))

    def visit_all(self, nodes: list[ast.expr], depth: int) -> list[ast.expr]:
        return [self.visit_at(n, depth) for n in nodes]

    def refuse(self, node: ast.expr, what: str, remedy: str = _ADVICE, **details: object) -> NoReturn:
        raise FormulaProblem("FORM003", node.col_offset, _width(node), what=what, remedy=remedy, **details)

    # ---- names
    def on_name(self, node: ast.Name, depth: int) -> ast.expr:
        name, k, scope = node.id, key(node.id), self.scope
        if k in self.local:
            node.id = self.local[k]
            return node
        if name.startswith("_") or "__" in name:
            remedy = N_("Names start with a letter.")
            raise FormulaProblem("FORM004", node.col_offset, _width(node), name=name, remedy=remedy)
        if k in scope.inputs:
            node.id = scope.inputs[k].name
            return node
        if (helper := scope.helpers.get(k)) is not None:
            return _call_of_helper(node, helper, [], _width(node))
        if k in scope.constants:
            return ast.copy_location(ast.Constant(scope.constants[k]), node)
        if (table := scope.table(name)) is not None:
            return ast.copy_location(constant_node(table), node)
        if k == "value" and len(scope.inputs) > 1:
            remedy = N_("Write an input's name: {names}.", names=", ".join(self._mine()))
            self.refuse(node, N_("{name} in a row with several inputs", name=name), remedy, name=name)
        if scope.functions.get(name) and not self._as_field(k):
            remedy = N_("Write {name}(…) with what it works on.", name=name)
            self.refuse(node, N_("The function {name} without brackets", name=name), remedy, name=name)
        if cell(name) and not any(cell(other) for other in scope.known()):
            raise cell_reference(node.col_offset, name, self._mine())
        problem = FormulaProblem("FORM004", node.col_offset, _width(node), name=name, **self._propose(name))
        if self._is_choice(k) and not problem.details.get("guess"):
            problem.written = f'"{name}"'
        raise problem

    def _mine(self) -> list[str]:
        return list(dict.fromkeys(i.name for i in self.scope.inputs.values()))

    def _as_field(self, k: str) -> str | None:
        """Return a field of that name with its input: `distance` alone is often meant for `redBall.distance`."""
        for each in self.scope.inputs.values():
            field = each.record.keys.get(k) if each.record else None
            if each.record and field:
                return f"{each.name}.{each.record.names[field]}"
        return None

    def _is_choice(self, k: str) -> bool:
        records = [i.record for i in self.scope.inputs.values() if i.record]
        return any(k == key(word) for r in records for f in r.fields for word in (*f.choices, *f.aliases))

    def _propose(self, name: str) -> dict[str, Any]:
        """Return the details `remedy` and `guess` for a name that is not known."""
        k, mine = key(name), self._mine()
        if guess := self._as_field(k):
            remedy = N_('Did you mean {field}? (A text needs quotes: "{name}".)', field=guess, name=name)
            return {"remedy": remedy, "guess": guess}
        if self._is_choice(k):
            return {"remedy": N_('Put the text between quotes: "{name}".', name=name)}
        if guess := self.scope.propose(name, self.scope.known()):
            guess = argument_name(guess)
            remedy = N_('Did you mean {guess}? (A text needs quotes: "{name}".)', guess=guess, name=name)
            return {"remedy": remedy, "guess": guess}
        if (known := name_here(k)) is not None:
            return {"remedy": known}
        if not mine:
            return {"remedy": N_("Put a text between quotes.")}
        named = N_("The input is called {value}", value=mine[0])
        if len(mine) > 1:
            named = N_("The inputs are called {mine}", mine=", ".join(mine))
        return {"remedy": N_('{named} here. (A text needs quotes: "{name}".)', named=named, name=name)}

    def new_name(self, target: ast.expr) -> str:
        if not isinstance(target, ast.Name) or target.id.startswith("_") or "__" in target.id:
            self.refuse(target, N_("This after “for”"), N_("Write a new name after “for”."))
        name, k = unicodedata.normalize("NFKC", target.id), key(target.id)
        scope = self.scope
        taken = k in scope.inputs or k in scope.helpers or k in scope.constants or scope.table(name) is not None
        if taken or scope.functions.get(name) or k in _RESERVED:
            self.refuse(target, N_("“{name}” after “for”", name=name), N_("Choose a name that is not in use yet."))
        target.id = self.local[k] = name
        return k

    # ---- calls
    def on_call(self, node: ast.Call, depth: int) -> ast.expr:
        if isinstance(node.func, ast.Attribute):
            name = node.func.attr
            function = self.scope.functions.get(name)
            remedy = function_here(key(name)) or _ADVICE
            if function:
                remedy = N_("Write {name}(…) instead.", name=function.name)
            self.refuse(node.func, N_("“.{name}( )”", name=name), remedy)
        if not isinstance(node.func, ast.Name) or key(node.func.id) in self.local:
            self.refuse(node, N_("A call of something that is not a function"))
        name, k, scope = node.func.id, key(node.func.id), self.scope
        helper = scope.helpers.get(k)
        function = scope.functions.get(name)
        alias = k == "value" and k in scope.inputs and scope.inputs[k].name != "value"
        if k in scope.inputs and not alias and not (helper is None and function is not None and k == "value"):
            remedy = N_("An input is a value: write it without ( ).")
            self.refuse(node, N_("The input {name} followed by brackets", name=name), remedy)
        if helper is not None:
            unclear = any(hasattr(arg, "unread") for arg in node.args)
            return _call_of_helper(node, helper, self._arguments(node, depth), _width(node.func), unclear)
        if k in AMBIGUOUS:
            raise FormulaProblem("FORM019", node.col_offset, len(name), name=name, remedy=AMBIGUOUS[k])
        if function is None:
            raise self._unknown_function(node, name)
        unclear = any(hasattr(arg, "unread") for arg in node.args)  # how many they are meant to be is not known
        args = self._arguments(node, depth)
        if unclear:
            return unread(node)
        if not function.least <= len(args) <= function.most:
            usage = self._with_comma_hint(function.usage, node) if len(args) > function.most else function.usage
            raise FormulaProblem("FORM006", node.col_offset, len(name), name=function.name, gets=_given(len(args)),
                                 takes=function.takes, usage=usage)  # fmt: skip
        if function.make is None:
            call: Any = ast.copy_location(ast.Call(ast.Name(function.name), args, []), node)
            call.bound, call.charges, call.gives = function.call, function.charges, function.gives
            return call  # type: ignore[no-any-return]
        if any(hasattr(arg, "unread") for arg in args):
            return unread(node)
        try:  # IF, AND, …: syntax rather than calls, their arguments are evaluated lazily
            return ast.copy_location(function.make(args), node)
        except FormulaProblem as problem:
            problem.column, problem.length = node.col_offset, len(name)
            raise

    def _arguments(self, node: ast.Call, depth: int) -> list[ast.expr]:
        scope = self.scope
        names = (self.local, scope.inputs, scope.helpers, scope.constants, scope.tables)
        for arg in node.args:
            if getattr(arg, "sheet", False) and isinstance(arg, ast.Compare) and isinstance(arg.left, ast.Name):
                left = arg.left.id
                if not any(key(left) in known for known in names):
                    what = N_("{left}= inside the brackets", left=left)
                    remedy = N_("Write the value alone. ({left} is not an input here.)", left=left)
                    problem = FormulaProblem("FORM003", arg.col_offset, _width(arg), what=what, remedy=remedy)
                    self.problems.append(problem)
                    unread(arg)
        return self.visit_all(node.args, depth)

    def _with_comma_hint(self, usage: str, node: ast.Call) -> str:
        found = _DECIMAL_COMMA.search(self.typed[node.col_offset : node.end_col_offset])
        number = found[0].replace(",", ".") if found else ""
        return N_("{usage} — decimal numbers with a point: {value}", usage=usage, value=number) if found else usage

    def _unknown_function(self, node: ast.Call, name: str) -> FormulaProblem:
        advice = function_here(key(name))
        if self.scope.table(name) is not None:
            advice = N_("{name} is a table: write INDEX({name}; 1) for a row, or {name}[…] for a column.", name=name)
        guess = None
        if advice is None and not name.startswith("_"):
            known = [h.shown for h in self.scope.helpers.values()] + self.scope.functions.names()
            guess = self.scope.propose(name, known)
        told = meant(guess, advice or N_("See `rrp-sheets help functions`."))
        return FormulaProblem("FORM005", node.col_offset, len(name), name=name, **told)

    # ---- plain values
    def on_constant(self, node: ast.Constant, depth: int) -> ast.expr:
        value = node.value
        if isinstance(value, str):
            if any(unicodedata.category(c) in ("Cc", "Cs") for c in value if not c.isprintable() and c not in "\n\t"):
                remedy = N_("Leave out the part that begins with a backslash.")
                self.refuse(node, N_("A character that cannot be shown"), remedy)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            if not abs(value) <= LARGEST_NUMBER:
                raise FormulaProblem("FORM008", node.col_offset, number=f"{value:.3g}")
        elif value is not None and not isinstance(value, bool):
            self.refuse(node, N_("This kind of value"))
        return node

    # ---- operators
    def on_binop(self, node: ast.BinOp, depth: int) -> ast.expr:
        if not isinstance(node.op, _OPERATORS):
            self.refuse(node, N_("This operator"))
        node.left = self.visit_at(node.left, depth)
        node.right = self.visit_at(node.right, depth)
        return node

    def on_unaryop(self, node: ast.UnaryOp, depth: int) -> ast.expr:
        if not isinstance(node.op, _SIGNS):
            self.refuse(node, N_("This sign"))
        node.operand = self.visit_at(node.operand, depth)
        return node

    def on_values(self, node: ast.BoolOp | ast.JoinedStr | Join, depth: int) -> ast.expr:
        node.values = self.visit_all(node.values, depth)
        return node

    def on_compare(self, node: ast.Compare, depth: int) -> ast.expr:
        for op, right in zip(node.ops, node.comparators, strict=True):
            if not isinstance(op, _COMPARISONS):
                self.refuse(node, N_("This comparison"))
            if isinstance(op, (ast.Is, ast.IsNot)) and not (isinstance(right, ast.Constant) and right.value is None):
                self.refuse(node, N_("“{text}”", text="is"), N_("Write = to ask whether two values are equal."))
        node.left = self.visit_at(node.left, depth)
        node.comparators = self.visit_all(node.comparators, depth)
        return node

    def on_ifexp(self, node: ast.IfExp, depth: int) -> ast.expr:
        node.test, node.body, node.orelse = (self.visit_at(n, depth) for n in (node.test, node.body, node.orelse))
        return node

    # ---- collections
    def on_list(self, node: ast.List | ast.Tuple, depth: int) -> ast.expr:
        node.elts = self.visit_all(node.elts, depth)
        return node

    def on_listcomp(self, node: ast.ListComp, depth: int) -> ast.expr:
        if len(node.generators) > MOST_LOOPS:
            reason = N_("it has more than {most} loops", most=MOST_LOOPS)
            raise FormulaProblem("FORM002", node.col_offset, reason=reason)
        before = dict(self.local)
        for loop in node.generators:
            loop.iter = self.visit_at(loop.iter, depth)
            for target in loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]:
                self.new_name(target)
            loop.ifs = self.visit_all(loop.ifs, depth)
        node.elt = self.visit_at(node.elt, depth)
        self.local = before
        return node

    def on_subscript(self, node: ast.Subscript, depth: int) -> ast.expr:
        if (table := self._named_table(node.value)) is not None:
            return self._column(node, table)
        node.value = self.visit_at(node.value, depth)
        if hasattr(node.value, "unread"):  # a table's name, perhaps, and then a column's in the brackets
            return unread(node)
        if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str):
            self._check_field(node.value, node.slice.value, node.slice)
        node.slice = self.visit_at(node.slice, depth)
        return node

    def _named_table(self, node: ast.expr) -> Table | None:
        named = isinstance(node, ast.Name) and key(node.id) not in self.local
        return self.scope.table(node.id) if named else None  # type: ignore[attr-defined]

    def _column(self, node: ast.Subscript, table: Table) -> ast.expr:
        """Return a column of a table as a constant: the list of its values."""
        name = str(node.slice.value) if isinstance(node.slice, ast.Constant) else ""
        if key(name) in table.type.keys:
            return ast.copy_location(constant_node(table.column(name)), node)
        names = [f.name for f in table.type.fields]
        if name.strip().isdecimal():
            remedy = N_("For row {name}, write INDEX({name2}; {name}).", name=name, name2=table.name)
        elif guess := nearest(name, names):
            remedy = N_("Did you mean {name}[{guess}]?", name=table.name, guess=guess)
        elif names:
            one = N_("Its only column is {names}: use that one, or add this column to the table.")
            several = N_("Its columns are {names}: use one of them, or add this column to the table.")
            remedy = N_(one if len(names) == 1 else several, names=", ".join(names))
        else:
            remedy = N_("None of its columns has a name: write one into its first row.")
        raise FormulaProblem("FORM017", node.slice.col_offset, max(len(name), 1), table=table.name, title=name,
                             remedy=remedy)  # fmt: skip

    def on_slice(self, node: ast.Slice, depth: int) -> ast.expr:
        for part in ("lower", "upper", "step"):
            if (value := getattr(node, part)) is not None:
                setattr(node, part, self.visit_at(value, depth))
        return node

    # ---- fields
    def on_attribute(self, node: ast.Attribute, depth: int) -> ast.expr:
        if node.attr.startswith("_") or node.attr.endswith("_"):
            self.refuse(node, N_("“.{name}”", name=node.attr))
        if (table := self._named_table(node.value)) is not None:
            what = N_("The table {name}", name=table.name)
            remedy = N_("Write {name}[{column}] for the column.", name=table.name, column=node.attr)
            raise FormulaProblem("FORM021", node.col_offset, len(table.name), what=what, remedy=remedy)
        node.value = self.visit_at(node.value, depth)
        self._check_field(node.value, node.attr, node)
        node.attr = key(node.attr)
        return node

    def _check_field(self, owner: ast.expr, field: str, at: ast.expr) -> None:
        record = self.record_of(owner)
        if record is None:
            found = self.scope.inputs.get(key(owner.id)) if isinstance(owner, ast.Name) else None
            if found is not None and found.kind and key(found.name) not in self.local:
                what = N_("{name} is {kind}: it", name=found.name, kind=KINDS[found.kind])
                remedy = N_("Write {name} alone.", name=found.name)
                raise FormulaProblem("FORM021", at.col_offset, len(found.name), what=what, remedy=remedy)
            return
        if key(field) in record.keys:
            return
        fields = [f.name for f in record.fields]
        guess = nearest(field, [*fields, *record.aliases])
        if not field.isascii():  # in the words of who wrote it
            own = {name: alias for alias, name in [*record.aliases.items()][::-1] if not alias.isascii()}
            fields = [own.get(name, name) for name in fields]
        names = ", ".join(fields)
        column = (at.end_col_offset or 0) - len(field) if isinstance(at, ast.Attribute) else at.col_offset + 1
        told = meant(guess, N_("It has {names}.", names=names))
        raise FormulaProblem("FORM007", column, len(field), record=record.name, field=field, **told)

    def record_of(self, owner: ast.expr) -> RecordType | None:
        """Return the record type of a name, of a field that is a record (`ball.value.x`), or of a table's row."""
        if isinstance(owner, ast.Name) and key(owner.id) not in self.local:
            found = self.scope.inputs.get(key(owner.id))
            return found.record if found else None
        if isinstance(owner, ast.Attribute) and (outer := self.record_of(owner.value)):
            return getattr(getattr(outer.field(owner.attr), "example", None), "type", None)
        source: ast.expr | None = None
        if isinstance(owner, Pick) and len(owner.members) == 1:
            source = owner.members[0]
        elif isinstance(owner, ast.Call) and isinstance(owner.func, ast.Name) and owner.func.id in _TABLE_ARGUMENT:
            source = owner.args[_TABLE_ARGUMENT[owner.func.id]] if not hasattr(owner, "helper") else None
        table = _table_of(source)
        return table.type if table else None

    # ---- texts with values in them
    def on_formattedvalue(self, node: ast.FormattedValue, depth: int) -> ast.expr:
        if node.conversion != -1:
            remedy = N_("Write the value alone, or with a format such as {distance:.1f}.")
            self.refuse(node, N_("“!” in a text"), remedy)
        if node.format_spec is not None:
            parts = getattr(node.format_spec, "values", [])
            spec = "".join(str(p.value) if isinstance(p, ast.Constant) else "{…}" for p in parts)
            if not _SPEC.fullmatch(spec):
                raise FormulaProblem("FORM010", node.col_offset, _width(node), spec=spec)
        node.value = self.visit_at(node.value, depth)
        return node


def _table_of(node: ast.expr | None) -> Table | None:
    value: object = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, Table) else None


def constant_node(value: object) -> ast.Constant:
    """Return a constant node for a value that is no literal of Python: a table, or a column of one."""
    node = ast.Constant(None)
    node.value = value  # type: ignore[assignment]
    return node


def _call_of_helper(
    node: ast.expr, helper: HelperDef, args: list[ast.expr], width: int, unclear: bool = False
) -> ast.expr:
    """Return the call of a helper; with `unclear`, how many arguments are meant is not known."""
    takes = len(helper.parameters)
    if len(args) != takes and not unclear:
        usage = f"{helper.shown}({'; '.join(p.name for p in helper.parameters)})" if takes else helper.shown
        raise FormulaProblem("FORM006", node.col_offset, width, name=helper.shown, takes=arguments(takes),
                             gets=_given(len(args)), usage=usage)  # fmt: skip
    call = ast.copy_location(ast.Call(ast.Name(helper.shown), args, []), node)
    call.helper = helper  # type: ignore[attr-defined]
    return call


def _width(node: ast.expr) -> int:
    return max((node.end_col_offset or 0) - node.col_offset, 1)


def _given(n: int) -> str:
    return N_("none") if n == 0 else str(n)


_METHODS: dict[type, Callable[[_Resolver, Any, int], ast.expr]] = {
    ast.Constant: _Resolver.on_constant, ast.Name: _Resolver.on_name, ast.BinOp: _Resolver.on_binop,
    ast.UnaryOp: _Resolver.on_unaryop, ast.BoolOp: _Resolver.on_values, Join: _Resolver.on_values,
    ast.Compare: _Resolver.on_compare, ast.IfExp: _Resolver.on_ifexp, ast.List: _Resolver.on_list,
    ast.Tuple: _Resolver.on_list, ast.ListComp: _Resolver.on_listcomp, ast.Subscript: _Resolver.on_subscript,
    ast.Slice: _Resolver.on_slice, ast.Attribute: _Resolver.on_attribute, ast.Call: _Resolver.on_call,
    ast.JoinedStr: _Resolver.on_values, ast.FormattedValue: _Resolver.on_formattedvalue,
}  # fmt: skip
"""The allow-list: nodes of any other kind are refused."""
