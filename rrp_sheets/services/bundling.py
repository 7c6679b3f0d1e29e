"""A bundle with its printed protocol: packing and printing joined."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path

from rrp_sheets.services.bundle.packing import Packed
from rrp_sheets.services.bundle.packing import pack as pack_files
from rrp_sheets.services.printing import HasErrors, make
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.texts import N_

_WITHIN = 90.0  # s; the tests of the workbook may take 20
_DRAFT = N_("The workbook has errors: protocol.pdf is marked as a draft.")


def pack(path: Path, target: Path | None, runs: Sequence[str], against: Path | None, today: date | None) -> Packed:
    """Make a bundle; see `api.pack`."""

    def printed(book: Path) -> tuple[bytes, Sequence[str]]:
        try:
            found = make(book, against=against, today=today)
            return found.data, found.notes
        except HasErrors:
            found = make(book, against=against, today=today, draft=True)
            return found.data, [*found.notes, _DRAFT]

    return pack_files(path, target, runs, printed)


class Packer(QueryWorker):
    """Query worker that packs bundles; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_WITHIN, __name__)

    def pack(self, path: Path, runs: list[Path], target: Path) -> None:
        """Create a bundle of a workbook and the runs in those folders.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        self.ask(path.name, "pack_apart", str(path), [str(run) for run in runs], str(target))


def pack_apart(path: str, runs: Sequence[str], target: str) -> None:
    """Make a bundle in a worker process."""
    pack(Path(path), Path(target), runs, None, None)
