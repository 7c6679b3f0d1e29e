"""A compiled formula, its compilation from text, and the parser's rules for operators, conditions and lists."""

from __future__ import annotations

import ast
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from rrp_sheets.formulas import hints
from rrp_sheets.formulas.hints import refuse_setting
from rrp_sheets.formulas.limits import LONGEST_FORMULA
from rrp_sheets.formulas.nodes import Join
from rrp_sheets.formulas.parsing import CONSTANTS, Values
from rrp_sheets.formulas.problems import FormulaProblem, together
from rrp_sheets.formulas.scope import Scope
from rrp_sheets.formulas.tokens import Token, tokenize
from rrp_sheets.formulas.tree import resolve
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import Value
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.formulas.evaluator import GuardedInterpreter
    from rrp_sheets.formulas.pick import Picker


@dataclass(frozen=True)
class Formula:
    """A checked formula, ready to be prepared for an interpreter.

    Attributes:
        text: as typed.
        tree: resolved; its columns are places in the text.
        names: of what the evaluator is given, in order: what the connector adds, then the inputs.
    """

    text: str
    tree: ast.expr
    names: tuple[str, ...]

    @property
    def used(self) -> frozenset[str]:
        """The `names` that occur in the tree."""
        return frozenset(n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name)).intersection(self.names)

    def prepare(self, interpreter: GuardedInterpreter, picker: Picker | None = None) -> Callable[..., Value]:
        """Return a callable from the inputs' values to the value or a Failure, for this interpreter and its thread.

        Args:
            interpreter: one per thread.
            picker: what PICK draws with; without one it takes the first, as `check` does.
        """
        return interpreter.prepare(self.tree, self.names, picker)


def compile_formula(text: str, scope: Scope, *, condition: bool = True) -> Formula:
    """Parse and check a formula, in a spreadsheet's spelling or in Python's.

    Args:
        text: as typed.
        scope: the names in it.
        condition: whether a yes or no is wanted; where it is not, `x = 1` is refused: it compares in a spreadsheet and
            sets in Python.

    Raises:
        FormulaProblem: when it is refused; its column and length are in the text as typed.

    >>> from rrp_sheets.formulas import make_scope
    >>> from rrp_sheets.formulas.evaluator import GuardedInterpreter
    >>> scope = make_scope([("Distance", None)])
    >>> formula = compile_formula("=IF(distance < 1; distance * 2; 0)", scope)
    >>> formula.prepare(GuardedInterpreter())(0.25)
    0.5
    >>> compile_formula("distance * 2 if distance < 1 else 0", scope).prepare(GuardedInterpreter())(0.25)
    0.5
    """
    _check_characters(text)
    try:
        tree, problems = parse_all(tokenize(text, lambda name: scope.table(name) is not None), text)
        if not condition and not problems:
            refuse_setting(tree, text)
        return Formula(text, resolve(tree, scope, text, problems), scope.order)
    except FormulaProblem as problem:
        for one in problem.every:
            _propose_name(one, text, scope)
        raise
    except RecursionError:  # whoever calls from deep within another program has less room for brackets
        raise FormulaProblem("FORM002", 0, reason=N_("it is nested too deeply")) from None


def read_formula(text: str) -> ast.expr:
    """Return the tree of a formula as it is typed, with names and calls unresolved; raises FormulaProblem.

    >>> ast.unparse(read_formula("=IF(a <> 1; x^2; 50%)"))
    'IF(a != 1, x ** 2, 0.5)'
    """
    _check_characters(text)
    try:
        return parse(tokenize(text), text)
    except RecursionError:
        raise FormulaProblem("FORM002", 0, reason=N_("it is nested too deeply")) from None


def _check_characters(text: str) -> None:
    size = len(text.strip())
    if size > LONGEST_FORMULA:
        raise FormulaProblem(
            "FORM002", LONGEST_FORMULA, reason=N_("it has more than {most} characters", most=LONGEST_FORMULA)
        )
    if text.isprintable():
        return
    for i, c in enumerate(text):
        if unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\r\t":
            raise FormulaProblem("FORM001", i, reason=N_("there is a character in it that cannot be seen"),
                                 remedy=N_("Type the formula again."))  # fmt: skip


def _propose_name(problem: FormulaProblem, text: str, scope: Scope) -> None:
    """Set the remedy where a stream's or table's name is spelt as in the sheet, with a space for instance."""
    names = list(dict.fromkeys(i.name for i in scope.inputs.values()))
    if problem.code == "FORM018" and names and "example" in problem.details:
        problem.advise(N_("Write the name of the row's input instead: {names}.", names=hints.any_of(names[:3])))
    if problem.code not in ("FORM001", "FORM003"):
        return
    lower = text.casefold()
    at = text[problem.column : problem.column + problem.length].casefold() if problem.column >= 0 else ""
    for shown in [*(i.shown for i in scope.inputs.values()), *(t.name for t in scope.tables.values())]:
        if at and shown.casefold() == at and key(argument_name(shown)) != key(shown):  # a word of Python's: class
            problem.advise(N_("Write {name} for “{shown}”.", name=argument_name(shown), shown=shown))
            return
        if problem.code == "FORM003":
            continue
        if shown and shown.casefold() in lower and key(shown) != shown.casefold():
            problem.advise(N_("Write {name} for “{shown}”.", name=argument_name(shown), shown=shown))
            return
        if shown[:1].isdigit() and key(shown) in key(text):
            problem.advise(N_("Write {name} for “{shown}”.", name=argument_name(shown), shown=shown))
            return


_COMPARE: dict[str, type[ast.cmpop]] = {
    "=": ast.Eq, "==": ast.Eq, "<>": ast.NotEq, "!=": ast.NotEq, "≠": ast.NotEq, "<": ast.Lt, "<=": ast.LtE,
    "≤": ast.LtE, ">": ast.Gt, ">=": ast.GtE, "≥": ast.GtE, "in": ast.In, "is": ast.Is, "not": ast.NotIn,
}  # fmt: skip
_SHEET_EQUALS = ("=", "<>")
_TERM: dict[str, type[ast.operator]] = {"*": ast.Mult, "/": ast.Div, "//": ast.FloorDiv, "%": ast.Mod}


def parse(tokens: list[Token], typed: str) -> ast.expr:
    """Return the expression's tree; raises FormulaProblem FORM001, FORM002, FORM003 or FORM018."""
    tree, problems = parse_all(tokens, typed)
    if problems:
        raise together(problems)
    return tree


def parse_all(tokens: list[Token], typed: str) -> tuple[ast.expr, list[FormulaProblem]]:
    """Return the expression's tree, and the problems that did not stop the parser; raises FormulaProblem at any other.

    What could not be read within brackets is an `unread` node in the tree.
    """
    parser = _Parser(tokens, typed)
    try:
        return parser.whole(), parser.problems
    except FormulaProblem as problem:
        raise together([*parser.problems, problem]) from None


class _Parser(Values):
    # ---- rules, loosest first
    def whole(self) -> ast.expr:
        node = self.expression()
        if self.now.kind != "end":
            self.leftover(node)
        return node

    def leftover(self, node: ast.expr) -> NoReturn:
        if self.now.text in (",", ";") and self.now.kind == "sign":
            hints.bare_separator(self.tokens, self.i)
        hints.leftover(self.tokens, self.i)

    def expression(self) -> ast.expr:
        return self.deeper(self._conditional)

    def _conditional(self) -> ast.expr:
        body = self.condition()
        if self.word != "if":
            return body
        start = self.step()
        test = self.condition()
        if self.word != "else":
            self.fail(N_("an if without else"), N_('Write: IF(distance < 1; "near"; "far").'), start)
        self.step()
        return self.between(ast.IfExp(test, body, orelse := self.expression()), body, orelse)

    def condition(self) -> ast.expr:
        return self._logic("or", ast.Or, lambda: self._logic("and", ast.And, self._not))

    def _logic(self, word: str, op: type[ast.boolop], rule: Callable[[], ast.expr]) -> ast.expr:
        first = rule()
        if self.word != word:
            return first
        values = [first]
        while self.word == word:
            self.step()
            values.append(rule())
        return self.between(ast.BoolOp(op(), values), first, values[-1])

    def _not(self) -> ast.expr:
        if self.word != "not":
            return self._comparison()
        start = self.step()
        bracket = self.word == "("
        operand = self.deeper(self._not)
        end = operand.end_col_offset or 0
        if bracket and not getattr(operand, "bracketed", False):
            self.note(N_("“not” before a bracket and more"), N_("Write not (a = b), or (not a) = b."), start.start, end)
        return self.at(ast.UnaryOp(ast.Not(), operand), start.start, end)

    def _comparison(self) -> ast.expr:
        left = self._join()
        if self.word not in _COMPARE:
            return left
        ops: list[ast.cmpop] = []
        others: list[ast.expr] = []
        sheet = False
        while self.word in _COMPARE:
            sign = self.step()
            kind = _COMPARE[sign.text]
            if sign.text == "not":
                if self.word != "in":
                    self.fail(N_("there is a “not” that does not belong there"), N_("Write and not, or <>."), sign)
                self.step()
            elif sign.text == "is" and self.word == "not":
                self.step()
                kind = ast.IsNot
            elif self.word in ("=", "=="):
                self.fail(N_("two signs = stand apart"), N_("Write x = 3 or x == 3."), sign)
            sheet = sheet or sign.text in _SHEET_EQUALS
            ops.append(kind())
            others.append(self._join())
        node = self.between(ast.Compare(left, ops, others), left, others[-1])
        if sheet and len(ops) > 1:
            self.note(N_("A chain of comparisons with = or <>"), N_("Write AND(a = b; b = c), or (a = b) = c."),
                        node.col_offset, node.end_col_offset or 0)  # fmt: skip
        if sheet and hints.truth_beside_number(left, others[0]):
            remedy = N_("Compare it with TRUE or FALSE, or take it as it is.")
            self.note(N_("TRUE or FALSE compared with a number"), remedy, node.col_offset, node.end_col_offset or 0)
        node.sheet = sheet  # type: ignore[attr-defined]
        return node

    def _join(self) -> ast.expr:
        first = self._sum()
        if self.word != "&":
            return first
        join = Join()
        join.values = [first]
        while self.word == "&":
            self.step()
            join.values.append(self._sum())
        return self.between(join, first, join.values[-1])

    def _sum(self) -> ast.expr:
        left = self._term()
        while self.word in ("+", "-"):
            op = ast.Add() if self.step().text == "+" else ast.Sub()
            left = self.between(ast.BinOp(left, op, right := self._term()), left, right)
        return left

    def _term(self) -> ast.expr:
        left = self._signed()
        while self.word in _TERM:
            op = _TERM[self.step().text]()
            left = self.between(ast.BinOp(left, op, right := self._signed()), left, right)
        return left

    def _signed(self) -> ast.expr:
        if self.word not in ("-", "+"):
            return self._power()
        sign = self.step()
        operand = self.deeper(self._signed)
        end = operand.end_col_offset or 0
        if sign.text == "-" and _is_power(operand):
            self.note(N_("A minus before a power without brackets"), N_("Write -(x^2) or (-x)^2."), sign.start, end)
        return self.at(ast.UnaryOp(ast.USub() if sign.text == "-" else ast.UAdd(), operand), sign.start, end)

    def _power(self) -> ast.expr:
        base = self.postfix()
        if self.word not in ("^", "**"):
            return base
        self.step()
        exponent = self.deeper(self._signed)
        if _is_power(exponent):
            self.note(N_("A power of a power without brackets"), N_("Write (2^3)^2 or 2^(3^2)."),
                        base.col_offset, exponent.end_col_offset or 0)  # fmt: skip
        return self.between(ast.BinOp(base, ast.Pow(), exponent), base, exponent)

    # ---- lists
    def list_(self) -> ast.expr:
        start = self.step()
        members = self.members("]", start) if self.word != "]" else []
        if self.word == "for":
            self.brackets += 1
            loops = self._loops(start)
            self.brackets -= 1
            return self.at(ast.ListComp(members[0], loops), start.start, self.step().end)
        return self.at(ast.List(members, ast.Load()), start.start, self.step().end)

    def _loops(self, start: Token) -> list[ast.comprehension]:
        loops: list[ast.comprehension] = []
        while self.word == "for":
            self.step()
            targets = [self._target()]
            while self.word == ",":
                self.step()
                targets.append(self._target())
            if self.word != "in":
                self.fail(N_("“in” is missing behind “for”"), N_("Write for example [n * 2 for n in numbers]."))
            self.step()
            target = targets[0] if len(targets) == 1 else self.between(
                ast.Tuple(list(targets), ast.Store()), targets[0], targets[-1])  # fmt: skip
            loop = ast.comprehension(target, self.condition(), [], 0)
            while self.word == "if":
                self.step()
                loop.ifs.append(self.condition())
            loops.append(loop)
        if self.word != "]":
            self.unclosed(start, "]")
        return loops

    def _target(self) -> ast.expr:
        bracket = self.word == "("
        if bracket:
            remedy = N_("Write for a, b in … without brackets.")
            self.refuse(N_("A bracket after “for”"), remedy, self.now.start, self.now.end)
        if self.now.kind != "name" or self.word or self.now.text.casefold() in CONSTANTS:
            self.refuse(N_("This after “for”"), N_("Write a new name after “for”."), self.now.start, self.now.end)
        token = self.step()
        if self.word in ("[", ".", "("):
            self.refuse(N_("This after “for”"), N_("Write a new name after “for”."), token.start, self.now.end)
        return self.at(ast.Name(token.text, ast.Store()), token.start, token.end)

    def read_inner(self, tokens: list[Token]) -> ast.expr:
        inner = _Parser(tokens, self.typed, self.depth)
        inner.brackets = self.brackets
        inner.problems = self.problems
        return inner.whole()


def _is_power(node: ast.expr) -> bool:
    """Return whether a node is a power without brackets around it."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not getattr(node, "bracketed", False)
