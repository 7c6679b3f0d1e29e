"""A file that is made for one answer, in the folder for temporary files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from rrp_sheets.errors import SheetsError


def made(name: str, make: Callable[[Path], object]) -> BinaryIO:
    """A file that is written where `make` is told, open; it is gone when it is closed.

    Raises:
        SheetsError: what `make` says; when nothing can be written there, where that is.
    """
    with tempfile.TemporaryDirectory(prefix="rrp-sheets-") as folder:
        target = Path(folder) / name
        try:
            make(target)
        except SheetsError as error:
            if folder not in error.message:
                raise
            why = error.message.rpartition("(")[2].partition(")")[0] if "(" in error.message else ""
            raise SheetsError(
                f"There is no room for this file in “{Path(folder).parent}”, where files are made before they are "
                f"sent{f' ({why})' if why else ''}.",
                "Make room there, on the computer on which the program runs, and try again.",
            ) from None
        return target.open("rb")  # stays readable when its name is gone
