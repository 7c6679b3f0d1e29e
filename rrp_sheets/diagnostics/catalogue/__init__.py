"""The catalogue of diagnostic codes: stable id, severity, title, message, remedy. One file per topic."""

from rrp_sheets.diagnostics.catalogue import devices, files, formulas, graph, lints, sheets
from rrp_sheets.diagnostics.catalogue.code import Code, Severity

CODES: dict[str, Code] = {}
for _topic in (files, sheets, formulas, graph, devices, lints):
    for _code in _topic.CODES:
        assert _code.id not in CODES, f"two diagnostics are called {_code.id}"
        CODES[_code.id] = _code

__all__ = ["CODES", "Code", "Severity"]
