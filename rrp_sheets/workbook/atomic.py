"""Files read at once and written atomically, whole or as they were; refusals of those that are open or workbooks."""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import secrets
import time
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.raw import unreadable

_ABANDONED_S = 600
_HALF = ".part"
_MOST_BYTES = 200  # of 255 that a name may have


def refuse_open_file(path: Path) -> None:
    """Raise SheetsError when Excel or LibreOffice has the file open (they leave a lock file beside it)."""
    for program, lock in (("Excel", f"~${path.name}"), ("LibreOffice", f".~lock.{path.name}#")):
        if os.path.exists(path.parent / lock):  # False, not an error, where that name is too long for the system
            told = N_("“{name}” is open in {program}.", name=path.name, program=program)
            how = N_("Close it there and try again; if it is not open, delete the file “{lock}” beside it.", lock=lock)
            raise SheetsError(told, how)


def already_there(path: Path) -> SheetsError:
    """The error for a file that must not be replaced."""
    message = N_("There is already a file “{name}”; it was left as it is.", name=path.name)
    return SheetsError(message, N_("Choose another name, or move that file."))


def unwritable(path: Path, error: OSError, remedy: str = N_("Name another file.")) -> SheetsError:
    """The error for a file that the system does not let us write."""
    reason = error.strerror or N_("the system refuses it")
    if error.errno == errno.ENAMETOOLONG:
        remedy = N_("Choose a shorter name.")
    return SheetsError(N_("“{file}” cannot be written: {reason}.", file=str(path), reason=reason), remedy)


def refuse_workbook(target: Path, source: Path) -> None:
    """Raise SheetsError when what is written about a workbook would take the place of a workbook or a run's record."""
    suffix = target.suffix.casefold()
    if os.path.exists(target) and os.path.exists(source) and target.samefile(source):
        message = N_("“{file}” is the workbook itself; nothing was written.", file=str(target))
    elif suffix == ".jsonl":
        message = N_("“{file}” would be taken for a run's record; nothing was written.", file=str(target))
    elif suffix in (".xlsx", ".xlsm", ".csv", ".tsv"):
        message = N_("“{file}” would be taken for a workbook; nothing was written.", file=str(target))
    else:
        return
    raise SheetsError(message, N_("Give the file another name, such as “{name}”.", name=f"{target.stem}.txt"))


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

    Without `replace` a file that is there is left, even one made a moment ago. `unchanged` is the stamp that the file
    had when it was read; it is not replaced when it has another by now.
    """
    refuse_open_file(path)
    half = ""
    try:
        if path.is_dir() or (path.exists() and not path.is_file()):
            raise SheetsError(N_("“{file}” is not a file that can be replaced.", file=str(path)), N_("Name a file."))
        sweep(path)
        mode = path.stat().st_mode & 0o777 if path.exists() else None  # a new file is as open as others of the process
        name = str(path.parent / f"{_half_name(path)}{secrets.token_hex(4)}{_HALF}")
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
        handle, half = os.open(name, flags, 0o666 if mode is None else 0o600), name
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if mode is not None:
            os.chmod(half, mode)
        refuse_open_file(path)
        if unchanged is not None and stamp_of(path) != unchanged:
            raise SheetsError(
                N_("“{name}” was changed by another program at this moment; it was left as it is.", name=path.name),
                N_("Look at it again, and then make your change."),
            )
        if replace:
            os.replace(half, path)
        else:
            _take_name(half, path)
        _keep_folder(path.parent)
    except FileExistsError:
        raise already_there(path) from None
    except OSError as error:
        raise unwritable(path, error, N_("Choose another folder, or free some space.")) from error
    finally:
        if half:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(half)


def sweep(path: Path, older: float = _ABANDONED_S) -> None:
    """Delete what an attempt left that was killed in mid-writing, `older` seconds ago; nobody writes for minutes."""
    limit = time.time() - older
    for left in path.parent.glob(f"{glob.escape(_half_name(path))}*{_HALF}"):
        with contextlib.suppress(OSError):
            if left.stat().st_mtime < limit:
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
