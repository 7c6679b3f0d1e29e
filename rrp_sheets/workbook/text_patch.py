"""Makes the texts of CSV and Markdown files and changes cells, rows and sheets in them; all else stays as it is."""

from __future__ import annotations

import base64
import json
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import edits, limits, text_books
from rrp_sheets.workbook.raw import Format, Rows, text_sheet
from rrp_sheets.workbook.schema import recognise
from rrp_sheets.workbook.sheet_names import header_row, refuse_more, sheet_name, sheet_named

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+\Z")
NO_FILE_NAME = re.compile(r"[/\\\x00-\x1f]|^[.~ ]|[. ]$")
"""Matches a sheet's name that cannot be a file's name."""
_HEADING = re.compile(r"^#{1,2}[ \t].*$", re.MULTILINE)


class EncodedText:
    """A file's text with its encoding, its byte order mark and its line breaks, all of which stay.

    A text that the old encoding cannot hold makes the file UTF-8 with a mark, which Excel understands.
    """

    def __init__(self, data: bytes) -> None:
        marks = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
        self._encoding = next((name for mark, name in marks.items() if data.startswith(mark)), "utf-8")
        try:
            self.text = data.decode(self._encoding)
        except UnicodeDecodeError:
            self._encoding = "cp1252"
            self.text = data.decode(self._encoding)
        breaks = re.findall(r"\r\n|\r|\n", self.text)
        self.newline = max(set(breaks), key=breaks.count) if breaks else "\n"

    def encode(self, text: str) -> bytes:
        """Another text as this file's bytes."""
        try:
            return text.encode(self._encoding)
        except UnicodeEncodeError:
            return text.encode("utf-8-sig")


def texts_only(edit: edits.SetComments | edits.SetLook) -> SheetsError:
    """The error for what a file that has only the texts of cells cannot keep."""
    if isinstance(edit, edits.SetComments):
        message = N_("A text file (CSV, Markdown) has no place for comments of cells.")
        return SheetsError(message, N_("Write it into the column Notes, or use an .xlsx workbook."))
    message = N_("A text file (CSV, Markdown) has no place for bold, colours and line breaks.")
    return SheetsError(message, N_("Use an .xlsx workbook."))


class TextTable(ABC):
    """The rows of one sheet as lines of a text: `head`, one entry per row in `lines`, `tail`.

    Subclasses know how a row is written.
    """

    def __init__(self, name: str, newline: str) -> None:
        self.name, self.newline = name, newline
        self.head = self.tail = ""
        self.lines: list[str] = []
        self.first_movable = 1

    @abstractmethod
    def cells(self, line: str) -> list[str]:
        """The texts of a row's cells."""

    @abstractmethod
    def with_cell(self, line: str, column: int, text: str) -> str:
        """A row with another text in one cell."""

    @abstractmethod
    def blank(self) -> str:
        """A blank row."""

    def apply(self, edit: edits.SetCell | edits.RowEdit) -> None:
        """Set a cell, or insert, delete or move rows; raises SheetsError where that cannot be."""
        if not isinstance(edit, edits.SetCell):
            self._change_rows(edit)
            return
        rows, columns = limits.ROWS, limits.COLUMNS
        if not (1 <= edit.row <= rows and 1 <= edit.column <= columns):
            how = N_(
                "A sheet in a text file has at most {rows:,} rows and {columns} columns.", rows=rows, columns=columns
            )
            raise SheetsError(N_("There is no cell {cell}.", cell=edit.place), how)
        text = edits.shown(edit.checked_value())
        if "\0" in text:
            message = N_("The text for {cell} contains a zero byte.", cell=edit.place)
            raise SheetsError(message, N_("Type the text again."))
        if not text and edit.row > len(self.lines):
            return
        self._reach(edit.row)
        self.lines[edit.row - 1] = self.with_cell(self.lines[edit.row - 1], edit.column, text)

    def _reach(self, row: int) -> None:
        """Have at least so many rows, and a line break behind the last one."""
        if self.lines and not self.lines[-1].endswith(("\n", "\r")) and (len(self.lines) < row):
            self.lines[-1] += self.newline
        self.lines += [self.blank() for _ in range(row - len(self.lines))]

    def _change_rows(self, edit: edits.RowEdit) -> None:
        if edit.start < 1 or edit.count < 1:
            raise SheetsError(N_("There are no such rows."), N_("Rows count from 1; name at least one."))
        head = [self.cells(line) for line in self.lines[: limits.HEADER_ROWS]]
        recognised = recognise(text_sheet(self.name, head))
        first = max(recognised.row + 1 if recognised.kind else 1, self.first_movable)
        if edit.start < first:
            raise header_row(self.name, first - 1)
        if isinstance(edit, edits.MoveRows):
            if not edit.moves:
                return
            last = needed = max(edit.first + edit.count, edit.before)
        elif edit.start > len(self.lines):
            return  # below everything: nothing to insert before, nothing to delete
        else:
            last, needed = edit.start + edit.count, len(self.lines) + 1
        if len(self.lines) + edit.count > limits.ROWS or last > 2 * limits.ROWS:
            message = N_("A sheet in a text file has at most {n:,} rows.", n=limits.ROWS)
            raise SheetsError(message, N_("Delete rows first."))
        self._reach(needed)
        if not isinstance(edit, edits.MoveRows):
            self.lines.pop()  # it was only there for the line break
        placed = {new: line for n, line in enumerate(self.lines, 1) if (new := edit.mapped(n)) is not None}
        self.lines = [placed.get(n) or self.blank() for n in range(1, max(placed, default=0) + 1)]
        if isinstance(edit, (edits.MoveRows, edits.DeleteRows)):
            while len(self.lines) > 1 and self.lines[-1] == self.blank():
                self.lines.pop()

    def whole(self) -> str:
        """The text as it is now."""
        return self.head + "".join(self.lines) + self.tail


class CsvTable(TextTable):
    """A CSV file, or a .tsv file, which `file` tells."""

    def __init__(self, name: str, text: str, newline: str, file: str = "") -> None:
        super().__init__(name, newline)
        self.head = text_books.csv_hint(text)
        self._delimiter = text_books.csv_delimiter(text.replace("\r\n", "\n").replace("\r", "\n"), file or name)
        body = text[len(self.head) :]
        delimiter = re.escape(self._delimiter)
        field = rf'(?:"(?:[^"]|"")*+(?:"|\Z))?+[^{delimiter}\r\n]*+'
        self._field = re.compile(field)
        line = re.compile(rf"(?:{field}{delimiter})*{field}(?:\r\n|\r|\n|\Z)")
        at = 0
        while at < len(body):
            match = line.match(body, at)
            if match is None or match.end() == at:  # cannot be: a field may be empty
                message = N_("“{name}” cannot be read.", name=file or name)
                raise SheetsError(message, N_("Save it again in LibreOffice."))
            self.lines.append(match[0])
            at = match.end()

    def _spans(self, line: str) -> list[tuple[int, int]]:
        body = line.rstrip("\r\n")
        spans, at = [], 0
        while match := self._field.match(body, at):
            spans.append(match.span())
            at = match.end() + 1
            if at > len(body):
                break
        return spans if body else []

    def cells(self, line: str) -> list[str]:
        """The texts of a row's fields."""
        fields = [line[a:b] for a, b in self._spans(line)]
        bare = [f[1:-1].replace('""', '"') if f[:1] == f[-1:] == '"' and len(f) > 1 else f for f in fields]
        return [text_books.from_csv(f) for f in bare]

    def with_cell(self, line: str, column: int, text: str) -> str:
        """A row with another text in one field; a field that was quoted stays so."""
        spans = self._spans(line)
        body = line.rstrip("\r\n")
        if column > len(spans):
            more = self._delimiter * (column - max(len(spans), 1)) + text_books.to_csv(text, self._delimiter)
            return body + more + line[len(body) :] if text else line
        a, b = spans[column - 1]
        return line[:a] + text_books.to_csv(text, self._delimiter, quoted=line[a:b].startswith('"')) + line[b:]

    def blank(self) -> str:
        """A row of empty fields."""
        width = max((len(self._spans(line)) for line in self.lines[: limits.HEADER_ROWS]), default=1)
        return self._delimiter * (width - 1) + self.newline


class MarkdownTable(TextTable):
    """The table below one heading of a Markdown file."""

    def __init__(self, name: str, text: str, newline: str) -> None:
        super().__init__(name, newline)
        self.first_movable = 2
        lines = _LINE.findall(text)
        heads = ((i, text_books.HEADING.fullmatch(line.strip())) for i, line in enumerate(lines))
        begin = next(i for i, head in heads if head and head[1] == name)
        before, rows, after = text_books.first_table(lines[begin:])
        self._rule = rows.pop(1) if len(rows) > 1 and text_books.RULE.fullmatch(rows[1].strip()) else ""
        self.head, self.lines, self.tail = "".join([*lines[:begin], *before]), rows, "".join(after)
        self._wide = self._columns()

    def _columns(self) -> int:
        return len(text_books.markdown_pieces(self.lines[0])) if self.lines else 0

    def cells(self, line: str) -> list[str]:
        """The texts of a row's cells."""
        return [text_books.from_markdown(piece) for piece in text_books.markdown_pieces(line)]

    def with_cell(self, line: str, column: int, text: str) -> str:
        """A row with another text in one cell; columns that are set in line stay in line where it fits."""
        edge = line[: len(line) - len(line.lstrip())]
        pieces = text_books.markdown_pieces(line)
        pieces += ["  "] * (column - len(pieces))
        pieces[column - 1] = f" {text_books.to_markdown(text)} ".ljust(len(pieces[column - 1]))
        return f"{edge}|{'|'.join(pieces)}|{line[len(line.rstrip()) :]}"

    def blank(self) -> str:
        """A row of empty cells."""
        return "|" + "  |" * max(self._columns(), 1) + self.newline

    def whole(self) -> str:
        """The text as it is now."""
        rule = self._rule
        if rule and (more := self._columns() - self._wide) > 0:  # else it would be a table no more
            bare = rule.rstrip()
            rule = f"{bare}{'' if bare.endswith('|') else '|'}{'---|' * more}{rule[len(bare) :]}"
        lines = self.lines[:1] + ([rule] if rule else []) + self.lines[1:]
        if len(self.lines) > 1 and self._rule and not self._rule.endswith(("\n", "\r")):
            lines[1] += self.newline
        return self.head + "".join(lines) + self.tail


def markdown_text(sheets: Mapping[str, Rows]) -> str:
    r"""The sheets as Markdown tables, each below its name.

    >>> print(markdown_text({"T": [["From", "To"], ["a|b"]]}))
    ## T
    <BLANKLINE>
    | From | To |
    |------|----|
    | a\|b |    |
    <BLANKLINE>
    """
    tables = []
    for name, rows in sheets.items():
        width = max((len(row) for row in rows), default=1) or 1
        cells = [[text_books.to_markdown(text) for text in row] + [""] * (width - len(row)) for row in rows or [[]]]
        widths = [min(max(2, *(len(row[c]) for row in cells)), 60) for c in range(width)]
        lines = ["| " + " | ".join(t.ljust(w) for t, w in zip(row, widths, strict=True)) + " |" for row in cells]
        lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
        heading = " ".join(name.split()) + (" #" if name.rstrip().endswith("#") else "")
        tables.append(f"## {heading}\n\n" + "\n".join(lines) + "\n")
    return "\n".join(tables)


def csv_text(rows: Rows, delimiter: str = ",") -> str:
    r"""Rows as CSV; where another delimiter than the comma could be taken for the right one, the first line names it.

    With the tab as delimiter the text is for a .tsv file.

    >>> csv_text([["a", "1,5"], [], ["=b"]])
    'a,"1,5"\n\n\'=b\n'
    """
    body = "".join(delimiter.join(text_books.to_csv(text, delimiter) for text in row) + "\n" for row in rows)
    if delimiter == "\t":
        return body
    return body if text_books.csv_delimiter(body, "") == "," else "sep=,\n" + body


def _refuse_last(names: list[str]) -> None:
    if len(names) < 2:
        raise SheetsError(N_("“{sheet}” is the only sheet.", sheet=names[0]), N_("Add another one first."))


@dataclass
class CsvFolder:
    """A folder of CSV files while its sheets change: contents by sheet, and the order of `order.txt`, if there is one.

    The sheets in `tabs` are .tsv files. New sheets are, too, when all others are.
    """

    files: dict[str, bytes]
    order: list[str]
    tabs: set[str] = field(default_factory=set)

    @property
    def names(self) -> list[str]:
        """The sheets in their order."""
        places = {sheet: i for i, sheet in enumerate(self.order)}
        return sorted(self.files, key=lambda sheet: (places.get(sheet, len(places)), text_books.natural(sheet)))

    def file_name(self, sheet: str) -> str:
        """The name of a sheet's file."""
        return f"{sheet}{text_books.TAB_SUFFIX if sheet in self.tabs else '.csv'}"

    def apply(self, edit: edits.SheetEdit) -> str:
        """Carry out an edit; of a deletion, what brings the sheet back."""
        names, kept = self.names, ""
        match edit:
            case edits.AddSheet():
                refuse_more(names)
                name = _file_name(sheet_name(edit.sheet, names))
                place = names.index(sheet_named(names, edit.before)) if edit.before else len(names)
                if self.tabs and len(self.tabs) == len(self.files):
                    self.tabs.add(name)
                delimiter = "\t" if name in self.tabs else ","
                self.files[name] = csv_text(edit.rows, delimiter).encode("utf-8-sig")
                names.insert(place, name)
            case edits.RenameSheet():
                old = sheet_named(names, edit.sheet)
                new = _file_name(sheet_name(edit.name, [n for n in names if n != old]))
                self.files[new] = self.files.pop(old)
                if old in self.tabs:
                    self.tabs = self.tabs - {old} | {new}
                names[names.index(old)] = new
            case edits.MoveSheet():
                _move(names, edit)
            case edits.DeleteSheet():
                name = sheet_named(names, edit.sheet)
                _refuse_last(names)
                data = base64.b64encode(self.files.pop(name)).decode()
                what = {"sheet": name, "place": names.index(name), "data": data, "tabs": name in self.tabs}
                kept = json.dumps(what, ensure_ascii=False)
                self.tabs.discard(name)
                names.remove(name)
            case edits.BringSheet():
                was = json.loads(edit.kept)
                name = sheet_name(was["sheet"], names)
                self.files[name] = base64.b64decode(was["data"])
                if was.get("tabs"):
                    self.tabs.add(name)
                names.insert(was["place"], name)
        if self.order or names != sorted(names, key=text_books.natural):
            self.order = names
        return kept


def _file_name(name: str) -> str:
    if NO_FILE_NAME.search(name) or len(name.encode()) > 200 or re.search(r'[<>|"]', name):
        message = N_("“{name}” cannot be the name of a file.", name=name)
        raise SheetsError(message, N_("Begin and end it with a letter or a digit."))
    return name


def _move(names: list[str], edit: edits.MoveSheet) -> None:
    name = sheet_named(names, edit.sheet)
    before = sheet_named(names, edit.before) if edit.before else ""
    if before == name:
        return
    names.remove(name)
    names.insert(names.index(before) if before else len(names), name)


class MarkdownSheets:
    """A Markdown text cut into what stands before the first sheet, and the sheets.

    Headings that are not in `names` belong to what is around them.
    """

    def __init__(self, text: str, names: list[str], newline: str) -> None:
        self._newline = newline
        wanted, begins = list(names), [0]
        self.names: list[str] = []
        heads = list(_HEADING.finditer(text))
        for i, head in enumerate(heads):
            found = text_books.HEADING.fullmatch(head[0].strip())
            end = heads[i + 1].start() if i + 1 < len(heads) else len(text)
            has_table = re.search(r"^[ \t]*\|", text[head.end() : end], re.MULTILINE) is not None
            if found and wanted and found[1] == wanted[0] and has_table:
                self.names.append(wanted.pop(0))
                begins.append(head.start())
        ends = [*begins[1:], len(text)]
        self._pieces = [text[a:b] for a, b in zip(begins, ends, strict=True)]

    def apply(self, edit: edits.SheetEdit) -> str:
        """Carry out an edit; of a deletion, what brings the sheet back."""
        names, pieces = self.names, self._pieces
        match edit:
            case edits.AddSheet():
                refuse_more(names)
                name = sheet_name(edit.sheet, names)
                place = names.index(sheet_named(names, edit.before)) if edit.before else len(names)
                self._insert(place, name, markdown_text({name: edit.rows}).replace("\n", self._newline))
            case edits.RenameSheet():
                old = sheet_named(names, edit.sheet)
                at = names.index(old)
                names[at] = sheet_name(edit.name, [n for n in names if n != old])
                pieces[at + 1] = _renamed(pieces[at + 1], names[at])
            case edits.MoveSheet():
                before = list(names)
                _move(names, edit)
                by_name = dict(zip(before, pieces[1:], strict=True))
                pieces[1:] = [self._ended(by_name[name]) for name in names] if names != before else pieces[1:]
            case edits.DeleteSheet():
                _refuse_last(names)
                at = names.index(sheet_named(names, edit.sheet))
                what = {"sheet": names.pop(at), "place": at, "text": pieces.pop(at + 1)}
                return json.dumps(what, ensure_ascii=False)
            case edits.BringSheet():
                was = json.loads(edit.kept)
                self._insert(was["place"], sheet_name(was["sheet"], names), was["text"])
        return ""

    def _insert(self, place: int, name: str, text: str) -> None:
        self._pieces[place] = self._ended(self._pieces[place]) if place or self._pieces[0] else ""
        self.names.insert(place, name)
        self._pieces.insert(place + 1, text if place + 1 == len(self._pieces) else self._ended(text))

    def _ended(self, piece: str) -> str:
        """A piece that another can follow: it ends with a blank line."""
        if piece.endswith(self._newline * 2) or not piece:
            return piece
        return piece + self._newline * (1 if piece.endswith(("\n", "\r")) else 2)

    def whole(self) -> str:
        """The text as it is now."""
        return "".join(self._pieces)


def _renamed(piece: str, name: str) -> str:
    head = _HEADING.match(piece)
    assert head is not None
    line = re.sub(r"(##[ \t]+).*", lambda m: m[1] + name + (" #" if name.endswith("#") else ""), head[0], count=1)
    return line + ("\r" if head[0].endswith("\r") else "") + piece[head.end() :]


def edit_markdown(data: bytes, name: str, changes: Sequence[edits.Edit]) -> tuple[bytes, tuple[str, ...]]:
    """Change a Markdown file, of which only the lines that change are others; see `Format`."""
    names = list(text_books.read_markdown(data, name).names)
    text, kept = EncodedText(data), list[str]()
    whole = text.text
    for one in changes:
        if isinstance(one, edits.SheetEdit):
            sheets = MarkdownSheets(whole, names, text.newline)
            kept += [back] if (back := sheets.apply(one)) else []
            whole, names = sheets.whole(), sheets.names
            continue
        if isinstance(one, edits.SetComments | edits.SetLook):
            raise texts_only(one)
        table = MarkdownTable(sheet_named(names, one.sheet), whole, text.newline)
        table.apply(one)
        whole = table.whole()
    return text.encode(whole), tuple(kept)


def _markdown_bytes(sheets: Mapping[str, Rows]) -> bytes:
    return markdown_text(sheets).encode()


MARKDOWN = Format(
    "markdown", (".md", ".markdown"), text_books.read_markdown, edit_markdown, _markdown_bytes, text_books.text_digest
)
