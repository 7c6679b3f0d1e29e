"""The tutorial: a workbook of ten lessons, each with a test that holds when it is done. Everyone works in a copy."""

from __future__ import annotations

import re
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_
from rrp_sheets.workbook.atomic import write_atomically

NAME = "tutorial.xlsx"
_COPY = re.compile(r"tutorial(?: \(\d+\))?\.xlsx")
_MOST = 1_000  # copies in one folder


def latest(folder: Path) -> Path | None:
    """The copy in a folder that was changed last; None when there is none.

    Raises:
        SheetsError: when the folder cannot be read.
    """
    try:
        found = [(path.stat().st_mtime_ns, path) for path in folder.iterdir() if _COPY.fullmatch(path.name)]
    except OSError as error:
        raise SheetsError(
            N_("The folder {folder} cannot be read: {why}.", folder=str(folder), why=str(error.strerror)),
            N_("Take another folder."),
        ) from error
    return max(found)[1] if found else None


def begin(folder: Path) -> Path:
    """Make a fresh copy in a folder; copies that are there stay as they are.

    Raises:
        SheetsError: when it cannot be written.
    """
    fresh = bundled("templates", "workbooks", NAME).read_bytes()
    for count in range(1, _MOST):
        path = folder / (NAME if count == 1 else f"tutorial ({count}).xlsx")
        if not path.exists():
            write_atomically(path, fresh, replace=False)
            return path
    raise SheetsError(
        N_("There are too many copies of the tutorial in this folder."), N_("Delete those that are done.")
    )
