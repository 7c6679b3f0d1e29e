"""Comments and looks of cells in a document under edit: several people, rows that come back, a server that is killed."""

from __future__ import annotations

from pathlib import Path

import pytest

from rrp_sheets.documents import CellText, Document, Refused
from rrp_sheets.documents.document import Journal
from rrp_sheets.workbook.comments import Comment, Thread, new_id, removed, replied, resolved, rewritten
from rrp_sheets.workbook.edits import SetComments, SetLook
from rrp_sheets.workbook.files import make_workbook, write_sheets
from rrp_sheets.workbook.looks import Look

ROWS = [["From", "Operator", "Parameter", "To"], ["a", "map", "1", "b"], ["b", "map", "2", "c"], ["c", "map", "3", "d"]]
AT = "2026-11-02T09:05:00Z"


@pytest.fixture
def document(tmp_path: Path) -> Document:
    return Document(make_workbook({"T": ROWS}, tmp_path / "x.xlsx"), Journal(tmp_path))


def say(document: Document, author: str, place: int, column: int, text: str) -> None:
    new = Comment(new_id(), author, AT, text)
    document.comment(author, "T", document.grids["T"].rows[place], column, lambda now: replied(now, new))


def said(document: Document) -> dict[tuple[int, int], list[str]]:
    """The comments in the file, which are those in the grid."""
    found = {(number, column): [c.text for c in thread] for _, number, column, _, thread in document.comments()}
    grid = document.grids["T"]
    marks = grid.marks.of(grid.rows)
    assert {(grid.number(r), c): [x.text for x in thread] for r, c, thread, _ in marks if thread} == found
    return found


def first(thread: Thread) -> str:
    return thread[0].id


def test_each_persons_undo_takes_back_only_their_own_comment(document: Document) -> None:
    say(document, "A", 0, 1, "one")
    say(document, "B", 0, 1, "two")
    say(document, "A", 0, 1, "three")
    document.undo("B")
    assert said(document) == {(2, 1): ["one", "three"]}
    document.undo("B", redo=True)
    assert said(document) == {(2, 1): ["one", "two", "three"]}
    document.undo("A")
    with pytest.raises(Refused, match="B has replied"):
        document.undo("A")
    assert said(document) == {(2, 1): ["one", "two"]}


def test_a_comment_is_changed_by_its_author_alone(document: Document) -> None:
    say(document, "A", 0, 1, "one")
    row, grid = document.grids["T"].rows[0], document.grids["T"]
    id = first(grid.marks.thread(row, 1))
    for change in (lambda now: rewritten(now, id, "B", "mine"), lambda now: removed(now, id, "B")):
        with pytest.raises(Exception, match="This comment is by A"):
            document.comment("B", "T", row, 1, change)
    document.comment("B", "T", row, 1, lambda now: resolved(now, done=True))
    document.comment("A", "T", row, 1, lambda now: rewritten(now, id, "A", "uno"))
    assert grid.marks.thread(row, 1)[0].done
    document.undo("B")
    thread = grid.marks.thread(row, 1)
    assert (thread[0].text, thread[0].done) == ("uno", False)


def test_rows_that_come_back_have_their_comments_and_looks(document: Document) -> None:
    grid = document.grids["T"]
    rows = list(grid.rows)
    say(document, "A", 1, 3, "about 2")
    document.set_looks("A", "T", [(rows[1], 1), (rows[0], 2)], {"bold": True, "fill": "FFF2CC"})
    document.delete("A", "T", rows[1:3])
    assert said(document) == {}
    document.undo("A")
    assert said(document) == {(3, 3): ["about 2"]}
    assert grid.marks.look(rows[1], 1) == Look(bold=True, fill="FFF2CC")
    assert grid.marks.look(rows[1], 2) == Look()
    again = Document(document.path, None).grids["T"]
    assert [again.marks.look(r, c) for r in again.rows[:3] for c in (1, 2)] == [
        grid.marks.look(r, c) for r in grid.rows[:3] for c in (1, 2)
    ]
    document.undo("A", redo=True)
    document.undo("A")
    assert said(document) == {(3, 3): ["about 2"]}


def test_a_row_on_which_others_have_commented_is_not_taken_away_by_undo(document: Document) -> None:
    document.insert("A", "T", document.grids["T"].rows[1], 1)
    say(document, "B", 1, 1, "why this row?")
    with pytest.raises(Refused, match="B has commented on row 3"):
        document.undo("A")
    assert said(document) == {(3, 1): ["why this row?"]}


def test_a_sheet_that_comes_back_or_is_copied_has_its_comments_and_looks(document: Document) -> None:
    say(document, "A", 1, 3, "about 2")
    document.set_looks("A", "T", [(document.grids["T"].rows[0], 2)], {"wrap": False})
    document.sheets.duplicate("A", "T")
    copy = document.grids["T 2"]
    assert [c.text for c in copy.marks.thread(copy.rows[1], 3)] == ["about 2"]
    assert copy.marks.look(copy.rows[0], 2) == Look(wrap=False)
    document.sheets.rename("A", "T 2", "Copy")
    document.sheets.delete("A", "Copy")
    assert {name for name, *_ in document.comments()} == {"T"}
    document.undo("A")
    assert sorted(name for name, *_ in document.comments()) == ["Copy", "T"]


def test_what_a_killed_server_had_accepted_is_stored_by_the_next_one(tmp_path: Path) -> None:
    path = make_workbook({"T": ROWS}, tmp_path / "x.xlsx")
    journal = Journal(tmp_path)
    document = Document(path, journal)
    thread = (Comment(new_id(), "A", AT, "kept"),)
    edits = [SetComments("T", 3, 2, thread), SetLook("T", 2, 2, bold=True), SetLook("T", 2, 3, fill="FFF2CC")]
    journal.add(path.name, "A", edits, document.file.digest)
    again = Document(path, journal)
    assert said(again) == {(3, 2): ["kept"]}
    assert again.grids["T"].marks.look(again.grids["T"].rows[0], 2) == Look(bold=True)


def test_typing_moving_and_inserting_leave_comments_with_their_cells(document: Document) -> None:
    grid = document.grids["T"]
    rows = list(grid.rows)
    say(document, "A", 2, 1, "about 3")
    document.set_cells("B", "T", [CellText(rows[2], 1, "new", "c")])
    document.move("B", "T", [rows[2]], rows[0])
    document.insert("B", "T", rows[2], 2)
    assert said(document) == {(4, 1): ["about 3"]}
    assert grid.text(rows[2], 1) == "new"


def test_a_text_file_refuses_comments_and_looks_and_stays(tmp_path: Path) -> None:
    document = Document(write_sheets({"T": ROWS}, tmp_path / "x.md"), Journal(tmp_path))
    with pytest.raises(Refused, match="no place for comments"):
        say(document, "A", 0, 1, "one")
    with pytest.raises(Refused, match="no place for bold"):
        document.set_looks("A", "T", [(document.grids["T"].rows[0], 1)], {"bold": True})
    assert document.comments() == []
    assert document.undo("A") is None
