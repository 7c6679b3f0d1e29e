"""Data of the shelf, grid and message pages for their templates, and texts cut into pieces of prose and formulas."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Protocol

from flask import render_template
from markupsafe import Markup

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.model.truths import FALSE_WORDS
from rrp_sheets.render.sentences import BehaviourText
from rrp_sheets.web.testing.panel import TestsPanel
from rrp_sheets.workbook.schema import Column


@dataclass(frozen=True, slots=True)
class ProblemCount:
    """Number of problems of one severity, in words; `kind` is error, warning or none."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class LastRun:
    """Newest run of a workbook: its folder's name, its time, and its end (`state` names the icon for that)."""

    run: str
    when: str
    ended: str
    state: str
    opens: bool


@dataclass(frozen=True, slots=True)
class Card:
    """Card of a workbook on the shelf.

    Attributes:
        about: the Protocol's purpose.
        size: `2 behaviours, 14 rows`.
        picture: whether its first behaviour can be drawn.
        words: the text that is searched: title, name, purpose, streams, notes.
        last: the newest run; None of a workbook that has not run.
    """

    name: str
    title: str
    about: str
    size: str
    changed: str
    counts: tuple[ProblemCount, ...]
    picture: bool
    words: str
    last: LastRun | None


@dataclass(frozen=True, slots=True)
class Unreadable:
    """File on the shelf that cannot be read as a workbook, and why; `addressed`: its name can be used in a URL."""

    name: str
    message: str
    remedy: str
    addressed: bool = True


@dataclass(frozen=True, slots=True)
class ShelfPage:
    """Shelf: the workbooks of the folder.

    Attributes:
        others: Markdown files without any sheet of ours.
        left_out: the number of files that were not read.
        templates: the templates for a new workbook, with a line about each.
        archived: the names of the files in the archive.
        sort: `recent`, `name` or `run`.
        notice: the result of the last action, or why it failed (`failed`); `made` is the file that it created.
        tutorial: the copy of the tutorial that was changed last; empty for none.
    """

    template: ClassVar[str] = "shelf.html"
    folder: str
    cards: tuple[Card, ...]
    unreadable: tuple[Unreadable, ...]
    others: tuple[str, ...] = ()
    left_out: int = 0
    templates: tuple[tuple[str, str], ...] = ()
    archived: tuple[str, ...] = ()
    sort: str = "recent"
    notice: str = ""
    failed: bool = False
    made: str = ""
    tutorial: str = ""


@dataclass(frozen=True, slots=True)
class Problem:
    """Finding of the check.

    Attributes:
        number: its place in the list, and on its flag in the diagram.
        severity: error, warning or info; also the word that is shown.
        place: `Tracking!C7`; empty for the whole file.
        cell: `C7`.
        anchor: the id of the row, or else of the sheet, on the page; empty where neither is shown.
        finding: names it in a request.
        fixes: what can be done about it at once: id and words.
    """

    number: int
    severity: str
    code: str
    place: str
    cell: str
    anchor: str
    message: str
    remedy: str
    sheet: str = ""
    finding: str = ""
    fixes: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class TextPiece:
    """Piece of a text; `code` if it is a formula."""

    text: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class RowSentence:
    """Description of a row in words; `active` is False when it is switched off or has no input."""

    number: int
    pieces: tuple[TextPiece, ...]
    active: bool


@dataclass(frozen=True, slots=True)
class BehaviourWords:
    """Description of a behaviour in words: a summary, its sensors and actuators, and its rows."""

    paragraph: tuple[TextPiece, ...]
    sensors: tuple[str, ...]
    actuators: tuple[str, ...]
    rows: tuple[RowSentence, ...]


@dataclass(frozen=True, slots=True)
class Head:
    """Header of a column.

    Attributes:
        header: as it is spelt in the sheet.
        spellings: the keys of the header and of its synonyms.
        column: of the schema.
    """

    number: int
    letter: str
    header: str
    spellings: tuple[str, ...]
    column: Column


@dataclass(frozen=True, slots=True)
class Tab:
    """Tab of a sheet; `here` for the one that is shown."""

    name: str
    kind: str
    here: bool


@dataclass(frozen=True, slots=True)
class Addable:
    """Kind of sheet that can be added: its title, a line of help, and the proposed name."""

    kind: str
    title: str
    help: str
    name: str


@dataclass(frozen=True, slots=True)
class SheetTabs:
    """Row of tabs below a sheet.

    Attributes:
        name: the workbook's.
        sheet: the one that is shown.
        tabs: the sheets of known kinds; then the user's own, whose kind is empty.
        addable: the sheets that can be added; none if the workbook is read-only, or on the run panel.
        live: this is the run panel.
    """

    template: ClassVar[str] = "tabs.html"
    name: str
    sheet: str
    tabs: tuple[Tab, ...]
    addable: tuple[Addable, ...]
    live: bool = False


@dataclass(frozen=True, slots=True)
class Panels:
    """Panels beside and below the grid.

    Attributes:
        sheet: the sheet whose diagram and words are shown.
        left_out: the number of problems that are not listed.
        drawing: the behaviour's diagram as trusted SVG; empty for none.
        picture: the behaviour's number, under which the diagram is a file of its own; 0 for none.
        words: the description of the behaviour; None if there is none, it is too long, or cannot be described yet.
        why: says why there is no diagram.
        checked: False while the first check is under way.
        tests: the results of the tests; None for a workbook without tests.
    """

    template: ClassVar[str] = "panels.html"
    name: str
    sheet: str
    counts: tuple[ProblemCount, ...]
    problems: tuple[Problem, ...]
    left_out: int
    drawing: Markup
    words: BehaviourWords | None
    why: str
    checked: bool = True
    picture: int = 0
    tests: TestsPanel | None = None


@dataclass(frozen=True, slots=True)
class GridPage:
    """Page of a sheet in the grid or in the run panel.

    Attributes:
        off_words: the words in the column On that switch a row off, with spaces between them.
        kind: `behaviour`, `devices`, …
        first: the number of the first row.
        examples: whether the rows show example values.
        rows: the table's rows, ready-made.
        vocabulary: the words that are suggested, as JSON.
        read_only: why nothing can be changed; empty when it can.
        write_block: why nothing can be changed just now, because another program has the file, say.
        errors: the number of errors; with any, the workbook cannot run.
        live: this is the run panel.
        acts: the actions of the scene's things that can be triggered by hand, as JSON.
        newest_event: the number of the newest event that the page includes.
        version: of the order of its rows.
    """

    template: ClassVar[str] = "grid.html"
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
    read_only: str = ""
    write_block: str = ""
    errors: int = 0
    live: bool = False
    acts: Markup | None = None
    newest_event: str = ""
    version: int = 0


@dataclass(frozen=True, slots=True)
class MessagePage:
    """Error page for an authorised user; `book` is the workbook to go on with."""

    template: ClassVar[str] = "message.html"
    title: str
    message: str
    remedy: str
    reload: bool = False
    book: str = ""


@dataclass(frozen=True, slots=True)
class RefusedPage:
    """Error page for an unauthorised visitor: it reveals nothing about the folder, and needs no other file."""

    template: ClassVar[str] = "refused.html"
    title: str
    message: str
    remedy: str


class PageData(Protocol):
    """Data of a page or of a part of one, with the template that shows it."""

    template: ClassVar[str]


def show(page: PageData) -> str:
    """Render a page with its template."""
    return render_template(page.template, page=page)


MOST_ROWS = 2000
_CODE = re.compile(r"(`+)(.+?)\1(?!`)")


def words_of(said: BehaviourText) -> BehaviourWords:
    """Convert the description of a behaviour for the pages."""
    rows = tuple(RowSentence(r.number, pieces(r.text), r.active) for r in said.rows[:MOST_ROWS])
    return BehaviourWords(pieces(said.paragraph), said.sensors, said.actuators, rows)


def pieces(text: str) -> tuple[TextPiece, ...]:
    """Split a text at its formulas in backticks.

    >>> [(p.text, p.code) for p in pieces("When `x > 1` holds")]
    [('When ', False), ('x > 1', True), (' holds', False)]
    """
    found: list[TextPiece] = []
    end = 0
    for match in _CODE.finditer(text):
        found += [TextPiece(text[end : match.start()]), TextPiece(match[2].strip(), code=True)]
        end = match.end()
    return tuple(p for p in (*found, TextPiece(text[end:])) if p.text)


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
