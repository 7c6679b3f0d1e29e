"""Values that may be put into a cell, and their form in a cell."""

from __future__ import annotations

import math
import re

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import Value
from rrp_sheets.workbook.xlsx_sheet import number_text

_NUMBER = re.compile(r"-?(?:0|[1-9]\d{0,14})(?:\.\d{1,15})?")
_IMPOSSIBLE = re.compile("[\ud800-\udfff\ufffe\uffff]")
_ESCAPED = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f]|_(?=x[0-9A-Fa-f]{4}_)")


def typed(text: str) -> Value:
    """Return what a spreadsheet program would make of a typed text, where there is no doubt; else the text.

    A number is one when it reads the same afterwards: leading and trailing zeros, long numbers, dates and whatever
    begins with `=` stay texts. So do `true` and `false` in small letters.

    >>> typed("20"), typed("-0.5"), typed("007"), typed("1.50"), typed("TRUE"), typed("=A1"), typed("")
    (20.0, -0.5, '007', '1.50', True, '=A1', None)
    """
    if text in ("TRUE", "FALSE"):
        return text == "TRUE"
    if _NUMBER.fullmatch(text) and shown(float(text)) == text:
        return float(text)
    return text or None


def shown(value: Value) -> str:
    """A value as the reader gives it back.

    >>> shown(20.0), shown(True), shown(None)
    ('20', 'TRUE', '')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return value if isinstance(value, str) else number_text(float(value))


def check_value(value: Value, place: str) -> Value:
    r"""The value as it can be stored: line breaks as `\n`, whole text as it is.

    Raises:
        SheetsError: when a cell cannot hold it.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not math.isfinite(value):
        raise SheetsError(
            N_("{value} is no number that a cell can hold ({cell}).", value=str(value), cell=place),
            N_("Write a number, or a text."),
        )
    if not isinstance(value, str):
        return value
    value = value.replace("\r\n", "\n").replace("\r", "\n")
    length = len(value.encode("utf-16-le", "surrogatepass")) // 2  # as Excel counts
    if length > limits.CELL_CHARACTERS:
        raise SheetsError(
            N_("The text for {cell} has {n:,} characters; a cell holds {most:,}.",
               cell=place, n=length, most=limits.CELL_CHARACTERS),
            N_("Shorten it, or split it over several cells."),
        )  # fmt: skip
    if match := _IMPOSSIBLE.search(value):
        raise SheetsError(
            N_("The text for {cell} contains something that is no character ({code}).",
               cell=place, code=f"U+{ord(match[0]):04X}"),
            N_("Type the text again instead of pasting it."),
        )  # fmt: skip
    return value


def content(value: Value) -> tuple[str | None, str, str]:
    """The cell's type attribute, the element inside it (none: an empty name), and the text.

    A text stays in the cell itself (`inlineStr`), so that the part with the shared texts need not change. It can never
    become a formula, whatever it begins with.
    """
    if value is None or value == "":
        return None, "", ""
    if isinstance(value, bool):
        return "b", "v", f"{value:d}"
    if isinstance(value, (int, float)):
        number = float(value)
        return None, "v", str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    return "inlineStr", "is", _ESCAPED.sub(lambda m: f"_x{ord(m[0]):04X}_", value)
