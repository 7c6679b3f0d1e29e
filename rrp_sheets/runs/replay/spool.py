"""What comes of a replay, put aside in a temporary file: of a long session it would fill the memory."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Mapping

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.replay.record import NO_DETAIL, RecordedLine

_ENCODE = json.JSONEncoder(separators=(",", ":")).encode


class Spool:
    """Entries that are written once, and can be gone through again and again, but not twice at one time.

    >>> spool = Spool(); spool.append(RecordedLine(5, "event", "s1", "Look!2", 0.5))
    >>> [(e.stream, e.value) for e in spool.named({"s1": "Distance"})]
    [('Distance', 0.5)]
    """

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115  # it goes with the spool
        self._count = 0

    def append(self, entry: RecordedLine) -> None:
        """Put one aside; its time is not before that of the one before."""
        parts = (entry.us, entry.kind, entry.stream, entry.row, entry.value, entry.what, entry.text)
        try:
            self._file.write(_ENCODE(parts) + "\n")
        except OSError as error:
            raise SheetsError(f"The replay cannot be stored ({error.strerror}).", "Free space on the disk.") from None
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def named(self, names: Mapping[str, str]) -> Iterator[RecordedLine]:
        """All of them, with streams called by the names of their ids."""
        self._file.seek(0)
        while line := self._file.readline():
            us, kind, stream, row, value, what, text = json.loads(line)
            yield RecordedLine(us, kind, names.get(stream, stream), row, value, what, text, NO_DETAIL)
