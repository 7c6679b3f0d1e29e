"""Temporary files that are created for one response."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from rrp_sheets.errors import SheetsError


def made(name: str, make: Callable[[Path], object]) -> BinaryIO:
    """Have `make` write a file, and return it open; it is deleted when it is closed.

    Raises:
        SheetsError: the error of `make`; if the temporary folder cannot be written, the message names it.
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
