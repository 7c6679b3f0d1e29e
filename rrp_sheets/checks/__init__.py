"""Everything that can be said about a workbook before it runs, in one pass (design: 4-streams, rules)."""

from rrp_sheets.checks.check import Checked, check_workbook

__all__ = ["Checked", "check_workbook"]
