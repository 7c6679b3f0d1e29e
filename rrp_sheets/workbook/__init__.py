"""Workbooks: reading .xlsx, CSV and Markdown into one model, and making new .xlsx files.

Reading is `read`; opening, editing and writing files is in `files`, making in `maker` and `template`.
"""

import os

from rrp_sheets.workbook.reading import Reading, read, to_sheets

# With lxml openpyxl would write other bytes, so that a workbook made anew would differ from an older one.
os.environ.setdefault("OPENPYXL_LXML", "False")

__all__ = ["Reading", "read", "to_sheets"]
