"""Workbooks under edit: identity of rows, conflicts, undo, what other programs write, and what a killed server left."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.documents import CellText, Document, Refused
from rrp_sheets.documents.document import Journal, made_for, raw_sheets, take_over
from rrp_sheets.documents.grid import PutTexts
from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import read
from rrp_sheets.workbook.edits import AddSheet, DeleteRows, DeleteSheet, Edit, InsertRows, SetCell
from rrp_sheets.workbook.files import Edited, edit

SHEET = "Tracking"
FORMULA = 3


@lru_cache
def template() -> bytes:
    """A new workbook with two sheets and the lists of its cells: to read the others takes most of the time."""
    with TemporaryDirectory() as folder:
        path = api.new(Path(folder) / "t.xlsx")
        edit(path, [DeleteSheet(name) for name in ("Read me", "Helpers", "Scene", "Check", "Protocol")])
        return path.read_bytes()


@pytest.fixture
def document(tmp_path: Path) -> Document:
    return opened(tmp_path)


def opened(folder: Path) -> Document:
    path = folder / "b.xlsx"
    if not path.exists():
        path.write_bytes(template())
    return Document(path, Journal(folder))


def formulas(document: Document) -> list[str]:
    grid = document.grids[SHEET]
    return [grid.text(row, FORMULA) for row in grid.rows if grid.texts[row]]


def on_disk(document: Document) -> list[str]:
    behaviour = next(b for b in read(document.path).workbook.behaviours if b.name == SHEET)
    return [row.formula.text for row in behaviour.rows]


def put(document: Document, row: str, text: str, was: str | None = None, author: str = "Aya") -> None:
    document.set_cells(author, SHEET, [CellText(row, FORMULA, text, was)])


def test_an_edit_is_in_the_file_when_it_is_accepted(document: Document) -> None:
    row = document.grids[SHEET].rows[0]
    put(document, row, "redBall.x")
    assert on_disk(document)[0] == "redBall.x"
    assert not Journal(document.path.parent).waiting("b.xlsx")


def test_rows_keep_their_identity_when_others_come_above(document: Document) -> None:
    second = document.grids[SHEET].rows[1]
    document.insert("Mika", SHEET, document.grids[SHEET].rows[0], 3)
    put(document, second, "distance < 0.25")
    assert document.grids[SHEET].number(second) == 6
    assert "distance < 0.25" in on_disk(document)


def test_a_cell_that_someone_has_changed_is_refused_with_both_values(document: Document) -> None:
    row = document.grids[SHEET].rows[1]
    was = document.grids[SHEET].text(row, FORMULA)
    put(document, row, "distance < 0.3", was, "Mika")
    with pytest.raises(Refused) as refused:
        put(document, row, "distance < 0.9", was)
    clash = refused.value.clashes[0]
    assert (clash.mine, clash.theirs, clash.by) == ("distance < 0.9", "distance < 0.3", "Mika")
    assert "distance < 0.3" in on_disk(document)


def test_undo_takes_back_ones_own_edits_only(document: Document) -> None:
    first, second = document.grids[SHEET].rows[:2]
    before = formulas(document)
    put(document, first, "1", author="Aya")
    put(document, second, "2", author="Mika")
    document.undo("Aya")
    assert formulas(document)[:2] == [before[0], "2"]
    document.undo("Aya", redo=True)
    assert formulas(document)[:2] == ["1", "2"]
    assert document.undo("Kai") is None


def test_undo_is_refused_where_someone_has_changed_the_cell_since(document: Document) -> None:
    first = document.grids[SHEET].rows[0]
    put(document, first, "1", author="Aya")
    put(document, first, "2", author="Mika")
    with pytest.raises(Refused):
        document.undo("Aya")
    assert formulas(document)[0] == "2"


def test_deleted_rows_come_back_with_their_texts_and_their_identity(document: Document) -> None:
    rows = document.grids[SHEET].rows[:2]
    before = on_disk(document)
    document.delete("Aya", SHEET, rows)
    assert on_disk(document) == before[2:]
    document.undo("Aya")
    assert on_disk(document) == before and document.grids[SHEET].rows[:2] == rows
    document.undo("Aya", redo=True)
    assert on_disk(document) == before[2:]


def test_undo_for_which_there_is_no_room_can_be_made_later(document: Document) -> None:
    row, text = document.grids[SHEET].rows[0], "x" * 30_000
    put(document, row, text)
    put(document, row, "short")
    journal = document.file.journal._db
    (pages,) = journal.execute("pragma page_count").fetchone()
    journal.execute(f"pragma max_page_count = {pages}")
    with pytest.raises(SheetsError, match="This was not saved"):
        document.undo("Aya")
    journal.execute("pragma max_page_count = 100000")
    document.undo("Aya")
    assert on_disk(document)[0] == text


def test_rows_between_which_others_have_inserted_one_are_undone_moved_and_deleted_together(document: Document) -> None:
    grid = document.grids[SHEET]
    start = list(grid.rows)
    document.insert("Aya", SHEET, start[1], 3)
    mine = grid.rows[1:4]
    document.insert("Mika", SHEET, mine[1], 1)
    theirs = grid.rows[2]
    document.undo("Aya")
    assert grid.rows[:3] == [start[0], theirs, start[1]]
    document.undo("Aya", redo=True)
    assert [row for row in grid.rows if row in mine] == mine
    document.move("Aya", SHEET, mine, start[0])
    assert grid.rows[:5] == [*mine, start[0], theirs]
    document.undo("Aya")
    document.delete("Aya", SHEET, mine)
    assert grid.rows[:3] == [start[0], theirs, start[1]]
    document.undo("Aya")
    assert {*mine, theirs} <= set(grid.rows[:6])


def test_undo_leaves_a_new_row_into_which_someone_else_has_typed(document: Document) -> None:
    grid = document.grids[SHEET]
    document.insert("Aya", SHEET, grid.rows[0], 1)
    put(document, grid.rows[0], "theirs", author="Mika")
    with pytest.raises(Refused, match="Mika has changed row 2 since"):
        document.undo("Aya")
    assert formulas(document)[0] == "theirs"
    document.delete("Aya", SHEET, grid.rows[:1])
    assert "theirs" not in formulas(document)


def test_what_was_to_stand_before_a_deleted_row_stands_where_that_was(document: Document) -> None:
    grid = document.grids[SHEET]
    start = list(grid.rows)
    document.delete("Mika", SHEET, start[1:3])
    document.insert("Aya", SHEET, start[1], [("wabcd-1", {FORMULA: "new"})])
    assert grid.rows[:3] == [start[0], "wabcd-1", start[3]]
    document.move("Aya", SHEET, ["wabcd-1"], start[0])
    document.delete("Mika", SHEET, start[3:4])
    document.undo("Aya")
    assert grid.rows[:3] == [start[0], "wabcd-1", start[4]]
    document.insert("Aya", SHEET, None, [("wabcd-3", {FORMULA: "last"})])
    assert on_disk(document)[-1] == "last" and grid.text("wabcd-3", FORMULA) == "last"
    with pytest.raises(Refused):
        document.insert("Aya", SHEET, start[4], [("wabcd-1", {})])
    with pytest.raises(Refused):
        document.insert("Aya", SHEET, start[4], [("wabcd-2", {99: "no such column"})])


def test_there_are_blank_rows_below_in_whatever_way_rows_are_filled(document: Document) -> None:
    grid = document.grids[SHEET]

    def room() -> int:
        return next(i for i, row in enumerate(reversed(grid.rows)) if grid.texts[row])

    def last() -> str:
        return grid.rows[-1]

    ways = (
        lambda: put(document, last(), "1"),
        lambda: document.insert("Aya", SHEET, last(), [(grid.new_id(), {FORMULA: "2"})]),
        lambda: document.move("Aya", SHEET, grid.rows[:1], None),
        lambda: document.delete("Aya", SHEET, grid.rows[-15:]),
        lambda: document.undo("Aya"),
        lambda: edit(document.path, [SetCell(SHEET, len(grid.rows), 3, "3")]),
        lambda: document.together("Aya", [PutTexts(SHEET, (CellText(last(), FORMULA, "4"),))]),
    )
    for way in ways:
        way()
        document.poll()
        assert room() >= 20
    assert len(set(grid.rows)) == len(grid.rows) == len(grid.texts)


def test_rows_move_and_move_back(document: Document) -> None:
    grid = document.grids[SHEET]
    before, rows = on_disk(document), list(grid.rows)
    document.move("Aya", SHEET, [rows[0]], rows[2])
    assert on_disk(document)[:2] == [before[1], before[0]]
    document.undo("Aya")
    assert on_disk(document) == before and grid.rows == rows


def test_what_another_program_writes_is_taken_over(document: Document) -> None:
    third = document.grids[SHEET].rows[2]
    edit(document.path, [InsertRows(SHEET, 2, 1), SetCell(SHEET, 2, 3, "new")])
    assert document.poll()
    assert formulas(document)[0] == "new"
    assert document.grids[SHEET].number(third) == 5
    put(document, third, "still mine")
    assert "still mine" in on_disk(document)


@pytest.mark.parametrize("edited", [False, True])
def test_what_another_program_writes_before_the_next_check_is_taken_over(document: Document, edited: bool) -> None:
    """The check reads the file anew when it was opened or edited, and is no reason to take its rows for known."""
    if edited:
        put(document, document.grids[SHEET].rows[1], "mine")
    edit(document.path, [InsertRows(SHEET, 2, 1), SetCell(SHEET, 2, 3, "new")])
    assert document.reading.workbook.behaviours, "the check reads it"
    third = document.grids[SHEET].rows[2]
    put(document, third, "still mine")
    assert formulas(document)[0] == "new" and document.grids[SHEET].number(third) == 5
    assert formulas(document) == [text for text in on_disk(document) if text]


@pytest.fixture
def written_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program writes the file once, at the moment when our first edit of it was stored."""

    def stored(path: Path, edits: Sequence[Edit], *, expected_digest: str | None = None) -> Edited:
        monkeypatch.setattr("rrp_sheets.documents.document.edit", edit)
        done = edit(path, edits, expected_digest=expected_digest)
        edit(path, [InsertRows(SHEET, 2, 1), SetCell(SHEET, 2, 3, "new")])
        return done

    monkeypatch.setattr("rrp_sheets.documents.document.edit", stored)


@pytest.mark.usefixtures("written_at_once")
@pytest.mark.parametrize("checked", [False, True])
def test_what_another_program_writes_when_an_edit_is_stored_is_taken_over(document: Document, checked: bool) -> None:
    first, _, third = document.grids[SHEET].rows[:3]
    put(document, first, "mine")
    if checked:
        assert document.reading.workbook.behaviours, "the check reads it"
    else:
        with pytest.raises(Refused, match="changed by somebody else"):
            put(document, third, "still mine")
    put(document, third, "still mine")
    assert formulas(document)[:2] == ["new", "mine"] and document.grids[SHEET].number(third) == 5
    assert formulas(document) == [text for text in on_disk(document) if text]


@pytest.mark.usefixtures("written_at_once")
def test_what_another_program_writes_when_a_sheet_is_added_is_told(document: Document) -> None:
    document.sheets.add("Aya", "behaviour", "More")
    assert SHEET in [one.sheet for one in document.outside()] and formulas(document)[0] == "new"
    assert not document.poll()


def test_rows_that_could_not_be_taken_over_are_no_base_for_an_edit(
    document: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    third = document.grids[SHEET].rows[2]
    edit(document.path, [InsertRows(SHEET, 2, 1), SetCell(SHEET, 2, 3, "new")])
    with monkeypatch.context() as patch, pytest.raises(OSError, match="locked"):
        patch.setattr(document.file, "whole", read_failing)
        document.poll()
    put(document, third, "still mine")
    assert formulas(document)[0] == "new" and document.grids[SHEET].number(third) == 5
    assert formulas(document) == [text for text in on_disk(document) if text]


def read_failing(_tables: object) -> None:
    raise OSError("locked for a moment")


OTHERS = st.lists(
    st.one_of(
        st.tuples(st.just("put"), st.integers(0, 8), st.sampled_from(["1", "x + 1", "", '"text"'])),
        st.tuples(st.just("insert"), st.integers(0, 8), st.integers(1, 2)),
        st.tuples(st.just("delete"), st.integers(0, 8), st.integers(1, 2)),
    ),
    min_size=1,
    max_size=3,
)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(changes=OTHERS)
def test_what_another_program_writes_is_told_as_a_difference(
    changes: list[tuple[str, int, object]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    document = opened(tmp_path_factory.mktemp("d"))
    grid = document.grids[SHEET]
    rows, before, version = list(grid.rows), {r: dict(c) for r, c in grid.texts.items()}, grid.version
    for name, at, value in changes:
        number = grid.first + at
        if name == "put":
            edit(document.path, [SetCell(SHEET, number, FORMULA, str(value))])
        elif name == "insert":
            edit(document.path, [InsertRows(SHEET, number, int(str(value))), SetCell(SHEET, number, FORMULA, "new")])
        else:
            edit(document.path, [DeleteRows(SHEET, number, int(str(value)))])
    changed = document.poll()
    assert not document.poll()
    fresh = Document(document.path, Journal(document.path.parent)).grids[SHEET]
    assert [grid.texts[r] for r in grid.rows if grid.texts[r]] == [fresh.texts[r] for r in fresh.rows if fresh.texts[r]]
    told = [one for one in changed if one.sheet == SHEET]
    for one in told:
        rows = [row for row in rows if row not in one.removed]
        for row, follower in one.inserted:
            rows.insert(rows.index(follower) if follower else len(rows), row)
        rows += one.grown
        new = {row for row, _ in one.inserted}
        assert {r for r in grid.rows if r not in new and grid.texts[r] != before.get(r, {})} == set(one.touched)
    assert rows == grid.rows and (grid.version > version or not any(o.inserted or o.removed for o in told))


def test_a_row_keeps_its_identity_when_another_program_changes_it_and_inserts_rows_above(document: Document) -> None:
    rows = list(document.grids[SHEET].rows)
    edit(document.path, [SetCell(SHEET, 3, FORMULA, "changed"), InsertRows(SHEET, 2, 2), SetCell(SHEET, 2, 3, "new")])
    (changed,) = document.poll()
    assert document.grids[SHEET].rows[2:] == rows
    assert changed.touched == (rows[1],) and len(changed.inserted) == 2
    edit(document.path, [SetCell(SHEET, 20, 6, "far below")])
    (changed,) = document.poll()
    assert changed.touched == (document.grids[SHEET].rows[18],) and not changed.removed


def test_an_edit_that_finds_the_file_changed_keeps_what_changed_to_be_told(document: Document) -> None:
    rows = document.grids[SHEET].rows
    edit(document.path, [SetCell(SHEET, 2, 6, "by Excel"), AddSheet("More", "behaviour")])
    put(document, rows[2], "mine")
    changed = document.outside()
    assert [(one.sheet, one.touched, one.change and one.change.what) for one in changed] == [
        (SHEET, (rows[0],), None), ("More", (), "added")
    ]  # fmt: skip
    assert not document.poll()


def test_what_a_killed_server_had_accepted_is_stored_at_the_next_start(tmp_path: Path) -> None:
    document = opened(tmp_path)
    digest = document.reading.digest
    Journal(tmp_path).add("b.xlsx", "Aya", [SetCell(SHEET, 2, FORMULA, "after the crash")], digest)
    assert on_disk(opened(tmp_path))[0] == "after the crash"
    assert not Journal(tmp_path).waiting("b.xlsx")


def test_what_was_stored_before_the_crash_is_not_stored_twice(tmp_path: Path) -> None:
    document = opened(tmp_path)
    before = len(on_disk(document))
    edits = [InsertRows(SHEET, 2, 1), SetCell(SHEET, 2, FORMULA, "once"), SetCell(SHEET, 2, 2, "map")]
    Journal(tmp_path).add("b.xlsx", "Aya", edits, document.reading.digest)
    edit(document.path, edits)
    assert len(on_disk(opened(tmp_path))) == before + 1


def test_versions_keep_the_file_as_it_was(document: Document) -> None:
    content = document.path.read_bytes()
    document.keep_version("Aya", "approved")
    put(document, document.grids[SHEET].rows[0], "1")
    (version,) = document.file.versions()
    assert version.name == "approved"
    assert document.file.version_content(version.id) == content


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.just("put"), st.integers(0, 6), st.sampled_from(["1", "x + 1", "", '"text"'])),
        st.tuples(st.just("insert"), st.integers(0, 6), st.integers(1, 3)),
        st.tuples(st.just("delete"), st.integers(0, 6), st.integers(1, 2)),
        st.tuples(st.just("move"), st.integers(0, 6), st.integers(0, 6)),
    ),
    max_size=8,
)


@settings(max_examples=8, deadline=None)
@given(actions=ACTIONS)
def test_the_file_always_says_what_the_grid_says_and_undo_leads_back(
    actions: list[tuple[str, int, object]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    document = opened(tmp_path_factory.mktemp("d"))
    grid = document.grids[SHEET]
    start = [dict(grid.texts[row]) for row in grid.rows if grid.texts[row]]
    done = 0
    for name, at, value in actions:
        row = grid.rows[at]
        if name == "put":
            put(document, row, str(value))
        elif name == "insert":
            document.insert("Aya", SHEET, row, int(str(value)))
        elif name == "delete":
            document.delete("Aya", SHEET, grid.rows[at : at + int(str(value))])
        else:
            document.move("Aya", SHEET, [row], grid.rows[int(str(value))])
        done += 1
        fresh = take_over({}, raw_sheets(document.path)[0], ())[0][SHEET]
        assert [fresh.texts[r] for r in fresh.rows if fresh.texts[r]] == [
            grid.texts[r] for r in grid.rows if grid.texts[r]
        ]
    assert [t for _, t in rows_of(again(document)) if t] == [t for _, t in rows_of(document) if t]
    for _ in range(done):
        document.undo("Aya")
    assert [grid.texts[r] for r in grid.rows if grid.texts[r]] == start


# ---- after a restart of the server ----


def again(document: Document) -> Document:
    """The workbook as another start of the server opens it; the one before was killed."""
    return opened(document.path.parent)


def rows_of(document: Document) -> list[tuple[str, dict[int, str]]]:
    grid = document.grids[SHEET]
    return [(row, grid.texts[row]) for row in grid.rows]


def test_rows_are_the_same_after_a_restart(document: Document) -> None:
    rows = document.grids[SHEET].rows
    document.insert("Aya", SHEET, rows[1], 2)
    put(document, document.grids[SHEET].rows[2], "new")
    document.move("Aya", SHEET, [rows[0]], rows[3])
    document.delete("Aya", SHEET, [rows[1]])
    put(document, document.grids[SHEET].rows[-5], "far below")
    document.insert("Aya", SHEET, None, 3)
    document.undo("Aya")
    before = rows_of(document)
    restarted = again(document)
    after = rows_of(restarted)
    assert after[: len(before)] == before and not any(texts for _, texts in after[len(before) :])
    fresh = restarted.insert("Aya", SHEET, before[0][0], 50).inserted
    assert not {row for row, _ in fresh} & {row for row, _ in before}


@pytest.mark.parametrize("then", ["a look", "an edit"])
@pytest.mark.parametrize("theirs", [SetCell(SHEET, 3, 6, "theirs"), DeleteRows(SHEET, 2, 1)], ids=["a cell", "a row"])
def test_rows_are_the_same_after_a_change_by_another_program_and_a_restart(
    document: Document, theirs: Edit, then: str
) -> None:
    put(document, document.grids[SHEET].rows[2], "mine")
    edit(document.path, [theirs])
    if then == "a look":
        document.poll()
    else:
        put(document, document.grids[SHEET].rows[3], "new")
    before = rows_of(document)
    assert rows_of(again(document))[: len(before)] == before


@pytest.mark.parametrize("moment", ["before the file", "before its ids"])
def test_rows_are_the_same_when_the_server_is_killed_while_they_are_moved(
    document: Document, moment: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = list(document.grids[SHEET].rows)

    def killed(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    where = {
        "before the file": "rrp_sheets.documents.document.edit",
        "before its ids": "rrp_sheets.documents.document.Document._keep_rows",
    }
    for change in (
        lambda d: d.insert("Aya", SHEET, rows[1], 2),
        lambda d: d.move("Aya", SHEET, [rows[0]], rows[3]),
        lambda d: d.delete("Aya", SHEET, [rows[1]]),
    ):
        before = {row: texts for row, texts in rows_of(document) if texts}
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr(where[moment], killed)
            change(document)
        document = again(document)
        after = {row: texts for row, texts in rows_of(document) if texts}
        assert after.items() <= before.items()
    assert rows[1] in before and after == {row: texts for row, texts in before.items() if row != rows[1]}


def test_rows_are_others_when_another_program_has_changed_the_file_while_no_server_ran(document: Document) -> None:
    before = document.grids[SHEET].rows
    edit(document.path, [SetCell(SHEET, 3, FORMULA, "by another program")])
    assert not set(again(document).grids[SHEET].rows) & set(before)


def test_an_edit_that_is_asked_for_again_is_known_after_a_restart(document: Document) -> None:
    row = document.grids[SHEET].rows[0]
    with made_for("page-1", ""):
        put(document, row, "first")
    with made_for("page-2"), pytest.raises(Refused):
        put(document, row, "refused", was="something else")
    with made_for("page-3"):
        document.insert("Aya", SHEET, row, 1)
    found = again(document)
    assert [found.file.made(f"page-{n}") for n in (1, 2, 3, 4)] == [True, False, True, False]
    assert not found.file.made("")
