"""Reading untrusted XML as a stream: no document types, no entities, nothing kept but what a handler keeps."""

from __future__ import annotations

import re
from typing import IO, Any
from xml.sax import SAXException
from xml.sax.handler import ContentHandler

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import unreadable

_FIRST_PIECE, _LARGEST_PIECE = 1 << 14, 1 << 22
DECLARED = re.compile(rb"""\A\s*<\?xml[^>]*encoding\s*=\s*["']([^"'>]*)["']""")
_ENCODINGS = {"utf-8", "utf8", "utf-16", "us-ascii", "ascii", "iso-8859-1"}


class Stop(Exception):
    """Raised by a handler that has seen enough."""


class Budget:
    """Number of elements that may still be read from one file, over all its parts."""

    def __init__(self, elements: int = limits.XML_ELEMENTS) -> None:
        self.left = elements


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
    """Feeds a part of the package to a handler, piece by piece, so that one may stop early and go on later.

    Args:
        stream: the part's bytes.
        handler: what to do with the elements.
        name: of the file, for messages.
        part: of the package, for messages.
        budget: shared by all parts of a file.
    """

    def __init__(self, stream: IO[bytes], handler: Handler, name: str, part: str, budget: Budget) -> None:
        from defusedxml.expatreader import DefusedExpatParser

        self._stream = stream
        self._name, self._part = name, part
        self._swollen = unreadable("FILE007", name=name, what=N_("{part} is too long or too deep", part=part))
        self._parser = DefusedExpatParser(forbid_dtd=True)
        handler.guard(budget, self._swollen)
        self._handler = handler
        self._parser.setContentHandler(handler)
        # Straight to the handler: what SAX makes of every element's attributes takes longer than to read them.
        self._parser.start_element, self._parser.end_element = handler.startElement, handler.endElement
        self._parser.character_data = handler.characters
        self._piece = _FIRST_PIECE
        self._token = 0
        self.finished = False

    def step(self) -> bool:
        """Read one piece; False when the part is at its end. Raises UnreadableFile for broken or unsafe XML."""
        import zipfile
        import zlib

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
            raise unreadable(
                "FILE009", name=self._name, what=N_("{part} declares its own document type", part=self._part)
            ) from error
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

    def run(self) -> None:
        """Read to the end, or until the handler has seen enough."""
        while self.step():
            pass
