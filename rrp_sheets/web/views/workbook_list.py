"""Shelf: its page, and the actions that create, copy, rename, archive, upload and download workbooks."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import ClassVar

from flask import Blueprint, Response, request, send_file, url_for

from rrp_sheets import api
from rrp_sheets.documents.copies import begin_tutorial, latest_tutorial
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import RUNS
from rrp_sheets.private import private_folder
from rrp_sheets.recording.metadata import RunMetadata, runs_place
from rrp_sheets.resources import bundled
from rrp_sheets.robots.media_files import SUFFIX as SOUND
from rrp_sheets.robots.media_files import SUFFIXES as PICTURES
from rrp_sheets.services import bundles
from rrp_sheets.services.bundles import Bundle, catalogue_note, has_bundle_suffix, is_device, unpack
from rrp_sheets.texts import N_, LazyMessage, listed, sentences
from rrp_sheets.web.models import KindText, both, counts, error_text, plural, show
from rrp_sheets.web.requests import page_language
from rrp_sheets.web.run_store import RunLine, RunStore, line_of, when
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import (
    MOST_FILES,
    CheckedWorkbook,
    WorkbookRepository,
    addressable,
    printable,
    refuse_text,
)
from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES, write_atomically
from rrp_sheets.workbook.limits import FILE_BYTES

blueprint = Blueprint("workbooks", __name__)
SORTS = ("recent", "name", "run")
ARCHIVE = "archive"
_MADE = (
    ("guided", N_("guided"), N_("every sheet with its headers, and notes that say what to type where")),
    ("empty", N_("empty"), N_("every sheet with its headers, and nothing in them")),
)
_MOST_RUNS = 1_000  # that are looked through for the newest of each workbook
_MOST_WORDS = 4_000  # letters that a search looks through
_UNSHOWABLE = N_("Its name has letters that cannot be shown here.")
_FORBIDDEN = frozenset('/\\:*?"<>|\0')  # in the name of a file
_LONGEST = 100  # letters of the name of a file
_MOST_UPLOADS = 20  # files at once
_MOST_BYTES = 200_000_000  # unpacked; what is sent may have 8 MB
_OTHER_ROBOT = N_("The robot's catalogue in it is another one than this program's, which is used here; `rrp-sheets "
                  "run` on the bundle itself takes the bundle's.")  # fmt: skip
Done = tuple[str, str]
"""Result of an action in words, and the file that exists now; empty for none."""


@dataclass(frozen=True, slots=True)
class Card:
    """Card of a workbook on the shelf: with its Protocol's purpose (`about`) and its newest run, if it has run.

    Attributes:
        size: `2 behaviours, 14 rows`.
        picture: whether its first behaviour can be drawn.
        words: the text that is searched: title, name, purpose, streams, notes.
    """

    name: str
    title: str
    about: str
    size: str
    changed: str
    counts: tuple[KindText, ...]
    picture: bool
    words: str
    last: RunLine | None


@dataclass(frozen=True, slots=True)
class ShelfPage:
    """Shelf: the workbooks of the folder.

    Attributes:
        unreadable: the name of each file that cannot be read, why, a remedy, and whether a URL can have its name.
        others: Markdown files without any sheet of ours.
        templates: the templates for a new workbook, each with what it is called and a line about it.
        notice: the result of the last action, or why it failed (`failed`); `made` is the file that it created.
        tutorial: the copy of the tutorial that was changed last; empty for none.
    """

    template: ClassVar[str] = "shelf.html"
    accepted: ClassVar[str] = ",".join((*WORKBOOK_SUFFIXES, bundles.SUFFIX))
    folder: str
    cards: tuple[Card, ...]
    unreadable: tuple[tuple[str, str, str, bool], ...]
    others: tuple[str, ...]
    left_out: int
    templates: tuple[tuple[str, str, str], ...]
    archived: tuple[str, ...]
    sort: str
    notice: str
    failed: bool
    made: str
    tutorial: str


@cache
def templates() -> tuple[tuple[str, str, str], ...]:
    """Return the templates for a new workbook, each with its title and the first sentence of its purpose."""
    found = {p.stem: api.read(p).workbook.protocol for p in sorted(bundled("workbooks").glob("*.xlsx"))}

    def told(text: str) -> LazyMessage:
        return LazyMessage(text.partition(". ")[0].rstrip(".。"), msgctxt="template")

    return (*_MADE, *((n, told(p.text("Title")), told(p.text("Purpose"))) for n, p in found.items()))


def archived(repository: WorkbookRepository) -> tuple[str, ...]:
    """Return the names of the workbooks in the archive."""
    try:
        found = [p.name for p in (repository.folder / ARCHIVE).iterdir() if p.suffix.casefold() in WORKBOOK_SUFFIXES]
    except OSError:
        return ()
    return tuple(sorted((n for n in found if addressable(n) and n[0] not in ".~"), key=str.casefold)[:MOST_FILES])


def shelf_page(
    repository: WorkbookRepository, notice: str = "", *, failed: bool = False, sort: str = "", made: str = ""
) -> ShelfPage:
    """Build the shelf, with the result of the last action; raises SheetsError if the folder cannot be read."""
    names = repository.names()
    runs = _last_runs(repository, names)
    books: list[CheckedWorkbook] = []
    unreadable: list[tuple[str, str, str, bool]] = []
    others: list[str] = []
    for name in names[:MOST_FILES]:
        if not addressable(name):
            unreadable.append((printable(name), _UNSHOWABLE, N_("Rename the file."), False))
        elif repository.is_text(name):
            others.append(name)
        else:
            try:
                books.append(repository.open(name))
            except SheetsError as error:
                unreadable.append((name, error.message, error.remedy, True))
    sort = sort if sort in SORTS else SORTS[0]
    if sort == "recent":
        books.sort(key=lambda b: b.changed, reverse=True)
    elif sort == "run":
        books.sort(key=lambda b: _ran(runs.get(b.name)), reverse=True)
    return ShelfPage(
        folder=printable(str(repository.folder.resolve())), cards=tuple(_card(b, runs.get(b.name)) for b in books),
        unreadable=tuple(unreadable), others=tuple(others), left_out=max(0, len(names) - MOST_FILES),
        templates=templates(), archived=archived(repository), sort=sort, notice=notice, failed=failed, made=made,
        tutorial=there.name if (there := latest_tutorial(repository.folder)) else "",
    )  # fmt: skip


def _last_runs(repository: WorkbookRepository, names: Collection[str]) -> dict[str, RunMetadata]:
    runs = RunStore(repository.folder)
    found: dict[str, RunMetadata] = {}
    for facts in runs.metadata(runs.names()[:_MOST_RUNS]):
        if facts.workbook in names:
            found.setdefault(facts.workbook, facts)
    return found


def _ran(last: RunMetadata | None) -> float:
    return last.began.timestamp() if last is not None and last.began is not None else 0.0


def _card(book: CheckedWorkbook, last: RunMetadata | None) -> Card:
    workbook = book.analysis.workbook
    rows = [row for behaviour in workbook.behaviours for row in behaviour.rows]
    drawable = book.analysis.graph.behaviours[:1]
    about = workbook.protocol.text("Purpose")
    streams = dict.fromkeys(s.name for s in book.analysis.graph.streams.values() if s.name)
    words = [book.title, book.name, about, *streams, *(row.notes for row in rows if row.notes)]
    return Card(
        name=book.name, title=book.title, about=about, changed=when(book.changed),
        size=listed([plural(len(workbook.behaviours), "behaviour"), plural(len(rows), "row")]),
        counts=counts(book.analysis.findings), words=" ".join(words)[:_MOST_WORDS].casefold(),
        picture=bool(drawable and drawable[0].steps and book.analysis.understood),
        last=line_of(last, ()) if last else None,
    )  # fmt: skip


def _new(repository: WorkbookRepository) -> Done:
    path = new_path(repository, request.form.get("name", ""))
    api.new(path, template=request.form.get("template", "guided"), language=page_language())
    return N_("Created {name}.", name=path.name), path.name


def _tutorial(repository: WorkbookRepository) -> Done:
    path = begin_tutorial(repository.folder, page_language())
    return N_("Created {name}.", name=path.name), path.name


def _copy(repository: WorkbookRepository) -> Done:
    source = repository.path(request.form.get("book", ""))
    target = numbered_path(source)
    if not source.is_file():  # of a pipe the end would be waited for
        message = N_("“{name}” is not a file any more.", name=source.name)
        raise SheetsError(message, N_("Put the workbook there again."))
    write_atomically(target, source.read_bytes(), replace=False)
    return N_("Created {name}.", name=target.name), target.name


def _rename(repository: WorkbookRepository) -> Done:
    source = repository.path(request.form.get("book", ""))
    target = new_path(repository, request.form.get("name", ""), source.suffix)
    with services().open_workbooks.without(source.name):
        source.rename(target)
        services().open_workbooks.renamed(source.name, target.name)
    return N_("{old} is now {new}.", old=source.name, new=target.name), target.name


def _archive(repository: WorkbookRepository) -> Done:
    source = repository.path(request.form.get("book", ""))
    folder = repository.folder / ARCHIVE
    folder.mkdir(exist_ok=True)
    target = numbered_path(folder / source.name)
    with services().open_workbooks.without(source.name):
        shutil.move(source, target)
    return N_("{name} is now in the folder {folder}.", name=source.name, folder=ARCHIVE), ""


def _unarchive(repository: WorkbookRepository) -> Done:
    name = request.form.get("book", "")
    source = repository.folder / ARCHIVE / name
    if name not in archived(repository) or source.is_symlink():
        raise SheetsError(N_("This workbook is not in the archive any more."), N_("Look at the list again."))
    target = numbered_path(repository.folder / name)
    source.rename(target)
    return N_("{name} is restored.", name=target.name), target.name


def _upload(repository: WorkbookRepository) -> Done:
    files = [f for f in request.files.getlist("file") if f.filename]
    if not files:
        raise SheetsError(N_("No file was chosen."), N_("Choose an .xlsx file, or a bundle (.zip)."))
    stored: list[str] = []
    notes: list[str] = []
    for file in files[:_MOST_UPLOADS]:
        try:
            name = Path(file.filename or "").name
            if has_bundle_suffix(Path(name)):
                book, note = take_in(repository.folder, name, file.stream.read())  # of a request of bounded size
                stored.append(book)
                notes.append(note)
            else:
                stored.append(_store(repository, name, file.stream.read(FILE_BYTES + 1)))
        except SheetsError as error:
            done = N_("{names} could be stored.", names=both(stored)) if stored else ""
            raise SheetsError(sentences(error.message, done), error.remedy) from error
    notice = N_("{names} is uploaded." if len(stored) == 1 else "{names} are uploaded.", names=both(stored))
    return sentences(notice, *notes), stored[0] if len(stored) == 1 else ""


_ACTIONS: dict[str, Callable[[WorkbookRepository], Done]] = {
    "new": _new, "copy": _copy, "rename": _rename, "archive": _archive, "unarchive": _unarchive, "upload": _upload,
    "tutorial": _tutorial,
}  # fmt: skip


@blueprint.get("/")
def shelf() -> str:
    """Show the shelf."""
    return show(shelf_page(services().repository, sort=request.args.get("sort", "")))


@blueprint.post(f"/shelf/<any({', '.join(_ACTIONS)}):action>")
def act(action: str) -> Response:
    """Create, copy, rename, archive or upload workbooks, and show the shelf with the result."""
    repository, sort = services().repository, request.args.get("sort", "")
    try:
        notice, made = _ACTIONS[action](repository)
    except SheetsError as error:
        return Response(show(shelf_page(repository, error_text(error), failed=True, sort=sort)))
    answer = Response(show(shelf_page(repository, notice, sort=sort, made=made)))
    if action in ("new", "tutorial"):  # one wants to write in it now
        answer.headers["HX-Redirect"] = url_for("sheet.page", name=made)
    return answer


@blueprint.get("/book/<name>/file")
def download(name: str) -> Response:
    """Send a workbook's file."""
    return send_file(services().repository.path(name).absolute(), as_attachment=True, download_name=name)


def _store(repository: WorkbookRepository, name: str, data: bytes) -> str:
    path = new_path(repository, name)
    write_atomically(path, data, replace=False)
    try:
        api.read(path)
        refuse_text(repository, path.name)
    except SheetsError:
        path.unlink()
        raise
    return path.name


def numbered_path(path: Path) -> Path:
    """Return the path, with a number added to the name when there is such a file."""
    target, count = path, 1
    while target.exists():
        count += 1
        target = path.with_name(f"{path.stem} ({count}){path.suffix}")
    return target


def new_path(repository: WorkbookRepository, wanted: str, suffix: str = ".xlsx") -> Path:
    """Return the path of a new workbook; raises SheetsError for a name that no file can have, and for one in use."""
    name = wanted.strip()
    if name and Path(name).suffix.casefold() not in WORKBOOK_SUFFIXES:
        name += suffix
    is_bad = _FORBIDDEN & set(name) or not name.isprintable() or is_device(name)
    if not name or len(name) > _LONGEST or name[0] in ".~" or is_bad:
        message = N_("“{name}” cannot be the name of a file.", name=wanted[:_LONGEST])
        raise SheetsError(message, N_("Use letters, digits and spaces."))
    path = repository.folder / name
    if path.exists():
        raise SheetsError(N_("There is already a file “{name}”.", name=name), N_("Choose another name."))
    return path


def take_in(folder: Path, name: str, data: bytes) -> tuple[str, str]:
    """Unpack a bundle; its files are stored together or not at all, its runs one by one.

    Returns the workbook's name, and notes on the bundle. Raises SheetsError when it is no bundle, or names are taken.
    """
    with tempfile.TemporaryDirectory(prefix="rrp-bundle-") as scratch:
        packed = Path(scratch) / "upload" / name
        packed.parent.mkdir()
        packed.write_bytes(data)
        bundle = unpack(packed, Path(scratch) / "files", _MOST_BYTES)
        book = bundle.workbook
        if not book.is_file() or book.suffix.casefold() not in WORKBOOK_SUFFIXES or book.name[0] in ".~":
            message = N_("The workbook in this bundle cannot be shown here.")
            raise SheetsError(message, N_("Use `rrp-sheets run` for it."))
        api.read(book)
        runs_place(folder)  # refuses one that leads elsewhere, before anything is stored
        _store_together(folder, _new_files(folder, bundle))
        other = catalogue_note(bundle.folder)
        kept = _take_runs(folder, bundle, with_robot=bool(other))
        notes = [note for note in bundle.notes if note not in other]
    return book.name, sentences(*notes, _OTHER_ROBOT if other else "", *kept)


def _new_files(folder: Path, bundle: Bundle) -> list[Path]:
    """Return the workbook, and the sounds and pictures beside it, that are not in the folder yet."""
    beside = [p for p in sorted(bundle.folder.iterdir()) if p.suffix.casefold() in (SOUND, *PICTURES) and p.is_file()]
    new = []
    for path in (bundle.workbook, *(p for p in beside if p != bundle.workbook and p.name[0] not in ".~")):
        target = folder / path.name
        if not target.exists():
            new.append(path)
        elif not target.is_file() or target.read_bytes() != path.read_bytes():
            message = N_("There is already another file “{name}”.", name=path.name)
            raise SheetsError(message, N_("Rename that one, and upload again."))
    return new


def _store_together(folder: Path, files: list[Path]) -> None:
    done: list[Path] = []
    try:
        for path in files:
            write_atomically(folder / path.name, path.read_bytes(), replace=False)
            done.append(folder / path.name)
    except (SheetsError, OSError):
        for path in done:
            path.unlink(missing_ok=True)
        raise


def _take_runs(folder: Path, bundle: Bundle, *, with_robot: bool) -> list[str]:
    """Store the runs of a bundle beside the existing ones; return notes on those that were not stored."""
    notes: list[str] = []
    for run in bundle.runs:
        target = folder / RUNS / run.name
        if target.exists():
            notes.append(N_("There is a run “{run}” already, which stays as it is.", run=run.name))
            continue
        making = target.with_name(f".{run.name}.part")
        shutil.rmtree(making, ignore_errors=True)
        try:
            private_folder(making)
            run.chmod(0o700)  # which the copy takes over
            shutil.copytree(
                run, making, dirs_exist_ok=True, ignore=None if with_robot else shutil.ignore_patterns(bundles.ROBOTS)
            )
            making.rename(target)
        except OSError as error:  # no room, or another upload was quicker
            shutil.rmtree(making, ignore_errors=True)
            why = error.strerror or N_("is there room for it?")
            notes.append(N_("The run “{run}” could not be stored ({why}).", run=run.name, why=why))
    return notes
