"""Checking in a process of its own: formulas of strangers are evaluated on examples there, and never in a server.

One process is kept and used again, so that a check costs what it costs anywhere. It has a memory limit; one that does
not come to an end is ended, and what is told then is a finding like any other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.runs.wire import unpack_finding
from rrp_sheets.runs.worker_process import RestartingWorker, RunWorkerProcess, WorkerError

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
        self._worker = RestartingWorker(RunWorkerProcess)

    def __enter__(self) -> CheckWorker:
        return self

    def __exit__(self, *ignored: object) -> None:
        self.close()

    def check(self, path: Path) -> Findings:
        """Read and check a workbook. A file that cannot be read, or a check that had to be ended, is one finding."""
        try:
            findings, examples = self._worker.ask(["check", str(path.absolute())], self._within)
        except WorkerError as none:
            report = Report()
            report.add("FILE018", None, name=path.name, why=f"it {none.why}")
            return Findings(tuple(report))
        except UnreadableFile as error:
            return Findings((Diagnostic(error.code, Severity.ERROR, None, error.message, error.remedy),))
        return Findings(tuple(map(unpack_finding, findings)), examples)

    def close(self) -> None:
        """End the process."""
        self._worker.close()
