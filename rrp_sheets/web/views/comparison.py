"""Kept versions of a workbook, and the comparison of two workbooks or versions.

A workbook is named by a reference: `book/NAME` as it is now, `version/ID/NAME`, or `run/RUN` for what ran.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from datetime import datetime
from io import BytesIO
from pathlib import Path
from typing import ClassVar

from flask import Blueprint, Response, abort, request, send_file, url_for
from markupsafe import Markup

from rrp_sheets.compare.as_html import as_part, render
from rrp_sheets.documents import Refused
from rrp_sheets.documents.document import Version
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import WORKBOOK
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_, listed
from rrp_sheets.web.models import both, error_text, show
from rrp_sheets.web.requests import author_name, confirm_download, page_language, workbook_or_404
from rrp_sheets.web.run_store import line_of, when
from rrp_sheets.web.services import Services, services
from rrp_sheets.web.workbook_repository import refuse_text
from rrp_sheets.web.workbook_session import WorkbookSession

Group = tuple[str, tuple[tuple[str, str], ...]]
"""Heading, and the workbooks that can be chosen under it: the reference and the words for each."""
blueprint = Blueprint("comparison", __name__)
blueprint.after_request(confirm_download)
_MOST_RUNS = 40
_LONGEST = 100  # letters of a version's name
_UNSAFE = re.compile(r'[\x00-\x1f/\\:*?"<>|]+')
_GONE = N_("Choose another one from the list.")
_DRAWN = frozenset(("behaviour", "row", "stream", "device", "helper"))  # parts that are seen on a diagram


@dataclass(frozen=True, slots=True)
class VersionsPage:
    """List of the kept versions of a workbook: each, when it was kept, and whether the workbook is the same now."""

    template: ClassVar[str] = "versions.html"
    longest: ClassVar[int] = _LONGEST
    name: str
    lines: tuple[tuple[Version, str, bool], ...]
    read_only: str
    notice: str = ""
    failed: bool = False


@dataclass(frozen=True, slots=True)
class ComparePage:
    """Comparison of two workbooks, those of `book` if not empty: a `result` as trusted HTML, or the `trouble`."""

    template: ClassVar[str] = "compare.html"
    groups: tuple[Group, ...]
    first: str
    second: str
    book: str
    result: Markup
    trouble: str = ""


@blueprint.get("/compare")
def compare() -> str:
    """Show the choice of two workbooks, and their differences when both are chosen."""
    first, second = refs = _refs()
    names = services().repository.workbooks()
    books = [b for b in dict.fromkeys(filter(None, (request.args.get("book", ""), *map(_book_of, refs)))) if b in names]
    groups = choices(books, refs)
    named = dict(choice for _, group in groups for choice in group)
    words = {r: N_("{book} (as it is now)", book=w) if r.startswith("book/") else w for r, w in named.items()}
    result, trouble = Markup(""), ""
    if first and second:
        try:
            result = _result(refs, words)
        except SheetsError as error:
            trouble = error_text(error)
    book = books[0] if len(books) == 1 else ""
    return show(ComparePage(groups, first, second, book, result, trouble))


@blueprint.get("/compare/drawn")
def drawn_changes() -> str:
    """Show the changes as diagrams, for a separate request, or a message why they cannot be drawn."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            first, second = (path_of(services(), ref, Path(folder) / str(n)) for n, ref in enumerate(_refs()))
            return Markup(services().drawer.drawn(first, second, page_language()))  # ours, everything is escaped
        except SheetsError as error:
            return render("trouble.html", language=page_language(), message=error.message, remedy=error.remedy)


@blueprint.get("/compare/changes.css")
def changes_style() -> Response:
    """Send the style sheet of comparisons."""
    return send_file(bundled("templates", "compare", "changes.css"), mimetype="text/css")


@blueprint.get("/book/<name>/versions")
def versions(name: str) -> str:
    """Show the kept versions of a workbook."""
    session = workbook_or_404(name)
    session.poll()
    return show(versions_page(session, name))


@blueprint.post("/book/<name>/versions/<any(keep, restore):action>")
def act(name: str, action: str) -> str:
    """Keep the workbook as it is now, or restore a version."""
    session = workbook_or_404(name)
    try:
        notice = (_keep if action == "keep" else _restore)(session)
    except SheetsError as error:
        return show(versions_page(session, name, error_text(error), failed=True))
    return show(versions_page(session, name, notice))


@blueprint.get("/book/<name>/versions/<int:number>/file")
def version_file(name: str, number: int) -> Response:
    """Send a kept version."""
    document = workbook_or_404(name).document
    found = next((v for v in document.file.versions() if v.id == number), None)
    content = document.file.version_content(number) if found else None
    if found is None or content is None:
        abort(404)
    file = file_name(name, found)  # in any script: a header alone holds no Japanese letters
    return send_file(BytesIO(content), mimetype="application/octet-stream", as_attachment=True, download_name=file)


def _refs() -> tuple[str, str]:
    return request.args.get("first", "")[:400], request.args.get("second", "")[:400]


def choices(books: Sequence[str], refs: Sequence[str] = ()) -> tuple[Group, ...]:
    """Return the choices, in groups: all workbooks, the kept versions of `books`, and workbooks as they ran."""
    runs = services().runs
    names = services().repository.workbooks()
    ran = [line_of(f, names) for f in runs.metadata(runs.names()[:300]) if f.readable]
    mine = [r for r in ran if not books or r.workbook in books or f"run/{r.run}" in refs][:_MOST_RUNS]
    words = {f"run/{r.run}": N_("{workbook}, ran {when}", workbook=r.workbook, when=r.when) for r in mine if r.opens}
    return (*current_and_kept(names, books), *([(N_("As they ran"), tuple(words.items()))] if words else []))


def current_and_kept(names: Sequence[str], books: Sequence[str]) -> list[Group]:
    """Return the groups of all workbooks as they are now, and of the kept versions of `books`; none that is empty."""
    groups: list[Group] = [(N_("Workbooks as they are now"), tuple((f"book/{n}", n) for n in names))]
    for book in books:
        kept = services().open_workbooks.session(services().repository.path(book)).document.file.versions()
        found = tuple((f"version/{v.id}/{book}", listed([v.name, moment(v)])) for v in kept)
        groups.append((N_("Saved versions of {book}", book=book), found))
    return [group for group in groups if group[1]]


def _book_of(ref: str) -> str:
    kind, _, rest = ref.partition("/")
    return rest if kind == "book" else rest.partition("/")[2] if kind == "version" else ""


def _result(refs: tuple[str, str], words: dict[str, str]) -> Markup:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        paths = [path_of(services(), ref, folder / str(n)) for n, ref in enumerate(refs)]
        found = services().queries.compare(*paths)
    first, second = (
        replace(v, source=words.get(ref, v.source)) for ref, v in zip(refs, (found.first, found.second), strict=True)
    )
    drawn = any(c.part in _DRAWN for c in found.changes)
    later = url_for("comparison.drawn_changes", first=refs[0], second=refs[1]) if drawn else ""
    return as_part(replace(found, first=first, second=second), later=later, language=page_language())


def path_of(shared: Services, ref: str, folder: Path) -> Path:
    """Return the path of the file of a reference; a kept version is written into `folder`. Raises SheetsError.

    `shared` are the services: a replay calls this in a thread of its own, where `services()` finds none.
    """
    kind, _, rest = ref.partition("/")
    if kind == "book":
        path = shared.repository.path(rest)
        refuse_text(shared.repository, rest)
        return path.absolute()
    if kind == "run":
        path = shared.runs.place(rest) / WORKBOOK
        if not path.is_file() or path.is_symlink():
            raise SheetsError(N_("The workbook that ran was not saved with this run."), _GONE)
        return path
    number, _, book = rest.partition("/")
    if kind != "version" or not number.isdecimal():
        raise SheetsError(N_("This cannot be compared."), _GONE)
    session = shared.open_workbooks.session(shared.repository.path(book))
    content = session.document.file.version_content(int(number[:15]))
    if content is None:
        raise SheetsError(N_("This version no longer exists."), _GONE)
    folder.mkdir()
    path = folder / book
    path.write_bytes(content)
    return path


def moment(version: Version) -> str:
    """Format the time at which a version was kept."""
    try:
        return when(datetime.fromisoformat(version.at).astimezone())
    except ValueError:
        return version.at


def versions_page(session: WorkbookSession, name: str, notice: str = "", *, failed: bool = False) -> VersionsPage:
    """Build the list, with the result of the last action or the reason why it failed."""
    kept = session.document.file.versions()
    now = "" if session.document.file.read_only else session.document.reading.digest
    lines = tuple((version, moment(version), version.digest == now) for version in kept)
    return VersionsPage(name, lines, session.document.why, notice, failed)


def _keep(session: WorkbookSession) -> str:
    title = " ".join(request.form.get("title", "").split())[:_LONGEST]
    if not title or not title.isprintable():
        remedy = N_("Write what you want to find it by, such as “before the pilot”.")
        raise Refused(N_("A version needs a name."), remedy)
    session.poll()
    session.document.keep_version(author_name(request.form.get("author", "")), title)
    return N_("Saved as “{title}”.", title=title)


def _restore(session: WorkbookSession) -> str:
    """Restore a version; refused while a cell is being edited, whose text would be lost."""
    number = request.form.get("version", "")
    found = next((v for v in session.document.file.versions() if str(v.id) == number), None)
    if found is None:
        raise Refused(N_("This version no longer exists."), N_("Look at the list again."))
    if people := sorted({name for _, name in session.locks.holders().values()}):
        one, many = N_("{who} is editing a cell just now."), N_("{who} are editing a cell just now.")
        message = N_(one if len(people) == 1 else many, who=both(people[:3]))
        raise Refused(message, N_("Restore it when they have finished."))
    author = author_name(request.form.get("author", ""))
    session.document.restore(author, found.id)
    why = N_("{name} has restored the version “{version}”.", name=author, version=found.name)
    session.tell("reload", {"why": why})
    session.check_soon()
    return N_("“{version}” is restored. The workbook as it was before is saved as a version too.", version=found.name)


def file_name(book: str, version: Version) -> str:
    """Return the file name under which a version is downloaded.

    >>> file_name("a.xlsx", Version(1, "before: the/pilot", "", "", ""))
    'a (before the pilot).xlsx'
    """
    path = Path(book)
    return f"{path.stem} ({' '.join(_UNSAFE.sub(' ', version.name).split())}){path.suffix}"
