"""The catalogue of diagnostic codes: severity, title, message and remedy stand at the head of `pages/<CODE>.md`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from string import Formatter

from rrp_sheets.texts import LazyMessage

PAGES = Path(__file__).parent / "pages"
TOPICS = {
    "FILE": "The file", "SHEET": "What stands in the sheets", "CONN": "Connectors",
    "GRAPH": "Streams, and how rows are connected", "FORM": "Formulas and helpers", "DEV": "Devices",
    "SCENE": "The scene", "GEST": "Gestures", "TEST": "Tests", "LINT": "What is probably not meant",
    "PROT": "The Protocol sheet",
}  # fmt: skip
"""Subjects of the codes by their beginnings, in the catalogue's order. FORM101 and later are found by evaluating."""


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

    @property
    def parameters(self) -> frozenset[str]:
        """The names of the details that fill the templates."""
        return _places(self.message) | _places(self.remedy)

    def text(self, part: str, details: Mapping[str, object]) -> LazyMessage:
        """Return its `title`, `message` or `remedy` with details."""
        return LazyMessage(getattr(self, part), msgctxt=f"{self.id}.{part}", **details)

    @property
    def constant_remedy(self) -> str:
        """The remedy if it is the same for all details; else an empty text."""
        return "" if _places(self.remedy) else self.text("remedy", {})


@cache
def _places(template: str) -> frozenset[str]:
    return frozenset(name for _, name, _, _ in Formatter().parse(template) if name)


def _code(page: Path) -> Code:
    head = page.read_text(encoding="utf-8").partition("\n## ")[0]
    name, severity, message, remedy = head.strip().split("\n\n")
    code, _, title = name.removeprefix("# ").partition(": ")
    return Code(code, Severity(severity), title, message, remedy.removeprefix("→ "))


def _place(page: Path) -> tuple[int, str]:
    return [*TOPICS].index(page.stem.rstrip("0123456789")), page.stem


CODES: dict[str, Code] = {page.stem: _code(page) for page in sorted(PAGES.glob("*.md"), key=_place)}
