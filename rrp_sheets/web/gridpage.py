"""Page of one sheet in the grid or in the run panel, and the panels beside and below it."""

from __future__ import annotations

import json
from dataclasses import replace

from markupsafe import Markup

from rrp_sheets.devices.scene_words import KINDS, verbs_of
from rrp_sheets.documents import Document
from rrp_sheets.documents.grid import Column, Grid
from rrp_sheets.documents.workfile import hindrance
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.render.diagram import draw_diagram
from rrp_sheets.render.sentences import explain
from rrp_sheets.render.svg import frame, text
from rrp_sheets.web.analysis import no_analysis
from rrp_sheets.web.completions import in_browser, vocabulary
from rrp_sheets.web.pages import GridPage, Panels, Problem, words_of
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.sheeting import strip_of
from rrp_sheets.web.testing.panel import panel_of
from rrp_sheets.web.workbook_list import counts
from rrp_sheets.web.workbook_repository import CheckedWorkbook
from rrp_sheets.web.workbook_session import WorkbookSession

MOST_PROBLEMS = 300
FIRST_ROWS = 200  # in the page itself; the others follow


def grid_page(room: WorkbookSession, name: str, sheet: str) -> GridPage:
    """Build the page of a sheet; without a sheet, that of the first behaviour."""
    told = room.told()
    grids = room.document.grids
    first = next((n for n, g in grids.items() if g.kind == "behaviour"), next(iter(grids), ""))
    if sheet in room.document.own:
        other = grid_page(room, name, first)
        return own_page(other, panels(room, name, sheet), room.document, sheet)
    sheet = sheet or first
    beside = panels(room, name, sheet)  # before the rows: a page that says "checked" must not have older rows
    look = room.analysis()
    maker = room.maker(sheet) if sheet else None
    version = grids[sheet].version if sheet else 0  # before the rows, which are of that version or of a later one
    rows = maker.rows(0, FIRST_ROWS) if maker else Markup("")
    return GridPage(
        name=name,
        title=look.workbook.protocol.text("Title") or name,
        sheet=sheet,
        kind=grids[sheet].kind if sheet else "",
        first=grids[sheet].first if sheet else 1,
        heads=tuple(maker.heads()) if maker else (),
        examples=bool(maker and maker.has_examples),
        rows=rows,
        count=len(grids[sheet].rows) if sheet else 0,
        strip=strip_of(room.document, name, sheet),
        vocabulary=_json(vocabulary(no_analysis())),
        panels=beside,
        read_only=room.document.why,
        hindered=hindrance(room.document.path),
        errors=look.errors,
        told=told,
        version=version,
    )


def run_page(room: WorkbookSession, name: str, sheet: str) -> GridPage:
    """Build the page of a sheet for the run panel, with the actions of the scene's things."""
    zones = list(room.analysis().robot.touch_zones)
    acts = {**{kind: verbs_of(kind) for kind in KINDS}, "zones": zones}
    page = grid_page(room, name, sheet)
    return replace(page, live=True, acts=_json(acts), strip=strip_of(room.document, name, page.sheet, live=True))


def _json(data: object) -> Markup:
    return Markup(json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"))


def panels(room: WorkbookSession, name: str, sheet: str) -> Panels:
    """Build the panels: the diagram, the explanation in words, the problems and the tests."""
    look = room.analysis()
    grids = room.document.grids
    problems = []
    for number, d in enumerate(look.findings[:MOST_PROBLEMS], 1):
        place = str(d.address) if d.address else ""
        row = ""
        grid = grids.get(d.address.sheet) if d.address else None
        if d.address and grid is not None and 0 <= d.address.row - grid.first < len(grid.rows):
            row = grid.rows[d.address.row - grid.first]
        problems.append(
            Problem(number, d.severity.value, d.code, place, d.address.cell if d.address else "", row,
                    in_browser(d.message), in_browser(d.remedy), d.address.sheet if d.address else "",
                    tuple(f.title for f in d.fixes))
        )  # fmt: skip
    behaviour = look.behaviour(sheet)
    drawing, words, why = Markup(""), None, ""
    number = next((n for n, b in enumerate(look.graph.behaviours, 1) if b is behaviour), 0)
    if behaviour is not None and behaviour.steps:
        if not look.understood:
            why = "The diagram comes when the problems are mended."
        elif len(behaviour.steps) > MOST_ROWS:
            why = f"This is too long to be drawn here: more than {MOST_ROWS} rows. Divide the sheet."
        else:
            try:
                drawing = Markup(look.drawing(behaviour))
            except SheetsError as error:
                why = f"{error.message} {error.remedy}"
            words = words_of(explain(look.graph, look.workbook, look.robot, [behaviour])[0])
    return Panels(
        name=name, sheet=sheet, counts=counts(look.findings), problems=tuple(problems),
        left_out=max(0, len(look.findings) - MOST_PROBLEMS), drawing=drawing, words=words, why=why,
        checked=look.checked, picture=number, tests=panel_of(room.tests, room.document, sheet),
    )  # fmt: skip


MOST_OWN_ROWS, MOST_COLUMNS = 2_000, 60


def own_page(page: GridPage, panels: Panels, document: Document, name: str) -> GridPage:
    """Build the page of a sheet of the user's own from that of another sheet of the workbook."""
    grid = own_grid(document, name)
    maker = RowRenderer(grid)
    return replace(
        page, panels=panels, sheet=name, kind="own", first=1, heads=tuple(maker.heads()), examples=False,
        count=len(grid.rows), rows=maker.rows(0, MOST_OWN_ROWS),
        strip=strip_of(document, page.name, name),
    )  # fmt: skip


def own_grid(document: Document, name: str) -> Grid:
    """Load the texts of a sheet of the user's own, up to the limits of rows and columns."""
    sheet = next(s for s in document.reading.sheets if s.name == name)
    width = min(max((column for _, column in sheet.cells), default=1), MOST_COLUMNS)
    grid = Grid(name, "own", 1, tuple(Column(number, "") for number in range(1, width + 1)))
    grid.load(sheet)
    del grid.rows[MOST_OWN_ROWS:]
    return grid


_SECONDS = 15.0  # for the layout; a larger diagram is told as too large
_LINE = 16.0
MOST_ROWS = 500
"""Of a behaviour that is drawn and told in words here: nobody reads more beside a table."""


def picture(book: CheckedWorkbook, behaviour: BehaviourGraph) -> str:
    """Draw the behaviour's diagram, or a picture with the reason why there is none."""
    if not book.look.understood:
        return _in_words(["This cannot be drawn yet.", "First mend the problems beside it."])
    if len(behaviour.steps) > MOST_ROWS:
        return _in_words([f"This is too long to be drawn here: more than {MOST_ROWS} rows.", "Divide the sheet."])
    try:
        drawn = draw_diagram(
            book.look.graph, behaviour, problems=book.look.flags(behaviour), whole=True, timeout=_SECONDS
        )
    except SheetsError as error:
        return _in_words([error.message, error.remedy])
    return drawn[0].svg if drawn else _in_words(["There is no row to draw yet."])


def _in_words(lines: list[str]) -> str:
    body = "".join(text(8, 4 + _LINE * (n + 1), line, 11) for n, line in enumerate(lines))
    high = _LINE * len(lines) + 16
    return frame(body, 440, high, ident="why", title="No diagram", description=" ".join(lines))
