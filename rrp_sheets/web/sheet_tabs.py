"""Row of tabs below a sheet: the existing sheets, and those that can be added."""

from __future__ import annotations

from rrp_sheets.documents import Document
from rrp_sheets.documents.sheet_edits import proposed_name
from rrp_sheets.web.pages import Addable, Strip, Tab
from rrp_sheets.workbook.template import SINGLE, TITLES

NAME = 200  # letters of a name that is looked at; those of a sheet are fewer, which is told
_HELP = {
    "behaviour": "what the robot does, one step a row",
    "devices": "names for sensors and actuators, with their settings",
    "helpers": "calculations and numbers for several formulas",
    "scene": "what happens in the simulator",
    "gestures": "movements of your own, as keyframes",
    "test": "values to send, and what must come out",
    "protocol": "what the session is for, and how it runs",
    "table": "a table of your own, for formulas",
}


def strip_of(document: Document, name: str, sheet: str, *, live: bool = False) -> Strip:
    """Build the row of tabs, with one sheet selected."""
    kinds = {n: g.kind for n, g in document.grids.items()} | dict.fromkeys(document.own, "")
    sheet = document.current(sheet)
    addable = () if live or document.read_only else tuple(_addable(kinds))
    return Strip(name, sheet, tuple(Tab(n, kind, n == sheet) for n, kind in kinds.items()), addable, live)


def _addable(kinds: dict[str, str]) -> list[Addable]:
    there = set(kinds.values())
    return [
        Addable(kind, title, _HELP[kind], proposed_name(kind, kinds))
        for kind, title in TITLES.items()
        if kind not in SINGLE or kind not in there
    ]
