"""Data of the pages of runs, kept versions, comparisons and the printed protocol, for their templates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from markupsafe import Markup

from rrp_sheets.render.pack.model import Pack
from rrp_sheets.web.models import TextPiece


@dataclass(frozen=True, slots=True)
class RunLine:
    """Run in a list.

    Attributes:
        run: the name of its folder; `opens` whether it can be opened.
        who: participant and condition.
        mode: simulated, pilot, real; empty when unknown.
        state: `good`, `stopped`, `broken`, `going`, `unreadable`: the icon that is shown.
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
    """List of the recorded runs of the folder.

    Attributes:
        book: only those of this workbook.
        words: only those with these words.
        books: the workbooks that have runs.
        total: how many runs there are; `older` the offset of the next page, 0 on the last one.
        found: how many of them match; `lines_from` the number of the first that is shown.
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
    """Property of a run, from its record."""

    name: str
    value: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class Download:
    """File of the run's folder that can be downloaded."""

    address: str
    name: str
    about: str
    size: str


@dataclass(frozen=True, slots=True)
class LogLine:
    """Entry of a run's log; `at` is in seconds, `when` in words."""

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
    """Row that was changed during the run: the time of the last change, and its line in the log or 0."""

    row: str
    when: str
    line: int


@dataclass(frozen=True, slots=True)
class RecordPage:
    """Page of one recorded run.

    Attributes:
        line: as in the list.
        others: further runs of the same workbook.
        same: whether the workbook in the folder is the one that ran: `same`, `changed`, `gone`, `unknown`.
        pictures: the names of the existing pictures.
        edits: the first rows that were changed, `more_edits` the number of the others.
        trouble: why the events cannot be read.
        writing: its last files are still being written.
        events: the number of events.
        window: the seconds that the marbles show at first.
        participant: the code.
        reading: the size of the record, when it is still to be read; empty when its content is shown.
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
    """Marble diagrams of a run, a fragment of its page.

    Attributes:
        rows: number, connector and formula, whether it is shown.
        first, last: seconds, as they were asked for.
        spread: whether a busy time is drawn in several strips.
        pictures: the diagrams as trusted SVG.
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
        """Numbers of the rows that were asked for; empty for all."""
        return [] if self.all_rows else [number for number, _, shown in self.rows if shown]


@dataclass(frozen=True, slots=True)
class VersionLine:
    """Kept version; `now` when the workbook is the same now."""

    id: int
    name: str
    when: str
    by: str
    now: bool


@dataclass(frozen=True, slots=True)
class VersionsPage:
    """List of the kept versions of a workbook."""

    template: ClassVar[str] = "versions.html"
    name: str
    lines: tuple[VersionLine, ...]
    read_only: str
    notice: str = ""
    failed: bool = False


@dataclass(frozen=True, slots=True)
class Choice:
    """Workbook that can be compared, by its reference."""

    ref: str
    words: str


@dataclass(frozen=True, slots=True)
class ComparePage:
    """Comparison of two workbooks side by side.

    Attributes:
        groups: the choices, under headings.
        book: the workbook that the page belongs to, or empty.
        result: the comparison, as trusted HTML.
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
    """Page for printing a workbook: the options; the protocol itself is requested separately.

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
    """Protocol on the page; `trouble` says why there is none.

    Attributes:
        t: the texts in its language.
        pictures: the diagrams, by the names under which the pack has them.
        pieces: splits a sentence at its formulas.
    """

    template: ClassVar[str] = "protocol.html"
    pack: Pack | None
    t: Mapping[str, str]
    pictures: Mapping[str, Markup]
    legend: Markup
    trouble: str
    pieces: Callable[[str], tuple[TextPiece, ...]] | None = None
