"""The page of one workbook."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.model.names import key
from rrp_sheets.render.sentences import BehaviourText, explain
from rrp_sheets.web.library import Book
from rrp_sheets.web.pages import Command, Problem, SheetView, WorkbookPage
from rrp_sheets.web.pictures import MOST_ROWS, understood
from rrp_sheets.web.sheets import BehaviourTable, Places, plain_view
from rrp_sheets.web.shelf import changed, counts
from rrp_sheets.workbook.headers import recognise

MOST_PROBLEMS = 300


def workbook_page(book: Book, icons: frozenset[str]) -> WorkbookPage:
    """Everything that the page of a workbook shows."""
    maker = _PageMaker(book, icons)
    behaviours, sheets = maker.behaviours(), maker.sheets()
    return WorkbookPage(
        name=book.name,
        title=book.title,
        changed=changed(book),
        program="Excel or LibreOffice" if book.reading.format == "xlsx" else "a text editor",
        counts=counts(book.checked.report),
        behaviours=behaviours,
        sheets=sheets,
        own=maker.own,
        problems=maker.problems(behaviours, sheets),
        problems_left_out=maker.problems_left_out,
        commands=commands(book.path),
    )


def commands(path: Path) -> tuple[Command, ...]:
    """The command lines for a workbook, to be typed where the server was started."""
    file = quoted(path)
    return (
        Command(f"rrp-sheets run {file}", "runs it on the simulated robot"),
        Command(f"rrp-sheets check {file}", "says what is wrong with it, as this page does"),
        Command(f"rrp-sheets diagram {file} -o {quoted(Path(f'{path.stem}.pdf'))}", "draws it for printing"),
    )


def quoted(path: Path) -> str:
    """A path for a command line: in quotes where needed, and never taken for an option.

    >>> quoted(Path("greeter.xlsx")), quoted(Path("-x.xlsx"))
    ('greeter.xlsx', './-x.xlsx')
    """
    name = f".{os.sep}{path}" if str(path).startswith("-") else str(path)
    if os.name == "nt":
        return f'"{name}"' if any(c in name for c in " &()^;,") else name
    return shlex.quote(name)


class _PageMaker:
    """Makes the parts of the page; the sheets' ids are `s1`, `s2`, … in the order of the file."""

    def __init__(self, book: Book, icons: frozenset[str]) -> None:
        self._book, self._icons = book, icons
        findings = list(book.checked.report)
        self.problems_left_out = max(0, len(findings) - MOST_PROBLEMS)
        self._findings = list(enumerate(findings[:MOST_PROBLEMS], 1))
        names = book.checked.workbook.sheets
        self._anchors = {key(name): f"s{n}" for n, name in reversed(list(enumerate(names, 1)))}
        recognised = [(sheet, recognise(sheet)) for sheet in book.reading.sheets]
        self._others = [(s, r) for s, r in recognised if r.kind and r.kind.name != "behaviour"]
        self.own = tuple(s.name for s, r in recognised if r.kind is None and not s.hidden)

    def behaviours(self) -> tuple[SheetView, ...]:
        """The tables of the behaviours."""
        checked = self._book.checked
        maker = BehaviourTable(checked.graph, self._icons)
        told = self._told()
        drawn = {b.key: b for b in checked.graph.behaviours}
        views = []
        for behaviour in checked.workbook.behaviours:
            graph = drawn.get(key(behaviour.name))
            places, anchor = self._places(behaviour.name), self._anchors.get(key(behaviour.name), "")
            views.append(maker.view(behaviour, graph, places, anchor, told.get(key(behaviour.name))))
        return tuple(views)

    def _told(self) -> dict[str, BehaviourText]:
        """The behaviours in words, by their key; those that are too long or not understood are missing."""
        checked = self._book.checked
        if not understood(checked.graph):
            return {}
        short = [b for b in checked.graph.behaviours if len(b.steps) <= MOST_ROWS]
        said = explain(checked.graph, checked.workbook, checked.robot, short)
        return {b.key: words for b, words in zip(short, said, strict=True)}

    def sheets(self) -> tuple[SheetView, ...]:
        """The tables of the other sheets of ours, in the order of the file."""
        return tuple(
            plain_view(sheet, found, self._places(sheet.name), self._anchors.get(key(sheet.name), ""))
            for sheet, found in self._others
        )

    def problems(self, *shown: tuple[SheetView, ...]) -> tuple[Problem, ...]:
        """All findings, each leading to its row, or else to its sheet, as far as they are among those shown."""
        anchors = {a for views in shown for view in views for a in (view.anchor, *(r.anchor for r in view.rows))}
        return tuple(self._problem(n, d, anchors) for n, d in self._findings)

    def _places(self, sheet: str) -> Places:
        places: dict[int, dict[int, list[Problem]]] = {}
        for number, d in self._findings:
            if d.address and d.address.sheet == sheet:
                row = places.setdefault(d.address.row, {})
                row.setdefault(d.address.column, []).append(self._problem(number, d, set()))
        return places

    def _problem(self, number: int, d: Diagnostic, anchors: set[str]) -> Problem:
        place, cell, anchor = "", "", ""
        if d.address:
            place, cell = str(d.address), d.address.cell
            sheet = self._anchors.get(key(d.address.sheet), "")
            anchor = next((a for a in (f"{sheet}-{d.address.row}", sheet) if a in anchors), "")
        return Problem(number, d.severity.value, d.code, place, cell, anchor, d.message, d.remedy)
