"""What an entry of the catalogue is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Severity(Enum):
    """An error keeps the workbook from running; a warning is shown; information is only told."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


@dataclass(frozen=True, slots=True)
class Code:
    """An entry: `message` and `remedy` are templates for `str.format`; the remedy says what to do."""

    id: str
    severity: Severity
    title: str
    message: str
    remedy: str
