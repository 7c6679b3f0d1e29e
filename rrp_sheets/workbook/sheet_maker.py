"""Making one styled sheet: its texts, its looks, its page, its prompts and drop-downs, its marks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.cells import column_letters
from rrp_sheets.model.names import key
from rrp_sheets.workbook import limits, style
from rrp_sheets.workbook.headers import Recognised
from rrp_sheets.workbook.xlsx_parts import escape_literal

_LETTER = 0.75  # the mean width of a letter, in widths of a digit, with room to spare
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


class SheetMaker:
    """One sheet being made: openpyxl's sheet, its rows, what it is, and the defined names of the lists."""

    def __init__(self, sheet: Any, rows: Sequence[Sequence[str]], what: Recognised, lists: Mapping[str, str]) -> None:
        self.sheet, self.rows, self.what, self.lists = sheet, rows, what, lists
        self.kind = what.kind.name if what.kind else ""
        self.header = what.row or next((n for n, row in enumerate(rows, 1) if any(row)), 1)
        self.width = max((len(row) for row in rows), default=1) or 1
        self.prose = not self.kind and self.width == 1 and any(len(t) > 40 for row in rows for t in row)
        self.last = max(len(rows), self.header + (style.ROWS if not self.prose else 0))
        self.names = {c: n for n, c in what.columns.items()} | dict(what.others)

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
        body = Font(name=style.FONT, size=style.SIZE, color=style.INK)
        notes = Font(name=style.FONT, size=style.SIZE, color=style.PALE_INK)
        head = Font(name=style.FONT, size=style.SIZE, bold=True, color=style.INK)
        title = Font(name=style.FONT, size=16, bold=True, color=style.INK)
        colour = style.HEADERS.get(self.kind, style.HEADERS[""])
        fill = PatternFill("solid", fgColor=colour)
        line = Border(bottom=Side("medium", color="8FA3B2"))
        self.sheet.sheet_properties.tabColor = colour
        # Setting one part of a style makes openpyxl search its tables for the rest of it, which takes most of the time:
        # the style of the first cell of each look is copied to the others.
        styles: dict[tuple[int, int], Any] = {}
        for number in range(1, self.last + 1):
            texts = self.rows[number - 1] if number <= len(self.rows) else ()
            for column in range(1, self.width + 1):
                cell = self.sheet.cell(number, column)
                _set_text(cell, texts[column - 1] if column <= len(texts) else "")
                plain = notes if self.names.get(column) == "Notes" else body
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
            part.size, part.font = 8, style.FONT

    def _set_columns(self) -> None:
        offered = frozenset(self.lists)
        for column in range(1, self.width + 1):
            letter, header = column_letters(column), self.names.get(column, "")
            look = style.column(self.kind, header, offered)
            longest = max((len(r[column - 1]) for r in self.rows if len(r) >= column), default=0)
            width = look.width if self.kind and header else min(max(look.width, longest + 2), 60)
            self.sheet.column_dimensions[letter].width = width
            cells = f"{letter}{self.header + 1}:{letter}{self.last}"
            add_prompt(self.sheet, cells, header, look, self.lists)

    def _set_heights(self) -> None:
        """Make room for wrapped texts. Not every program does it on opening; all of them do after an edit."""
        widths = [self.sheet.column_dimensions[column_letters(c)].width for c in range(1, self.width + 1)]
        for number, row in enumerate(self.rows, 1):
            lines = max(
                (
                    sum(1 + int(len(t) * _LETTER / width) for t in text.split("\n"))
                    for text, width in zip(row, widths, strict=False)
                ),
                default=1,
            )
            if number != self.header:
                self.sheet.row_dimensions[number].height = min(5 + 13 * lines, 400)
        for number in range(len(self.rows) + 1, self.last + 1):
            self.sheet.row_dimensions[number].height = 18

    def _add_marks(self) -> None:
        first, last, row = "A", column_letters(self.width), self.header + 1
        columns = {n: column_letters(c) for n, c in self.what.columns.items()}
        if self.kind == "behaviour":
            inputs, output, connector = (columns[n] for n in ("Input streams", "Output stream", "Connector"))
            names = [f"${output}${row}:${output}${self.last}"]
            names += [self.lists[n] for n in ("Streams", "Sensors") if n in self.lists]
            add_name_marks(self.sheet, f"{inputs}{row}:{inputs}{self.last}", f"${inputs}{row}", names)
            known = [self.lists["Connectors"]] if "Connectors" in self.lists else []
            add_name_marks(self.sheet, f"{connector}{row}:{connector}{self.last}", f"${connector}{row}", known)
        if self.kind == "devices" and "All devices" in self.lists:
            device = columns["Device"]
            cells = f"{device}{row}:{device}{self.last}"
            add_name_marks(self.sheet, cells, f"${device}{row}", [self.lists["All devices"]])
        if self.kind == "protocol":
            for number, fields in enumerate(self.rows[self.header :], row):
                name = fields[self.what.columns["Field"] - 1] if fields else ""
                choices, prompt = style.FIELDS.get(key(name), ((), ""))
                if choices:
                    add_choices(self.sheet, f"{columns['Value']}{number}", name, choices, prompt)
        on = columns.get("On", "") if self.kind == "behaviour" else ""
        add_row_marks(self.sheet, TableRange(first, last, row, self.last), on)


def _set_text(cell: Any, text: str) -> None:
    """Put a text into a cell as text, whatever it begins with."""
    if len(text) > limits.CELL_CHARACTERS:
        raise SheetsError(
            f"The text of {cell.parent.title}!{cell.coordinate} has {len(text):,} characters; a cell holds "
            f"{limits.CELL_CHARACTERS:,}.",
            "Shorten it.",
        )
    if text:
        cell.value = escape_literal(_CONTROL.sub("\ufffd", text))
        cell.data_type = "s"  # after the value: a text that begins with = must not become a formula


_TITLE_LENGTH, _PROMPT_LENGTH = 32, 255  # Excel's limits


def add_prompt(sheet: Any, cells: str, title: str, look: style.ColumnStyle, lists: Mapping[str, str]) -> None:
    """Give a column its prompt, and its drop-down when there is a list for it.

    Args:
        sheet: of openpyxl.
        cells: such as `A2:A201`.
        title: the column's header.
        look: the column's style.
        lists: the defined names of the lists by title.
    """
    from openpyxl.worksheet.datavalidation import DataValidation

    name = lists.get(look.offers, "")
    if not name and not look.prompt:
        return
    # With no type there is a prompt only. showErrorMessage stays off: what is not on the list may be typed.
    rule = DataValidation(type="list" if name else None, formula1=name or None, allow_blank=True)
    rule.showErrorMessage = False
    if look.prompt:
        rule.showInputMessage = True
        rule.promptTitle = title[:_TITLE_LENGTH]
        rule.prompt = look.prompt[:_PROMPT_LENGTH]
    rule.add(cells)
    sheet.add_data_validation(rule)


def add_choices(sheet: Any, cell: str, title: str, choices: Sequence[str], prompt: str) -> None:
    """Give one cell a drop-down of a few words (without commas in them), and a prompt."""
    from openpyxl.worksheet.datavalidation import DataValidation

    rule = DataValidation(type="list", formula1='"' + ",".join(choices) + '"', allow_blank=True)
    rule.showErrorMessage = False
    rule.showInputMessage, rule.promptTitle, rule.prompt = True, title[:_TITLE_LENGTH], prompt[:_PROMPT_LENGTH]
    rule.add(cell)
    sheet.add_data_validation(rule)


@dataclass(frozen=True, slots=True)
class TableRange:
    """The rows of a table: letters of its first and last column, numbers of its first and last row."""

    first: str
    last: str
    top: int
    bottom: int

    def __str__(self) -> str:
        return f"{self.first}{self.top}:{self.last}{self.bottom}"


def add_row_marks(sheet: Any, block: TableRange, on: str = "") -> None:
    """A hairline under every filled row; comment rows and rows switched off are pale.

    Lines are conditional because lines under blank rows would be printed, page after page.
    """
    from openpyxl.formatting.rule import Rule
    from openpyxl.styles import Border, Font, Side
    from openpyxl.styles.differential import DifferentialStyle

    cells, first, row = str(block), block.first, block.top
    pale = Font(color=style.OFF_INK, italic=True)
    tests = [f'LEFT(${first}{row},1)="#"']
    if on:
        tests.append(f'AND(LEN(${on}{row})>0,ISNUMBER(SEARCH(","&${on}{row}&",",",FALSE,no,off,0,")))')
    for test in tests:
        sheet.conditional_formatting.add(
            cells, Rule(type="expression", formula=[test], dxf=DifferentialStyle(font=pale))
        )
    line = Border(bottom=Side("thin", color=style.RULE))
    filled = f"COUNTA(${first}{row}:${block.last}{row})>0"
    sheet.conditional_formatting.add(
        cells, Rule(type="expression", formula=[filled], dxf=DifferentialStyle(border=line))
    )


def add_name_marks(sheet: Any, cells: str, first: str, known: list[str]) -> None:
    """Mark cells whose single name is in none of the ranges; capitals, spaces, _ and - make no difference.

    Args:
        sheet: of openpyxl.
        cells: such as `A2:A201`.
        first: the first of them, such as `$A2`.
        known: ranges or defined names that hold the known names.
    """
    from openpyxl.formatting.rule import Rule
    from openpyxl.styles import PatternFill
    from openpyxl.styles.differential import DifferentialStyle

    if not known:
        return
    single = [f"LEN({first})>0", f'LEFT({first},1)<>"#"', f'RIGHT({first},5)<>" done"']
    single += [f"ISERROR(FIND({separator},{first}))" for separator in ('","', "CHAR(10)", '"!"')]
    unknown = [f"SUMPRODUCT(--({_key(names)}={_key(first)}))=0" for names in known]
    fill = PatternFill("solid", bgColor=style.MARK, fgColor=style.MARK)
    test = f"AND({','.join(single + unknown)})"
    sheet.conditional_formatting.add(cells, Rule(type="expression", formula=[test], dxf=DifferentialStyle(fill=fill)))


def _key(names: str) -> str:
    for joiner in (" ", "_", "-"):
        names = f'SUBSTITUTE({names},"{joiner}","")'
    return names
