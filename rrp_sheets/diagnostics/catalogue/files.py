"""FILE…: the file as a whole cannot be read, or is refused."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E = Severity.ERROR
CODES = (
    Code("FILE001", _E, "File not found", "There is no file “{name}”.", "Check the spelling and the folder."),
)
