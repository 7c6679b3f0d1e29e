"""Data that several pages share, the pages for messages, and texts cut into pieces of prose and formulas."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from functools import reduce
from typing import ClassVar, Protocol

from flask import render_template
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import StreamKind
from rrp_sheets.page_texts import in_language
from rrp_sheets.texts import N_, sentences
from rrp_sheets.workbook.schema import Column

_CODE = re.compile(r"(`+)(.+?)\1(?!`)")
_COUNTED = {
    "error": (N_("{n:,} error"), N_("{n:,} errors")), "warning": (N_("{n:,} warning"), N_("{n:,} warnings")),
    "behaviour": (N_("{n:,} behaviour"), N_("{n:,} behaviours")), "row": (N_("{n:,} row"), N_("{n:,} rows")),
    "run": (N_("{n:,} run"), N_("{n:,} runs")),
}  # fmt: skip

STREAM_KINDS: Mapping[str, str] = {
    StreamKind.SENSOR.value: N_("sensor"), StreamKind.ORDINARY.value: N_("stream"),
    StreamKind.ACTUATOR.value: N_("actuator"), StreamKind.DONE.value: N_("done"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class KindText:
    """Text with its kind, by which it is shown: a number of problems with its severity, a stream with its kind."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class TextPiece:
    """Piece of a text: plain, or a formula (`code`)."""

    text: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class Head:
    """Header of a column as it is spelt in the sheet.

    Attributes:
        spellings: the keys of it and of its synonyms.
        told: its comments in short; `resolved` is true if they are.
    """

    number: int
    letter: str
    header: str
    spellings: tuple[str, ...]
    column: Column
    told: str = ""
    resolved: bool = False


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


def error_text(error: SheetsError) -> str:
    """Return what an error says is wrong, and what to do about it."""
    return sentences(error.message, error.remedy)


def script_json(data: object, language: str) -> Markup:
    """Format data for a script element of a page, in a language."""
    return htmlsafe_json_dumps(in_language(data, language), ensure_ascii=False)


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


def counts(findings: Iterable[Diagnostic]) -> tuple[KindText, ...]:
    """Count the errors and the warnings among the findings, in words."""
    found = [d.severity.value for d in findings]
    total = {kind: found.count(kind) for kind in ("error", "warning")}
    return tuple(KindText(kind, plural(n, kind)) for kind, n in total.items() if n) or (
        KindText("none", N_("no problems")),
    )


def plural(count: int, word: str) -> str:
    """Format a count with its word.

    >>> plural(1, "row"), plural(1200, "row")
    ('1 row', '1,200 rows')
    """
    return N_(_COUNTED[word][count != 1], n=count)


def both(names: Sequence[str]) -> str:
    """Return names with “and” between them.

    >>> both(["Anna", "Ben", "Cleo"])
    'Anna and Ben and Cleo'
    """
    return reduce(lambda before, after: N_("{before} and {after}", before=before, after=after), names)


_MONTHS = (
    N_("January"), N_("February"), N_("March"), N_("April"), N_("May"), N_("June"), N_("July"), N_("August"),
    N_("September"), N_("October"), N_("November"), N_("December"),
)  # fmt: skip


def date_in_words(day: date) -> str:
    """Format a date.

    >>> date_in_words(date(2026, 11, 2))
    '2 November 2026'
    """
    return N_("{day} {month} {year}", day=day.day, month=_MONTHS[day.month - 1], year=day.year)


def date_and_time(moment: datetime, *, year: bool = True) -> str:
    """Format a moment, with its year or without.

    >>> date_and_time(datetime(2026, 11, 2, 9, 5))
    '2 November 2026, 09:05'
    """
    month, time = _MONTHS[moment.month - 1], f"{moment:%H:%M}"
    template = N_("{day} {month} {year}, {time}" if year else "{day} {month}, {time}")
    return N_(template, day=moment.day, month=month, year=moment.year, time=time)
