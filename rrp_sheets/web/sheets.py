"""The sheets of a workbook as tables, with their problems on the cells."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from rrp_sheets.graph import BehaviourGraph, Graph, Step, StreamKind
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Behaviour, Row
from rrp_sheets.render.sentences import BehaviourText
from rrp_sheets.web import pictures
from rrp_sheets.web.pages import CellView, Name, Piece, Problem, RowView, Sentence, SheetView, Words
from rrp_sheets.workbook.headers import Recognised
from rrp_sheets.workbook.raw import RawCell, RawSheet

MOST_ROWS = 2000
_HEADERS = ("On", "Input streams", "Connector", "Formula", "Output stream", "Notes")

_CODE = re.compile(r"(`+)(.+?)\1(?!`)")

Places = Mapping[int, Mapping[int, Sequence[Problem]]]
"""The problems of a sheet by row and column."""


class BehaviourTable:
    """Makes the table of a behaviour.

    Args:
        graph: of the whole workbook; knows which stream is a sensor and which an actuator.
        icons: the names of the icons there are.
    """

    def __init__(self, graph: Graph, icons: frozenset[str]) -> None:
        self._graph, self._icons = graph, icons

    def view(
        self, behaviour: Behaviour, drawn: BehaviourGraph | None, places: Places, anchor: str,
        said: BehaviourText | None = None,
    ) -> SheetView:  # fmt: skip
        """The table; the diagram's number and the words are added by the page."""
        steps = {s.number: s for s in drawn.steps} if drawn else {}
        sheet = key(behaviour.name)
        rows = tuple(self._row(r, steps.get(r.number), sheet, places, anchor) for r in behaviour.rows[:MOST_ROWS])
        return SheetView(
            anchor, behaviour.name, "Behaviour", _HEADERS, rows,
            problems=elsewhere(places, {r.number for r in rows}),
            left_out=max(0, len(behaviour.rows) - MOST_ROWS),
            picture=self._graph.behaviours.index(drawn) + 1 if drawn and drawn.steps and said else 0,
            words=_words(said) if said else None,
            too_long=len(behaviour.rows) > pictures.MOST_ROWS,
        )  # fmt: skip

    def _row(self, row: Row, step: Step | None, sheet: str, places: Places, anchor: str) -> RowView:
        here = places.get(row.number, {})
        cells = (row.inputs_cell, row.connector, row.formula, row.output)
        inputs, connector, formula, output = (tuple(here.get(c.address.column, ())) for c in cells)
        mine = tuple(p for found in here.values() for p in found)
        rest = tuple(p for p in mine if p not in (*inputs, *connector, *formula, *output))
        names = tuple(self._name(c, sheet) for c in row.inputs)
        made = (self._name(row.output, sheet),) if row.output else ()
        icon = self._icon(row.connector.text)
        views = (
            CellView("on", "on" if row.on else "off", problems=rest),
            CellView("names", names=names, hint="" if names else "↑ row above", problems=inputs),
            CellView("connector", row.connector.text, icon=icon, problems=connector),
            CellView("formula", row.formula.text, problems=formula),
            CellView("names", names=made, hint="" if made else self._output_hint(step), problems=output),
            CellView("notes", row.notes),
        )
        return RowView(f"{anchor}-{row.number}", row.number, views, off=not row.on, problems=mine)

    def _name(self, cell: Cell, sheet: str) -> Name:
        streams = self._graph.streams
        stream = streams.get(f"{sheet}!{key(cell.text)}") or streams.get(key(cell.text))
        return Name(cell.text, stream.kind.value if stream and stream.kind is not StreamKind.ANONYMOUS else "")

    def _icon(self, connector: str) -> str:
        return next((i for i in self._icons if key(i) == key(connector)), "")

    def _output_hint(self, step: Step | None) -> str:
        stream = self._graph.streams.get(step.output) if step else None
        return "↓ row below" if stream and stream.kind is StreamKind.ANONYMOUS else ""


def plain_view(sheet: RawSheet, found: Recognised, places: Places, anchor: str) -> SheetView:
    """The table of a sheet of ours that is no behaviour, as it stands in the file."""
    head = sheet.cells
    columns = [c for r, c in sorted(head) if r == found.row]
    filled = [(n, cells) for n, cells in sheet.rows().items() if n > found.row and any(c in cells for c in columns)]
    rows = tuple(_plain_row(n, cells, columns, places, anchor) for n, cells in filled[:MOST_ROWS])
    return SheetView(
        anchor, sheet.name, found.kind.name.capitalize() if found.kind else "",
        tuple(head[found.row, c].text for c in columns), rows,
        problems=elsewhere(places, {r.number for r in rows}),
        left_out=max(0, len(filled) - MOST_ROWS),
    )  # fmt: skip


def _plain_row(
    number: int, cells: Mapping[int, RawCell], columns: Sequence[int], places: Places, anchor: str
) -> RowView:
    here = places.get(number, {})
    views = tuple(
        CellView("plain", cells[c].typed if c in cells else "", problems=tuple(here.get(c, ()))) for c in columns
    )
    mine = tuple(p for found in here.values() for p in found)
    comment = cells[min(cells)].text.lstrip().startswith("#")
    return RowView(f"{anchor}-{number}", number, views, comment=comment, problems=mine)


def elsewhere(places: Places, rows: set[int]) -> tuple[Problem, ...]:
    """The problems that stand on none of these rows: of the header, say, or of the sheet as a whole."""
    return tuple(p for row, cells in places.items() if row not in rows for found in cells.values() for p in found)


def _words(said: BehaviourText) -> Words:
    rows = tuple(Sentence(r.number, pieces(r.text), r.active) for r in said.rows[:MOST_ROWS])
    return Words(pieces(said.paragraph), said.sensors, said.actuators, rows)


def pieces(text: str) -> tuple[Piece, ...]:
    """A text with formulas in backticks, in its pieces.

    >>> [(p.text, p.code) for p in pieces("When `x > 1` holds")]
    [('When ', False), ('x > 1', True), (' holds', False)]
    """
    found: list[Piece] = []
    end = 0
    for match in _CODE.finditer(text):
        found += [Piece(text[end : match.start()]), Piece(match[2].strip(), code=True)]
        end = match.end()
    return tuple(p for p in (*found, Piece(text[end:])) if p.text)
