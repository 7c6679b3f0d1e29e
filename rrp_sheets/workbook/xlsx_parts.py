"""The small parts of an .xlsx that its sheets refer to: the list of sheets, date formats, shared texts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.package import Package
from rrp_sheets.workbook.raw import Kind, unreadable
from rrp_sheets.workbook.xml_stream import Handler

_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_LITERAL = re.compile("_(?=x[0-9A-Fa-f]{4}_)")
_TEXT_FORMAT = 49
IMPOSSIBLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters, and halves of characters, that XML cannot hold."""
_TRUE = {"1", "true", "on"}


def number(text: str | None, default: int = 0) -> int:
    """A whole number of an attribute; the default where it is none, so that broken files stay readable."""
    return int(text) if text and text.isascii() and text.isdigit() and len(text) < 10 else default


def truth(text: str | None) -> bool:
    """A yes/no attribute."""
    return (text or "").casefold() in _TRUE


def unescape(text: str) -> str:
    r"""Undo Excel's `_x000D_` for characters that XML cannot hold; a carriage return is a line break.

    >>> unescape("a_x000D_b")
    'a\nb'
    """
    if "_x" in text:
        text = _ESCAPED.sub(lambda m: chr(int(m[1], 16)) if not 0xD800 <= int(m[1], 16) < 0xE000 else "", text)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def escape_literal(text: str) -> str:
    """A text that has the form of such an escape itself, so that it is read as it stands.

    >>> escape_literal("a_x000D_b"), unescape(escape_literal("a_x000D_b"))
    ('a_x005F_x000D_b', 'a_x000D_b')
    """
    return _LITERAL.sub("_x005F_", text) if "_x" in text else text


@dataclass(frozen=True, slots=True)
class SheetEntry:
    """A sheet as the workbook part lists it: its name, its part in the package, whether it is hidden."""

    name: str
    part: str
    hidden: bool


class WorkbookHandler(Handler):
    """Reads the list of sheets and the epoch of dates."""

    def __init__(self) -> None:
        super().__init__()
        self.sheets: list[tuple[str, str, bool]] = []
        self.mac_epoch = False

    def start(self, name: str, attributes: Any) -> None:
        """Note a sheet."""
        if name == "sheet":
            relation = next((v for n, v in attributes.items() if n.rpartition(":")[2] == "id"), "")
            hidden = attributes.get("state", "visible") != "visible"
            self.sheets.append((attributes.get("name", ""), relation, hidden))
        elif name == "workbookPr":
            self.mac_epoch = truth(attributes.get("date1904"))


class StylesHandler(Handler):
    """Finds the cell styles that show numbers as dates or times."""

    def __init__(self) -> None:
        super().__init__()
        self._formats: dict[int, str] = {}
        self._styles: list[int] = []
        self._kinds: dict[int, Kind | None] = {}
        self._inside = False

    def start(self, name: str, attributes: Any) -> None:
        """Note a number format, or the number format of a cell style."""
        if name == "numFmt":
            self._formats[number(attributes.get("numFmtId"))] = attributes.get("formatCode", "")
        elif name == "cellXfs":
            self._inside = True
        elif name == "xf" and self._inside:
            self._styles.append(number(attributes.get("numFmtId")))

    def end(self, name: str) -> None:
        """The list of cell styles ends."""
        if name == "cellXfs":
            self._inside = False

    def kind(self, style: int) -> Kind | None:
        """DATE or TIME for a style that shows one. Found out when asked for, because few cells are numbers."""
        format_id = self._styles[style] if style < len(self._styles) else 0
        if format_id not in self._kinds:
            self._kinds[format_id] = self._find_kind(format_id)
        return self._kinds[format_id]

    def is_text(self, style: int) -> bool:
        """Return whether a style takes everything that is typed for text (`@`)."""
        format_id = self._styles[style] if style < len(self._styles) else 0
        return format_id == _TEXT_FORMAT or self._formats.get(format_id, "") == "@"

    def _find_kind(self, format_id: int) -> Kind | None:
        if format_id == 0:
            return None
        from openpyxl.styles.numbers import BUILTIN_FORMATS, is_date_format, is_timedelta_format

        code = self._formats.get(format_id, BUILTIN_FORMATS.get(format_id, ""))
        if not code or len(code) > 255:
            return None
        if is_timedelta_format(code) or (is_date_format(code) and not re.search("[dyDY]", _bare(code))):
            return Kind.TIME
        return Kind.DATE if is_date_format(code) else None


def _bare(code: str) -> str:
    """A number format without its literal texts and bracketed parts."""
    return re.sub(r'"[^"]*"|\[[^\]]*\]|\\.|_.', "", code)


class _StringsHandler(Handler):
    """Collects the shared texts. Phonetic readings of Japanese texts (`rPh`) are no part of the text."""

    def __init__(self, refuse: Exception) -> None:
        super().__init__()
        self.texts: list[str] = []
        self._too_many = refuse
        self._phonetic = False

    def start(self, name: str, attributes: Any) -> None:
        """A text or a run of one begins."""
        if name == "t":
            self.wanted = not self._phonetic
        elif name == "rPh":
            self._phonetic = True
        elif name == "si":
            self.take_text()

    def end(self, name: str) -> None:
        """A text ends."""
        if name == "t":
            self.wanted = False
        elif name == "rPh":
            self._phonetic = False
        elif name == "si":
            self.texts.append(unescape(self.take_text()))
            if len(self.texts) > limits.SHARED_STRINGS:
                raise self._too_many


class SharedStrings:
    """The shared texts, read only as far as a sheet asks for them."""

    def __init__(self, package: Package, part: str | None) -> None:
        self._name = package.name
        refuse = unreadable(
            "FILE007", name=package.name, what=N_("more than {n} texts", n=f"{limits.SHARED_STRINGS:,}")
        )
        self._handler = _StringsHandler(refuse)
        self._reader = package.reader(part, self._handler) if part else None

    def get(self, index: int) -> str:
        """The text of that number; raises UnreadableFile when there is none."""
        texts = self._handler.texts
        while len(texts) <= index:
            if self._reader is None or not self._reader.step():
                if len(texts) > index:
                    break
                raise unreadable("FILE008", name=self._name, what=N_("a cell refers to a text that is missing"))
        return texts[index]
