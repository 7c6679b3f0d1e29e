"""Worker process that exports, compares and deletes runs: `python -m rrp_sheets.runs.records.export_child LINK`.

Started by a `QueryWorker` only. Long requests here do not delay the pages that the other query worker answers.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rrp_sheets.runs.worker_loop import serve

PROGRAM = "rrp_sheets.runs.records.export_child"


def _export(runs: list[str], target: str) -> list[str]:
    from rrp_sheets.runs.records.exporting import export

    return export([Path(run) for run in runs], Path(target))


def _marbles(
    run: str, behaviour: str, rows: list[int], window: list[float | None], target: str
) -> list[str]:  # fmt: skip
    from rrp_sheets.runs.marbles import write_run_marbles

    return write_run_marbles(Path(run), behaviour, rows, (window[0], window[1]), Path(target))


def _pair(first: str, second: str) -> dict[str, Any]:
    from rrp_sheets.runs.records.table import pair

    return pair(Path(first), Path(second))


def _plan(folder: str, participant: str, names: list[str], going: list[str]) -> dict[str, Any]:
    from rrp_sheets.runs.records.deleting import plan

    return plan(Path(folder), participant, names, going).as_dict()


def _delete(
    folder: str, participant: str, names: list[str], going: list[str], expected: list[str], below: list[str]
) -> dict[str, Any]:
    """Delete only what was shown: if there is another run since then, nothing goes, and `deleted` is False."""
    from rrp_sheets.runs.records.deleting import delete, plan

    planned = plan(Path(folder), participant, names, going)
    same = sorted(planned.shown()) == sorted(expected)
    begun = delete(planned, going, below) if same else ()
    return {**planned.as_dict(), "deleted": same, "begun": list(begun)}


_DO: dict[str, Callable[..., Any]] = {
    "export": _export, "marbles": _marbles, "pair": _pair, "plan": _plan, "delete": _delete,
}  # fmt: skip


if __name__ == "__main__":
    serve(_DO)
