"""The grid's requests: the page of a sheet, edits, and the stream of what happens."""

from __future__ import annotations

from typing import Any

from flask import Blueprint, Response, abort, jsonify, request, stream_with_context
from werkzeug.exceptions import BadRequest

from rrp_sheets.documents import CellText, Changed, Document, Refused
from rrp_sheets.web.desk import Desk, Room, stream
from rrp_sheets.web.fixing import make_fix
from rrp_sheets.web.gridpage import grid_page, panels
from rrp_sheets.web.library import Library
from rrp_sheets.web.pages import show

MOST_CELLS = 50_000
MOST_ROWS = 5_000
PIECE = 1_000  # rows that are sent at once
Answer = dict[str, Any]


def make_editing(library: Library, desk: Desk, icons: frozenset[str]) -> Blueprint:
    """The routes of the grid."""
    pages = Blueprint("editing", __name__)

    def room_of(name: str) -> Room:
        if not library.has(name):
            abort(404)
        return desk.room(library.path(name))

    @pages.get("/book/<name>")
    @pages.get("/book/<name>/sheet/<sheet>")
    def book(name: str, sheet: str = "") -> str:
        room = room_of(name)
        room.poll()
        if sheet and sheet not in room.document.grids:
            abort(404)
        return show(grid_page(room, name, sheet, icons))

    @pages.get("/book/<name>/panels/<sheet>")
    def beside(name: str, sheet: str) -> str:
        room = room_of(name)
        if sheet not in room.document.grids:
            abort(404)
        return show(panels(room, name, sheet, icons))

    @pages.get("/book/<name>/rows/<sheet>/<int:first>")
    def more(name: str, sheet: str, first: int) -> str:
        room = room_of(name)
        if sheet not in room.document.grids:
            abort(404)
        return str(room.maker(sheet).rows(first, PIECE))

    @pages.get("/book/<name>/vocabulary")
    def words(name: str) -> Response:
        from rrp_sheets.web.vocabulary import vocabulary

        return jsonify(vocabulary(room_of(name).look()))

    @pages.get("/book/<name>/events")
    def events(name: str) -> Response:
        room = room_of(name)
        if desk.full():
            return Response("Too many pages are open; close some.", 503, {"Retry-After": "30"})
        listener = room.join(request.args.get("client", "")[:40], request.args.get("name", "")[:40] or "Somebody",
                             knows=request.args.get("knows") != "no")  # fmt: skip
        answer = Response(stream_with_context(stream(room, listener)), mimetype="text/event-stream")
        answer.headers["X-Accel-Buffering"] = "no"
        return answer

    @pages.post("/book/<name>/<any(cells, insert, delete, move, undo, redo, lock, unlock, stand, fix):action>")
    def change(name: str, action: str) -> Response:
        room, asked = room_of(name), _asked()
        client, tag = _text(asked, "client"), _text(asked, "tag")
        author = _text(asked, "name") or client
        if action == "stand":
            room.stand(client, author, _place(asked))
            return jsonify({})
        if action == "fix":
            return jsonify(room.change(client, tag, lambda document: make_fix(document, room.look(), author, asked)))
        if action in ("lock", "unlock"):
            return jsonify(_seat(room, client, author, asked, take=action == "lock"))
        return jsonify(room.change(client, tag, lambda document: _make(document, author, action, asked)))

    return pages


def _make(document: Document, author: str, action: str, asked: Answer) -> Changed | None:
    if action in ("undo", "redo"):
        changed = document.undo(author, again=action == "redo")
        if changed is None:
            raise Refused("There is nothing to undo." if action == "undo" else "There is nothing to do again.")
        return changed
    sheet = _text(asked, "sheet")
    if action == "cells":
        cells = asked.get("cells")
        if not isinstance(cells, list) or len(cells) > MOST_CELLS:
            raise BadRequest
        return document.set_cells(author, sheet, [_cell(c) for c in cells])
    before = asked.get("before")
    if before is not None and not isinstance(before, str):
        raise BadRequest
    if action == "insert":
        count = asked.get("count")
        if not isinstance(count, int) or not 1 <= count <= MOST_ROWS:
            raise BadRequest
        return document.insert(author, sheet, before, count)
    rows = asked.get("rows")
    if not isinstance(rows, list) or not rows or not all(isinstance(r, str) for r in rows):
        raise BadRequest
    return document.delete(author, sheet, rows) if action == "delete" else document.move(author, sheet, rows, before)


def _seat(room: Room, client: str, name: str, asked: Answer, *, take: bool) -> Answer:
    place = _place(asked)
    if not take:
        room.release(client, place)
        return {}
    holder = room.take(client, name, place)
    return {"message": f"{holder} is editing this cell.", "taken": True} if holder else {}


def _place(asked: Answer) -> tuple[str, str, int]:
    column = asked.get("column")
    if not isinstance(column, int):
        raise BadRequest
    return _text(asked, "sheet"), _text(asked, "row"), column


def _asked() -> Answer:
    asked = request.get_json(silent=True)
    if not isinstance(asked, dict):
        raise BadRequest
    return asked


def _text(asked: Answer, name: str) -> str:
    value = asked.get(name, "")
    if not isinstance(value, str) or len(value) > 200:
        raise BadRequest
    return value


def _cell(asked: Any) -> CellText:
    if not isinstance(asked, dict):
        raise BadRequest
    row, column, text, was = (asked.get(n) for n in ("row", "column", "text", "was"))
    if not (isinstance(row, str) and isinstance(column, int) and isinstance(text, str)):
        raise BadRequest
    if was is not None and not isinstance(was, str):
        raise BadRequest
    return CellText(row, column, text, was)
