"""Drop-downs, prompts and the marks of unknown names in a new workbook. All of them only offer; none refuses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.workbook import style

_TITLE_LENGTH, _PROMPT_LENGTH = 32, 255  # Excel's limits


def add_prompt(sheet: Any, cells: str, title: str, look: style.Column, lists: Mapping[str, str]) -> None:
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
class Block:
    """The rows of a table: letters of its first and last column, numbers of its first and last row."""

    first: str
    last: str
    top: int
    bottom: int

    def __str__(self) -> str:
        return f"{self.first}{self.top}:{self.last}{self.bottom}"


def add_row_marks(sheet: Any, block: Block, on: str = "") -> None:
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
