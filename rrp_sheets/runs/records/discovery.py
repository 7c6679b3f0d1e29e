"""The folders below a folder that have runs of their own: a study is often sorted into sub-folders."""

from __future__ import annotations

import os
import time
from pathlib import Path

from rrp_sheets.runs.records.metadata import RUNS

_LIBRARIES = "node_modules"
_MOST_FOLDERS = 50_000
_MOST_SECONDS = 10.0


def is_software(root: str, name: str) -> bool:
    """Whether a folder holds installed software: it would take all the time, and nothing of ours lies there."""
    return name == _LIBRARIES or Path(root, name, "pyvenv.cfg").is_file()


def folders_below(folder: Path) -> tuple[list[Path], bool]:
    """The folders below a folder that have a `runs`, in the order of their names, and whether everything was looked at.

    No link is followed, and nothing is looked for within runs.
    """
    deadline = time.monotonic() + _MOST_SECONDS
    found: list[Path] = []
    for number, (root, folders, _) in enumerate(os.walk(folder)):
        if number >= _MOST_FOLDERS or time.monotonic() > deadline:
            return found, False
        runs = Path(root, RUNS)
        if RUNS in folders and not runs.is_symlink():
            folders.remove(RUNS)
            if number:
                found.append(Path(root))
        folders[:] = sorted(n for n in folders if not is_software(root, n))
    return found, True
