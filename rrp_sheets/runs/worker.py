"""Checking in a process of its own: formulas of strangers are evaluated on examples there, and never in a server.

One process is kept and used again, so that a check costs what it costs anywhere. It has a memory limit; one that does
not come to an end is ended, and what is told then is a finding like any other.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.runs.office import Office
from rrp_sheets.runs.wire import unpack_error, unpack_finding

CHECK_WITHIN = 20.0
"""Seconds for one check, the start of the process included; usually some hundredths."""


@dataclass(frozen=True)
class Findings:
    """What a check has found.

    Attributes:
        diagnostics: in the order of the sheets and cells.
        examples: an example of what each row gives, as shown, by the row's ref; missing where none is known.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    examples: Mapping[str, str] = field(default_factory=dict)


class CheckWorker:
    """Checks workbooks in a kept process; from any thread, one at a time. Close it at the end.

    Args:
        within: seconds for one check.
    """

    def __init__(self, within: float = CHECK_WITHIN) -> None:
        self._within = within
        self._lock = threading.Lock()
        self._office: Office | None = None

    def __enter__(self) -> CheckWorker:
        return self

    def __exit__(self, *ignored: object) -> None:
        self.close()

    def check(self, path: Path) -> Findings:
        """Read and check a workbook. A file that cannot be read, or a check that had to be ended, is one finding."""
        with self._lock:
            if self._office is None:
                self._office = Office()
            self._office.send("check", str(path.absolute()))
            try:
                kind, *rest = self._answer(self._office)
            except _Ended as ended:
                self._drop()
                return _alone(path, ended.why)
        if kind == "checked":
            findings, examples = rest
            return Findings(tuple(map(unpack_finding, findings)), examples)
        if kind == "failed":
            error = unpack_error(rest[0])
            if isinstance(error, UnreadableFile):
                found = Diagnostic(error.code, Severity.ERROR, None, error.message, error.remedy)
                return Findings((found,))
            raise error
        with self._lock:
            self._drop()  # what it holds in memory may be what was too much
        return _alone(path, "it needs more memory than a check may have")

    def _answer(self, office: Office) -> list[Any]:
        deadline = time.monotonic() + self._within
        while (left := deadline - time.monotonic()) > 0:
            messages = office.receive(left)
            if messages is None:
                raise _Ended(f"its process has ended unexpectedly{office.last_words()}")
            if messages:
                return messages[0]
        office.kill()
        raise _Ended(f"it did not come to an end within {self._within:g} s")

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        if self._office is not None:
            self._office.close()
            self._office = None


class _Ended(SheetsError):
    """The process is gone; `why` in words."""

    def __init__(self, why: str) -> None:
        super().__init__(why)
        self.why = why


def _alone(path: Path, why: str) -> Findings:
    report = Report()
    report.add("FILE018", None, name=path.name, why=why)
    return Findings(tuple(report))
