"""Names of sheets in formulas (of cells, rules and names, in charts, shapes and buttons) and in the list of titles."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator, Sequence

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.patch.markup import Element, as_utf8, find, inner_text, splice, text_xml, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.xml_lists import children

_PIECE = re.compile(
    r""""(?:[^"]|"")*"|(?P<quoted>'(?:[^']|'')+')!|(?<![\w.\])#'])(?P<plain>[^\W\d][\w.]*(?::[^\W\d][\w.]*)?)!"""
)
_PLAIN = re.compile(r"(?!(?:[A-Z]{1,3}\d+|R\d*C\d*|TRUE|FALSE)\Z)[A-Z_]\w*\Z", re.IGNORECASE | re.ASCII)
_FORMULAS = ("f", "formula", "formula1", "formula2", "calculatedColumnFormula", "totalsRowFormula")
_HAS_FORMULA = re.compile(rb"<(?:\w+:)?(?:f|formula[12]?|calculatedColumnFormula|totalsRowFormula)[\s>/]|<hyperlink\b")
_LINKED = re.compile(
    rb"""(\b(?:textlink|fmlaLink|fmlaRange|fmlaTxbx)\s*=\s*")([^"]*)(")|(<x:Fmla\w*>)([^<]*)(</x:Fmla\w*>)"""
)
GONE = "#REF!"
Change = Callable[[str], str]


def quoted(name: str) -> str:
    """A sheet's name as a formula writes it.

    >>> quoted("Mine"), quoted("My data"), quoted("A1"), quoted("Anna's")
    ('Mine', "'My data'", "'A1'", "'Anna''s'")
    """
    return name if _PLAIN.match(name) else "'" + name.replace("'", "''") + "'"


def sheets_named(formula: str) -> set[str]:
    r"""The sheets that a formula refers to, case-folded.

    >>> sorted(sheets_named("Mine!A1+'My data'!B2&\"No!\"+SUM(First:Last!A1)"))
    ['first', 'last', 'mine', 'my data']
    """
    return {name.casefold() for match in _PIECE.finditer(formula) for name in _names(match)}


def _names(match: re.Match[str]) -> list[str]:
    text = match["plain"] or (match["quoted"] or "")[1:-1].replace("''", "'")
    return text.split(":") if text else []


def renamed(formula: str, old: str, new: str) -> str:
    r"""A formula in which a sheet has another name; quotes that were not needed stay.

    >>> renamed("SUM(Mine!A1:A3)&'mine'!B2&\"Mine!\"", "Mine", "My data")
    'SUM(\'My data\'!A1:A3)&\'My data\'!B2&"Mine!"'
    """

    def change(match: re.Match[str]) -> str:
        names = _names(match)
        if old.casefold() not in (n.casefold() for n in names):
            return match[0]
        bare = match["plain"] or not all(_PLAIN.match(n) for n in names)
        names = [new if n.casefold() == old.casefold() else n for n in names]
        if bare and all(_PLAIN.match(n) for n in names):
            return f"{':'.join(names)}!"
        inside = ":".join(names).replace("'", "''")
        return f"'{inside}'!"

    return _PIECE.sub(change, formula)


def without(formula: str, sheet: str) -> str:
    """A formula after a sheet was deleted, as spreadsheet programs write it.

    Raises:
        SheetsError: when the sheet is the first or the last of several that the formula takes together.

    >>> without("Mine!A1+'Mine'!B2+Other!C3", "Mine")
    '#REF!A1+#REF!B2+Other!C3'
    """

    def change(match: re.Match[str]) -> str:
        names = [n.casefold() for n in _names(match)]
        if sheet.casefold() not in names:
            return match[0]
        if len(names) > 1:
            raise SheetsError(
                f"A formula takes the sheets {' to '.join(_names(match))} together, so “{sheet}” cannot go.",
                "Delete it in Excel or LibreOffice, which change such formulas too.",
            )
        return GONE

    return _PIECE.sub(change, formula)


def rewrite(package: PackageEdit, part: str, change: Change) -> dict[str, str]:
    """Change every formula of a part; the old texts by the new ones, both as they stand in the XML."""
    spelt = part.casefold()
    raw = package.read(part)
    if "/drawings/" in spelt or "/ctrlprops/" in spelt:
        return _rewrite_links(package, part, raw, change)
    if not _HAS_FORMULA.search(raw):
        return {}
    data = as_utf8(raw)
    changes: list[tuple[int, int, bytes]] = []
    old: dict[str, str] = {}
    charts = "/charts/" in spelt
    for e in _elements(data):
        if e.local == "hyperlink":
            location = e.attributes.get("location", "")
            if location and (new := change(location)) != location and not new.startswith(GONE):
                changes.append((e.start, e.inner, with_attributes(data[e.start : e.inner], {"location": new})))
            continue
        text = inner_text(data, e) if e.inner < e.inner_end else ""
        if not text or "!" not in text or (new := change(text)) == text:
            continue
        written = text_xml(GONE if charts and GONE in new else new)
        old.setdefault(written.decode(), data[e.inner : e.inner_end].decode())
        changes.append((e.inner, e.inner_end, written))
    if changes:
        package.write(part, splice(data, changes))
    return old


def _elements(data: bytes) -> list[Element]:
    return find(data, lambda path: path[-1] in _FORMULAS or path[-1] == "hyperlink")


def _rewrite_links(package: PackageEdit, part: str, data: bytes, change: Change) -> dict[str, str]:
    old: dict[str, str] = {}

    def put(match: re.Match[bytes]) -> bytes:
        begin, text, end = (match[1], match[2], match[3]) if match[1] else (match[4], match[5], match[6])
        told = html.unescape(text.decode("utf-8", "replace"))
        new = change(told)
        if new == told:
            return match[0]
        written = html.escape(new).encode()
        old.setdefault(written.decode(), text.decode("utf-8", "replace"))
        return bytes(begin + written + end)

    new = _LINKED.sub(put, data)
    if new != data:
        package.write(part, new)
    return old


def put_back(package: PackageEdit, part: str, old: dict[str, str]) -> None:
    """Take `rewrite` back where its texts still stand."""
    data = as_utf8(package.read(part))
    if "/drawings/" in part.casefold() or "/ctrlprops/" in part.casefold():
        for new, was in old.items():
            data = data.replace(f'"{new}"'.encode(), f'"{was}"'.encode()).replace(
                f">{new}<".encode(), f">{was}<".encode()
            )
        package.write(part, data)
        return
    changes = [
        (e.inner, e.inner_end, before.encode())
        for e in _elements(data)
        if (before := old.get(data[e.inner : e.inner_end].decode())) is not None and e.inner < e.inner_end
    ]
    if changes:
        package.write(part, splice(data, changes))


def formula_parts(package: PackageEdit) -> Iterator[str]:
    """The parts that may hold formulas, but the list of sheets itself."""
    for part in package.package.parts:
        folders = ("/worksheets/", "/charts/", "/drawings/", "/ctrlprops/", "/tables/")
        if any(f in f"/{part}" for f in folders) and "/_rels/" not in part and part.endswith((".xml", ".vml")):
            yield part


_TITLES = ("Properties", "TitlesOfParts", "vector")
_COUNTS = ("Properties", "HeadingPairs", "vector", "variant", "i4")


def titles_part(package: PackageEdit) -> str:
    """The part with the list; empty where there is none."""
    related = package.package.relations("").values()
    return next((t for kind, t in related if kind == "extended-properties" and t in package.package), "")


def keep_titles(
    package: PackageEdit, sheets: Sequence[str], named: Callable[[str], str] = str, added: Sequence[str] = ()
) -> None:
    """Write the list anew.

    Args:
        package: its book still tells the sheets there were; a list that names others is left alone.
        sheets: the names of the worksheets from now on.
        named: what the title of a name (`Mine!Print_Area`) is from now on; empty when it is gone.
        added: the titles of new names.
    """
    part = titles_part(package)
    data = as_utf8(package.read(part)) if part else b""
    titles = children(data, _TITLES) if data else []
    texts = [inner_text(data, e) if e.inner < e.inner_end else "" for e in titles]
    before = package.book.names
    if not titles or texts[: len(before)] != before:
        return
    counts = find(data, lambda at: tuple(at) == _COUNTS)
    rest = [new for text in texts[len(before) :] if (new := named(text))]
    rest += added if len(counts) > 1 else ()
    more = len(rest) - (len(texts) - len(before))
    name = titles[0].name
    written = b"".join(f"<{name}>".encode() + text_xml(t) + f"</{name}>".encode() for t in (*sheets, *rest))
    (box,) = find(data, lambda at: tuple(at) == _TITLES)
    size = {"size": str(len(sheets) + len(rest))}
    changes = [
        (box.start, box.inner, with_attributes(data[box.start : box.inner], size)),
        (titles[0].start, titles[-1].end, written),
    ]
    for e, by in ((counts[:1], len(sheets) - len(before)), (counts[1:][-1:], more)):
        changes += [(c.inner, c.inner_end, str(int(inner_text(data, c)) + by).encode()) for c in e if by]
    package.write(part, splice(data, changes))
