"""The errors that a user may see. Each says what is wrong and what to do; none is shown with a traceback."""

from __future__ import annotations


class SheetsError(Exception):
    """Something the user can mend: `message` says what is wrong, `remedy` what to do about it."""

    def __init__(self, message: str, remedy: str = "") -> None:
        super().__init__(f"{message} {remedy}".strip())
        self.message = message
        self.remedy = remedy


class UnreadableFile(SheetsError):
    """The file cannot be read as a workbook at all (missing, broken, refused). Exit code 2.

    `code` is the diagnostic's code, so that `check --json` can list it like any other finding.
    """

    def __init__(self, code: str, message: str, remedy: str = "") -> None:
        super().__init__(message, remedy)
        self.code = code


class MissingPart(SheetsError):
    """An optional part of the program (the simulator, say) is not installed here."""


class RunBroken(SheetsError):
    """A run broke off: the simulator died or a device failed. Exit code 3."""
