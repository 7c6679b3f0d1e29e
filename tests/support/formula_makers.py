"""Formulas by chance, for attacking the language: both spellings, sound and mutated, with names of dangerous things."""

from __future__ import annotations

import random

from rrp_sheets.formulas import HelperDef, Input, compile_formula, make_scope, make_table
from rrp_sheets.formulas.functions import library
from rrp_sheets.model.values import Field, Record, RecordType

BALL = RecordType("Red ball", (Field("distance"), Field("x"), Field("y"), Field("colour"), Field("Is red")))
_DANGEROUS = [
    "__class__", "__globals__", "__builtins__", "__import__", "__subclasses__", "__dict__", "__init__", "gi_frame", "mro", "open",
    "eval", "exec", "getattr", "print", "vars", "type", "object", "import os", "lambda", "format", "format_map", "keys", "values",
    "get", "type.name", "symtable", "node_handlers", "_value", "self", "tolist", "__reduce__", "f_locals", "tb_frame", "cr_code",
]  # fmt: skip
_NAMES = [
    "ball",
    "x",
    "name",
    "balls",
    "gone",
    "deep",
    "Parts",
    "double",
    "praise",
    "grow",
    "q",
    "p",
    "pi",
    "e",
    "value",
]
_FIELDS = ["distance", "x", "colour", "isRed", "is_red", "ask", "zone", "points", *_DANGEROUS[:12]]
_NUMBERS = [
    "0",
    "1",
    "2",
    "-1",
    "0.5",
    "3.7",
    "1e15",
    "1e-15",
    "999",
    "1000",
    "2000",
    "50%",
    "30°",
    "9**9",
    "10^15",
    "1e308",
    "0x10",
]
_TEXTS = [
    '"a"',
    "'b'",
    '"say ""hi"""',
    '""',
    "“red”",
    '"{x}"',
    'f"{x}"',
    'f"{x:.2f}"',
    "f'{name:>50}'",
    'f"{x:>99}"',
    '"%s"',
    "'\\\\'",
]
_SIGNS = [
    "+",
    "-",
    "*",
    "/",
    "//",
    "%",
    "**",
    "^",
    "&",
    "=",
    "==",
    "<>",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    " and ",
    " or ",
    " in ",
    " not in ",
    " is ",
]
_SCRAPS = [
    *"()[]{}.,;:+-*/%^&=<>!'\"~|@$#\\`?",
    " ",
    "**",
    " for q in ",
    " if ",
    " else ",
    "not ",
    "=",
    "IF(",
    "PICK(",
    "[q for q in ",
    "f'{",
    "}'",
]


def inputs() -> dict[str, object]:
    """Inputs of every kind."""
    ball = Record(BALL, {"distance": 12.5, "x": 3.0, "y": -4.0, "colour": "red", "isred": True})
    return {
        "ball": ball,
        "x": 5,
        "name": "Kim",
        "balls": [1, 2, 3],
        "gone": None,
        "deep": [[1, ["a", [2.5]]], (ball, ball)],
    }


def scope():
    """A scope of them, with tables of 1,000 × 30 and helpers that call helpers."""
    wide = [[f"C{i}" for i in range(30)], *([str(r * i) for i in range(30)] for r in range(1000))]
    tables = {
        "parts": make_table("Parts", [["Ask", "Zone", "Points"], ["where?", "head", "1"], ["and?", "hand", ""], ["so?", "foot", "TRUE"]]),
        "wide": make_table("Wide", wide),
    }  # fmt: skip
    helpers: dict[str, HelperDef] = {}
    for name, parameters, text in [
        ("double", ["n"], "n & n"), ("grow", ["n"], "double(double(n)) + double(n)"), ("praise", [], "PICK(\"a\"; \"b\")"),
        ("many", ["n"], "[n for i in RANGE(100)]"), ("more", ["n"], "many(many(n))"), ("most", ["n"], "more(more(n))"),
    ]:  # fmt: skip
        tree = compile_formula(text, make_scope([(p, None) for p in parameters], helpers, tables=tables)).tree
        helpers[name] = HelperDef(name, tuple(Input(p, p) for p in parameters), tree)
    return make_scope([(n, getattr(v, "type", None)) for n, v in inputs().items()], helpers, tables=tables)


class Maker:
    """Makes formulas; the same seed makes the same."""

    def __init__(self, seed: int) -> None:
        self.chance = random.Random(seed)
        self.functions = [(f.names, f.least, min(f.most, 6)) for f in library()]

    def formula(self) -> str:
        """A formula: mostly well formed, often damaged, sometimes only scraps."""
        draw = self.chance.random()
        if draw < 0.08:
            return "".join(self.chance.choice(_SCRAPS + _NAMES + _NUMBERS) for _ in range(self.chance.randint(1, 16)))
        text = self._value(self.chance.randint(1, 5))
        if draw < 0.25:
            text = self._damage(text)
        return self.chance.choice(("", "", "=", "= ")) + text

    def _damage(self, text: str) -> str:
        for _ in range(self.chance.randint(1, 3)):
            at = self.chance.randint(0, len(text))
            cut = at + self.chance.randint(0, 4)
            text = text[:at] + self.chance.choice([*_SCRAPS, *_DANGEROUS, *_NUMBERS, "", ""]) + text[cut:]
        return text

    def _value(self, depth: int) -> str:
        c = self.chance
        if depth <= 0 or c.random() < 0.12:
            return c.choice(
                c.choice((_NAMES, _NAMES, _NUMBERS, _TEXTS, ["TRUE", "false", "BLANK", "None", "Wide", "RANGE(1000)"]))
            )
        return getattr(self, "_" + c.choice(_KINDS))(depth - 1)

    def _call(self, depth: int) -> str:
        names, least, most = self.chance.choice(self.functions)
        name = self.chance.choice((self.chance.choice(names), self.chance.choice(names).lower()))
        between = self.chance.choice((", ", "; ", ";"))
        return (
            f"{name}({between.join(self._value(depth) for _ in range(self.chance.randint(least, max(least, most))))})"
        )

    def _helper(self, depth: int) -> str:
        return f"{self.chance.choice(('double', 'grow', 'many', 'more', 'most'))}({self._value(depth)})"

    def _binary(self, depth: int) -> str:
        return f"{self._value(depth)} {self.chance.choice(_SIGNS)} {self._value(depth)}"

    def _bracket(self, depth: int) -> str:
        return f"({self._value(depth)})"

    def _unary(self, depth: int) -> str:
        return (
            self.chance.choice(("-", "+", "not ", "NOT", ""))
            + self._bracket(depth)
            + self.chance.choice(("", "", "%", "°"))
        )

    def _list(self, depth: int) -> str:
        members = (self.chance.choice((", ", "; "))).join(self._value(depth) for _ in range(self.chance.randint(0, 4)))
        return f"[{members}]" if self.chance.random() < 0.7 else f"({members})"

    def _loop(self, depth: int) -> str:
        condition = f" if {self._value(depth)}" if self.chance.random() < 0.3 else ""
        second = f" for p in {self._value(depth)}" if self.chance.random() < 0.3 else ""
        return f"[{self._value(depth)} for q in {self._value(depth)}{second}{condition}]"

    def _field(self, depth: int) -> str:
        owner = self._value(depth) if self.chance.random() < 0.5 else "ball"
        name = self.chance.choice(_FIELDS)
        return f"{owner}.{name}" if self.chance.random() < 0.7 else f"{owner}['{name}']"

    def _place(self, depth: int) -> str:
        inner = self._value(depth) if self.chance.random() < 0.7 else f"{self._value(depth)}:{self._value(depth)}"
        return f"{self._value(depth)}[{inner}]"

    def _column(self, depth: int) -> str:
        return self.chance.choice(
            ("Parts[Ask]", "Parts[Zone]", "Wide[C29]", "Wide[C0]", "Parts[Points]", "Parts[__class__]")
        )

    def _choice(self, depth: int) -> str:
        return f"{self._value(depth)} if {self._value(depth)} else {self._value(depth)}"

    def _text(self, depth: int) -> str:
        quote = self.chance.choice("'\"")
        return f"f{quote}it is {{{self._value(depth)}{self.chance.choice(('', '', '', ':.1f', ':>20', '!r', ':{x}'))}}}{quote}"


_KINDS = (
    ["call"] * 6
    + ["binary"] * 5
    + ["helper", "bracket", "unary", "list", "list", "loop", "loop", "field", "place", "column", "choice", "text"]
)
