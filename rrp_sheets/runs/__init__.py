"""One run from the workbook to the folder that it leaves."""

from rrp_sheets.runs.run import RunResult, RunSettings, RunView, run

__all__ = ["RunResult", "RunSettings", "RunView", "run"]
