"""Workbooks: reading .xlsx, CSV and Markdown into one model, and making new .xlsx files.

Reading is `read`; making is in `maker` and `template`, which are imported where they are needed.
"""

import os

from rrp_sheets.workbook.reading import Reading, read, to_sheets

# With lxml openpyxl would write other bytes, so that a workbook made anew would differ from an older one.
os.environ.setdefault("OPENPYXL_LXML", "False")

__all__ = ["Reading", "read", "to_sheets"]
