"""Codes about devices."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO
CODES: tuple[Code, ...] = ()
