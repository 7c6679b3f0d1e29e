"""One of two compared workbooks: its file opened, as git passes it too, and its contents resolved."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.compare.changes import helpers_in, meanings, shape_of
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import Formula, HelperDef
from rrp_sheets.graph import Step, Stream
from rrp_sheets.graph.device_table import DeviceTable
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Behaviour, Row, Workbook
from rrp_sheets.robots import FoundDevice
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.files import KNOWN_SUFFIXES
from rrp_sheets.workbook.schema import BEHAVIOUR, recognise


@dataclass
class RowView:
    """A row of a behaviour.

    Attributes:
        connector: its name as the program spells it; the key of what is written, when there is none of that name.
        inputs: stream ids; of a row that the graph refuses, the ids that they would have.
        output: a stream id.
        formula: compiled, if it could be.
        deep: a number that is equal for rows with the same texts and the same streams (unnamed ones: made by equal
            rows).
    """

    row: Row
    sheet: str
    step: Step | None
    connector: str
    drives: bool
    inputs: tuple[str, ...]
    output: str
    formula: Formula | None
    deep: int = 0

    @cached_property
    def shape(self) -> str | tuple[str, ...]:
        """Shape of the formula, whatever its spelling; its tokens where it does not compile."""
        if self.step is not None and self.step.period_us is not None:
            return f"{self.step.period_us} µs"
        if self.formula is None:
            return meanings(self.row.formula.text)
        return shape_of(self.formula, len(self.inputs))

    @cached_property
    def tokens(self) -> frozenset[str]:
        """Tokens of the formula, to measure likeness."""
        return frozenset(meanings(self.row.formula.text))


@dataclass
class BehaviourView:
    """A behaviour: its name, its key, its rows in the order of the sheet."""

    name: str
    key: str
    rows: list[RowView]


@dataclass(frozen=True)
class DeviceView:
    """Stream that is a device: declared in a row of Devices (`row` is not 0), or used by its name alone."""

    name: str
    found: FoundDevice | None
    device: str
    settings: Mapping[str, Value]
    texts: Mapping[str, str] = field(default_factory=dict)
    row: int = 0
    sheet: str = "Devices"

    def meaning(self, sheets: Mapping[str, str]) -> tuple[object, ...]:
        """Return the device and its settings: equal for two streams that do the same.

        `sheets` are the keys of behaviours as they are called now, by the old ones.
        """
        kind = self.found.type.name if self.found else key(self.device)
        return (kind, *sorted((k, repr(self.value(k, sheets))) for k in self.settings))

    def value(self, name: str, sheets: Mapping[str, str]) -> Value:
        """Return the value of a setting; for one that names a behaviour, that behaviour's key."""
        value = self.settings.get(name)
        setting = self.found.type.settings.get(name) if self.found else None
        if setting is not None and setting.kind == "behaviour" and isinstance(value, str):
            return sheets.get(key(value), key(value))
        return value


class Side:
    """A workbook that was read and checked.

    Attributes:
        devices: all streams that are devices, by key: declared ones, and those that rows name.
        used: ids of the streams that rows which are on read or drive.
        helpers: as compiled, by key; only those that formulas call.
        remarks: of sheets other than behaviours, by sheet key and row: texts on which the robot does not act.
    """

    def __init__(self, reading: Reading, checked: Checked) -> None:
        self.reading, self.checked = reading, checked
        self.workbook = checked.workbook
        self.streams: Mapping[str, Stream] = checked.graph.streams
        steps = {s.ref: s for b in checked.graph.behaviours for s in b.steps}
        self.behaviours = [self._behaviour(b, steps) for b in self.workbook.behaviours]
        views = [view for b in self.behaviours for view in b.rows if view.row.on]
        self.used = {i for view in views for i in (*view.inputs, view.output)}
        self.used |= {s.done_of for i in self.used if (s := self.streams.get(i)) is not None and s.done_of}
        self.devices = self._devices()
        self.helpers: dict[str, HelperDef] = {}
        for formula in checked.formulas.values() if self.workbook.helpers else ():
            helpers_in(formula.tree, self.helpers)
        self.remarks = self._remarks()

    def shown(self, stream: str) -> str:
        """Return a stream's name for people; empty for an unnamed one."""
        found = self.streams.get(stream)
        return found.name if found is not None else stream.rpartition("!")[2]

    # ---- rows
    def _behaviour(self, behaviour: Behaviour, steps: Mapping[str, Step]) -> BehaviourView:
        sheet = key(behaviour.name)
        made = {key(r.output.text) for r in behaviour.rows if r.output and not self._drives(r)}
        home = sheet + "!"  # left out, so that a sheet that is only called otherwise has the same rows
        deep: dict[str, int] = {}
        above: tuple[str, ...] = ()
        views = []
        for row in behaviour.rows:
            step = steps.get(f"{behaviour.name}!{row.number}")
            view = self._view(row, behaviour.name, step, made, above)
            named = [i.removeprefix(home) for i in view.inputs]
            inputs = tuple(deep.get(i, name) if "!#" in i else name for i, name in zip(view.inputs, named, strict=True))
            output = view.output.removeprefix(home) if row.output else ""
            texts = (row.on, row.priority, view.connector, row.formula.text, output)
            view.deep = deep[view.output] = hash((inputs, *texts))
            views.append(view)
            if row.on:
                above = view.inputs if view.drives else (view.output,)
        return BehaviourView(behaviour.name, sheet, views)

    def _drives(self, row: Row) -> bool:
        connector = connectors().get(row.connector.text)
        return connector is not None and connector.is_sink

    def _view(self, row: Row, sheet: str, step: Step | None, made: set[str], above: tuple[str, ...]) -> RowView:
        if step is not None:
            formula = self.checked.formulas.get(step.ref)
            connector = step.connector
            return RowView(row, sheet, step, connector.name, connector.is_sink, step.inputs, step.output, formula)
        found, home = connectors().get(row.connector.text), key(sheet)
        inputs = tuple(f"{home}!{k}" if (k := key(c.text)) in made else k for c in row.inputs) or above
        drives = found is not None and found.is_sink
        output = f"{home}!{key(row.output.text)}" if row.output else f"{home}!#{row.number}"
        name = found.name if found else key(row.connector.text)
        return RowView(row, sheet, None, name, drives, inputs, key(row.output.text) if drives else output, None)

    # ---- devices
    def _devices(self) -> dict[str, DeviceView]:
        table = DeviceTable(self.workbook, self.checked.robot, Report())
        views: dict[str, DeviceView] = {}
        for device in self.workbook.devices:
            k = key(device.stream.text)
            if not k or k in views:
                continue
            declared = table.declared.get(k)
            texts = {n: c.text for n, c in device.settings.items() if c}
            found, settings = (declared.found, declared.settings) if declared else (None, texts)
            at = device.stream.address
            views[k] = DeviceView(device.stream.text, found, device.device.text, settings, texts, at.row, at.sheet)
        for stream in self.streams.values():
            if stream.device is not None and stream.id not in views and not stream.done_of:
                views[stream.id] = DeviceView(stream.name, stream.device, stream.device.name, stream.settings)
        return views

    # ---- remarks of the other sheets
    def _remarks(self) -> dict[tuple[str, int], dict[str, str]]:
        found: dict[tuple[str, int], dict[str, str]] = {}
        for sheet in self.reading.sheets:
            recognised = recognise(sheet)
            if recognised.kind is None or recognised.kind is BEHAVIOUR:
                continue
            names = {recognised.columns.get(c.name, 0): c.name for c in recognised.kind.columns if not c.effect}
            for (row, at), cell in sheet.cells.items():
                if at in names and row > recognised.row and cell.text.strip():
                    found.setdefault((key(sheet.name), row), {})[names[at]] = cell.text.strip()
        return found

    def remarks_of(self, sheet: str, row: int) -> Mapping[str, str]:
        """Return the remarks of a row in a sheet other than a behaviour, by their column."""
        return self.remarks.get((key(sheet), row), {})

    @cached_property
    def field_names(self) -> bool:
        """True if formulas may see stream names as fields: some combineLatest has no formula."""
        return any(v.connector == "combineLatest" and not v.row.formula for b in self.behaviours for v in b.rows)


def different(first: Mapping[str, str], second: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    """Yield the remarks that differ: their column, in small letters, and their texts."""
    for column in dict.fromkeys([*first, *second]):
        before, after = first.get(column, ""), second.get(column, "")
        if before != after:
            yield column.casefold(), before, after


def formula_name(stream: str) -> str:
    """Return the key of the name that a stream has in formulas."""
    return key(argument_name(stream))


_HEAD = 8_192  # bytes that tell a format


def open_workbook(path: Path) -> Reading:
    """Read a workbook of any file name; without a known ending, its first bytes decide the format.

    The null device, which git gives for a file that is not there, is a workbook without sheets.

    Raises:
        UnreadableFile: when it cannot be read at all, or is refused.
    """
    if str(path) == os.devnull:
        return Reading(Workbook("nothing", ()), Report(), "", "none")
    return read(path, _format(path))


def open_checked(path: Path) -> tuple[Reading, Checked]:
    """Read and check a workbook, without lints."""
    reading = open_workbook(path)
    return reading, check_workbook(reading.workbook, reading.report, lints=False)


def _format(path: Path) -> str:
    """Return the ending for the format that the first bytes show, if the file's own is unknown; else empty."""
    if path.suffix.casefold() in KNOWN_SUFFIXES or "\0" in str(path) or not path.is_file():
        return ""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
    except OSError:
        return ""
    if b"\0" in head[:4] or head.startswith(b"PK"):
        return ""
    lines = [line.strip() for line in head.decode("utf-8", "replace").splitlines() if line.strip()]
    if any(line.startswith("## ") for line in lines) and any(line.startswith("|") for line in lines):
        return ".md"
    return ".csv" if lines and any(mark in lines[0] for mark in ",;\t") else ""
