"""Page of a sheet: its panels and rows, its edits and fixes, and the event stream."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from functools import cache, partial
from typing import Any, ClassVar

from flask import Blueprint, Response, abort, jsonify, redirect, request, stream_with_context, url_for
from markupsafe import Markup
from werkzeug.exceptions import BadRequest
from werkzeug.wrappers import Response as BaseResponse

from rrp_sheets.checks.fixing import replaced
from rrp_sheets.checks.renaming import Renaming
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.report import MORE_LATER, Delete, FixEdit, Insert, Put, checks_wait
from rrp_sheets.documents import CellText, Changed, Document, Refused
from rrp_sheets.documents.document import write_block_reason
from rrp_sheets.documents.grid import (
    AddRows,
    Grid,
    GridColumn,
    PutHeader,
    PutTexts,
    RemoveRows,
    SheetMissing,
    setting_columns,
)
from rrp_sheets.documents.sheet_edits import language_of_sheets
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import FALSE_WORDS, column_letters
from rrp_sheets.render.diagram import draw_diagram
from rrp_sheets.render.sentences import BehaviourText, explain
from rrp_sheets.render.svg import frame, text
from rrp_sheets.robots import Robot
from rrp_sheets.scene.scene_words import KINDS, verbs_of
from rrp_sheets.texts import N_, sentences, translate
from rrp_sheets.web import completions
from rrp_sheets.web.analysis import Analysis, no_analysis
from rrp_sheets.web.diagram_parts import AROUND, part_of, parts
from rrp_sheets.web.first_rows import FirstRow, first_row
from rrp_sheets.web.models import Head, KindText, MessagePage, counts, error_text, script_json, show
from rrp_sheets.web.requests import (
    Asked,
    author_name,
    json_body,
    page_language,
    sender_of,
    sheet_or_404,
    text_of,
    visitor,
    workbook_or_404,
)
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.run_session import LONGEST_TEXTS
from rrp_sheets.web.services import services
from rrp_sheets.web.serving import unsent
from rrp_sheets.web.views.lessons import LessonPanel, lesson_panel
from rrp_sheets.web.views.tabs import SheetTabs, sheet_tabs
from rrp_sheets.web.workbook_repository import CheckedWorkbook, printable
from rrp_sheets.web.workbook_session import WorkbookSession, stream
from rrp_sheets.web.workbook_tests import TestsPanel, panel_of
from rrp_sheets.workbook.comments import Comment, Thread, checked_text, new_id, removed, replied, resolved, rewritten
from rrp_sheets.workbook.looks import FILLS
from rrp_sheets.workbook.schema import TITLES, setting_header

MOST_CELLS = 50_000
MOST_NEW_ROWS = 5_000
_MOST_DEVICES = 20  # that one edit adds to the sheet Devices
_ACTIONS = (
    "cells", "insert", "delete", "move", "rename", "replace", "undo", "redo", "lock", "unlock", "stand", "part",
    "fix", "test", "comment", "look", "column",
)  # fmt: skip
_ROW_ID = re.compile(r"w[0-9a-f]{4,32}-[0-9]{1,9}", re.ASCII)
_OWN_ROW = re.compile(r"r[0-9]{1,7}", re.ASCII)  # of a sheet of the user's own, by its number
_COLUMN = re.compile(r"[0-9]{1,5}", re.ASCII)
PIECE = 1_000  # rows that are sent at once
_OLD = N_("This is no longer what the check says.")
_LOOK = N_("Look at the problems again.")
MOST_LISTED_THREADS, MOST_LISTED_TEXT = 2_000, 300
MOST_PROBLEMS = 300  # that are listed; of the others the number
FIRST_ROWS = 200  # in the page itself; the others follow
MOST_OWN_ROWS, MOST_COLUMNS = 2_000, 60  # of a sheet of the user's own
_SECONDS = 15.0  # for the layout; a larger diagram is told as too large
_LINE = 16.0  # from line to line of a text in place of a diagram
MOST_DRAWN_ROWS = 500  # of a behaviour that is drawn and told in words here: nobody reads more beside a table
_TOO_LONG = (
    N_("Too large to draw (over {n} rows).", n=MOST_DRAWN_ROWS), N_("Split the sheet."),
)  # fmt: skip

blueprint = Blueprint("sheet", __name__)


@dataclass(frozen=True, slots=True)
class Panels:
    """Panels beside and below the grid.

    Attributes:
        problems: the number of each, also on its flag in the diagram, the id of its row if that is shown, and the
            finding; `left_out` is the number of those that are not listed, `more_later` is said if checks wait.
        drawing: the behaviour's diagram as trusted SVG; empty for none, and then `why` may say why.
        diagram_number: the number of the behaviour, under which the diagram is a file of its own; 0 for none.
        words: the description of the behaviour, if there can be one; `row_ids` are the ids of its rows by number.
        first: what is shown of a sheet without rows; `no_tests` is true for a behaviour without a test.
        parts: what can be shown of a long behaviour, see `diagram_parts`, and which of these is shown.
        too_large: whether it is drawn in parts only.
        checked: False while the first check is under way.
    """

    template: ClassVar[str] = "panels.html"
    name: str
    sheet: str
    counts: tuple[KindText, ...]
    problems: tuple[tuple[int, str, Diagnostic], ...]
    left_out: int
    more_later: str
    drawing: Markup
    words: BehaviourText | None
    row_ids: Mapping[int, str]
    parts: tuple[tuple[str, str], ...]
    part: str
    why: str
    checked: bool
    diagram_number: int
    tests: TestsPanel | None
    too_large: bool
    first: FirstRow | None
    no_tests: bool


@dataclass(frozen=True, slots=True)
class GridPage:
    """Page of a sheet in the grid or, when it is `live`, in the run panel.

    Attributes:
        longest: the most letters of the texts that are sent to a run.
        first: the number of the first row.
        read_only: why nothing can be changed; `write_block` why not now, because another program has the file, say.
        acts: the actions of the scene's things that can be triggered by hand, as JSON.
        newest_event: the number of the newest event that the page includes.
        version: of the order of its rows.
    """

    template: ClassVar[str] = "grid.html"
    longest: ClassVar[Mapping[str, int]] = LONGEST_TEXTS
    off_words: ClassVar[str] = " ".join(sorted(FALSE_WORDS))
    name: str
    title: str
    sheet: str
    kind: str
    first: int
    heads: tuple[Head, ...]
    examples: bool
    rows: Markup
    count: int
    tabs: SheetTabs
    vocabulary: Markup
    panels: Panels
    read_only: str
    write_block: str
    errors: int
    newest_event: str
    version: int
    live: bool
    acts: Markup | None
    lesson: LessonPanel | None


@blueprint.get("/book/<name>")
@blueprint.get("/book/<name>/sheet/<sheet>")
def page(name: str, sheet: str = "") -> str | BaseResponse | tuple[str, int]:
    """Show a sheet in the grid; without a sheet, the first behaviour."""
    session = workbook_or_404(name)
    session.poll()
    now = session.document.current(sheet)
    if now != sheet:  # it was renamed
        return redirect(url_for("sheet.page", name=name, sheet=now))
    if sheet and sheet not in session.document.grids and sheet not in session.document.own:
        message = N_("The workbook has no sheet “{sheet}”: somebody has deleted or renamed it.", sheet=printable(sheet))
        remedy = N_("Look at the workbook’s other sheets.")
        return show(MessagePage(N_("There is no such sheet"), message, remedy, book=name)), 404
    return show(grid_page(session, name, sheet))


@blueprint.get("/book/<name>/panels/<sheet>")
def beside(name: str, sheet: str) -> str:
    """Show the panels beside and below the grid."""
    session = workbook_or_404(name)
    part = request.args.get("part", "")[:20]
    return show(panels(session, name, sheet_or_404(session.document, sheet), part))


@blueprint.get("/book/<name>/rows/<sheet>/<int:first>")
def rows(name: str, sheet: str, first: int) -> Response:
    """Send further rows of a sheet."""
    session = workbook_or_404(name)
    sheet = session.document.current(sheet)
    if sheet not in session.document.grids:
        abort(404)
    grid, after = session.document.grids[sheet], request.args.get("after", "")
    if grid.knows(after):  # the last row that the page has, which may stand elsewhere now, or be gone
        first = grid.index_of(after) + grid.has(after)
    return jsonify(session.piece(sheet, first, PIECE, page_language()))


@blueprint.get("/book/<name>/vocabulary")
def vocabulary(name: str) -> Response:
    """Send the words that are suggested."""
    text, digest = workbook_or_404(name).words(page_language())
    return Response(text, mimetype="application/json", headers={"ETag": f'"{digest}"'})


@blueprint.get("/book/<name>/texts")
def texts(name: str) -> Response:
    """Send the texts of all sheets that can be edited, to be searched in the page."""
    session = workbook_or_404(name)
    found = [(sheet, session.renderer(sheet)) for sheet in tuple(session.document.grids)]
    return jsonify([
        {
            "sheet": sheet,
            "columns": [(head.number, head.letter, head.column.kind) for head in renderer.heads()],
            "rows": [(row, number, dict(t)) for row, number in renderer.grid.numbers().items()
                     if (t := renderer.grid.texts.get(row))],
        }
        for sheet, renderer in found
    ])  # fmt: skip


@blueprint.get("/book/<name>/renaming/<sheet>")
def renaming(name: str, sheet: str) -> Response:
    """Send the cells that change when a stream or a helper gets another name, or why it cannot have that."""
    session = workbook_or_404(name)
    document, old, new = session.document, *(request.args.get(n, "")[:200] for n in ("old", "new"))
    sheet, column = sheet_or_404(document, sheet), request.args.get("column", "")
    cells: list[dict[str, str | None]] = []
    try:
        if _COLUMN.fullmatch(column):
            found = session.renaming_column(sheet, old, new)
            at = f"{column_letters(int(column))}{document.grids[sheet].first - 1}"
            cells.append({"sheet": sheet, "cell": at, "was": old, "text": new})
        else:
            found = _renaming(session, document, sheet, old, new)
    except SheetsError as error:
        return jsonify({"message": error_text(error)})
    return jsonify({
        "cells": [*cells, *map(_shown_edit, found.edits)], "unsafe": [str(at) for at in found.unsafe],
        "unsure": [*map(_shown_edit, found.unsure)],
    })  # fmt: skip


def _shown_edit(edit: Put) -> dict[str, str | None]:
    return {"sheet": edit.address.sheet, "cell": edit.address.cell, "was": edit.was, "text": edit.text}


@blueprint.get("/book/<name>/thread/<sheet>")
def thread(name: str, sheet: str) -> Response:
    """Send the comments of a cell or a header; none for one that is gone."""
    document = workbook_or_404(name).document
    sheet = sheet_or_404(document, sheet)
    row, column = request.args.get("row", ""), request.args.get("column", 0, type=int)
    if grid := document.grids.get(sheet):
        found = grid.marks.thread(row, column)
    else:
        found = document.marks_of(sheet)[0].get((int(row[1:]) if _OWN_ROW.fullmatch(row) else 0, column), ())
    return jsonify({"comments": [asdict(c) for c in found]})


@blueprint.get("/book/<name>/comments")
def comments(name: str) -> Response:
    """Send the comments of all cells, the first of each thread, with the number of its replies."""
    document = workbook_or_404(name).document
    try:
        found = document.comments()
    except SheetsError as error:
        return jsonify({"message": error_text(error)})
    return jsonify({"threads": [
        {"sheet": sheet, "row": row or _own_row(document, sheet, number, column),
         "cell": f"{column_letters(column)}{number}", "replies": len(thread) - 1,
         **asdict(thread[0]), "text": thread[0].text[:MOST_LISTED_TEXT]}
        for sheet, number, column, row, thread in found[:MOST_LISTED_THREADS]
    ], "left_out": max(0, len(found) - MOST_LISTED_THREADS)})  # fmt: skip


@blueprint.get("/book/<name>/diagram/<int:number>.svg")
def diagram(name: str, number: int) -> Response:
    """Send the diagram of a behaviour."""
    repository = services().repository
    if not repository.has(name):
        abort(404)
    opened = repository.open(name)
    behaviours = opened.analysis.graph.behaviours
    if not 1 <= number <= len(behaviours):
        abort(404)
    return Response(picture(opened, behaviours[number - 1]), mimetype="image/svg+xml")


@blueprint.get("/book/<name>/events")
def events(name: str) -> Response:
    """Open the event stream of a page."""
    session = workbook_or_404(name)
    person = visitor()
    client = request.args.get("client", "")[:40]
    if request.method == "HEAD" or not session.is_of(client, person.key):  # HEAD: nobody would listen, nor leave
        abort(405 if request.method == "HEAD" else 403)
    had = request.headers.get("Last-Event-ID") or request.args.get("had", "")  # the former if it had a stream already
    name = author_name(request.args.get("name", ""))
    join = partial(session.join, client, name, language=page_language(), had=had, login_key=person.key)
    listener = services().open_workbooks.listen(session, client, person.key, join)
    if isinstance(listener, str):
        return Response(listener, 503, {"Retry-After": "5"}, mimetype="text/plain")
    listener.unsent = unsent(request.environ)
    messages = stream_with_context(stream(listener, session.about_run, session.leave))
    return Response(messages, mimetype="text/event-stream", headers={"X-Accel-Buffering": "no"})


@blueprint.post(f"/book/<name>/<any({', '.join(_ACTIONS)}):action>")
def change(name: str, action: str) -> Response:
    """Make an edit, or tell the others what the page's user is doing."""
    session, given = workbook_or_404(name), json_body()
    tag, request_id = text_of(given, "tag"), text_of(given, "request")
    client, author = sender_of(session, given)
    if action == "stand":
        session.stand(client, author, _place(given, given))
    elif action == "part":
        session.part(client)
    elif action == "test":
        session.tests.soon(asked=True)
    elif action == "unlock":
        session.unlock(client, _place(given, given))
    elif action == "lock":
        if holder := session.lock(client, author, _place(given, given)):
            return jsonify({"message": N_("{name} is editing this cell.", name=holder), "locked": True})
    else:
        if "unlock" in given:  # an edit of a cell ends its editing and moves the cursor, without further requests
            session.unlock(client, _place(given, given["unlock"]))
        if "stand" in given:
            session.stand(client, author, _place(given, given["stand"]))
        return jsonify(session.change(client, author, tag, partial(_make, session, author, action, given), request_id))
    return jsonify({})


def _make(session: WorkbookSession, author: str, action: str, given: Asked, document: Document) -> Changed | None:
    match action:
        case "fix":
            return make_fix(document, session.analysis(), author, given)
        case "undo" | "redo":
            changed = document.undo(author, redo=action == "redo")
            if changed is None:
                raise Refused(N_("There is nothing to undo." if action == "undo" else "There is nothing to do again."))
            return changed
        case "cells":
            return _set_cells(session, document, author, given)
        case "replace":
            return document.together(author, _replaced(document, given))
        case "rename":
            return _rename_all(session, document, author, given)
        case "comment":
            return _comment(document, author, text_of(given, "sheet"), given)
        case "look":
            return _set_looks(document, author, text_of(given, "sheet"), given)
        case "column":
            return _add_column(session, document, author, given)
    return _change_rows(document, author, action, given)


def _set_cells(session: WorkbookSession, document: Document, author: str, given: Asked) -> Changed:
    sheet, cells = text_of(given, "sheet"), given.get("cells")
    if not isinstance(cells, list) or len(cells) > MOST_CELLS:
        raise BadRequest
    texts = [_cell(c) for c in cells]
    if given.get("rename") is True and len(texts) == 1:
        return _rename(session, document, author, sheet, texts[0])
    if given.get("carried"):
        return document.paste(author, sheet, texts, _carried(given["carried"]))
    added, devices = _added_devices(session.analysis().robot, document, given.get("devices", []))
    if added:
        changed = document.together(author, [PutTexts(document.current(sheet), tuple(texts)), *added])
        return replace(changed, devices=devices)
    return document.set_cells(author, sheet, texts)


def _rename_all(session: WorkbookSession, document: Document, author: str, given: Asked) -> Changed | None:
    """Give a stream, a helper or a column of a table another name, everywhere."""
    sheet, names = document.current(text_of(given, "sheet")), (text_of(given, "old"), text_of(given, "new"))
    if "column" in given:
        return _rename_column(session, document, author, sheet, *names, given)
    steps = list(_steps(document.grids, _renaming(session, document, sheet, *names).edits))
    return document.together(author, steps) if steps else None


def _change_rows(document: Document, author: str, action: str, given: Asked) -> Changed:
    """Insert, delete or move rows."""
    sheet, before = text_of(given, "sheet"), given.get("before")
    if before is not None and not isinstance(before, str):
        raise BadRequest
    if action == "insert":
        return document.insert(author, sheet, before, _new_rows(given))
    rows = given.get("rows")
    if not isinstance(rows, list) or not rows or not all(isinstance(r, str) for r in rows):
        raise BadRequest
    return document.delete(author, sheet, rows) if action == "delete" else document.move(author, sheet, rows, before)


def _add_column(session: WorkbookSession, document: Document, author: str, given: Asked) -> Changed:
    """Add a column to a sheet; the cursor goes there, in the row that the page names."""
    name, grids = text_of(given, "setting").strip(), document.grids
    grid = grids.get(document.current(text_of(given, "sheet")))
    if grid is None or not grid.kind or not name:
        raise BadRequest
    if key(name) in setting_columns(grid):
        raise Refused(N_("The sheet has this column already."), N_("Reload the page."))
    if grid.kind != "table":
        offered = completions.missing_columns(session.analysis(), grid, language_of_sheets(grids.values()))
        name = next((one["text"] for one in offered if key(one["name"]) == key(name)), "")
        if not name:
            raise BadRequest
    step = PutHeader(grid.name, grid.free, name, "")
    return replace(document.together(author, [step]), cursor=(text_of(given, "row"), step.column))


def _new_columns(grid: Grid, columns: dict[str, int], settings: Sequence[str], language: str) -> list[PutHeader]:
    """Return the edits that add columns of settings to the sheet Devices, and note these columns among the others."""
    new = [s for s in dict.fromkeys(settings) if key(s) not in columns]
    columns.update((key(name), grid.free + n) for n, name in enumerate(new))
    return [PutHeader(grid.name, columns[key(s)], setting_header(s, language), "") for s in new]


def _added_devices(
    robot: Robot, document: Document, given: Any
) -> tuple[list[PutTexts | AddRows | PutHeader], tuple[str, ...]]:
    """Return the edits that write devices, which were chosen in another sheet, into the sheet Devices, and their names.

    So are columns of settings that they need. A device or a column that it has, and other settings, are left out.
    """
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given[:_MOST_DEVICES]):
        raise BadRequest
    grid = next((grid for grid in document.grids.values() if grid.kind == "devices"), None)
    columns = setting_columns(grid) if grid else {}
    if grid is None or not {"stream", "device"} <= set(columns):
        return [], ()
    have = {key(grid.text(row, columns["stream"])) for row in grid.rows}
    free = iter(grid.rows[grid.filled() :])
    new = [one for one in given[:_MOST_DEVICES] if key(text_of(one, "stream")) not in have]
    devices = [robot.find(japanese.standard(japanese.DEVICES, text_of(one, "device"))) for one in new]
    chosen = [one.get("settings", {}) for one in new]
    if not all(isinstance(c, dict) and all(isinstance(text, str) for text in c.values()) for c in chosen):
        raise BadRequest
    needed = [
        s.name for d, c in zip(devices, chosen, strict=True) if d for k, s in d.type.settings.items()
        if k not in d.preset and (s.required or s.name in c)
    ]  # fmt: skip
    steps: list[PutTexts | AddRows | PutHeader] = [
        *_new_columns(grid, columns, needed, document.reading.workbook.language)
    ]
    names = []
    for one, settings in zip(new, chosen, strict=True):
        texts = {"Stream": text_of(one, "stream"), "Device": text_of(one, "device"), **settings}
        if key(texts["Stream"]) in have:
            continue
        have.add(key(texts["Stream"]))
        names.append(texts["Stream"])
        cells = {columns[key(name)]: text for name, text in texts.items() if key(name) in columns}
        row = next(free, None)
        if row is None:
            steps.append(AddRows(grid.name, ((grid.new_id(), cells),), None))
        else:
            steps.append(PutTexts(grid.name, tuple(CellText(row, column, text, "") for column, text in cells.items())))
    return steps, tuple(names)


def _replaced(document: Document, given: Asked) -> list[PutTexts]:
    """Validate new texts of cells in several sheets."""
    sheets = given.get("sheets")
    if not isinstance(sheets, list) or not all(isinstance(one, dict) for one in sheets):
        raise BadRequest
    cells = [(document.current(text_of(one, "sheet")), one.get("cells")) for one in sheets]
    if not cells or not all(isinstance(mine, list) and mine for _, mine in cells):
        raise BadRequest
    if sum(len(mine) for _, mine in cells) > MOST_CELLS:
        raise BadRequest
    if missing := next((sheet for sheet, _ in cells if sheet not in document.grids), ""):
        raise SheetMissing(missing)
    return [PutTexts(sheet, tuple(map(_cell, mine))) for sheet, mine in cells]


def _comment(document: Document, author: str, sheet: str, given: Asked) -> Changed:
    """Change the comments of a cell as a page asks for it (`what`)."""
    what, text, id = text_of(given, "what"), given.get("text", ""), given.get("id", "")
    column = given.get("column")
    if not (isinstance(column, int) and isinstance(text, str) and isinstance(id, str)):
        raise BadRequest
    if what in ("add", "edit"):
        text = checked_text(text)
    at = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")[:22] + "Z"
    changes: dict[str, Callable[[Thread], Thread]] = {
        "add": lambda now: replied(now, Comment(new_id(), author, at, text)),
        "edit": lambda now: rewritten(now, id, author, text),
        "delete": lambda now: removed(now, id, author),
        "clear": lambda now: (),
        "resolve": lambda now: resolved(now, done=True),
        "reopen": lambda now: resolved(now, done=False),
    }
    if what not in changes:
        raise BadRequest
    return document.comment(author, sheet, text_of(given, "row"), column, changes[what])


def _carried(given: Any) -> list[tuple[tuple[str, int], tuple[str, int]]]:
    """Validate which comments go from one cell to another."""
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        raise BadRequest
    sources, targets = _places({"cells": given}), _places({"cells": [one.get("to") for one in given]})
    return list(zip(sources, targets, strict=True))


def _set_looks(document: Document, author: str, sheet: str, given: Asked) -> Changed:
    return document.set_looks(author, sheet, _places(given), _look(given))


def _places(given: Asked) -> list[tuple[str, int]]:
    cells = given.get("cells")
    if not isinstance(cells, list) or not 0 < len(cells) <= MOST_CELLS:
        raise BadRequest
    if not all(isinstance(c, dict) and isinstance(c.get("column"), int) for c in cells):
        raise BadRequest
    return [(text_of(c, "row"), c["column"]) for c in cells]


def _look(given: Asked) -> dict[str, bool | str]:
    """Validate how cells are to look: bold or not, of one of our colours or none, with long texts broken or not."""
    look = {name: given[name] for name in ("bold", "fill", "wrap") if name in given}
    fill = look.get("fill", "")
    if fill not in ("", *FILLS) or not all(isinstance(look.get(n, False), bool) for n in ("bold", "wrap")) or not look:
        raise BadRequest
    return {name: FILLS.get(fill, "") if name == "fill" else value for name, value in look.items()}


def _rename(session: WorkbookSession, document: Document, author: str, sheet: str, cell: CellText) -> Changed:
    """Change a cell that gives a name, and all cells that have it.

    Only that cell is changed where another one gives the name too, or the new name cannot be used: the check tells it.
    """
    sheet = document.current(sheet)
    edits: tuple[Put, ...] = ()
    if cell.was:
        with suppress(SheetsError):
            edits = _renaming(session, document, sheet, cell.was, cell.text).edits
    steps = list(_steps(document.grids, edits))
    cells = [(step.sheet, one) for step in steps if isinstance(step, PutTexts) for one in step.cells]
    giving = [one.row for place, one in cells if place == sheet and one.column == cell.column]
    if len(steps) < 2 or giving != [cell.row]:
        return document.set_cells(author, sheet, [cell])
    return document.together(author, steps)


def _rename_column(
    session: WorkbookSession, document: Document, author: str, sheet: str, old: str, new: str, given: Asked
) -> Changed:
    """Give a column of a table another name, also in the uncertain places that the page names (`also`)."""
    column, also = given.get("column"), given.get("also", [])
    if not isinstance(column, int) or not isinstance(also, list) or sheet not in document.grids:
        raise BadRequest
    found = session.renaming_column(sheet, old, new.strip()).including(also)
    steps = list(_steps(document.grids, found.edits))
    return document.together(author, [PutHeader(sheet, column, new.strip(), old), *steps])


def _renaming(session: WorkbookSession, document: Document, sheet: str, old: str, new: str) -> Renaming:
    """Return the edits that give what a cell of a sheet names (in a test also `Tracking!Far`) another name."""
    grid = document.grids.get(sheet)
    near = sheet if grid is None or grid.kind == "behaviour" else TITLES[grid.kind]
    given, _, name = old.rpartition("!")
    return session.renaming(name.strip(), new.strip(), given.strip().strip("'") or near)


def _new_rows(given: Asked) -> list[tuple[str, dict[int, str]]]:
    """Validate rows that a page has created; return their ids, and their texts by column."""
    rows = given.get("rows")
    if not isinstance(rows, list) or not 1 <= len(rows) <= MOST_NEW_ROWS:
        raise BadRequest
    made = []
    for one in rows:
        texts = one.get("texts", {}) if isinstance(one, dict) else None
        if not isinstance(texts, dict) or not all(
            _COLUMN.fullmatch(c) and isinstance(t, str) for c, t in texts.items()
        ):
            raise BadRequest
        made.append((text_of(one, "id"), {int(column): text for column, text in texts.items() if text}))
    if not all(_ROW_ID.fullmatch(row) for row, _ in made) or len(dict(made)) < len(made):
        raise BadRequest
    return made


def _place(given: Asked, cell: Any) -> tuple[str, str, int]:
    if not isinstance(cell, dict) or not isinstance(cell.get("column"), int):
        raise BadRequest
    return text_of(given, "sheet"), text_of(cell, "row"), cell["column"]


def _cell(given: Any) -> CellText:
    if not isinstance(given, dict):
        raise BadRequest
    row, column, text, was = (given.get(n) for n in ("row", "column", "text", "was"))
    if not (isinstance(row, str) and isinstance(column, int) and isinstance(text, str)):
        raise BadRequest
    if was is not None and not isinstance(was, str):
        raise BadRequest
    return CellText(row, column, text, was)


def make_fix(document: Document, analysis: Analysis, author: str, asked: dict[str, Any]) -> Changed:
    """Apply the fix that a user has chosen in the list of problems: `asked` holds the ids of `finding` and `fix`.

    Raises:
        Refused: the problem is not there any more, or the fix does not fit the sheet as it is now.
    """
    finding = next((d for d in analysis.findings if d.fixes and d.id == asked.get("finding")), None)
    fix = next((f for f in finding.fixes if f.id == asked.get("fix")), None) if finding else None
    if fix is None:
        raise Refused(_OLD, _LOOK)
    sheets = {_place_of(one)[0] for one in fix.edits}
    missing = sorted(name for name in sheets if name not in document.grids)
    if missing:
        message = N_("There is no sheet “{sheet}” that this fix could change.", sheet=missing[0])
        raise Refused(message, N_("Create it, or fix this by hand."))
    steps = list(_steps(document.grids, fix.edits))
    if not steps:
        raise Refused(_OLD, _LOOK)
    changed, at = document.together(author, steps), fix.fill
    row = document.grids[at.sheet].row_at(at.row - document.grids[at.sheet].first) if at else None
    return replace(changed, cursor=(row, at.column)) if at and row else changed


def _steps(
    grids: Mapping[str, Grid], edits: Sequence[FixEdit]
) -> Iterator[PutTexts | AddRows | RemoveRows | PutHeader]:
    """Yield the edits of a fix with row ids; each of its row numbers counts the rows as the edit before left them."""
    order: dict[str, list[str]] = {}
    for one in edits:
        sheet, number = _place_of(one)
        grid = grids[sheet]
        rows, place = order.setdefault(sheet, list(grid.rows)), number - grid.first
        if place == -1 and isinstance(one, Put) and one.text:
            yield PutHeader(sheet, one.address.column, one.text, "")
            continue
        if not 0 <= place < len(rows) + isinstance(one, Insert):
            raise Refused(_OLD, _LOOK)
        if isinstance(one, Insert):
            row = grid.new_id()
            yield AddRows(sheet, ((row, dict(one.cells)),), rows[place] if place < len(rows) else None)
            rows.insert(place, row)
            continue
        if isinstance(one, Delete):
            yield RemoveRows(sheet, (rows.pop(place),))
            continue
        now = grid.text(rows[place], one.address.column)
        if isinstance(one, Put) and one.was not in (None, now):
            raise Refused(_OLD, _LOOK)
        text = one.text if isinstance(one, Put) else replaced(now, one)
        if text != now:
            yield PutTexts(sheet, (CellText(rows[place], one.address.column, text, now),))


def _place_of(one: FixEdit) -> tuple[str, int]:
    """Return the sheet of an edit and the number of its row; of an insertion that of the row after it."""
    if isinstance(one, Insert):
        return one.sheet, one.before
    return (one.sheet, one.row) if isinstance(one, Delete) else (one.address.sheet, one.address.row)


@cache
def _first_words(language: str) -> Markup:
    """Return the suggestions that all pages have at first, without their workbooks' own, which they fetch."""
    return script_json(completions.vocabulary(no_analysis()), language)


def grid_page(session: WorkbookSession, name: str, sheet: str, *, live: bool = False) -> GridPage:
    """Build the page of a sheet, by default of the first behaviour; if `live`, for the run panel."""
    newest_event = session.backlog.number
    document, grids = session.document, session.document.grids
    sheet = sheet or next((n for n, g in grids.items() if g.kind == "behaviour"), next(iter(grids), ""))
    beside = panels(session, name, sheet)  # before the rows: a page that says "checked" must not have older rows
    analysis = session.analysis()
    own = sheet in document.own
    renderer = RowRenderer(own_grid(document, sheet)) if own else session.renderer(sheet) if sheet else None
    grid = renderer.grid if renderer else None
    zones = [(zone, N_(zone, msgctxt="value")) for zone in analysis.robot.touch_zones]
    acts = {**{kind: verbs_of(kind) for kind in KINDS}, "zones": zones}
    version = grid.version if grid else 0  # before the rows, which are of that version or of a later one
    rows = renderer.rows(0, MOST_OWN_ROWS if own else FIRST_ROWS, page_language()) if renderer else Markup("")
    return GridPage(
        name=name, title=analysis.workbook.protocol.text("Title") or name, sheet=sheet,
        kind=grid.kind if grid else "", first=grid.first if grid else 1, rows=rows,
        heads=tuple(renderer.heads()) if renderer else (), count=len(grid.rows) if grid else 0,
        examples=bool(renderer and renderer.has_examples), tabs=sheet_tabs(document, name, sheet, live=live),
        vocabulary=_first_words(page_language()),
        panels=beside, read_only=document.why, write_block=write_block_reason(document.path),
        errors=analysis.errors, newest_event=newest_event, version=version, live=live,
        acts=script_json(acts, page_language()) if live else None,
        lesson=None if live else lesson_panel(session.tests, document, name, sheet),
    )  # fmt: skip


def panels(session: WorkbookSession, name: str, sheet: str, part: str = "") -> Panels:
    """Build the panels: the diagram and the words of a behaviour or a part of it, the problems and the tests."""
    analysis = session.analysis()
    grids = session.document.grids
    problems = []
    for number, d in enumerate(analysis.findings[:MOST_PROBLEMS], 1):
        grid = grids.get(d.address.sheet) if d.address else None
        place = d.address.row - grid.first if d.address and grid else -1
        problems.append((number, grid.rows[place] if grid and 0 <= place < len(grid.rows) else "", d))
    behaviour = analysis.behaviour(sheet)
    offered: tuple[tuple[str, str], ...] = ()
    drawing, words, why, too_large = Markup(""), None, "", False
    number = next((n for n, b in enumerate(analysis.graph.behaviours, 1) if b is behaviour), 0)
    if behaviour is not None and behaviour.steps:
        headings = next((b.headings for b in analysis.workbook.behaviours if key(b.name) == behaviour.key), {})
        chosen = replace(behaviour, steps=part_of(behaviour, headings, part))
        offered = parts(behaviour.steps, headings)
        if not analysis.understood:
            why = N_("The diagram appears when the problems are fixed.")
        elif len(chosen.steps) > MOST_DRAWN_ROWS:
            why, too_large = sentences(*_TOO_LONG), True
        else:
            try:
                drawing = Markup(analysis.drawing(chosen, page_language()))
            except SheetsError as error:
                why = error_text(error)
            words = explain(analysis.graph, analysis.workbook, [chosen], language=page_language())[0]
    here = grids.get(sheet)
    return Panels(
        name=name, sheet=sheet, counts=counts(analysis.findings), problems=tuple(problems),
        left_out=max(0, len(analysis.findings) - MOST_PROBLEMS),
        more_later=MORE_LATER if checks_wait(analysis.findings) else "", drawing=drawing, words=words, why=why,
        parts=offered, part=AROUND if part.startswith(AROUND) else part,
        row_ids=dict(enumerate(here.rows, here.first)) if here and words else {},
        checked=analysis.checked, diagram_number=number, tests=panel_of(session.tests, session.document, sheet),
        too_large=too_large, first=first_row(here) if not session.document.why else None,
        no_tests=bool(behaviour and behaviour.steps) and not session.tests.sheets and not session.document.why,
    )  # fmt: skip


def own_grid(document: Document, name: str) -> Grid:
    """Load the texts, comments and looks of a sheet of the user's own, up to the limits of rows and columns."""
    sheet = next(s for s in document.reading.sheets if s.name == name)
    threads, looks = document.marks_of(name)
    width = min(max((column for _, column in (*sheet.cells, *threads)), default=1), MOST_COLUMNS)
    grid = Grid(name, "own", 1, tuple(GridColumn(number, "") for number in range(1, width + 1)))
    grid.load(sheet)
    grid.add_blank(min(max((number for number, _ in threads), default=0), MOST_OWN_ROWS) - len(grid.rows))
    grid.texts = {f"r{number}": grid.texts[row] for row, number in grid.numbers().items() if number <= MOST_OWN_ROWS}
    grid.rows = [*grid.texts]
    grid.marks.load(dict(enumerate(grid.rows, 1)), threads, looks)
    return grid


def _own_row(document: Document, sheet: str, number: int, column: int) -> str:
    """Return the id of a row of a sheet of the user's own if the cell is shown, else an empty text."""
    shown = sheet in document.own and number <= MOST_OWN_ROWS and column <= MOST_COLUMNS
    return f"r{number}" if shown else ""


def picture(book: CheckedWorkbook, behaviour: BehaviourGraph) -> str:
    """Draw the behaviour's diagram, or a picture with the reason why there is none."""
    if not book.analysis.understood:
        return _in_words([N_("This cannot be drawn yet."), N_("Fix the problems beside it first.")])
    if len(behaviour.steps) > MOST_DRAWN_ROWS:
        return _in_words(_TOO_LONG)
    try:
        drawn = draw_diagram(
            book.analysis.graph,
            behaviour,
            problems=book.analysis.flags(behaviour),
            whole=True,
            timeout=_SECONDS,
            language=page_language(),
        )
    except SheetsError as error:
        return _in_words([error.message, error.remedy])
    return drawn[0].svg if drawn else _in_words([N_("There is no row to draw yet.")])


def _in_words(lines: Sequence[str]) -> str:
    said = [translate(line, page_language()) for line in lines]
    body = "".join(text(8, 4 + _LINE * (n + 1), line, 11) for n, line in enumerate(said))
    title = translate(N_("No diagram"), page_language())
    return frame(body, 440, _LINE * len(said) + 16, ident="why", title=title, description=" ".join(said))
