"""Sheets of a workbook under edit: one edit and one undo each, several people, Excel meanwhile, a killed server."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from lossless import parts
from test_sheets import same

from rrp_sheets import api
from rrp_sheets.documents import CellText, Document, Refused
from rrp_sheets.documents.document import Journal
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.workbook import read
from rrp_sheets.workbook.edits import AddSheet, DeleteSheet, RenameSheet, SetCell
from rrp_sheets.workbook.files import edit, make_workbook, read_sheets

HEAD = ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"]
SHEETS = {
    "Look": [HEAD, ["Red ball", "map", "INDEX(Parts[Say]; 1)", "Words"], ["Words", "subscribe", "", "Say"]],
    "Switch": [HEAD, ["Red ball", "subscribe", "", "Stop looking"]],
    "Devices": [["Stream", "Device", "Name", "State"], ["Stop looking", "Behaviour", "look", "Off"]],
    "Check": [["Time (ms)", "Stream", "Send", "Expect"], ["0", "Red ball", "", ""], ["0", "Look!Words", "", "Hello"]],
    "Protocol": [["Field", "Value"], ["Run", "Look, Switch"]],
    "Parts": [["Say", "Parts"], ["Hello", "1"]],
}


@pytest.fixture(scope="module")
def pattern(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workbook(SHEETS, tmp_path_factory.mktemp("pattern") / "b.xlsx")


@pytest.fixture
def document(pattern: Path, tmp_path: Path) -> Document:
    shutil.copy(pattern, tmp_path / "b.xlsx")
    return Document(tmp_path / "b.xlsx", Journal(tmp_path))


def errors(path: Path) -> list[str]:
    return [d.code for d in api.check(path).report.errors]


def test_everything_that_names_a_sheet_follows_it_and_goes_back_with_one_undo(document: Document) -> None:
    path = document.path
    assert errors(path) == []
    first = {s.name: {at: c.text for at, c in s.cells.items()} for s in read_sheets(path)}
    document.sheets.rename("Aya", "Look", "Watch the ball")
    document.sheets.rename("Aya", "Parts", "My texts")
    book = read(path).workbook
    assert book.protocol.text("Run") == "Watch the ball, Switch"
    assert book.tests[0].rows[1].stream.text == "Watch the ball!Words"
    assert book.devices[0].settings["name"].text == "Watch the ball"
    assert book.behaviours[0].rows[0].formula.text == "INDEX(myTexts[Say]; 1)"
    assert errors(path) == []
    document.undo("Aya")
    document.undo("Aya")
    assert {s.name: {at: c.text for at, c in s.cells.items()} for s in read_sheets(path)} == first
    document.undo("Aya", redo=True)
    assert [b.name for b in read(path).workbook.behaviours] == ["Watch the ball", "Switch"] and errors(path) == []


def test_a_page_that_knows_the_old_name_only_loses_nothing(document: Document) -> None:
    row = document.grids["Look"].rows[0]
    document.sheets.rename("Mika", "Look", "Watch")
    document.set_cells("Aya", "Look", [CellText(row, 6, "typed meanwhile")])
    assert read(document.path).workbook.behaviours[0].rows[0].notes == "typed meanwhile"
    assert document.grids["Watch"].rows[0] == row and document.current("Look") == "Watch"
    document.undo("Aya")
    document.sheets.add("Kai", "behaviour", "Look")  # now that name means another sheet
    with pytest.raises(Refused, match="has been deleted"):
        document.set_cells("Aya", "Look", [CellText(row, 6, "too late")])


def test_a_new_behaviour_runs_and_is_taken_back_whole(document: Document) -> None:
    before = parts(document.path)
    document.sheets.add("Aya", "behaviour")
    assert list(document.grids)[:3] == ["Look", "Switch", "Behaviour 3"]
    assert read(document.path).workbook.protocol.text("Run") == "Look, Switch, Behaviour 3"
    assert [c.header for c in document.grids["Behaviour 3"].columns] == HEAD
    document.undo("Aya")
    assert read(document.path).workbook.protocol.text("Run") == "Look, Switch"
    now = parts(document.path)
    assert {p for p in before if not same(p, before[p], now[p])} <= {"xl/worksheets/sheet5.xml", "docProps/app.xml"}
    assert now.keys() == before.keys()


def test_only_one_is_offered_of_what_there_is_one(document: Document) -> None:
    with pytest.raises(Refused, match="“Devices” already"):
        document.sheets.add("Aya", "devices")
    with pytest.raises(Refused, match="such kind"):
        document.sheets.add("Aya", "macro")
    with pytest.raises(Refused, match="make a sheet the protocol"):
        document.sheets.add("Aya", "table", "", [["Field", "Value"]])
    with pytest.raises(Refused, match="stands between names"):
        document.sheets.rename("Aya", "Look", "Look, and say")


def test_a_deleted_sheet_comes_back_with_its_rows_and_what_others_did(document: Document) -> None:
    path, rows = document.path, list(document.grids["Look"].rows)
    before = parts(path)
    assert document.sheets.naming("Look") == [
        "Check!B3: Look!Words", "Devices!C2: look", "Protocol!B2: Look, Switch"
    ]  # fmt: skip
    document.sheets.delete("Aya", "Look")
    assert read(path).workbook.protocol.text("Run") == "Switch"
    switch = document.grids["Switch"].rows[0]
    document.set_cells("Mika", "Switch", [CellText(switch, 6, "by Mika")])
    document.undo("Aya")
    assert document.grids["Look"].rows[:2] == rows[:2] and errors(path) == []
    assert parts(path)["xl/worksheets/sheet1.xml"] == before["xl/worksheets/sheet1.xml"]
    assert read(path).workbook.behaviours[1].rows[0].notes == "by Mika"
    document.set_cells("Mika", "Look", [CellText(rows[0], 6, "new")])
    with pytest.raises(Refused, match="changed since by Mika"):
        document.undo("Aya", redo=True)
    document.undo("Mika")
    document.undo("Aya", redo=True)
    assert "Look" not in document.grids


def test_a_table_that_was_added_can_be_filled_in_before_a_formula_names_it(document: Document) -> None:
    document.sheets.add("Aya", "table", "Steps", [["Step", "Ask"]])
    document.sheets.rename("Aya", "Steps", "My steps")
    grid = document.grids["My steps"]
    lines = [CellText(grid.rows[i], 1, str(i)) for i in range(20)]
    document.set_cells("Aya", "My steps", lines)
    document.insert("Aya", "My steps", None, 20)
    document.set_cells("Aya", "My steps", [CellText(grid.rows[30], 2, "far down")])
    again = Document(document.path, Journal(document.path.parent))
    assert again.grids["My steps"].text(again.grids["My steps"].rows[30], 2) == "far down"
    document.sheets.duplicate("Aya", "My steps")
    assert document.grids["My steps 2"].text(document.grids["My steps 2"].rows[30], 2) == "far down"


def test_what_excel_does_to_sheets_meanwhile_is_taken_over(document: Document) -> None:
    edit(document.path, [RenameSheet("Switch", "Turn off"), AddSheet("Other", [HEAD], "Devices")])
    assert document.poll()
    assert [*document.grids] == ["Look", "Turn off", "Other", "Devices", "Check", "Protocol", "Parts"]
    with pytest.raises(Refused, match="no sheet “Switch”"):
        document.sheets.delete("Aya", "Switch")
    document.sheets.delete("Aya", "Other")
    edit(document.path, [SetCell("Look", 9, 6, "by another program")])
    document.undo("Aya")
    assert "Other" in document.grids and read_sheets(document.path)[0].cells[9, 6].text == "by another program"


@pytest.mark.slow
@pytest.mark.parametrize("what", ["add", "rename", "delete", "bring"])
def test_a_server_that_was_killed_in_between_stores_it_when_it_starts(
    document: Document, what: str, monkeypatch
) -> None:
    """The edit is in the journal and not yet in the file, which is where a killed server leaves it."""
    if what == "bring":
        document.sheets.delete("Aya", "Check")

    class Killed(BaseException):
        pass

    def die(*_args: object, **_options: object) -> None:
        raise Killed

    monkeypatch.setattr("rrp_sheets.documents.document.edit", die)
    does = {
        "add": lambda: document.sheets.add("Aya", "test"), "rename": lambda: document.sheets.rename("Aya", "Look", "Watch"),
        "delete": lambda: document.sheets.delete("Aya", "Look"), "bring": lambda: document.undo("Aya"),
    }[what]  # fmt: skip
    with pytest.raises(Killed):
        does()
    monkeypatch.undo()
    again = Document(document.path, Journal(document.path.parent))
    names = [s.name for s in read_sheets(again.path)]
    run = read(again.path).workbook.protocol.text("Run")
    expected = {"add": "Test 2" in names, "rename": run == "Watch, Switch" and "Watch" in names,
                "delete": run == "Switch" and "Look" not in names, "bring": "Check" in names}  # fmt: skip
    assert expected[what] and not Journal(document.path.parent).waiting("b.xlsx")


@pytest.mark.slow
def test_versions_and_comparing_know_sheets_that_came_and_went(document: Document, tmp_path: Path) -> None:
    document.keep_version("Aya", "before")
    document.sheets.delete("Aya", "Check")
    document.sheets.add("Aya", "behaviour", "Greeting")
    document.sheets.add("Aya", "table", "Steps", [["Step", "Ask"]])
    (version,) = document.file.versions()
    old = tmp_path / "old.xlsx"
    old.write_bytes(document.file.version_content(version.id) or b"")
    told = {(c.kind, c.sheet or c.name) for c in api.diff(old, document.path).changes}
    assert {("removed", "Check"), ("added", "Greeting"), ("added", "Steps")} <= told
    document.restore("Aya", version.id)
    assert [*document.grids] == ["Look", "Switch", "Devices", "Check", "Protocol", "Parts"]
    edit(document.path, [DeleteSheet("Devices")])
    assert ("removed", "Devices") in {(c.kind, c.sheet or c.name) for c in api.diff(old, document.path).changes}


@pytest.mark.slow
def test_undo_on_a_deleted_sheet_is_refused_and_kept(document: Document) -> None:
    document.sheets.move("Aya", "Parts", "Look")
    document.sheets.rename("Ben", "Switch", "Off")
    document.sheets.delete("Cem", "Off")
    deleted = document.undo("Cem")
    assert deleted is not None
    document.sheets.delete("Cem", "Parts")
    for _ in range(2):
        with pytest.raises(Refused, match="It waits until somebody restores the sheet"):
            document.undo("Aya")
    document.undo("Cem")
    document.undo("Aya")
    assert list(document.reading.workbook.sheets)[-1] == "Parts"
    document.sheets.delete("Cem", "Off")
    with pytest.raises(Refused, match="no sheet “Off”"):
        document.undo("Ben")
    with pytest.raises(Refused, match="no sheet “Nowhere”"):
        document.sheets.move("Aya", "Nowhere", "")


def test_steps_on_a_deleted_sheet_do_not_keep_the_earlier_ones_from_being_undone(document: Document) -> None:
    look, switch = document.grids["Look"], document.grids["Switch"]
    was = look.text(look.rows[0], 6)
    document.set_cells("Aya", "Look", [CellText(look.rows[0], 6, "kept", was)])
    for text in "one", "two", "three":
        row = switch.rows[0]
        document.set_cells("Aya", "Switch", [CellText(row, 6, text, switch.text(row, 6))])
    document.sheets.delete("Cem", "Switch")
    with pytest.raises(Refused, match="no sheet “Switch”"):
        document.undo("Aya")
    document.undo("Aya")
    assert document.grids["Look"].text(look.rows[0], 6) == was
    document.undo("Cem")
    for text in "two", "one", "":  # those that waited are in their order
        document.undo("Aya")
        switch = document.grids["Switch"]
        assert switch.text(switch.rows[0], 6) == text
    assert document.undo("Aya") is None


def test_a_step_is_kept_when_the_file_cannot_be_taken_over(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    look = document.grids["Look"]
    document.set_cells("Aya", "Look", [CellText(look.rows[0], 6, "mine")])
    edit(document.path, [SetCell("Look", 3, 6, "theirs")])

    def fails(*_: object) -> None:
        raise UnreadableFile("FILE002", "It is being written.")

    with monkeypatch.context() as patch, pytest.raises(UnreadableFile):
        patch.setattr(document.file, "whole", fails)
        document.undo("Aya")
    document.undo("Aya")
    assert document.grids["Look"].text(document.grids["Look"].rows[0], 6) == ""


def test_undo_of_a_move_finds_the_neighbour_by_its_new_name(document: Document) -> None:
    first = list(document.reading.workbook.sheets)
    document.sheets.move("Aya", "Look", "")
    document.sheets.rename("Ben", "Switch", "Off")
    document.undo("Aya")
    assert list(document.reading.workbook.sheets) == [{"Switch": "Off"}.get(name, name) for name in first]


def test_undo_of_a_deletion_restores_the_run_of_a_renamed_protocol(document: Document) -> None:
    document.sheets.delete("Aya", "Switch")
    document.sheets.rename("Ben", "Protocol", "Study")
    document.undo("Aya")
    assert read(document.path).workbook.protocol.text("Run") == "Look, Switch"


def test_undo_that_cannot_read_the_file_is_kept(document: Document) -> None:
    document.sheets.move("Aya", "Parts", "Look")
    content = document.path.read_bytes()
    document.path.write_bytes(b"no workbook")
    with pytest.raises(UnreadableFile):
        document.undo("Aya")
    document.path.write_bytes(content)
    document.undo("Aya")
    assert list(document.reading.workbook.sheets)[-1] == "Parts"
