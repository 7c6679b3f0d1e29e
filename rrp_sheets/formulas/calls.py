"""Resolution of names and calls: look-up in the scope, binding to nodes, and advice for what is refused."""

from __future__ import annotations

import ast
import re
import unicodedata
from abc import ABC, abstractmethod
from typing import Any, NoReturn

from rrp_sheets.diagnostics.proposals import meant
from rrp_sheets.formulas.functions import Function
from rrp_sheets.formulas.functions.define import arguments
from rrp_sheets.formulas.hints import cell, cell_reference
from rrp_sheets.formulas.parsing import unread
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.scope import HelperDef, Scope
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import N_

_DECIMAL_COMMA = re.compile(r"(?<![\w.])\d+,\d+")
ADVICE = N_("Formulas are built of inputs, numbers, texts, operators and the library's functions.")


class Calls(ABC):
    """The part of the resolver that looks names up in the scope."""

    def __init__(self, scope: Scope, typed: str) -> None:
        self.scope = scope
        self.typed = typed
        self.local: dict[str, str] = {}  # names bound by list comprehensions around, by key
        self.problems: list[FormulaProblem] = []  # after which looking went on

    @abstractmethod
    def visit_at(self, node: ast.expr, depth: int) -> ast.expr:
        """Check and bind a node and what is in it."""

    def refuse(self, node: ast.AST, what: str, remedy: str = ADVICE, **details: object) -> NoReturn:
        """Raise FORM003 at a node."""
        start = getattr(node, "col_offset", 0)
        raise FormulaProblem("FORM003", start, _length(node), what=what, remedy=remedy, **details)

    # ---- names
    def on_name(self, node: ast.Name, depth: int) -> ast.expr:
        """Resolve a name to an input, a helper without inputs, a constant, or a table."""
        name, k, scope = node.id, key(node.id), self.scope
        if k in self.local:
            node.id = self.local[k]
            return node
        if name.startswith("_") or "__" in name:
            raise FormulaProblem(
                "FORM004", node.col_offset, _length(node), name=name, remedy=N_("Names start with a letter.")
            )
        if k in scope.inputs:
            node.id = scope.inputs[k].name
            return node
        helper = scope.helpers.get(k)
        if helper is not None:
            if helper.parameters:
                raise FormulaProblem("FORM006", node.col_offset, _length(node), name=helper.shown, gets=N_("none"),
                                     takes=arguments(len(helper.parameters)), usage=_usage(helper))  # fmt: skip
            return _bind_helper(node, helper, [])
        if k in scope.constants:
            return ast.copy_location(ast.Constant(scope.constants[k]), node)
        table = scope.table(name)
        if table is not None:
            return ast.copy_location(plain(table), node)
        if k == "value" and len(scope.inputs) > 1:
            self.refuse(
                node,
                N_("{name} in a row with several inputs", name=name),
                N_("Write an input's name: {names}.", names=", ".join(self._mine())),
                name=name,
            )
        if scope.functions.get(name) and not self._as_field(k):
            self.refuse(
                node,
                N_("The function {name} without brackets", name=name),
                N_("Write {name}(…) with what it works on.", name=name),
                name=name,
            )
        if cell(name) and not any(cell(other) for other in scope.known()):
            raise cell_reference(node.col_offset, name, self._mine())
        raise FormulaProblem("FORM004", node.col_offset, _length(node), name=name, **self._propose(name))

    def _mine(self) -> list[str]:
        return list(dict.fromkeys(i.name for i in self.scope.inputs.values()))

    def _as_field(self, k: str) -> str | None:
        """Return a field of that name with its input: `distance` alone is often meant for `redBall.distance`."""
        for each in self.scope.inputs.values():
            field = each.record.keys.get(k) if each.record else None
            if each.record and field:
                return f"{each.name}.{next(f.name for f in each.record.fields if key(f.name) == field)}"
        return None

    def _propose(self, name: str) -> dict[str, Any]:
        """Return the details `remedy` and `guess` for a name that is not known."""
        k = key(name)
        guess = self._as_field(k)
        if guess:
            return {"remedy": N_('Did you mean {field}? (A text needs quotes: "{name}".)', field=guess, name=name),
                    "guess": guess}  # fmt: skip
        records = [i.record for i in self.scope.inputs.values() if i.record]
        if any(k == key(c) for r in records for f in r.fields for c in f.choices):
            return {"remedy": N_('Put the text between quotes: "{name}".', name=name)}
        guess = self.scope.propose(name, self.scope.known())
        if guess:
            guess = argument_name(guess)
            return {"remedy": N_('Did you mean {guess}? (A text needs quotes: "{name}".)', guess=guess, name=name),
                    "guess": guess}  # fmt: skip
        return {"remedy": name_here(k) or self._inputs_named(name)}

    def _inputs_named(self, name: str) -> str:
        mine = self._mine()
        if not mine:
            return N_("Put a text between quotes.")
        named = (
            N_("The inputs are called {mine}", mine=", ".join(mine))
            if len(mine) > 1
            else N_("The input is called {value}", value=mine[0])
        )
        return N_('{named} here. (A text needs quotes: "{name}".)', named=named, name=name)

    def new_name(self, target: ast.expr) -> str:
        """Bind a name after “for”, which must not be in use."""
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
        """Resolve a call of a library function or a helper by its name; nothing else can be called."""
        if isinstance(node.func, ast.Attribute):
            self._method(node.func)
        if not isinstance(node.func, ast.Name) or key(node.func.id) in self.local:
            self.refuse(node, N_("A call of something that is not a function"))
        name, k, scope = node.func.id, key(node.func.id), self.scope
        helper = scope.helpers.get(k)
        function = scope.functions.get(name)
        alias = k == "value" and k in scope.inputs and scope.inputs[k].name != "value"
        if k in scope.inputs and not alias and not (helper is None and function is not None and k == "value"):
            self.refuse(
                node,
                N_("The input {name} followed by brackets", name=name),
                N_("An input is a value: write it without ( )."),
            )
        if helper is not None:
            return self._helper(node, helper, depth)
        if k in AMBIGUOUS:
            raise FormulaProblem("FORM019", node.col_offset, len(name), name=name, remedy=AMBIGUOUS[k])
        if function is None:
            raise self._unknown_function(node, name)
        unclear = any(hasattr(arg, "unread") for arg in node.args)  # how many they are meant to be is not known
        args = self._arguments(node, depth)
        if unclear:
            return unread(node)
        if not function.least <= len(args) <= function.most:
            usage = self._with_comma_hint(function.usage, node, len(args) > function.most)
            raise FormulaProblem("FORM006", node.col_offset, len(name), name=function.name, gets=_given(len(args)),
                                 takes=function.takes, usage=usage)  # fmt: skip
        if function.make is None:
            return _bind_function(node, function, args)
        if any(hasattr(arg, "unread") for arg in args):
            return unread(node)
        try:  # IF, AND, …: syntax rather than calls, their arguments are evaluated lazily
            return ast.copy_location(function.make(args), node)
        except FormulaProblem as problem:
            problem.column, problem.length = node.col_offset, len(name)
            raise

    def _arguments(self, node: ast.Call, depth: int) -> list[ast.expr]:
        for arg in node.args:
            if getattr(arg, "sheet", False) and isinstance(arg, ast.Compare) and isinstance(arg.left, ast.Name):
                left = arg.left.id
                if not self._is_known(left):
                    what = N_("{left}= inside the brackets", left=left)
                    remedy = N_("Write the value alone. ({left} is no input here.)", left=left)
                    problem = FormulaProblem("FORM003", arg.col_offset, _length(arg), what=what, remedy=remedy)
                    self.problems.append(problem)
                    unread(arg)
        return [self.visit_at(a, depth) for a in node.args]

    def _is_known(self, name: str) -> bool:
        k, scope = key(name), self.scope
        return any(k in known for known in (self.local, scope.inputs, scope.helpers, scope.constants, scope.tables))

    def _with_comma_hint(self, usage: str, node: ast.Call, too_many: bool) -> str:
        found = _DECIMAL_COMMA.search(self.typed[node.col_offset : node.end_col_offset])
        if not found or not too_many:
            return usage
        value = found[0].replace(",", ".")
        return N_("{usage} — decimal numbers with a point: {value}", usage=usage, value=value)

    def _helper(self, node: ast.Call, helper: HelperDef, depth: int) -> ast.expr:
        unclear = any(hasattr(arg, "unread") for arg in node.args)
        args = self._arguments(node, depth)
        if len(args) != len(helper.parameters) and not unclear:
            takes, usage = arguments(len(helper.parameters)), _usage(helper)
            raise FormulaProblem("FORM006", node.col_offset, _length(node.func), name=helper.shown, takes=takes,
                                 gets=_given(len(args)), usage=usage)  # fmt: skip
        return _bind_helper(node, helper, args)

    def _method(self, method: ast.Attribute) -> NoReturn:
        function = self.scope.functions.get(method.attr)
        advice = (
            N_("Write {name}(…) instead.", name=function.name)
            if function
            else function_here(key(method.attr)) or ADVICE
        )
        self.refuse(method, N_("“.{name}( )”", name=method.attr), advice)

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


def plain(value: object) -> ast.Constant:
    """Return a constant node for a value that is no literal of Python: a table, or a column of one."""
    node = ast.Constant(None)
    node.value = value  # type: ignore[assignment]
    return node


def _bind_function(node: ast.expr, function: Function, args: list[ast.expr]) -> ast.expr:
    call = ast.copy_location(ast.Call(ast.Name(function.name), args, []), node)
    call.bound = function.call  # type: ignore[attr-defined]
    call.charges = function.charges  # type: ignore[attr-defined]
    return call


def _bind_helper(node: ast.expr, helper: HelperDef, args: list[ast.expr]) -> ast.expr:
    call = ast.copy_location(ast.Call(ast.Name(helper.shown), args, []), node)
    call.helper = helper  # type: ignore[attr-defined]
    return call


def _length(node: ast.AST) -> int:
    start = getattr(node, "col_offset", 0)
    return max((getattr(node, "end_col_offset", None) or start + 1) - start, 1)


def _given(n: int) -> str:
    return N_("none") if n == 0 else str(n)


def _usage(helper: HelperDef) -> str:
    return f"{helper.shown}({'; '.join(p.name for p in helper.parameters)})" if helper.parameters else helper.shown


_RESERVED = frozenset((
    "print", "open", "eval", "exec", "dir", "id", "type", "object", "input", "vars", "globals", "locals", "getattr",
    "setattr", "hasattr", "compile", "exit", "quit", "repr", "self", "true", "false", "none", "blank", "null",
))  # fmt: skip


AMBIGUOUS = {  # where spreadsheets and Python disagree: never guess
    "log": N_("Write LN(…) for the natural logarithm, or LOG10(…)."),
    "atan2": N_("Write ANGLE(x; y): the direction of a point, x ahead and y to the left."),
}
"""By key: names that mean different things, with the remedy."""

_INSTEAD = {
    "vlookup": "XLOOKUP(what; Table[Column]; Table)", "hlookup": "XLOOKUP(what; Table[Column]; Table)",
    "lookup": "XLOOKUP(what; Table[Column]; Table)", "ifna": "IFERROR(value; otherwise)",
    "rand": "PICK([1; 2; 3])", "randbetween": "PICK([1; 2; 3])", "random": "PICK([1; 2; 3])", "choice": "PICK(list)",
    "randint": "PICK([1; 2; 3])", "choose": "INDEX([first; second]; place)", "filter": "[x for x in list if x > 0]",
    "map": "[x * 2 for x in list]", "print": N_("the text alone"), "format": 'f"{distance:.1f}"',
    "isnull": "ISBLANK(value)", "isempty": "ISBLANK(value)", "isnone": "ISBLANK(value)", "isna": "ISERROR(value)",
    "float": "VALUE(text)", "tonumber": "VALUE(text)", "tostring": "STR(number)", "length": "LEN(text)",
    "replace": "SUBSTITUTE(text; old; new)", "split": "TEXTSPLIT(text; between)", "contains": '"ball" in text',
    "indexof": "FIND(what; text)", "strip": "TRIM(text)", "capitalize": "PROPER(text)", "factorial": "PRODUCT(1; 2; 3)",
    "square": "x^2", "sqr": N_("SQRT(x) for the root, or x^2"), "cbrt": "x^(1/3)", "norm": "HYPOT(x; y)",
    "dist": "DISTANCE(x1; y1; x2; y2)", "limit": "CLAMP(value; low; high)", "clip": "CLAMP(value; low; high)",
    "bool": "value <> 0", "columns": N_("the number of columns"), "indirect": N_("the stream's name"),
    "offset": "INDEX(table; n)",
}  # fmt: skip
_GERMAN_FRENCH = {
    "wenn": "IF", "und": "AND", "oder": "OR", "nicht": "NOT", "summe": "SUM", "mittelwert": "AVERAGE",
    "runden": "ROUND", "ganzzahl": "INT", "rest": "MOD", "wurzel": "SQRT", "länge": "LEN", "links": "LEFT",
    "rechts": "RIGHT", "teil": "MID",
    "wennfehler": "IFERROR", "istleer": "ISBLANK", "verketten": "CONCAT", "anzahl": "COUNT", "zeilen": "ROWS",
    "xverweis": "XLOOKUP", "sverweis": "XLOOKUP", "vergleich": "MATCH", "gross": "UPPER", "klein": "LOWER",
    "glätten": "TRIM", "wechseln": "SUBSTITUTE", "bogenmass": "RADIANS", "grad": "DEGREES", "potenz": "POWER",
    "si": "IF", "et": "AND", "ou": "OR", "non": "NOT", "somme": "SUM", "moyenne": "AVERAGE", "arrondi": "ROUND",
    "ent": "INT", "racine": "SQRT", "nbcar": "LEN", "gauche": "LEFT", "droite": "RIGHT", "stxt": "MID",
    "sierreur": "IFERROR", "estvide": "ISBLANK", "concatener": "CONCAT", "nb": "COUNT", "lignes": "ROWS",
    "recherchex": "XLOOKUP", "recherchev": "XLOOKUP", "equiv": "MATCH", "majuscule": "UPPER", "minuscule": "LOWER",
    "wahr": "TRUE", "falsch": "FALSE", "vrai": "TRUE", "faux": "FALSE",
    "supprespace": "TRIM", "substitue": "SUBSTITUTE", "puissance": "POWER",
}  # fmt: skip
_CLOCK = frozenset(("now", "today", "time", "timevalue", "date", "hour", "minute", "second", "clock"))
_REFUSED = {
    "repr": N_("Write STR(…) for a number as a text."),
    "eval": N_("A formula cannot hold another one as a text: write it into a helper."),
    "zip": N_("Use a table, or INDEX with a place."),
}
_NAMES = {
    "null": "BLANK", "nil": "BLANK", "undefined": "BLANK", "empty": "BLANK", "nothing": "BLANK", "wahr": "TRUE",
    "falsch": "FALSE", "vrai": "TRUE", "faux": "FALSE", "yes": "TRUE", "on": "TRUE", "off": "FALSE", "π": "pi",
}  # fmt: skip


def function_here(name: str) -> str | None:
    """Return what to write instead of calling a function that is not here, or None when nothing is known.

    >>> function_here("wenn"), function_here("vlookup")
    ('Write IF: functions have their English names.', 'Write XLOOKUP(what; Table[Column]; Table).')
    """
    if name in _GERMAN_FRENCH:
        return N_("Write {value}: functions have their English names.", value=_GERMAN_FRENCH[name])
    if name in _INSTEAD:
        return N_("Write {usage}.", usage=_INSTEAD[name])
    if name in _CLOCK:
        return N_("Use the connector timestamp: it gives the time with every event.")
    return _REFUSED.get(name)


def name_here(name: str) -> str | None:
    """Return what to write instead of a name that means something elsewhere, or None when nothing is known.

    >>> name_here("null")
    'Write BLANK.'
    """
    return N_("Write {value}.", value=_NAMES[name]) if name in _NAMES else None
