"""Shelf page: every workbook of the folder with its problems and its last run."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cache

from rrp_sheets import api
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.documents.tutorial import latest
from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.runs.records.metadata import RunMetadata
from rrp_sheets.web.pages import Card, LastRun, ProblemCount, ShelfPage, Unreadable
from rrp_sheets.web.records.run_store import RunStore, line_of, when
from rrp_sheets.web.workbook_repository import (
    MOST_FILES,
    SUFFIXES,
    CheckedWorkbook,
    WorkbookRepository,
    addressable,
    printable,
)

SORTS = ("recent", "name", "run")
ARCHIVE = "archive"
_MADE = (
    ("guided", "every sheet with its headers, and notes that say what to type where"),
    ("empty", "every sheet with its headers, and nothing in them"),
)
_MOST_RUNS = 1_000  # that are looked through for the newest of each workbook
_MOST_WORDS = 4_000  # letters that a search looks through
_UNSHOWABLE = "Its name has letters that cannot be shown here."


@cache
def templates() -> tuple[tuple[str, str], ...]:
    """Return the templates for a new workbook, each with a line about it, such as its Protocol's purpose."""
    found = []
    for path in sorted(bundled("workbooks").glob("*.xlsx")):
        found.append((path.stem, api.read(path).workbook.protocol.text("Purpose").partition(". ")[0].rstrip(".")))
    return (*_MADE, *found)


def archived(repository: WorkbookRepository) -> tuple[str, ...]:
    """Return the names of the workbooks in the archive."""
    try:
        found = [p.name for p in (repository.folder / ARCHIVE).iterdir() if p.suffix.casefold() in SUFFIXES]
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
    unreadable: list[Unreadable] = []
    others: list[str] = []
    for name in names[:MOST_FILES]:
        if not addressable(name):
            unreadable.append(Unreadable(printable(name), _UNSHOWABLE, "Rename the file.", addressed=False))
            continue
        if repository.is_text(name):
            others.append(name)
            continue
        try:
            book = repository.open(name)
        except SheetsError as error:
            unreadable.append(Unreadable(name, error.message, error.remedy))
            continue
        books.append(book)
    sort = sort if sort in SORTS else SORTS[0]
    if sort == "recent":
        books.sort(key=lambda b: b.changed, reverse=True)
    elif sort == "run":
        books.sort(key=lambda b: _ran(runs.get(b.name)), reverse=True)
    return ShelfPage(
        folder=printable(str(repository.folder.resolve())), cards=tuple(_card(b, runs.get(b.name)) for b in books),
        unreadable=tuple(unreadable), others=tuple(others), left_out=max(0, len(names) - MOST_FILES),
        templates=templates(), archived=archived(repository), sort=sort, notice=notice, failed=failed, made=made,
        tutorial=there.name if (there := latest(repository.folder)) else "",
    )  # fmt: skip


def _last_runs(repository: WorkbookRepository, names: Collection[str]) -> dict[str, RunMetadata]:
    """Return the newest run of each workbook."""
    runs = RunStore(repository.folder)
    found: dict[str, RunMetadata] = {}
    for facts in runs.facts(runs.names()[:_MOST_RUNS]):
        if facts.workbook in names:
            found.setdefault(facts.workbook, facts)
    return found


def _ran(last: RunMetadata | None) -> float:
    """Return the timestamp of a workbook's last run; 0 when it has not run."""
    return last.began.timestamp() if last is not None and last.began is not None else 0.0


def counts(findings: Iterable[Diagnostic]) -> tuple[ProblemCount, ...]:
    """Count the errors and the warnings among the findings, in words."""
    found = [d.severity.value for d in findings]
    total = {kind: found.count(kind) for kind in ("error", "warning")}
    return tuple(ProblemCount(kind, plural(n, kind)) for kind, n in total.items() if n) or (
        ProblemCount("none", "no problems"),
    )


def plural(count: int, word: str) -> str:
    """Format a count with its word.

    >>> plural(1, "row"), plural(1200, "row")
    ('1 row', '1,200 rows')
    """
    return f"{count:,} {word}{'' if count == 1 else 's'}"


def changed(book: CheckedWorkbook) -> str:
    """Format the time at which the file was last written."""
    return when(book.changed)


def _card(book: CheckedWorkbook, last: RunMetadata | None) -> Card:
    workbook = book.look.workbook
    rows = sum(len(b.rows) for b in workbook.behaviours)
    drawable = book.look.graph.behaviours[:1]
    about = workbook.protocol.text("Purpose")
    return Card(
        name=book.name,
        title=book.title,
        about=about,
        size=f"{plural(len(workbook.behaviours), 'behaviour')}, {plural(rows, 'row')}",
        changed=changed(book),
        counts=counts(book.look.findings),
        picture=bool(drawable and drawable[0].steps and book.look.understood),
        words=" ".join([book.title, book.name, about, *_words(book)])[:_MOST_WORDS].casefold(),
        last=_last(last) if last else None,
    )


def _words(book: CheckedWorkbook) -> list[str]:
    """Return the streams' names and the notes, for the search."""
    behaviours = book.look.workbook.behaviours
    streams = dict.fromkeys(s.name for s in book.look.graph.streams.values() if s.name)
    return [*streams, *(row.notes for b in behaviours for row in b.rows if row.notes)]


def _last(facts: RunMetadata) -> LastRun:
    line = line_of(facts, ())
    return LastRun(line.run, line.when, line.ended, line.state, line.opens)
