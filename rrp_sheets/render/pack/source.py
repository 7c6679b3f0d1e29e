"""What the parts of the pack are made from: the checked workbook, its sheets, and the words of a language."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from rrp_sheets.checks import Checked
from rrp_sheets.checks.abstract_values import BLANK
from rrp_sheets.checks.keeping import channel
from rrp_sheets.devices import DeviceType
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.graph import Step, Stream, StreamKind
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack.model import Ref
from rrp_sheets.render.pack.speech import Speech
from rrp_sheets.render.rows import Rows
from rrp_sheets.render.texts import Texts
from rrp_sheets.workbook import Reading

BUTTON = "OperatorButton"


@dataclass(frozen=True)
class Driver:
    """An active row that drives an actuator stream."""

    behaviour: str
    step: Step
    stream: Stream
    stops: bool

    @property
    def kind(self) -> str:
        """The device's name in the catalogue; empty when it is not known."""
        return self.stream.device.type.name if self.stream.device else ""


@dataclass(frozen=True)
class Source:
    """A workbook that is printed, and the language for that."""

    reading: Reading
    checked: Checked
    words: Texts
    rows: Rows = field(repr=False)

    def get(self, entry: str, /, **values: object) -> str:
        """A text of the pack."""
        return self.words.get(f"pack.{entry}", **values)

    def count(self, entry: str, n: int, **values: object) -> str:
        """A text that has a form of its own for one: the entry with `_one`."""
        return self.get(f"{entry}_one" if n == 1 else entry, n=f"{n:,}", **values)

    def protocol(self, name: str) -> str:
        """A field of the Protocol sheet, on several lines if it has them."""
        return self.checked.workbook.protocol.text(name)

    @cached_property
    def speech(self) -> Speech:
        """The texts that rows can say."""
        return Speech(self.checked)

    @cached_property
    def findings(self) -> list[Diagnostic]:
        """What is open: errors and warnings, in the order of their flags."""
        return [d for d in self.checked.report if d.severity is not Severity.INFO]

    def flags(self, behaviour: str) -> dict[int, list[int]]:
        """The numbers of the findings in a behaviour (by key), by row."""
        found: dict[int, list[int]] = {}
        for number, d in enumerate(self.findings, 1):
            if d.address and key(d.address.sheet) == behaviour:
                found.setdefault(d.address.row, []).append(number)
        return found

    @cached_property
    def active(self) -> list[tuple[str, Step]]:
        """The rows that take part, with their behaviour's name."""
        return [(clean(b.name), s) for b in self.checked.graph.behaviours for s in b.steps if s.active]

    @cached_property
    def drivers(self) -> list[Driver]:
        """The rows that drive actuators."""
        facts, streams = self.checked.facts, self.checked.graph.streams
        return [
            Driver(name, s, streams[s.output], s.ref in facts and facts[s.ref].known.kind == BLANK)
            for name, s in self.active
            if s.connector.is_sink and s.output in streams
        ]

    @cached_property
    def sensors(self) -> dict[str, tuple[Ref, ...]]:
        """The sensor streams that rows take in, each with those rows."""
        found: dict[str, list[tuple[str, Step]]] = {}
        for name, step in self.active:
            for stream in dict.fromkeys(step.inputs):
                if self.checked.graph.streams[stream].kind is StreamKind.SENSOR:
                    found.setdefault(stream, []).append((name, step))
        return {stream: refs(rows) for stream, rows in found.items()}

    def device_entry(self, stream: Stream) -> Mapping[str, Any]:
        """What the catalogue says about a sensor, as it stands in the file."""
        name = stream.device.type.name if stream.device else ""
        return next((s for s in self.checked.robot.data["sensor"] if s["name"] == name), {})

    def channel(self, stream: Stream) -> str:
        """Through what a sensor perceives: `camera`, `touch`, `microphone` or another entry of `pack.channel`."""
        return channel(self.checked.robot, stream.device.type if stream.device else None)

    def is_button(self, stream: str) -> bool:
        """Whether a sensor stream is a button of the operator's."""
        device = self.checked.graph.streams[stream].device
        return device is not None and device.type.name == BUTTON

    @cached_property
    def buttons(self) -> list[str]:
        """The operator's buttons that rows take in: ids of streams."""
        return [s for s in self.sensors if self.is_button(s)]

    def label(self, stream: str) -> str:
        """What stands on a button."""
        found = self.checked.graph.streams[stream]
        return clean(str(found.settings.get("label") or found.name))

    def quoted(self, names: Iterable[str], joiner: str = "and") -> str:
        """`“a”, “b” and “c”`."""
        return self.words.listed([self.words.get("name.quoted", name=n) for n in names], joiner)

    def presses(self) -> str:
        """`the operator presses “a” or “b”`: what the buttons that rows take in tell."""
        return self.get("summary.presses", list=self.quoted((self.label(s) for s in self.buttons), "or"))

    def listed(self, things: Sequence[str]) -> str:
        """`a, b and c`."""
        return self.words.listed(list(things))

    def listed_cells(self, cells: Iterable[Cell]) -> str:
        """The names in a cell, as they are typed: `a, b`."""
        return self.words.in_a_row([clean(c.text) for c in cells])

    def fields(self, kind: DeviceType) -> list[str]:
        """What the value of a sensor consists of: its fields with their units."""
        names = kind.words(self.words.language).fields
        said = [(names[key(f.name)][0], f.unit) for f in kind.payload.fields] if kind.payload else []
        return [self.get("sensed.field", name=name, unit=unit) if unit else name for name, unit in said]


def refs(rows: Iterable[tuple[str, Step]]) -> tuple[Ref, ...]:
    """The rows, behaviour by behaviour."""
    found: dict[str, list[int]] = {}
    for name, step in rows:
        found.setdefault(name, []).append(step.number)
    return tuple(Ref(name, tuple(dict.fromkeys(numbers))) for name, numbers in found.items())


def driver_refs(drivers: Iterable[Driver]) -> tuple[Ref, ...]:
    """The same, of drivers."""
    return refs((d.behaviour, d.step) for d in drivers)


def capital(text: str) -> str:
    """The text with a capital letter at its start."""
    return text[:1].upper() + text[1:]
