"""One key for every name, the name a stream has inside formulas, and the nearest name to an unknown one."""

from __future__ import annotations

import difflib
import keyword
import re
import unicodedata
from collections.abc import Collection, Iterable
from functools import lru_cache

OPERATOR_WORDS = frozenset(("if", "else", "and", "or", "not", "in", "is", "for"))
_CONSTANTS = frozenset(("true", "false", "none", "blank"))  # what these mean in a formula
_LIKE = 0.66  # how like what was meant must be, as difflib measures it
_LONGEST = 60  # letters of a name in which typing errors are counted
_JOINERS = re.compile(r"[\s_\-\u00a0\u2010-\u2015]+")


@lru_cache(maxsize=65536)
def key(name: str) -> str:
    """The key under which a name is looked up: NFKC, case-folded, without spaces, underscores and hyphens.

    >>> key("Red ball") == key("RedBall") == key("red_ball") == "redball"
    True
    """
    return _JOINERS.sub("", unicodedata.normalize("NFKC", name).casefold())


@lru_cache(maxsize=65536)
def argument_name(name: str) -> str:
    """The name a stream has inside a formula: camelCase, as in the thesis.

    Characters that cannot stand in a name are dropped; a leading digit and Python's keywords get an `s` before
    them. Any spelling with the same key is accepted too.

    >>> argument_name("Red ball"), argument_name("2nd ball"), argument_name("from"), argument_name("赤いボール")
    ('redBall', 's2ndBall', 'sFrom', '赤いボール')
    """
    words = [w for w in _JOINERS.split(unicodedata.normalize("NFKC", name)) if w]
    words = ["".join(c for c in w if ("a" + c).isidentifier()) for w in words]
    words = [w for w in words if w]
    if not words:
        return ""
    first, rest = words[0], [w[:1].upper() + w[1:] for w in words[1:]]
    first = first.lower() if first.isupper() else first[:1].lower() + first[1:]
    joined = first + "".join(rest)
    if keyword.iskeyword(joined) or joined.casefold() in _CONSTANTS or not joined.isidentifier():
        joined = "s" + joined[:1].upper() + joined[1:]
    return joined


def is_reserved(name: str) -> bool:
    """Return whether formulas read a name as an operator or a constant, so that it cannot name a stream.

    >>> is_reserved("In"), is_reserved("TRUE"), is_reserved("Inside")
    (True, True, False)
    """
    return key(name) in OPERATOR_WORDS | _CONSTANTS


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """The candidate that the user most likely meant by `name`, or None: few letters differ, at most one in three.

    >>> nearest("Distence", ["Distance", "Red ball"]), nearest("Start", ["Sonar"])
    ('Distance', None)
    """
    by_key = {key(c): c for c in candidates}
    wanted = key(name)
    matcher = difflib.SequenceMatcher()
    matcher.set_seq2(wanted)
    letters, best, found = frozenset(wanted), 0.0, None
    for k in sorted(by_key, reverse=True):  # of two that are as near the first is taken, as difflib does
        # no ratio is above that of the letters which both have: most candidates need not be compared any further
        most, both = min(len(wanted), sum(map(letters.__contains__, k))), len(wanted) + len(k)
        bound = 2.0 * most / both if both else 1.0
        if bound < _LIKE or bound <= best:
            continue
        matcher.set_seq1(k)
        bound = matcher.quick_ratio()
        if bound < _LIKE or bound <= best:
            continue
        ratio = matcher.ratio()
        if ratio >= _LIKE and ratio > best and is_near(wanted, k):
            best, found = ratio, k
    return None if found is None else by_key[found]


def is_near(first: str, second: str) -> bool:
    """Return whether one of two names may be the other one with typing errors: at most one in three letters.

    >>> is_near("Tekst", "Text"), is_near("wave", "Walk"), is_near("start", "Sonar")
    (True, False, False)
    """
    most = max(1, (max(len(key(first)), len(key(second))) + 1) // 3)
    return count_typos(first, second, most) <= most


def count_typos(first: str, second: str, most: int = _LONGEST) -> int:
    """Count the typing errors between two names: letters missing, added, wrong, or in the wrong order.

    Beyond `most` they are not counted exactly, which is quicker for names that are not alike.

    >>> count_typos("Red bal", "red_ball"), count_typos("SQTR", "SQRT"), count_typos("Touch", "Say", most=2) > 2
    (1, 1, True)
    """
    a, b = key(first)[:_LONGEST], key(second)[:_LONGEST]
    apart = max(abs(len(a) - len(b)), len(b) - sum(map(frozenset(a).__contains__, b)))
    if apart > most:
        return apart
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        older, before, row = before, row, [i]
        for j, y in enumerate(b, 1):
            row.append(min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y)))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                row[j] = min(row[j], older[j - 2] + 1)
        if min(row) > most and min(before) > most:
            return most + 1
    return row[-1]


class Proposals:
    """`nearest` for one check: where very many names are unknown in a large workbook, only the first are looked for.

    >>> propose = Proposals(2); propose("Balk", ["Ball"]), propose("Balk", ["Ball", "Tie"]), propose("Balk", ["Ball"])
    ('Ball', 'Ball', None)
    """

    def __init__(self, most: int = 200_000) -> None:
        self._left = most  # candidates that are still compared

    def __call__(self, name: str, candidates: Collection[str]) -> str | None:
        """As `nearest`; None when too much was looked for before."""
        if self._left <= 0:
            return None
        self._left -= len(candidates)
        return nearest(name, candidates)


def names_in(text: str) -> list[str]:
    """Return the names of streams in a cell."""
    return [n.strip() for n in text.replace("\n", ",").split(",") if n.strip()]
