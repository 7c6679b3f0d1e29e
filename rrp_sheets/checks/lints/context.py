"""The checked workbook as the lints read it, names of rows and streams in their findings, and edits of their fixes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from rrp_sheets.checks.dataflow import Paths
from rrp_sheets.checks.facts import Fact
from rrp_sheets.checks.formulas import Compiled
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import FixEdit, Insert, Put
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address, Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_

RowKey = tuple[str, int]
"""The key of a sheet and the number of a row."""


def row_key(address: Address) -> RowKey:
    """Return the key of the row in which a cell stands."""
    return key(address.sheet), address.row


@dataclass(frozen=True)
class LintContext:
    """A workbook, keys of the behaviours that can run, routes and readers of streams, and the report of the lints."""

    workbook: Workbook
    robot: Robot
    graph: Graph
    compiled: Compiled
    running: frozenset[str]  # keys of the behaviours that run, or that a row can switch on
    routes: Paths
    report: Report
    unclear: frozenset[RowKey] = frozenset()  # rows that are not yet what is meant, as a warning shows
    readers: dict[str, list[Step]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        for step in self.steps():
            for stream in step.inputs:
                self.readers.setdefault(stream, []).append(step)

    def steps(self) -> Iterator[Step]:
        """Yield all active rows with inputs, behaviour by behaviour, in the order in which they settle."""
        for behaviour in self.behaviours():
            yield from (s for s in sorted(behaviour.steps, key=lambda s: s.rank) if s.active and s.inputs)

    def behaviours(self) -> list[BehaviourGraph]:
        """Return the behaviours that can run."""
        return [b for b in self.graph.behaviours if b.key in self.running]

    def fact(self, stream: str) -> Fact:
        """Return what is known about a stream or, by its ref, about what a subscribe row sends."""
        return self.compiled.facts.get(stream, Fact())

    def joints(self, stream: Stream) -> tuple[str, ...]:
        """Return the joints that an actuator with the setting Joint moves."""
        named = key(str(stream.settings.get("joint")))
        return (self.robot.joints[named].name,) if named in self.robot.joints else self.robot.groups.get(named, ())

    def name(self, stream: str) -> str:
        """Return a stream's name or, for one without a name, the row that gives it."""
        found = self.graph.streams[stream]
        return found.name or N_("the result of row {row}", row=found.address.row)


def row_of(step: Step, seen_from: Step) -> str:
    """Return `row 5`, or `row 5 of the sheet Look` when it is in another sheet."""
    sheet = step.row.output.address.sheet
    if key(sheet) != key(seen_from.row.output.address.sheet):
        return N_("row {number} of the sheet {sheet}", number=step.number, sheet=sheet)
    return N_("row {number}", number=step.number)


class RowWriter:
    """Collects edits around a row for a fix; a row that is inserted before it moves it down."""

    def __init__(self, step: Step) -> None:
        row = step.row
        self.sheet = row.output.address.sheet
        self.columns = [c.address.column for c in (row.inputs_cell, row.connector, row.formula, row.output)]
        self.number = row.number
        self.below = 0  # rows inserted after it
        self.edits: list[FixEdit] = []

    def insert(self, *texts: str, after: bool = False) -> None:
        """Insert a row just before the row, or just after it."""
        cells = tuple((c, t) for c, t in zip(self.columns, texts, strict=True) if t)
        self.edits.append(Insert(self.sheet, self.number + self.below + 1 if after else self.number, cells))
        self.number += not after
        self.below += after

    def put(self, *texts: str | None) -> None:
        """Set the row's inputs, connector, formula and output; None leaves one as it is."""
        for column, text in zip(self.columns, texts, strict=False):
            if text is not None:
                self.edits.append(Put(Address(self.sheet, self.number, column), text))
