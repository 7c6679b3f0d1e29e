"""Adding, renaming, moving and deleting sheets of CSV and Markdown workbooks."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass, field

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SheetEdit
from rrp_sheets.workbook.sheet_names import sheet_name
from rrp_sheets.workbook.text_books import HEADING, TAB_SUFFIX, natural
from rrp_sheets.workbook.text_patch import NO_FILE_NAME, csv_text, markdown_text, sheet_named

_HEADING = re.compile(r"^#{1,2}[ \t].*$", re.MULTILINE)


def _kept(**what: object) -> str:
    return json.dumps(what, ensure_ascii=False)


def _refuse_last(names: list[str]) -> None:
    if len(names) < 2:
        raise SheetsError(f"“{names[0]}” is the only sheet.", "Add another one first.")


def _refuse_more(names: list[str]) -> None:
    if len(names) >= limits.SHEETS:
        raise SheetsError(
            f"A workbook has at most {limits.SHEETS} sheets.", "Delete one first, or begin another workbook."
        )


@dataclass
class CsvFolder:
    """A folder of CSV files while its sheets change.

    Attributes:
        files: the contents by sheet.
        order: what `order.txt` says; empty without one.
        tabs: the sheets that are .tsv files. New sheets are, too, when all others are.
    """

    files: dict[str, bytes]
    order: list[str]
    tabs: set[str] = field(default_factory=set)

    @property
    def names(self) -> list[str]:
        """The sheets in their order."""
        places = {sheet: i for i, sheet in enumerate(self.order)}
        return sorted(self.files, key=lambda sheet: (places.get(sheet, len(places)), natural(sheet)))

    def file_name(self, sheet: str) -> str:
        """The name of a sheet's file."""
        return f"{sheet}{TAB_SUFFIX if sheet in self.tabs else '.csv'}"

    def apply(self, edit: SheetEdit) -> str:
        """Carry out an edit; of a deletion, what brings the sheet back."""
        names, kept = self.names, ""
        match edit:
            case AddSheet():
                _refuse_more(names)
                name = _file_name(sheet_name(edit.sheet, names))
                place = names.index(sheet_named(names, edit.before)) if edit.before else len(names)
                if self.tabs and len(self.tabs) == len(self.files):
                    self.tabs.add(name)
                delimiter = "\t" if name in self.tabs else ","
                self.files[name] = csv_text(edit.rows, delimiter).encode("utf-8-sig")
                names.insert(place, name)
            case RenameSheet():
                old = sheet_named(names, edit.sheet)
                new = _file_name(sheet_name(edit.name, [n for n in names if n != old]))
                self.files[new] = self.files.pop(old)
                if old in self.tabs:
                    self.tabs = self.tabs - {old} | {new}
                names[names.index(old)] = new
            case MoveSheet():
                _move(names, edit)
            case DeleteSheet():
                name = sheet_named(names, edit.sheet)
                _refuse_last(names)
                data = base64.b64encode(self.files.pop(name)).decode()
                kept = _kept(sheet=name, place=names.index(name), data=data, tabs=name in self.tabs)
                self.tabs.discard(name)
                names.remove(name)
            case BringSheet():
                was = json.loads(edit.kept)
                name = sheet_name(was["sheet"], names)
                self.files[name] = base64.b64decode(was["data"])
                if was.get("tabs"):
                    self.tabs.add(name)
                names.insert(was["place"], name)
        if self.order or names != sorted(names, key=natural):
            self.order = names
        return kept


def _file_name(name: str) -> str:
    if NO_FILE_NAME.search(name) or len(name.encode()) > 200 or re.search(r'[<>|"]', name):
        raise SheetsError(f"“{name}” cannot be the name of a file.", "Begin and end it with a letter or a digit.")
    return name


def _move(names: list[str], edit: MoveSheet) -> None:
    name = sheet_named(names, edit.sheet)
    before = sheet_named(names, edit.before) if edit.before else ""
    if before == name:
        return
    names.remove(name)
    names.insert(names.index(before) if before else len(names), name)


class MarkdownSheets:
    """A Markdown text cut into what stands before the first sheet, and the sheets.

    Args:
        text: of the file.
        names: its sheets; other headings belong to what is around them.
        newline: the file's line break.
    """

    def __init__(self, text: str, names: list[str], newline: str) -> None:
        self._newline = newline
        wanted, begins = list(names), [0]
        self.names: list[str] = []
        heads = list(_HEADING.finditer(text))
        for i, head in enumerate(heads):
            found = HEADING.fullmatch(head[0].strip())
            end = heads[i + 1].start() if i + 1 < len(heads) else len(text)
            has_table = re.search(r"^[ \t]*\|", text[head.end() : end], re.MULTILINE) is not None
            if found and wanted and found[1] == wanted[0] and has_table:
                self.names.append(wanted.pop(0))
                begins.append(head.start())
        ends = [*begins[1:], len(text)]
        self._pieces = [text[a:b] for a, b in zip(begins, ends, strict=True)]

    def apply(self, edit: SheetEdit) -> str:
        """Carry out an edit; of a deletion, what brings the sheet back."""
        names, pieces = self.names, self._pieces
        match edit:
            case AddSheet():
                _refuse_more(names)
                name = sheet_name(edit.sheet, names)
                place = names.index(sheet_named(names, edit.before)) if edit.before else len(names)
                self._insert(place, name, markdown_text({name: edit.rows}).replace("\n", self._newline))
            case RenameSheet():
                old = sheet_named(names, edit.sheet)
                at = names.index(old)
                names[at] = sheet_name(edit.name, [n for n in names if n != old])
                pieces[at + 1] = _renamed(pieces[at + 1], names[at])
            case MoveSheet():
                before = list(names)
                _move(names, edit)
                by_name = dict(zip(before, pieces[1:], strict=True))
                pieces[1:] = [self._ended(by_name[name]) for name in names] if names != before else pieces[1:]
            case DeleteSheet():
                _refuse_last(names)
                at = names.index(sheet_named(names, edit.sheet))
                return _kept(sheet=names.pop(at), place=at, text=pieces.pop(at + 1))
            case BringSheet():
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
