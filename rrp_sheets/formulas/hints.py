"""Problems of formulas in plain words, and what to write for the names and signs of other programs."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple, NoReturn

from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.tokens import Token
from rrp_sheets.texts import N_

KEYWORDS = frozenset((
    "else", "for", "in", "is", "lambda", "await", "yield", "import", "from", "class", "def", "del", "try", "with",
    "assert", "raise", "return", "global", "nonlocal", "while", "async", "as", "except", "finally", "pass", "break",
    "continue", "elif",
))  # fmt: skip
_REFUSED_WORDS = {"lambda": N_("A lambda"), **{word: N_("“{text}”", text=word) for word in ("await", "yield", "async")}}
_TIMES = frozenset(("s", "ms", "sec", "min", "h"))
_UNITS = frozenset(("m", "cm", "mm", "km", "kg", "g", "hz", "deg", "degree", "degrees", "rad"))
_CELL = re.compile(r"\$?[A-Za-z]{1,3}\$?[1-9]\d{0,6}")
_SIGNS = {  # a sign that nothing here is called by: what people mean with it
    "&&": N_("Write AND(…; …)."), "||": N_("Write OR(…; …)."), "?": N_("Write IF(condition; then; otherwise)."),
    "=>": N_("Write >=."), "=<": N_("Write <=."), "><": N_("Write <>."), "|": N_("Write OR(…; …)."),
    "~": N_("Write NOT(…), or <> for not equal."),
    "<<": N_("Write < once, or multiply by 2."), ">>": N_("Write > once, or divide by 2."), "@": N_("Leave it out."),
    "\\": N_("Write / to divide."), "`": N_("Put texts between quotes."),
    "{": N_("Write lists in brackets [ ]: [1; 2]."), "}": N_("Write lists in brackets [ ]: [1; 2]."),
    "$": N_("Write the stream's name."), "°": N_("Write RADIANS(…)."),
    ":=": N_("A formula only calculates: use an accumulate row to remember a value."),
    "!": N_("Write NOT(…) for not, <> for not equal, PRODUCT(1; 2; 3) for a factorial."),
}  # fmt: skip
_WRITTEN = {"=>": ">=", "=<": "<=", "><": "<>"}
_BETWEEN = N_("Write what to do with the two values: & + - * / < =, or ; between.")
_ADVICE = N_("A formula is one calculation of inputs, numbers, texts, operators and the library's functions.")


def syntax(token: Token, reason: str, remedy: str, **details: object) -> FormulaProblem:
    """Return the problem FORM001 at a token."""
    width = max(token.end - token.start, 1)
    return FormulaProblem("FORM001", token.start, width, reason=reason, remedy=remedy, **details)


def refused(token: Token, what: str, remedy: str) -> FormulaProblem:
    """Return the problem FORM003 at a token."""
    problem = FormulaProblem("FORM003", token.start, max(token.end - token.start, 1), what=what, remedy=remedy)
    problem.written = _WRITTEN.get(token.text, "")
    return problem


def cell(name: str) -> bool:
    """Return whether a name looks like a cell of a spreadsheet: A1, $B$12."""
    return _CELL.fullmatch(name) is not None


def cell_reference(start: int, text: str, names: list[str] | None = None) -> FormulaProblem:
    """Return the problem FORM018: a cell where a stream's name belongs."""
    if names:
        return FormulaProblem("FORM018", start, len(text), cell=text, remedy=instead_of_cell(names))
    remedy = N_("Write the name of one of the row's inputs instead, such as {example}.", example="redBall")
    return FormulaProblem("FORM018", start, len(text), cell=text, remedy=remedy, example="redBall")


def instead_of_cell(names: Sequence[str]) -> str:
    """Return the remedy that proposes up to three inputs: `a or b or c`."""
    listed = reduce(lambda before, after: N_("{before} or {after}", before=before, after=after), names[:3])
    return N_("Write the name of the row's input instead: {names}.", names=listed)


def if_example(name: str) -> str:
    """Return the remedy that writes IF with a number of the row."""
    return N_('Write IF({name} < 1; "near"; "far").', name=name)


def truth_beside_number(left: ast.expr, right: ast.expr) -> bool:
    """Return whether TRUE or FALSE is compared with a number: never equal in a spreadsheet, but maybe in Python."""
    kinds = {type(n.value) if isinstance(n, ast.Constant) else None for n in (left, right)}
    return bool in kinds and bool(kinds & {int, float})


def bare_separator(tokens: list[Token], i: int) -> NoReturn:
    """Raise the problem of a comma or semicolon without brackets around it."""
    if decimal := _decimal(tokens, i):
        raise decimal.problem(N_("Write {value}; for a pair, use brackets: (x; y).", value=decimal.shown))
    name = N_("comma") if tokens[i].text == "," else N_("semicolon")
    remedy = N_("Put brackets around values that belong together: (x; y).")
    raise refused(tokens[i], N_("A {name} without brackets", name=name), remedy)


def mixed_separators(tokens: list[Token], i: int, separator: Token) -> NoReturn:
    """Raise the problem of `;` and `,` in one pair of brackets, where most often one is a decimal comma."""
    if decimal := _decimal(tokens, i if tokens[i].text == "," else tokens.index(separator)):
        raise decimal.problem(N_("Write {value}.", value=decimal.shown))
    raise refused(tokens[i], N_("Both ; and , in one pair of brackets"),
                  N_("Write the same sign between all values; decimal numbers have a point."))  # fmt: skip


class _Decimal(NamedTuple):
    """A number with a decimal comma: its place, its text, how to write it, and that alone if it is sure."""

    start: int
    end: int
    typed: str
    shown: str
    guess: str | None

    def problem(self, remedy: str) -> FormulaProblem:
        return FormulaProblem("FORM003", self.start, self.end - self.start, what=N_("A decimal comma"), remedy=remedy,
                              typed=self.typed, guess=self.guess)  # fmt: skip


def _decimal(tokens: list[Token], i: int) -> _Decimal | None:
    """Return the number that a comma stands in; None when it stands between two values."""
    before, comma, after = tokens[i - 1], tokens[i], tokens[i + 1] if i + 1 < len(tokens) else tokens[i]
    if comma.text != "," or before.kind != "number" or after.kind != "number" or after.start != comma.end:
        return None
    typed, whole = f"{before.text},{after.text}", before.text.replace(".", "")
    number, joined = f"{whole}.{after.text}", f"{whole}{after.text}"
    if "." not in before.text and len(after.text) == 3 and whole != "0":
        shown = N_("{joined} for thousands, or {number}", joined=joined, number=number)
        return _Decimal(before.start, after.end, typed, shown, None)
    return _Decimal(before.start, after.end, typed, number, number if joined.isdecimal() else None)


def no_value(tokens: list[Token], i: int) -> NoReturn:
    """Raise the problem of a token that stands where a value belongs."""
    now, before = tokens[i], tokens[i - 1] if i else None
    if now.kind == "end":
        if before is None:
            raise syntax(now, N_("there is nothing in it"), N_("Write a formula."))
        raise syntax(before, N_("it breaks off after “{near}”", near=_near(before)), N_("Write what belongs there."))
    if now.text in ("*", "**") and (before is None or before.text in ("(", "[", ",", ";")):
        raise refused(now, N_("A star"), N_("Write the list itself: MAX(balls)."))
    if now.text == "{":
        if any(t.kind == "sign" and t.text == ":" for t in tokens[i:]):  # braces are lists to a spreadsheet
            raise refused(now, N_("A dictionary"), N_("Write lists in brackets [ ]: [1; 2]; look up with XLOOKUP."))
        raise refused(now, "{ }", _SIGNS["{"])
    if now.text == "$":
        raise cell_reference(now.start, now.text + "".join(t.text for t in tokens[i + 1 : i + 4] if t.kind != "end"))
    if now.text in _SIGNS:
        raise refused(now, N_("The sign {text}", text=now.text), _SIGNS[now.text])
    if now.text in (")", "]"):
        reason = N_("there is nothing before “{text}”", text=now.text)
        raise syntax(now, reason, N_("Write a value there, or take the sign away."))
    if now.text == ":":
        raise syntax(now, N_("there is a colon in it"), N_("Use colons only in brackets: balls[0:2]."))
    if before is not None and before.text in ("=", "==") and now.text in ("=", "=="):
        raise syntax(now, N_("two = are not next to each other"), N_("Write x = 3 or x == 3."))
    raise syntax(now, N_("a value is missing before “{near}”", near=_near(now)), N_("Write what belongs there."))


def keyword(tokens: list[Token], i: int) -> NoReturn:
    """Raise the problem of a word of Python's, or IF, AND, OR, NOT without brackets, where a value belongs."""
    now, lower = tokens[i], tokens[i].text.casefold()
    if lower in _REFUSED_WORDS:
        raise refused(now, _REFUSED_WORDS[lower], _ADVICE)
    if lower == "if":
        raise syntax(now, N_("it begins with “if”"), if_example("distance"), example="distance")
    if lower == "not":
        problem = syntax(now, N_("NOT in capitals needs brackets"), N_("Write NOT(…), or not in small letters."))
        problem.written = lower
        raise problem
    if lower in ("and", "or", "in", "is", "else", "for"):
        raise syntax(now, N_("a value is missing before “{text}”", text=now.text), N_("Write what belongs there."))
    raise syntax(now, N_("“{text}” belongs to a program", text=now.text), _ADVICE)


def leftover(tokens: list[Token], i: int) -> NoReturn:
    """Raise the problem of a token that cannot stand behind a complete value."""
    before, now = tokens[i - 1], tokens[i]
    if now.kind == "sign":
        raise _odd_sign(tokens, i)
    if now.kind == "number" and before.kind == "number" and now.start == before.end:
        raise syntax(now, N_("there are two points in a number"), N_("Write numbers with one point: 1.5."))
    if now.kind == "number" and before.kind == "number":
        remedy = N_("Write {text}{text2}.", text=before.text, text2=now.text)
        raise syntax(now, N_("there is a space in a number"), remedy)
    if now.kind in ("text", "texts") and before.kind in ("text", "texts"):
        raise syntax(now, N_("two texts are next to each other"), N_("Write & between them to join them."))
    if now.kind == "name":
        raise _odd_word(before, now)
    shown = N_("a text") if now.kind in ("text", "texts") else N_("“{text}”", text=_near(now))
    raise syntax(now, N_("there is no sign before {shown}", shown=shown), _BETWEEN)


def _odd_word(before: Token, now: Token) -> FormulaProblem:
    lower = now.text.casefold()
    if lower in ("and", "or", "not"):
        problem = syntax(now, N_("AND, OR and NOT in capitals need brackets"),
                         N_("Write and, or, not in small letters, or AND(…; …)."))  # fmt: skip
        problem.written = lower
        return problem
    if lower in ("then", "elif", "elseif"):
        reason = N_("“{text}” is not understood", text=now.text)
        return syntax(now, reason, if_example("distance"), example="distance")
    if lower == "between":
        return syntax(now, N_("“between” is not understood"), N_("Write 1 <= distance <= 2."))
    if lower in ("equals", "equal", "is"):
        return syntax(now, N_("“{text}” is not understood", text=now.text), N_("Write = to compare."))
    if lower == "mod":
        return syntax(now, N_("“mod” is between two values"), N_("Write MOD(x; y)."))
    if before.kind == "number" and lower in _TIMES:
        spelt = f"{before.text} {now.text}"
        advice: str = N_('Write "{spelt}" in quotes for Wait, and a number of seconds elsewhere.', spelt=spelt)
        return syntax(now, N_("there is a unit of time behind a number"), advice, quotes=True)
    if before.kind == "number" and lower in _UNITS:
        advice = N_("Leave the unit out: distances are in metres, angles in radians (30° is 30 degrees).")
        return syntax(now, N_("there is a unit behind a number"), advice)
    if before.kind == "number":
        advice = N_("Write {text} * {text2}.", text=before.text, text2=now.text)
        return syntax(now, N_("there is no sign between a number and a name"), advice)
    advice = N_("{between} A text needs quotes.", between=_BETWEEN)
    return syntax(now, N_("there is no sign before “{near}”", near=_near(now)), advice, quotes=True)


def _odd_sign(tokens: list[Token], i: int) -> FormulaProblem:
    before, now = tokens[i - 1], tokens[i]
    following = tokens[i + 1] if i + 1 < len(tokens) else now
    if now.text == "!" and before.kind in ("name", "text") and following.kind != "end":
        end = tokens[i + 2].end if following.text == "$" and i + 2 < len(tokens) else following.end
        remedy = N_("Write the name of one of the row's inputs, or of a table's column: Parts[Ask].")
        shown = f"{before.text}!{following.text}"
        return FormulaProblem("FORM018", before.start, end - before.start, cell=shown, remedy=remedy)
    if now.text == ":" and cell(before.text):
        return cell_reference(before.start, f"{before.text}:{following.text}")
    if now.text == "$" and before.kind == "name":
        return cell_reference(before.start, f"{before.text}${following.text}")
    if now.text in (")", "]"):
        return syntax(now, N_("an opening bracket is missing"), N_("Add the opening bracket, or take this one away."))
    if now.text == ":":
        return syntax(now, N_("there is a colon in it"), N_("Use colons only in brackets: balls[0:2]."))
    if now.text == ":=":
        return refused(now, N_("An assignment"), _SIGNS[":="])
    if now.text in _SIGNS:
        return refused(now, N_("The sign {text}", text=now.text), _SIGNS[now.text])
    return syntax(now, N_("“{text}” does not belong there", text=now.text), N_("Check this place."))


def _near(token: Token) -> str:
    text = token.text or N_("a text")
    return text if len(text) <= 20 else text[:19] + "…"


def refuse_setting(tree: ast.expr, typed: str) -> None:
    """Refuse a whole formula such as `x = 1`, with spaces: a spreadsheet compares there, and Python sets.

    Without the spaces, behind a leading `=`, and as a part of a formula it is a comparison, as in a spreadsheet.
    """
    if not isinstance(tree, ast.Compare) or len(tree.ops) != 1 or not isinstance(tree.ops[0], ast.Eq):
        return
    left, right = tree.left, tree.comparators[0]
    sign = typed[left.end_col_offset : right.col_offset]
    number = isinstance(right, ast.Constant) and type(right.value) in (int, float)
    settable = isinstance(left, (ast.Name, ast.Attribute, ast.Subscript))
    if settable and number and sign.strip() == "=" and sign != sign.strip() and not typed.lstrip().startswith("="):
        text = typed.strip()
        twice = text.replace("=", "==", 1)
        remedy = N_("To ask whether they are equal write {twice}, or ={text}.", twice=twice, text=text)
        raise FormulaProblem("FORM003", tree.col_offset, len(text), what=N_("Setting a value with ="), remedy=remedy)


# ---- names of other programs
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
    "eval": N_("A formula cannot contain another formula as a text. Write it in a helper."),
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
