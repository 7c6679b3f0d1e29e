"""What the rows and streams had in a piece of a run, in words as the run panel shows them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from rrp_sheets.devices import Robot
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, RecordType, Value
from rrp_sheets.runs.formatting import told
from rrp_sheets.runs.lookback.index import Entry, Index
from rrp_sheets.runs.marbles import value_from_json

_LONGEST_ERROR = 200  # letters
_SEEN = ("x", "y", "width", "height", "distance")  # of what a sensor sees: where the camera's picture shows it
_MOST_NAME = 60  # letters


def names_of(kinds: Mapping[str, str]) -> dict[str, str]:
    """The streams' names as the run panel has them: without their sheet, where that can be told apart.

    >>> names_of({"Red ball": "sensor", "A!Far": "stream", "B!Near": "stream", "C!Near": "stream", "A!#4": "anonymous"})
    {'Red ball': 'Red ball', 'A!Far': 'Far', 'B!Near': 'B!Near', 'C!Near': 'C!Near', 'A!#4': 'A!#4'}
    """
    plain = Counter(label.partition("!")[2] or label for label in kinds)
    found = {}
    for label in kinds:
        _, _, name = label.partition("!")
        found[label] = name if name and name[0] != "#" and plain[name] == 1 else label
    return found


class Words:
    """Puts the values of a trace into words.

    Args:
        robot: whose sensors give records.
        units: of what rows give, by their refs.
    """

    def __init__(self, robot: Robot, units: Mapping[str, str]) -> None:
        self._units = units
        self._types: dict[tuple[str, ...], RecordType] = {_fields(DONE): DONE}
        for device in robot.devices.values():
            if device.payload is not None:
                self._types.setdefault(_fields(device.payload), device.payload)

    def told(self, stream: str, row: str, value: Any) -> str:
        """A value of a row, or of a sensor (then without a row)."""
        return told(self._value(stream, value), self._units.get(row, ""))

    def _value(self, stream: str, value: Any) -> Value:
        """A record is known by its fields: the trace keeps no other word of what it is."""
        kind = self._types.get(tuple(value)) if isinstance(value, dict) else None
        if kind is None:
            return value_from_json(stream, value)
        return Record(kind, {key(n): value_from_json(stream, v) for n, v in value.items()})


def _fields(kind: RecordType) -> tuple[str, ...]:
    return tuple(f.name for f in kind.fields)


def piece(index: Index, number: int, words: Words) -> dict[str, Any]:
    """A piece of a run as JSON: of each series the times, what was told then (places in `words`), and what was seen."""
    numbers, before = index.piece(number)
    series: dict[int, dict[str, list[Any]]] = {}
    table: dict[str, int] = {}
    wanted = [n for n in before if n >= 0] + list(numbers)
    for event, entry in index.read(wanted):
        of = index.of[event]
        told_series = series.setdefault(of, {"t": [], "v": []})
        text = _text(index, of, entry, words)
        told_series["t"].append(index.times[event])
        told_series["v"].append(table.setdefault(text, len(table)))
        seen = _seen(entry.get("value")) if not index.series[of].row else None  # what a sensor gave, no command
        if seen is not None:
            told_series.setdefault("s", [None] * (len(told_series["t"]) - 1)).append(seen)
        elif "s" in told_series:
            told_series["s"].append(None)
    return {"words": list(table), "series": series}


def _text(index: Index, of: int, entry: Entry, words: Words) -> str:
    named = index.series[of]
    if not named.stream:
        return str(entry.get("error") or entry.get("text") or "")[:_LONGEST_ERROR]
    return words.told(named.stream, named.row, entry.get("value"))


def _seen(value: Any) -> list[Any] | None:
    """Where in the picture something was: its angles (rad), how far it was (m), its name."""
    if not isinstance(value, dict) or not all(_is_number(value.get(n)) for n in ("x", "y")):
        return None
    numbers = [round(float(value[n]), 4) if _is_number(value.get(n)) else None for n in _SEEN]
    name = value.get("name")
    return [*numbers, name[:_MOST_NAME] if isinstance(name, str) else ""]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e6
