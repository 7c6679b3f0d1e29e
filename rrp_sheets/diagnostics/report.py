"""Diagnostics: each with code, cell, message and remedy; collected, never stopping at the first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from rrp_sheets.diagnostics.catalogue import CODES, Severity
from rrp_sheets.diagnostics.fix import Fix
from rrp_sheets.diagnostics.languages import told
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.diagnostics.proposals import proposed
from rrp_sheets.diagnostics.suppression import without_followers
from rrp_sheets.model.cells import Address


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding.

    Attributes:
        code: the catalogue's code.
        severity: of that code.
        address: the cell it belongs to; None for the whole file.
        message: what is wrong, in the user's words; a `Phrase`, which `languages.told` says in another language.
        remedy: what to do about it, likewise.
        span: first and last+1 character within the cell's text, where known.
        fixes: what would remove it, to choose from.
    """

    code: str
    severity: Severity
    address: Address | None
    message: str
    remedy: str
    span: tuple[int, int] | None = None
    fixes: tuple[Fix, ...] = field(default=(), compare=False)

    def in_language(self, language: str) -> Diagnostic:
        """The same with its texts in a language (`en`, `ja`)."""
        fixes = tuple(replace(fix, title=told(fix.title, language)) for fix in self.fixes)
        return replace(self, message=told(self.message, language), remedy=told(self.remedy, language), fixes=fixes)

    def as_dict(self) -> dict[str, Any]:
        """As `check --json` prints it."""
        return {
            "code": self.code,
            "severity": self.severity.value,
            "sheet": self.address.sheet if self.address else "",
            "cell": self.address.cell if self.address else "",
            "message": self.message,
            "remedy": self.remedy,
            "span": list(self.span) if self.span else None,
            "fixes": [{"title": f.title, "safe": f.safe} for f in self.fixes],
        }


class Report:
    """The diagnostics of one workbook, in the order of its sheets and cells.

    >>> report = Report(); _ = report.add("FILE001", None, name="x.xlsx", hint=""); report.flatten(["code", "cell"])
    [('FILE001', '')]
    """

    def __init__(self, diagnostics: Iterable[Diagnostic] = ()) -> None:
        self._found: dict[Diagnostic, None] = dict.fromkeys(diagnostics)  # in order, each once
        self._sheets: dict[str, int] = {}

    def order_by(self, sheets: Iterable[str]) -> None:
        """Let the findings follow the order of these sheets."""
        self._sheets = {name: i for i, name in enumerate(sheets)}

    def add(
        self,
        code: str,
        address: Address | None,
        *,
        span: tuple[int, int] | None = None,
        fixes: Iterable[Fix] = (),
        **details: object,
    ) -> Diagnostic:
        """Add a finding; `details` fill the catalogue's texts."""
        entry = CODES[code]
        message, remedy = Phrase(entry.message, **details), Phrase(entry.remedy, **details)
        diagnostic = Diagnostic(code, entry.severity, address, message, remedy, span,
                                tuple(fixes) or proposed(code, address, details, remedy))  # fmt: skip
        self._found[diagnostic] = None
        return diagnostic

    def extend(self, other: Iterable[Diagnostic]) -> None:
        """Add the findings of another report."""
        self._found.update(dict.fromkeys(other))

    def judge_fixes(self, judge: Callable[[Diagnostic, Fix], Fix]) -> None:
        """Let something that knows more of the workbook say anew whether fixes are safe."""
        for d in [d for d in self._found if d.fixes]:
            del self._found[d]
            self._found[replace(d, fixes=tuple(judge(d, fix) for fix in d.fixes))] = None

    def drop_followers(self) -> None:
        """Drop what only follows from another finding."""
        self._found = dict.fromkeys(without_followers(self._found))

    def _place(self, d: Diagnostic) -> tuple[int, str, int, int, str]:
        if d.address is None:
            return (-1, "", 0, 0, d.code)
        a = d.address
        return (self._sheets.get(a.sheet, len(self._sheets)), a.sheet, a.row, a.column, d.code)

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(sorted(self._found, key=self._place))

    def __len__(self) -> int:
        return len(self._found)

    @property
    def errors(self) -> list[Diagnostic]:
        """The findings that keep the workbook from running."""
        return [d for d in self if d.severity is Severity.ERROR]

    def flatten(self, fields: Iterable[str]) -> list[tuple[Any, ...]]:
        """The named entries of every finding, for tests: `report.flatten(["code", "cell"])`."""
        fields = list(fields)
        return [tuple(d.as_dict()[f] for f in fields) for d in self]
