"""What the templates get, field by field. `template` is the file in templates/web/ that shows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from flask import render_template
from markupsafe import Markup

from rrp_sheets.model.truths import FALSE_WORDS
from rrp_sheets.web.testing.panel import TestsPanel


@dataclass(frozen=True, slots=True)
class ProblemCount:
    """So many problems of one severity, in words; `kind` is error, warning or none."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class LastRun:
    """A workbook's newest run: its folder's name, when it was, how it ended (`state` is a sign for that)."""

    run: str
    when: str
    ended: str
    state: str
    opens: bool


@dataclass(frozen=True, slots=True)
class Card:
    """A workbook on the shelf.

    Attributes:
        about: the Protocol's purpose.
        size: `2 behaviours, 14 rows`.
        picture: whether its first behaviour can be drawn.
        words: what a search looks through: title, name, purpose, streams, notes.
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
    """A file on the shelf that is no workbook, and why; `addressed` whether something can be done with it here."""

    name: str
    message: str
    remedy: str
    addressed: bool = True


@dataclass(frozen=True, slots=True)
class ShelfPage:
    """The workbooks of the folder.

    Attributes:
        others: Markdown files without any sheet of ours.
        left_out: how many files were not looked at.
        templates: what a new workbook may begin with, with a line about each.
        archived: the names of the files in the archive.
        sort: `recent`, `name` or `run`.
        notice: what has just been done, or why not (`failed`); `made` is the file that it made.
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
    """A finding of the check.

    Attributes:
        number: its place in the list, and on its flag in the diagram.
        severity: error, warning or info; also the word that is shown.
        place: `Tracking!C7`; empty for the whole file.
        cell: `C7`.
        anchor: the id of the row, or else of the sheet, on the page; empty where neither is shown.
        fixes: what can be done about it at once, in words.
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
    fixes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TextPiece:
    """A piece of a text; `code` where it is a formula."""

    text: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class RowSentence:
    """What a row does, in words; `active` is False when it is switched off or nothing feeds it."""

    number: int
    pieces: tuple[TextPiece, ...]
    active: bool


@dataclass(frozen=True, slots=True)
class BehaviourWords:
    """What a behaviour does, in words: all of it, what it takes in and acts on, and row by row."""

    paragraph: tuple[TextPiece, ...]
    sensors: tuple[str, ...]
    actuators: tuple[str, ...]
    rows: tuple[RowSentence, ...]


@dataclass(frozen=True, slots=True)
class Head:
    """A column's header.

    Attributes:
        kind: what its cells hold.
        spellings: the keys of the header and of its synonyms.
        required: whether every sheet of this kind has the column.
    """

    number: int
    letter: str
    header: str
    kind: str
    spellings: tuple[str, ...]
    required: bool


@dataclass(frozen=True, slots=True)
class Tab:
    """A sheet's tab; `here` for the one that is shown."""

    name: str
    kind: str
    here: bool


@dataclass(frozen=True, slots=True)
class Addable:
    """A kind of sheet that can be added: what it is called, a line about it, and the name that is proposed."""

    kind: str
    title: str
    help: str
    name: str


@dataclass(frozen=True, slots=True)
class Strip:
    """The tabs below a sheet.

    Attributes:
        name: the workbook's.
        sheet: the one that is shown.
        tabs: the sheets of ours; then the user's own, whose kind is empty.
        addable: what can be added; nothing where the workbook can only be looked at, or while a run is watched.
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
    """What stands beside and below the grid.

    Attributes:
        sheet: the sheet whose diagram and words are shown.
        left_out: how many problems are not listed.
        drawing: the behaviour's diagram as SVG of our own making; empty for none.
        picture: the behaviour's number, under which the diagram is a file of its own; 0 for none.
        words: what it does; None of a sheet that is no behaviour or cannot be understood yet.
        why: says why there is no diagram.
        checked: False while the first check is under way.
        tests: what the tests came to; None of a workbook without tests.
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
    """A sheet under edit.

    Attributes:
        off_words: the words in the column On that switch a row off, with spaces between them.
        kind: `behaviour`, `devices`, …
        first: the number of the first row.
        examples: whether the rows show example values.
        rows: the table's rows, ready-made.
        vocabulary: the words that are suggested, as JSON.
        read_only: why nothing can be changed; empty when it can.
        hindered: why nothing can be changed just now, because another program has the file, say.
        errors: how many there are; then it cannot run.
        live: this is the run panel.
        acts: what the scene's things can be made to do by hand, as JSON.
        told: the number of the newest change that the page shows already.
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
    strip: Strip
    vocabulary: Markup
    panels: Panels
    read_only: str = ""
    hindered: str = ""
    errors: int = 0
    live: bool = False
    acts: Markup | None = None
    told: str = ""
    version: int = 0


@dataclass(frozen=True, slots=True)
class MessagePage:
    """Something did not go as wished, for someone who may see the rest; `book` is the workbook to go on with."""

    template: ClassVar[str] = "message.html"
    title: str
    message: str
    remedy: str
    reload: bool = False
    book: str = ""


@dataclass(frozen=True, slots=True)
class RefusedPage:
    """For a visitor without the token: tells nothing about the folder, and needs no other file."""

    template: ClassVar[str] = "refused.html"
    title: str
    message: str
    remedy: str


Page = ShelfPage | GridPage | Strip | Panels | MessagePage | RefusedPage


def show(page: Page) -> str:
    """Render a page with its template."""
    return render_template(page.template, page=page)
