"""Texts of values on marbles: cut to the letters that fit, except for numbers, which are never cut."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.render.measure import clean, columns

_FEW = 4
_LONGEST = 120  # letters; more stand on no marble


def labels(value: Value) -> Iterator[str]:
    """Yield a value in words, from the longest form to the shortest that is still useful.

    >>> list(labels(0.98632)), list(labels(None)), list(labels(True))
    (['0.986', '0.99', '1'], ['blank', '–'], ['TRUE'])
    """
    if value is None:
        yield from ("blank", "–")
    elif isinstance(value, bool):
        yield show(value)
    elif isinstance(value, (int, float)):
        whole = isinstance(value, float) and 1_000 <= abs(value) < 1_000_000
        yield from dict.fromkeys((f"{value:.0f}",) if whole else (show(value), f"{value:.2g}", f"{value:.1g}"))
    elif isinstance(value, Record):
        yield from _fields(value)
    elif isinstance(value, str):
        yield clean(value[:_LONGEST])
    else:
        yield clean(show(value, _LONGEST))


def _fields(record: Record) -> Iterator[str]:
    """Yield the fields of a record that are filled: all of them, then fewer."""
    if record.type.name == "Done":
        done = short(record.values.get("value")) if record.values.get("value") is not None else "done"
        yield done if record.values.get("completed") is not False else f"stopped: {done}"
        return
    told = [(n, v) for n, v in record.as_dict().items() if v not in (None, "")]
    if len(told) <= _FEW:  # of few fields the texts say most: the zone of a touch, a word
        told.sort(key=lambda item: not isinstance(item[1], str))
    parts = [short(v) if isinstance(v, str) else f"{clean(n)} {short(v)}" for n, v in told]
    for count in range(len(parts), 0, -1):
        yield ", ".join(parts[:count])[:_LONGEST]


def short(value: Value) -> str:
    r"""Return a value as it stands on a marble that has room.

    >>> short(0.123456), short(None), short("Hello\n you"), short(True)
    ('0.123', 'blank', 'Hello you', 'TRUE')
    """
    return next(labels(value), "")


def fitting(value: Value, room: float, measure: Callable[[str], float] = columns, least: float = 4) -> str:
    """Return the value as far as it fits into `room`; a text may be cut; empty when nothing useful would be left.

    >>> fitting("Can you touch my hand?", 9), fitting(0.98632, 4), fitting("Hello", 2)
    ('Can you…', '0.99', '')
    """
    for words in labels(value):
        if measure(words) <= room:
            return words
    if isinstance(value, Record):
        value = next((v for v in value.values.values() if isinstance(v, str) and v), None)
    if not isinstance(value, (str, list, tuple)) or room < least:
        return ""
    return cut(short(value), room, measure)


def cut(words: str, room: float, measure: Callable[[str], float] = columns) -> str:
    """Return a text cut so that it fits with a `…`; empty when nothing of it would be left."""
    if measure(words) <= room:
        return words
    while words and measure(words + "…") > room:
        words = words[:-1]
    return words.rstrip() + "…" if words.strip() else ""
