"""Numbers of the Scene sheet: lengths, times, shares, angles, places; each may be a range such as `0.4..0.6`."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.scene_actions import RandomRange

Amount = float | RandomRange
METRES: Mapping[str, float] = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001}
RADIANS: Mapping[str, float] = {
    "°": math.pi / 180, "deg": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180, "rad": 1.0,
}  # fmt: skip
SHARES: Mapping[str, float] = {"%": 0.01, "": 1.0}
"""A number alone is at most 1: a spreadsheet makes 0.4 of 40 % that is typed as a number."""
_NUMBER = r"[-+]?(?:[0-9]+(?:\.(?!\.)[0-9]*)?|\.[0-9]+)"
_ONE = re.compile(rf"(?P<low>{_NUMBER})(?:\.\.(?P<high>{_NUMBER}))?(?:\s*(?P<unit>[^\W\d_]+|%|°))?")
_GAP = re.compile(r"\s*[,;]\s*|\s+|$")
_DOTS = re.compile(r"\s*(?:\.{2,3}|…|‥)\s*")
_TIMES = re.compile(r"\s*[x×*]\s*", re.IGNORECASE)
_LETTER = re.compile(r"[^\W\d_]")


class BadValueError(Exception):
    """A cell cannot be understood. Its text says what to do; empty where only an example helps."""


def plain(text: str) -> str:
    """A text with its minus signs and dots as they are typed without help.

    >>> plain("at \N{MINUS SIGN}1 … 1, 0")
    'at -1..1, 0'
    """
    return _DOTS.sub("..", text.replace("\N{MINUS SIGN}", "-")).strip(" ,;\n\t")


def ends(amount: Amount) -> tuple[float, float]:
    """The least and the most that an amount can be.

    >>> ends(0.5), ends(RandomRange(0.4, 0.6))
    ((0.5, 0.5), (0.4, 0.6))
    """
    return (amount.low, amount.high) if isinstance(amount, RandomRange) else (amount, amount)


def between(low: float, high: float) -> Amount:
    """A number, or a range when both ends differ, whichever is given first.

    >>> between(2.0, 1.0), between(1.0, 1.0)
    (RandomRange(low=1.0, high=2.0), 1.0)
    """
    return low if low == high else RandomRange(min(low, high), max(low, high))


def one(text: str, units: Mapping[str, float], least: float, most: float, unit: str) -> Amount:
    """A number with its unit, in the unit whose factor is 1.

    >>> one("5..10 cm", METRES, 0.01, 1, "m")
    RandomRange(low=0.05, high=0.1)

    Raises:
        BadValueError: it is none, or beyond its limits (whose name is `unit`).
    """
    match = _ONE.fullmatch(_folded(text))
    if not match:
        raise BadValueError
    return _within(_scaled(match, match["unit"] or "", units), least, most, unit)


def many(text: str, least: float, most: float) -> tuple[Amount, ...]:
    """Lengths with a cross between them; a unit at the end is that of all.

    >>> many("60 x 40 cm", 0.1, 1)
    (0.6, 0.4)

    Raises:
        BadValueError: they are none, or beyond their limits (m).
    """
    matches = [_ONE.fullmatch(piece) for piece in _TIMES.split(_folded(text))]
    found = [m for m in matches if m is not None]
    if len(found) < len(matches):
        raise BadValueError
    return tuple(_within(_scaled(m, m["unit"] or found[-1]["unit"] or "", METRES), least, most, "m") for m in found)


def place(text: str, least: int, most: int, farthest: float) -> tuple[Amount, ...]:
    """A position in m: so many numbers, with commas or blanks between them.

    >>> place("(1, 0.4..0.6 20 cm)", 3, 3, 20)
    (1.0, RandomRange(low=0.4, high=0.6), 0.2)

    Raises:
        BadValueError: it is none, or farther away than `farthest` m.
    """
    rest, numbers = _folded(text).removeprefix("(").removesuffix(")").strip(), list[Amount]()
    while rest:
        match = _ONE.match(rest)
        # of “1, 0 5”, “1 m” and “1 m, 0” the unit is what stands before the gap
        gap = _GAP.match(rest, match.end()) if match else None
        if match is None or gap is None:
            raise BadValueError
        numbers.append(_within(_scaled(match, match["unit"] or "", METRES), -farthest, farthest, "m"))
        rest = rest[gap.end() :]
    if not least <= len(numbers) <= most:
        raise BadValueError
    return tuple(numbers)


def span(text: str) -> tuple[int, int] | None:
    """A time, or a range of times, in microseconds; a number alone is in seconds. None when it is none.

    >>> span("2 s"), span("500..700 ms"), span("1..2"), span("soon")
    ((2000000, 2000000), (500000, 700000), (1000000, 2000000), None)
    """
    first, dots, last = (part.strip() for part in text.partition(".."))
    if not dots:
        us = parse_duration(first, bare="s")
        return None if us is None else (us, us)
    if not _LETTER.search(first):
        unit = _LETTER.search(last)
        first += last[unit.start() :] if unit else ""
    low, high = parse_duration(first, bare="s"), parse_duration(last, bare="s")
    return None if low is None or high is None else (min(low, high), max(low, high))


def seconds(text: str, least: float, most: float) -> Amount:
    """A time in seconds.

    Raises:
        BadValueError: it is none, or beyond its limits (s).
    """
    us = span(text)
    if us is None:
        raise BadValueError
    return _within(between(us[0] / 1e6, us[1] / 1e6), least, most, "s")


def _folded(text: str) -> str:
    """Full-width digits and signs are digits and signs."""
    return unicodedata.normalize("NFKC", text).strip()


def _scaled(match: re.Match[str], unit: str, units: Mapping[str, float]) -> Amount:
    factor = units.get(unit.casefold())
    if factor is None or len(match["low"]) > 20 or len(match["high"] or "") > 20:
        raise BadValueError
    low = float(match["low"])
    high = low if match["high"] is None else float(match["high"])
    return between(round(low * factor, 9) + 0.0, round(high * factor, 9) + 0.0)


def _within(amount: Amount, least: float, most: float, unit: str) -> Amount:
    low, high = ends(amount)
    if not (least <= low and high <= most):
        scale = 100 if unit == "%" else 1
        raise BadValueError(
            Phrase("Write from {value:g} to {value2:g} {unit}.", value=least * scale, value2=most * scale, unit=unit)
        )
    return amount
