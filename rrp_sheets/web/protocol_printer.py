"""Client of the printing process, which typesets protocols; the results are cached.

A workbook may be untrusted, and its tests evaluate formulas: the server only reads what that process writes.
"""

from __future__ import annotations

import json
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import date
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from rrp_sheets.errors import SheetsError
from rrp_sheets.render.pack.model import Pack
from rrp_sheets.render.pack.participants import ParticipantSheet
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.texts import N_
from rrp_sheets.workers import codec

if TYPE_CHECKING:
    from rrp_sheets.services.printing import Gathered

T = TypeVar("T")
_WITHIN = 120.0  # s for one protocol; its tests alone may take 20, and a thousand rows fill 130 pages
_KEPT = 8  # protocols, and as many PDFs
_MOST_BYTES = 60_000_000


@dataclass(frozen=True)
class Wanted:
    """Parameters of a protocol to be printed; with `against` it is compared, an empty language is the Protocol's.

    For `participants` it is the information sheet instead of the protocol.
    """

    path: Path
    digest: str
    against: Path | None = None
    against_digest: str = ""
    language: str = ""
    participants: bool = False
    day: str = field(default_factory=lambda: date.today().isoformat())

    @property
    def name(self) -> tuple[str, ...]:
        """Key of the protocol in the cache."""
        return (str(self.path), self.digest, self.against_digest, self.language, self.day, str(self.participants))

    @property
    def request(self) -> tuple[str, ...]:
        """Arguments of the request to the printing process."""
        other = str(self.against) if self.against else ""
        return (str(self.path), f"{self.digest} {self.against_digest} {self.day}", other, self.language)


@dataclass(frozen=True)
class ProtocolPreview:
    """Protocol to be shown as a page: its content, its diagrams by name, and the legend."""

    pack: Pack
    pictures: dict[str, str]
    legend: str


@dataclass(frozen=True)
class SheetPreview:
    """Information sheet to be shown as a page."""

    sheet: ParticipantSheet


class ProtocolPrinter(QueryWorker):
    """Query worker that prints protocols; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_WITHIN, __name__)
        self._keeping = threading.Lock()
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._made: OrderedDict[tuple[str, ...], Any] = OrderedDict()

    def store(self, content: bytes, name: str) -> Path:
        """Write a file with this content that lives as long as the server, for a kept version."""
        with self._keeping:
            if self._folder is None:
                self._folder = tempfile.TemporaryDirectory(prefix="rrp-sheets-")
            path = Path(self._folder.name) / sha256(content).hexdigest() / name
            if not path.is_file():
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(content)
            return path

    def preview(self, wanted: Wanted) -> ProtocolPreview:
        """Return the protocol as data; raises SheetsError when it cannot be made, or not in time."""

        def make(target: Path) -> ProtocolPreview:
            self.ask(wanted.path.name, "write_preview", *wanted.request, str(target))
            return codec.unpack(ProtocolPreview, json.loads(_content(target)))

        return self._kept(("preview", *wanted.name), make)

    def sheet(self, wanted: Wanted) -> ParticipantSheet:
        """Return the information sheet for participants as data; raises as `preview`."""

        def make(target: Path) -> ParticipantSheet:
            self.ask(wanted.path.name, "write_sheet_preview", *wanted.request, str(target))
            return codec.unpack(SheetPreview, json.loads(_content(target))).sheet

        return self._kept(("sheet", *wanted.name), make)

    def pdf(self, wanted: Wanted, paper: str) -> tuple[bytes, list[str]]:
        """Return the PDF for a paper size (`a4` or `letter`), and notes on what it lacks; raises as `preview`."""

        def make(target: Path) -> tuple[bytes, list[str]]:
            write = "write_sheet_pdf" if wanted.participants else "write_pdf"
            notes = self.ask(wanted.path.name, write, *wanted.request, paper, str(target))
            return _content(target), [str(note) for note in notes]

        return self._kept(("pdf", paper, *wanted.name), make)

    def _kept(self, name: tuple[str, ...], make: Callable[[Path], T]) -> T:
        with self._keeping:
            if name in self._made:
                self._made.move_to_end(name)
                return cast(T, self._made[name])
        with tempfile.TemporaryDirectory() as folder:
            made = make(Path(folder) / "made")
        with self._keeping:
            self._made[name] = made
            while len(self._made) > 2 * _KEPT:
                self._made.popitem(last=False)
        return made


def _content(path: Path) -> bytes:
    if path.stat().st_size > _MOST_BYTES:
        raise SheetsError(N_("This protocol is too large to be printed."), N_("Split the workbook."))
    return path.read_bytes()


# ---- in the worker process
@lru_cache(maxsize=2)
def _gathered(path: str, digest: str, against: str, language: str) -> Gathered:
    """Gather the protocol's content; cached by the digests, as the page and its PDF are requested in turn."""
    from rrp_sheets.services.printing import HasErrors, gather

    other = Path(against) if against else None
    try:
        return gather(Path(path), against=other, language=language)
    except HasErrors:
        return gather(Path(path), against=other, language=language, draft=True)


def _sheet(path: str, language: str) -> ParticipantSheet:
    """Make the information sheet; of a workbook with errors a draft."""
    from rrp_sheets.services.printing import HasErrors, gather_sheet

    try:
        return gather_sheet(Path(path), language=language)[1]
    except HasErrors:
        return gather_sheet(Path(path), language=language, draft=True)[1]


def write_sheet_preview(path: str, digest: str, against: str, language: str, target: str) -> None:
    """Write the information sheet as JSON."""
    Path(target).write_text(json.dumps(codec.pack(SheetPreview(_sheet(path, language)))), encoding="ascii")


def write_sheet_pdf(path: str, digest: str, against: str, language: str, paper: str, target: str) -> list[str]:
    """Write the information sheet as a PDF; return notes on what it lacks."""
    from rrp_sheets.render.pack.participants import set_sheet

    data, notes = set_sheet(_sheet(path, language), "letter" if paper == "letter" else "a4")
    Path(target).write_bytes(data)
    return notes


def write_preview(path: str, digest: str, against: str, language: str, target: str) -> None:
    """Write the protocol, its diagrams and the legend as JSON."""
    from rrp_sheets.render.diagram import draw_legend

    found = _gathered(path, digest, against, language)
    legend, _, _ = draw_legend(found.pack.language, found.pack.connectors)
    preview = ProtocolPreview(found.pack, found.pictures, legend)
    Path(target).write_text(json.dumps(codec.pack(preview)), encoding="ascii")


def write_pdf(path: str, digest: str, against: str, language: str, paper: str, target: str) -> list[str]:
    """Write the PDF; return notes on what it lacks."""
    from rrp_sheets.render.pack.make import set_pack

    found = _gathered(path, digest, against, language)
    data, notes = set_pack(found.pack, found.pictures, "letter" if paper == "letter" else "a4")
    Path(target).write_bytes(data)
    return notes
