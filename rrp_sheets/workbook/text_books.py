"""The CSV and Markdown backends. Row 1 is the header and rows count as in a sheet.

A folder of CSV files is a workbook: one file is one sheet, the file's name is the sheet's name, and the sheets stand
in the order of the names, numbers counting as numbers (`2 Greet.csv` before `10 Look.csv`), unless a file `order.txt`
says otherwise, one sheet a line. The delimiter (comma, semicolon or tab) is the one that gives the header row most
columns; in a .tsv file it is the tab.
"""

from __future__ import annotations

import csv
import hashlib
import io
import re
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import Extent, RawSheet, text_sheet, unreadable
from rrp_sheets.workbook.schema import recognise

CELL_END = re.compile(r"(?<!\\)\|")
DELIMITERS = ",;\t"
"""Delimiters that the fields of a CSV file may have."""
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
    guarded = bare != field and bare.startswith(_DANGEROUS) and not _QUOTED_SIGN.match(field)
    return field[1:] if guarded else field


def to_csv(text: str, delimiter: str = ",", quoted: bool = False) -> str:
    """A text as a field: guarded against being calculated, and quoted where it must be.

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


ORDER = "order.txt"
TAB_SUFFIX = ".tsv"
SUFFIXES = (".csv", TAB_SUFFIX)
"""Of the files of which each is a sheet."""
HEADING = re.compile(r"##[ \t]+(.*?)[ \t]*#*[ \t]*")
_QUOTED = re.compile(rf'(?<![^{DELIMITERS}\r\n])"(?:[^"]|"")*+"(?![^{DELIMITERS}\r\n])')
RULE = re.compile(r"\|[\s:|-]*-[\s:|-]*\|?\s*")


class TextBook:
    """Sheets that are in memory already."""

    def __init__(self, format: str, sheets: list[RawSheet], findings: list[Diagnostic], name: str) -> None:
        if not sheets:
            raise unreadable("FILE017", name=name)
        if len(sheets) > limits.SHEETS:
            raise unreadable("FILE012", name=name, count=len(sheets), limit=limits.SHEETS)
        self.format, self.findings, self._sheets = format, findings, sheets
        self.names = [s.name for s in sheets]

    def sheet(self, index: int, extent: Extent) -> RawSheet:
        """A sheet; see Book."""
        return self._sheets[index]


def decode(data: bytes, name: str) -> str:
    """The text of a file: UTF-8 with or without mark, UTF-16 with mark, or else what Excel writes (Windows-1252)."""
    marked = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    for encoding in ["utf-16"] if marked else ["utf-8-sig", "cp1252"]:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            if max(text.count(mark) for mark in "|,;\t\n") > limits.TEXT_CELLS:
                raise unreadable("FILE007", name=name, what=N_("more than {n} cells", n=f"{limits.TEXT_CELLS:,}"))
            return text.replace("\r\n", "\n").replace("\r", "\n")
    raise unreadable("FILE014", name=name)


def text_digest(data: bytes, name: str) -> str:
    """The SHA-256 of a file's text, so that a copy with other line breaks or another mark has the same."""
    return hashlib.sha256(decode(data, name).encode()).hexdigest()


def read_csv(files: Mapping[str, bytes], name: str, order: Sequence[str] = (), tabs: Collection[str] = ()) -> TextBook:
    """A workbook from the contents of CSV files by sheet name; `order` names the sheets that come first.

    The files of the sheets in `tabs` are .tsv files: their delimiter is the tab.
    """
    sheets, findings = [], []
    places = {sheet: i for i, sheet in enumerate(order)}
    for sheet in sorted(files, key=lambda sheet: (places.get(sheet, len(places)), natural(sheet))):
        file = f"{sheet}{TAB_SUFFIX if sheet in tabs else '.csv'}"
        text = decode(files[sheet], file)
        parsed = _parsed(text[len(csv_hint(text)) :], csv_delimiter(text, file), file)
        rows = [[from_csv(field) for field in row] for row in parsed]
        sheets.append(text_sheet(sheet, rows))
        findings.extend(_overlong(sheet, rows))
    return TextBook("csv", sheets, findings, name)


def read_markdown(data: bytes, name: str) -> TextBook:
    """A workbook from a Markdown text: `## Name of the sheet`, below it a table."""
    sheets: list[RawSheet] = []
    findings: list[Diagnostic] = []
    lines = [line.strip() for line in decode(data, name).split("\n")]
    heads = [(i, match[1]) for i, line in enumerate(lines) if (match := HEADING.fullmatch(line))]
    for (begin, heading), (end, _) in pairwise([*heads, (len(lines), "")]):
        _, table, after = first_table(lines[begin:end])
        if heading and table:
            if any(line.startswith("|") for line in after):
                findings.append(Diagnostic("SHEET018", Address(heading), {"sheet": heading}))
            if len(table) > 1 and RULE.fullmatch(table[1]):
                del table[1]
            rows = [[from_markdown(piece) for piece in markdown_pieces(line)] for line in table]
            sheets.append(text_sheet(heading, rows))
            findings.extend(_overlong(heading, rows))
    return TextBook("markdown", sheets, findings, name)


def first_table(lines: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """The lines before the first table, those of the table, and those after it."""
    is_row = [line.strip().startswith("|") for line in lines]
    first = is_row.index(True) if True in is_row else len(lines)
    last = is_row.index(False, first) if False in is_row[first:] else len(lines)
    return list(lines[:first]), list(lines[first:last]), list(lines[last:])


def markdown_pieces(line: str) -> list[str]:
    """Return the texts between the bars of a table's line; text behind the closing bar is no cell."""
    pieces = CELL_END.split(line.strip()[1:])
    return pieces[:-1] if not pieces[-1].strip() else pieces


def csv_hint(text: str) -> str:
    """Excel's own first line that names the delimiter (`sep=;`), with its line break; it is no row of the sheet."""
    first, found, _ = text.partition("\n")
    return first + found if re.fullmatch(r"sep=[,;\t]\s*", first.lstrip(), re.IGNORECASE) else ""


def csv_delimiter(text: str, name: str) -> str:
    """The delimiter: the one that the file names, that makes a header row of ours, or that gives most columns.

    In a .tsv file, told by its name, it is the tab unless the file names another.
    """
    if hint := csv_hint(text):
        return hint.lstrip()[4]
    if name.casefold().endswith(TAB_SUFFIX):
        return "\t"
    bare = _QUOTED.sub('""', text)  # what stands in quotes is a text, whatever the delimiter

    def fitness(delimiter: str) -> tuple[bool, int]:
        rows = _parsed(text, delimiter, name)
        ours = recognise(text_sheet(name, rows[: limits.HEADER_ROWS])).kind is not None
        fields = rows if bare == text else _parsed(bare, delimiter, name)
        return ours, max((len(r) for r in fields[: limits.HEADER_ROWS]), default=0)

    usual, others = DELIMITERS[0], DELIMITERS[1:]
    return max((usual, *(d for d in others if d in text)), key=fitness)


def _parsed(text: str, delimiter: str, name: str) -> list[list[str]]:
    try:
        return list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
    except csv.Error as error:
        raise unreadable("FILE008", name=name, what=N_("a cell is too long or a double quote is not closed")) from error


def _overlong(sheet: str, rows: list[list[str]]) -> list[Diagnostic]:
    """Rows with more filled cells than the first filled row has: a delimiter inside a text, most likely."""
    width = next((len(r) for r in rows if any(c.strip() for c in r)), 0)
    wide = [number for number, row in enumerate(rows, 1) if any(c.strip() for c in row[width:])]
    return [Diagnostic("SHEET017", Address(sheet, number, width + 1)) for number in wide[:20]]


def natural(name: str) -> list[tuple[int, int, str]]:
    """The order of names in which numbers count as numbers."""
    parts = re.split(r"(\d{1,9})", name.casefold())
    return [(0, int(p), "") if p.isascii() and p.isdigit() else (1, 0, p) for p in parts if p]
