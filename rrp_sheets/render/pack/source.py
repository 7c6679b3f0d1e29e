"""Source of the pack's parts: the checked workbook in a language, and the texts that its rows can say."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

from rrp_sheets.checks import Checked
from rrp_sheets.checks.dataflow import Paths, Route, field_text
from rrp_sheets.checks.facts import BLANK, exactly
from rrp_sheets.checks.protocol import channel
from rrp_sheets.checks.speech_texts import SpeechTexts
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.graph import Step, Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Cell
from rrp_sheets.render.pack.model import Ref
from rrp_sheets.render.sentences import Rows
from rrp_sheets.render.style import clean
from rrp_sheets.render.texts import Texts
from rrp_sheets.robots import DeviceType
from rrp_sheets.workbook import Reading


@dataclass(frozen=True)
class Driver:
    """An active row that drives an actuator stream."""

    behaviour: str
    step: Step
    stream: Stream
    stops: bool


@dataclass(frozen=True)
class Source:
    """Workbook to be printed, with the words of the language for that."""

    reading: Reading
    checked: Checked
    words: Texts
    rows: Rows = field(repr=False)

    def get(self, entry: str, /, **values: object) -> str:
        """Return a text of the pack."""
        return self.words.get(f"pack.{entry}", **values)

    def count(self, entry: str, n: int, **values: object) -> str:
        """Return a text that has a form of its own for one: the entry with `_one`."""
        return self.get(f"{entry}_one" if n == 1 else entry, n=f"{n:,}", **values)

    def protocol(self, name: str) -> str:
        """Return a field of the Protocol sheet, on several lines if it has them."""
        return self.checked.workbook.protocol.text(name)

    @cached_property
    def speech(self) -> SpeechTexts:
        """Finder of the texts that rows can say."""
        checked = self.checked
        return SpeechTexts(checked.graph, checked.formulas, checked.facts)

    @cached_property
    def findings(self) -> list[Diagnostic]:
        """Errors and warnings of the check, in the order of their flags."""
        return [d for d in self.checked.report if d.severity is not Severity.INFO]

    def flags(self, behaviour: str) -> dict[int, list[int]]:
        """Return the numbers of the findings in a behaviour (by key), by row."""
        found: dict[int, list[int]] = {}
        for number, d in enumerate(self.findings, 1):
            if d.address and key(d.address.sheet) == behaviour:
                found.setdefault(d.address.row, []).append(number)
        return found

    @cached_property
    def active(self) -> list[tuple[str, Step]]:
        """Active rows, with their behaviour's name."""
        return [(clean(b.name), s) for b in self.checked.graph.behaviours for s in b.steps if s.active]

    @cached_property
    def drivers(self) -> list[Driver]:
        """Active rows that drive actuators."""
        facts, streams = self.checked.facts, self.checked.graph.streams
        return [
            Driver(name, s, streams[s.output], s.ref in facts and facts[s.ref].known.kind == BLANK)
            for name, s in self.active
            if s.connector.is_sink and s.output in streams
        ]

    @cached_property
    def sensors(self) -> dict[str, tuple[Ref, ...]]:
        """Sensor streams that rows take in, each with those rows."""
        found: dict[str, list[tuple[str, Step]]] = {}
        for name, step in self.active:
            for stream in dict.fromkeys(step.inputs):
                if self.checked.graph.streams[stream].kind is StreamKind.SENSOR:
                    found.setdefault(stream, []).append((name, step))
        return {stream: refs(rows) for stream, rows in found.items()}

    def shows(self, stream: str, thing: str) -> bool:
        """Return whether a sensor shows something (`person`), by its entry in the catalogue file."""
        device = self.checked.graph.streams[stream].device
        name = device.type.name if device else ""
        return any(thing in s.get("shows", ()) for s in self.checked.robot.data["sensor"] if s["name"] == name)

    def channel(self, stream: Stream) -> str:
        """Return the channel of a sensor: `camera`, `touch`, `microphone` or another entry of `pack.channel`."""
        return channel(self.checked.robot, stream.device.type if stream.device else None)

    def is_button(self, stream: str) -> bool:
        """Return whether a sensor stream is a button of the operator."""
        device = self.checked.graph.streams[stream].device
        return device is not None and device.type.is_button

    @cached_property
    def buttons(self) -> list[str]:
        """Ids of the operator's button streams that rows take in."""
        return [s for s in self.sensors if self.is_button(s)]

    @cached_property
    def _paths(self) -> Paths:
        """Routes from sensors to rows, with the conditions on the way."""
        return Paths(self.checked.graph, self.checked.formulas, self.checked.facts)

    @cached_property
    def _rows(self) -> dict[str, Step]:
        return {step.ref: step for _, step in self.active}

    def ways(self, place: str, sensor: str) -> list[Route]:
        """Return the routes of a sensor's values to a stream, or to a row by its ref, without the end of an action.

        Where there are too many routes it is one without conditions.
        """
        routes = self._paths.of.get(place, ())
        if routes is None:
            return [Route(sensor)]
        waiting = [self._rows[r.origin.removeprefix("clock ")] for r in routes if r.origin.startswith("clock ")]
        found = [route for route in routes if route.origin == sensor]
        return found + [way for step in waiting for way in self.ways(step.inputs[0], sensor)]

    def occasions(self) -> dict[str, Stream]:
        """Return the sensor streams that trigger rows which drive actuators.

        Where only a touch does, not its end, the stream has the setting `pressed` for the words of the catalogue.
        """
        found = {}
        for sensor in self.sensors:
            stream = self.checked.graph.streams[sensor]
            released = [(field_text(sensor, "pressed"), exactly(False))]
            if ways := [way for driver in self.drivers for way in self.ways(driver.step.ref, sensor)]:
                pressed = not any(self._paths.possible(replace(way, given=(*way.given, *released))) for way in ways)
                found[sensor] = replace(stream, settings={**stream.settings, "pressed": "yes"}) if pressed else stream
        return found

    def label(self, stream: str) -> str:
        """Return the label of a button, by default the name of its stream."""
        found = self.checked.graph.streams[stream]
        return clean(str(found.settings.get("label") or found.name))

    def quoted(self, names: Iterable[str], joiner: str = "and") -> str:
        """Return `“a”, “b” and “c”`."""
        return self.words.listed([self.words.get("name.quoted", name=n) for n in names], joiner)

    def presses(self, buttons: Iterable[str]) -> str:
        """Return `the operator presses “a” or “b”`, for ids of buttons."""
        return self.get("summary.presses", list=self.quoted(map(self.label, buttons), "or"))

    def listed_cells(self, cells: Iterable[Cell]) -> str:
        """Return the names in a cell, as they are typed: `a, b`."""
        return self.words.in_a_row([clean(c.text) for c in cells])

    def fields(self, kind: DeviceType) -> list[str]:
        """Return the fields of a sensor's value with their units."""
        names = kind.words(self.words.language).fields
        said = [(names[key(f.name)][0], f.unit) for f in kind.payload.fields] if kind.payload else []
        return [self.get("sensed.field", name=name, unit=unit) if unit else name for name, unit in said]


def refs(rows: Iterable[tuple[str, Step]]) -> tuple[Ref, ...]:
    """Group rows by their behaviour."""
    found: dict[str, list[int]] = {}
    for name, step in rows:
        found.setdefault(name, []).append(step.number)
    return tuple(Ref(name, tuple(dict.fromkeys(numbers))) for name, numbers in found.items())


def driver_refs(drivers: Iterable[Driver]) -> tuple[Ref, ...]:
    """Group the rows of drivers by their behaviour."""
    return refs((d.behaviour, d.step) for d in drivers)
