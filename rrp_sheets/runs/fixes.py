"""A corrected copy of a workbook; the original stays as it is."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.checks.fixing import Change, Chosen, apply_fixes
from rrp_sheets.devices import load_robot
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.copies import convert
from rrp_sheets.workbook import read
from rrp_sheets.workbook.atomic import write_atomically

_COPIED = (".xlsx", ".md", ".markdown")


def fix_copy(path: Path, target: Path, chosen: Chosen) -> tuple[list[Change], Checked]:
    """Make a copy in which all safe fixes are applied, and the chosen ones.

    Args:
        path: the workbook.
        target: the copy, an .xlsx or .md file; what has that name is replaced.
        chosen: by code, the number of the fix that is wanted of those that need a choice.

    Raises:
        SheetsError: when the copy would be the workbook itself, or cannot be written.
        UnreadableFile: when the workbook cannot be read.
    """
    read(path)  # whatever keeps it from being read is told about the file that the user named
    suffix = target.suffix.casefold()
    if suffix not in _COPIED:
        raise SheetsError(f"“{target.name}” is no name for the copy.", "Name an .xlsx file, or an .md file.")
    if target.exists() and target.resolve() == path.resolve():
        raise SheetsError("The copy would replace the workbook itself.", "Give the copy another name.")
    with TemporaryDirectory(prefix="rrp-fix-") as folder:
        work = Path(folder) / target.name
        if path.is_file() and path.suffix.casefold() == suffix:
            work.write_bytes(path.read_bytes())
        else:
            convert(path, load_robot(), work)
        changes, checked = apply_fixes(work, _check, chosen)
        write_atomically(target, work.read_bytes())
    return changes, checked


def _check(path: Path) -> Checked:
    reading = read(path)
    return check_workbook(reading.workbook, reading.report)
