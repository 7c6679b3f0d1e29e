"""First rows of empty sheets: what a row of each kind says, and an example that a click inserts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from rrp_sheets.documents.grid import Grid
from rrp_sheets.texts import N_


@dataclass(frozen=True, slots=True)
class FirstRow:
    """Invitation of an empty sheet: a sentence on its rows, and the label of the button that inserts an example.

    Attributes:
        cells: the example's texts by the number of the column, as JSON.
        templates: whether an example workbook can be taken instead.
    """

    about: str
    does: str
    cells: str
    templates: bool


_EXAMPLES: Mapping[str, tuple[str, str, Mapping[str, str]]] = {
    "behaviour": (
        N_("A row says what comes in, what is done with it, and where it goes."),
        N_("Insert an example: the head follows a red ball"),
        {"Input streams": "Red ball", "Connector": "subscribe", "Output stream": "Head tracker"},
    ),
    "devices": (
        N_("A row gives a sensor or an actuator of the robot a name."),
        N_("Insert an example: a button for the operator"),
        {"Stream": "Start", "Device": "Operator button"},
    ),
    "helpers": (
        N_("A row gives a number or a calculation a name, for several formulas."),
        N_("Insert an example: a distance called Reach"),
        {"Name": "Reach", "Formula": "0.5"},
    ),
    "scene": (
        N_("A row says what happens in the simulated room, and when."),
        N_("Insert an example: a red ball appears"),
        {"Time (s)": "1", "Thing": "Red ball", "Does": "appears", "Value": "at 1, 0, 0.4"},
    ),
    "test": (
        N_("A row sends a value, or says what must come out, and when."),
        N_("Insert an example: a ball one metre away"),
        {"Time (ms)": "0", "Stream": "Red ball", "Send": "distance=1"},
    ),
}


def first_row(grid: Grid | None) -> FirstRow | None:
    """Return what to show of a sheet without rows, comments aside; None for any other."""
    if grid is None or grid.kind not in _EXAMPLES or any(map(_is_row, grid.texts.values())):
        return None
    about, does, texts = _EXAMPLES[grid.kind]
    columns = {column.name: column.number for column in grid.columns}
    cells = {columns[name]: text for name, text in texts.items() if name in columns}
    return FirstRow(about, does, json.dumps(cells), templates=grid.kind == "behaviour")


def _is_row(texts: Mapping[int, str]) -> bool:
    return bool(texts) and not texts[min(texts)].lstrip().startswith("#")
