"""The formulas of a sheet; those that stand once for several cells (`t="shared"`) as they are in each cell."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.model.cells import column_letters
from rrp_sheets.workbook.patch.markup import Element, find, inner_text, splice, text_xml
from rrp_sheets.workbook.patch.sheet_xml import RowXml, SheetXml


def formula_elements(row: RowXml) -> list[tuple[int, Element]]:
    """The `f` elements of a row with the columns of their cells."""
    cells = row.cells()
    found = []
    for f in find(row.raw, lambda path: path == ["row", "c", "f"]):
        cell = max((c for c in cells if c.element.start < f.start), key=lambda c: c.element.start)
        found.append((cell.column, f))
    return found


def formula_text(row: RowXml, formula: Element) -> str:
    """Return what the program shows in its formula bar, without the leading `=`."""
    raw = row.raw[formula.inner : formula.inner_end]
    return raw.decode() if b"&" not in raw and b"<" not in raw else inner_text(row.raw, formula)


def formulas(sheet: SheetXml) -> Iterator[tuple[RowXml, int, Element, str]]:
    """Every formula: its row, its column, its element, and its text for this cell."""
    masters: dict[str, tuple[str, str]] = {}
    for number in sorted(sheet.rows):
        row = sheet.rows[number]
        for column, f in formula_elements(row) if row.formulas else ():
            text, place = formula_text(row, f), f"{column_letters(column)}{number}"
            if f.attributes.get("t") == "shared":
                group = f.attributes.get("si", "")
                if text:
                    masters[group] = (text, place)
                elif group in masters:
                    text = _translated(*masters[group], place)
            yield row, column, f, text


def _translated(formula: str, origin: str, place: str) -> str:
    from openpyxl.formula.tokenizer import TokenizerError
    from openpyxl.formula.translate import Translator, TranslatorError

    try:
        return str(Translator("=" + formula, origin).translate_formula(place))[1:]
    except (TokenizerError, TranslatorError):
        return formula


def write_out(sheet: SheetXml) -> None:
    """Give every cell its own formula, so that rows are independent; what is calculated stays the same."""
    if not sheet.shared:
        return
    changes: dict[int, list[tuple[int, int, bytes]]] = {}
    for row, _, f, text in formulas(sheet):
        if f.attributes.get("t") == "shared":
            new = f"<{f.name}>".encode() + text_xml(text) + f"</{f.name}>".encode()
            changes.setdefault(row.number, []).append((f.start, f.end, new))
    for number, pieces in changes.items():
        sheet.rows[number].raw = splice(sheet.rows[number].raw, pieces)
    sheet.shared, sheet.touched = False, True
