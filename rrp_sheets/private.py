"""Folders and files that only their user can read, from the moment they are there: records of people, faces, edits."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import TextIO

_OTHERS = 0o077


def only_for_this_user() -> None:
    """Have everything that this process makes from now on, and those that it starts, readable by this user only."""
    os.umask(_OTHERS)


def private_folder(path: Path) -> None:
    """Make a folder for this user only, and those above that are missing; one that is there stays as it is.

    Raises:
        OSError: it cannot be made.
    """
    folder_above(path)
    path.mkdir(mode=0o700, exist_ok=True)


def folder_above(path: Path) -> None:
    """Make the folders above a path that are missing, as open as the one that they are made in.

    Raises:
        OSError: they cannot be made.
    """
    missing = [folder for folder in path.absolute().parents if not folder.exists()]
    for folder in reversed(missing):
        folder.mkdir(exist_ok=True)
        with suppress(OSError):  # `only_for_this_user` has closed it
            folder.chmod(stat.S_IMODE(folder.stat().st_mode) | (folder.parent.stat().st_mode & 0o777))


def opener(path: str, flags: int) -> int:
    """An opener for `open`: a file that is made by it is for this user only."""
    return os.open(path, flags, 0o600)


def private_text(path: Path) -> TextIO:
    """Open a text file for writing that is for this user only; half letters are written as escapes.

    Raises:
        OSError: it cannot be written.
    """
    number = opener(os.fspath(path), os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_CLOEXEC", 0))
    return os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace", newline="\n")


def close_to_others(path: Path) -> None:
    """Take away what others may do with a file or folder that an earlier version of the program has made."""
    with suppress(OSError):  # another user's
        mode = stat.S_IMODE(path.stat().st_mode)
        if os.name == "posix" and mode & _OTHERS:
            path.chmod(mode & ~_OTHERS)
