"""Diagnostics of a workbook: a catalogue of codes, and the findings reported under them."""

from rrp_sheets.diagnostics.catalogue import CODES, Code, Severity
from rrp_sheets.diagnostics.report import Diagnostic, Report

__all__ = ["CODES", "Code", "Diagnostic", "Report", "Severity"]
