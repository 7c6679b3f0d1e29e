"""What keeps a workbook from being changed at the moment, in words."""

from __future__ import annotations

import stat
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.atomic import refuse_open_file


def hindrance(path: Path) -> str:
    """Why edits of a workbook would be refused just now; empty when they would not."""
    try:
        refuse_open_file(path)
        mode = path.stat().st_mode
    except SheetsError as error:
        return f"{error.message} It can be looked at here, but not changed, so that nothing is lost. {error.remedy}"
    except OSError:
        return (
            f"“{path.name}” is not there any more: it was deleted, renamed or moved. What is shown here cannot be "
            "changed. Put it back, or go to the shelf."
        )
    if not path.is_dir() and not mode & stat.S_IWUSR:
        return (
            f"“{path.name}” is write-protected: it can be looked at here, but not changed. "
            "Take the protection off in the file's properties, or change a copy."
        )
    return ""
