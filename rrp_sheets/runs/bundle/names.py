"""Which names a file of a bundle may have, on every system."""

from __future__ import annotations

import unicodedata

_MOST_PARTS, _MOST_BYTES = 6, 200
_FORBIDDEN = frozenset('\\:*?"<>|')
_TAKEN = frozenset(
    ("con", "prn", "aux", "nul", *(f"com{n}" for n in range(1, 10)), *(f"lpt{n}" for n in range(1, 10)))
)  # names that Windows keeps for itself


def is_safe(name: str) -> bool:
    r"""Whether a name stays in the folder where it is unpacked, and can be written on every system.

    >>> [is_safe(n) for n in ("a.xlsx", "runs/1/trace.jsonl", "赤い ボール.xlsx")]
    [True, True, True]
    >>> [is_safe(n) for n in ("../a", "/a", "a//b", "a\\b", "C:a", "a/./b", "", "a\nb", "nul.txt", "a. ", "\u202ea")]
    [False, False, False, False, False, False, False, False, False, False, False]
    """
    parts = name.split("/")
    return len(parts) <= _MOST_PARTS and all(map(_is_safe_part, parts))


def _is_safe_part(part: str) -> bool:
    if part in ("", ".", "..") or part[-1] in ". " or part.partition(".")[0].casefold() in _TAKEN:
        return False
    if any(c in _FORBIDDEN or unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") for c in part):
        return False
    return len(part.encode("utf-8", "surrogatepass")) <= _MOST_BYTES
