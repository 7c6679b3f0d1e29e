"""Rendering of a grid's rows as HTML; a row is rendered again only when something about it has changed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from itertools import islice
from types import MappingProxyType
from typing import Any

from markupsafe import Markup, escape

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.documents.grid import HEADER, Grid, GridColumn
from rrp_sheets.graph import StreamKind
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key, names_in
from rrp_sheets.model.workbook import column_letters, truth_of
from rrp_sheets.page_texts import Versions
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_, translate
from rrp_sheets.web.analysis import Analysis
from rrp_sheets.web.completions import in_browser
from rrp_sheets.web.models import STREAM_KINDS, Head
from rrp_sheets.workbook.comments import Thread
from rrp_sheets.workbook.looks import Look, shade
from rrp_sheets.workbook.schema import CELLS, OWN, PLAIN, SHEETS, Column

Numbered = list[tuple[int, Diagnostic]]
_SEVERITIES = {"error": N_("Error"), "warning": N_("Warning"), "info": N_("Info")}
_LONG = 600  # characters of a text that is shown in part until the cursor is there
_MOST_TOLD = 300  # characters of a comment
_BODY = 50  # rows; as many as grid.js makes them
Signature = tuple[Any, ...]
Locked = Mapping[tuple[str, str, int], tuple[str, str]]


class RowRenderer:
    """Renderer of the rows of one sheet."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.has_examples = grid.kind == "behaviour"
        self.sheet = SHEETS.get(grid.kind, OWN)
        self._pairs = [(column, self._column(column).kind) for column in grid.columns]
        self._signatures: dict[str, Signature] = {}
        self._problems: dict[int, Numbered] = {}
        self._examples: Mapping[int, str] = {}
        self._streams: dict[str, str] = {}
        self._locked: dict[tuple[str, int], tuple[str, str]] = {}
        self._verdicts: Mapping[str, str] = {}
        self._robot: Robot | None = None
        self._anonymous: frozenset[int] = frozenset()

    def _column(self, column: GridColumn) -> Column:
        return self.sheet.column(column.name) if column.name else self.sheet.other or PLAIN

    def heads(self) -> list[Head]:
        """Return the headers, from left to right."""
        heads = []
        for c in self.grid.columns:
            column = self._column(c)
            if not c.header.isascii():
                words = japanese.CHOICES.get(key(column.name), {})
                choices = (replace(one, text=japanese.japanese_word(words, one.text)) for one in column.choices)
                column = replace(column, choices=tuple(choices))
            spellings = dict.fromkeys([key(c.header), *map(key, (c.name, *column.synonyms) if c.name else ())])
            thread = self.grid.marks.thread(HEADER, c.number)
            about = (_told(thread), thread[0].done) if thread else ()
            heads.append(Head(c.number, column_letters(c.number), c.header, tuple(spellings), column, *about))
        return heads

    def header_comments(self) -> list[dict[str, Any]]:
        """Return the comments of headers in short, as pages get them when one of them has changed."""
        return [{"column": h.number, "told": h.told, "resolved": h.resolved} for h in self.heads() if h.told]

    def update(self, analysis: Analysis, locked: Locked, verdicts: Mapping[str, str] = MappingProxyType({})) -> None:
        """Take over the newest check, the locked cells with their editors (page, name), and the test results."""
        self._verdicts = verdicts
        self._robot = analysis.robot
        self._locked = {(row, column): who for (_, row, column), who in locked.items()}
        problems: dict[int, Numbered] = {}
        for number, d in enumerate(analysis.findings, 1):
            if d.address and d.address.sheet == self.grid.name:
                problems.setdefault(d.address.row, []).append((number, d))
        self._problems = problems
        behaviour = analysis.behaviour(self.grid.name)
        if not self.has_examples or behaviour is None:
            return
        self._streams = analysis.kinds(self.grid.name)
        shown = [s for s in behaviour.steps if s.active and not s.connector.is_sink]
        self._examples = {s.number: analysis.examples[s.ref] for s in shown if s.ref in analysis.examples}
        streams = analysis.graph.streams
        anonymous = (s for s in behaviour.steps if s.output in streams)
        self._anonymous = frozenset(s.number for s in anonymous if streams[s.output].kind is StreamKind.ANONYMOUS)

    def rows(self, first: int, count: int, language: str = "en") -> Markup:
        """Render some rows from a place on, in several table bodies: the browser skips those out of sight.

        A long sheet is requested in parts, so that its beginning is shown at once.
        """
        numbers = islice(self.grid.numbers().items(), first, first + count)
        made = []
        for row, number in numbers:
            self._signatures.setdefault(row, self._signature(row, number))
            made.append(self._render(row, number, language))
        bodies = (made[i : i + _BODY] for i in range(0, max(len(made), 1), _BODY))
        return Markup("".join(f'<tbody role="rowgroup">{"".join(body)}</tbody>' for body in bodies))

    def changed(self, languages: Collection[str] = ("en",)) -> list[tuple[str, Versions]]:
        """Render the rows that have changed since all pages were told of them; rows never rendered are left out."""
        return [
            (row, self._versions(row, number, languages)) for row, number in self.grid.numbers().items()
            if row in self._signatures and self._signatures[row] != self._signature(row, number)
        ]  # fmt: skip

    def html(self, rows: Iterable[str], languages: Collection[str] = ("en",)) -> dict[str, Versions]:
        """Render rows by their ids; those deleted meanwhile are left out."""
        numbers = self.grid.numbers()
        return {row: self._versions(row, numbers[row], languages) for row in rows if row in numbers}

    def _versions(self, row: str, number: int, languages: Collection[str]) -> Versions:
        self._signatures[row] = self._signature(row, number)
        return Versions(languages, lambda language: self._render(row, number, language))

    def _signature(self, row: str, number: int) -> Signature:
        texts = self.grid.texts.get(row, {})
        names = tuple(self._streams.get(key(n), "") for c, k in self._pairs if k in ("inputs", "output")
                      for n in names_in(texts.get(c.number, "")))  # fmt: skip
        problems = tuple((n, d.id, len(d.fixes)) for n, d in self._problems.get(number, ()))
        locked = tuple(self._locked.get((row, c.number)) for c in self.grid.columns)
        example, is_anonymous = self._examples.get(number, ""), number in self._anonymous
        marks = self.grid.marks.of([row])
        return tuple(texts.items()), names, problems, example, is_anonymous, locked, self._verdicts.get(row), marks

    def _render(self, row: str, number: int, language: str) -> str:
        texts = self.grid.texts.get(row, {})
        problems = self._problems.get(number, [])
        known = {c.number for c in self.grid.columns}
        cells = []
        for column, kind in self._pairs:
            mine = [(n, d) for n, d in problems if d.address and d.address.column == column.number]
            if column is self.grid.columns[0]:
                mine += [(n, d) for n, d in problems if d.address and d.address.column not in known]
            cells.append(self._cell(row, number, column, kind, texts.get(column.number, ""), mine, language))
            if kind == "output" and self.has_examples:
                example = escape(translate(self._examples.get(number, ""), language))
                cells.append(f'<td role="gridcell" class="example" title="{example}">{example}</td>')
        off = any(k == "on" and truth_of(texts.get(c.number, "")) is False for c, k in self._pairs)
        filled = [t for _, t in sorted(texts.items()) if t.strip()]
        comment = bool(filled) and filled[0].lstrip().startswith("#")
        buried = comment and len(filled) > 1
        looks = " ".join(w for w, holds in (("off", off), ("comment", comment), ("buried", buried)) if holds)
        marked = f' class="{looks}"' if looks else ""
        return (
            f'<tr role="row" id="{row}" aria-rowindex="{number - self.grid.first + 2}"{marked}>'
            f'<th role="rowheader" class="number" scope="row">{number}</th>{"".join(cells)}</tr>'
        )

    def _cell(
        self, row: str, number: int, column: GridColumn, kind: str, text: str, problems: Numbered, language: str
    ) -> str:
        looks, more = kind + _look(self.grid.marks.look(row, column.number)), ""
        if text:
            more += f' data-v="{escape(text)}"'
        described = [f"p{n}" for n, _ in problems]
        if problems:
            worst = problems[0][1].severity.value
            more += ' aria-invalid="true"' if worst == "error" else ""
            looks += f" flagged is-{worst}"
        if comments := self.grid.marks.thread(row, column.number):
            described.append(f"c-{row}-{column.number}")
            looks += " commented" + (" resolved" if comments[0].done else "")
        if described:
            more += f' aria-describedby="{" ".join(described)}"'
        if kind == "setting" and not text and not self._has_setting(row, column):
            looks += " untaken"
        if who := self._locked.get((row, column.number)):
            looks += " taken"
        if text.lstrip().startswith("#") and column.number == min(self.grid.texts.get(row, {column.number: ""})):
            looks += " remark"
            inside = f'<span class="word">{escape(text)}</span>'
        else:
            inside = self._inside(row, number, kind, text, language)
        if kind == "expect" and row in self._verdicts:
            inside += _verdict(self._verdicts[row], language)
        inside += f'<div class="mends">{"".join(_mend(n, d, language) for n, d in problems)}</div>' if problems else ""
        if comments:
            told = _said(_told(comments), language)
            inside += f'<span class="about-comments" id="{described[-1]}" hidden>{told}</span>'
        if who:
            client, name = who
            said = _said(N_("{name} is editing", name=name), language)
            inside += f'<span class="name-tag" data-client="{escape(client)}">{said}</span>'
        return f'<td role="gridcell" tabindex="-1" class="{looks}"{more}>{inside}</td>'

    def _has_setting(self, row: str, column: GridColumn) -> bool:
        """Return whether the device of a row has the setting of a column; True for an unknown device."""
        place = next((c.number for c, k in self._pairs if k == "device"), 0)
        found = self._robot.find(self.grid.text(row, place)) if self._robot else None
        return found is None or key(column.header) in found.type.settings

    def _inside(self, row: str, number: int, kind: str, text: str, language: str) -> str:
        if kind == "on":
            if not self.grid.texts.get(row):
                return ""  # a blank row is neither on nor off
            checked = "" if truth_of(text) is False else " checked"
            label = _said(N_("Row {row} is on", row=number), language)
            return f'<input type="checkbox" tabindex="-1" aria-label="{label}"{checked}>'
        if not text:
            below = kind == "output" and number in self._anonymous
            return f'<span class="hint-word">{_said(N_("↓ row below"), language)}</span>' if below else ""
        if kind in ("inputs", "output"):
            return ",<br>".join(self._named(n, language) for n in names_in(text))
        if kind == "connector":
            known = connectors().get(text)
            icon = f' data-icon="{known.name}" title="{_said(known.legend_message(), language)}"' if known else ""
            return f'<span class="word"{icon}>{escape(text)}</span>'
        looks = "formula" if CELLS[kind].code else "word"
        return f'<span class="{looks}{" lengthy" if len(text) > _LONG else ""}">{escape(text)}</span>'

    def _named(self, name: str, language: str) -> str:
        kind = self._streams.get(key(name), "")
        spoken = f'<span class="only-spoken">{_said(STREAM_KINDS[kind], language)} </span>' if kind else ""
        return f'<span class="name {kind}">{spoken}{escape(name)}</span>'


def _look(look: Look) -> str:
    """Return the classes of a look."""
    tint = shade(look.fill)
    return "".join((" bold" if look.bold else "", f" tint-{tint}" if tint else "", "" if look.wrap else " unwrapped"))


def _told(thread: Thread) -> str:
    """Return the comments of a cell in short, for a screen reader."""
    last = thread[-1]
    text, author = last.text[:_MOST_TOLD], last.author or N_("somebody")
    if thread[0].done:
        return N_("Resolved comment: {text} ({author})", text=text, author=author)
    if len(thread) == 1:
        return N_("Comment: {text} ({author})", text=text, author=author)
    return N_("{n} comments, the last one: {text} ({author})", n=len(thread), text=text, author=author)


def _said(text: str, language: str) -> Markup:
    return escape(translate(text, language))


def _verdict(got: str, language: str) -> str:
    """Render the result of a test row, with what came instead if it failed."""
    if not got:
        spoken = f'<span class="only-spoken"> {_said(N_("passed"), language)}</span>'
        return f'<span class="verdict holds">✓{spoken}</span>'
    spoken = f'<span class="only-spoken"> {_said(N_("failed;"), language)}</span>'
    return f'<span class="verdict fails">✗{spoken} {_said(N_("got: {value}", value=got), language)}</span>'


def _mend(number: int, d: Diagnostic, language: str) -> str:
    remedy = f'<span class="do">→ {_said(in_browser(d.remedy), language)}</span>' if d.remedy else ""
    kind = d.severity.value
    fixes = "".join(
        f'<button class="button small" type="button" tabindex="-1" data-fix="{escape(fix.id)}" '
        f'data-finding="{d.id}" data-title="{_said(fix.title, language)}">'
        f"{_said(N_('Apply fix: {fix}', fix=fix.title), language)}"
        f"{' <kbd>Ctrl .</kbd>' if i == 0 else ''}</button>"
        for i, fix in enumerate(d.fixes)
    )
    return (
        f'<div class="mend is-{kind}" id="p{number}" data-code="{escape(d.code)}"><b class="severity">'
        f"{_said(_SEVERITIES[kind], language)}</b> <span>{_said(in_browser(d.message), language)}</span> "
        f'<small class="code" aria-hidden="true">{escape(d.code)}</small> '
        f"{remedy}{fixes}</div>"
    )
