"""Form of the catalogue's entries: severity, title, and templates of message and remedy."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Severity(Enum):
    """Severity of a finding: an error keeps the workbook from running, a warning or information does not."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


@dataclass(frozen=True, slots=True)
class Code:
    """Entry of the catalogue: `message` and `remedy` are templates for `str.format`; the remedy says what to do."""

    id: str
    severity: Severity
    title: str
    message: str
    remedy: str
