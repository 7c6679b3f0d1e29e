"""Text of one cell in CSV and Markdown: reading and writing."""

from __future__ import annotations

import re

CELL_END = re.compile(r"(?<!\\)\|")
DELIMITERS = ",;\t"
"""What may stand between the fields of a CSV file."""
_BREAK = re.compile(r"(\\*)(<br\s*/?>)", re.IGNORECASE)
_CODE_MARK = re.compile(r"\\*`")
_DANGEROUS = ("=", "+", "-", "@", "\t")
_PLAIN_NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?")
_QUOTED_SIGN = re.compile(r"'[=+\-@\t][^']*'\s*(?:$|[&=<>+\-*/^,;)])")


def from_markdown(cell: str) -> str:
    r"""The text of a cell between two bars.

    `<br>` is a line break; backticks around all of it set it as code and go; a backslash before `|`, `<br>` or the
    first backtick says that it is meant as it stands.

    >>> from_markdown(r" `a < 1` "), from_markdown(r"a \| b<br>c\<br>"), from_markdown(r"\`a`")
    ('a < 1', 'a | b\nc<br>', '`a`')
    """
    cell = cell.strip().replace("\\|", "|")
    cell = _BREAK.sub(lambda m: m[1][1:] + m[2] if m[1] else "\n", cell)
    inside = cell[1:-1]
    if len(cell) > 2 and cell[0] == cell[-1] == "`" and "`" not in inside:
        return inside
    return cell[1:] if cell.startswith("\\") and _CODE_MARK.match(cell) else cell


def to_markdown(text: str) -> str:
    r"""A text as a cell of a table; spaces at its edges are lost.

    >>> to_markdown("a | b\nc <br>"), to_markdown("`a`")
    ('a \\| b<br>c \\<br>', '\\`a`')
    """
    text = text.strip()
    if _CODE_MARK.match(text):
        text = "\\" + text
    text = _BREAK.sub(lambda m: "\\" + m[0], text)
    return re.sub(r"(\\?)\n", lambda m: m[1] + (" " if m[1] else "") + "<br>", text).replace("|", "\\|")


def from_csv(field: str) -> str:
    """The text of a field, without the apostrophe that keeps spreadsheet programs from calculating it.

    A formula that begins with a quoted sign (`'-' & x`) keeps its apostrophe.

    >>> from_csv("'=1+1"), from_csv("'-' & x"), from_csv("'tis")
    ('=1+1', "'-' & x", "'tis")
    """
    bare = field.lstrip("'")
    if bare != field and bare.startswith(_DANGEROUS) and not _QUOTED_SIGN.match(field):
        return field[1:]
    return field


def to_csv(text: str, delimiter: str = ",", quoted: bool = False) -> str:
    """A text as a field: guarded against being calculated, and quoted where it must be.

    Args:
        text: of the cell.
        delimiter: between the fields.
        quoted: whether to quote it in any case.

    >>> to_csv("=1+1"), to_csv("-0.5"), to_csv("a, b")
    ("'=1+1", '-0.5', '"a, b"')
    """
    bare = text.lstrip("'")
    if bare.startswith(_DANGEROUS) and not _PLAIN_NUMBER.fullmatch(text) and not _QUOTED_SIGN.match(text):
        text = "'" + text
    # Any delimiter: in a narrow table an unquoted one would be taken for that of the file.
    special = set(text) & {delimiter, *DELIMITERS, '"', "\n", "\r"}
    quoted = quoted or bool(special) or text != text.strip() or text.casefold().startswith("sep=")
    return '"' + text.replace('"', '""') + '"' if quoted else text
