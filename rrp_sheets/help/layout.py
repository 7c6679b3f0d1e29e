"""Blocks that a help topic is made of: headings, paragraphs, lists, tables, code, example workbooks, marble diagrams.

A topic is made once, as blocks, and shown in two ways: `as_text` prints it in a terminal, `as_html` in a browser. Texts
of the program in blocks are messages, which are shown in the reader's language.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.diagnostics.catalogue import completed
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked

FILES = Path(__file__).parent
Rows = tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Block:
    """Block of a topic.

    Attributes:
        kind: `heading`, `paragraph`, `remark` (an indented paragraph), `entries` (terms and their meanings), `columns`
            (a table), `lines` (code), `titled` (blocks under a small title), `example` (a workbook), `sheet` (of an
            example), `marbles`.
        head: the text of a heading, a paragraph or a title, the name of a sheet; of an example what it is about.
        rows: of entries, columns, lines and sheets; of marbles each stream with its row of marbles.
        parts: of a titled block; of an example its sheets.
        anchor: by which a page has a link to the block; of an example by which it is opened as a workbook.
        headed: whether the first row of columns has their titles.
        source: of an example, its Markdown, with a behaviour when its sheets have none.
        drawn: whether an example has a diagram, and a file in published pages.
    """

    kind: str
    head: str = ""
    rows: Rows = ()
    parts: tuple[Block, ...] = ()
    anchor: str = ""
    headed: bool = False
    source: str = ""
    drawn: bool = False


def heading(text: str, anchor: str = "") -> Block:
    """Return the beginning of a section."""
    return Block("heading", text, anchor=anchor or slug(text))


def paragraph(text: str) -> Block:
    """Return a text of one or more sentences."""
    return Block("paragraph", text)


def remark(text: str) -> Block:
    """Return a paragraph that is indented in a terminal."""
    return Block("remark", text)


def titled(title: str, *parts: Block) -> Block:
    """Return blocks under a small title."""
    return Block("titled", title, parts=parts)


def lines(texts: Iterable[str]) -> Block:
    """Return code, such as formulas and what they give, each on its line."""
    return Block("lines", rows=tuple((text,) for text in texts))


def entries(pairs: Iterable[tuple[str, str]]) -> Block:
    """Return terms and what they mean."""
    return Block("entries", rows=tuple(pairs))


def columns(rows: Iterable[Sequence[str]], *, headed: bool = False) -> Block:
    """Return a table; with two columns it is a list of terms."""
    found = tuple(tuple(row) for row in rows)
    return Block("columns" if headed or len(found[0]) > 2 else "entries", rows=found, headed=headed)


def workbook(about: str, markdown: str, language: str, *, drawn: bool = True) -> Block:
    """Return an example, a workbook in English in Markdown, as it is written in a language; with a diagram if `drawn`.

    Its sheets are `## ` or `### ` headings, each with a table.
    """
    english = re.sub(r"^### ", "## ", markdown, flags=re.MULTILINE)
    shown = sheets_of(in_language(english, language))
    sheets = tuple(Block("sheet", name, tuple(map(tuple, rows))) for name, rows in shown.items())
    source = in_language(completed(english), language)
    return Block("example", about, parts=sheets, anchor=slug(about), source=source, drawn=drawn)


def sheets_of(markdown: str) -> dict[str, list[list[str]]]:
    """Return the rows of a Markdown workbook, which are all as long as the longest of their sheet."""
    from rrp_sheets.workbook.raw import Extent
    from rrp_sheets.workbook.text_books import read_markdown

    book = read_markdown(markdown.encode(), "help")
    sheets = {}
    for index, name in enumerate(book.names):
        cells = book.sheet(index, Extent.WHOLE).cells
        bottom, right = max(row for row, _ in cells), max(column for _, column in cells)
        texts = {at: cell.text for at, cell in cells.items()}
        sheets[name] = [[texts.get((r, c), "") for c in range(1, right + 1)] for r in range(1, bottom + 1)]
    return sheets


@lru_cache(maxsize=500)
def in_language(markdown: str, language: str) -> str:
    """Return a Markdown workbook in English as it is written in a language; one with broken rows stays as it is."""
    from rrp_sheets.workbook.template import in_japanese
    from rrp_sheets.workbook.text_books import read_markdown
    from rrp_sheets.workbook.text_patch import markdown_text

    if language != "ja" or read_markdown(markdown.encode(), "help").findings:
        return markdown
    own = markdown_text(in_japanese(sheets_of(markdown)))
    told = [[(d.code, d.address and d.address.cell, bool(d.fixes)) for d in checked(m).report] for m in (markdown, own)]
    # a mistake with an English name of a device is shown with that
    return own if told[0] == told[1] else markdown_text(in_japanese(sheets_of(markdown), declare=False))


def slug(text: str) -> str:
    """Return a text as an anchor, the same in every language of a message.

    >>> slug("Red ball (sensor)"), slug("CLAMP(value; low; high)"), slug("Where and how?")
    ('Red-ball-sensor', 'CLAMP-value-low-high', 'Where-and-how')
    """
    return re.sub(r"\W+", "-", str(text)).strip("-")


def rows_to_open(example: Block) -> dict[str, list[list[str]]]:
    """Return the sheets of an example as a workbook that can be opened."""
    return sheets_of(example.source)


def mapped(block: Block, change: Callable[[str], str]) -> Block:
    """Return a block with another text for each of its texts, those of example workbooks apart."""
    if block.kind in ("example", "sheet", "marbles"):
        return block
    rows = tuple(tuple(map(change, row)) for row in block.rows)
    return replace(block, head=change(block.head), rows=rows, parts=tuple(mapped(p, change) for p in block.parts))


# ---- topics that stand in files
_TABLE = re.compile(r"\|\s*-+")


def topic_file(name: str, language: str) -> str:
    """Return the text of `help/<language>/<name>.md`, of the English file where there is none."""
    own = FILES / language / f"{name}.md"
    return (own if language != "en" and own.is_file() else FILES / f"{name}.md").read_text(encoding="utf-8")


@lru_cache(maxsize=1_000)
def anchors(name: str) -> tuple[str, ...]:
    """Return the anchors of the headings of a topic's file, which are those of the English one in every language."""
    return tuple(block.anchor for block in from_markdown(topic_file(name, "en")) if block.kind == "heading")


def from_file(name: str, language: str, **made: str) -> Iterator[Block]:
    """Yield the blocks of a topic's file; `made` are texts for its `{places}`."""
    text = topic_file(name, language)
    for place, told in made.items():
        text = text.replace(f"{{{place}}}", told)
    given = iter(anchors(name))
    for block in from_markdown(text, name, language):
        yield replace(block, anchor=next(given, block.anchor)) if block.kind == "heading" else block


def from_markdown(text: str, name: str = "", language: str = "en") -> Iterator[Block]:
    """Yield the blocks of a topic's text: `# ` headings, `* term | meaning` lists, tables, code, examples, paragraphs.

    An example is a workbook: `### ` headings, each with a table below; `name` is what it is about. A list of which an
    entry has more than one `|` is a table.
    """
    found = re.split(r"\n{2,}", text.strip("\n"))
    while found:
        block = found.pop(0)
        texts = block.split("\n")
        if block.startswith("### "):
            sheets = [block]
            while found and found[0].startswith(("### ", "|")):
                sheets.append(found.pop(0))
            yield workbook(name, "\n\n".join(sheets), language)
        elif block.startswith("# "):
            yield heading(block[2:])
        elif block.startswith("* "):
            yield columns([re.split(r" +\| +", line[2:].strip()) for line in texts])
        elif block.startswith("|"):
            yield columns([_cells(line) for line in texts if not _TABLE.match(line)], headed=True)
        elif block.startswith("    "):
            yield lines(textwrap.dedent(block).split("\n"))
        else:
            yield paragraph(block)


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split(" | ")]


def example(name: str) -> str:
    """Return the Markdown workbook `examples/<name>.md`."""
    return (FILES / "examples" / f"{name}.md").read_text(encoding="utf-8")


def checked(markdown: str) -> Checked:
    """Read and check a Markdown workbook."""
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.workbook.reading import Reader
    from rrp_sheets.workbook.text_books import read_markdown

    reader = Reader(read_markdown(markdown.encode(), "help"), "help")
    return check_workbook(reader.workbook, reader.report)


FOR_EXAMPLE = N_("For example")
