"""The values that travel on streams: numbers, text, TRUE/FALSE, blank, lists of these, and payload records."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.model.names import key

Value = Any
"""None (blank), bool, int, float, str, list or tuple of values, Record, or (as an error) Failure."""


@dataclass(frozen=True)
class Field:
    """A field of a payload record: its name, kind (`number`, `text`, `truth`, `any`), unit, example and help.

    A number lies between `lower` and `upper`; a text is one of the `choices`, if there are any; `aliases`
    are further words for such texts, Japanese ones, by key. Two fields are equal
    whatever their examples are: a touch is a touch, of a hand or of a foot.
    """

    name: str
    kind: str = "any"
    unit: str = ""
    example: Value = field(default=None, compare=False)
    help: str = field(default="", compare=False)
    lower: float = field(default=-math.inf, compare=False)
    upper: float = field(default=math.inf, compare=False)
    choices: tuple[str, ...] = field(default=(), compare=False)
    aliases: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True)
class RecordType:
    """Definition of a kind of record: its fields, their further names, and their positions."""

    name: str  # shown in messages ("Red ball has no field “distence”")
    fields: tuple[Field, ...]  # in the order they are shown
    aliases: Mapping[str, str] = field(default_factory=dict)  # further names of fields, by key (`isnew` is `new`)
    positions: tuple[str, ...] = ()  # the fields that `[0]`, `[1]`, … mean; empty when the record has no positions
    # the key of a field by each key that may name it
    keys: Mapping[str, str] = field(init=False, compare=False, repr=False)
    names: Mapping[str, str] = field(init=False, compare=False, repr=False)  # the names of the fields by their keys

    def __post_init__(self) -> None:
        names = {key(f.name): f.name for f in self.fields}
        keys = {k: k for k in names} | {key(alias): key(name) for alias, name in self.aliases.items()}
        object.__setattr__(self, "keys", keys)
        object.__setattr__(self, "names", names)

    def field(self, name: str) -> Field | None:
        """Return the field of that name in any spelling, or None."""
        return next((f for f in self.fields if key(f.name) == self.keys.get(key(name))), None)

    def standard(self, name: str, value: Value) -> Value:
        """Return the text that a further word for it means in a field; any other value as it is."""
        found = self.field(name)
        return found.aliases.get(key(value), value) if found and isinstance(value, str) else value

    def make(self, /, **values: Value) -> Record:
        """A record of this type from values by the fields' names; fields that are not given are blank.

        >>> RecordType("Ball", (Field("x"), Field("is red"))).make(x=1)
        Ball(x=1, is red=None)
        """
        return Record(self, {k: values.get(name) for k, name in self.names.items()})

    def example(self) -> Record:
        """The record of the fields' examples."""
        return self.make(**{f.name: f.example for f in self.fields})


class Record:
    """A payload: named, read-only values, found by key, so `new`, `New` and `is_new` may be one field.

    Formulas reach the values only through :meth:`get`; there is no attribute to follow.
    """

    __slots__ = ("type", "values")

    def __init__(self, type: RecordType, values: dict[str, Value]) -> None:
        self.type = type
        self.values = values

    def get(self, name: str | int) -> Value:
        """The field of that name (or position); raises KeyError when there is none."""
        if isinstance(name, int):
            if not -len(self.type.positions) <= name < len(self.type.positions):
                raise KeyError(name)
            return self.values[self.type.positions[name]]
        k = key(name)
        return self.values[self.type.keys.get(k, k)]

    def as_dict(self) -> dict[str, Value]:
        """The values by the fields' shown names."""
        return {name: self.values[k] for k, name in self.type.names.items()}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self.values == other.values

    __hash__ = None  # type: ignore[assignment]  # a record may hold lists

    def __repr__(self) -> str:
        return f"{self.type.name}({', '.join(f'{n}={v!r}' for n, v in self.as_dict().items())})"


def record_from_mapping(name: str, mapping: Mapping[str, Value]) -> Record:
    """A record with exactly the fields of a mapping, for values that come from JSON or from a test."""
    kind = RecordType(name, tuple(Field(n, example=v) for n, v in mapping.items()))
    return Record(kind, {key(n): v for n, v in mapping.items()})


@dataclass(frozen=True, slots=True)
class Failure:
    """A formula's error as a value: it never travels to another row."""

    code: str  # the diagnostic's code, such as `FORM101`
    message: str  # in the user's words
    column: int = -1  # where in the formula, counted from 0; -1 when not known


def as_stream_value(value: Value) -> Value:
    """The value as it may enter a stream: numpy scalars and arrays become plain numbers and lists.

    >>> as_stream_value((1, 2.5))
    (1, 2.5)
    """
    if value is None or type(value) in (bool, int, float, str, Record):
        return value
    if isinstance(value, list):
        return [as_stream_value(v) for v in value]
    if isinstance(value, tuple):
        return tuple(as_stream_value(v) for v in value)
    if hasattr(value, "tolist"):
        return as_stream_value(value.tolist())
    raise TypeError(f"{type(value).__name__} cannot travel on a stream")


def identity(value: Value) -> Hashable:
    """Return a hashable that is the same for equal values only: TRUE is not 1, 1 is 1.0, records count by fields.

    >>> identity([1, "a"]) == identity((1.0, "a")), identity(True) == identity(1)
    (True, False)
    """
    if isinstance(value, bool):
        return (bool, value)
    if isinstance(value, Record):
        return (Record, tuple(sorted((k, identity(v)) for k, v in value.values.items())))
    if isinstance(value, (list, tuple)):
        return (list, tuple(identity(v) for v in value))
    return value if value is None or isinstance(value, (int, float, str)) else (type(value), id(value))


def to_json(value: Value) -> Any:
    """The value as JSON knows it: records become objects, tuples lists."""
    if isinstance(value, Record):
        return {name: to_json(v) for name, v in value.as_dict().items()}
    if isinstance(value, (list, tuple)):
        return [to_json(v) for v in value]
    return value


def show(value: Value, longest: int = 160) -> str:
    """The value in short, as a person reads it.

    >>> show(0.123456), show(None), show("hi"), show([1, True])
    ('0.123', 'blank', '“hi”', '(1, TRUE)')
    """
    text = _show(value)
    return text if len(text) <= longest else text[: longest - 1] + "…"


def _show(value: Value) -> str:
    if value is None:
        return "blank"
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, str):
        return f"“{value}”"
    if isinstance(value, (list, tuple)):
        return f"({', '.join(_show(v) for v in value)})"
    if isinstance(value, Record):
        fields = (f"{n} {_show(v)}" for n, v in value.as_dict().items() if v is not None)
        return f"{value.type.name} ({', '.join(fields)})"
    return str(value)
