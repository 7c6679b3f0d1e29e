"""An .xlsx file is a zip of XML parts, which is checked here before any part is parsed; the list of its sheets."""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
import zlib
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import IO, Any
from xml.sax import SAXException
from xml.sax.handler import ContentHandler

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import Kind, Range, unreadable

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
    """The part with the relations of a part, be that one there or not."""
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

    def __init__(self, package: Package, part: str, handler: Handler) -> None:
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


class Package:
    """The checked zip of one file, and the list of its sheets; raises UnreadableFile for what is broken or suspicious.

    `part` is the workbook part; `by_kind` has the parts that it refers to, of several of one kind the last. With
    `mac_epoch` dates count from 1904.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name = name
        self.budget = Budget()
        if not data:
            raise unreadable("FILE015", name=name)
        if data.startswith(_OLE):
            raise unreadable("FILE005" if _ENCRYPTED_NAME in data else "FILE003", name=name)
        if not data.startswith(b"PK"):
            raise unreadable("FILE002", name=name)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
        except BROKEN_ZIP as error:
            raise unreadable("FILE008", name=name, what=N_("it is cut off or not whole")) from error
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

    def relations(self, part: str) -> dict[str, tuple[str, str]]:
        """The relations of a part: kind and target part by id."""
        if (rels := rels_of(part)) not in self:
            return {}
        handler, folder = Relations(), posixpath.join("/", posixpath.dirname(part))
        self.parse(rels, handler)
        found = handler.found.items()
        return {id: (kind, posixpath.normpath(posixpath.join(folder, to)).lstrip("/")) for id, (kind, to) in found}
