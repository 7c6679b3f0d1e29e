"""Two workbooks compared by what they mean, not by where it stands (design: 7-exchange, Compare)."""

from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.compare.compare import compare, compare_in_detail

__all__ = ["Change", "ComparedWorkbook", "Comparison", "compare", "compare_in_detail"]
