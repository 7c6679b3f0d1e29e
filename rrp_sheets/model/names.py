"""One key for every name, and the name a stream has inside formulas (design: 2-workbook, 3-formulas)."""

from __future__ import annotations

import difflib
import keyword
import re
import unicodedata
from collections.abc import Iterable
from functools import lru_cache

_CONSTANTS = ("true", "false", "none", "blank")  # what these mean in a formula
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


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """The candidate that the user most likely meant by `name`, or None.

    >>> nearest("Distence", ["Distance", "Red ball"])
    'Distance'
    """
    by_key = {key(c): c for c in candidates}
    close = difflib.get_close_matches(key(name), list(by_key), n=1, cutoff=0.6)
    return by_key[close[0]] if close else None
