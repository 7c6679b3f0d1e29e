"""Functions that people know from elsewhere, and what to write here instead."""

from __future__ import annotations

from rrp_sheets.diagnostics.phrase import Phrase

AMBIGUOUS = {  # where spreadsheets and Python disagree: never guess
    "log": "Write LN(…) for the natural logarithm, or LOG10(…).",
    "atan2": "Write ANGLE(x; y): the direction of a point, x ahead and y to the left.",
}
"""By key: names that mean different things, with the remedy."""

_INSTEAD = {
    "vlookup": "XLOOKUP(what; Table[Column]; Table)", "hlookup": "XLOOKUP(what; Table[Column]; Table)",
    "lookup": "XLOOKUP(what; Table[Column]; Table)", "ifna": "IFERROR(value; otherwise)",
    "rand": "PICK([1; 2; 3])", "randbetween": "PICK([1; 2; 3])", "random": "PICK([1; 2; 3])", "choice": "PICK(list)",
    "randint": "PICK([1; 2; 3])", "choose": "INDEX([first; second]; place)", "filter": "[x for x in list if x > 0]",
    "map": "[x * 2 for x in list]", "print": "the text alone", "format": 'f"{distance:.1f}"',
    "isnull": "ISBLANK(value)", "isempty": "ISBLANK(value)", "isnone": "ISBLANK(value)", "isna": "ISERROR(value)",
    "float": "VALUE(text)", "tonumber": "VALUE(text)", "tostring": "STR(number)", "length": "LEN(text)",
    "replace": "SUBSTITUTE(text; old; new)", "split": "TEXTSPLIT(text; between)", "contains": '"ball" in text',
    "indexof": "FIND(what; text)", "strip": "TRIM(text)", "capitalize": "PROPER(text)", "factorial": "PRODUCT(1; 2; 3)",
    "square": "x^2", "sqr": "SQRT(x) for the root, or x^2", "cbrt": "x^(1/3)", "norm": "HYPOT(x; y)",
    "dist": "DISTANCE(x1; y1; x2; y2)", "limit": "CLAMP(value; low; high)", "clip": "CLAMP(value; low; high)",
    "bool": "value <> 0", "columns": "the number of columns", "indirect": "the stream's name",
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
    "repr": "Write STR(…) for a number as a text.",
    "eval": "A formula cannot hold another one as a text: write it into a helper.",
    "zip": "Use a table, or INDEX with a place.",
}
_NAMES = {
    "null": "BLANK", "nil": "BLANK", "undefined": "BLANK", "empty": "BLANK", "nothing": "BLANK", "wahr": "TRUE",
    "falsch": "FALSE", "vrai": "TRUE", "faux": "FALSE", "yes": "TRUE", "on": "TRUE", "off": "FALSE", "π": "pi",
}  # fmt: skip


def function_here(name: str) -> str | None:
    """What to do instead of calling a function that is not here, or None when nothing is known.

    >>> function_here("wenn"), function_here("vlookup")
    ('Write IF: functions have their English names.', 'Write XLOOKUP(what; Table[Column]; Table).')
    """
    if name in _GERMAN_FRENCH:
        return Phrase("Write {value}: functions have their English names.", value=_GERMAN_FRENCH[name])
    if name in _INSTEAD:
        return Phrase("Write {usage}.", usage=_INSTEAD[name])
    if name in _CLOCK:
        return "Use the connector timestamp: it gives the time with every event."
    return _REFUSED.get(name)


def name_here(name: str) -> str | None:
    """What to write instead of a name that means something elsewhere.

    >>> name_here("null")
    'Write BLANK.'
    """
    return Phrase("Write {value}.", value=_NAMES[name]) if name in _NAMES else None
