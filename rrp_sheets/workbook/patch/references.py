"""References to rows and sheets in formulas: found, rewritten or refused when they move, grown with a sheet's table."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook.edits import InsertRows, MoveRows, RowEdit
from rrp_sheets.workbook.patch import package_edit as xml
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.schema import LIST_PREFIX
from rrp_sheets.workbook.xlsx import block_of, number

_CELL = r"(?<![\w.$])\$?[A-Z]{1,3}(?P<a>\$?)(?P<top>[1-9]\d{0,6})(?::\$?[A-Z]{1,3}(?P<b>\$?)(?P<bottom>[1-9]\d{0,6}))?"
_ROWS = r"(?<![\w.$:])(?P<c>\$?)(?P<from>[1-9]\d{0,6}):\$?(?P<to>[1-9]\d{0,6})"
_SHEET = r"(?:(?P<sheet>'(?:[^']|'')+'|[^\W\d][\w.]*(?::[^\W\d][\w.]*)?)!)?"
_TOKEN = re.compile(rf'"(?:[^"]|"")*"|\[[^\[\]]*\]|{_SHEET}(?:{_CELL}|{_ROWS})(?![\w.(!\[])', re.IGNORECASE)
Moves = Sequence[tuple[int, int | None]]
"""Filled rows that go elsewhere: from where, to where (None: away)."""
SPARE = 50
"""Blank rows below the last filled one that are covered too when something grows."""
_PIECE = re.compile(
    r""""(?:[^"]|"")*"|(?P<quoted>'(?:[^']|'')+')!|(?<![\w.\])#'])(?P<plain>[^\W\d][\w.]*(?::[^\W\d][\w.]*)?)!"""
)
_PLAIN = re.compile(r"(?!(?:[A-Z]{1,3}\d+|R\d*C\d*|TRUE|FALSE)\Z)[A-Z_]\w*\Z", re.IGNORECASE | re.ASCII)
_FORMULAS = ("f", "formula", "formula1", "formula2", "calculatedColumnFormula", "totalsRowFormula")
GONE = "#REF!"
Change = Callable[[str], str]
_TITLES = ("Properties", "TitlesOfParts", "vector")
_PAIRS = ("Properties", "HeadingPairs", "vector")


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference inside a formula; one to the formula's own sheet has an empty `sheet`.

    Its rows are fixed with `$` where it is `absolute`; their numbers stand in the formula at `spans`.
    """

    sheet: str
    top: int
    bottom: int
    absolute: bool
    spans: tuple[tuple[int, int], tuple[int, int]]

    def on(self, sheet: str, own: str) -> bool:
        """Return whether it refers to a sheet, from a formula in the sheet `own` (empty: from outside of sheets)."""
        if not self.sheet:
            return own.casefold() == sheet.casefold()
        return sheet.casefold() in self.sheet.casefold().split(":")


def references(formula: str) -> Iterator[Reference]:
    r"""The references of a formula; whole columns refer to no row.

    >>> [(r.sheet, r.top, r.bottom) for r in references('SUM(A2:$B$9, \'My data\'!C5) & "A1" + LOG10(2) + T[A1]')]
    [('', 2, 9), ('My data', 5, 5)]
    """
    for match in _TOKEN.finditer(formula):
        top, bottom, absolute = "top", "bottom", match["a"] == "$"
        if match["from"]:
            top, bottom, absolute = "from", "to", match["c"] == "$"
        elif not match["top"]:
            continue
        last = bottom if match[bottom] else top
        sheet = (match["sheet"] or "").strip("'").replace("''", "'")
        yield Reference(sheet, int(match[top]), int(match[last]), absolute, (match.span(top), match.span(last)))


class ReferenceConflict(Exception):
    """A reference would mean something else afterwards; `top` and `bottom` are its rows."""

    def __init__(self, top: int, bottom: int) -> None:
        super().__init__(f"{top}:{bottom}")
        self.top, self.bottom = top, bottom


def check(top: int, bottom: int, moves: Moves) -> None:
    """Raise ReferenceConflict when rows `top` to `bottom` would not hold the same contents afterwards.

    A range may lose deleted rows, and rows may change places within it; a single row must stay as it is.
    """
    for old, new in moves:
        if top == bottom:
            if top in (old, new):
                raise ReferenceConflict(top, bottom)
        elif new is not None and (top <= old <= bottom) != (top <= new <= bottom):
            raise ReferenceConflict(top, bottom)


def adapted(formula: str, sheet: str, edit: RowEdit, moves: Moves) -> str:
    """A formula of the edited sheet itself, with its references following their rows as in a spreadsheet program.

    Raises ReferenceConflict when they cannot.

    >>> from rrp_sheets.workbook.edits import InsertRows
    >>> adapted("A4+SUM(B2:B9)+Other!C4", "T", InsertRows("T", 3), [(4, 5)])
    'A5+SUM(B2:B10)+Other!C4'
    """

    def moved(ref: Reference) -> tuple[int, int]:
        top, bottom = edit.mapped(ref.top), edit.mapped(ref.bottom)
        if not ref.on(sheet, sheet):
            return ref.top, ref.bottom
        if top is None or bottom is None or (isinstance(edit, MoveRows) and ref.top != ref.bottom):
            check(ref.top, ref.bottom, moves)
            return ref.top, ref.bottom
        return top, bottom

    return _with_rows(formula, moved)


def _with_rows(formula: str, rows: Callable[[Reference], tuple[int, int]]) -> str:
    """The formula with other rows: those that `rows` gives for each of its references."""
    out, at = list[str](), 0
    for ref in references(formula):
        for (start, end), row in dict(zip(ref.spans, rows(ref), strict=True)).items():
            if int(formula[start:end]) != row:  # what stays is kept to the letter
                out += (formula[at:start], str(row))
                at = end
    return "".join([*out, formula[at:]])


def grow(package: PackageEdit, index: int) -> None:
    """Let everything that covered a sheet's table before cover it again, where it has become longer."""
    before, now = package.ends[index], package.sheet(index).last_filled
    package.ends[index] = now
    if now <= before or not package.recognised(index).kind:
        return
    top = package.recognised(index).row + 1

    def longer(first: int, bottom: int) -> int:
        return now + SPARE if first == top and first < bottom and before <= bottom < now else bottom

    _grow_rules(package, index, longer)
    for book, e in package.workbook.find("definedName"):  # the lists behind the drop-downs
        if e.get("name", "").startswith(LIST_PREFIX):
            xml.change_text(book, e, _referring(xml.text_of(e), package.book.names[index], "", longer))


def follows(package: PackageEdit, index: int, ref: Reference, edit: RowEdit) -> bool:
    """Return whether a reference covers the whole table of a sheet, so that it grows when rows are inserted."""
    known = package.recognised(index)
    whole = known.kind and ref.top == known.row + 1 and ref.top < ref.bottom
    return isinstance(edit, InsertRows) and bool(whole) and ref.bottom >= package.sheet(index).last_filled


def _grow_rules(package: PackageEdit, index: int, longer: Callable[[int, int], int]) -> None:
    """Extend the ranges where the sheet's rules hold, and those that the rules of all sheets refer to."""
    name, sheet = package.book.names[index], package.sheet(index)
    for e in sheet.elements("conditionalFormatting", "dataValidation"):
        old = e.get("sqref", "")
        if old and (new := _grown(old, longer)) != old:
            e.set("sqref", new)
            sheet.touch()
    for e in sheet.elements("sqref"):  # of the rules that newer programs keep elsewhere
        xml.change_text(sheet, e, _grown(xml.text_of(e), longer))
    for i, own in enumerate(package.book.names):
        if i != index and not package.mentions(i, name):
            continue
        other = package.sheet(i)
        for e in other.rules():
            xml.change_text(other, e, _referring(xml.text_of(e), name, own, longer))


def _grown(blocks: str, longer: Callable[[int, int], int]) -> str:
    found = []
    for text in blocks.split():
        block = block_of(text)
        bottom = longer(block.top, block.bottom) if block else 0
        found.append(xml.block_text(replace(block, bottom=bottom)) if block and bottom != block.bottom else text)
    return " ".join(found)


def _referring(formula: str, sheet: str, own: str, longer: Callable[[int, int], int]) -> str:
    """A formula whose references to a whole table of the sheet reach its new end."""

    def grown(ref: Reference) -> tuple[int, int]:
        meant = ref.absolute and ref.on(sheet, own)
        return ref.top, longer(ref.top, ref.bottom) if meant else ref.bottom

    return _with_rows(formula, grown)


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

    Raises SheetsError when the sheet is the first or the last of several that the formula takes together.

    >>> without("Mine!A1+'Mine'!B2+Other!C3", "Mine")
    '#REF!A1+#REF!B2+Other!C3'
    """

    def change(match: re.Match[str]) -> str:
        names = _names(match)
        if sheet.casefold() not in (n.casefold() for n in names):
            return match[0]
        if len(names) > 1:
            message = N_("A formula takes the sheets {first} to {last} together, so “{sheet}” cannot go.",
                         first=names[0], last=" to ".join(names[1:]), sheet=sheet)  # fmt: skip
            raise SheetsError(message, N_("Delete it in Excel or LibreOffice, which change such formulas too."))
        return GONE

    return _PIECE.sub(change, formula)


def rewrite(package: PackageEdit, part: str, change: Change) -> dict[str, str]:
    """Change every formula of a part; the old texts by the new ones."""
    spelt = part.casefold()
    if "/drawings/" in spelt or "/ctrlprops/" in spelt:
        return _rewrite_links(package, part, package.read(part), change)
    if not xml.may_refer(package.read(part)):
        return {}
    old: dict[str, str] = {}
    for holder, e in package.part(part).find(*_FORMULAS, "hyperlink"):
        if xml.local(e) == "hyperlink":
            location = e.get("location", "")
            if location and (new := change(location)) != location and not new.startswith(GONE):
                e.set("location", new)
                holder.touch()
            continue
        text = xml.text_of(e)
        new = change(text) if "!" in text else text
        written = GONE if "/charts/" in spelt and GONE in new and new != text else new
        if xml.change_text(holder, e, written):
            old.setdefault(written, text)
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

    new = xml.LINKED.sub(put, data)
    if new != data:
        package.write(part, new)
    return old


def put_back(package: PackageEdit, part: str, old: dict[str, str]) -> None:
    """Take `rewrite` back where its texts still stand."""
    if "/drawings/" in part.casefold() or "/ctrlprops/" in part.casefold():
        data = package.read(part)
        for new, was in old.items():
            for begin, end in (('"', '"'), (">", "<")):
                data = data.replace(f"{begin}{new}{end}".encode(), f"{begin}{was}{end}".encode())
        package.write(part, data)
        return
    for holder, e in package.part(part).find(*_FORMULAS):
        xml.change_text(holder, e, old.get(xml.text_of(e), xml.text_of(e)))


def formula_parts(package: PackageEdit) -> Iterator[str]:
    """The parts that may hold formulas, but the list of sheets itself."""
    for part in package.book.parts:
        folders = ("/worksheets/", "/charts/", "/drawings/", "/ctrlprops/", "/tables/")
        if any(f in f"/{part}" for f in folders) and "/_rels/" not in part and part.endswith((".xml", ".vml")):
            yield part


def titles_part(package: PackageEdit) -> str:
    """The part with the list; empty where there is none."""
    related = package.book.relations("").values()
    return next((t for kind, t in related if kind == "extended-properties" and t in package.book), "")


def keep_titles(
    package: PackageEdit, sheets: Sequence[str], named: Callable[[str], str] = str, added: Sequence[str] = ()
) -> None:
    """Write the list anew, unless it does not begin with the sheets that the package's book names: those before.

    `sheets` are the worksheets from now on, `added` the titles of new names; `named` gives what the title of a name
    (`Mine!Print_Area`) is from now on, empty when it is gone.
    """
    name = titles_part(package)
    part = package.part(name) if name else None
    container = part.container(*_TITLES) if part else None
    titles = list(container.iterchildren("*")) if container is not None else []
    texts = [xml.text_of(e) for e in titles]
    before = package.book.names
    counts = [e for pair in part.children(*_PAIRS) for e in pair.iterchildren("{*}i4")] if part else []
    unknown = any(number(xml.text_of(e), -1) < 0 for e in counts)
    if not part or container is None or not titles or texts[: len(before)] != before or unknown:
        return
    rest = [new for text in texts[len(before) :] if (new := named(text))]
    rest += added if len(counts) > 1 else ()
    more = len(rest) - (len(texts) - len(before))
    container.set("size", str(len(sheets) + len(rest)))
    at, like = container.index(titles[0]), xml.local(titles[0])
    for e in titles:
        container.remove(e)
    for i, text in enumerate((*sheets, *rest)):
        xml.add(container, like, {}, text, at + i)
    for count, by in ((counts[:1], len(sheets) - len(before)), (counts[1:][-1:], more)):
        for e in count if by else ():
            xml.set_text(e, str(number(xml.text_of(e)) + by))
    part.touch()
