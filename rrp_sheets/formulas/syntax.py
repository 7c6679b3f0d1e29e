"""Parsing a formula in Python's spelling, and telling a syntax error in a therapist's words."""

from __future__ import annotations

import ast
import re
import warnings

from rrp_sheets.formulas.limits import DEEPEST, MOST_NODES
from rrp_sheets.formulas.problems import FormulaProblem

_HABITS = (  # what spreadsheets and people write, and Python does not
    (r";", "there is a semicolon in it", "Write a comma between the values in brackets."),
    (r"<>", "there is <> in it", "Write != to ask whether two things differ."),
    (r"\d\s*%(?!\s*[\w(])", "there is a percent sign in it", "Write 0.5 for 50 %."),
    (r"\b(AND|OR|NOT)\b(?!\s*\()", "AND, OR and NOT in capitals need brackets",
     "Write and, or, not in small letters, or AND(…, …)."),
    (r"\bbetween\b", "“between” is not understood", "Write 1 <= distance <= 2."),
    (r"(?<![\w.])\d+(\.\d+)?\s*(m|cm|mm|s|ms|°|deg|rad)\b", "there is a unit behind a number",
     "Leave the unit out: distances are in metres, angles in radians (RADIANS(30) is 30 degrees)."),
)  # fmt: skip


def parse(source: str) -> ast.expr:
    """The expression's tree; raises FormulaProblem FORM001 or FORM002."""
    if source.count("(") + source.count("[") > MOST_NODES or _deepest_brackets(source) > DEEPEST:
        raise FormulaProblem("FORM002", 0, reason="its brackets are nested too deeply")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # "is with a literal" is ours to tell
            return ast.parse(source, mode="eval").body
    except SyntaxError as error:
        column = max((error.offset or 1) - 1, 0)
        reason, remedy = _syntax_words(source, column, error)
        raise FormulaProblem("FORM001", column, reason=reason, remedy=remedy) from None
    except (ValueError, RecursionError, MemoryError, OverflowError):
        raise FormulaProblem("FORM002", 0, reason="it is nested too deeply") from None


def _deepest_brackets(source: str) -> int:
    depth = deepest = 0
    for c in source:
        depth += (c in "([{") - (c in ")]}")
        deepest = max(deepest, depth)
    return deepest


def _syntax_words(source: str, column: int, error: SyntaxError) -> tuple[str, str]:
    """A syntax error in a therapist's words."""
    if re.search(r"(?<![<>=!])=(?!=)", re.sub(r"\"[^\"]*\"|'[^']*'", "", source)):
        return "there is a single = in it", "Write == to ask whether two things are equal."
    bare = re.sub(r"\"[^\"]*\"|'[^']*'", '""', source)
    for pattern, reason, remedy in _HABITS:
        if re.search(pattern, bare):
            return reason, remedy
    balance = source.count("(") - source.count(")")
    if balance:
        missing = "closing" if balance > 0 else "opening"
        return f"a {missing} bracket is missing", f"Add the {missing} bracket."
    if "expected 'else'" in (error.msg or ""):
        return "an if without else", 'Write: "near" if distance < 1 else "far".'
    if "unterminated" in (error.msg or ""):
        return "a quote is missing at the end of a text", "Close the text with the same quote as at its beginning."
    near = source[column : column + 12].strip() + ("…" if len(source) > column + 12 else "")
    return (f"it breaks off at “{near}”" if near else "it breaks off at its end"), "Check what stands there."
