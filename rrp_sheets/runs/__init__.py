"""One run from the workbook to the folder that it leaves; here (`run`), or in a process of its own (`run_process`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rrp_sheets.runs.view import RunResult, RunSettings, RunStart, RunView, Summary

if TYPE_CHECKING:
    from rrp_sheets.runs.running import run

__all__ = ["RunResult", "RunSettings", "RunStart", "RunView", "Summary", "run"]


def __getattr__(name: str) -> Any:
    """`run`, without loading the engine for those who only watch."""
    if name == "run":
        from rrp_sheets.runs.running import run

        return run
    raise AttributeError(name)
