"""A workbook on paper: title block, diagrams, tables, sentences, and what is still open."""

from __future__ import annotations

import re
import threading
from collections import OrderedDict
from collections.abc import Iterable
from datetime import datetime

from markupsafe import Markup

from rrp_sheets import __version__
from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.opening import take_over
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model.names import key
from rrp_sheets.render.diagram import draw_diagram
from rrp_sheets.render.sentences import explain
from rrp_sheets.web.browserwords import in_browser
from rrp_sheets.web.library import Book
from rrp_sheets.web.pages import Problem, Words
from rrp_sheets.web.pictures import MOST_ROWS
from rrp_sheets.web.records.pages import Drawn, DrawnPart, PrintBehaviour, PrintPage, PrintTable
from rrp_sheets.web.words import words_of

_SECONDS = 20.0  # for a diagram's layout
_ORDER = ("devices", "helpers", "scene", "gestures", "table", "test")
_MOST_PROBLEMS = 200
_MOST_PRINTED = 2_000  # rows of a table
_KEPT = 16  # drawn behaviours


def print_page(book: Book) -> PrintPage:
    """Everything that is printed of a workbook."""
    look, workbook = book.look, book.look.workbook
    grids, _ = take_over({}, book.reading.sheets, workbook.tables)
    tables = {name: _table(grid) for name, grid in grids.items()}
    sheets = {key(name): table for name, table in tables.items()}
    behaviours = tuple(
        _behaviour(book, number, graph, sheets.get(graph.key)) for number, graph in enumerate(look.graph.behaviours, 1)
    )
    others = sorted((t for t in tables.values() if t.kind in _ORDER and t.rows), key=lambda t: _ORDER.index(t.kind))
    protocol = workbook.protocol
    fields = tuple((protocol.names.get(k, k), cell.text) for k, cell in protocol.fields.items() if cell.text)
    found = [d for d in enumerate(look.findings, 1) if d[1].severity.value != "info"]
    problems = tuple(
        Problem(
            number,
            d.severity.value,
            d.code,
            str(d.address) if d.address else "",
            "",
            "",
            in_browser(d.message),
            in_browser(d.remedy),
        )
        for number, d in found[:_MOST_PROBLEMS]
    )
    tests = [t.name for t in workbook.tests]
    return PrintPage(
        name=book.name, title=book.title, fields=tuple(f for f in fields if key(f[0]) != "title"),
        behaviours=behaviours, tables=tuple(others), problems=problems, left_out=max(0, len(found) - _MOST_PROBLEMS),
        digest=book.reading.digest, when=today(), program=__version__, tests=", ".join(tests),
    )  # fmt: skip


def today() -> str:
    """The date and time, for people."""
    now = datetime.now()
    return f"{now.day} {now:%B %Y, %H:%M}"


def _table(grid: Grid) -> PrintTable:
    """A sheet as it stands there; blank rows, and columns with nothing in them, are left out."""
    filled = [c for c in grid.columns if any(grid.text(row, c.number) for row in grid.rows)]
    on = next((c.number for c in filled if c.name == "On"), 0)
    rows = []
    for number, row in enumerate(grid.rows, grid.first):
        texts = tuple(grid.text(row, c.number) for c in filled)
        if any(texts):
            rows.append((number, bool(on) and _is_off(grid.text(row, on)), texts))
    heads = tuple((key(c.name).replace(" ", ""), c.header) for c in filled)
    return PrintTable(grid.name, grid.kind, heads, tuple(rows[:_MOST_PRINTED]), max(0, len(rows) - _MOST_PRINTED))


def _is_off(text: str) -> bool:
    return text.strip().casefold() in ("false", "no", "off", "0")


def _behaviour(book: Book, number: int, behaviour: BehaviourGraph, table: PrintTable | None) -> PrintBehaviour:
    look = book.look
    if not behaviour.steps:
        return PrintBehaviour(behaviour.name, number, "There is no row in it yet.", table, None)
    if not look.understood:
        return PrintBehaviour(behaviour.name, number, "The diagram comes when the problems are mended.", table, None)
    words: Words = words_of(explain(look.graph, look.workbook, look.robot, [behaviour])[0])
    return PrintBehaviour(behaviour.name, number, "", table, words)


class Drawings:
    """The diagrams on paper: drawn once for each state of a workbook, as a long one takes its time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[str, str, int], DrawnPart] = OrderedDict()

    def part(self, book: Book, number: int) -> DrawnPart | None:
        """The diagram of a behaviour; None when there is no such behaviour."""
        behaviours = book.look.graph.behaviours
        if not 1 <= number <= len(behaviours):
            return None
        name = (book.name, book.reading.digest, number)
        with self._lock:
            if name not in self._kept:
                self._kept[name] = _drawn(book, behaviours[number - 1])
                while len(self._kept) > _KEPT:
                    self._kept.popitem(last=False)
            return self._kept[name]


def _drawn(book: Book, behaviour: BehaviourGraph) -> DrawnPart:
    if len(behaviour.steps) > MOST_ROWS:
        why = f"Its diagram is not printed: it has more than {MOST_ROWS} rows. Divide the sheet."
        return DrawnPart(behaviour.name, (), why)
    if not book.look.understood:
        return DrawnPart(behaviour.name, (), "The diagram comes when the problems are mended.")
    try:
        pages = draw_diagram(book.look.graph, behaviour, problems=book.look.flags(behaviour), timeout=_SECONDS)
    except SheetsError as error:
        return DrawnPart(behaviour.name, (), f"{error.message} {error.remedy}".strip())
    return DrawnPart(behaviour.name, tuple(Drawn(Markup(p.svg), p.caption, p.landscape) for p in pages), "")


def paper_style(name: str, digest: str, when: str) -> str:
    r"""What stands in the foot of every sheet of paper: a style of its own, since a page may hold none.

    >>> print(paper_style("a.xlsx", "0123456789abcdef" * 4, "1 May 2026, 10:00").splitlines()[2].strip())
    @bottom-left { content: "a\2e xlsx   SHA-256 0123 4567 89ab cdef …   1 May 2026\2c  10\3a 00"; }
    """
    digits = " ".join(_pieces(digest[:16]))
    foot = f"{_css(name)}   SHA-256 {_css(digits)} …   {_css(when)}"
    return (
        "@media print {\n  @page {\n"
        f'    @bottom-left {{ content: "{foot}"; }}\n'
        '    @bottom-right { content: "page " counter(page) " of " counter(pages); }\n'
        "  }\n}\n"
    )


def _pieces(digits: str) -> Iterable[str]:
    return (digits[n : n + 4] for n in range(0, len(digits), 4))


def _css(text: str) -> str:
    """A text inside a string of CSS: everything but letters and digits is escaped."""
    return re.sub(r"[^\w ]", lambda m: f"\\{ord(m[0]):x} ", " ".join(text.split())[:120])
