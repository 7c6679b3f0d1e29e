"""Changing a workbook's file: all edits or none, nothing else in it touched, never over somebody else's change.

>>> from tempfile import TemporaryDirectory
>>> from rrp_sheets.workbook.edits import MoveRows
>>> from rrp_sheets.workbook.maker import make_workbook
>>> with TemporaryDirectory() as folder:
...     path = make_workbook({"T": [["From", "Operator", "Parameter", "To"]]}, f"{folder}/x.xlsx")
...     edited = edit(path, [SetCell("T", 2, 3, "=2"), MoveRows("T", 2, 1, before=4)])
...     read_sheets(path)[0].cells[3, 3].text
'=2'
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.atomic import Stamp, file_bytes, refuse_open_file, stamp_of, sweep, write_atomically
from rrp_sheets.workbook.edits import Edit, SetCell, SheetEdit
from rrp_sheets.workbook.raw import Extent, RawSheet, check_size, unreadable
from rrp_sheets.workbook.reading import MARKDOWN, csv_files, csv_order, csv_paths, open_book, tab_sheets, text_digest
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.text_books import ORDER, SUFFIXES
from rrp_sheets.workbook.text_patch import CsvFolder, CsvTable, EncodedText, MarkdownSheets, MarkdownTable


class FileChanged(SheetsError):
    """The file is not what it was when it was read: someone has changed it meanwhile."""


@dataclass(frozen=True)
class Edited:
    """Result of a series of edits: the file's `Reading.digest` as it is now, and whether it was written at all.

    `kept` has of every deleted sheet, in their order, what brings it back (`BringSheet`).
    """

    digest: str
    changed: bool
    kept: tuple[str, ...] = ()


def edit(path: Path | str, edits: Sequence[Edit], *, expected_digest: str | None = None) -> Edited:
    """Carry out edits one after the other and write the file once; each counts rows as the one before left them.

    In an .xlsx only the parts of the sheets that change are written anew (see `patch`); in CSV and Markdown only the
    lines that change. A symbolic link is followed. The edits are based on the file whose `Reading.digest` is expected;
    None takes the file as it is.

    Raises:
        FileChanged: the file is not what was expected. Read it again and decide anew.
        SheetsError: an edit cannot be done, or the file cannot be written. It is then as it was.
        UnreadableFile: the file cannot be read at all.
    """
    path = Path(path)
    if not path.exists():
        raise unreadable("FILE001", name=path.name or str(path), hint=N_("Check the spelling and the folder."))
    if not path.is_file() and not path.is_dir():
        raise unreadable("FILE002", name=path.name)
    refuse_open_file(path)
    path = path.resolve()
    with _alone(path if path.is_dir() else path.parent):
        if path.is_dir() or path.suffix.casefold() in SUFFIXES:
            return _edit_csv(path, edits, expected_digest)
        _refuse_read_only(path)
        stamp = stamp_of(path)
        data = file_bytes(path)
        if path.suffix.casefold() in MARKDOWN:
            return _edit_markdown(path, data, stamp, edits, expected_digest)
        if expected_digest not in (None, digest := hashlib.sha256(data).hexdigest()):
            raise _changed(path)
        new, kept = _edited(data, path.name, edits)
        if new != data:
            _refuse_unreadable(new, path.name)
            write_atomically(path, new, unchanged=stamp)
            digest = hashlib.sha256(new).hexdigest()
        return Edited(digest, new != data, kept)


def clean_up(path: Path) -> None:
    """Delete what a killed program of ours has left half-written beside a workbook, where none of ours writes now."""
    path = path.resolve()
    with _alone(path.parent) as alone, contextlib.suppress(OSError):
        if alone:
            sweep(path, older=-1.0)


def _edited(data: bytes, name: str, edits: Sequence[Edit]) -> tuple[bytes, tuple[str, ...]]:
    from rrp_sheets.workbook.patch.package_edit import PackageEdit, set_cell
    from rrp_sheets.workbook.patch.references import grow
    from rrp_sheets.workbook.patch.row_edits import change_rows
    from rrp_sheets.workbook.patch.sheets import change_sheets

    def finished() -> bytes:
        for index in package.ends:
            grow(package, index)
        return package.to_bytes()

    package, kept = PackageEdit(data, name), list[str]()
    for one in edits:
        if isinstance(one, SetCell):
            set_cell(package, one)
        elif isinstance(one, SheetEdit):
            package = PackageEdit(finished(), name)  # it has all sheets as they are now
            kept += [back] if (back := change_sheets(package, one)) else []
            package = PackageEdit(package.to_bytes(), name)
        else:
            change_rows(package, one)
    return finished(), tuple(kept)


def read_sheets(path: Path | str) -> tuple[RawSheet, ...]:
    """All cells of all sheets, the user's own too; raises UnreadableFile, also for a sheet beyond the limits."""
    book, _ = open_book(Path(path))
    sheets = tuple(book.sheet(index, Extent.WHOLE) for index in range(len(book.names)))
    for sheet in sheets:
        check_size(sheet)
    return sheets


def _edit_csv(path: Path, edits: Sequence[Edit], expected: str | None) -> Edited:
    folder = csv_files(path) if path.is_dir() else {path.stem: file_bytes(path)}
    paths = csv_paths(path)
    stamps = {name: stamp_of(paths[name]) for name in folder}
    open_book(path)  # refuses what cannot be read
    order = csv_order(path) if path.is_dir() else []
    if expected not in (None, digest := text_digest(folder, named=True, order=order)):
        raise _changed(path)
    now, kept = CsvFolder(dict(folder), list(order), tab_sheets(paths)), list[str]()
    for one in edits:
        if isinstance(one, SheetEdit):
            if not path.is_dir():
                remedy = N_("Use a folder of CSV files, or an .xlsx workbook.")
                raise SheetsError(N_("A CSV file is one sheet."), remedy)
            kept += [back] if (back := now.apply(one)) else []
            continue
        name = sheet_named(list(now.files), one.sheet)
        text = EncodedText(now.files[name])
        table = CsvTable(name, text.text, text.newline, now.file_name(name))
        table.apply(one)
        now.files[name] = text.encode(table.whole())
    if now.files == folder and now.order == order:
        return Edited(digest, False, tuple(kept))
    for name in {n for n in (*folder, *now.files) if folder.get(n) != now.files.get(n)} & paths.keys():
        refuse_open_file(paths[name])
        _refuse_read_only(paths[name])
    write_folder(path, folder, now, order, stamps)
    return Edited(text_digest(now.files, named=True, order=now.order), True, tuple(kept))


def _edit_markdown(path: Path, data: bytes, stamp: Stamp, edits: Sequence[Edit], expected: str | None) -> Edited:
    names = list(open_book(path)[0].names)
    if expected not in (None, digest := text_digest({path.name: data}, named=False)):
        raise _changed(path)
    text, kept = EncodedText(data), list[str]()
    whole = text.text
    for one in edits:
        if isinstance(one, SheetEdit):
            sheets = MarkdownSheets(whole, names, text.newline)
            kept += [back] if (back := sheets.apply(one)) else []
            whole, names = sheets.whole(), sheets.names
            continue
        table = MarkdownTable(sheet_named(names, one.sheet), whole, text.newline)
        table.apply(one)
        whole = table.whole()
    new = text.encode(whole)
    if new != data:
        write_atomically(path, new, unchanged=stamp)
        digest = text_digest({path.name: new}, named=False)
    return Edited(digest, new != data, tuple(kept))


def _changed(path: Path) -> FileChanged:
    return FileChanged(
        N_("“{name}” was changed by somebody else since it was read; nothing was written.", name=path.name),
        N_("Look at it again, and then make your change."),
    )


def _refuse_unreadable(data: bytes, name: str) -> None:
    """A result that we could not read ourselves (too large, say) is not written."""
    from rrp_sheets.workbook.xlsx import Package

    if len(data) > limits.FILE_BYTES:
        size, limit = f"{len(data) / 1e6:.1f} MB", f"{limits.FILE_BYTES / 1e6:g} MB"
        raise unreadable("FILE006", name=name, size=size, limit=limit)
    Package(data, name)


def _refuse_read_only(path: Path) -> None:
    if not path.stat().st_mode & stat.S_IWUSR:
        message = N_("“{name}” is write-protected, so it was left as it is.", name=path.name)
        raise SheetsError(message, N_("Take the protection off in the file's properties, or change a copy."))


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[bool]:
    """Let no other edit of ours run in this folder meanwhile, in this process or another; False where that is not sure.

    On Windows, and in a folder whose file system has no locks, it is not sure.
    """
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):  # a folder that cannot be read is told when the file is
        yield False
        return
    try:
        sure = False
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(handle, fcntl.LOCK_EX)
            sure = True
        yield sure
    finally:
        os.close(handle)


def write_folder(
    path: Path, before: Mapping[str, bytes], now: CsvFolder, order: Sequence[str], stamps: Mapping[str, Stamp]
) -> None:
    """Write the files that are other ones, new files, the order of the sheets; delete files whose sheets are gone.

    `before` and `stamps` are contents and stamps of the files by sheet as they were read; `order` is what `order.txt`
    said then. Where something cannot be written, SheetsError is raised and everything is as it was.
    """

    def file(name: str) -> Path:
        if not path.is_dir():
            return path
        spelt = (p for p in path.iterdir() if p.stem == name and p.suffix.casefold() in SUFFIXES)  # .CSV too
        return next(spelt, path / now.file_name(name))

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
