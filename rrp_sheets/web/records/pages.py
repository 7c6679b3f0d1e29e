"""What the templates of the recorded and the kept get, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from flask import render_template
from markupsafe import Markup

from rrp_sheets.web.pages import Problem, Words


@dataclass(frozen=True, slots=True)
class RunLine:
    """A run in a list.

    Attributes:
        run: the name of its folder; `opens` whether it can be opened.
        who: participant and condition.
        mode: simulated, pilot, real; empty when unknown.
        state: `good`, `stopped`, `broken`, `going`, `unreadable`: the sign that is shown.
        ended: how it ended, in words.
        why: what is wrong, or why it broke off, and what can be done.
        book: the workbook's file, when it is in the folder.
    """

    run: str
    opens: bool
    when: str
    workbook: str
    book: str
    who: str
    operator: str
    mode: str
    length: str
    state: str
    ended: str
    why: str
    errors: int


@dataclass(frozen=True, slots=True)
class RunsPage:
    """The recorded runs of the folder.

    Attributes:
        book: only those of this workbook.
        words: only those with these words.
        books: the workbooks that have runs.
        total: how many runs there are; `older` the number to go on from, 0 when these are the last ones.
    """

    template: ClassVar[str] = "runs.html"
    lines: tuple[RunLine, ...]
    book: str
    words: str
    books: tuple[str, ...]
    total: int
    older: int
    here: bool = False


@dataclass(frozen=True, slots=True)
class Fact:
    """Something that the record says of its run."""

    name: str
    value: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class Download:
    """A file of the run's folder, or one that is made of it."""

    address: str
    name: str
    about: str
    size: str


@dataclass(frozen=True, slots=True)
class LogLine:
    """Something that happened; `at` is in seconds, `when` in words."""

    at: float
    when: str
    kind: str
    word: str
    icon: str
    text: str
    row: str
    by: str
    sound: str


@dataclass(frozen=True, slots=True)
class Edited:
    """A row that was changed during the run: when last, and the number of its line in the log, 0 when that has none."""

    row: str
    when: str
    line: int


@dataclass(frozen=True, slots=True)
class RecordPage:
    """One run.

    Attributes:
        line: as in the list.
        others: further runs of the same workbook.
        same: the workbook of the folder is the one that ran: `same`, `changed`, `gone`, `unknown`.
        pictures: the names of the pictures that there are.
        edits: the first rows that were changed, `more_edits` the number of the others.
        trouble: why the events cannot be read.
        writing: its last files are still being written.
        events: how many there are.
        window: the seconds that the marbles show at first.
    """

    template: ClassVar[str] = "record.html"
    line: RunLine
    others: tuple[RunLine, ...]
    facts: tuple[Fact, ...]
    same: str
    pictures: frozenset[str]
    downloads: tuple[Download, ...]
    log: tuple[LogLine, ...]
    left_out: int
    sounds: tuple[str, ...]
    errors: Mapping[str, int]
    edits: tuple[Edited, ...]
    more_edits: int
    trouble: str
    writing: bool
    events: str
    window: tuple[str, str]
    curves: int
    compared_with: tuple[RunLine, ...]


@dataclass(frozen=True, slots=True)
class MarblesPage:
    """The marble diagrams of a run, a piece of its page.

    Attributes:
        rows: number, what it does, whether it is shown.
        first, last: seconds, as they were asked for.
        spread: whether a busy time is drawn in several strips.
        pictures: SVG of our own making.
    """

    template: ClassVar[str] = "marbles.html"
    run: str
    behaviours: tuple[str, ...]
    behaviour: str
    rows: tuple[tuple[int, str, bool], ...]
    all_rows: bool
    first: str
    last: str
    seconds: str
    spread: bool
    pictures: tuple[Markup, ...]
    left_out: int
    trouble: str


@dataclass(frozen=True, slots=True)
class VersionLine:
    """A kept version; `now` when the workbook is the same now."""

    id: int
    name: str
    when: str
    by: str
    now: bool


@dataclass(frozen=True, slots=True)
class VersionsPage:
    """The kept versions of a workbook."""

    template: ClassVar[str] = "versions.html"
    name: str
    lines: tuple[VersionLine, ...]
    kept_now: bool
    read_only: str
    notice: str = ""
    failed: bool = False


@dataclass(frozen=True, slots=True)
class Choice:
    """Something that can be compared."""

    ref: str
    words: str


@dataclass(frozen=True, slots=True)
class ComparePage:
    """Two workbooks side by side.

    Attributes:
        groups: what can be chosen, under headings.
        book: the workbook that the page belongs to, or empty.
        result: the comparison, of our own making.
        trouble: why there is none.
    """

    template: ClassVar[str] = "compare.html"
    groups: tuple[tuple[str, tuple[Choice, ...]], ...]
    first: str
    second: str
    book: str
    result: Markup
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class Drawn:
    """A part of a diagram on paper."""

    svg: Markup
    caption: str
    landscape: bool


@dataclass(frozen=True, slots=True)
class DrawnPart:
    """The diagram of a behaviour, a piece of the printed page; `why` says why there is none."""

    template: ClassVar[str] = "drawn.html"
    name: str
    drawn: tuple[Drawn, ...]
    why: str


@dataclass(frozen=True, slots=True)
class PrintTable:
    """A sheet as a table: its columns (what each holds, and its name), and rows: number, whether off, texts."""

    name: str
    kind: str
    heads: tuple[tuple[str, str], ...]
    rows: tuple[tuple[int, bool, tuple[str, ...]], ...]
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class PrintBehaviour:
    """A behaviour on paper; its diagram follows, unless `why` says why not."""

    name: str
    number: int
    why: str
    table: PrintTable | None
    words: Words | None


@dataclass(frozen=True, slots=True)
class PrintPage:
    """A workbook on paper.

    Attributes:
        fields: of the Protocol: name and text.
    """

    template: ClassVar[str] = "print.html"
    name: str
    title: str
    fields: tuple[tuple[str, str], ...]
    behaviours: tuple[PrintBehaviour, ...]
    tables: tuple[PrintTable, ...]
    problems: tuple[Problem, ...]
    left_out: int
    digest: str
    when: str
    program: str
    tests: str


Page = RunsPage | RecordPage | MarblesPage | VersionsPage | ComparePage | PrintPage | DrawnPart


def show(page: Page) -> str:
    """Render a page with its template."""
    return render_template(page.template, page=page)
