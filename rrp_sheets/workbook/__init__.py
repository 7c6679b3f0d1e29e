"""Workbooks: reading .xlsx, CSV and Markdown into one model, and making new .xlsx files.

Reading is `read`; making is in `maker` and `template`, which are imported where they are needed.
"""

from rrp_sheets.workbook.reading import Reading, read
from rrp_sheets.workbook.rows import to_sheets

__all__ = ["Reading", "read", "to_sheets"]
