"""What can be done on the shelf: a new workbook, a copy, another name, the archive, an upload."""

from __future__ import annotations

import shutil
from pathlib import Path

from flask import Blueprint, Response, request, send_file, url_for

from rrp_sheets import api
from rrp_sheets.documents.tutorial import begin
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.bundle.names import is_device
from rrp_sheets.runs.bundle.unpacking import is_zip
from rrp_sheets.web.open_workbooks import OpenWorkbooks
from rrp_sheets.web.pages import show
from rrp_sheets.web.unbundling import take_in
from rrp_sheets.web.workbook_list import ARCHIVE, archived, shelf_page
from rrp_sheets.web.workbook_repository import SUFFIXES, WorkbookRepository, refuse_text
from rrp_sheets.workbook.atomic import write_atomically
from rrp_sheets.workbook.limits import FILE_BYTES

_FORBIDDEN = frozenset('/\\:*?"<>|\0')
_LONGEST = 100
_MOST_UPLOADS = 20  # files at once


def make_shelving(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Blueprint:
    """The routes of the shelf."""
    pages = Blueprint("shelving", __name__)
    actions = {
        "new": _new, "copy": _copy, "rename": _rename, "archive": _archive, "unarchive": _unarchive, "upload": _upload,
        "tutorial": _tutorial,
    }  # fmt: skip

    @pages.post("/shelf/<any(new, copy, rename, archive, unarchive, upload, tutorial):action>")
    def act(action: str) -> Response:
        sort = request.args.get("sort", "")
        try:
            notice, made = actions[action](repository, open_workbooks)
        except SheetsError as error:
            notice = f"{error.message} {error.remedy}".strip()
            return Response(show(shelf_page(repository, notice, failed=True, sort=sort)))
        answer = Response(show(shelf_page(repository, notice, sort=sort, made=made)))
        if action in ("new", "tutorial"):  # one wants to write in it now
            answer.headers["HX-Redirect"] = url_for("editing.book", name=made)
        return answer

    @pages.get("/book/<name>/file")
    def download(name: str) -> Response:
        return send_file(repository.path(name).absolute(), as_attachment=True, download_name=name)

    return pages


Done = tuple[str, str]
"""What was done, in words, and the file that is there now; empty for none."""


def _new(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    path = _free(repository, _name(request.form.get("name", "")))
    api.new(path, template=request.form.get("template", "guided"))
    return f"Made {path.name}.", path.name


def _tutorial(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    path = begin(repository.folder)
    return f"Made {path.name}.", path.name


def _copy(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    source = repository.path(request.form.get("book", ""))
    target = _numbered(source)
    if not source.is_file():  # of a pipe the end would be waited for
        raise SheetsError(f"“{source.name}” is no file any more.", "Put the workbook there again.")
    write_atomically(target, source.read_bytes(), replace=False)
    return f"Made {target.name}.", target.name


def _rename(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    source = repository.path(request.form.get("book", ""))
    target = _free(repository, _name(request.form.get("name", ""), source.suffix))
    with open_workbooks.without(source.name):
        source.rename(target)
        open_workbooks.renamed(source.name, target.name)
    return f"{source.name} is now {target.name}.", target.name


def _archive(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    source = repository.path(request.form.get("book", ""))
    folder = repository.folder / ARCHIVE
    folder.mkdir(exist_ok=True)
    target = folder / source.name
    if target.exists():
        target = _numbered(target)
    with open_workbooks.without(source.name):
        shutil.move(source, target)
    return f"{source.name} is in the folder {ARCHIVE} now.", ""


def _unarchive(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    name = request.form.get("book", "")
    source = repository.folder / ARCHIVE / name
    if name not in archived(repository) or source.is_symlink():
        raise SheetsError("This workbook is not in the archive any more.", "Look at the list again.")
    target = repository.folder / name
    if target.exists():
        target = _numbered(target)
    source.rename(target)
    return f"{target.name} is back on the shelf.", target.name


def _upload(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Done:
    files = [f for f in request.files.getlist("file") if f.filename]
    if not files:
        raise SheetsError("No file was chosen.", "Choose an .xlsx file, or a bundle (.zip).")
    stored: list[str] = []
    notes: list[str] = []
    for file in files[:_MOST_UPLOADS]:
        try:
            name = Path(file.filename or "").name
            if is_zip(Path(name)):
                book, note = take_in(repository.folder, name, file.stream.read())  # of a request of bounded size
                stored.append(book)
                notes.append(note)
            else:
                stored.append(_store(repository, name, file.stream.read(FILE_BYTES + 1)))
        except SheetsError as error:
            done = f" {' and '.join(stored)} could be stored." if stored else ""
            raise SheetsError(error.message + done, error.remedy) from error
    verb = "is" if len(stored) == 1 else "are"
    told = " ".join([f"{' and '.join(stored)} {verb} on the shelf.", *notes]).strip()
    return told, stored[0] if len(stored) == 1 else ""


def _store(repository: WorkbookRepository, name: str, data: bytes) -> str:
    path = _free(repository, _name(name))
    write_atomically(path, data, replace=False)
    try:
        api.read(path)
        refuse_text(repository, path.name)
    except SheetsError:
        path.unlink()
        raise
    return path.name


def _numbered(path: Path) -> Path:
    """The same name with a number, that no file has yet."""
    count = 2
    while (target := path.with_name(f"{path.stem} ({count}){path.suffix}")).exists():
        count += 1
    return target


def _name(wanted: str, suffix: str = ".xlsx") -> str:
    name = wanted.strip()
    if name and Path(name).suffix.casefold() not in SUFFIXES:
        name += suffix
    if (
        not name
        or len(name) > _LONGEST
        or name[0] in ".~"
        or _FORBIDDEN & set(name)
        or not name.isprintable()
        or is_device(name)
    ):
        raise SheetsError(f"“{wanted[:_LONGEST]}” cannot be the name of a file.", "Use letters, digits and spaces.")
    return name


def _free(repository: WorkbookRepository, name: str) -> Path:
    path = repository.folder / name
    if path.exists():
        raise SheetsError(f"There is already a file “{name}”.", "Choose another name.")
    return path
