"""Tests inside workbooks: values are sent at given times, and what comes out is compared with what is expected."""

from rrp_sheets.testing.judge import CaseResult, Event, RowResult
from rrp_sheets.testing.run import TestReport, run_tests

__all__ = ["CaseResult", "Event", "RowResult", "TestReport", "run_tests"]
