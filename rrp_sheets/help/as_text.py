"""Prints help topics for a terminal of 80 to 100 columns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from rrp_sheets.help.layout import Block, mapped
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.render.style import columns as text_columns
from rrp_sheets.texts import translate

WIDTH = 88
_TERM = 26  # the widest column of terms; a longer term stands on a line of its own
_CELL = 44
_WIDE = "\u2e80-\u9fff\uf900-\ufaff\uff00-\uffef"
_NEVER_FIRST = "、。，．・：；？！ー々」』）】〉》”’ぁぃぅぇぉっゃゅょァィゥェォッャュョ…"
_PIECES = re.compile(
    rf" *(?:[「『（【“‘]*[{_WIDE}][{_NEVER_FIRST}]*|[「『（【]*[^ {_WIDE}{_NEVER_FIRST}]+[{_NEVER_FIRST}]*|[^ ]+)"
)


def as_text(blocks: Iterable[Block], language: str = "en") -> str:
    """Return blocks as lines for a terminal, in a language."""
    return "\n\n".join(_printed(mapped(block, lambda text: translate(text, language)), language) for block in blocks)


def _printed(block: Block, language: str) -> str:
    if block.kind == "heading":
        return f"{block.head}\n{'-' * text_columns(block.head)}"
    if block.kind in ("paragraph", "remark"):
        space = "" if block.kind == "paragraph" else "  "
        return "\n".join(space + line for line in wrapped(block.head, WIDTH - len(space)))
    if block.kind == "entries":
        return _entries([(row[0], row[-1]) for row in block.rows], _TERM)
    if block.kind == "marbles":
        return _entries([(translate(name, language), row) for name, row in block.rows], _TERM)
    if block.kind == "columns":
        widths = [max(text_columns(row[i]) for row in block.rows) for i in range(len(block.rows[0]) - 1)]
        pairs = [("  ".join(_padded(c, w) for c, w in zip(row, widths, strict=False)), row[-1]) for row in block.rows]
        return _entries(pairs, WIDTH)
    if block.kind == "lines":
        return "\n".join(f"  {row[0]}" for row in block.rows)
    if block.kind == "example":
        return "\n\n".join(_sheet(part.head, part.rows) for part in block.parts)
    return "\n".join([block.head, *(_printed(part, language) for part in block.parts)])


def wrapped(text: str, width: int) -> list[str]:
    """Break a text into lines at spaces, and between the letters of Japanese.

    >>> wrapped("one two three", 8), wrapped("赤いボールを見つけます。", 12)
    (['one two', 'three'], ['赤いボールを', '見つけます。'])
    """
    found, line = [], ""
    for piece in _PIECES.findall(" ".join(text.split())):
        if line and text_columns(line + piece) > width:
            found.append(line)
            line = piece.lstrip()
        else:
            line += piece
    return [*found, line]


def _entries(pairs: Sequence[tuple[str, str]], widest: int) -> str:
    term = min(max((text_columns(left) for left, _ in pairs), default=0), widest)
    return "\n".join(_entry(left, right, term) for left, right in pairs)


def _entry(left: str, right: str, term: int) -> str:
    space = " " * (term + 4)
    lines = wrapped(right, WIDTH - len(space))
    if text_columns(left) > term:
        return "\n".join([f"  {left}", *(space + line for line in lines)])
    return "\n".join([f"  {_padded(left, term)}  {lines[0]}".rstrip(), *(space + line for line in lines[1:])])


def _sheet(name: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a sheet as users know it, with letters above its columns and numbers before its rows."""
    table = [["", *(column_letters(i + 1) for i in range(len(rows[0])))]]
    table += [[str(number), *map(_short, row)] for number, row in enumerate(rows, 1)]
    widths = [max(text_columns(row[i]) for row in table) for i in range(len(table[0]))]
    printed = ["  ".join(_padded(c, w) for c, w in zip(row, widths, strict=True)).rstrip() for row in table]
    return "\n".join(f"  {line}" for line in [name, *printed])


def _short(cell: str) -> str:
    cell = cell.replace("\n", ", ")
    return cell if len(cell) <= _CELL else cell[: _CELL - 1] + "…"


def _padded(text: str, width: int) -> str:
    return text + " " * (width - text_columns(text))
