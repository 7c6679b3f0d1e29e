"""The tabs of a workbook, and their routes: adding, renaming, moving, duplicating and deleting sheets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from flask import Blueprint, Response, jsonify, request

from rrp_sheets.documents import Changed, Document, Refused
from rrp_sheets.documents.sheet_edits import language_of_sheets, proposed_name
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.web.models import both, error_text, show
from rrp_sheets.web.requests import (
    Asked,
    json_body,
    number_of,
    page_language,
    sender_of,
    sheet_or_404,
    text_of,
    workbook_or_404,
)
from rrp_sheets.web.workbook_session import WorkbookSession
from rrp_sheets.workbook.schema import TITLES, is_single, title_of

blueprint = Blueprint("tabs", __name__)
MOST_NAMED = 12  # places that are told before a sheet is deleted
_COLUMNS = 2_000  # letters of a new table's columns
NAME = 200  # letters of a name that is looked at; those of a sheet are fewer, which is told
_HELP = {
    "behaviour": N_("what the robot does, one step a row"),
    "devices": N_("names for sensors and actuators, with their settings"),
    "helpers": N_("calculations and numbers for several formulas"),
    "scene": N_("what happens in the simulator"),
    "gestures": N_("movements of your own, as keyframes"),
    "test": N_("values to send, and what must come out"),
    "protocol": N_("what the session is for, and how it runs"),
    "risks": N_("what could go wrong for people, and what reduces it"),
    "table": N_("a table of your own, for formulas"),
}


@dataclass(frozen=True, slots=True)
class SheetTabs:
    """Row of tabs below a sheet.

    Attributes:
        tabs: the names and kinds of the sheets; the kind of the user's own is empty.
        addable: the kind, title, line of help and proposed name of each sheet that can be added; none if none can be.
    """

    template: ClassVar[str] = "tabs.html"
    name: str
    sheet: str
    tabs: tuple[tuple[str, str], ...]
    addable: tuple[tuple[str, str, str, str], ...]
    live: bool = False


@blueprint.get("/book/<name>/tabs/<sheet>")
def tabs(name: str, sheet: str) -> str:
    """Show the tabs below a sheet."""
    document = workbook_or_404(name).document
    sheet = sheet_or_404(document, sheet)
    return show(sheet_tabs(document, name, sheet, live=request.args.get("live") == "yes"))


@blueprint.get("/book/<name>/sheets/about/<sheet>")
def about(name: str, sheet: str) -> Response:
    """Tell what would be lost with a sheet: its rows, and the places that name it."""
    document = workbook_or_404(name).document
    sheet = sheet_or_404(document, sheet)
    try:
        named = document.sheets.naming(sheet)
    except SheetsError as error:
        return jsonify({"message": error_text(error)})
    grid = document.grids.get(sheet)
    rows = sum(bool(grid.texts[row]) for row in list(grid.rows)) if grid is not None else None
    more = len(named) - MOST_NAMED
    return jsonify({"naming": named[:MOST_NAMED], "more": max(0, more), "rows": rows})


@blueprint.post("/book/<name>/sheets/<any(add, rename, move, duplicate, delete):action>")
def change(name: str, action: str) -> Response:
    """Change the sheets of a workbook."""
    session, given = workbook_or_404(name), json_body()
    client, author = sender_of(session, given)
    make = partial(_ACTIONS[action], session, author, given)
    return jsonify(session.change(client, author, text_of(given, "tag"), make))


def _of(document: Document, given: Asked) -> str:
    return document.current(text_of(given, "of"))


def _add(session: WorkbookSession, author: str, given: Asked, document: Document) -> Changed:
    kind, name = text_of(given, "kind"), text_of(given, "title", NAME)
    columns = [text for part in text_of(given, "columns", _COLUMNS).split(",") if (text := " ".join(part.split()))]
    return document.sheets.add(author, kind, name, [columns] if kind == "table" and columns else ())


def _move(session: WorkbookSession, author: str, given: Asked, document: Document) -> Changed | None:
    """Move a sheet one place to the left or right, among the sheets of known kinds or the user's own."""
    sheet, by = _of(document, given), 1 if number_of(given, "by", -1, 1) > 0 else -1
    group = list(document.grids) if sheet in document.grids else list(document.own)
    to = group.index(sheet) + by if sheet in group else -1
    if not 0 <= to < len(group):
        raise Refused(N_("It is already at the end." if sheet in group else "This sheet no longer exists."))
    names = list(document.reading.workbook.sheets)
    after = names[names.index(group[to]) + 1 :][:1] if by > 0 else [group[to]]
    return document.sheets.move(author, sheet, after[0] if after else "")


def _delete(session: WorkbookSession, author: str, given: Asked, document: Document) -> Changed:
    sheet = _of(document, given)
    people = session.locks.others(text_of(given, "client"), sheet)
    if people:
        one, many = N_("{who} is editing a cell of it just now."), N_("{who} are editing a cell of it just now.")
        raise Refused(N_(one if len(people) == 1 else many, who=both(people[:3])), N_("Try again later."))
    return document.sheets.delete(author, sheet)


_ACTIONS: dict[str, Callable[[WorkbookSession, str, Asked, Document], Changed | None]] = {
    "add": _add, "move": _move, "delete": _delete,
    "rename": lambda session, author, given, document: document.sheets.rename(
        author, _of(document, given), text_of(given, "title", NAME)
    ),
    "duplicate": lambda session, author, given, document: document.sheets.duplicate(author, _of(document, given)),
}  # fmt: skip


def sheet_tabs(document: Document, name: str, sheet: str, *, live: bool = False) -> SheetTabs:
    """Build the row of tabs, with one sheet selected."""
    kinds = {n: g.kind for n, g in document.grids.items()} | dict.fromkeys(document.own, "")
    language = language_of_sheets(document.grids.values())
    wanted = {} if live or document.file.read_only else TITLES
    addable = tuple(
        (kind, title_of(kind, page_language()), _HELP[kind], proposed_name(kind, kinds, language)) for kind in wanted
        if not is_single(kind) or kind not in kinds.values()
    )  # fmt: skip
    return SheetTabs(name, document.current(sheet), tuple(kinds.items()), addable, live)
