"""Reads the test sheets: the values that are sent into streams, and those that are expected on streams, by time."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from rrp_sheets.checks.send_expect import Expectation, Place, Sending, read_expect, read_send
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Delete, Fix, meant, proposed
from rrp_sheets.formulas import Scope
from rrp_sheets.graph import Graph, Stream, StreamKind
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import Proposals, argument_name, key
from rrp_sheets.model.values import RecordType
from rrp_sheets.model.workbook import Address, Cell, TestRow, TestSheet, Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_, listed

LONGEST_US = 24 * 3_600_000_000  # a day: longer is surely a typing mistake
_TEXT = re.compile('[^"“”„<>=≠;,()]+')
"""A text within an Expect cell, in quotes or not."""
MakeScope = Callable[[Sequence[tuple[str, RecordType | None]]], Scope]


@dataclass(frozen=True)
class CaseRow:
    """A parsed row of a test, which either sends or expects something."""

    row: int
    address: Address  # of the cell that says what is sent or expected
    time_us: int  # from the start of the test
    name: str  # the stream as the row names it; `stream` is its id, which a done stream that no row reads has too
    stream: str
    sending: Sending | None = None
    expectation: Expectation | None = None
    why_silent: str = ""  # why nothing can ever come on that stream; empty when it runs
    notes: str = ""


@dataclass(frozen=True)
class Case:
    """A test sheet: its rows in the order of the sheet."""

    name: str
    rows: tuple[CaseRow, ...]

    @property
    def sends(self) -> list[CaseRow]:
        """The rows that send, by time; those of one time in the order of the sheet."""
        return sorted((r for r in self.rows if r.sending), key=lambda r: r.time_us)


_RowsByStream = Mapping[str, Sequence[TestRow]]
"""Rows of a test by the keys of the streams that they name."""


@dataclass(frozen=True)
class _Named:
    """A stream that a test names: one of the graph, or one that is not in it since no row uses it."""

    id: str
    shown: str
    kind: StreamKind
    record: RecordType | None = None
    why_silent: str = ""


@dataclass
class _Names:
    """The streams of a workbook by the names that a test may use."""

    workbook: Workbook
    robot: Robot
    graph: Graph
    running: frozenset[str]
    records: Mapping[str, RecordType | None]
    by_name: dict[str, list[Stream]] = field(default_factory=dict)
    propose: Proposals = field(default_factory=Proposals)

    def __post_init__(self) -> None:
        for stream in self.graph.streams.values():
            sheet, _, name = stream.id.partition("!")
            if stream.kind in (StreamKind.SENSOR, StreamKind.ACTUATOR, StreamKind.DONE):
                self.by_name.setdefault(stream.id, []).insert(0, stream)
            else:
                self.by_name.setdefault(f"{sheet}!{name}", []).append(stream)
                if stream.name:
                    self.by_name.setdefault(name, []).append(stream)
        self.used = {i for b in self.graph.behaviours if b.key in self.running for s in b.steps if s.active
                     for i in (*s.inputs, s.output)}  # fmt: skip

    def find(self, cell: Cell, report: Report, by_stream: _RowsByStream) -> _Named | None:
        """Return the stream that a Stream cell names; None when it is refused, which is reported."""
        sheet, bang, name = cell.text.rpartition("!")
        sheet = sheet.strip().strip("'")
        k = f"{key(sheet)}!{key(name)}" if bang else key(name)
        found = self.by_name.get(k, [])
        if len(found) > 1 and found[0].kind is StreamKind.ORDINARY:
            sheets = [s.address.sheet for s in found]
            example = f"{quoted_sheet(sheets[0])}!{found[0].name}"
            report.add("TEST003", cell.address, name=cell.text, sheets=listed(sheets, "and of"), example=example)
            return None
        if found:
            stream, why = found[0], ""
            if stream.id not in self.used:
                dead = not stream.active or stream.id.partition("!")[0] in self.running
                why = N_("its rows are switched off, or get nothing" if dead else "its behaviour is not run")
            return _Named(stream.id, stream.name or cell.text, stream.kind, self.records.get(stream.id), why)
        unused = None if bang else self._unused(cell.text)
        if unused is None:
            guess = self.propose(cell.text, self._all_names)
            otherwise = N_("Write the stream as it is called in a behaviour or in Devices. If no row gives “{name}” "
                           "any more, delete the rows of the test that name it.", name=cell.text)  # fmt: skip
            details = {"name": cell.text, **meant(guess, otherwise)}
            fixes = [*proposed("TEST002", cell.address, details), *_row_deletions(cell, by_stream)]
            report.add("TEST002", cell.address, fixes=fixes, **details)
        return unused

    def _unused(self, name: str) -> _Named | None:
        """Return a device, or the done stream of an actuator, that no row uses; None when the name is of neither."""
        k = key(name)
        declared = {key(d.stream.text): self.robot.find(d.device.text) for d in self.workbook.devices}
        if k.endswith("done") and k not in declared:
            of = self.graph.streams.get(k.removesuffix("done"))
            if of is not None and of.kind is StreamKind.ACTUATOR:
                return _Named(k, name, StreamKind.DONE, DONE)
        found = declared.get(k) or self.robot.find(name)
        if found is None:
            return None
        kind = StreamKind.SENSOR if found.type.kind == "sensor" else StreamKind.ACTUATOR
        return _Named(k, name, kind, found.type.payload, N_("no row uses it"))

    @cached_property
    def _all_names(self) -> list[str]:
        names = [s.name for s in self.graph.streams.values() if s.name]
        return names + [d.stream.text for d in self.workbook.devices if d.stream]


def _row_deletions(cell: Cell, by_stream: _RowsByStream) -> list[Fix]:
    """Return the fix that deletes the rows of a test with the stream of a cell; empty if another row has it above.

    It deletes all rows of the test if no other one expects anything.
    """
    rows = by_stream[key(cell.text)]
    if rows[0].stream is not cell:
        return []
    title = N_("Delete the rows of the test that name “{name}”", name=cell.text)
    every = [row for rows in by_stream.values() for row in rows]
    if not any(row.expect for row in every if key(row.stream.text) != key(cell.text)):
        rows, title = every, N_("Delete all rows of this test")
    numbers = sorted((row.stream.address.row for row in rows), reverse=True)
    return [Fix("delete-rows", title, tuple(Delete(cell.address.sheet, number) for number in numbers))]


def quoted_sheet(name: str) -> str:
    """A sheet's name before `!` in a test."""
    return f"'{name}'" if "!" in name else name


def check_tests(
    workbook: Workbook,
    robot: Robot,
    graph: Graph,
    running: frozenset[str],
    records: Mapping[str, RecordType | None],
    make: MakeScope,
    report: Report,
) -> tuple[Case, ...]:
    """Return the tests of a workbook; rows that cannot be understood are reported and left out.

    `running` are the keys of the behaviours that run; `make` makes the scope of a formula with these inputs.
    """
    if not workbook.tests:
        return ()
    names = _Names(workbook, robot, graph, running | switchable(graph), records)
    reader = _Reader(names, make, make(()), report, any(d.code == "GRAPH011" for d in report))
    return tuple(reader.case(sheet) for sheet in workbook.tests)


def switchable(graph: Graph) -> frozenset[str]:
    """Return the keys of the behaviours that a row may switch on."""
    switches = (s for s in graph.streams.values() if s.device and s.device.type.name == "Behaviour")
    return frozenset(key(str(s.settings.get("name") or "")) for s in switches)


@dataclass
class _Reader:
    names: _Names
    make: MakeScope
    alone: Scope
    report: Report
    may_be_driven: bool  # an actuator that no row drives may be meant by a row that gives what nothing takes

    def case(self, sheet: TestSheet) -> Case:
        before = len(self.report)
        by_stream: dict[str, list[TestRow]] = {}
        for row in sheet.rows:
            by_stream.setdefault(key(row.stream.text), []).append(row)
        rows = [found for row in sheet.rows if (found := self._row(row, by_stream)) is not None]
        if len(self.report) == before and not any(r.expectation for r in rows):
            self.report.add("TEST012", Address(sheet.name), name=sheet.name)
        return Case(sheet.name, tuple(rows))

    def _row(self, row: TestRow, by_stream: _RowsByStream) -> CaseRow | None:
        if not row.time or not row.stream:
            return None  # told by the reader
        time = parse_duration(row.time.text, bare="ms")
        if time is None or time > LONGEST_US:
            meant, longest = meant_duration(row.time.text) or "2 s", "24 h"
            self.report.add("TEST001", row.time.address, text=row.time.text, meant=meant, longest=longest)
        named = self.names.find(row.stream, self.report, by_stream)
        if named is None:
            return None
        undriven = named.kind is StreamKind.ACTUATOR and named.id not in self.names.graph.streams
        if named.why_silent and not (undriven and self.may_be_driven):
            self.report.add("TEST011", row.stream.address, name=named.shown, why=named.why_silent)
        if row.send and row.expect:
            self.report.add("TEST005", row.expect.address, send=row.send.text, expect=row.expect.text)
            return None
        if row.send and named.kind is StreamKind.ACTUATOR:
            self.report.add("TEST004", row.send.address, name=named.shown, text=row.send.text)
            return None
        sending = expectation = None
        if row.expect:
            shown = named.shown.rpartition("!")[2]
            names = frozenset(("value", key(argument_name(shown))))
            place = Place(names, named.record, lambda: self.make([(shown, named.record)]), self.alone)
            expectation = read_expect(self._standard(row.expect, named.id), place, self.report)
        elif row.send:
            sending = read_send(row.send, named.record, self.alone, self.report)
        elif named.kind in (StreamKind.SENSOR, StreamKind.DONE):
            sending = Sending("")
        else:
            self.report.add("TEST006", row.send.address, name=named.shown)
        if time is None or (sending is None and expectation is None):
            return None
        address = (row.expect or row.send or row.stream).address
        name, why = row.stream.text, named.why_silent
        return CaseRow(address.row, address, time, name, named.id, sending, expectation, why, row.notes)

    def _standard(self, cell: Cell, stream: str) -> Cell:
        """Return an Expect cell with the robot's own words for Japanese ones, as actuators are sent them."""
        found = self.names.graph.streams.get(stream)
        driven = self.names.graph.streams.get(found.done_of or stream) if found else None
        robot, kind = self.names.robot, driven.device.type.name if driven and driven.device else ""
        return replace(cell, text=_TEXT.sub(lambda match: str(robot.standard(kind, match[0])), cell.text))
