"""LINT012, LINT013, LINT014: values that an actuator cannot use, or that exceed its limits, as its driver has them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from rrp_sheets.checks.facts import ANY, BLANK, LIST, NUMBER, RECORD, TEXT, Fact
from rrp_sheets.checks.lints.context import LintContext
from rrp_sheets.diagnostics.report import Fix
from rrp_sheets.formulas.operations import is_number
from rrp_sheets.formulas.problems import KINDS, kind_of, kind_of_value
from rrp_sheets.graph import Step, Stream
from rrp_sheets.graph.device_table import setting_fixes, understand
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.robots import DeviceType, Robot, Setting
from rrp_sheets.robots.trajectory import JointLimits
from rrp_sheets.texts import N_, sentences


@dataclass(frozen=True, slots=True)
class InputSpec:
    """The values that an actuator can use."""

    kinds: frozenset[str]  # of values that it accepts; blank is always accepted (it stops the actuator)
    remedy: str
    # returns the problem with a value of these kinds, in words, or an empty text
    wrong: Callable[[Value, Stream, LintContext], str] = lambda value, stream, context: ""
    # the fields that a record must have; `lacks` describes one without them, in words
    needs: frozenset[str] = frozenset()
    lacks: str = ""


def lint_input_specs(context: LintContext) -> None:
    """Report rows that send an actuator values that it cannot use."""
    payloads = {s.id: s.device.type.payload for s in context.graph.streams.values() if s.device}
    seeing = {i for i, payload in payloads.items() if payload and {"x", "y"} <= set(payload.keys)}
    ancestors: dict[str, frozenset[str]] = {}
    for step in context.steps():
        mine = frozenset().union(*(ancestors.get(i, frozenset({i})) for i in step.inputs))
        if not step.connector.is_sink:
            ancestors[step.output] = mine if len(mine) <= 50 else mine & seeing or frozenset(sorted(mine)[:1])
            continue
        stream = context.graph.streams[step.output]
        if stream.device is None:
            continue
        device = stream.device.type
        if device.name == "Tracker" and not mine & seeing and context.fact(step.ref).known.kind != BLANK:
            context.report.add("LINT014", step.row.output.address, device=stream.name)
        decides = _SETTING_DECIDES.get(device.name)
        taker = _TAKERS.get(device.name)
        if taker is not None and not (decides and stream.settings.get(decides) not in (None, "")):
            _check(step, stream, device, taker, context)


def _check(step: Step, stream: Stream, device: DeviceType, taker: InputSpec, context: LintContext) -> None:
    fact = context.fact(step.ref)
    if fact.known.kind == BLANK:
        return
    address = (step.row.formula or step.row.inputs_cell).address
    what, value = _what_is_wrong(fact, stream, taker, context)
    if what:
        remedy = sentences(_stands(value, context), taker.remedy)
        fixes = _name_fixes(value, stream, device, context)
        context.report.add(
            "LINT012", address, fixes=fixes, device=stream.name, takes=device.takes, what=what, remedy=remedy
        )
        return
    for what, known, low, high, unit in _limited(stream, device, fact, context):
        beyond = next((v for v in known if v < low - 1e-6 or v > high + 1e-6), None)
        if beyond is not None:
            end = low if beyond < low else high  # shown with so many digits that the two look different
            n = next((n for n in range(3, 7) if f"{beyond:.{n}g}" != f"{end:.{n}g}"), 7)
            context.report.add(
                "LINT013", address, value=f"{beyond:.{n}g}", what=what, low=f"{low:.{n}g}", high=f"{high:.{n}g}",
                unit=f" {unit}" if unit else "",
            )  # fmt: skip
            return


def _name_fixes(value: Value, stream: Stream, device: DeviceType, context: LintContext) -> list[Fix]:
    """Return the fix that fills in the setting which decides for a declared stream, with what is meant, if known."""
    book, decides = context.workbook, _SETTING_DECIDES.get(device.name, "")
    if not decides or not any(key(d.stream.text) == key(stream.name) for d in book.devices) or stream.device is None:
        return []
    names = {"posture": context.robot.postures, "gesture": context.robot.gestures}.get(
        device.settings[decides].kind, ()
    )
    known = [*names, *japanese.words_for(japanese.MOVES, *names)]
    typed = [value, stream.name] if isinstance(value, str) else [stream.name]
    guess = next(filter(None, (nearest(text, known) for text in typed)), "")
    text = japanese.word_in(japanese.MOVES, japanese.standard(japanese.MOVES, guess), book.language)
    return setting_fixes(book, device.settings[decides], stream.name, stream.device.name, text)


def _what_is_wrong(fact: Fact, stream: Stream, taker: InputSpec, context: LintContext) -> tuple[str, Value]:
    """Return the problem in words, and the value that has it; an empty text when there is none."""
    known = fact.known
    if known.choices:
        found = ((_wrong(c, stream, taker, context), c) for c in known.choices if c is not None)
        return next((f for f in found if f[0]), ("", None))
    if known.kind not in (ANY, *taker.kinds):
        return KINDS.get(known.kind, N_("something else")), None
    if known.kind == RECORD and known.record is not None and not taker.needs <= set(known.record.keys):
        return taker.lacks, None
    sure = known.kind == ANY and fact.has_example and fact.sure and not fact.holes
    if sure or (known.kind == LIST and fact.has_example):
        return _wrong(fact.example, stream, taker, context), fact.example
    return "", None


def _stands(value: Value, context: LintContext) -> str:
    """Return in words the table column that holds an unusable text; empty when none does."""
    columns = ((f.name, t) for t in context.compiled.tables.values() for f in t.type.fields)
    for column, table in columns if isinstance(value, str) else ():
        if value in table.column(column):
            return N_("{value} is in the column {column} of the sheet {sheet}.",
                      value=show(value), column=column, sheet=table.name)  # fmt: skip
    return ""


def _wrong(value: Value, stream: Stream, taker: InputSpec, context: LintContext) -> str:
    if value is None or stream.device is None:
        return ""
    value = context.robot.standard(stream.device.type.name, value)
    return taker.wrong(value, stream, context) if kind_of_value(value) in taker.kinds else kind_of(value)


# ---- what each takes, as its driver does


def _colour(value: Value, stream: Stream, context: LintContext) -> str:
    if isinstance(value, Record):
        return "" if isinstance(value.values.get("colour"), str) else N_("a record without a colour")
    if isinstance(value, (list, tuple)):
        fine = len(value) == 3 and all(is_number(v) and 0 <= v <= 1 for v in value)
        return "" if fine else N_("{value}, which is not (red, green, blue) from 0 to 1", value=show(value))
    _, wants = understand(Setting("Colour", "colour"), str(value), context.robot)
    return N_("{value}, which is not {wants}", value=show(value), wants=wants) if wants else ""


def _posture(value: Value, stream: Stream, context: LintContext) -> str:
    names = context.robot.postures
    return "" if key(value) in {key(p) for p in names} else _no_name(value, N_("posture"), names)


def _gesture(value: Value, stream: Stream, context: LintContext) -> str:
    if isinstance(value, Record):
        return "" if {"x", "y"} <= set(value.values) else N_("a record without a place to point at")
    if not isinstance(value, str):
        return ""
    names = [*context.robot.gestures, *(g.name.text for g in context.workbook.gestures)]
    return "" if key(value) in {key(g) for g in names} else _no_name(value, N_("gesture"), names)


def _no_name(value: Value, what: str, names: Iterable[str]) -> str:
    names = list(names)
    guess = nearest(str(value), [*names, *japanese.words_for(japanese.MOVES, *names)])
    if guess:
        return N_("{value}, which is not a {what} (did you mean {guess}?)", value=show(value), what=what, guess=guess)
    return N_("{value}, which is not a {what}", value=show(value), what=what)


def _duration(value: Value, stream: Stream, context: LintContext) -> str:
    if isinstance(value, str) and parse_duration(value, bare="s") is None:
        return N_("{value}, which is not a time", value=show(value))
    return ""


def _angles(value: Value, stream: Stream, context: LintContext) -> str:
    count = len(context.joints(stream))
    values = list(value) if isinstance(value, (list, tuple)) else [value]
    if len(values) == 1 != count:
        return N_("one angle for {count} joints", count=count)
    if len(values) != count:
        return N_("{n} angles for {count} joints", n=len(values), count=count)
    return "" if all(is_number(v) for v in values) else N_("{value}, which are not all numbers", value=show(value))


_ANGLE = N_("Send an angle in rad, or a list with one for each joint.")
_SPOKEN = frozenset({TEXT, NUMBER})
_TAKERS: Mapping[str, InputSpec] = {
    "SayInput": InputSpec(_SPOKEN, N_("Turn it into a text in a map row, for example \"I see \"&colour.")),
    "EyeLedColor": InputSpec(
        frozenset({TEXT, LIST, RECORD}), N_('Send "red", "#ff8000" or three numbers such as (1, 0.5, 0).'), _colour,
        needs=frozenset({"colour"}), lacks=N_("a record without a colour")
    ),
    "EyeBrightness": InputSpec(frozenset({NUMBER}), N_("Send a number from 0 (dark) to 1.")),
    "SetJointPosition": InputSpec(frozenset({NUMBER, LIST}), _ANGLE, _angles),
    "Posture": InputSpec(
        frozenset({TEXT}), N_("Send the name of a posture, such as StandInit, or fill in the setting Name."), _posture
    ),
    "Gesture": InputSpec(
        frozenset({TEXT, RECORD}), N_("Send the name of a gesture, such as Wave, or fill in the setting Name."),
        _gesture, needs=frozenset({"x", "y"}), lacks=N_("a record without a place to point at")
    ),
    "Wait": InputSpec(_SPOKEN, N_("Send a time such as 8 s, or fill in the setting Time."), _duration),
}  # fmt: skip
_SETTING_DECIDES = {"Posture": "name", "Gesture": "name", "Wait": "time"}

_Limited = tuple[str, list[float], float, float, str]
"""The name of what has limits, the values that it will surely be given, its limits and their unit."""


def _limited(stream: Stream, device: DeviceType, fact: Fact, context: LintContext) -> list[_Limited]:
    if device.name == "EyeBrightness":
        return [(N_("the eyes"), _sure_values(fact), 0.0, 1.0, "")]
    if device.name != "SetJointPosition":
        return []
    names = context.joints(stream)
    given = fact.known.choices if fact.known.choices is not None else (fact.example,) if fact.sure else ()
    lists = [list(v) for v in given if isinstance(v, (list, tuple))]
    alone = len(names) == 1 and not lists
    lists = [v for v in lists if len(v) == len(names)]
    found = []
    for place, name in enumerate(names):
        joint = context.robot.joints[key(name)]
        values = _sure_values(fact) if alone else [v[place] for v in lists]
        found.append((name, [v for v in values if is_number(v)], joint.lower, joint.upper, joint.unit))
    if {"HeadYaw", "HeadPitch"} <= set(names):
        found += _pitches([(v[names.index("HeadYaw")], v[names.index("HeadPitch")]) for v in lists], context.robot)
    return found


def _pitches(pairs: list[tuple[Value, Value]], robot: Robot) -> list[_Limited]:
    """Return the head's pitch with its limits at the yaw that is sent with it: turned aside, it can nod less."""
    found: list[_Limited] = []
    limits = JointLimits(robot)
    for yaw, pitch in pairs:
        if is_number(yaw) and is_number(pitch):
            name = N_("HeadPitch with HeadYaw at {value:.3g} rad", value=yaw)
            found.append((name, [pitch], *limits.of("HeadPitch", float(yaw)), "rad"))
    return found


def _sure_values(fact: Fact) -> list[float]:
    """Return numbers that will surely be sent: a formula's possible results, or the example and the nearest bound."""
    known = fact.known
    if known.choices is not None:
        return [c for c in known.choices if is_number(c)]
    values = [fact.example] if fact.has_example and fact.sure and is_number(fact.example) else []
    nearest_to_0 = [known.low] if 0 < known.low < 1e9 else [known.high] if -1e9 < known.high < 0 else []
    return values + nearest_to_0
