"""The parser: by recursive descent from tokens to Python's syntax nodes, and kinds of nodes that Python lacks."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from typing import NoReturn, TypeVar

from rrp_sheets.formulas import hints
from rrp_sheets.formulas.limits import DEEPEST
from rrp_sheets.formulas.problems import FormulaProblem, together
from rrp_sheets.formulas.tokens import Hole, Token, parse_number
from rrp_sheets.model.names import OPERATOR_WORDS
from rrp_sheets.texts import N_

Node = TypeVar("Node", bound=ast.AST)
CONSTANTS = {"true": True, "false": False, "none": None, "blank": None}
_AS_FUNCTION = frozenset(("if", "and", "or", "not"))
_STARTS = frozenset("([{-+$.") | {"**", "++", "--"}
_TREE_DEPTH = 2 * DEEPEST  # of nested rules; brackets count on their own
_COMPARE: dict[str, type[ast.cmpop]] = {
    "=": ast.Eq, "==": ast.Eq, "<>": ast.NotEq, "!=": ast.NotEq, "≠": ast.NotEq, "<": ast.Lt, "<=": ast.LtE,
    "≤": ast.LtE, ">": ast.Gt, ">=": ast.GtE, "≥": ast.GtE, "in": ast.In, "is": ast.Is, "not": ast.NotIn,
}  # fmt: skip
_SHEET_EQUALS = ("=", "<>")
_SUM: dict[str, type[ast.operator]] = {"+": ast.Add, "-": ast.Sub}
_TERM: dict[str, type[ast.operator]] = {"*": ast.Mult, "/": ast.Div, "//": ast.FloorDiv, "%": ast.Mod}


class Join(ast.expr):
    """`a & b & c`: a text of all of them."""

    _fields = ("values",)

    values: list[ast.expr]


class IfError(ast.expr):
    """IFERROR: `value`, or `otherwise` when evaluating it fails. ISERROR: `otherwise` is None."""

    _fields = ("value", "otherwise")

    value: ast.expr
    otherwise: ast.expr | None


class Switch(ast.expr):
    """SWITCH: the result of the first case that `value` equals, or `otherwise`; IFS: of the first that holds."""

    _fields = ("value", "cases", "results", "otherwise")

    value: ast.expr | None
    cases: list[ast.expr]
    results: list[ast.expr]
    otherwise: ast.expr | None


class Pick(ast.expr):
    """PICK: it draws from `members`; `site` distinguishes those of a row that draw from different lists."""

    _fields = ("members",)

    members: list[ast.expr]
    site: str


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


def unread(node: ast.expr) -> ast.expr:
    """Mark a node that stands for something unreadable or meaningless: no problem is reported about its use."""
    node.unread = True  # type: ignore[attr-defined]
    return node


def operator_of(token: Token) -> str:
    """Return the token as an operator: a sign, or one of Python's words in small letters; else an empty text."""
    return token.text if token.kind == "sign" or (token.kind == "name" and token.text in OPERATOR_WORDS) else ""


class _Parser:
    def __init__(self, tokens: list[Token], typed: str, depth: int = 0) -> None:
        self.tokens = tokens
        self.typed = typed
        self.i = 0
        self.now = tokens[0]
        self.word = operator_of(self.now)
        self.depth = depth
        self.brackets = 0
        self.problems: list[FormulaProblem] = []  # after which reading went on

    # ---- moving on
    def step(self) -> Token:
        token = self.now
        self.i += 1
        self.now = self.tokens[self.i]
        self.word = operator_of(self.now)
        return token

    @property
    def next(self) -> Token:
        return self.tokens[min(self.i + 1, len(self.tokens) - 1)]

    def fail(self, reason: str, remedy: str, at: Token | None = None) -> NoReturn:
        raise hints.syntax(at or self.now, reason, remedy)

    def refuse(self, what: str, remedy: str, start: int, end: int) -> NoReturn:
        raise FormulaProblem("FORM003", start, max(end - start, 1), what=what, remedy=remedy)

    def note(self, what: str, remedy: str, start: int, end: int) -> None:
        """Record FORM003 for a part of the typed text, and read on."""
        self.problems.append(FormulaProblem("FORM003", start, max(end - start, 1), what=what, remedy=remedy))

    def at(self, node: Node, start: int, end: int) -> Node:
        node.lineno = node.end_lineno = 1  # type: ignore[attr-defined]
        node.col_offset, node.end_col_offset = start, end  # type: ignore[attr-defined]
        return node

    def between(self, node: Node, first: ast.expr, last: ast.expr) -> Node:
        return self.at(node, first.col_offset, last.end_col_offset or 0)

    def deeper(self, rule: Callable[[], ast.expr]) -> ast.expr:
        """Return what a rule reads one level deeper; raises FORM002 when that is too deep."""
        self.depth += 1
        if self.depth > _TREE_DEPTH:
            raise FormulaProblem("FORM002", self.now.start, reason=N_("it is nested too deeply"))
        node = rule()
        self.depth -= 1
        return node

    # ---- rules, loosest first
    def whole(self) -> ast.expr:
        node = self.expression()
        if self.now.kind == "sign" and self.now.text in (",", ";"):
            hints.bare_separator(self.tokens, self.i)
        if self.now.kind != "end":
            hints.leftover(self.tokens, self.i)
        return node

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
        values = [rule()]
        while self.word == word:
            self.step()
            values.append(rule())
        return values[0] if len(values) == 1 else self.between(ast.BoolOp(op(), values), values[0], values[-1])

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
                self.fail(N_("two = are not next to each other"), N_("Write x = 3 or x == 3."), sign)
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
        values = [self._sum()]
        while self.word == "&":
            self.step()
            values.append(self._sum())
        if len(values) == 1:
            return values[0]
        join = Join()
        join.values = values
        return self.between(join, values[0], values[-1])

    def _sum(self) -> ast.expr:
        return self._calculation(_SUM, lambda: self._calculation(_TERM, self._signed))

    def _calculation(self, operators: dict[str, type[ast.operator]], operand: Callable[[], ast.expr]) -> ast.expr:
        left = operand()
        while self.word in operators:
            op = operators[self.step().text]()
            left = self.between(ast.BinOp(left, op, right := operand()), left, right)
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
            targets = [target := self._target()]
            while self.word == ",":
                self.step()
                targets.append(self._target())
            if self.word != "in":
                self.fail(N_("“in” is missing behind “for”"), N_("Write for example [n * 2 for n in numbers]."))
            self.step()
            if len(targets) > 1:
                target = self.between(ast.Tuple(targets, ast.Store()), targets[0], targets[-1])
            loop = ast.comprehension(target, self.condition(), [], 0)
            while self.word == "if":
                self.step()
                loop.ifs.append(self.condition())
            loops.append(loop)
        if self.word != "]":
            self.unclosed(start, "]")
        return loops

    def _target(self) -> ast.expr:
        token = self.now
        if self.word == "(":
            remedy = N_("Write for a, b in … without brackets.")
            self.refuse(N_("A bracket after “for”"), remedy, token.start, token.end)
        if token.kind != "name" or self.word or token.text.casefold() in CONSTANTS:
            self.refuse(N_("This after “for”"), N_("Write a new name after “for”."), token.start, token.end)
        self.step()
        if self.word in ("[", ".", "("):
            self.refuse(N_("This after “for”"), N_("Write a new name after “for”."), token.start, self.now.end)
        return self.at(ast.Name(token.text, ast.Store()), token.start, token.end)

    # ---- what stands behind a value
    def postfix(self) -> ast.expr:
        """Read a value with its fields, places, brackets, and the signs % and ° behind it."""
        node = self._value()
        while True:
            word = self.word
            if word == ".":
                self.step()
                if self.now.kind != "name":
                    self.fail(N_("a field's name is missing behind a point"), N_("Write for example redBall.distance."))
                name = self.step()
                node = self.at(ast.Attribute(node, name.text, ast.Load()), node.col_offset, name.end)
            elif word == "[":
                node = self._subscript(node)
            elif word == "(":
                start = self.step()
                args = self.members(")", start, call=True)
                node = self.at(ast.Call(node, args, []), node.col_offset, self.step().end)
            elif word == "%" and self._is_percent(node):
                node = self._scaled(node, self.step().end, lambda n: n / 100, 100)
            elif word == "°":
                end = self.step().end
                if not _is_number(node):
                    remedy = N_("Write RADIANS(…).")
                    self.refuse(N_("The sign ° after something that is not a number"), remedy, node.col_offset, end)
                node = self._scaled(node, end, math.radians, 1)
            else:
                return node

    def _is_percent(self, node: ast.expr) -> bool:
        """Return whether % is the sign behind a number (50%), and not the remainder's (x % 2)."""
        following = self.next
        if following.kind not in ("sign", "end") and following.text not in OPERATOR_WORDS:
            return False
        if following.text in ("-", "+"):
            shown = self.typed[node.col_offset : self.now.start].strip()
            advice = N_("Write ({shown}%) {sign} … for percent, or MOD({shown}; {sign}…) for the remainder.",
                        shown=shown, sign=following.text)  # fmt: skip
            self.refuse(N_("“%” before a sign"), advice, self.now.start, following.end)
        return following.text != "not" and following.text not in _STARTS

    def _scaled(self, node: ast.expr, end: int, scale: Callable[[float], float], divisor: int) -> ast.expr:
        start = node.col_offset
        if isinstance(node, ast.Constant) and _is_number(node):
            return self.at(ast.Constant(scale(node.value)), start, end)  # type: ignore[arg-type]
        return self.at(ast.BinOp(node, ast.Div(), self.at(ast.Constant(divisor), start, end)), start, end)

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
                if self.word in (",", ";"):
                    remedy = N_("Write balls[0] for one place, balls[0:2] for a part.")
                    self.fail(N_("there are two places in brackets"), remedy)
                self.unclosed(start, "]")
        if colons == 0 and parts[0] is None:
            self.fail(N_("there is nothing between [ and ]"), N_("Write a field's name or a place: balls[0]."))
        if colons > 2:
            self.fail(N_("there are too many : in brackets"), N_("Write [first:end]."))
        index = parts[0] if colons == 0 else self.at(ast.Slice(*parts), start.start, self.now.end)
        assert index is not None
        self.brackets -= 1
        return self.at(ast.Subscript(owner, index, ast.Load()), owner.col_offset, self.step().end)

    # ---- values
    def _value(self) -> ast.expr:
        kind = self.now.kind
        if kind in ("number", "text"):
            token = self.step()
            value = parse_number(token) if kind == "number" else token.text
            return self.at(ast.Constant(value), token.start, token.end)
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
            return self.list_()
        hints.no_value(self.tokens, self.i)

    def _name(self) -> ast.expr:
        token, lower = self.now, self.now.text.casefold()
        called = self.next.text == "(" and self.next.kind == "sign"
        if lower in CONSTANTS:
            self.step()
            if called:  # spreadsheets write TRUE() as well
                start = self.step()
                if self.word != ")":
                    reason = N_("there is something between the brackets of {text}", text=token.text)
                    self.fail(reason, N_("Write {text} alone.", text=token.text), start)
                token = token._replace(end=self.step().end)
            return self.at(ast.Constant(CONSTANTS[lower]), token.start, token.end)
        if (lower in _AS_FUNCTION and not called) or lower in hints.KEYWORDS:
            hints.keyword(self.tokens, self.i)
        self.step()
        return self.at(ast.Name(token.text, ast.Load()), token.start, token.end)

    def _bracketed(self) -> ast.expr:
        start = self.step()
        if self.word == ")":
            return self.at(ast.Tuple([], ast.Load()), start.start, self.step().end)
        members, before = self.members(")", start), self.tokens[self.i - 1]
        trailing = before.text == "," and before.kind == "sign"
        end = self.step().end
        node = members[0] if len(members) == 1 and not trailing else ast.Tuple(members, ast.Load())
        node.bracketed = True  # type: ignore[attr-defined]
        return self.at(node, start.start, end)

    def _open(self, start: Token) -> None:
        self.brackets += 1
        if self.brackets > DEEPEST:
            raise FormulaProblem("FORM002", start.start, reason=N_("its brackets are nested too deeply"))

    def members(self, closer: str, start: Token, call: bool = False) -> list[ast.expr]:
        """Read the values up to a closing bracket, which is not taken; `;` and `,` both separate, but not mixed."""
        self._open(start)
        found: list[ast.expr] = []
        separator: Token | None = None
        while not (self.word == closer and not (call and separator)):
            found.append(self._member(closer, start, may_loop=closer == "]" and not found))
            if self.word not in (",", ";"):
                break
            if separator is not None and separator.text != self.word:
                hints.mixed_separators(self.tokens, self.i, separator)
            separator = self.step()
        self.brackets -= 1
        return found

    def _member(self, closer: str, start: Token, may_loop: bool) -> ast.expr:
        """Read a value between separators; if it cannot be read, record the problem and go on behind it."""
        first, depth, brackets = self.i, self.depth, self.brackets
        try:
            if self.word in (",", ";", closer):
                self.fail(N_("there is nothing between two separators"), N_("Write a value there, or BLANK for none."))
            member = self.expression()
            if self.word not in (",", ";", closer) and not (may_loop and self.word == "for"):
                self.unclosed(start, closer)
            return member
        except FormulaProblem as problem:
            end = self._end_of_member(first, closer) if problem.code in ("FORM001", "FORM003", "FORM018") else 0
            if not end:
                raise
            self.problems.append(problem)
            self.depth, self.brackets = depth, brackets
            self.i = end - 1
            self.step()
            return unread(self.at(ast.Constant(None), self.tokens[first].start, self.now.start))

    def _end_of_member(self, first: int, closer: str) -> int:
        """Return the place of the separator or bracket that ends a member; 0 when there is none."""
        deep = 0
        for i in range(first, len(self.tokens)):
            text = self.tokens[i].text if self.tokens[i].kind == "sign" else ""
            if not deep and text in (",", ";", closer):
                return i
            deep += (text in ("(", "[", "{")) - (text in (")", "]", "}"))
            if deep < 0:
                return 0
        return 0

    def unclosed(self, start: Token, closer: str) -> NoReturn:
        if self.word == "for":
            self.refuse(N_("A generator"), N_("Write the brackets [ ] around it."), self.now.start, self.now.end)
        if self.now.kind == "end":
            self.fail(N_("a closing bracket is missing"), N_("Add the closing bracket {closer}.", closer=closer), start)
        hints.leftover(self.tokens, self.i)

    def _text_with_values(self, token: Token) -> ast.expr:
        place = token.start, token.end
        values: list[ast.expr] = [
            self._hole(part) if isinstance(part, Hole) else self.at(ast.Constant(part), *place)
            for part in token.parts if part
        ]  # fmt: skip
        return self.at(ast.JoinedStr(values), *place)

    def _hole(self, hole: Hole) -> ast.expr:
        def read() -> ast.expr:
            inner = _Parser(hole.tokens, self.typed, self.depth)
            inner.brackets, inner.problems = self.brackets, self.problems
            return inner.whole()

        value, spec = self.deeper(read), None
        place = hole.start, hole.end
        if hole.format is not None:
            spec = self.at(ast.JoinedStr([self.at(ast.Constant(hole.format), *place)]), *place)
        return self.at(ast.FormattedValue(value, -1, spec), *place)


def _is_power(node: ast.expr) -> bool:
    """Return whether a node is a power without brackets around it."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not getattr(node, "bracketed", False)


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool)
