"""Names of sheets in formulas (of cells, rules, names, charts, shapes and buttons) and in the list of titles."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator, Sequence

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.xml_part import add, local, set_text, text_of

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
    """Change every formula of a part; the old texts by the new ones."""
    spelt = part.casefold()
    if "/drawings/" in spelt or "/ctrlprops/" in spelt:
        return _rewrite_links(package, part, package.read(part), change)
    if not _HAS_FORMULA.search(package.read(part)):
        return {}
    old: dict[str, str] = {}
    for holder, e in package.part(part).find(*_FORMULAS, "hyperlink"):
        if local(e) == "hyperlink":
            location = e.get("location", "")
            if location and (new := change(location)) != location and not new.startswith(GONE):
                e.set("location", new)
                holder.touch()
            continue
        text = text_of(e)
        if "!" not in text or (new := change(text)) == text:
            continue
        written = GONE if "/charts/" in spelt and GONE in new else new
        old.setdefault(written, text)
        set_text(e, written)
        holder.touch()
    return old


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
    if "/drawings/" in part.casefold() or "/ctrlprops/" in part.casefold():
        data = package.read(part)
        for new, was in old.items():
            data = data.replace(f'"{new}"'.encode(), f'"{was}"'.encode()).replace(
                f">{new}<".encode(), f">{was}<".encode()
            )
        package.write(part, data)
        return
    for holder, e in package.part(part).find(*_FORMULAS):
        if (before := old.get(text_of(e))) is not None:
            set_text(e, before)
            holder.touch()


def formula_parts(package: PackageEdit) -> Iterator[str]:
    """The parts that may hold formulas, but the list of sheets itself."""
    for part in package.package.parts:
        folders = ("/worksheets/", "/charts/", "/drawings/", "/ctrlprops/", "/tables/")
        if any(f in f"/{part}" for f in folders) and "/_rels/" not in part and part.endswith((".xml", ".vml")):
            yield part


_TITLES = ("Properties", "TitlesOfParts", "vector")
_PAIRS = ("Properties", "HeadingPairs", "vector")


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
    name = titles_part(package)
    part = package.part(name) if name else None
    box = part.box(*_TITLES) if part else None
    titles = list(box.iterchildren("*")) if box is not None else []
    texts = [text_of(e) for e in titles]
    before = package.book.names
    if not part or box is None or not titles or texts[: len(before)] != before:
        return
    counts = [e for pair in part.children(*_PAIRS) for e in pair.iterchildren("{*}i4")]
    rest = [new for text in texts[len(before) :] if (new := named(text))]
    rest += added if len(counts) > 1 else ()
    more = len(rest) - (len(texts) - len(before))
    box.set("size", str(len(sheets) + len(rest)))
    at, like = box.index(titles[0]), local(titles[0])
    for e in titles:
        box.remove(e)
    for i, text in enumerate((*sheets, *rest)):
        add(box, like, {}, text, at + i)
    for count, by in ((counts[:1], len(sheets) - len(before)), (counts[1:][-1:], more)):
        for e in count if by else ():
            set_text(e, str(int(text_of(e)) + by))
    part.touch()
