"""Facts about streams before the run: an example, bounds and possible values, and how often they come."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from rrp_sheets.formulas.problems import kind_of_value
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field, Record, RecordType, Value
from rrp_sheets.robots import Robot

MOST_CHOICES = 100
NUMBER, TEXT, TRUTH, LIST, RECORD, BLANK, ANY = "number", "text", "truth", "list", "record", "blank", "any"


@dataclass(frozen=True, slots=True)
class AbstractValue:
    """Knowledge about a value before the run.

    Attributes:
        kind: `number`, `text`, `truth`, `list`, `record`, `blank`, or `any` when that is not known. A value of another
            kind than `any` and `blank` may be blank besides, when `blank` says so.
        record: the type of a record.
        fields: what is known about a record's fields, by key, where it is more than their type says.
        low, high: bounds of a number; infinite when not known.
        choices: all the values that it can have; None when there are too many, or when they are not known.
        unit: of a number.
        blank: whether it may be blank.
        members: of a list that is written out: what is known about each place.
    """

    kind: str = ANY
    record: RecordType | None = None
    fields: Mapping[str, AbstractValue] = field(default_factory=dict)
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[Value, ...] | None = None
    unit: str = ""
    blank: bool = False
    members: tuple[AbstractValue, ...] = ()

    @property
    def bounded(self) -> bool:
        """True for a number that has bounds on both sides."""
        return self.kind == NUMBER and math.isfinite(self.low) and math.isfinite(self.high)

    def at(self, name: str) -> AbstractValue:
        """Return what is known about a field."""
        if self.record is None:
            return UNKNOWN
        k = self.record.keys.get(key(name), "")
        if k in self.fields:
            return self.fields[k]
        if self.choices is not None:
            return one_of(c.values.get(k) for c in self.choices if isinstance(c, Record))
        found = next((f for f in self.record.fields if key(f.name) == k), None)
        return UNKNOWN if found is None else of_field(found)


UNKNOWN = AbstractValue()


def of_field(f: Field) -> AbstractValue:
    """Return what a record type says about one of its fields."""
    if isinstance(f.example, Record):
        return AbstractValue(RECORD, f.example.type)
    if f.choices:
        return one_of(f.choices)
    if f.kind == NUMBER:
        return AbstractValue(NUMBER, low=f.lower, high=f.upper, unit=f.unit)
    return AbstractValue(f.kind, unit=f.unit) if f.kind in (TEXT, TRUTH) else UNKNOWN


def exactly(value: Value) -> AbstractValue:
    """Return the abstract value of a single known value.

    >>> exactly(3).low, exactly("red").choices
    (3.0, ('red',))
    """
    known = kind_of_value(value)
    if known == NUMBER:
        return AbstractValue(known, low=float(value), high=float(value), choices=(value,))
    record = value.type if isinstance(value, Record) else None
    return AbstractValue(known, record, choices=(value,), blank=value is None)


def number_within(low: float, high: float, unit: str = "") -> AbstractValue:
    """Return an abstract number within bounds; a bound that is NaN (∞ - ∞) counts as none.

    >>> number_within(0, 1).bounded, number_within(2, 2).choices, number_within(float("nan"), 1).low
    (True, (2,), -inf)
    """
    low = -math.inf if math.isnan(low) else low
    high = math.inf if math.isnan(high) else high
    choices = (low,) if low == high and math.isfinite(low) else None
    return AbstractValue(NUMBER, low=low, high=high, choices=choices, unit=unit)


def one_of(values: Iterable[Value]) -> AbstractValue:
    """Return the abstract value that covers all of these values."""
    result: AbstractValue | None = None
    for value in values:
        known = exactly(value)
        result = known if result is None else either(result, known)
    return UNKNOWN if result is None else result


def either(first: AbstractValue, second: AbstractValue) -> AbstractValue:
    """Return the abstract value that covers both.

    >>> either(exactly(1), exactly(3)).high, either(exactly(1), exactly("a")).kind
    (3.0, 'any')
    """
    choices = None
    if first.choices is not None and second.choices is not None:
        more = [c for c in second.choices if not any(type(c) is type(o) and c == o for o in first.choices)]
        choices = (*first.choices, *more) if len(first.choices) + len(more) <= MOST_CHOICES else None
    if BLANK in (first.kind, second.kind):
        other = second if first.kind == BLANK else first
        return replace(other, choices=choices, blank=True)
    blank = first.blank or second.blank
    if first.kind != second.kind:
        return AbstractValue(choices=choices, blank=blank)
    unit = first.unit if first.unit == second.unit else first.unit or second.unit
    record = _common(first.record, second.record)
    fields = {k: either(v, second.fields[k]) for k, v in first.fields.items() if k in second.fields} if record else {}
    low, high = min(first.low, second.low), max(first.high, second.high)
    members: tuple[AbstractValue, ...] = ()
    if len(first.members) == len(second.members):
        members = tuple(either(a, b) for a, b in zip(first.members, second.members, strict=True))
    return AbstractValue(first.kind, record, fields, low, high, choices, unit, blank, members)


def _common(first: RecordType | None, second: RecordType | None) -> RecordType | None:
    """Return a record type for both, or None; types with the same fields are joined (a red and a green ball)."""
    if first is None or second is None or first == second:
        return first if first == second else None
    if first.fields != second.fields or first.positions != second.positions:
        return None
    return replace(first, name=f"{first.name} or {second.name}")


def not_blank(known: AbstractValue) -> AbstractValue:
    """Return the abstract value without a possible blank; one that is always blank stays as it is."""
    if known.kind == BLANK or not known.blank:
        return known
    kept = None if known.choices is None else tuple(c for c in known.choices if c is not None)
    return replace(known, choices=kept, blank=False)


CAMERA, CHANGE, EVENT, TIMER = "camera", "change", "event", "timer"
_ON_CHANGE = ("joint", "inertia")  # kinds of perception that tell only what is new
_JOINT_EXAMPLE = 0.1  # rad; not 0, by which one cannot divide


@dataclass(frozen=True, slots=True)
class Rate:
    """Frequency of a stream's values.

    Attributes:
        kind: `camera` (again and again, as pictures are looked at), `change` (when something is new), `event` (when
            somebody does something), `timer`; or empty when that is not known.
        hz: at most so often a second; 0 when nothing can be said.
    """

    kind: str = ""
    hz: float = 0.0


@dataclass(frozen=True, slots=True)
class Fact:
    """Knowledge about a stream before the run.

    Attributes:
        known: about its values.
        has_example: whether there is an example value.
        example: a value that it may have; blank is one too.
        sure: False when the example went through a filter that does not let it pass: it shows the kind of value only.
        holes: whether the example is a record of which some fields are not known.
        others: examples of another type that the stream has besides (of a merge).
        rate: how often its values come.
    """

    known: AbstractValue = UNKNOWN
    has_example: bool = False
    example: Value = None
    sure: bool = True
    holes: bool = False
    others: tuple[Value, ...] = ()
    rate: Rate = field(default_factory=Rate)

    @property
    def may_be_blank(self) -> bool:
        """True when blank may arrive, as far as is known."""
        return self.known.blank


def sensor_fact(stream: Stream, robot: Robot) -> Fact:
    """Return the fact about a sensor's stream, or about the done stream of an actuator."""
    if stream.kind is StreamKind.DONE:
        return Fact(AbstractValue(RECORD, DONE), True, DONE.example(), holes=True, rate=Rate(EVENT))
    assert stream.device is not None
    kind = stream.device.type
    rate = _rate(stream, robot)
    if kind.payload is None:
        joint = robot.joints.get(key(str(stream.settings.get("joint"))))
        if joint is None:
            return Fact(AbstractValue(NUMBER, unit=kind.unit), True, _JOINT_EXAMPLE, rate=rate)
        example = min(max(_JOINT_EXAMPLE, joint.lower), joint.upper)
        return Fact(AbstractValue(NUMBER, low=joint.lower, high=joint.upper, unit=joint.unit), True, example, rate=rate)
    said = _said_by_settings(stream.settings, robot)
    fields = {k: known for k, known in said.items() if k in kind.payload.keys.values()}
    values = dict(kind.payload.example().values)
    for k, known in fields.items():
        if known.choices and values.get(k) not in known.choices:
            values[k] = known.choices[0]
    return Fact(AbstractValue(RECORD, kind.payload, fields), True, Record(kind.payload, values), rate=rate)


def _said_by_settings(settings: Mapping[str, Value], robot: Robot) -> dict[str, AbstractValue]:
    """Return the fields that the settings decide: a button's label, a touched zone, the words to recognise."""
    said = {}
    if settings.get("label"):
        said["label"] = exactly(settings["label"])
    if "zone" in settings:
        said["zone"] = exactly(settings["zone"]) if settings["zone"] else one_of(robot.touch_zones)
    words = settings.get("words")
    if isinstance(words, (list, tuple)) and words:
        said["word"] = one_of(words)
    return said


def _rate(stream: Stream, robot: Robot) -> Rate:
    assert stream.device is not None
    every, rate = stream.settings.get("every"), stream.settings.get("rate")
    if isinstance(every, (int, float)) and every > 0:
        return Rate(TIMER, 1_000_000 / every)
    if not isinstance(rate, (int, float)):
        return Rate(EVENT)
    name = stream.device.type.name
    entry: Mapping[str, object] = next((s for s in robot.data["sensor"] if s["name"] == name), {})
    return Rate(CHANGE if entry.get("perception") in _ON_CHANGE else CAMERA, float(rate))


def fastest(rates: list[Rate]) -> Rate:
    """Return the rate of a row that takes the values of several streams: the highest of theirs."""
    return max(rates, key=lambda r: r.hz, default=Rate())


def slower(rate: Rate, period_us: int | None) -> Rate:
    """Return the rate behind a sample or throttle with this period."""
    limit = 1_000_000 / period_us if period_us else 0.0
    hz = min(rate.hz, limit) if rate.hz and limit else rate.hz or limit
    return replace(rate, hz=hz)
