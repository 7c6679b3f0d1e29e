"""A fix that changes several sheets is one edit: made together, told for each sheet, taken back as one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.report import Delete, Fix, Insert, Put, Replace
from rrp_sheets.documents import Document, Refused
from rrp_sheets.documents.document import Journal
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model.workbook import Address
from rrp_sheets.web.analysis import Analysis, no_analysis
from rrp_sheets.web.views.sheet import make_fix
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]


@pytest.fixture
def document(tmp_path: Path) -> Document:
    rows = [["Gaze", "map", "gaze * far", "A"], ["A", "subscribe", "", "Print"]]
    sheets = {"T": [HEADER, *rows], "Devices": [["Stream", "Device"], ["Ball", "Red ball"]]}
    make_workbook(sheets, tmp_path / "b.xlsx")
    return Document(tmp_path / "b.xlsx", Journal(tmp_path))


def look_with(fix: Fix) -> Analysis:
    """Analysis of a check that offers one fix."""
    return replace(no_analysis(), findings=(replace(FOUND, fixes=(fix,)),))


def texts(document: Document) -> dict[str, list[list[str]]]:
    """The filled rows of the sheets."""
    return {
        name: [list(grid.texts[row].values()) for row in grid.rows if grid.texts[row]]
        for name, grid in document.grids.items()
    }


FOUND = Diagnostic("GRAPH001", Address("T", 2, 1), {"name": "Gaze", "remedy": ""})
FIX = Fix(
    "declare",
    "Declare Gaze",
    (
        Insert("Devices", 2, ((1, "Gaze"), (2, "Head yaw"))), Replace(Address("T", 2, 3), "far", "0.5"),
        Insert("T", 3, ((1, "A"), (2, "sample"), (3, "1 s"), (4, "B"))), Put(Address("T", 4, 1), "B"),
    ),
)  # fmt: skip
ASKED = {"finding": FOUND.id, "fix": "declare"}


def test_a_row_bears_the_flag_of_its_first_finding_which_is_an_error() -> None:
    details = {"first": "a", "second": "b", "name": "x", "stream": "s", "hz": 1, "period": "1 s", "remedy": ""}
    found = Report(
        Diagnostic(code, Address("T", row, column), details)
        for code, row, column in [("LINT002", 2, 1), ("GRAPH001", 2, 3), ("LINT002", 3, 4)]
    )
    analysis = replace(no_analysis(), findings=tuple(found))
    assert analysis.flags(BehaviourGraph("T", "t", ())) == {2: 1, 3: 3}


def test_a_fix_of_two_sheets_is_made_and_taken_back_as_one(document: Document) -> None:
    before = texts(document)
    changed = make_fix(document, look_with(FIX), "Aya", ASKED)
    assert [c.sheet for c in (changed, *changed.then)] == ["Devices", "T", "T", "T"]
    assert texts(document) == {
        "T": [["Gaze", "map", "gaze * 0.5", "A"], ["A", "sample", "1 s", "B"], ["B", "subscribe", "Print"]],
        "Devices": [["Gaze", "Head yaw"], ["Ball", "Red ball"]],
    }
    behaviour = read(document.path).workbook.behaviours[0]
    assert [r.connector.text for r in behaviour.rows] == ["map", "sample", "subscribe"]
    back = document.undo("Aya")
    assert back is not None and {c.sheet for c in (back, *back.then)} == {"T", "Devices"}
    assert texts(document) == before and document.undo("Aya") is None
    document.undo("Aya", redo=True)
    assert texts(document)["Devices"][0] == ["Gaze", "Head yaw"]


def test_a_fix_of_a_sheet_that_is_not_there_changes_nothing(document: Document) -> None:
    before = document.path.read_bytes()
    fix = replace(FIX, edits=(*FIX.edits, Insert("Helpers", 2, ((1, "far"),))))
    with pytest.raises(Refused, match="There is no sheet “Helpers”"):
        make_fix(document, look_with(fix), "Aya", ASKED)
    fix = replace(FIX, edits=(*FIX.edits, Put(Address("T", 900, 1), "x")))
    with pytest.raises(Refused, match="no longer what the check says"):
        make_fix(document, look_with(fix), "Aya", ASKED)
    assert document.path.read_bytes() == before


def test_a_fix_deletes_rows_and_an_undo_brings_them_back(document: Document) -> None:
    before = texts(document)
    gone = replace(FIX, edits=(Delete("T", 3), Delete("T", 2)))
    make_fix(document, look_with(gone), "Aya", ASKED)
    assert texts(document)["T"] == before["T"][2:]
    document.undo("Aya")
    assert texts(document) == before
    with pytest.raises(Refused, match="no longer what the check says"):
        make_fix(document, look_with(replace(FIX, edits=(Delete("T", 900),))), "Aya", ASKED)


def test_undo_tells_which_cells_it_has_changed(document: Document) -> None:
    make_fix(document, look_with(replace(FIX, edits=FIX.edits[1:2])), "Aya", ASKED)
    back = document.undo("Aya")
    assert back is not None and back.cells == ((document.grids["T"].rows[0], 3),)


def test_a_fix_adds_a_column_to_the_devices_and_an_undo_takes_it_away(document: Document) -> None:
    before = texts(document)
    fix = Fix("language", "", (Put(Address("Devices", 1, 3), "Language"), Put(Address("Devices", 2, 3), "ja")))
    changed = make_fix(document, look_with(fix), "Aya", {**ASKED, "fix": "language"})
    assert changed.change is not None and changed.change.what == "reshaped"
    assert texts(document)["Devices"] == [["Ball", "Red ball", "ja"]]
    assert read(document.path).workbook.devices[0].settings["language"].text == "ja"
    document.undo("Aya")
    assert texts(document) == before and [c.header for c in document.grids["Devices"].columns] == ["Stream", "Device"]
    assert "language" not in read(document.path).workbook.devices[0].settings
    with pytest.raises(Refused, match="header of this column"):
        fix = replace(fix, edits=(Put(Address("T", 1, 4), "Notes"),))
        make_fix(document, look_with(fix), "Aya", {**ASKED, "fix": "language"})


def test_a_fix_leads_to_the_cell_that_is_to_be_filled_in(document: Document) -> None:
    sheet, fill = "Devices", Address("Devices", 3, 3)
    edits = (Put(Address(sheet, 1, 3), "Text"), Insert(sheet, 3, ((1, "Ask"), (2, "Say parameter"))))
    changed = make_fix(document, look_with(Fix("declare", "", edits, fill=fill)), "Aya", ASKED)
    assert changed.sheet == sheet and changed.heads == ((3, "Text"),)
    assert changed.cursor == (document.grids[sheet].rows[1], 3)
    back = document.undo("Aya")
    assert back is not None and [c.heads for c in (back, *back.then)] == [(), ((3, ""),)]
