"""What can be done on the shelf: a new workbook, a copy, another name, the archive, an upload."""

from __future__ import annotations

import shutil
from pathlib import Path

from flask import Blueprint, Response, request, send_file, url_for

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.web.desk import Desk
from rrp_sheets.web.library import SUFFIXES, Library
from rrp_sheets.web.pages import show
from rrp_sheets.web.shelf import shelf_page
from rrp_sheets.workbook.atomic import write_atomically
from rrp_sheets.workbook.limits import FILE_BYTES

ARCHIVE = "archive"
_FORBIDDEN = frozenset('/\\:*?"<>|\0')
_LONGEST = 100


def make_shelving(library: Library, desk: Desk) -> Blueprint:
    """The routes of the shelf."""
    pages = Blueprint("shelving", __name__)
    actions = {"new": _new, "copy": _copy, "rename": _rename, "archive": _archive, "upload": _upload}

    @pages.post("/shelf/<any(new, copy, rename, archive, upload):action>")
    def act(action: str) -> Response:
        try:
            notice = actions[action](library, desk)
        except SheetsError as error:
            return Response(show(shelf_page(library, f"{error.message} {error.remedy}".strip(), failed=True)))
        answer = Response(show(shelf_page(library, notice)))
        if action == "new":  # one wants to write in it now
            name = _name(request.form.get("name", ""))
            answer.headers["HX-Redirect"] = url_for("editing.book", name=name)
        return answer

    @pages.get("/book/<name>/file")
    def download(name: str) -> Response:
        return send_file(library.path(name).absolute(), as_attachment=True, download_name=name)

    return pages


def _new(library: Library, desk: Desk) -> str:
    path = _free(library, _name(request.form.get("name", "")))
    api.new(path, template=request.form.get("template", "guided"))
    return f"Made {path.name}."


def _copy(library: Library, desk: Desk) -> str:
    source = library.path(request.form.get("book", ""))
    count = 2
    while (target := source.with_name(f"{source.stem} ({count}){source.suffix}")).exists():
        count += 1
    write_atomically(target, source.read_bytes(), replace=False)
    return f"Made {target.name}."


def _rename(library: Library, desk: Desk) -> str:
    source = library.path(request.form.get("book", ""))
    target = _free(library, _name(request.form.get("name", ""), source.suffix))
    desk.leave(source.name)
    source.rename(target)
    return f"{source.name} is now {target.name}."


def _archive(library: Library, desk: Desk) -> str:
    source = library.path(request.form.get("book", ""))
    folder = library.folder / ARCHIVE
    folder.mkdir(exist_ok=True)
    count, target = 2, folder / source.name
    while target.exists():
        target, count = folder / f"{source.stem} ({count}){source.suffix}", count + 1
    desk.leave(source.name)
    shutil.move(source, target)
    return f"{source.name} is in the folder {ARCHIVE} now."


def _upload(library: Library, desk: Desk) -> str:
    file = request.files.get("file")
    if file is None or not file.filename:
        raise SheetsError("No file was chosen.", "Choose an .xlsx file.")
    data = file.stream.read(FILE_BYTES + 1)
    path = _free(library, _name(Path(file.filename).name))
    write_atomically(path, data, replace=False)
    try:
        api.read(path)
    except SheetsError:
        path.unlink()
        raise
    return f"{path.name} is on the shelf."


def _name(wanted: str, suffix: str = ".xlsx") -> str:
    name = wanted.strip()
    if name and Path(name).suffix.casefold() not in SUFFIXES:
        name += suffix
    if not name or len(name) > _LONGEST or name[0] in ".~" or _FORBIDDEN & set(name) or not name.isprintable():
        raise SheetsError(f"“{wanted[:_LONGEST]}” cannot be the name of a file.", "Use letters, digits and spaces.")
    return name


def _free(library: Library, name: str) -> Path:
    path = library.folder / name
    if path.exists():
        raise SheetsError(f"There is already a file “{name}”.", "Choose another name.")
    return path
