"""From tokens to a tree of Python's nodes, for both spellings; the columns are places in the typed text.

What the two worlds would read differently is refused here: `-x^2`, `2^3^2`, `a = b = c`, `not (a) = b`, a comma without
brackets. What is only another spelling becomes the same node: `=` and `==`, `^` and `**`, `;` and `,`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import NoReturn

from rrp_sheets.formulas import hints
from rrp_sheets.formulas.nodes import Join
from rrp_sheets.formulas.parsing import CONSTANTS, Values
from rrp_sheets.formulas.problems import FormulaProblem, together
from rrp_sheets.formulas.tokens import Token

_COMPARE: dict[str, type[ast.cmpop]] = {
    "=": ast.Eq, "==": ast.Eq, "<>": ast.NotEq, "!=": ast.NotEq, "≠": ast.NotEq, "<": ast.Lt, "<=": ast.LtE,
    "≤": ast.LtE, ">": ast.Gt, ">=": ast.GtE, "≥": ast.GtE, "in": ast.In, "is": ast.Is, "not": ast.NotIn,
}  # fmt: skip
_SHEET_EQUALS = ("=", "<>")
_TERM: dict[str, type[ast.operator]] = {"*": ast.Mult, "/": ast.Div, "//": ast.FloorDiv, "%": ast.Mod}


def parse(tokens: list[Token], typed: str) -> ast.expr:
    """The expression's tree; raises FormulaProblem FORM001, FORM002, FORM003 or FORM018."""
    tree, problems = parse_all(tokens, typed)
    if problems:
        raise together(problems)
    return tree


def parse_all(tokens: list[Token], typed: str) -> tuple[ast.expr, list[FormulaProblem]]:
    """The expression's tree and the problems after which reading could go on; raises FormulaProblem at any other.

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
        hints.leftover(self.tokens, self.i, self.typed)

    def expression(self) -> ast.expr:
        return self.deeper(self._conditional)

    def _conditional(self) -> ast.expr:
        body = self.condition()
        if self.word != "if":
            return body
        start = self.step()
        test = self.condition()
        if self.word != "else":
            self.fail("an if without else", 'Write: IF(distance < 1; "near"; "far").', start)
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
            self.note("“not” before a bracket and more", "Write not (a = b), or (not a) = b.", start.start, end)
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
                    self.fail("there is a “not” that does not belong there", "Write and not, or <>.", sign)
                self.step()
            elif sign.text == "is" and self.word == "not":
                self.step()
                kind = ast.IsNot
            elif self.word in ("=", "=="):
                self.fail("two signs = stand apart", "Write x = 3 or x == 3.", sign)
            sheet = sheet or sign.text in _SHEET_EQUALS
            ops.append(kind())
            others.append(self._join())
        node = self.between(ast.Compare(left, ops, others), left, others[-1])
        if sheet and len(ops) > 1:
            self.note("A chain of comparisons with = or <>", "Write AND(a = b; b = c), or (a = b) = c.",
                        node.col_offset, node.end_col_offset or 0)  # fmt: skip
        if sheet and hints.truth_beside_number(left, others[0]):
            self.note("TRUE or FALSE compared with a number", "Compare it with TRUE or FALSE, or take it as it is.",
                        node.col_offset, node.end_col_offset or 0)  # fmt: skip
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
            self.note("A minus before a power without brackets", "Write -(x^2) or (-x)^2.", sign.start, end)
        return self.at(ast.UnaryOp(ast.USub() if sign.text == "-" else ast.UAdd(), operand), sign.start, end)

    def _power(self) -> ast.expr:
        base = self.postfix()
        if self.word not in ("^", "**"):
            return base
        self.step()
        exponent = self.deeper(self._signed)
        if _is_power(exponent):
            self.note("A power of a power without brackets", "Write (2^3)^2 or 2^(3^2).",
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
                self.fail("“in” is missing behind “for”", "Write for example [n * 2 for n in numbers].")
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
            self.refuse("A bracket after “for”", "Write for a, b in … without brackets.", self.now.start, self.now.end)
        if self.now.kind != "name" or self.word or self.now.text.casefold() in CONSTANTS:
            self.refuse("This after “for”", "Write a new name after “for”.", self.now.start, self.now.end)
        token = self.step()
        if self.word in ("[", ".", "("):
            self.refuse("This after “for”", "Write a new name after “for”.", token.start, self.now.end)
        return self.at(ast.Name(token.text, ast.Store()), token.start, token.end)

    def read_inner(self, tokens: list[Token]) -> ast.expr:
        inner = _Parser(tokens, self.typed, self.depth)
        inner.brackets = self.brackets
        inner.problems = self.problems
        return inner.whole()


def _is_power(node: ast.expr) -> bool:
    """Whether a node is a power that no bracket stands around."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not getattr(node, "bracketed", False)
