"""Running workbooks, in this process (`run`) or in one of its own (`run_process`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.runs.run_data import RunResult, RunSettings, RunStart, Summary

if TYPE_CHECKING:
    from rrp_sheets.runs.running import run

__all__ = ["RunObserver", "RunResult", "RunSettings", "RunStart", "Summary", "run"]


def __getattr__(name: str) -> Any:
    """Load `run` on first use, so that callers who only watch need not load the engine."""
    if name == "run":
        from rrp_sheets.runs.running import run

        return run
    raise AttributeError(name)
