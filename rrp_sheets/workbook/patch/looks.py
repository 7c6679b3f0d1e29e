"""Looks of cells in a package: cell styles are added where there is none like the wanted one."""

from __future__ import annotations

from copy import deepcopy

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import SetLook
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch.package_edit import PackageEdit, XmlPart
from rrp_sheets.workbook.patch.sheets import place_style
from rrp_sheets.workbook.xlsx import number

_BEFORE_BOLD = frozenset({"name", "charset", "family"})  # openpyxl writes them first, and keeps a font's order


def set_look(package: PackageEdit, edit: SetLook) -> None:
    """Give a cell another look; raises SheetsError when the file has no styles."""
    parts = package.related(package.book.part, "styles")
    styles = package.part(parts[0]) if parts else None
    if styles is None or not all(styles.children("styleSheet", name) for name in ("fonts", "fills", "cellXfs")):
        raise SheetsError(N_("This file has no formats of cells."), N_("Save it in Excel or LibreOffice once."))
    sheet = package.sheet(package.index(edit.sheet))
    style = sheet.style(edit.row, edit.column)
    wanted = (style, edit.bold, edit.fill, edit.wrap)
    if wanted not in package.styled:
        package.styled[wanted] = _styled(styles, style, edit)
    sheet.set_style(edit.row, edit.column, package.styled[wanted])


def _styled(styles: XmlPart, style: int, edit: SetLook) -> int:
    """The number of a cell style like another one, with what the edit changes of it."""
    there = styles.children("styleSheet", "cellXfs")
    xf = deepcopy(there[style] if style < len(there) else there[0])
    if edit.bold is not None:
        _set_bold(styles, xf, edit.bold)
    if edit.fill is not None:
        _set_fill(styles, xf, edit.fill)
    if edit.wrap is not None:
        alignment = xml.child(xf, "alignment")
        if alignment is None:
            alignment = xml.add(xf, "alignment", {}, at=0)
        xml.set_attributes(alignment, {"wrapText": "1" if edit.wrap else "0"})
        xf.set("applyAlignment", "1")
    return place_style(styles, "cellXfs", xf, {})


def _set_bold(styles: XmlPart, xf: etree._Element, bold: bool) -> None:
    fonts = styles.children("styleSheet", "fonts")
    at = number(xf.get("fontId"))
    font = deepcopy(fonts[at] if at < len(fonts) else fonts[0])
    for mark in font.findall("{*}b"):
        font.remove(mark)
    if bold:
        xml.add(font, "b", {}, at=sum(xml.local(e) in _BEFORE_BOLD for e in list(font)[:3]))
    xf.set("fontId", str(place_style(styles, "fonts", font, {})))
    xf.set("applyFont", "1")


def _set_fill(styles: XmlPart, xf: etree._Element, fill: str) -> None:
    at = 0
    if fill:
        new = xml.new_element(styles.children("styleSheet", "fills")[0], "fill", {})
        pattern = xml.add(new, "patternFill", {"patternType": "solid"})
        xml.add(pattern, "fgColor", {"rgb": f"FF{fill}"})
        xml.add(pattern, "bgColor", {"indexed": "64"})
        at = place_style(styles, "fills", new, {})
    xf.set("fillId", str(at))
    xf.set("applyFill", "1")
