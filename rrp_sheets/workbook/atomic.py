"""Writing a file so that it is either whole or as it was, and never under the eyes of another program."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from rrp_sheets.errors import SheetsError


def refuse_open_file(path: Path) -> None:
    """Raise SheetsError when Excel or LibreOffice has the file open (they leave a lock file beside it)."""
    for program, lock in (("Excel", f"~${path.name}"), ("LibreOffice", f".~lock.{path.name}#")):
        if path.with_name(lock).exists():
            raise SheetsError(
                f"“{path.name}” is open in {program}.",
                f"Close it there and try again; if it is not open, delete the file “{lock}” beside it.",
            )


def write_atomically(path: Path, data: bytes, *, replace: bool = True) -> None:
    """Write to a temporary file beside `path`, have it stored, and give it the name.

    Args:
        path: of the file.
        data: its new content.
        replace: False to refuse when there is such a file, even one made a moment ago.

    Raises:
        SheetsError: when it cannot be written, or is there already and `replace` is False.
    """
    refuse_open_file(path)
    if path.exists() and not path.is_file() and not path.is_dir():
        raise SheetsError(f"“{path}” is not a file that can be replaced.", "Name a file.")
    half = ""
    try:
        handle, half = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(half, path.stat().st_mode & 0o777 if path.exists() else 0o644)
        if replace:
            os.replace(half, path)
        else:
            _take_name(half, path)
    except FileExistsError:
        raise SheetsError(
            f"There is already a file “{path.name}”; it was left as it is.", "Choose another name, or move that file."
        ) from None
    except OSError as error:
        why = error.strerror or "the system refuses it"
        raise SheetsError(
            f"“{path}” cannot be written: {why}.", "Choose another folder, or free some space."
        ) from error
    finally:
        if half:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(half)


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
