"""Text for a terminal of 80 to 100 columns: paragraphs, lists of terms, columns, and workbooks as grids."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.model.workbook import column_letters
from rrp_sheets.render.style import columns as text_columns

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked

WIDTH = 88
_TERM = 26  # the widest column of terms; a longer term stands on a line of its own
_CELL = 44


class Block(str):
    """A block of text for the terminal that also remembers what it was made of, for a page."""

    kind: str  # `paragraph`, `heading`, `entries`, `columns`, `grid`, `lines`, `marbles` or `titled`
    # of a heading, a grid (the sheet's name) or a titled block; the connector of marbles; the whole text of a paragraph
    head: str
    rows: tuple[tuple[str, ...], ...]  # of entries, columns, marbles and grids
    parts: tuple[str, ...]  # of a titled block

    @classmethod
    def of(
        cls, kind: str, printed: str, head: str = "", rows: Iterable[Sequence[str]] = (), parts: Sequence[str] = ()
    ) -> Block:
        """A block that is printed in a certain way."""
        block = cls(printed)
        block.kind, block.head = kind, head
        block.rows, block.parts = tuple(tuple(row) for row in rows), tuple(parts)
        return block


def titled(title: str, *parts: str, between: str = "\n") -> Block:
    r"""Blocks under a small title.

    >>> titled("Its fields", columns([("x", "rad")]))
    'Its fields\n  x  rad'
    """
    return Block.of("titled", f"{title}\n{between.join(parts)}", title, parts=parts)


def lines(texts: Sequence[str]) -> Block:
    """Formulas and what they give, each on its line."""
    return Block.of("lines", "\n".join(f"  {text}" for text in texts), rows=[(text,) for text in texts])


def paragraph(text: str, indent: int = 0) -> Block:
    r"""A text wrapped to the width.

    >>> paragraph("word " * 20).count("\n")
    1
    """
    space, whole = " " * indent, " ".join(text.split())
    printed = textwrap.fill(
        whole, WIDTH, initial_indent=space, subsequent_indent=space, break_long_words=False, break_on_hyphens=False
    )
    return Block.of("paragraph", printed, whole)


def heading(text: str) -> Block:
    r"""A heading and the line below it.

    >>> heading("Maths")
    'Maths\n-----'
    """
    return Block.of("heading", f"{text}\n{'-' * text_columns(text)}", text)


def entries(pairs: Iterable[tuple[str, str]], indent: int = 2, widest: int = _TERM, kind: str = "entries") -> Block:
    r"""Terms and what they mean, in two columns.

    >>> entries([("sample", "at a fixed pace"), ("map", "works out")])
    '  sample  at a fixed pace\n  map     works out'
    """
    pairs = list(pairs)
    term = min(max((text_columns(t) for t, _ in pairs), default=0), widest)
    return Block.of(kind, "\n".join(_entry(left, right, indent, term) for left, right in pairs), rows=pairs)


def _entry(left: str, right: str, indent: int, term: int) -> str:
    space = " " * (indent + term + 2)
    lines = textwrap.wrap(right, WIDTH - len(space), break_long_words=False, break_on_hyphens=False) or [""]
    head = " " * indent + left
    if text_columns(left) > term:
        return "\n".join([head, *(space + line for line in lines)])
    first = head + " " * (term - text_columns(left) + 2) + lines[0]
    return "\n".join([first.rstrip(), *(space + line for line in lines[1:])])


def columns(rows: Sequence[Sequence[str]], indent: int = 2) -> Block:
    """Rows in columns; the last one is wrapped."""
    widths = [max(text_columns(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    pairs = (("  ".join(_padded(c, w) for c, w in zip(row, widths, strict=False)), row[-1]) for row in rows)
    return Block.of("columns", entries(pairs, indent, widest=WIDTH), rows=rows)


def grid(sheet: str, rows: Sequence[Sequence[str]], indent: int = 2) -> Block:
    """A sheet as the user knows it: with letters above its columns and numbers before its rows.

    >>> print(grid("Devices", [["Stream", "Device"], ["Neck", "Head yaw"]]))
      Devices
         A       B
      1  Stream  Device
      2  Neck    Head yaw
    """
    width = max(len(row) for row in rows)
    cells = [[_short(c) for c in row] + [""] * (width - len(row)) for row in rows]
    table = [["", *(column_letters(i + 1) for i in range(width))]]
    table += [[str(number), *row] for number, row in enumerate(cells, 1)]
    widths = [max(text_columns(row[i]) for row in table) for i in range(width + 1)]
    printed = ["  ".join(_padded(c, w) for c, w in zip(row, widths, strict=True)).rstrip() for row in table]
    return Block.of("grid", "\n".join(" " * indent + line for line in [sheet, *printed]), sheet, cells)


def _short(cell: str) -> str:
    cell = cell.replace("\n", ", ")
    return cell if len(cell) <= _CELL else cell[: _CELL - 1] + "…"


def _padded(text: str, width: int) -> str:
    return text + " " * (width - text_columns(text))


def from_markdown(text: str) -> Iterator[str]:
    """The blocks of a topic's file: `# ` headings, `* term | meaning` lists, verbatim lines and paragraphs."""
    for block in re.split(r"\n{2,}", text.strip("\n")):
        texts = block.split("\n")
        if block.startswith("# "):
            yield heading(block[2:])
        elif block.startswith("* "):
            rows = [re.split(r" +\| +", line[2:].strip()) for line in texts]
            yield columns(rows)
        elif block.startswith("    "):
            yield lines(textwrap.dedent(block).split("\n"))
        else:
            yield paragraph(block)


def example(name: str) -> str:
    """The Markdown workbook `examples/<name>.md`."""
    return (Path(__file__).parent / "examples" / f"{name}.md").read_text(encoding="utf-8")


def checked(markdown: str) -> Checked:
    """A Markdown workbook, read and checked."""
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.workbook.reading import Reader
    from rrp_sheets.workbook.text_books import read_markdown

    reader = Reader(read_markdown(markdown.encode(), "help"), "help")
    return check_workbook(reader.workbook, reader.report)


def grids(markdown: str) -> Iterator[str]:
    """Every sheet of a Markdown workbook as a grid."""
    from rrp_sheets.workbook.raw import Extent
    from rrp_sheets.workbook.text_books import read_markdown

    book = read_markdown(markdown.encode(), "help")
    for index, name in enumerate(book.names):
        cells = book.sheet(index, Extent.WHOLE).cells
        bottom, right = max(row for row, _ in cells), max(column for _, column in cells)
        texts = {at: cell.text for at, cell in cells.items()}
        yield grid(name, [[texts.get((r, c), "") for c in range(1, right + 1)] for r in range(1, bottom + 1)])
