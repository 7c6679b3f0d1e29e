"""Checks of workbooks in worker processes, for who evaluates no formula itself: a server, and whoever ends a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import WORKBOOK
from rrp_sheets.model.values import show
from rrp_sheets.private import only_for_this_user
from rrp_sheets.texts import N_
from rrp_sheets.workers.codec import unpack
from rrp_sheets.workers.worker_loop import lift_limit
from rrp_sheets.workers.worker_process import RestartingWorker, WorkerClosed, WorkerError

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.checks.renaming import Renaming
    from rrp_sheets.workbook import Reading

CHECK_WITHIN = 20.0
"""Seconds for one check, the start of the process included; usually some hundredths."""


@dataclass(frozen=True)
class Findings:
    """Findings of a check, with examples of the rows' values.

    Attributes:
        diagnostics: errors first, in the order of the sheets and cells.
        examples: an example of what each row gives, as shown, by the row's ref; missing where none is known.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    examples: Mapping[str, str] = field(default_factory=dict)


class CheckWorker:
    """Checker of workbooks in a kept process, from any thread, one at a time; a check may take `within` seconds."""

    def __init__(self, within: float = CHECK_WITHIN) -> None:
        self._within = within
        self._worker = RestartingWorker()

    def __enter__(self) -> CheckWorker:
        return self

    def __exit__(self, *ignored: object) -> None:
        self.close()

    def check(self, path: Path) -> Findings:
        """Read and check a workbook. A file that cannot be read, or a check that had to be ended, is one finding."""
        try:
            return unpack(Findings, self._worker.ask([f"{__name__}.check_file", str(path.absolute())], self._within))
        except UnreadableWorkbook as error:
            return Findings((error.finding,))
        except WorkerClosed:
            raise
        except SheetsError as error:  # too many open files are one as well
            report = Report()
            why = N_("it {why}", why=error.why) if isinstance(error, WorkerError) else error.message.rstrip(".")
            report.add("FILE018", None, name=path.name, why=why)
            return Findings(tuple(report))

    def rename(self, path: Path, old: str, new: str, near: str) -> Renaming:
        """Return the edits that give a stream or a helper another name; see `renaming.rename`, also for errors."""
        from rrp_sheets.checks.renaming import Renaming

        request = [f"{__name__}.rename_in_file", str(path.absolute()), old, new, near]
        return unpack(Renaming, self._worker.ask(request, self._within))

    def rename_column(self, path: Path, table: str, old: str, new: str, headers: Sequence[str]) -> Renaming:
        """Return the edits that give a column of a table another name; see `table_columns.rename_column`."""
        from rrp_sheets.checks.renaming import Renaming

        request = [f"{__name__}.rename_column_in_file", str(path.absolute()), table, old, new, *headers]
        return unpack(Renaming, self._worker.ask(request, self._within))

    def close(self) -> None:
        """End the process."""
        self._worker.close()


# ---- in the worker process
def check_file(path: str) -> Findings:
    """Read and check a workbook."""
    _, checked = read_and_check(Path(path))
    return Findings(tuple(checked.report), _examples(checked))


def rename_in_file(path: str, old: str, new: str, near: str) -> Renaming:
    """Return the edits that give a stream or a helper of a workbook another name."""
    from rrp_sheets.checks.renaming import rename

    return rename(read_and_check(Path(path))[1], old, new, near=near)


def rename_column_in_file(path: str, table: str, old: str, new: str, *headers: str) -> Renaming:
    """Return the edits outside of a table's sheet that give one of its columns another name."""
    from rrp_sheets.checks.table_columns import rename_column

    return rename_column(read_and_check(Path(path))[1], table, old, new, headers)


def read_and_check(path: Path) -> tuple[Reading, Checked]:
    """Read a workbook, and check it."""
    from rrp_sheets.checks import check_workbook
    from rrp_sheets.workbook import read

    reading = read(path)
    return reading, check_workbook(reading.workbook, reading.report)


def _examples(checked: Checked) -> dict[str, str]:
    """Return an example of each row's value as shown, by the row's ref; in brackets if a filter would stop it."""
    from rrp_sheets.checks.check import row_examples

    found = {}
    for ref, fact in row_examples(checked).items():
        number = isinstance(fact.example, (int, float)) and not isinstance(fact.example, bool)
        text = f"{show(fact.example)} {fact.known.unit if number else ''}".rstrip()
        found[ref] = text if fact.sure else f"({text})"
    return found


def finish_run(folder: str) -> tuple[dict[str, str], tuple[str, ...]]:
    """Write the table and the diagram of a run whose process has been ended; see `finish_folder`."""
    from rrp_sheets.recording.folder import finish_folder

    only_for_this_user()
    _, checked = read_and_check(Path(folder) / WORKBOOK)
    lift_limit()
    return finish_folder(Path(folder), checked)
