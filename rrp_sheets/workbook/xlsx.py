"""Reading an .xlsx file: the zip and its XML parts, checked before any is parsed; the list of sheets; their cells.

Of a sheet only the cells that exist are read, in one pass that counts while it reads.
"""

from __future__ import annotations

import io
import math
import posixpath
import re
import zipfile
import zlib
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import IO, Any
from xml.sax import SAXException
from xml.sax.handler import ContentHandler

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import Extent, Kind, Range, RawCell, RawSheet, number_text, unreadable

_FIRST_PIECE, _LARGEST_PIECE = 1 << 14, 1 << 22
DECLARED = re.compile(rb"""\A\s*<\?xml[^>]*encoding\s*=\s*["']([^"'>]*)["']""")
_ENCODINGS = {"utf-8", "utf8", "utf-16", "us-ascii", "ascii", "iso-8859-1"}
_TRUE = {"1", "true", "on"}
_TEXT_FORMAT = 49
_REFERENCE = re.compile(r"\$?([A-Z]{1,3})\$?([0-9]{1,7})")
LAST_ROW, LAST_COLUMN = 1_048_576, 16_384


def number(text: str | None, default: int = 0) -> int:
    """A whole number of an attribute; the default where it is none, so that broken files stay readable."""
    return int(text) if text and text.isascii() and text.isdigit() and len(text) < 10 else default


def truth(text: str | None) -> bool:
    """A yes/no attribute."""
    return (text or "").casefold() in _TRUE


@lru_cache(maxsize=8_192)
def place(reference: str) -> tuple[int, int] | None:
    """Row and column of a reference such as `B7`, or None.

    >>> place("B7"), place("XFE1")
    ((7, 2), None)
    """
    match = _REFERENCE.fullmatch(reference)
    if not match:
        return None
    column = 0
    for letter in match[1]:
        column = column * 26 + ord(letter) - 64
    row = int(match[2])
    return (row, column) if 1 <= row <= LAST_ROW and column <= LAST_COLUMN else None


@lru_cache(maxsize=1_024)
def _column(letters: str) -> int:
    """Return the number of a column, 0 for what are no letters of one: quicker than `place`, as rows share them."""
    found = place(f"{letters}1") if letters.isalpha() else None
    return found[1] if found else 0


def block_of(reference: str) -> Range | None:
    """The block that a reference such as `B2:C9` names.

    >>> block_of("C9:B2")
    Range(top=2, left=2, bottom=9, right=3)
    """
    first, _, last = reference.partition(":")
    a, b = place(first), place(last or first)
    if a is None or b is None:
        return None
    return Range(min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1]))


def rels_of(part: str) -> str:
    """Return the name of the part with the relations of a part, whether or not it exists."""
    folder, leaf = posixpath.split(part)
    return posixpath.join(folder, "_rels", f"{leaf}.rels")


def translated(formula: str, origin: str, at: str) -> str:
    """The formula of the cell `origin` as a spreadsheet program shows it in the cell `at`, both without `=`."""
    from openpyxl.formula.tokenizer import TokenizerError
    from openpyxl.formula.translate import Translator, TranslatorError

    try:
        return str(Translator("=" + formula, origin).translate_formula(at))[1:]
    except (TokenizerError, TranslatorError):
        return formula


class Stop(Exception):
    """Raised by a handler that has seen enough."""


class Budget:
    """Number of elements that may still be read from one file, over all its parts."""

    left = limits.XML_ELEMENTS


class Handler(ContentHandler):
    """A SAX handler whose element names come without namespace prefix.

    Subclasses define `start` and `end`; characters are collected while `wanted` is true.
    """

    def __init__(self) -> None:
        super().__init__()
        self.wanted = False
        self._text: list[str] = []
        self._depth = 0

    def start(self, name: str, attributes: Any) -> None:
        """An element begins."""

    def end(self, name: str) -> None:
        """An element ends."""

    def thin(self, piece: bytes) -> bytes:
        """A piece of the part without what need not be parsed; called before each piece is."""
        return piece

    def take_text(self) -> str:
        """The characters since the last call."""
        text = "".join(self._text)
        self._text.clear()
        return text

    def guard(self, budget: Budget, refuse: UnreadableFile) -> None:
        """Count elements and depth from now on; `refuse` is raised when there are too many."""
        self._budget, self._refuse = budget, refuse

    # The names below are those of xml.sax.
    def startElement(self, name: str, attrs: Any) -> None:  # noqa: N802, D102
        self._depth += 1
        self._budget.left -= 1
        if self._depth > limits.XML_DEPTH or self._budget.left < 0:
            raise self._refuse
        self.start(name.rpartition(":")[2] if ":" in name else name, attrs)

    def endElement(self, name: str) -> None:  # noqa: N802, D102
        self._depth -= 1
        self.end(name.rpartition(":")[2] if ":" in name else name)

    def characters(self, content: str) -> None:  # noqa: D102
        if self.wanted:
            self._text.append(content)


class XmlReader:
    """Feeds a part of a package to a handler, piece by piece, so that one may stop early and go on later."""

    def __init__(self, package: XlsxBook, part: str, handler: Handler) -> None:
        from defusedxml.expatreader import DefusedExpatParser

        self._stream, self._handler, self._name, self._part = package.open(part), handler, package.name, part
        self._swollen = unreadable("FILE007", name=package.name, what=N_("{part} is too long or too deep", part=part))
        self._parser = DefusedExpatParser(forbid_dtd=True)
        handler.guard(package.budget, self._swollen)
        self._parser.setContentHandler(handler)
        # Straight to the handler: what SAX makes of every element's attributes takes longer than to read them.
        self._parser.start_element, self._parser.end_element = handler.startElement, handler.endElement
        self._parser.character_data = handler.characters
        self._piece, self._token = _FIRST_PIECE, 0
        self.finished = False

    def step(self) -> bool:
        """Read one piece; False when the part is at its end. Raises UnreadableFile for broken or unsafe XML."""
        from defusedxml import DefusedXmlException

        if self.finished:
            return False
        try:
            piece = self._stream.read(self._piece)
            if piece:
                self._check(piece)
                self._parser.feed(self._handler.thin(piece))
            else:
                self._parser.close()
                self.finished = True
        except Stop:
            self.finished = True
        except DefusedXmlException as error:
            what = N_("{part} declares its own document type", part=self._part)
            raise unreadable("FILE009", name=self._name, what=what) from error
        except (SAXException, zipfile.BadZipFile, zlib.error, EOFError, OSError) as error:
            raise unreadable("FILE008", name=self._name, what=N_("{part} cannot be read", part=self._part)) from error
        # Larger and larger pieces: old versions of expat begin a long text anew with every piece.
        self._piece = min(self._piece * 2, _LARGEST_PIECE)
        return not self.finished

    def _check(self, piece: bytes) -> None:
        """Refuse long tokens before they are parsed. `<` cannot stand in a text or a tag, so it bounds both."""
        if self._piece == _FIRST_PIECE:
            declared = DECLARED.search(piece)
            if declared and declared[1].decode("ascii", "replace").casefold() not in _ENCODINGS:
                raise unreadable("FILE009", name=self._name, what=N_("{part} has an unusual encoding", part=self._part))
        runs = piece.split(b"<")
        if self._token + len(runs[0]) > limits.XML_TOKEN_BYTES or max(map(len, runs)) > limits.XML_TOKEN_BYTES:
            raise self._swollen
        self._token = len(runs[-1]) + (self._token if len(runs) == 1 else 0)


BROKEN_ZIP = (zipfile.BadZipFile, OSError, EOFError, ValueError, RuntimeError, NotImplementedError, zlib.error)
"""Exceptions of the zip library for a file that is damaged, cut off, protected, or compressed in an unusual way."""
_OLE = bytes.fromhex("d0cf11e0a1b11ae1")
_MB = 1_000_000
_ENCRYPTED_NAME = "EncryptedPackage".encode("utf-16-le")
_DOCTYPE = re.compile(rb"<!(?:DOCTYPE|ENTITY)", re.IGNORECASE)
_PROLOGUE = 1 << 16

# Parts and relations that make a file refused, each with the code and the words that tell it.
_PARTS = (
    (re.compile(r"vbaproject|/macrosheets/|/dialogsheets/"), "FILE004", ""),
    (re.compile(r"/externallinks/"), "FILE010", N_("another workbook")),
    (re.compile(r"/connections\.xml$|/querytables/|/webextensions/"), "FILE010", N_("a data connection")),
    (re.compile(r"/embeddings/|/oleobjects?/"), "FILE011", N_("a document")),
    (re.compile(r"/activex/"), "FILE011", N_("an ActiveX control")),
)
_RELATIONS = {
    **dict.fromkeys(("vbaproject", "xlmacrosheet"), ("FILE004", "")),
    **dict.fromkeys(("externallink", "externallinkpath"), ("FILE010", N_("another workbook"))),
    "connections": ("FILE010", N_("a data connection")),
    **dict.fromkeys(("oleobject", "package"), ("FILE011", N_("a document"))),
    "control": ("FILE011", N_("an ActiveX control")),
}


class Relations(Handler):
    """The relations of a part: kind and target by id. Kinds are the last word of their type's address."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[str, tuple[str, str]] = {}
        self.outside: list[str] = []

    def start(self, name: str, attributes: Any) -> None:
        """Note a relation."""
        if name == "Relationship":
            kind = attributes.get("Type", "").rpartition("/")[2].casefold()
            if attributes.get("TargetMode", "").casefold() == "external":
                self.outside.append(kind)
            self.found[attributes.get("Id", "")] = (kind, attributes.get("Target", ""))


@dataclass(frozen=True, slots=True)
class SheetEntry:
    """A sheet as the workbook part lists it: its name, its part in the package, whether it is hidden."""

    name: str
    part: str
    hidden: bool


class WorkbookHandler(Handler):
    """Reads the list of sheets and the epoch of dates."""

    def __init__(self) -> None:
        super().__init__()
        self.sheets: list[tuple[str, str, bool]] = []
        self.mac_epoch = False

    def start(self, name: str, attributes: Any) -> None:
        """Note a sheet."""
        if name == "sheet":
            relation = next((v for n, v in attributes.items() if n.rpartition(":")[2] == "id"), "")
            hidden = attributes.get("state", "visible") != "visible"
            self.sheets.append((attributes.get("name", ""), relation, hidden))
        elif name == "workbookPr":
            self.mac_epoch = truth(attributes.get("date1904"))


class StylesHandler(Handler):
    """Finds the cell styles that show numbers as dates or times."""

    def __init__(self) -> None:
        super().__init__()
        self._formats: dict[int, str] = {}
        self._styles: list[int] = []
        self._kinds: dict[int, Kind | None] = {}
        self._inside = False

    def start(self, name: str, attributes: Any) -> None:
        """Note a number format, or the number format of a cell style."""
        if name == "numFmt":
            self._formats[number(attributes.get("numFmtId"))] = attributes.get("formatCode", "")
        elif name == "cellXfs":
            self._inside = True
        elif name == "xf" and self._inside:
            self._styles.append(number(attributes.get("numFmtId")))

    def end(self, name: str) -> None:
        """The list of cell styles ends."""
        if name == "cellXfs":
            self._inside = False

    def kind(self, style: int) -> Kind | None:
        """DATE or TIME for a style that shows one. Found out when asked for, because few cells are numbers."""
        format_id = self._styles[style] if style < len(self._styles) else 0
        if format_id not in self._kinds:
            self._kinds[format_id] = self._find_kind(format_id)
        return self._kinds[format_id]

    def is_text(self, style: int) -> bool:
        """Return whether a style takes everything that is typed for text (`@`)."""
        format_id = self._styles[style] if style < len(self._styles) else 0
        return format_id == _TEXT_FORMAT or self._formats.get(format_id, "") == "@"

    def _find_kind(self, format_id: int) -> Kind | None:
        if format_id == 0:
            return None
        from openpyxl.styles.numbers import BUILTIN_FORMATS, is_date_format, is_timedelta_format

        code = self._formats.get(format_id, BUILTIN_FORMATS.get(format_id, ""))
        if not code or len(code) > 255:
            return None
        bare = re.sub(r'"[^"]*"|\[[^\]]*\]|\\.|_.', "", code)  # without its literal texts and bracketed parts
        if is_timedelta_format(code) or (is_date_format(code) and not re.search("[dyDY]", bare)):
            return Kind.TIME
        return Kind.DATE if is_date_format(code) else None


class XlsxBook:
    """An opened .xlsx file, see Book: its checked zip; raises UnreadableFile for what is broken or suspicious.

    `part` is the workbook part; `by_kind` has the parts that it refers to, of several of one kind the last. With
    `mac_epoch` dates count from 1904.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name, self.format, self.budget = name, "xlsx", Budget()
        self.findings: list[Diagnostic] = []
        if not data:
            raise unreadable("FILE015", name=name)
        if data.startswith(_OLE):
            raise unreadable("FILE005" if _ENCRYPTED_NAME in data else "FILE003", name=name)
        if not data.startswith(b"PK"):
            raise unreadable("FILE002", name=name)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
        except BROKEN_ZIP as error:
            raise unreadable("FILE008", name=name, what=N_("it is incomplete")) from error
        entries = self._zip.infolist()
        self._check_entries(entries)
        self.parts = {e.filename.casefold(): e for e in entries if not e.is_dir()}
        self._check_parts()
        self._read_workbook()

    def _read_workbook(self) -> None:
        relations = self.relations("").values()
        self.part = next((target for kind, target in relations if kind == "officedocument"), "xl/workbook.xml")
        if self.part not in self or not self.part.endswith(".xml"):
            raise unreadable("FILE002", name=self.name)
        workbook, self.styles = WorkbookHandler(), StylesHandler()
        self.parse(self.part, workbook)
        self.mac_epoch = workbook.mac_epoch
        related = self.relations(self.part)
        self.by_kind = {kind: target for kind, target in related.values() if target in self}
        if "styles" in self.by_kind:
            self.parse(self.by_kind["styles"], self.styles)
        parts = {id: target for id, (kind, target) in related.items() if kind == "worksheet"}
        self.entries = [  # without charts on sheets of their own
            SheetEntry(title, parts[id], hidden) for title, id, hidden in workbook.sheets if id in parts
        ]
        self.names = [entry.name for entry in self.entries]
        if len(self.entries) > limits.SHEETS:
            raise unreadable("FILE012", name=self.name, count=len(self.entries), limit=limits.SHEETS)
        if not self.entries:
            raise unreadable("FILE008", name=self.name, what=N_("it lists no sheets"))

    def _check_entries(self, entries: list[zipfile.ZipInfo]) -> None:
        if len(entries) > limits.PARTS:
            raise self._swollen(N_("{n} parts", n=len(entries)))
        seen: set[str] = set()
        for e in entries:
            if e.flag_bits & 0x1:
                raise unreadable("FILE005", name=self.name)
            spelt = e.filename.casefold()
            if not spelt:  # zipfile cuts names at a NUL
                raise unreadable("FILE009", name=self.name, what=N_("a part has no name"))
            if spelt.startswith("/") or "\\" in spelt or ":" in spelt or ".." in spelt.split("/"):
                raise unreadable("FILE009", name=self.name, what=N_("a part has the name of a file outside"))
            if spelt in seen:
                raise unreadable("FILE009", name=self.name, what=N_("two parts have one name"))
            seen.add(spelt)
            if e.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise unreadable("FILE009", name=self.name, what=N_("an unusual compression"))
            if e.file_size > limits.PART_BYTES:
                raise self._swollen(N_("a part of {n} MB", n=e.file_size // _MB))
            if e.file_size > limits.RATIO_FROM_BYTES and e.file_size > limits.RATIO * max(e.compress_size, 1):
                ratio = e.file_size // max(e.compress_size, 1)
                raise self._swollen(N_("a part that is compressed to a {n}th", n=ratio))
        if sum(e.file_size for e in entries) > limits.INFLATED_BYTES:
            raise self._swollen(N_("{n} MB", n=sum(e.file_size for e in entries) // _MB))

    def _check_parts(self) -> None:
        if "[content_types].xml" not in self.parts or not any(p.startswith("xl/") for p in self.parts):
            raise unreadable("FILE002", name=self.name)
        for part, (pattern, code, what) in product(self.parts, _PARTS):
            if pattern.search("/" + part):
                raise unreadable(code, name=self.name, what=what)
        for part in self.parts:
            if not part.endswith((".xml", ".rels", ".vml")):
                continue
            beginning = self.read(part, _PROLOGUE)  # a document type stands before the first element
            if _DOCTYPE.search(beginning.replace(b"\0", b"")):
                raise unreadable("FILE009", name=self.name, what=N_("{part} declares its own document type", part=part))
        if b"macroenabled" in self.read("[content_types].xml").lower():
            raise unreadable("FILE004", name=self.name)
        for part in self.parts:
            if part.endswith(".rels"):
                relations = Relations()
                self.parse(part, relations)
                if refused := [_RELATIONS[kind] for kind, _ in relations.found.values() if kind in _RELATIONS]:
                    code, what = refused[0]
                    raise unreadable(code, name=self.name, what=what)
                if outside := set(relations.outside) - {"hyperlink"}:
                    raise unreadable("FILE010", name=self.name, what=min(outside))

    def _swollen(self, what: str) -> Exception:
        return unreadable("FILE007", name=self.name, what=what)

    def __contains__(self, part: str) -> bool:
        return part.casefold() in self.parts

    def open(self, part: str) -> IO[bytes]:
        """A stream of a part's bytes."""
        try:
            return self._zip.open(self.parts[part.casefold()])
        except KeyError:
            raise unreadable("FILE008", name=self.name, what=N_("{part} is missing", part=part)) from None
        except BROKEN_ZIP as error:
            raise unreadable("FILE008", name=self.name, what=N_("{part} cannot be read", part=part)) from error

    def read(self, part: str, most: int = -1) -> bytes:
        """The bytes of a part, all or the first ones."""
        with self.open(part) as stream:
            try:
                return stream.read(most)
            except BROKEN_ZIP as error:
                raise unreadable("FILE008", name=self.name, what=N_("{part} cannot be read", part=part)) from error

    def parse(self, part: str, handler: Handler) -> None:
        """Feed a part to a handler until it has seen enough."""
        reader = XmlReader(self, part, handler)
        while reader.step():
            pass

    @cached_property
    def strings(self) -> SharedStrings:
        """The shared texts of its cells."""
        return SharedStrings(self)

    def sheet(self, index: int, extent: Extent) -> RawSheet:
        """Read a sheet; see Book."""
        entry = self.entries[index]
        handler = SheetHandler(self, entry.name, extent)
        self.parse(entry.part, handler)
        return RawSheet(entry.name, handler.cells, tuple(handler.merged), frozenset(handler.hidden_rows), entry.hidden)

    def relations(self, part: str) -> dict[str, tuple[str, str]]:
        """The relations of a part: kind and target part by id."""
        if (rels := rels_of(part)) not in self:
            return {}
        handler, folder = Relations(), posixpath.join("/", posixpath.dirname(part))
        self.parse(rels, handler)
        found = handler.found.items()
        return {id: (kind, posixpath.normpath(posixpath.join(folder, to)).lstrip("/")) for id, (kind, to) in found}


_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_LITERAL = re.compile("_(?=x[0-9A-Fa-f]{4}_)")
IMPOSSIBLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters, and halves of characters, that XML cannot hold."""


def unescape(text: str) -> str:
    r"""Undo Excel's `_x000D_` for characters that XML cannot hold; a carriage return is a line break.

    >>> unescape("a_x000D_b")
    'a\nb'
    """
    if "_x" in text:
        text = _ESCAPED.sub(lambda m: chr(int(m[1], 16)) if not 0xD800 <= int(m[1], 16) < 0xE000 else "", text)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def escape_literal(text: str) -> str:
    """A text that has the form of such an escape itself, so that it is read as it stands.

    >>> escape_literal("a_x000D_b"), unescape(escape_literal("a_x000D_b"))
    ('a_x005F_x000D_b', 'a_x000D_b')
    """
    return _LITERAL.sub("_x005F_", text) if "_x" in text else text


class _StringsHandler(Handler):
    """Collects the shared texts. Phonetic readings of Japanese texts (`rPh`) are no part of the text."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self._name, self._phonetic = name, False

    def start(self, name: str, attributes: Any) -> None:
        if name == "t":
            self.wanted = not self._phonetic
        elif name == "rPh":
            self._phonetic = True
        elif name == "si":
            self.take_text()

    def end(self, name: str) -> None:
        if name == "t":
            self.wanted = False
        elif name == "rPh":
            self._phonetic = False
        elif name == "si":
            self.texts.append(unescape(self.take_text()))
            if len(self.texts) > limits.SHARED_STRINGS:
                what = N_("more than {n} texts", n=f"{limits.SHARED_STRINGS:,}")
                raise unreadable("FILE007", name=self._name, what=what)


class SharedStrings:
    """The shared texts, read only as far as a sheet asks for them."""

    def __init__(self, package: XlsxBook) -> None:
        self._name, self._handler = package.name, _StringsHandler(package.name)
        part = package.by_kind.get("sharedstrings")
        self._reader = XmlReader(package, part, self._handler) if part else None

    def get(self, index: int) -> str:
        """The text of that number; raises UnreadableFile when there is none."""
        texts = self._handler.texts
        while len(texts) <= index and self._reader and self._reader.step():
            pass
        if len(texts) <= index:
            raise unreadable("FILE008", name=self._name, what=N_("a cell refers to a text that is missing"))
        return texts[index]


# Cells that have only a colour, before a cell that says where it stands or at a row's end. A comment or a text that
# is marked as one could have the same letters: where there is one, nothing is left out.
_BARE = re.compile(rb'(?:<c r="[A-Z]{1,3}[0-9]{1,7}"(?: s="[0-9]{1,6}")?(?: t="n")? ?/>)+(?=<c r="[A-Z]|</row>)')
_MARKED = re.compile(rb"\A!|<!|<\Z")


class SheetHandler(Handler):
    """Collects the filled cells, merged ranges and hidden rows of a sheet, as much of it as `extent` wants."""

    def __init__(self, book: XlsxBook, sheet: str, extent: Extent) -> None:
        super().__init__()
        self.cells: dict[tuple[int, int], RawCell] = {}
        self.merged: list[Range] = []
        self.hidden_rows: set[int] = set()
        self._book, self._sheet, self._extent = book, sheet, extent
        self._row = self._column = self._elements = self._merged_area = self._filled_rows = 0
        self._at: tuple[int, int] = (0, 0)
        self._type = self._style = self._value = self._formula = self._row_text = ""
        self._formula_kind = self._shared = ""
        self._masters: dict[str, tuple[str, str]] = {}
        self._phonetic = self._in_cell = self._in_data = False
        self._thins = extent is Extent.WHOLE

    def thin(self, piece: bytes) -> bytes:
        """Leave out cells without a value, which are most of a prepared sheet; they count all the same."""
        self._thins = self._thins and not _MARKED.search(piece)
        if not self._thins:
            return piece
        thinned = _BARE.sub(b"", piece)
        if len(thinned) != len(piece):
            left_out = piece.count(b"<c ") - thinned.count(b"<c ")
            self._elements += left_out
            self._budget.left -= left_out
            self._refuse_too_many()
        return thinned

    def start(self, name: str, attributes: Any) -> None:
        """A row, a cell, or a part of a cell begins."""
        if name == "sheetData":
            self._in_data = True
        elif not self._in_data:
            if name == "mergeCell":
                self._merge(attributes.get("ref", ""))
        elif name == "c":
            self._start_cell(attributes)
        elif name == "row":
            self._row = number(attributes.get("r"), self._row + 1)
            self._row_text = str(self._row)
            self._column = 0
            self._stop_after(self._row)
            if truth(attributes.get("hidden")) and len(self.hidden_rows) < limits.CELLS:
                self.hidden_rows.add(self._row)
        elif self._in_cell and (name in ("v", "f") or (name == "t" and not self._phonetic)):
            if name == "f":
                self._formula_kind, self._shared = attributes.get("t", "normal"), attributes.get("si", "")
            self.take_text()
            self.wanted = True
        elif name == "rPh":
            self._phonetic = True

    def end(self, name: str) -> None:
        """A part of a cell, or a cell, ends."""
        if name in ("v", "f", "t"):
            if self.wanted:
                text = unescape(self.take_text())
                self.wanted = False
                if name == "f":
                    self._formula = text
                else:
                    self._value += text
        elif name == "c" and self._in_data:
            self._end_cell()
        elif name == "rPh":
            self._phonetic = False
        elif name == "sheetData":
            self._in_data = False

    def _start_cell(self, attributes: Any) -> None:
        self._elements += 1
        reference = attributes.get("r", "")  # old writers leave it out: the next cell of the row
        if not reference:
            self._at = (self._row, self._column + 1)
        elif column := _column(reference.removesuffix(self._row_text)):
            self._at = (self._row, column)
        else:
            self._at = place(reference) or (0, 0)
        self._column = self._at[1]
        self._type, self._style = attributes.get("t", "n"), attributes.get("s", "")
        self._value = self._formula = self._formula_kind = self._shared = ""
        self._in_cell = True
        self._refuse_too_many()

    def _refuse_too_many(self) -> None:
        if self._elements > (limits.HEAD_CELLS if self._extent is Extent.HEAD else limits.CELL_ELEMENTS):
            if self._extent is not Extent.WHOLE:
                raise Stop
            raise self._too_large(N_("more than {n} cells", n=f"{limits.CELL_ELEMENTS:,}"), limits.CELLS)

    def _end_cell(self) -> None:
        self._in_cell = False
        if not (self._value or self._formula or self._formula_kind):
            return  # most of the cells that there are have only a colour
        formula = self._shared_formula() if self._formula_kind == "shared" else self._formula
        text, kind = self._typed()
        beyond = self._extent is Extent.TABLE and self._at[1] > _LAST_TABLE_COLUMN
        if not (formula or text) or not self._at[0] or beyond:
            return
        self.cells[self._at] = RawCell(text, kind, formula.lstrip("="))
        if self._extent is Extent.WHOLE and len(self.cells) > limits.CELLS:
            raise self._too_large(N_("more than {n} filled cells", n=f"{limits.CELLS:,}"), limits.CELLS)

    def _shared_formula(self) -> str:
        """A formula that stands once for several cells is written out for this one, as Excel shows it."""
        here = f"{column_letters(self._at[1])}{self._at[0]}"
        if self._formula:
            self._masters[self._shared] = (self._formula, here)
            return self._formula
        if self._shared not in self._masters:
            return ""
        return translated(*self._masters[self._shared], here)

    def _typed(self) -> tuple[str, Kind]:
        value, kind = self._value, self._type
        if kind == "s":
            index = value.strip()
            known = index.isascii() and index.isdigit()
            return self._book.strings.get(number(index)) if known else "", Kind.TEXT
        if kind in ("str", "inlineStr"):
            return value, Kind.TEXT
        value = value.strip()
        if kind == "b":
            return ("TRUE" if truth(value) else "FALSE") if value else "", Kind.TRUTH
        if kind in ("e", "d"):
            return value, Kind.ERROR if kind == "e" else Kind.DATE
        return self._number(value)

    def _number(self, value: str) -> tuple[str, Kind]:
        try:
            parsed = float(value)
        except ValueError:
            return value, Kind.TEXT
        if not math.isfinite(parsed):
            return value, Kind.TEXT
        kind = self._book.styles.kind(number(self._style))
        if kind is None:
            return number_text(parsed), Kind.NUMBER
        from openpyxl.utils.datetime import MAC_EPOCH, WINDOWS_EPOCH, from_excel

        try:
            moment = from_excel(parsed, MAC_EPOCH if self._book.mac_epoch else WINDOWS_EPOCH, timedelta=False)
        except (OverflowError, ValueError):
            return number_text(parsed), Kind.NUMBER
        return str(moment).removesuffix(" 00:00:00") if kind is Kind.DATE else str(moment).rpartition(" ")[2], kind

    def _stop_after(self, row: int) -> None:
        if self._extent is Extent.HEAD and row > limits.HEADER_ROWS:
            raise Stop
        self._filled_rows += 1
        if self._extent is Extent.TABLE and self._filled_rows > _TABLE_ROWS_READ:
            raise Stop

    def _merge(self, reference: str) -> None:
        if (block := block_of(reference)) is None:
            return
        self.merged.append(block)
        self._merged_area += block.area
        if self._extent is Extent.WHOLE and self._merged_area > limits.MERGED_CELLS:
            raise self._too_large(N_("{n} merged cells", n=f"{self._merged_area:,}"), limits.MERGED_CELLS)

    def _too_large(self, what: str, limit: int) -> UnreadableFile:
        return unreadable("FILE013", sheet=self._sheet, what=what, limit=f"{limit:,}")


_LAST_TABLE_COLUMN = limits.TABLE_COLUMNS + limits.COLUMNS
"""A table may begin further right; what is beyond its own 30 columns is found out later."""
_TABLE_ROWS_READ = limits.TABLE_ROWS + limits.HEADER_ROWS + 2
