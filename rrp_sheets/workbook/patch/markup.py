"""XML as bytes with known places: an element is found, cut out or replaced, and everything around it stays as it was.

Nothing is parsed into a tree and written back, because that would lose prefixes, comments, the order of attributes,
and what other programs keep between the elements.
"""

from __future__ import annotations

import codecs
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import limits

TAG = re.compile(rb"""<(?:[^<>"']|"[^"]*"|'[^']*')*>""")
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")
_DECLARED = re.compile(rb"""\A\s*<\?xml[^>]*encoding\s*=\s*["']([^"'>]*)["']""")
_UTF8 = {"utf-8", "utf8", "us-ascii", "ascii"}


@dataclass(frozen=True, slots=True)
class Element:
    """An element and where it stands, in bytes.

    Attributes:
        path: the local names from the document's element down to this one.
        name: as written, with its prefix.
        start: of its start tag.
        inner: end of its start tag, where its content begins.
        inner_end: where its content ends; the same as `inner` for `<a/>`.
        end: after its end tag.
    """

    path: tuple[str, ...]
    name: str
    attributes: Mapping[str, str]
    start: int
    inner: int
    inner_end: int
    end: int

    @property
    def local(self) -> str:
        """The name without prefix."""
        return self.path[-1]

    @property
    def prefix(self) -> str:
        """The prefix with its colon, or nothing."""
        return self.name[: -len(self.local)]


def as_utf8(data: bytes) -> bytes:
    """The same XML in UTF-8, unchanged where it is that already; raises SheetsError for an unknown encoding."""
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    declared = _DECLARED.search(data)
    encoding = "utf-16" if wide else declared[1].decode("ascii", "replace") if declared else "utf-8"
    if encoding.casefold() in _UTF8:
        return data.removeprefix(codecs.BOM_UTF8)
    try:
        text = _DECLARATION.sub("", data.decode(encoding))
    except (UnicodeDecodeError, LookupError) as error:
        raise broken() from error
    return b'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n' + text.encode()


def _refuse_doctype(*_: Any) -> None:
    raise SheetsError("A part of the file declares its own document type.", "Save the workbook anew in Excel.")


class Scanner(ABC):
    """Walks through XML once. Subclasses say in `wants` which elements they want and get them in `found`."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self._open: list[tuple[str, str, Mapping[str, str], int] | None] = []
        self._path: list[str] = []
        self._left = limits.XML_ELEMENTS
        self._parser = expat.ParserCreate()
        self._parser.StartDoctypeDeclHandler = _refuse_doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def scan(self) -> None:
        """Walk; raises SheetsError where the XML is broken."""
        try:
            self._parser.Parse(self.data, True)
        except expat.ExpatError as error:
            raise broken() from error

    @abstractmethod
    def wants(self, path: list[str], attributes: Mapping[str, str]) -> bool:
        """Return whether `found` is called for an element."""

    @abstractmethod
    def found(self, element: Element) -> None:
        """A wanted element has ended."""

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._path.append(name.rpartition(":")[2])
        self._left -= 1
        if self._left < 0 or len(self._path) > limits.XML_DEPTH:
            raise broken()
        wanted = self.wants(self._path, attributes)
        self._open.append((name, "", attributes, self._parser.CurrentByteIndex) if wanted else None)

    def _end(self, name: str) -> None:
        opened = self._open.pop()
        if opened is not None:
            start = opened[3]
            self.found(_element(self.data, tuple(self._path), name, opened[2], start, self._parser.CurrentByteIndex))
        self._path.pop()


def _element(
    data: bytes, path: tuple[str, ...], name: str, attributes: Mapping[str, str], start: int, at: int
) -> Element:
    """The element whose end expat reports at `at`: before `</name>`, or after `<name/>`."""
    tag = TAG.match(data, start)
    if tag is None:
        raise broken()
    inner = tag.end()
    if data[inner - 2 : inner] == b"/>":
        return Element(path, name, attributes, start, inner, inner, inner)
    return Element(path, name, attributes, start, inner, at, data.index(b">", at) + 1)


class _Finder(Scanner):
    def __init__(self, data: bytes, wanted: Callable[[list[str]], bool]) -> None:
        super().__init__(data)
        self.elements: list[Element] = []
        self._wanted = wanted

    def wants(self, path: list[str], attributes: Mapping[str, str]) -> bool:
        return self._wanted(path)

    def found(self, element: Element) -> None:
        self.elements.append(element)


def find(data: bytes, wanted: Callable[[list[str]], bool]) -> list[Element]:
    """The elements whose path is wanted, in the order of their beginnings.

    >>> [e.attributes["r"] for e in find(b'<a><x:c r="1"/><x:c r="2">t</x:c></a>', lambda p: p[-1] == "c")]
    ['1', '2']
    """
    finder = _Finder(data, wanted)
    finder.scan()
    return sorted(finder.elements, key=lambda e: e.start)


def broken() -> SheetsError:
    """The error for XML that cannot be changed safely."""
    return SheetsError(
        "A part of the file cannot be understood, so it is left as it is.",
        "Open the workbook in Excel or LibreOffice, save it under a new name, and use that.",
    )


def inner_text(data: bytes, element: Element) -> str:
    """The text of an element and all within it.

    >>> data = b"<a>1 &lt; <b>2</b><![CDATA[ < 3]]></a>"
    >>> inner_text(data, find(data, lambda p: p == ["a"])[0])
    '1 < 2 < 3'
    """
    texts: list[str] = []
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse_doctype
    parser.CharacterDataHandler = texts.append
    parser.Parse(data[element.start : element.end], True)
    return "".join(texts)


def with_attributes(tag: bytes, changes: Mapping[str, str | None]) -> bytes:
    """A start tag with attributes changed, added at its end, or (None) taken out.

    >>> with_attributes(b'<c r="A1"  t="s"/>', {"r": "A2", "t": None, "s": "3"})
    b'<c r="A2" s="3"/>'
    """
    for name, value in changes.items():
        pattern = re.compile(rb"""(\s+)""" + re.escape(name.encode()) + rb"""\s*=\s*("[^"]*"|'[^']*')""")
        match = _outside_of_values(tag, pattern)
        if match is not None:
            new = b"" if value is None else match[1] + name.encode() + b"=" + quoteattr(value).encode()
            tag = tag[: match.start()] + new + tag[match.end() :]
        elif value is not None:
            close = len(tag) - (2 if tag.endswith(b"/>") else 1)
            tag = tag[:close].rstrip() + b" " + name.encode() + b"=" + quoteattr(value).encode() + tag[close:]
    return tag


def _outside_of_values(tag: bytes, pattern: re.Pattern[bytes]) -> re.Match[bytes] | None:
    """The first match that is an attribute of its own and not a part of another one's value."""
    for match in pattern.finditer(tag):
        before = re.sub(rb'"[^"]*"|\'[^\']*\'', b"", tag[: match.start()])
        if b'"' not in before and b"'" not in before:
            return match
    return None


def splice(data: bytes, changes: Iterable[tuple[int, int, bytes]]) -> bytes:
    """Data with pieces replaced; the places are those of the original and do not overlap.

    >>> splice(b"abcdef", [(4, 5, b""), (1, 2, b"BB")])
    b'aBBcdf'
    """
    out: list[bytes] = []
    at = 0
    for start, end, new in sorted(changes):
        out += (data[at:start], new)
        at = end
    return b"".join([*out, data[at:]])


def text_xml(text: str) -> bytes:
    """A text as the content of an element."""
    return escape(text, {"\r": "&#13;"}).encode()
