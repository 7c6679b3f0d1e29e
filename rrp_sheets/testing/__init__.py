"""Tests inside workbooks: what is sent when, and whether what must come out does (design: 7-exchange)."""

from rrp_sheets.testing.results import CaseResult, Event, RowResult
from rrp_sheets.testing.run import TestReport, run_tests

__all__ = ["CaseResult", "Event", "RowResult", "TestReport", "run_tests"]
