"""The shelf: every workbook of the folder with what there is to know before opening it."""

from __future__ import annotations

from collections.abc import Iterable

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.resources import bundled
from rrp_sheets.web.library import MOST_FILES, Book, Library, addressable, printable
from rrp_sheets.web.pages import Card, Count, ShelfPage, Unreadable


def template_names() -> tuple[str, ...]:
    """What a new workbook may begin with."""
    return ("guided", "empty", *sorted(path.stem for path in bundled("workbooks").glob("*.xlsx")))


_NO_TABLES = "FILE017"
_UNSHOWABLE = "Its name has letters that cannot be shown here."


def shelf_page(library: Library, notice: str = "", *, failed: bool = False) -> ShelfPage:
    """What the shelf shows, with what has just been done; raises SheetsError when the folder cannot be read."""
    names = library.names()
    cards: list[Card] = []
    unreadable: list[Unreadable] = []
    others: list[str] = []
    for name in names[:MOST_FILES]:
        if not addressable(name):
            unreadable.append(Unreadable(printable(name), _UNSHOWABLE, "Rename the file."))
            continue
        try:
            book = library.open(name)
        except SheetsError as error:
            if isinstance(error, UnreadableFile) and error.code == _NO_TABLES and not name.casefold().endswith(".xlsx"):
                others.append(name)
                continue
            unreadable.append(Unreadable(name, error.message, error.remedy))
            continue
        if book.reading.format == "markdown" and _is_prose(book):
            others.append(name)
        else:
            cards.append(_card(book))
    folder = printable(str(library.folder.resolve()))
    left_out = max(0, len(names) - MOST_FILES)
    return ShelfPage(folder, tuple(cards), tuple(unreadable), tuple(others), left_out, template_names(), notice, failed)


def counts(findings: Iterable[Diagnostic]) -> tuple[Count, ...]:
    """The findings counted by severity, in words; those that are only information do not count."""
    found = [d.severity.value for d in findings]
    total = {kind: found.count(kind) for kind in ("error", "warning")}
    return tuple(Count(kind, plural(n, kind)) for kind, n in total.items() if n) or (Count("none", "no problems"),)


def plural(count: int, word: str) -> str:
    """A count with its word.

    >>> plural(1, "row"), plural(1200, "row")
    ('1 row', '1,200 rows')
    """
    return f"{count:,} {word}{'' if count == 1 else 's'}"


def changed(book: Book) -> str:
    """When the file was last written, for people."""
    return f"{book.changed.day} {book.changed:%B %Y, %H:%M}"


def _is_prose(book: Book) -> bool:
    """A text such as a README: no behaviour, and nothing in it that was nearly one."""
    workbook = book.look.workbook
    near = any(d.code.startswith("SHEET") and d.code != "SHEET001" for d in book.look.findings)
    return not (workbook.behaviours or workbook.protocol.fields or workbook.scene or near)


def _card(book: Book) -> Card:
    workbook = book.look.workbook
    rows = sum(len(b.rows) for b in workbook.behaviours)
    drawable = book.look.graph.behaviours[:1]
    return Card(
        name=book.name,
        title=book.title,
        about=workbook.protocol.text("Purpose"),
        size=f"{plural(len(workbook.behaviours), 'behaviour')}, {plural(rows, 'row')}",
        changed=changed(book),
        counts=counts(book.look.findings),
        picture=bool(drawable and drawable[0].steps and book.look.understood),
    )
