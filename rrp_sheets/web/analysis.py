"""Analysis of a workbook for its pages: the robot, the stream graph, and the findings of the check.

No formula is evaluated in the server: the check runs in a worker process.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.graph import BehaviourGraph, Graph, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.render.diagram import draw_diagram
from rrp_sheets.robots import Robot, load_robot, robot_names
from rrp_sheets.robots.gesture_sheet import parse_gestures
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.workbook import Reading

MOST_DRAWINGS = 50  # that are kept: one may be asked around each row
_SECONDS = 5.0  # for a diagram's layout


@dataclass(frozen=True)
class Analysis:
    """Result of analysing a workbook, as the pages show it.

    Attributes:
        findings: errors first, in the order of the sheets and cells; shown numbers start at 1.
        examples: an example of what each row gives, by the row's ref.
        checked: False before the first check has ended.
    """

    workbook: Workbook
    robot: Robot
    graph: Graph
    findings: tuple[Diagnostic, ...]
    examples: Mapping[str, str]
    checked: bool = True

    def behaviour(self, sheet: str) -> BehaviourGraph | None:
        """Return the graph of the behaviour on a sheet; None for any other sheet."""
        return next((b for b in self.graph.behaviours if b.key == key(sheet)), None)

    @property
    def errors(self) -> int:
        """Number of errors among the findings; a workbook with errors does not run."""
        return sum(d.severity is Severity.ERROR for d in self.findings)

    def flags(self, behaviour: BehaviourGraph) -> dict[int, int]:
        """Map the rows of a behaviour to the number of their first error or warning, for the flags in the diagram."""
        return {
            d.address.row: number
            for number, d in reversed([*enumerate(self.findings, 1)])
            if d.address and key(d.address.sheet) == behaviour.key and d.severity is not Severity.INFO
        }

    @property
    def understood(self) -> bool:
        """True if every stream that a row names is in the graph.

        A row that cannot be parsed leaves a row below it, whose blank input means "the row above", without its
        stream; such a workbook can be neither drawn nor put into words.
        """
        graph = self.graph
        return all(i in graph.streams for b in graph.behaviours for s in b.steps for i in (*s.inputs, s.output))

    @cached_property
    def stream_examples(self) -> Mapping[str, str]:
        """Example values of streams, by stream id, taken from the rows that output to them."""
        steps = (s for b in self.graph.behaviours for s in b.steps if not s.connector.is_sink)
        return {s.output: self.examples[s.ref] for s in steps if s.ref in self.examples}

    def drawing(self, behaviour: BehaviourGraph, language: str) -> str:
        """Return the diagram of a behaviour, or of some of its rows, for a panel as SVG in a language, drawn once.

        Raises:
            SheetsError: it cannot be drawn.
        """
        what = (behaviour.key, tuple(step.number for step in behaviour.steps), language)
        if what not in self._drawings:
            if len(self._drawings) >= MOST_DRAWINGS:
                self._drawings.clear()
            flags = self.flags(behaviour)
            drawn = draw_diagram(
                self.graph, behaviour, problems=flags, whole=True, room=True, timeout=_SECONDS, language=language
            )
            self._drawings[what] = drawn[0].svg if drawn else ""
        return self._drawings[what]

    @cached_property
    def _drawings(self) -> dict[tuple[str, tuple[int, ...], str], str]:
        return {}

    def kinds(self, sheet: str) -> dict[str, str]:
        """Map the keys of the names known on a sheet to their kind (sensor, stream, actuator, done)."""
        own = f"{key(sheet)}!"
        return {
            key(s.name): s.kind.value
            for s in self.graph.streams.values()
            if s.kind is not StreamKind.ANONYMOUS and (s.id.startswith(own) or "!" not in s.id)
        }


def no_analysis() -> Analysis:
    """Return an empty analysis, for the time before the first check has ended."""
    return Analysis(Workbook("", ()), load_robot("nao"), Graph((), {}), (), {}, checked=False)


def analyse(path: Path, reading: Reading, worker: CheckWorker) -> Analysis:
    """Check a workbook that was read, in the worker process, and build its graph."""
    findings = worker.check(path)
    name = reading.workbook.protocol.robot
    robot = load_robot(name if name in robot_names() else "nao")
    robot = robot.with_gestures(parse_gestures(reading.workbook.gestures, robot, Report()))
    graph = build_graph(reading.workbook, robot, connectors(), Report())
    return Analysis(reading.workbook, robot, graph, findings.diagnostics, findings.examples)
