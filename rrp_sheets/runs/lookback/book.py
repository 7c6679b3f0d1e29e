"""The workbook of a recorded run, read from the copy in its folder: its rows, units and diagrams."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.checks import check_workbook
from rrp_sheets.checks.check import robot_of
from rrp_sheets.checks.shown import row_examples
from rrp_sheets.connectors import connectors
from rrp_sheets.devices import Robot, load_robot
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import Graph, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Row
from rrp_sheets.workbook import Reading, read

WORKBOOK = "protocol.xlsx"
_MOST_CHECKED = 1_500  # rows of a workbook whose units are looked for
_MOST_SHOWN = 2_000  # rows of a sheet
_LONGEST = 2_000  # letters of a cell
_SECONDS = 8.0  # for a diagram's layout


@dataclass(frozen=True)
class Book:
    """What ran.

    Attributes:
        graph: None when the copy cannot be read; `why` says why.
        units: of what rows give, by their refs.
    """

    robot: Robot
    graph: Graph | None
    units: Mapping[str, str]
    why: str = ""


def read_book(place: Path) -> Book:
    """Read the workbook of a run; one that cannot be read says why."""
    try:
        reading = read(place / WORKBOOK)
    except SheetsError as error:
        return Book(load_robot(), None, {}, f"{error.message} {error.remedy}")
    robot = robot_of(reading.workbook, Report())
    if sum(len(b.rows) for b in reading.workbook.behaviours) > _MOST_CHECKED:
        return Book(robot, build_graph(reading.workbook, robot, connectors(), Report()), {})
    return _checked(reading)


def _checked(reading: Reading) -> Book:
    checked = check_workbook(reading.workbook, reading.report, lints=False)
    numbers = {
        ref: fact.known.unit
        for ref, fact in row_examples(checked).items()
        if isinstance(fact.example, (int, float)) and not isinstance(fact.example, bool)
    }
    return Book(checked.robot, checked.graph, numbers)


def sheets(book: Book) -> list[dict[str, Any]]:
    """The behaviours as JSON: name, rows, and what the names in them are (sensor, stream, actuator, done)."""
    if book.graph is None:
        return []
    return [
        {
            "name": b.name, "rows": [_row(s.row) for s in b.steps[:_MOST_SHOWN]],
            "left_out": max(0, len(b.steps) - _MOST_SHOWN), "kinds": _kinds(book.graph, b.key),
        }
        for b in book.graph.behaviours
    ]  # fmt: skip


def _row(row: Row) -> list[Any]:
    """Number, whether it is on, and the texts of its cells."""
    cells = (row.inputs_cell.text, row.connector.text, row.formula.text, row.output.text, row.notes)
    return [row.number, row.on, *(text[:_LONGEST] for text in cells)]


def _kinds(graph: Graph, behaviour: str) -> dict[str, str]:
    own = f"{behaviour}!"
    return {
        key(s.name): s.kind.value
        for s in graph.streams.values()
        if s.kind is not StreamKind.ANONYMOUS and (s.id.startswith(own) or "!" not in s.id)
    }


def drawing(book: Book, number: int) -> str:
    """The diagram of a behaviour, for a page that lights it, as SVG of our own making; empty when there is none.

    Raises:
        SheetsError: it is too long, or cannot be laid out.
    """
    from rrp_sheets.render.diagram import draw_diagram
    from rrp_sheets.runs.drawings import MOST_ROWS

    if book.graph is None or not 0 <= number < len(book.graph.behaviours):
        return ""
    behaviour = book.graph.behaviours[number]
    if any(i not in book.graph.streams for s in behaviour.steps for i in (*s.inputs, s.output)):
        return ""
    if len(behaviour.steps) > MOST_ROWS:
        raise SheetsError(f"“{behaviour.name}” is too long to be drawn: more than {MOST_ROWS} rows.", "")
    drawn = draw_diagram(book.graph, behaviour, whole=True, room=True, timeout=_SECONDS)
    return drawn[0].svg if drawn else ""
