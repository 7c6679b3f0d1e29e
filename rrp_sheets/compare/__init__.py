"""Comparison of two workbooks by their meaning, not by the places of rows and cells."""

from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.compare.compare import compare, compare_in_detail

__all__ = ["Change", "ComparedWorkbook", "Comparison", "compare", "compare_in_detail"]
