"""New cell styles in the style part of a copy: what is there keeps its number, new ones are added at the end."""

from __future__ import annotations

from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, splice, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.xlsx_parts import number

_LISTS = ("fonts", "fills", "borders", "cellXfs")


class StyleSheet:
    """The style part of a package; call `store` when all styles are made.

    Args:
        package: a package that has one, as every workbook with a spreadsheet program behind it.
    """

    def __init__(self, package: PackageEdit) -> None:
        self._package = package
        self._parts = package.related(package.book.part, "styles")
        self._data = as_utf8(package.read(self._parts[0])) if self._parts else b""
        self._lists: dict[str, Element] = {}
        self._styles: list[bytes] = []
        self._new: dict[str, list[bytes]] = {name: [] for name in _LISTS}
        self._made: dict[tuple[int, str, bool], int] = {}
        if self._parts:
            found = find(self._data, lambda path: len(path) in (2, 3))
            self._lists = {e.local: e for e in found if len(e.path) == 2 and e.local in _LISTS}
            self._styles = [self._data[e.start : e.end] for e in found if e.path[1:] == ("cellXfs", "xf")]
            self._counts = {name: sum(e.path[1:2] == (name,) and len(e.path) == 3 for e in found) for name in _LISTS}

    def marked(self, style: int, fill: str, edge: str) -> int:
        """A style like another one, with this fill and this border (`RRGGBB`); a conditional format may hide a fill."""
        return self._make(style, fill, edge, False)

    def note(self, fill: str, *, bold: bool = False) -> int:
        """The style of a text of ours: small and wrapped."""
        return self._make(-1, fill, "", bold)

    def _make(self, base: int, fill: str, edge: str, bold: bool) -> int:
        if any(name not in self._lists for name in _LISTS):
            return max(base, 0)  # a workbook without styles: told by its texts only
        made = self._made.get((base, fill, bold))
        if made is None:
            made = self._made[base, fill, bold] = self._add("cellXfs", self._style(base, fill, edge, bold))
        return made

    def _style(self, base: int, fill: str, edge: str, bold: bool) -> bytes:
        p = self._lists["cellXfs"].prefix
        named: dict[str, str | None] = {}
        if fill:
            solid = f'<{p}patternFill patternType="solid"><{p}fgColor rgb="FF{fill}"/><{p}bgColor indexed="64"/>'
            named |= {"fillId": str(self._add("fills", f"<{p}fill>{solid}</{p}patternFill></{p}fill>".encode()))}
            named |= {"applyFill": "1"}
        if edge:
            sides = "".join(
                f'<{p}{side} style="medium"><{p}color rgb="FF{edge}"/></{p}{side}>'
                for side in ("left", "right", "top", "bottom")
            )
            named |= {"borderId": str(self._add("borders", f"<{p}border>{sides}<{p}diagonal/></{p}border>".encode()))}
            named |= {"applyBorder": "1"}
        if base >= 0:
            old = self._styles[base] if base < len(self._styles) else f"<{p}xf/>".encode()
            tag = find(old, lambda path: len(path) == 1)[0]
            return with_attributes(old[: tag.inner], named) + old[tag.inner :]
        thick = f"<{p}b/>" if bold else ""
        font = f'<{p}font>{thick}<{p}sz val="9"/><{p}color rgb="FF1F2D3A"/><{p}name val="Arial"/></{p}font>'
        named |= {"fontId": str(self._add("fonts", font.encode())), "applyFont": "1"}
        start = f'<{p}xf numFmtId="49" fontId="0" fillId="0" borderId="0" xfId="0" applyAlignment="1">'.encode()
        return with_attributes(start, named) + f'<{p}alignment vertical="center" wrapText="1"/></{p}xf>'.encode()

    def _add(self, name: str, element: bytes) -> int:
        new = self._new[name]
        if element not in new:
            new.append(element)
        return self._counts[name] + new.index(element)

    def store(self) -> None:
        """Write the part, if there are new styles."""
        changes = []
        for name, new in self._new.items():
            if new:
                e = self._lists[name]
                count = max(number(e.attributes.get("count")), self._counts[name]) + len(new)
                tag = with_attributes(self._data[e.start : e.inner], {"count": str(count)})
                changes += [(e.start, e.inner, tag), (e.inner_end, e.inner_end, b"".join(new))]
        if changes:
            self._package.write(self._parts[0], splice(self._data, changes))
