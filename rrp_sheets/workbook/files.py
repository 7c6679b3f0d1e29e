"""Files of workbooks: opened, changed and written, each in its format, whole or as they were.

Of several edits all are made or none, nothing else in the file is touched, and nobody else's change is written over.

>>> from tempfile import TemporaryDirectory
>>> from rrp_sheets.workbook.edits import MoveRows
>>> with TemporaryDirectory() as folder:
...     path = make_workbook({"T": [["From", "Operator", "Parameter", "To"]]}, f"{folder}/x.xlsx")
...     edited = edit(path, [SetCell("T", 2, 3, "=2"), MoveRows("T", 2, 1, before=4)])
...     read_sheets(path)[0].cells[3, 3].text
'=2'
"""

from __future__ import annotations

import contextlib
import errno
import glob
import hashlib
import os
import secrets
import stat
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.texts import N_, os_reason
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import Edit, SetCell, SetComments, SetLook, SheetEdit
from rrp_sheets.workbook.maker import Offers, workbook_bytes
from rrp_sheets.workbook.raw import Book, Extent, Format, RawSheet, Rows, check_size, unreadable
from rrp_sheets.workbook.sheet_names import sheet_named
from rrp_sheets.workbook.text_books import ORDER, SUFFIXES, TAB_SUFFIX, decode, natural, read_csv
from rrp_sheets.workbook.text_patch import (
    MARKDOWN,
    NO_FILE_NAME,
    CsvFolder,
    CsvTable,
    EncodedText,
    csv_text,
    texts_only,
)
from rrp_sheets.workbook.xlsx import XlsxBook


def _edit_xlsx(data: bytes, name: str, edits: Sequence[Edit]) -> tuple[bytes, tuple[str, ...]]:
    """Change an .xlsx file, of which only the parts of the sheets that change are others; see `Format`."""
    from rrp_sheets.workbook.patch.marks import add_parts, set_comments, set_look
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
        elif isinstance(one, SetComments):
            if add_parts(package, one):
                package = PackageEdit(finished(), name)
            set_comments(package, one)
        elif isinstance(one, SetLook):
            set_look(package, one)
        elif isinstance(one, SheetEdit):
            package = PackageEdit(finished(), name)  # it has all sheets as they are now
            kept += [back] if (back := change_sheets(package, one)) else []
            package = PackageEdit(package.to_bytes(), name)
        else:
            change_rows(package, one)
    new = finished()
    if new != data:
        _refuse_unreadable(new, name)
    return new, tuple(kept)


def _refuse_unreadable(data: bytes, name: str) -> None:
    """A result that we could not read ourselves (too large, say) is not written."""
    if len(data) > limits.FILE_BYTES:
        size, limit = f"{len(data) / 1e6:.1f} MB", f"{limits.FILE_BYTES / 1e6:g} MB"
        raise unreadable("FILE006", name=name, size=size, limit=limit)
    XlsxBook(data, name)


def _bytes_digest(data: bytes, name: str) -> str:
    return hashlib.sha256(data).hexdigest()


XLSX = Format("xlsx", (".xlsx",), XlsxBook, _edit_xlsx, workbook_bytes, _bytes_digest)
FORMATS = (XLSX, MARKDOWN)
"""Formats in which one file is a workbook. Several files are one in a folder of CSV files, each of them a sheet."""
WORKBOOK_SUFFIXES = tuple(suffix for one in FORMATS for suffix in one.suffixes)  # lists show such files
_MACROS = (".xlsm", ".xltm", ".xlam")
KNOWN_SUFFIXES = (*WORKBOOK_SUFFIXES, *SUFFIXES, *_MACROS, ".xls", ".ods")  # those of files that are refused too


def format_of(path: Path, suffix: str = "") -> Format | None:
    """The format of a file by its suffix, or the one given instead."""
    suffix = (suffix or path.suffix).casefold()
    return next((one for one in FORMATS if suffix in one.suffixes), None)


def open_book(path: Path, suffix: str = "") -> tuple[Book, str]:
    """A file's sheets, and its digest; see `read`."""
    if "\0" in str(path) or not path.exists():
        longer = f"{path.name}.xlsx"
        there = path.name and path.with_name(longer).exists()
        hint = N_("Did you mean “{guess}”?", guess=longer) if there else N_("Check the spelling and the folder.")
        raise unreadable("FILE001", name=path.name or str(path), hint=hint)
    if path.is_dir():
        paths = csv_paths(path)
        files, order = csv_files(paths), csv_order(path)
        book = read_csv(files, path.name or str(path), order, tab_sheets(paths))
        return book, _folder_digest(files, order)
    suffix = (suffix or path.suffix).casefold()
    if not path.is_file():
        raise unreadable("FILE002", name=path.name)
    data = file_bytes(path)
    if suffix in _MACROS:
        raise unreadable("FILE004", name=path.name)
    if not data:
        raise unreadable("FILE015", name=path.name)
    if suffix in SUFFIXES:
        tabs = {path.stem} if suffix == TAB_SUFFIX else set()
        return read_csv({path.stem: data}, path.name, tabs=tabs), _folder_digest({path.stem: data})
    found = format_of(path, suffix) or XLSX  # which refuses what is no package
    return found.read(data, path.name), found.digest(data, path.name)


def csv_order(folder: Path) -> list[str]:
    """The sheets that the folder's `order.txt` names, in that order; empty without one."""
    path = folder / ORDER
    if not path.is_file():
        return []
    lines = decode(file_bytes(path, limits.PART_BYTES), ORDER).split("\n")
    return [name for line in lines if (name := line.strip())][: limits.SHEETS]


def csv_paths(path: Path) -> dict[str, Path]:
    """The .csv and .tsv files of a folder (or the one file that `path` is) by sheet name.

    Raises UnreadableFile when there are too many, or two of them are the same sheet.
    """
    if not path.is_dir():
        return {path.stem: path}
    files = (p for p in path.iterdir() if p.suffix.casefold() in SUFFIXES and p.name[0] not in ".~" and p.is_file())
    found = sorted(files)
    if len(found) > limits.SHEETS:
        raise unreadable("FILE012", name=path.name, count=len(found), limit=limits.SHEETS)
    paths: dict[str, Path] = {}
    for file in found:
        if other := paths.get(file.stem):
            raise unreadable("FILE021", name=path.name, one=other.name, other=file.name, sheet=file.stem)
        paths[file.stem] = file
    return paths


def tab_sheets(paths: Mapping[str, Path]) -> set[str]:
    """The sheets whose files are .tsv files."""
    return {sheet for sheet, path in paths.items() if path.suffix.casefold() == TAB_SUFFIX}


def csv_files(paths: Mapping[str, Path]) -> dict[str, bytes]:
    """The contents of .csv and .tsv files by sheet name."""
    files: dict[str, bytes] = {}
    left = limits.FILE_BYTES
    for sheet, path in paths.items():
        files[sheet] = file_bytes(path, left)
        left -= len(files[sheet])
    return files


def _folder_digest(files: Mapping[str, bytes], order: Sequence[str] = ()) -> str:
    """One SHA-256 over texts in the order of their names, with length and name of each."""
    total = hashlib.sha256("".join(f"{name}\n" for name in order).encode("utf-8", "surrogateescape"))
    for name in sorted(files):
        content = decode(files[name], name).encode()
        total.update(f"{name}\0{len(content)}\0".encode("utf-8", "surrogateescape") + content)
    return total.hexdigest()


def read_sheets(path: Path | str) -> tuple[RawSheet, ...]:
    """All cells of all sheets, the user's own too; raises UnreadableFile, also for a sheet beyond the limits."""
    book, _ = open_book(Path(path))
    sheets = tuple(book.sheet(index, Extent.WHOLE) for index in range(len(book.names)))
    for sheet in sheets:
        check_size(sheet)
    return sheets


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

    What does not change of a file stays as it is. A symbolic link is followed. The edits are based on the file whose
    `Reading.digest` is expected; None takes the file as it is.

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
    carry_out = _edit_csv if path.is_dir() or path.suffix.casefold() in SUFFIXES else _edit_file
    try:
        with _locked(path if path.is_dir() else path.parent):  # no other edit of ours runs here meanwhile
            return carry_out(path, edits, expected_digest)
    except FileNotFoundError:  # it, or a sheet of it, has just gone
        raise _changed(path) from None
    except OSError as error:
        raise unwritable(path, error, N_("Look whether you may open and change it, and try again.")) from error


def clean_up(path: Path) -> None:
    """Delete what a killed program of ours has left half-written of a workbook; what is being written stays."""
    path = path.resolve()
    folder, beginning = (path, ".") if path.is_dir() else (path.parent, _half_name(path))
    _sweep(folder, beginning, older=_JUST_MADE_S)


def _edit_file(path: Path, edits: Sequence[Edit], expected: str | None) -> Edited:
    _refuse_read_only(path)
    stamp = stamp_of(path)  # before it is read: what is saved in between is then another state
    data = file_bytes(path)
    found = format_of(path) or XLSX
    if expected not in (None, digest := found.digest(data, path.name)):
        raise _changed(path)
    if not data:
        raise unreadable("FILE015", name=path.name)
    new, kept = found.edit(data, path.name, edits)
    if new != data:
        write_atomically(path, new, unchanged=stamp)
        digest = found.digest(new, path.name)
    return Edited(digest, new != data, kept)


def _edit_csv(path: Path, edits: Sequence[Edit], expected: str | None) -> Edited:
    paths, is_folder = csv_paths(path), path.is_dir()
    listed = path / ORDER
    stamps = {file: stamp_of(file) for file in (*paths.values(), *([listed] if listed.is_file() else []))}
    folder, order = csv_files(paths), csv_order(path)
    if not is_folder and not folder[path.stem]:
        raise unreadable("FILE015", name=path.name)
    read_csv(folder, path.name, order, tab_sheets(paths))  # refuses what cannot be read
    if expected not in (None, digest := _folder_digest(folder, order)):
        raise _changed(path)
    now, kept = CsvFolder(dict(folder), list(order), tab_sheets(paths)), list[str]()
    for one in edits:
        if isinstance(one, SheetEdit):
            if not is_folder:
                remedy = N_("Use a folder of CSV files, or an .xlsx workbook.")
                raise SheetsError(N_("A CSV file is one sheet."), remedy)
            kept += [back] if (back := now.apply(one)) else []
            continue
        if isinstance(one, SetComments | SetLook):
            raise texts_only(one)
        name = sheet_named(list(now.files), one.sheet)
        text = EncodedText(now.files[name])
        table = CsvTable(name, text.text, text.newline, now.file_name(name))
        table.apply(one)
        now.files[name] = text.encode(table.whole())
    was: dict[Path, bytes | None] = {file: folder[name] for name, file in paths.items()}
    new = {paths.get(name) or path / now.file_name(name): data for name, data in now.files.items()}
    if now.order != order:
        new[listed] = ("\n".join(now.order) + "\n").encode()
    gone = [file for file in was if file not in new]
    # deleted last; but where capitals make no difference, a file may have to make way for one that is alike
    first = [old for old in gone if any(os.path.exists(file) and file.samefile(old) for file in new)]
    files = dict.fromkeys(first) | new | dict.fromkeys(gone)
    changes = [
        _Change(file, data, file in stamps, stamps.get(file)) for file, data in files.items() if was.get(file) != data
    ]
    for change in changes:
        if change.replace:
            refuse_open_file(change.path)
            _refuse_read_only(change.path)
    if changes:
        _write_all(changes)
        digest = _folder_digest(now.files, now.order)
    return Edited(digest, bool(changes), tuple(kept))


def _changed(path: Path) -> FileChanged:
    return FileChanged(
        N_("“{name}” was changed by somebody else since it was read; nothing was written.", name=path.name),
        N_("Look at it again, and then make your change."),
    )


def _refuse_read_only(path: Path) -> None:
    if not path.stat().st_mode & stat.S_IWUSR:
        message = N_("“{name}” is write-protected, so it was left as it is.", name=path.name)
        raise SheetsError(message, N_("Take the protection off in the file's properties, or change a copy."))


@contextlib.contextmanager
def _locked(path: Path, wait: bool = True) -> Iterator[bool | None]:
    """Lock a file or folder meanwhile; False where another has it locked, None where there are no locks (Windows)."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))  # else a pipe of that name would block
    except OSError:  # a folder cannot be opened on Windows; elsewhere it is told when its file is read
        yield None
        return
    try:
        yield _lock(handle, wait)
    finally:
        os.close(handle)


def _lock(handle: int, wait: bool = True) -> bool | None:
    """Lock an open file until it is closed; returns as `_locked` yields."""
    try:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return None
    return True


def make_workbook(
    sheets: Mapping[str, Rows], path: Path | str, offers: Offers | None = None, *,
    language: str = "", replace: bool = True,
) -> Path:  # fmt: skip
    """Write rows of texts as a workbook, see `workbook_bytes`; raises SheetsError also when it cannot be written."""
    path = Path(path)
    write_atomically(path, workbook_bytes(sheets, offers, language), replace=replace)
    return path


def write_sheets(sheets: Mapping[str, Rows], path: Path, *, replace: bool = True) -> Path:
    """Write a file in the format that its suffix tells, else a folder of CSV files, see `write_csv`.

    Raises SheetsError when it cannot be written, or there is a file and `replace` is False.
    """
    found = format_of(path)
    if found is None:
        return write_csv(sheets, path)
    data = found.write(sheets)
    _refuse_large(data)
    write_atomically(path, data, replace=replace)
    return path


def write_csv(sheets: Mapping[str, Rows], folder: Path) -> Path:
    """Write a folder of CSV files, one a sheet, and where needed the file `order.txt` with the order of the sheets.

    Raises SheetsError when there are CSV files in the folder already, a sheet's name cannot be a file's name, or
    something cannot be written.
    """
    if folder.is_dir() and any(p.suffix.casefold() in SUFFIXES for p in folder.iterdir()):
        message = N_("There are CSV files in “{folder}” already.", folder=folder.name)
        raise SheetsError(message, N_("Name another folder, or empty that one."))
    if os.path.exists(folder / ORDER):  # it would say the order of these sheets
        raise already_there(folder / ORDER)
    for name in sheets:
        if NO_FILE_NAME.search(name) or len(name.encode()) > 200:
            message = N_("The sheet “{sheet}” cannot be a file of that name.", sheet=name)
            raise SheetsError(message, N_("Rename the sheet."))
    # the mark of UTF-8 is for Excel
    files = {f"{name}.csv": csv_text(rows).encode("utf-8-sig") for name, rows in sheets.items()}
    _refuse_large(b"".join(files.values()))
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = os_reason(error)
        message = N_("“{folder}” cannot be made: {why}.", folder=str(folder), why=why)
        raise SheetsError(message, N_("Name another folder.")) from error
    if list(sheets) != sorted(sheets, key=natural):
        files[ORDER] = ("\n".join(sheets) + "\n").encode()
    try:
        _write_all([_Change(folder / name, data, replace=False) for name, data in files.items()])
    except SheetsError:
        with contextlib.suppress(OSError):
            if made:
                folder.rmdir()
        raise
    return folder


def _refuse_large(data: bytes) -> None:
    if len(data) > limits.FILE_BYTES:
        n, most = len(data) / 1e6, limits.FILE_BYTES / 1e6
        message = N_("As text the workbook has {n:.1f} MB; {most:g} MB can be read again.", n=n, most=most)
        raise SheetsError(message, N_("Take out the sheets that the robot does not need."))


_ABANDONED_S = 600
_JUST_MADE_S = 0.1  # not locked yet
_HALF = ".part"
_RANDOM = "[0-9a-f]" * 8  # pattern of what `_new_half` puts before the suffix
_MOST_BYTES = 200  # of 255 that a name may have


def refuse_open_file(path: Path) -> None:
    """Raise SheetsError when Excel or LibreOffice has the file open (they leave a lock file beside it)."""
    for program, lock in (("Excel", f"~${path.name}"), ("LibreOffice", f".~lock.{path.name}#")):
        if os.path.exists(path.parent / lock):  # False, not an error, where that name is too long for the system
            told = N_("“{name}” is open in {program}.", name=path.name, program=program)
            how = N_("Close it there and try again. If it is not open, delete the file “{lock}” next to it.", lock=lock)
            raise SheetsError(told, how)


def already_there(path: Path) -> SheetsError:
    """The error for a file that must not be replaced."""
    message = N_("There is already a file “{name}”; it was left as it is.", name=path.name)
    return SheetsError(message, N_("Choose another name, or move that file."))


def unwritable(path: Path, error: OSError, remedy: str = N_("Name another file.")) -> SheetsError:
    """The error for a file that the system does not let us write."""
    reason = os_reason(error)
    if error.errno == errno.ENAMETOOLONG:
        remedy = N_("Choose a shorter name.")
    return SheetsError(N_("“{file}” cannot be written: {reason}.", file=str(path), reason=reason), remedy)


def refuse_workbook(target: Path, source: Path) -> None:
    """Raise SheetsError when what is written about a workbook would take the place of a workbook or a run's record."""
    suffix = target.suffix.casefold()
    if os.path.exists(target) and os.path.exists(source) and target.samefile(source):
        message = N_("“{file}” is the workbook itself; nothing was written.", file=str(target))
    elif suffix == ".jsonl":
        message = N_("“{file}” has the name of a run's recording, so nothing was written.", file=str(target))
    elif suffix in (".xlsx", ".xlsm", *SUFFIXES) or (suffix in KNOWN_SUFFIXES and _is_workbook(target)):
        message = N_("“{file}” has the name of a workbook, so nothing was written.", file=str(target))
    else:
        return
    raise SheetsError(message, N_("Give the file another name, such as “{name}”.", name=f"{target.stem}.txt"))


def _is_workbook(path: Path) -> bool:
    """Return whether there is such a file; one in Markdown counts only if it has sheets, as it may be any text."""
    if not os.path.isfile(path):  # False, not an error, for a name that is too long
        return False
    if format_of(path) is MARKDOWN:
        try:
            open_book(path)
        except UnreadableFile as error:
            return error.code not in ("FILE015", "FILE017")  # blank, or no sheets
        except OSError:
            return True
    return True


Stamp = tuple[int, int, int]
"""Identity of a file's state: time of the last change (ns), size in bytes, number of the file itself."""


def stamp_of(path: Path) -> Stamp:
    """The stamp of a file as it is now."""
    about = path.stat()
    return about.st_mtime_ns, about.st_size, about.st_ino


def file_bytes(path: Path, most: int = limits.FILE_BYTES) -> bytes:
    """The bytes of a file, read once so that what is checked, hashed and parsed is the same."""
    with path.open("rb") as file:
        data = file.read(limits.FILE_BYTES + 1)
        size = max(len(data), os.fstat(file.fileno()).st_size)
    if size > most:
        limit = N_("{n:g} MB in all", n=limits.FILE_BYTES / 1e6)
        raise unreadable("FILE006", name=path.name, size=f"{size / 1e6:.1f} MB", limit=limit)
    return data


def write_atomically(path: Path, data: bytes, *, replace: bool = True, unchanged: Stamp | None = None) -> None:
    """Write to a temporary file beside `path`, have it stored, and give it the name; raises SheetsError if it cannot.

    Without `replace` a file that is there is left, even one made a moment ago; with it a symbolic link is followed.
    `unchanged` is the stamp that the file had when it was read; it is not replaced when it has another by now.
    """
    _write_all([_Change(path, data, replace, unchanged)])


@dataclass(frozen=True)
class _Change:
    """A file that gets other contents, or is deleted where `data` is None; the rest is as in `write_atomically`."""

    path: Path
    data: bytes | None
    replace: bool = True
    unchanged: Stamp | None = None


def _write_all(changes: Sequence[_Change]) -> None:
    """Write temporary files beside all files, have them stored, and then give them their names: all or none.

    What takes room on the disk is done before the first file gets its name, also for the way back.
    """
    several = len(changes) > 1
    changes = [replace(change, path=_target(change)) for change in changes]
    with contextlib.ExitStack() as until_done, contextlib.ExitStack() as undo:
        prepared = [_prepare(change, several, until_done) for change in changes]
        for change, (half, back) in zip(changes, prepared, strict=True):
            with _told(change.path):
                refuse_open_file(change.path)
                if change.unchanged and not (change.path.exists() and stamp_of(change.path) == change.unchanged):
                    words = N_("“{name}” was changed by another program at this moment; it was left as it is.")
                    remedy = N_("Look at it again, and then make your change.")
                    raise SheetsError(N_(words, name=change.path.name), remedy)
                if change.data is None:
                    os.unlink(change.path)
                elif change.replace:
                    os.replace(half, change.path)
                else:
                    _take_name(half, change.path)
                if several:
                    undo.callback(_put_back, change.path, back)
        undo.pop_all()
    for folder in {change.path.parent for change in changes}:
        _keep_folder(folder)


def _target(change: _Change) -> Path:
    """Return the file that is changed: where a link leads to, if its contents are replaced."""
    follows = change.replace and change.data is not None and os.path.islink(change.path)
    return Path(os.path.realpath(change.path)) if follows else change.path


def _prepare(change: _Change, several: bool, until_done: contextlib.ExitStack) -> tuple[str, str]:
    """Return a temporary file with the new contents and one with the old ones, for the way back; "" without any."""
    path = change.path
    refuse_open_file(path)
    with _told(path):
        if path.is_dir() or (path.exists() and not path.is_file()):
            raise SheetsError(N_("“{file}” is not a file that can be replaced.", file=str(path)), N_("Name a file."))
        _sweep(path.parent, _half_name(path))
        about = path.stat() if change.replace and path.exists() else None
        half = back = ""
        if change.data is not None:
            half = _write_half(path, change.data, about, until_done)
        if several and about is not None:
            back = _linked(path, until_done) or _write_half(path, file_bytes(path), about, until_done)
        return half, back


def _linked(path: Path, until_done: contextlib.ExitStack) -> str:
    """Give a file a second name until all is done, and keep it locked; "" where there are no links or no locks."""
    back = _new_half(path, until_done)
    with contextlib.suppress(OSError):
        handle = os.open(path, os.O_RDONLY)
        if _keep_locked(handle, until_done):
            os.link(path, back)
            return back
    return ""


def _write_half(path: Path, data: bytes, about: os.stat_result | None, until_done: contextlib.ExitStack) -> str:
    """Write and store a temporary file beside another one, with the rights that `about` tells; it is locked, too."""
    half = _new_half(path, until_done)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
    # a new file is as open as others of the process
    with os.fdopen(os.open(half, flags, 0o666 if about is None else 0o600), "wb") as file:
        _keep_locked(os.dup(file.fileno()), until_done)
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    if about is not None:
        _keep_rights(half, about)
    return half


def _new_half(path: Path, until_done: contextlib.ExitStack) -> str:
    """Return a name for a temporary file beside another one, which is deleted when all is done."""
    half = str(path.parent / f"{_half_name(path)}{secrets.token_hex(4)}{_HALF}")
    until_done.callback(_delete, half)
    return half


def _keep_locked(handle: int, until_done: contextlib.ExitStack) -> bool:
    """Keep an open file locked until all is done, so that nobody takes it for left behind; else close it."""
    if _lock(handle, wait=False):
        until_done.callback(os.close, handle)
        return True
    os.close(handle)  # on Windows it could not be replaced
    return False


@contextlib.contextmanager
def _told(path: Path) -> Iterator[None]:
    """Raise what the system refuses as SheetsError."""
    try:
        yield
    except FileExistsError:
        raise already_there(path) from None
    except OSError as error:
        raise unwritable(path, error, N_("Choose another folder, or free some space.")) from error


def _put_back(path: Path, back: str) -> None:
    """Give a file its old contents, or delete it where there were none."""
    if back:
        with contextlib.suppress(OSError):  # what failed first is told
            os.replace(back, path)
    else:
        _delete(path)


def _delete(path: str | Path) -> None:
    with contextlib.suppress(OSError):  # it is gone already, or is swept away later
        os.unlink(path)


def _keep_rights(half: str, about: os.stat_result) -> None:
    """Give a temporary file owner, group and mode of the file that it replaces: others may do what they could."""
    mode = about.st_mode & 0o777
    if hasattr(os, "chown"):
        for owner in (about.st_uid, -1):  # only root may give a file away; its group may be another one of ours
            with contextlib.suppress(OSError):
                os.chown(half, owner, about.st_gid)
                break
        else:
            mode &= 0o707  # its group is another one now, which may not do what the old one could
    os.chmod(half, mode)


def _sweep(folder: Path, beginning: str, older: float = _ABANDONED_S) -> None:
    """Delete what attempts left that were killed in mid-writing, `older` seconds ago.

    Who writes it has it locked; where there are no locks, nobody writes for minutes.
    """
    for left in folder.glob(f"{glob.escape(beginning)}*{_RANDOM}{_HALF}"):
        with contextlib.suppress(OSError), _locked(left, wait=False) as locked:
            limit = older if locked else _ABANDONED_S
            if locked is not False and time.time() - left.stat().st_mtime > limit:
                left.unlink()


def _half_name(path: Path) -> str:
    """Return the beginning of the temporary file's name, cut so that the whole is not too long for the system."""
    return f".{os.fsencode(path.name)[:_MOST_BYTES].decode(errors='ignore')}."


def _keep_folder(folder: Path) -> None:
    """Have the new name stored too, so that a power cut cannot bring the old file back (not on Windows)."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _take_name(half: str, path: Path) -> None:
    """Give the file its name; raises FileExistsError when that is taken."""
    try:
        os.link(half, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        with path.open("xb"):
            pass
        os.replace(half, path)
