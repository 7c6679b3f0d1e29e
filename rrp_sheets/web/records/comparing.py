"""Comparison of two workbooks: the choice of them, the page, and the drawn changes.

A workbook is named by a reference: `book/NAME` as it is now, `version/ID/NAME`, or `run/RUN` for what ran.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from flask import url_for
from markupsafe import Markup

from rrp_sheets.compare.as_html import as_part
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.marbles import WORKBOOK
from rrp_sheets.runs.records.query_worker import QueryWorker
from rrp_sheets.web.open_workbooks import OpenWorkbooks
from rrp_sheets.web.records.record_pages import Choice, ComparePage
from rrp_sheets.web.records.run_store import RunStore
from rrp_sheets.web.records.telling import line_of
from rrp_sheets.web.records.versions import moment
from rrp_sheets.web.workbook_repository import WorkbookRepository, addressable, refuse_text

_MOST_RUNS = 40
_GONE = "Choose another one from the list."
_DRAWN = frozenset(("behaviour", "row", "stream", "device", "helper"))  # parts that are seen on a diagram
_LATER = Markup(
    '<div aria-busy="true" hx-get="{}" hx-trigger="load" hx-swap="outerHTML"><p class="quiet">'
    "The changes are being drawn …</p></div>"
)


def compare_page(
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    queries: QueryWorker,
    refs: tuple[str, str],
    asked_book: str,
) -> ComparePage:
    """Build the page; the comparison itself is made when both workbooks are named."""
    first, second = refs
    names = [n for n in repository.workbooks() if addressable(n)]
    books = [b for b in dict.fromkeys(filter(None, (asked_book, *map(_book_of, refs)))) if b in names]
    groups = choices(repository, open_workbooks, runs, books, refs)
    words = {c.ref: f"{c.words} (as it is now)" if c.ref.startswith("book/") else c.words for _, g in groups for c in g}
    result, trouble = Markup(""), ""
    if first and second:
        try:
            result = _result(repository, open_workbooks, runs, queries, refs, words)
        except SheetsError as error:
            trouble = f"{error.message} {error.remedy}".strip()
    return ComparePage(tuple(groups), first, second, books[0] if len(books) == 1 else "", result, trouble)


def choices(
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    books: Sequence[str],
    refs: Sequence[str] = (),
) -> list[tuple[str, tuple[Choice, ...]]]:
    """Return the choices, in groups: all workbooks, the kept versions of `books`, and workbooks as they ran."""
    names = [n for n in repository.workbooks() if addressable(n)]
    groups: list[tuple[str, tuple[Choice, ...]]] = [
        ("Workbooks as they are now", tuple(Choice(f"book/{n}", n) for n in names))
    ]
    for book in books:
        kept = open_workbooks.room(repository.path(book)).document.versions()
        found = tuple(Choice(f"version/{v.id}/{book}", f"{v.name}, {moment(v)}") for v in kept)
        groups.append((f"Kept versions of {book}", found))
    ran = [line_of(f, names) for f in runs.facts(runs.names()[:300]) if f.readable]
    mine = [r for r in ran if not books or r.workbook in books or f"run/{r.run}" in refs][:_MOST_RUNS]
    groups.append(
        ("As they ran", tuple(Choice(f"run/{r.run}", f"{r.workbook}, ran {r.when}") for r in mine if r.opens))
    )
    return [group for group in groups if group[1]]


def _book_of(ref: str) -> str:
    kind, _, rest = ref.partition("/")
    return rest if kind == "book" else rest.partition("/")[2] if kind == "version" else ""


def _result(
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    queries: QueryWorker,
    refs: tuple[str, str],
    words: dict[str, str],
) -> Markup:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        paths = [path_of(repository, open_workbooks, runs, ref, folder / str(n)) for n, ref in enumerate(refs)]
        found = queries.compare(*paths)
    named = [
        replace(version, source=words.get(ref, version.source))
        for ref, version in zip(refs, (found.first, found.second), strict=True)
    ]
    told = replace(found, first=named[0], second=named[1])
    drawn = any(c.part in _DRAWN for c in found.changes)
    return Markup(
        as_part(told, _LATER.format(url_for("records.drawn_changes", first=refs[0], second=refs[1])) if drawn else "")
    )


def drawn_changes(
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    drawer: QueryWorker,
    refs: tuple[str, str],
) -> Markup:
    """Return the changes as diagrams, for a separate request, or a message why they cannot be drawn."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            paths = [
                path_of(repository, open_workbooks, runs, ref, Path(folder) / str(n)) for n, ref in enumerate(refs)
            ]
            return Markup(drawer.drawn(*paths))  # of our own making, everything in it is escaped
        except SheetsError as error:
            return Markup('<p class="notice is-error" role="status">{} {}</p>').format(error.message, error.remedy)


def path_of(
    repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore, ref: str, folder: Path
) -> Path:
    """Return the path of the file that a reference names; a kept version is written into `folder`.

    Raises:
        SheetsError: there is no such file.
    """
    kind, _, rest = ref.partition("/")
    if kind == "book":
        path = repository.path(rest)
        refuse_text(repository, rest)
        return path.absolute()
    if kind == "run":
        path = runs.place(rest) / WORKBOOK
        if not path.is_file() or path.is_symlink():
            raise SheetsError("The workbook that ran was not kept with this run.", _GONE)
        return path
    number, _, book = rest.partition("/")
    if kind != "version" or not number.isdecimal():
        raise SheetsError("This cannot be compared.", _GONE)
    content = open_workbooks.room(repository.path(book)).document.version_content(int(number[:15]))
    if content is None:
        raise SheetsError("There is no such version any more.", _GONE)
    folder.mkdir()
    path = folder / book
    path.write_bytes(content)
    return path
