"""Making styled .xlsx workbooks and sheets from plain rows: looks, text cells, drop-downs, prompts, print setup."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import FALSE_WORDS, column_letters
from rrp_sheets.texts import N_, translate
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.schema import (
    DEVICES,
    FIELDS,
    OWN,
    PROTOCOL,
    Recognised,
    field_key,
    fixed_lists,
    language_of,
    list_name,
    recognise,
)
from rrp_sheets.workbook.sheet_names import FORBIDDEN, LONGEST
from rrp_sheets.workbook.xlsx import IMPOSSIBLE, escape_literal

FONT = "Arial"  # on every machine, or with a replacement of the same widths
SIZE = 10
INK, PALE_INK, RULE = "1F2D3A", "5F6B76", "C9D3DB"
MARK, OFF_INK = "FFE9B8", "8A949C"
ROWS = 200
_LISTS = re.compile(r"リスト|Lists(?: for drop-downs(?: \d+)?)?")
"""Name of the sheet with the entries of the drop-downs."""
_LETTER = 0.75  # the mean width of a letter, in widths of a digit, with room to spare
_PROMPT_TITLE_LENGTH, _PROMPT_LENGTH = 32, 255  # Excel's limits


def workbook_bytes(
    sheets: Mapping[str, Sequence[Sequence[str]]], offers: Offers | None = None, language: str = ""
) -> bytes:
    """Make a workbook of rows of texts that opens, looks right and prints well; the same rows give the same bytes.

    Which row is the header is found as in reading. A Lists sheet that the program has made is made again. Prompts and
    drop-downs are in the language, or that of the headers. Raises SheetsError when a text is too long for a cell.
    """
    from openpyxl import Workbook

    if offers is not None:
        sheets = {name: rows for name, rows in sheets.items() if not offers.made(name, rows)}
    book = Workbook()
    book.remove(book.worksheets[0])
    taken = {name.casefold() for name in sheets}
    recognised = {name: recognise(text_sheet(name, rows)) for name, rows in sheets.items()}
    language = language or _language(sheets, recognised)
    lists_name = "リスト" if language == "ja" else "Lists"
    lists_name = lists_name if lists_name.casefold() not in taken else "Lists for drop-downs"
    titles = sheet_titles([*sheets, lists_name])
    entries = offers.lists(language) if offers else {}
    lists = _name_lists(book, titles[lists_name], entries, _streams(sheets, recognised, titles))
    for name, rows in sheets.items():
        SheetMaker(book.create_sheet(titles[name]), rows, recognised[name], lists, language).make()
    if offers is not None:
        sheet = book.create_sheet(titles[lists_name])
        head = [*(japanese.japanese(japanese.LISTS, entries) if language == "ja" else entries)]
        maker = SheetMaker(sheet, [head, *zip_longest(*entries.values(), fillvalue="")], Recognised(), {})
        maker.last = len(maker.rows)
        maker.make()
    book.properties.language = language
    book.properties.creator = "RRP Sheets"
    return packed(book)


def sheet_titles(names: Sequence[str]) -> dict[str, str]:
    r"""Names that Excel accepts: at most 31 characters, no `[ ] : * ? / \`, no two alike.

    >>> sheet_titles(["Ask: yes/no?", "ask_ yes_no_"])
    {'Ask: yes/no?': 'Ask_ yes_no_', 'ask_ yes_no_': 'ask_ yes_no_ 2'}
    """
    titles: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        stem = FORBIDDEN.sub("_", name).strip().strip("'")[:LONGEST] or "Sheet"
        title, number = stem, 2
        while title.casefold() in taken or title.casefold() == "history":  # Excel keeps that name for itself
            title, number = f"{stem[: LONGEST - len(str(number)) - 1]} {number}", number + 1
        taken.add(title.casefold())
        titles[name] = title
    return titles


def _streams(
    sheets: Mapping[str, Sequence[Sequence[str]]], recognised: Mapping[str, Recognised], titles: Mapping[str, str]
) -> str:
    """The range of the first Devices sheet's streams; empty when there is no such sheet."""
    for name, what in recognised.items():
        if what.kind is DEVICES:
            letter, first = column_letters(what.columns["Stream"]), what.row + 1
            last = max(len(sheets[name]), what.row + ROWS)
            quoted = titles[name].replace("'", "''")
            return f"'{quoted}'!${letter}${first}:${letter}${last}"
    return ""


def _language(sheets: Mapping[str, Sequence[Sequence[str]]], recognised: Mapping[str, Recognised]) -> str:
    """Return the language of the headers of ours."""
    heads = ((sheets[name][what.row - 1], what) for name, what in recognised.items() if what.kind)
    return language_of(head[at - 1] for head, what in heads for at in what.columns.values())


def _name_lists(book: Any, title: str, lists: Mapping[str, Sequence[str]], streams: str) -> dict[str, str]:
    """Define a name for every list, and one for the streams of the Devices sheet; the names by the lists' titles."""
    from openpyxl.workbook.defined_name import DefinedName

    places = {"Streams": streams} if streams else {}
    for column, (name, entries) in enumerate(lists.items(), 1):
        letter = column_letters(column)
        places[name] = f"'{title}'!${letter}$2:${letter}${len(entries) + 1}"
    for name, place in places.items():
        book.defined_names[list_name(name)] = DefinedName(list_name(name), attr_text=place)
    return {name: list_name(name) for name in places}


@dataclass(frozen=True, slots=True)
class Offers:
    """Names for drop-downs and for the marks of unknown names.

    The everyday connectors come first, then the advanced ones. `choices` has further ones by column header (`Mode`,
    `Joint`, `Thing`, `Does`).
    """

    connectors: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()  # devices that can be an input stream
    actuators: tuple[str, ...] = ()  # devices that can be an output stream
    choices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def lists(self, language: str = "en") -> dict[str, tuple[str, ...]]:
        """The columns of the Lists sheet by their English title, in a language; empty ones are left out."""
        lists = {
            "Connectors": self.connectors,
            "Sensors": self.sensors,
            "Actuators": self.actuators,
            "All devices": tuple(dict.fromkeys(self.sensors + self.actuators)),
            **fixed_lists(),
            **{title: tuple(names) for title, names in self.choices.items()},
        }
        own = {title: japanese.offered(title, names) for title, names in lists.items()} if language == "ja" else lists
        return {title: names for title, names in own.items() if names}

    def made(self, name: str, rows: Sequence[Sequence[str]]) -> bool:
        """Return whether a sheet is a Lists sheet that the program has made: it can be made again without loss.

        A sheet with another name, column or entry is the user's own.

        >>> offers = Offers(("map", "filter"))
        >>> offers.made("Lists", [["Connectors", "On or off"], ["map", "TRUE"]])
        True
        >>> offers.made("Lists", [["Connectors", "On or off"], ["mine", "TRUE"]])
        False
        """
        lists, own = self.lists(), self.lists("ja")
        titles = [japanese.standard(japanese.LISTS, text.strip()) for text in rows[0]] if rows else []
        if not _LISTS.fullmatch(name) or fixed_lists().keys().isdisjoint(titles) or not lists.keys() >= set(titles):
            return False
        known = [{key(entry) for entry in (*lists[title], *own[title])} for title in titles]
        return all(
            not text.strip() or (column < len(known) and key(text) in known[column])
            for row in rows[1:]
            for column, text in enumerate(row)
        )


class SheetMaker:
    """One sheet being made: openpyxl's sheet, its rows, what it is, and the defined names of the lists."""

    def __init__(
        self, sheet: Any, rows: Sequence[Sequence[str]], what: Recognised, lists: Mapping[str, str],
        language: str = "en",
    ) -> None:  # fmt: skip
        self.sheet, self.rows, self.what, self.lists, self.language = sheet, rows, what, lists, language
        self.header = what.row or next((n for n, row in enumerate(rows, 1) if any(row)), 1)
        self.width = max((len(row) for row in rows), default=1) or 1
        self.prose = what.kind is None and self.width == 1 and any(len(t) > 40 for row in rows for t in row)
        self.last = max(len(rows), self.header + (ROWS if not self.prose else 0))
        headers = {c: n for n, c in what.columns.items()} | dict(what.others)
        self.columns = {c: (what.kind or OWN).column(headers.get(c, "")) for c in range(1, self.width + 1)}

    def make(self) -> None:
        """Fill and style the sheet."""
        self._fill()
        self._set_page()
        if self.prose:
            self.sheet.column_dimensions["A"].width = 110
            self._set_heights()
            self.sheet.sheet_view.showGridLines = False
            return
        self.sheet.freeze_panes = f"A{self.header + 1}"
        self.sheet.print_title_rows = f"{self.header}:{self.header}"
        self._set_columns()
        self._set_heights()
        self._add_marks()

    def _fill(self) -> None:
        from openpyxl.styles import Alignment, Border, Font, PatternFill, Side

        wrapped = Alignment(vertical="center", wrap_text=True)
        body, notes = (Font(name=FONT, size=SIZE, color=ink) for ink in (INK, PALE_INK))
        head, title = (Font(name=FONT, size=size, bold=True, color=INK) for size in (SIZE, 16))
        self.sheet.sheet_properties.tabColor = colour = (self.what.kind or OWN).colour
        fill, line = PatternFill("solid", fgColor=colour), Border(bottom=Side("medium", color="8FA3B2"))
        # Setting one part of a style makes openpyxl search its tables for the rest of it, which takes most of the time:
        # the style of the first cell of each look is copied to the others.
        styles: dict[tuple[int, int], Any] = {}
        for number in range(1, self.last + 1):
            texts = self.rows[number - 1] if number <= len(self.rows) else ()
            for column in range(1, self.width + 1):
                cell = self.sheet.cell(number, column)
                _set_text(cell, texts[column - 1] if column <= len(texts) else "")
                plain = notes if self.columns[column].cells.as_typed else body
                if self.prose:
                    font = self._prose_font(number, title, head, body)
                else:
                    font = head if number == self.header else plain
                look = id(plain), id(font)
                if look not in styles:
                    cell.number_format, cell.alignment, cell.font = "@", wrapped, plain
                    cell.font = font  # after `plain`, which thereby has the same number in every file
                    if font is head and not self.prose:
                        cell.fill, cell.border = fill, line
                    styles[look] = cell._style
                cell._style = copy(styles[look])
        if not self.prose:
            self.sheet.row_dimensions[self.header].height = 24

    def _prose_font(self, number: int, title: Any, head: Any, body: Any) -> Any:
        """The first line is the title; a short line after a blank one is a heading."""
        texts = [row[0] if row else "" for row in self.rows]
        text = texts[number - 1]
        if number == self.header:
            return title
        heading = number > 1 and not texts[number - 2] and len(text) < 40 and text[-1:].isalnum()
        return head if heading else body

    def _set_page(self) -> None:
        sheet = self.sheet
        sheet.page_setup.orientation = "portrait" if self.prose else "landscape"
        sheet.page_setup.paperSize = 9  # A4
        sheet.page_setup.fitToWidth, sheet.page_setup.fitToHeight = 1, 0
        sheet.sheet_properties.pageSetUpPr.fitToPage = True
        sheet.page_margins.left = sheet.page_margins.right = 0.5
        sheet.page_margins.top, sheet.page_margins.bottom = 0.7, 0.6
        sheet.oddHeader.left.text, sheet.oddHeader.right.text = "&F", "&A"
        sheet.oddFooter.right.text = "&P / &N"
        for part in (sheet.oddHeader.left, sheet.oddHeader.right, sheet.oddFooter.right):
            part.size, part.font = 8, FONT

    def _set_columns(self) -> None:
        for number, column in self.columns.items():
            letter = column_letters(number)
            longest = max((len(r[number - 1]) for r in self.rows if len(r) >= number), default=0)
            width = column.width if self.what.kind and column.name else min(max(column.width, longest + 2), 60)
            self.sheet.column_dimensions[letter].width = width
            cells = f"{letter}{self.header + 1}:{letter}{self.last}"
            title, prompt = column.header(self.language), translate(column.prompt, self.language)
            add_prompt(self.sheet, cells, title, prompt, self.lists.get(column.offers))

    def _set_heights(self) -> None:
        """Make room for wrapped texts. Not every program does it on opening; all of them do after an edit."""
        widths = [self.sheet.column_dimensions[column_letters(c)].width for c in range(1, self.width + 1)]
        for number, row in enumerate(self.rows, 1):
            cells = zip(row, widths, strict=False)
            lines = [sum(1 + int(_digits(t) / width) for t in text.split("\n")) for text, width in cells]
            if number != self.header:
                self.sheet.row_dimensions[number].height = min(5 + 13 * max(lines, default=1), 400)
        for number in range(len(self.rows) + 1, self.last + 1):
            self.sheet.row_dimensions[number].height = 18

    def _add_marks(self) -> None:
        kind, row = self.what.kind, self.header + 1
        letters = {n: column_letters(c) for n, c in self.what.columns.items()}
        for column in kind.columns if kind else ():
            if column.known and (letter := letters.get(column.name)):
                ranges = {n: f"${at}${row}:${at}${self.last}" for n, at in letters.items()}
                known = [place for n in column.known if (place := ranges.get(n) or self.lists.get(n))]
                add_name_marks(self.sheet, f"{letter}{row}:{letter}{self.last}", f"${letter}{row}", known)
        if kind is PROTOCOL:
            for number, fields in enumerate(self.rows[self.header :], row):
                name = fields[self.what.columns["Field"] - 1] if fields else ""
                found = FIELDS.get(field_key(name))
                if found and found.prompt:
                    words = [found.shown(word, self.language) for word in found.words] if found.closed else []
                    prompt = translate(found.prompt, self.language)
                    choices = f'"{",".join(words)}"' if words else None
                    add_prompt(self.sheet, f"{letters['Value']}{number}", name, prompt, choices)
        on = next((letters[c.name] for c in self.columns.values() if c.kind == "on"), "")
        last = column_letters(self.width)
        add_row_marks(self.sheet, f"A{row}:{last}{self.last}", last, on)


def _digits(text: str) -> float:
    """Return the width of a text, in widths of a digit; a Japanese letter is as wide as two."""
    return sum(_LETTER if ord(letter) < 0x2E80 else 2.0 for letter in text)


def _set_text(cell: Any, text: str) -> None:
    n, most = len(text), limits.CELL_CHARACTERS
    if n > most:
        at = f"{cell.parent.title}!{cell.coordinate}"
        told = N_("The text of {cell} has {n:,} characters. The limit of a cell is {most:,}.", cell=at, n=n, most=most)
        raise SheetsError(told, N_("Shorten it."))
    if text:
        cell.value = escape_literal(IMPOSSIBLE.sub("\ufffd", text))
        cell.data_type = "s"  # after the value: a text that begins with = must not become a formula


def add_prompt(sheet: Any, cells: str, title: str, prompt: str, entries: str | None) -> None:
    """Give cells such as `A2:A201` a prompt, a drop-down, or both.

    The entries of the drop-down are the defined name of a list, or words in quotes with commas between them.
    """
    from openpyxl.worksheet.datavalidation import DataValidation

    if not entries and not prompt:
        return
    # With no type there is a prompt only. showErrorMessage stays off: what is not on the list may be typed.
    rule = DataValidation(type="list" if entries else None, formula1=entries or None, allow_blank=True)
    rule.showErrorMessage = False
    if prompt:
        rule.showInputMessage = True
        rule.promptTitle, rule.prompt = title[:_PROMPT_TITLE_LENGTH], prompt[:_PROMPT_LENGTH]
    rule.add(cells)
    sheet.add_data_validation(rule)


def add_row_marks(sheet: Any, cells: str, last: str, on: str = "") -> None:
    """A hairline under every filled row of cells such as `A2:F201`; comment rows and rows switched off are pale.

    Lines are conditional because lines under blank rows would be printed, page after page. `last` and `on` are the
    letters of the last column and of the one that switches rows off, if there is one.
    """
    from openpyxl.styles import Border, Font, Side

    row = cells[1 : cells.index(":")]
    pale = Font(color=OFF_INK, italic=True)
    tests = [f'LEFT($A{row},1)="#"']
    if on:
        off = f'",{",".join(sorted(FALSE_WORDS))},"'  # a text in a formula has at most 255 letters
        tests.append(f'AND(LEN(${on}{row})>0,ISNUMBER(SEARCH(","&${on}{row}&",",{off})))')
    for test in tests:
        _add_rule(sheet, cells, test, font=pale)
    _add_rule(sheet, cells, f"COUNTA($A{row}:${last}{row})>0", border=Border(bottom=Side("thin", color=RULE)))


def add_name_marks(sheet: Any, cells: str, first: str, known: list[str]) -> None:
    """Mark cells whose single name is in none of the ranges; capitals, spaces, _ and - make no difference.

    `cells` are such as `A2:A201`, `first` the first of them (`$A2`); the known names stand in ranges or defined names.
    """
    from openpyxl.styles import PatternFill

    if not known:
        return
    single = [f"LEN({first})>0", f'LEFT({first},1)<>"#"', f'RIGHT({first},5)<>" done"']
    single += [f"ISERROR(FIND({separator},{first}))" for separator in ('","', "CHAR(10)", '"!"')]
    unknown = [f"SUMPRODUCT(--({_key(names)}={_key(first)}))=0" for names in known]
    fill = PatternFill("solid", bgColor=MARK, fgColor=MARK)
    _add_rule(sheet, cells, f"AND({','.join(single + unknown)})", fill=fill)


def _add_rule(sheet: Any, cells: str, test: str, **look: Any) -> None:
    from openpyxl.formatting.rule import Rule
    from openpyxl.styles.differential import DifferentialStyle

    sheet.conditional_formatting.add(cells, Rule(type="expression", formula=[test], dxf=DifferentialStyle(**look)))


def _key(names: str) -> str:
    for joiner in (" ", "_", "-"):
        names = f'SUBSTITUTE({names},"{joiner}","")'
    return names


_MOMENT = (2026, 1, 1, 0, 0, 0)
_MODIFIED = re.compile(rb"(<dcterms:(?:created|modified)[^>]*>)[^<]*(</)")
_STAMP = rb"\g<1>2026-01-01T00:00:00Z\g<2>"
# Numbers are stored as text on purpose; without this Excel marks each with a green corner.
_AS_TEXT = b'<ignoredErrors><ignoredError sqref="A1:XFD1048576" numberStoredAsText="1"/></ignoredErrors></worksheet>'


def packed(book: Any) -> bytes:
    """Save an openpyxl workbook with a fixed date in its properties and in its zip entries."""
    first, second = io.BytesIO(), io.BytesIO()
    book.save(first)
    with zipfile.ZipFile(first) as source, zipfile.ZipFile(second, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "docProps/core.xml":
                data = _MODIFIED.sub(_STAMP, data)
            elif name.startswith("xl/worksheets/") and data.endswith(b"</worksheet>"):
                # A height without this attribute is adapted when the row's text changes.
                data = data.replace(b' customHeight="1"', b"").removesuffix(b"</worksheet>") + _AS_TEXT
            entry = zipfile.ZipInfo(name, _MOMENT)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            target.writestr(entry, data)
    return second.getvalue()
