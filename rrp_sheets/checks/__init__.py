"""Checks of a workbook before it runs, all in one pass."""

from rrp_sheets.checks.check import Checked, check_workbook

__all__ = ["Checked", "check_workbook"]
