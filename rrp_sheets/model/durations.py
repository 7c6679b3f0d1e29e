"""Durations as people type them: `1000`, `1 s`, `500 ms`, `10 min`, `4 h`."""

from __future__ import annotations

import re
import unicodedata

_UNITS = {
    "": 1_000, "ms": 1_000, "msec": 1_000, "millisecond": 1_000, "milliseconds": 1_000,
    "s": 1_000_000, "sec": 1_000_000, "secs": 1_000_000, "second": 1_000_000, "seconds": 1_000_000,
    "min": 60_000_000, "mins": 60_000_000, "minute": 60_000_000, "minutes": 60_000_000,
    "ミリ秒": 1_000, "秒": 1_000_000, "分": 60_000_000, "分間": 60_000_000, "秒間": 1_000_000, "時間": 3_600_000_000,
    "h": 3_600_000_000, "hour": 3_600_000_000, "hours": 3_600_000_000,
}  # fmt: skip
_DURATION = re.compile(r"\s*(\d+(?:\.\d+)?|\.\d+)\s*([a-z]*|ミリ秒|秒間?|分間?|時間)\.?\s*", re.ASCII)
_BEGINNINGS = {"ms": "ms", "mil": "ms", "m": "min", "s": "s", "h": "h"}  # of foreign and misspelt units
LONGEST_US = 31 * 24 * 3_600_000_000  # a month: longer is surely a typing mistake


def parse_duration(text: str, bare: str = "ms") -> int | None:
    """A duration in whole microseconds, or None when the text is not one; a number alone is in the unit `bare`.

    >>> parse_duration("1000"), parse_duration("1 s"), parse_duration("0.5", bare="s"), parse_duration("soon")
    (1000000, 1000000, 500000, None)
    >>> parse_duration("２秒"), parse_duration("500 ミリ秒"), parse_duration("10分")
    (2000000, 500000, 600000000)
    """
    match = _DURATION.fullmatch(unicodedata.normalize("NFKC", text).casefold())
    if not match or match[2] not in _UNITS:
        return None
    us = float(match[1]) * _UNITS[match[2] or bare]
    return round(us) if us <= LONGEST_US else None


def meant_duration(text: str, bare: str = "ms") -> str:
    """A duration that the user most likely meant by a text that is none; empty when there is no telling.

    >>> meant_duration("1,5 s"), meant_duration("10 sek"), meant_duration("soon")
    ('1.5 s', '10 s', '')
    """
    match = re.fullmatch(r"\s*(\d+(?:[.,]\d+)?)\s*([^\W\d]*)\.?\s*", unicodedata.normalize("NFKC", text))
    if not match:
        return ""
    typed = match[2].casefold()
    unit = next((u for first, u in _BEGINNINGS.items() if typed.startswith(first)), "")
    meant = f"{match[1].replace(',', '.')} {unit}".strip()
    return meant if (unit or not typed) and parse_duration(meant, bare) else ""


def show_duration(us: int) -> str:
    """A duration in the largest unit that keeps it short.

    >>> show_duration(500_000), show_duration(2_000_000), show_duration(90_000_000), show_duration(60_000_000)
    ('500 ms', '2 s', '90 s', '1 min')
    """
    if us < 1_000_000:
        return f"{us / 1_000:g} ms"
    if us % 60_000_000 == 0:
        return f"{us // 60_000_000} min"
    return f"{us / 1_000_000:g} s"
