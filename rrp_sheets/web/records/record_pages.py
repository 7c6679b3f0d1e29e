"""What the templates of the recorded and the kept get, field by field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from flask import render_template
from markupsafe import Markup

from rrp_sheets.render.pack.model import Pack
from rrp_sheets.web.pages import TextPiece


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
        found: how many of them are like that; `lines_from` the number of the first that is shown.
        participant: only those of this one; `participants` all codes that there are.
    """

    template: ClassVar[str] = "runs.html"
    lines: tuple[RunLine, ...]
    book: str
    words: str
    books: tuple[str, ...]
    total: int
    older: int
    here: bool = False
    participant: str = ""
    participants: tuple[str, ...] = ()
    found: int = 0
    lines_from: int = 1


@dataclass(frozen=True, slots=True)
class RecordDetail:
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
class EditedRow:
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
        participant: the code.
        reading: how large the record is, when it is still to be read; empty when what is in it is shown.
    """

    template: ClassVar[str] = "record.html"
    line: RunLine
    others: tuple[RunLine, ...]
    facts: tuple[RecordDetail, ...]
    same: str
    pictures: frozenset[str]
    downloads: tuple[Download, ...]
    log: tuple[LogLine, ...]
    left_out: int
    sounds: tuple[str, ...]
    errors: Mapping[str, int]
    edits: tuple[EditedRow, ...]
    more_edits: int
    trouble: str
    writing: bool
    events: str
    window: tuple[str, str]
    curves: int
    compared_with: tuple[RunLine, ...]
    participant: str = ""
    reading: str = ""


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

    @property
    def ticked(self) -> list[int]:
        """The rows that were asked for; none for all."""
        return [] if self.all_rows else [number for number, _, shown in self.rows if shown]


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
class PrintPage:
    """A workbook on paper: what can be chosen; the protocol itself follows.

    Attributes:
        own: the language that the Protocol sheet says.
        choice: language, paper and against, as they are asked for.
        has_approved: whether a kept version is called an approved one.
        errors: whether it will be a draft.
    """

    template: ClassVar[str] = "print.html"
    name: str
    title: str
    digest: str
    own: str
    languages: tuple[tuple[str, str], ...]
    papers: tuple[tuple[str, str], ...]
    groups: tuple[tuple[str, tuple[Choice, ...]], ...]
    choice: Mapping[str, str]
    has_approved: bool
    errors: bool


@dataclass(frozen=True, slots=True)
class ProtocolPart:
    """The protocol on the page; `trouble` says why there is none.

    Attributes:
        t: the words of its language.
        pictures: the diagrams, by the names under which the pack has them.
        pieces: cuts a sentence at its formulas.
    """

    template: ClassVar[str] = "protocol.html"
    pack: Pack | None
    t: Mapping[str, str]
    pictures: Mapping[str, Markup]
    legend: Markup
    trouble: str
    pieces: Callable[[str], tuple[TextPiece, ...]] | None = None


Page = RunsPage | RecordPage | MarblesPage | VersionsPage | ComparePage | PrintPage | ProtocolPart


def show(page: Page) -> str:
    """Render a page with its template."""
    return render_template(page.template, page=page)
