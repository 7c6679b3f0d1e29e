"""Folder for the temporary files of a server and its processes: tables, bundles and prints to be sent.

Such files hold data of participants. A server that was killed leaves them behind; the next one that is
started on this computer removes them.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rrp_sheets.engine.file_lock import is_locked, locked

_PREFIX = "rrp-sheets-server-"
_NEW_S = 5  # so long may a server take from making its folder to holding it


@contextmanager
def scratch() -> Iterator[Path]:
    """Put the temporary files of this process and its children into a folder of their own during the block."""
    system = tempfile.gettempdir()
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as name, locked(Path(name)):
        if is_locked(Path(name)):  # else nobody can tell which of the others are in use
            _remove_abandoned(Path(system))
        before, tempfile.tempdir = tempfile.tempdir, name
        try:
            yield Path(name)
        finally:
            tempfile.tempdir = before


def _remove_abandoned(system: Path) -> None:
    """Remove the folders that servers of this user left behind."""
    limit = time.time() - _NEW_S
    for folder in system.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            about = folder.lstat()
            ours = stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid() and about.st_mtime < limit
            if ours and not is_locked(folder):
                shutil.rmtree(folder, ignore_errors=True)
