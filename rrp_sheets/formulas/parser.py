"""From tokens to a tree of Python's nodes, for both spellings; the columns are places in the typed text.

What the two worlds would read differently is refused here: `-x^2`, `2^3^2`, `a = b = c`, `not (a) = b`, a comma without
brackets. What is only another spelling becomes the same node: `=` and `==`, `^` and `**`, `;` and `,`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from typing import NoReturn, TypeVar

from rrp_sheets.formulas import hints
from rrp_sheets.formulas.limits import DEEPEST
from rrp_sheets.formulas.nodes import Join
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.tokens import Hole, Token

Node = TypeVar("Node", bound=ast.AST)
_COMPARE: dict[str, type[ast.cmpop]] = {
    "=": ast.Eq, "==": ast.Eq, "<>": ast.NotEq, "!=": ast.NotEq, "≠": ast.NotEq, "<": ast.Lt, "<=": ast.LtE,
    "≤": ast.LtE, ">": ast.Gt, ">=": ast.GtE, "≥": ast.GtE, "in": ast.In, "is": ast.Is, "not": ast.NotIn,
}  # fmt: skip
_SHEET_EQUALS = ("=", "<>")
_TERM: dict[str, type[ast.operator]] = {"*": ast.Mult, "/": ast.Div, "//": ast.FloorDiv, "%": ast.Mod}
_CONSTANTS = {"true": True, "false": False, "none": None, "blank": None}
_WORDS = frozenset(("if", "else", "and", "or", "not", "in", "is", "for"))
_AS_FUNCTION = frozenset(("if", "and", "or", "not"))
_STARTS = frozenset("([{-+$.") | {"**", "++", "--"}
_TREE_DEPTH = 2 * DEEPEST  # of nested rules; brackets count on their own


def parse(tokens: list[Token], typed: str) -> ast.expr:
    """The expression's tree; raises FormulaProblem FORM001, FORM002, FORM003 or FORM018."""
    return _Parser(tokens, typed).whole()


class _Parser:
    def __init__(self, tokens: list[Token], typed: str, depth: int = 0) -> None:
        self.tokens = tokens
        self.typed = typed
        self.i = 0
        self.now = tokens[0]
        self.word = self._word()
        self.depth = depth
        self.brackets = 0

    # ---- moving on
    def _word(self) -> str:
        """The token as an operator: a sign, or one of Python's words in small letters; else nothing."""
        kind, text = self.now.kind, self.now.text
        return text if kind == "sign" or (kind == "name" and text in _WORDS) else ""

    def step(self) -> Token:
        token = self.now
        self.i += 1
        self.now = self.tokens[self.i]
        kind, text = self.now.kind, self.now.text
        self.word = text if kind == "sign" or (kind == "name" and text in _WORDS) else ""
        return token

    @property
    def next(self) -> Token:
        return self.tokens[min(self.i + 1, len(self.tokens) - 1)]

    def fail(self, reason: str, remedy: str, at: Token | None = None) -> NoReturn:
        at = at or self.now
        raise FormulaProblem("FORM001", at.start, max(at.end - at.start, 1), reason=reason, remedy=remedy)

    def refuse(self, what: str, remedy: str, start: int, end: int) -> NoReturn:
        raise FormulaProblem("FORM003", start, max(end - start, 1), what=what, remedy=remedy)

    def at(self, node: Node, start: int, end: int) -> Node:
        node.lineno = node.end_lineno = 1  # type: ignore[attr-defined]
        node.col_offset, node.end_col_offset = start, end  # type: ignore[attr-defined]
        return node

    def between(self, node: Node, first: ast.expr, last: ast.expr) -> Node:
        return self.at(node, first.col_offset, last.end_col_offset or 0)

    def deeper(self, rule: Callable[[], ast.expr]) -> ast.expr:
        self.depth += 1
        if self.depth > _TREE_DEPTH:
            raise FormulaProblem("FORM002", self.now.start, reason="it is nested too deeply")
        node = rule()
        self.depth -= 1
        return node

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
        body = self._or()
        if self.word != "if":
            return body
        start = self.step()
        test = self._or()
        if self.word != "else":
            self.fail("an if without else", 'Write: IF(distance < 1; "near"; "far").', start)
        self.step()
        return self.between(ast.IfExp(test, body, orelse := self.expression()), body, orelse)

    def _or(self) -> ast.expr:
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
            self.refuse("“not” before a bracket and more", "Write not (a = b), or (not a) = b.", start.start, end)
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
            self.refuse("A chain of comparisons with = or <>", "Write AND(a = b; b = c), or (a = b) = c.",
                        node.col_offset, node.end_col_offset or 0)  # fmt: skip
        if sheet and hints.truth_beside_number(left, others[0]):
            self.refuse("TRUE or FALSE compared with a number", "Compare it with TRUE or FALSE, or take it as it is.",
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
            self.refuse("A minus before a power without brackets", "Write -(x^2) or (-x)^2.", sign.start, end)
        return self.at(ast.UnaryOp(ast.USub() if sign.text == "-" else ast.UAdd(), operand), sign.start, end)

    def _power(self) -> ast.expr:
        base = self._postfix()
        if self.word not in ("^", "**"):
            return base
        self.step()
        exponent = self.deeper(self._signed)
        if _is_power(exponent):
            self.refuse("A power of a power without brackets", "Write (2^3)^2 or 2^(3^2).",
                        base.col_offset, exponent.end_col_offset or 0)  # fmt: skip
        return self.between(ast.BinOp(base, ast.Pow(), exponent), base, exponent)

    # ---- what stands behind a value
    def _postfix(self) -> ast.expr:
        node = self._value()
        while True:
            word = self.word
            if word == ".":
                self.step()
                if self.now.kind != "name":
                    self.fail("a field's name is missing behind a point", "Write for example redBall.distance.")
                name = self.step()
                node = self.at(ast.Attribute(node, name.text, ast.Load()), node.col_offset, name.end)
            elif word == "[":
                node = self._subscript(node)
            elif word == "(":
                start = self.step()
                args = self._members(")", start, call=True)
                node = self.at(ast.Call(node, args, []), node.col_offset, self.step().end)
            elif word == "%" and self._is_percent(node):
                end = self.step().end
                node = self._scaled(node, end, lambda n: n / 100, 100)
            elif word == "°":
                end = self.step().end
                if not _is_number(node):
                    self.refuse(
                        "The sign ° behind something that is no number", "Write RADIANS(…).", node.col_offset, end
                    )
                node = self._scaled(node, end, math.radians, 1)
            else:
                return node

    def _is_percent(self, node: ast.expr) -> bool:
        """Whether % is the sign behind a number (50%), and not the remainder's (x % 2)."""
        following = self.next
        if following.kind not in ("sign", "end") and following.text not in _WORDS:
            return False
        if following.text in ("-", "+"):
            self.refuse("“%” before a sign", "Write (50%) - x for half minus x, or MOD(50; -x) for the remainder.",
                        self.now.start, following.end)  # fmt: skip
        if following.text == "not":
            return False
        return following.text not in _STARTS

    def _scaled(self, node: ast.expr, end: int, scale: Callable[[float], float], divisor: int) -> ast.expr:
        if isinstance(node, ast.Constant) and _is_number(node):
            return self.at(ast.Constant(scale(node.value)), node.col_offset, end)  # type: ignore[arg-type]
        hundred = self.at(ast.Constant(divisor), node.col_offset, end)
        return self.at(ast.BinOp(node, ast.Div(), hundred), node.col_offset, end)

    def _subscript(self, owner: ast.expr) -> ast.expr:
        start = self.step()
        self._open(start)
        parts: list[ast.expr | None] = [None]
        colons = 0
        while self.word != "]":
            if self.word == ":":
                self.step()
                colons += 1
                parts.append(None)
            elif parts[-1] is None and self.now.kind != "end":
                parts[-1] = self.expression()
            else:
                self._unclosed(start, "]")
        if colons == 0 and parts[0] is None:
            self.fail("there is nothing between [ and ]", "Write a field's name or a place: balls[0].")
        if colons > 2:
            self.fail("there are too many : in brackets", "Write [first:end].")
        index: ast.expr
        if colons == 0:
            assert parts[0] is not None
            index = parts[0]
        else:
            index = self.at(ast.Slice(*parts), start.start, self.now.end)
        self.brackets -= 1
        return self.at(ast.Subscript(owner, index, ast.Load()), owner.col_offset, self.step().end)

    # ---- values
    def _value(self) -> ast.expr:
        kind = self.now.kind
        if kind == "number":
            token = self.step()
            return self.at(ast.Constant(hints.number(token)), token.start, token.end)
        if kind == "text":
            token = self.step()
            return self.at(ast.Constant(token.text), token.start, token.end)
        if kind == "name":
            return self._name()
        if kind == "texts":
            return self._text_with_values(self.step())
        if kind == "column":
            token = self.step()
            owner = self.at(ast.Name(str(token.parts[0]), ast.Load()), token.start, token.start)
            column = self.at(ast.Constant(token.text), token.start + len(owner.id) + 1, token.end - 1)
            return self.at(ast.Subscript(owner, column, ast.Load()), token.start, token.end)
        if self.word == "(":
            return self._bracketed()
        if self.word == "[":
            return self._list()
        hints.no_value(self.tokens, self.i)

    def _name(self) -> ast.expr:
        token, lower = self.now, self.now.text.casefold()
        called = self.next.text == "(" and self.next.kind == "sign"
        if lower in _CONSTANTS:
            self.step()
            if called:  # spreadsheets write TRUE() as well
                start = self.step()
                if self.word != ")":
                    self.fail(
                        f"there is something between the brackets of {token.text}", f"Write {token.text} alone.", start
                    )
                token = token._replace(end=self.step().end)
            return self.at(ast.Constant(_CONSTANTS[lower]), token.start, token.end)
        if (lower in _AS_FUNCTION and not called) or lower in hints.KEYWORDS:
            hints.keyword(self.tokens, self.i)
        self.step()
        return self.at(ast.Name(token.text, ast.Load()), token.start, token.end)

    def _bracketed(self) -> ast.expr:
        start = self.step()
        if self.word == ")":
            return self.at(ast.Tuple([], ast.Load()), start.start, self.step().end)
        members = self._members(")", start)
        trailing = self.tokens[self.i - 1].text == "," and self.tokens[self.i - 1].kind == "sign"
        end = self.step().end
        node = members[0] if len(members) == 1 and not trailing else ast.Tuple(members, ast.Load())
        node.bracketed = True  # type: ignore[attr-defined]
        return self.at(node, start.start, end)

    def _list(self) -> ast.expr:
        start = self.step()
        members = self._members("]", start) if self.word != "]" else []
        if self.word == "for":
            self.brackets += 1
            loops = self._loops(start)
            self.brackets -= 1
            return self.at(ast.ListComp(members[0], loops), start.start, self.step().end)
        return self.at(ast.List(members, ast.Load()), start.start, self.step().end)

    def _open(self, start: Token) -> None:
        self.brackets += 1
        if self.brackets > DEEPEST:
            raise FormulaProblem("FORM002", start.start, reason="its brackets are nested too deeply")

    def _members(self, closer: str, start: Token, call: bool = False) -> list[ast.expr]:
        """The values up to a closing bracket, which is not taken; `;` and `,` both separate, but not mixed."""
        self._open(start)
        found: list[ast.expr] = []
        separator: Token | None = None
        while not (self.word == closer and not (call and separator)):
            if self.word in (",", ";", closer):
                self.fail("there is nothing between two separators", "Write a value there, or BLANK for none.")
            found.append(self.expression())
            if closer == "]" and self.word == "for" and len(found) == 1:
                break
            if self.word not in (",", ";"):
                if self.word != closer:
                    self._unclosed(start, closer)
                break
            if separator is not None and separator.text != self.word:
                hints.mixed_separators(self.tokens, self.i, separator)
            separator = self.step()
        self.brackets -= 1
        return found

    def _unclosed(self, start: Token, closer: str) -> NoReturn:
        if self.word == "for":
            self.refuse("A generator", "Write the brackets [ ] around it.", self.now.start, self.now.end)
        if self.now.kind == "end":
            self.fail("a closing bracket is missing", f"Add the closing bracket {closer}.", start)
        hints.leftover(self.tokens, self.i, self.typed)

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
            loop = ast.comprehension(target, self._or(), [], 0)
            while self.word == "if":
                self.step()
                loop.ifs.append(self._or())
            loops.append(loop)
        if self.word != "]":
            self._unclosed(start, "]")
        return loops

    def _target(self) -> ast.expr:
        bracket = self.word == "("
        if bracket:
            self.refuse("A bracket after “for”", "Write for a, b in … without brackets.", self.now.start, self.now.end)
        if self.now.kind != "name" or self.word or self.now.text.casefold() in _CONSTANTS:
            self.refuse("This after “for”", "Write a new name after “for”.", self.now.start, self.now.end)
        token = self.step()
        if self.word in ("[", ".", "("):
            self.refuse("This after “for”", "Write a new name after “for”.", token.start, self.now.end)
        return self.at(ast.Name(token.text, ast.Store()), token.start, token.end)

    def _text_with_values(self, token: Token) -> ast.expr:
        values: list[ast.expr] = []
        for part in token.parts:
            if isinstance(part, Hole):
                values.append(self._hole(part))
            elif part:
                values.append(self.at(ast.Constant(part), token.start, token.end))
        return self.at(ast.JoinedStr(values), token.start, token.end)

    def _hole(self, hole: Hole) -> ast.expr:
        inner = _Parser(hole.tokens, self.typed, self.depth + 1)
        inner.brackets = self.brackets
        value = self.deeper(inner.whole)
        spec = None
        if hole.format is not None:
            text = self.at(ast.Constant(hole.format), hole.start, hole.end)
            spec = self.at(ast.JoinedStr([text]), hole.start, hole.end)
        return self.at(ast.FormattedValue(value, -1, spec), hole.start, hole.end)


def _is_power(node: ast.expr) -> bool:
    """Whether a node is a power that no bracket stands around."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not getattr(node, "bracketed", False)


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool)
