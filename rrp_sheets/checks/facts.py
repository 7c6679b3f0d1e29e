"""Facts about streams before the run: an example, bounds and possible values, and how often they come."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rrp_sheets.checks.abstract_values import NUMBER, RECORD, UNKNOWN, AbstractValue, exactly, one_of
from rrp_sheets.devices import Robot
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value

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


def slower(rate: Rate, period_us: int | None, kind: str = "") -> Rate:
    """Return the rate behind a sample or throttle with this period."""
    limit = 1_000_000 / period_us if period_us else 0.0
    hz = min(rate.hz, limit) if rate.hz and limit else rate.hz or limit
    return replace(rate, kind=kind or rate.kind, hz=hz)
