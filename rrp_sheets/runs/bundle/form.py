"""Layout of a bundle: the names of its parts, its limits, and the check of file names.

Unpacked by hand it is a folder to work in: sounds, robot and runs beside the workbook.
"""

from __future__ import annotations

import unicodedata

SUFFIX = ".zip"
LIST = "versions.json"
README = "README.txt"
PAPER = "protocol.pdf"
RUNS = "runs"
ROBOTS = "robots"
KIND = "rrp-sheets bundle"
SCHEMA = 1  # grows when an entry of the list changes its meaning or goes
MOST_FILES = 2_000
MOST_BYTES = 2_000_000_000


_MOST_PARTS, _MOST_BYTES = 6, 200
_FORBIDDEN = frozenset('\\:*?"<>|')
_TAKEN = frozenset((
    "con", "prn", "aux", "nul", "conin$", "conout$",
    *(f"{port}{n}" for port in ("com", "lpt") for n in "0123456789¹²³"),
))  # fmt: skip
"""Names of devices, which Windows takes for these whatever ending stands behind them."""


def is_safe(name: str) -> bool:
    r"""Return whether a name stays in the folder where it is unpacked, and can be written on every system.

    >>> [is_safe(n) for n in ("a.xlsx", "runs/1/trace.jsonl", "赤い ボール.xlsx")]
    [True, True, True]
    >>> [is_safe(n) for n in ("NUL", "runs/CON/x", "aux .txt", "COM¹.csv", "lpt1.tar.gz", "a./b", "a /b", "a:b")]
    [False, False, False, False, False, False, False, False]
    >>> [is_safe(n) for n in ("../a", "/a", "a//b", "a\\b", "C:a", "a/./b", "", "a\nb", "nul.txt", "a. ", "\u202ea")]
    [False, False, False, False, False, False, False, False, False, False, False]
    """
    parts = name.split("/")
    return len(parts) <= _MOST_PARTS and all(map(_is_safe_part, parts))


def is_device(name: str) -> bool:
    """Return whether Windows takes a file's name for one of its devices.

    >>> is_device("nul.xlsx"), is_device("null.xlsx")
    (True, False)
    """
    return name.partition(".")[0].rstrip().casefold() in _TAKEN


def _is_safe_part(part: str) -> bool:
    if part in ("", ".", "..") or part[-1] in ". " or is_device(part):
        return False
    if any(c in _FORBIDDEN or unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") for c in part):
        return False
    return len(part.encode("utf-8", "surrogatepass")) <= _MOST_BYTES
