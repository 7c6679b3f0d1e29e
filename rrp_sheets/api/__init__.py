"""Facade of the program for the command line, the web and notebooks.

>>> from rrp_sheets import api
>>> from rrp_sheets.resources import bundled
>>> api.check(bundled("workbooks", "simple-tracking.xlsx")).report.errors
[]
"""

from __future__ import annotations

from typing import Any

from rrp_sheets.api.pictures import draw, draw_marbles, draw_tests, explain, marbles, print_pack
from rrp_sheets.api.runs import export, pack, replay, run, run_apart, test
from rrp_sheets.api.workbooks import (
    check,
    convert,
    diff,
    diff_in_detail,
    edit,
    fix,
    formula,
    mark,
    new,
    pose,
    read,
    set_cell,
)

__all__ = [
    "RunSettings",
    "check",
    "convert",
    "diff",
    "diff_in_detail",
    "draw",
    "draw_marbles",
    "draw_tests",
    "edit",
    "explain",
    "export",
    "fix",
    "formula",
    "marbles",
    "mark",
    "new",
    "pack",
    "pose",
    "print_pack",
    "read",
    "replay",
    "run",
    "run_apart",
    "set_cell",
    "test",
]


def __getattr__(name: str) -> Any:
    """Load `RunSettings` on first use, so that callers who only check need not load the engine."""
    if name == "RunSettings":
        from rrp_sheets.runs import RunSettings

        return RunSettings
    raise AttributeError(name)
