"""What is known about what a function gives, whatever it is given."""

from __future__ import annotations

import math

from rrp_sheets.checks.abstract_values import LIST, NUMBER, TEXT, TRUTH, UNKNOWN, AbstractValue, number_within

_TRUTHS = frozenset(
    {"ALL", "ANY", "BETWEEN", "ENDSWITH", "EXACT", "ISBLANK", "ISEVEN", "ISLIST", "ISLOGICAL", "ISNUMBER", "ISODD",
     "ISRECORD", "ISTEXT", "STARTSWITH", "XOR"}
)  # fmt: skip
_TEXTS = frozenset(
    {"CONCAT", "FIXED", "LEFT", "LOWER", "MID", "PROPER", "REPT", "RIGHT", "STR", "SUBSTITUTE", "TEXT", "TEXTJOIN",
     "TRIM", "UPPER"}
)  # fmt: skip
_LISTS = frozenset({"DROP", "LIST", "RANGE", "REVERSE", "SEQUENCE", "SORTED", "TAKE", "TEXTSPLIT", "UNIQUE"})
_BOUNDS = {
    "ABS": (0, math.inf), "ACOS": (0, math.pi), "ANGLE": (-math.pi, math.pi), "ASIN": (-math.pi / 2, math.pi / 2),
    "ATAN": (-math.pi / 2, math.pi / 2), "COS": (-1, 1), "COUNT": (0, math.inf), "DISTANCE": (0, math.inf),
    "EXP": (0, math.inf), "HYPOT": (0, math.inf), "LEN": (0, 2_000), "MATCH": (1, 1_000), "ROWS": (0, 1_000),
    "SIGN": (-1, 1), "SIN": (-1, 1), "SQRT": (0, math.inf),
}  # fmt: skip
_NUMBERS = frozenset(
    {"AVERAGE", "CEIL", "COUNTA", "COUNTIF", "FIND", "FLOOR", "INT", "LN", "LOG10", "MEDIAN", "MOD", "MROUND", "PI",
     "POWER", "PRODUCT", "QUOTIENT", "ROUND", "ROUNDDOWN", "ROUNDUP", "SCALE", "SEARCH", "STDEV", "SUM", "TAN", "TRUNC",
     "VALUE"}
)  # fmt: skip


def given_by(function: str) -> AbstractValue:
    """What a function gives, by its name.

    >>> given_by("UPPER").kind, given_by("COS").low, given_by("INDEX").kind
    ('text', -1, 'any')
    """
    if function in _BOUNDS:
        return number_within(*_BOUNDS[function])
    kinds = {TRUTH: _TRUTHS, TEXT: _TEXTS, LIST: _LISTS, NUMBER: _NUMBERS}
    return next((AbstractValue(kind) for kind, names in kinds.items() if function in names), UNKNOWN)
