"""An .xlsx file is a zip of XML parts. Everything about the package is checked here before any part is parsed."""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
import zlib
from typing import IO, Any

from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import unreadable
from rrp_sheets.workbook.xml_stream import Budget, Handler, XmlReader

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
    "vbaproject": ("FILE004", ""),
    "xlmacrosheet": ("FILE004", ""),
    "externallink": ("FILE010", N_("another workbook")),
    "externallinkpath": ("FILE010", N_("another workbook")),
    "connections": ("FILE010", N_("a data connection")),
    "oleobject": ("FILE011", N_("a document")),
    "package": ("FILE011", N_("a document")),
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


class Package:
    """The checked zip of one file; raises UnreadableFile for everything suspicious.

    Args:
        data: the file's bytes.
        name: the file's name, for messages.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name = name
        self.budget = Budget()
        _check_beginning(data, name)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
        except BROKEN_ZIP as error:
            raise unreadable("FILE008", name=name, what=N_("it is cut off or not whole")) from error
        entries = self._zip.infolist()
        self._check_entries(entries)
        self.parts = {e.filename.casefold(): e for e in entries if not e.is_dir()}
        self._check_parts()

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
        for part in self.parts:
            for pattern, code, what in _PARTS:
                if pattern.search("/" + part):
                    raise unreadable(code, name=self.name, what=what)
        for part in self.parts:
            if part.endswith((".xml", ".rels", ".vml")):
                self._check_prologue(part)
        if b"macroenabled" in self.read("[content_types].xml").lower():
            raise unreadable("FILE004", name=self.name)
        for part in self.parts:
            if part.endswith(".rels"):
                self._check_relations(part)

    def _check_prologue(self, part: str) -> None:
        """A document type stands before the first element, so a look at the beginning is enough."""
        with self.open(part) as stream:
            try:
                beginning = stream.read(_PROLOGUE)
            except BROKEN_ZIP as error:
                raise unreadable("FILE008", name=self.name, what=N_("{part} cannot be read", part=part)) from error
        if _DOCTYPE.search(beginning.replace(b"\0", b"")):
            raise unreadable("FILE009", name=self.name, what=N_("{part} declares its own document type", part=part))

    def _check_relations(self, part: str) -> None:
        relations = Relations()
        self.parse(part, relations)
        for kind, _ in relations.found.values():
            if kind in _RELATIONS:
                code, what = _RELATIONS[kind]
                raise unreadable(code, name=self.name, what=what)
        if set(relations.outside) - {"hyperlink"}:
            raise unreadable("FILE010", name=self.name, what=sorted(set(relations.outside) - {"hyperlink"})[0])

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

    def read(self, part: str) -> bytes:
        """All bytes of a part."""
        with self.open(part) as stream:
            try:
                return stream.read()
            except BROKEN_ZIP as error:
                raise unreadable("FILE008", name=self.name, what=N_("{part} cannot be read", part=part)) from error

    def reader(self, part: str, handler: Handler) -> XmlReader:
        """A reader of a part that has not begun yet."""
        return XmlReader(self.open(part), handler, self.name, part, self.budget)

    def parse(self, part: str, handler: Handler) -> None:
        """Feed a part to a handler until it has seen enough."""
        self.reader(part, handler).run()

    def relations(self, part: str) -> dict[str, tuple[str, str]]:
        """The relations of a part: kind and target part by id."""
        folder, leaf = posixpath.split(part)
        rels = posixpath.join(folder, "_rels", f"{leaf}.rels")
        if rels not in self:
            return {}
        handler = Relations()
        self.parse(rels, handler)
        return {
            id: (kind, posixpath.normpath(posixpath.join("/", folder, target)).lstrip("/"))
            for id, (kind, target) in handler.found.items()
        }


def _check_beginning(data: bytes, name: str) -> None:
    """Raise UnreadableFile for a file that is no zip, with a code for what it may be."""
    if not data:
        raise unreadable("FILE015", name=name)
    if data.startswith(_OLE):
        raise unreadable("FILE005" if _ENCRYPTED_NAME in data else "FILE003", name=name)
    if not data.startswith(b"PK"):
        raise unreadable("FILE002", name=name)


_MOMENT = (2026, 1, 1, 0, 0, 0)
_MODIFIED = re.compile(rb"(<dcterms:(?:created|modified)[^>]*>)[^<]*(</)")
_STAMP = rb"\g<1>2026-01-01T00:00:00Z\g<2>"
# Numbers are stored as text on purpose; without this Excel marks each with a green corner.
_AS_TEXT = b'<ignoredErrors><ignoredError sqref="A1:XFD1048576" numberStoredAsText="1"/></ignoredErrors></worksheet>'


def packed(book: Any) -> bytes:
    """Save an openpyxl workbook with a fixed date in its properties and in its zip entries."""
    first, second = io.BytesIO(), io.BytesIO()
    book.save(first)
    with zipfile.ZipFile(first) as source, zipfile.ZipFile(second, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "docProps/core.xml":
                data = _MODIFIED.sub(_STAMP, data)
            elif name.startswith("xl/worksheets/") and data.endswith(b"</worksheet>"):
                # A height without this attribute is adapted when the row's text changes.
                data = data.replace(b' customHeight="1"', b"").removesuffix(b"</worksheet>") + _AS_TEXT
            entry = zipfile.ZipInfo(name, _MOMENT)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            target.writestr(entry, data)
    return second.getvalue()
