"""Writing what has changed in a folder of CSV files: all of it, or nothing."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.atomic import Stamp, write_atomically
from rrp_sheets.workbook.text_books import ORDER, SUFFIXES
from rrp_sheets.workbook.text_sheets import CsvFolder


def write_folder(
    path: Path, before: Mapping[str, bytes], now: CsvFolder, order: Sequence[str], stamps: Mapping[str, Stamp]
) -> None:
    """Write the files that are other ones, new files, the order of the sheets; delete files whose sheets are gone.

    Args:
        path: of the folder, or of a single file.
        before: what the files held, by sheet.
        now: what they shall hold.
        order: what `order.txt` said before.
        stamps: of the files when they were read.

    Raises:
        SheetsError: something cannot be written; everything is then as it was.
    """

    def file(name: str) -> Path:
        return (_spelt(path, name) or path / now.file_name(name)) if path.is_dir() else path

    written: list[str] = []
    try:
        for name, data in now.files.items():
            if before.get(name) != data:
                new = name not in before
                write_atomically(file(name), data, replace=not new, unchanged=None if new else stamps[name])
                written.append(name)
        if now.order != list(order):
            write_atomically(path / ORDER, ("\n".join(now.order) + "\n").encode())
    except SheetsError:
        for name in written:
            if name in before:
                write_atomically(file(name), before[name])
            else:
                with contextlib.suppress(OSError):
                    file(name).unlink()
        raise
    for name in before.keys() - now.files.keys():
        _leave(file(name), [file(n) for n in now.files if n.casefold() == name.casefold()])


def _leave(old: Path, alike: Sequence[Path]) -> None:
    """Delete a file; where capitals make no difference it may be one that was just written, which gets its name."""
    for new in alike:
        if old.exists() and new.exists() and old.samefile(new):
            old.rename(new)
            return
    old.unlink(missing_ok=True)


def _spelt(folder: Path, name: str) -> Path | None:
    """The file of a sheet, whose ending may be written in capitals."""
    return next((p for p in folder.iterdir() if p.stem == name and p.suffix.casefold() in SUFFIXES), None)
