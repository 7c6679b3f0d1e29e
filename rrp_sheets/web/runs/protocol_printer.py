"""Clients of the printing process, which typesets protocols (the results are cached), and of the packing process.

A workbook may be untrusted, and its tests evaluate formulas: the server only reads what that process writes.
"""

from __future__ import annotations

import json
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import date
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

from rrp_sheets.errors import SheetsError
from rrp_sheets.render.pack.model import Pack
from rrp_sheets.runs.records.query_worker import QueryWorker

T = TypeVar("T")
_PACK_WITHIN = 90.0  # s; the tests of the workbook may take 20
_WITHIN = 120.0  # s for one protocol; its tests alone may take 20, and a thousand rows fill 130 pages
_KEPT = 8  # protocols, and as many PDFs
_MOST_BYTES = 60_000_000


@dataclass(frozen=True)
class Wanted:
    """Parameters of a protocol to be printed.

    Attributes:
        path: of the workbook; `digest` is its SHA-256, `against_digest` that of the one it is compared with.
        against: the other workbook; None for no comparison.
        language: its code; empty for the Protocol's.
        day: the date that is printed.
    """

    path: Path
    digest: str
    against: Path | None = None
    against_digest: str = ""
    language: str = ""
    day: str = field(default_factory=lambda: date.today().isoformat())

    @property
    def name(self) -> tuple[str, ...]:
        """Key of the protocol in the cache."""
        return (str(self.path), self.digest, self.against_digest, self.language, self.day)

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


class ProtocolPrinter(QueryWorker):
    """Query worker that prints protocols; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_WITHIN, "rrp_sheets.web.records.press_child")
        self._keeping = threading.Lock()
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._made: OrderedDict[tuple[str, ...], Any] = OrderedDict()

    def held(self, content: bytes, name: str) -> Path:
        """Write a file with this content that lives as long as the server, for a kept version."""
        with self._keeping:
            if self._folder is None:
                self._folder = tempfile.TemporaryDirectory(prefix="rrp-sheets-")
            path = Path(self._folder.name) / sha256(content).hexdigest() / name
            if not path.is_file():
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(content)
            return path

    def proof(self, wanted: Wanted) -> ProtocolPreview:
        """Return the protocol as data.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        return self._kept(("proof", *wanted.name), lambda: self._proof(wanted))

    def pdf(self, wanted: Wanted, paper: str) -> tuple[bytes, list[str]]:
        """Return the PDF for a paper size (`a4` or `letter`), and notes on what it lacks.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        return self._kept(("pdf", paper, *wanted.name), lambda: self._pdf(wanted, paper))

    def _proof(self, wanted: Wanted) -> ProtocolPreview:
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "pack.json"
            self._ask(wanted.path.name, "data", *wanted.request, str(target))
            found = json.loads(_content(target))
        return ProtocolPreview(rebuilt(Pack, found["pack"]), found["pictures"], found["legend"])

    def _pdf(self, wanted: Wanted, paper: str) -> tuple[bytes, list[str]]:
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "protocol.pdf"
            notes = self._ask(wanted.path.name, "pdf", *wanted.request, paper, str(target))
            return _content(target), [str(note) for note in notes]

    def _kept(self, name: tuple[str, ...], make: Callable[[], T]) -> T:
        with self._keeping:
            if name in self._made:
                self._made.move_to_end(name)
                return cast(T, self._made[name])
        made = make()
        with self._keeping:
            self._made[name] = made
            while len(self._made) > 2 * _KEPT:
                self._made.popitem(last=False)
        return made


class Packer(QueryWorker):
    """Query worker that packs bundles; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_PACK_WITHIN, "rrp_sheets.web.records.bundling_child")

    def pack(self, path: Path, runs: list[Path], target: Path) -> None:
        """Create a bundle of a workbook and the runs in those folders.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        self._ask(path.name, "pack", str(path), [str(run) for run in runs], str(target))


def _content(path: Path) -> bytes:
    if path.stat().st_size > _MOST_BYTES:
        raise SheetsError("This protocol is too large to be printed.", "Divide the workbook.")
    return path.read_bytes()


Rebuilt = TypeVar("Rebuilt")


def rebuilt(kind: type[Rebuilt], data: Mapping[str, Any]) -> Rebuilt:
    """Rebuild a dataclass object from JSON; its fields are texts, numbers, tuples, dicts and such dataclasses.

    >>> from rrp_sheets.render.pack.model import Ref
    >>> rebuilt(Ref, {"behaviour": "Greet", "rows": [2, 3]})
    Ref(behaviour='Greet', rows=(2, 3))
    """
    hints = _hints(cast(Any, kind))
    return kind(**{name: _value(hints[name], data[name]) for name in hints})


@lru_cache(maxsize=64)
def _hints(kind: type[Any]) -> dict[str, Any]:
    known = get_type_hints(kind)
    return {f.name: known[f.name] for f in fields(kind)}


def _value(hint: Any, data: Any) -> Any:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is UnionType:
        return None if data is None else _value(next(i for i in inner if i is not NoneType), data)
    if origin is tuple:
        several = inner[0:1] * len(data) if inner[-1] is Ellipsis else inner
        return tuple(_value(i, part) for i, part in zip(several, data, strict=True))
    if origin is dict:
        return {_value(inner[0], k): _value(inner[1], v) for k, v in data.items()}
    if is_dataclass(hint) and isinstance(hint, type):
        return rebuilt(hint, data)
    return hint(data)
