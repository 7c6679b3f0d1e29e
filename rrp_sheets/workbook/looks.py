"""Looks of cells that people give them: bold, a fill, and whether a long text is broken into lines."""

from __future__ import annotations

import colorsys
import re
from dataclasses import dataclass, field
from typing import Any

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.xlsx import Handler, XlsxBook, number, place, truth

FILLS = {"yellow": "FFF2CC", "green": "E2EFDA", "blue": "DDEBF7", "red": "FCE4E4", "purple": "E8E1F2", "grey": "E7E6E6"}
"""Colours that can be chosen, as a file has them. A page has its own shades of them, for light and dark."""
_HUES = ((20, "red"), (70, "yellow"), (165, "green"), (255, "blue"), (325, "purple"), (360, "red"))  # up to, in degrees
_PALE, _WHITE = 0.12, 0.97  # of saturation; of lightness
_CELL = re.compile(rb"<(?:[\w.-]+:)?c(?=[\s/>])((?:[^<>\"']|\"[^\"<]*\"|'[^'<]*')*)>")
_COLUMN = re.compile(rb"<(?:[\w.-]+:)?col(?=[\s/>])((?:[^<>\"']|\"[^\"<]*\"|'[^'<]*')*)>")
_ROW = re.compile(rb"<(?:[\w.-]+:)?row(?=[\s/>])")
_ATTRIBUTE = re.compile(rb"""(?:\A|\s)(r|s|min|max|style)\s*=\s*["']([^"']*)["']""")


@dataclass(frozen=True, slots=True)
class Look:
    """Format of a cell, as far as people set it here.

    Attributes:
        fill: `RRGGBB`; empty for none.
        wrap: a long text is broken into lines; False only where the file says so.
    """

    bold: bool = False
    fill: str = ""
    wrap: bool = True


PLAIN_LOOK = Look()


@dataclass(frozen=True, slots=True)
class SheetLooks:
    """Looks in a sheet: of columns where nothing else is said, and of cells (row, column) that look otherwise."""

    columns: dict[int, Look] = field(default_factory=dict)
    cells: dict[tuple[int, int], Look] = field(default_factory=dict)


def shade(fill: str) -> str:
    """Return which of the colours a fill is like; empty for none.

    >>> shade("FFFF00"), shade("DDEBF7"), shade("FFFFFF"), shade("808080")
    ('yellow', 'blue', '', 'grey')
    """
    if not fill:
        return ""
    red, green, blue = (int(fill[i : i + 2], 16) / 255 for i in (0, 2, 4))
    hue, light, saturation = colorsys.rgb_to_hls(red, green, blue)
    if light >= _WHITE and fill not in FILLS.values():
        return ""
    if saturation < _PALE:
        return "grey"
    return next(name for most, name in _HUES if hue * 360 <= most)


class _LookHandler(Handler):
    """Reads fonts, fills and cell styles, as far as they make a look."""

    def __init__(self) -> None:
        super().__init__()
        self.theme: list[str] = []
        self.bold: list[bool] = []
        self.fills: list[str] = []
        self.styles: list[tuple[int, int, bool]] = []
        self._inside, self._solid = "", False

    def start(self, name: str, attributes: Any) -> None:
        if name in ("fonts", "fills", "cellXfs", "dxfs", "cellStyleXfs", "borders"):
            self._inside = name
        elif self._inside == "fonts" and name == "font":
            self.bold.append(False)
        elif self._inside == "fonts" and name == "b" and self.bold:
            self.bold[-1] = truth(attributes.get("val", "1"))
        elif self._inside == "fills" and name == "fill":
            self.fills.append("")
        elif self._inside == "fills" and name == "patternFill":
            self._solid = attributes.get("patternType", "none") not in ("none", "gray125")
        elif self._inside == "fills" and name == "fgColor" and self.fills and self._solid:
            self.fills[-1] = self._colour(attributes)
        elif self._inside == "cellXfs" and name == "xf":
            self.styles.append((number(attributes.get("fontId")), number(attributes.get("fillId")), True))
        elif self._inside == "cellXfs" and name == "alignment" and self.styles:
            self.styles[-1] = (*self.styles[-1][:2], truth(attributes.get("wrapText", "1")))

    def end(self, name: str) -> None:
        if name == self._inside:
            self._inside = ""

    def looks(self) -> list[Look]:
        """The looks of the cell styles."""
        return [
            Look(font < len(self.bold) and self.bold[font], self.fills[fill] if fill < len(self.fills) else "", wrap)
            for font, fill, wrap in self.styles
        ]

    def _colour(self, attributes: Any) -> str:
        from openpyxl.styles.colors import COLOR_INDEX

        rgb, tint = attributes.get("rgb", ""), attributes.get("tint", "")
        at = number(attributes.get("indexed"), len(COLOR_INDEX))
        themed = number(attributes.get("theme"), len(self.theme))
        if not rgb and at < len(COLOR_INDEX):
            rgb = COLOR_INDEX[at]
        elif not rgb and themed < len(self.theme):
            rgb = self.theme[themed]
        rgb = rgb[-6:].upper()
        if not re.fullmatch("[0-9A-F]{6}", rgb):
            return ""
        try:
            by = max(-1.0, min(float(tint or 0), 1.0))
        except ValueError:
            by = 0.0
        return _tinted(rgb, by) if by else rgb


def _tinted(rgb: str, by: float) -> str:
    """A colour made lighter, or darker, as the theme's colours are."""
    hue, light, saturation = colorsys.rgb_to_hls(*(int(rgb[i : i + 2], 16) / 255 for i in (0, 2, 4)))
    light = light * (1 + by) if by < 0 else light + (1 - light) * by
    return "".join(f"{round(part * 255):02X}" for part in colorsys.hls_to_rgb(hue, light, saturation))


class _ThemeHandler(Handler):
    """Collects the colours of a theme; cells count the dark and the light ones the other way round."""

    def __init__(self) -> None:
        super().__init__()
        self._found: list[str] = []
        self._inside = False

    def start(self, name: str, attributes: Any) -> None:
        if name == "clrScheme":
            self._inside = True
        elif self._inside and name in ("srgbClr", "sysClr"):
            self._found.append(attributes.get("lastClr" if name == "sysClr" else "val", ""))

    def end(self, name: str) -> None:
        if name == "clrScheme":
            self._inside = False

    @property
    def colours(self) -> list[str]:
        """Light 1, dark 1, light 2, dark 2, and the accents."""
        f = self._found
        return [f[1], f[0], f[3], f[2], *f[4:]] if len(f) >= 4 else f


def style_looks(book: XlsxBook) -> list[Look]:
    """Return the look of each cell style; none where the styles cannot be read."""
    handler, theme = _LookHandler(), _ThemeHandler()
    try:
        if "theme" in book.by_kind:
            book.parse(book.by_kind["theme"], theme)
        handler.theme = theme.colours
        if "styles" in book.by_kind:
            book.parse(book.by_kind["styles"], handler)
    except UnreadableFile:
        return []
    return handler.looks()


def read_looks(book: XlsxBook, index: int, styles: list[Look]) -> SheetLooks:
    """Read how the cells of a sheet look; `styles` are the `style_looks` of its book."""
    if all(look == PLAIN_LOOK for look in styles):
        return SheetLooks()
    data = book.read(book.entries[index].part)

    def look(text: bytes | None) -> Look:
        at = number(text.decode("ascii", "replace") if text else "", 0)
        return styles[at] if at < len(styles) else PLAIN_LOOK

    columns: dict[int, Look] = {}
    for match in _COLUMN.finditer(data, 0, max(data.find(b"sheetData"), 0)):
        about = dict(_ATTRIBUTE.findall(match[1]))
        first, last = (number(about.get(n, b"").decode("ascii", "replace"), 0) for n in (b"min", b"max"))
        if (mine := look(about.get(b"style"))) != PLAIN_LOOK:
            columns |= dict.fromkeys(range(max(first, 1), min(last, limits.COLUMNS) + 1), mine)
    wanted = b"|".join(str(i).encode() for i, one in enumerate(styles) if one != PLAIN_LOOK)
    styled = re.compile(rb"""\ss\s*=\s*["'](?:%s)["']""" % wanted)
    cells: dict[tuple[int, int], Look] = {}
    for row in _ROW.split(data):
        if not (columns or styled.search(row)):
            continue
        for match in _CELL.finditer(row):
            about = dict(_ATTRIBUTE.findall(match[1]))
            at = place(about.get(b"r", b"").decode("ascii", "replace"))
            if at and (mine := look(about.get(b"s"))) != columns.get(at[1], PLAIN_LOOK) and at[1] <= limits.COLUMNS:
                cells[at] = mine
        if len(cells) > limits.CELLS:
            break
    return SheetLooks(columns, cells)
