"""A bundle with its printed protocol: packing and printing joined."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path

from rrp_sheets.printing import HasErrors, make
from rrp_sheets.runs.bundle.packing import Packed
from rrp_sheets.runs.bundle.packing import pack as pack_files

_DRAFT = "The workbook has errors: protocol.pdf is marked as a draft."


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
