"""Comments of cells in an .xlsx file: written as Excel does, read by others, kept through edits; hostile files."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import openpyxl
import pytest
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lossless import SHEET, add_part, edited, make, parts, refused, repack

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.comments import MOST_TEXT, NOTE, Comment, Thread, Threads, read_threads, replied, with_new_ids
from rrp_sheets.workbook.edits import (
    DeleteRows,
    DeleteSheet,
    Edit,
    InsertRows,
    MoveRows,
    RenameSheet,
    SetCell,
    SetComments,
)  # fmt: skip
from rrp_sheets.workbook.files import edit, make_workbook, read_sheets
from rrp_sheets.workbook.xlsx import XlsxBook

AT = "2026-11-02T09:05:00Z"
COMMENTS = "application/vnd.openxmlformats-officedocument.spreadsheetml.comments+xml"
KIND = "http://schemas.openxmlformats.org/officeDocument/2006/relationships/comments"


def thread(*texts: str, author: str = "Aya", done: bool = False) -> Thread:
    """A thread of these texts."""
    made = tuple(
        Comment(f"{{{i}}}", author if i % 2 == 0 else "Mika", AT, t, done and i == 0) for i, t in enumerate(texts)
    )
    return with_new_ids(made)


def threads(file: Path | bytes, sheet: int = 0) -> Threads:
    """Comments of a sheet."""
    return read_threads(XlsxBook(file if isinstance(file, bytes) else file.read_bytes(), "x.xlsx"), sheet)


def by_openpyxl(file: Path | bytes, sheet: str = SHEET) -> dict[str, Any]:
    """Notes as openpyxl reads them, by cell."""
    book = openpyxl.load_workbook(io.BytesIO(file) if isinstance(file, bytes) else file)
    cells = (cell for row in book[sheet].iter_rows() for cell in row)
    return {cell.coordinate: cell.comment for cell in cells if cell.comment}


def same_but_comments(before: bytes, after: bytes) -> None:
    """Every part that has nothing to do with comments is the same byte for byte."""
    old, new = parts(before), parts(after)
    touched = {"[Content_Types].xml", "xl/worksheets/sheet1.xml", "xl/worksheets/_rels/sheet1.xml.rels"}
    touched |= {"xl/_rels/workbook.xml.rels"}
    assert old.keys() <= new.keys()
    assert [n for n in old if old[n] != new[n] and n not in touched and "omment" not in n and "vml" not in n] == []
    assert all("omment" in n or "vml" in n or "persons" in n or n in touched for n in new.keys() - old.keys())


def test_a_thread_is_written_as_note_box_thread_and_persons(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    before, mine = path.read_bytes(), thread("Faster?", "Yes,\n  <b> & “so”", done=True)
    edit(path, [SetComments(SHEET, 3, 3, mine)])
    same_but_comments(before, path.read_bytes())
    assert threads(path) == {(3, 3): mine}
    note = by_openpyxl(path)["C3"]
    assert note.author == f"tc={mine[0].id}"
    assert note.text.startswith("[Threaded comment]\n\nYour version of Excel allows you to read this threaded comment;")
    assert note.text.endswith(
        "Comment (Aya, 2026-11-02 09:05 UTC):\n    Faster?\nReply (Mika, 2026-11-02 09:05 UTC):\n    Yes,\n  <b> & “so”"
    )
    there = parts(path)
    kinds = [n for n in there if "omment" in n or "vml" in n or "person" in n]
    assert len(kinds) == 4
    vml = next(data for n, data in there.items() if n.endswith(".vml"))
    assert b"<x:Row>2</x:Row><x:Column>2</x:Column>" in vml
    assert b'<Default Extension="vml"' in there["[Content_Types].xml"]
    assert there["xl/worksheets/sheet1.xml"].count(b"legacyDrawing") == 1


def test_a_reply_leaves_the_other_comments_as_they_are_in_the_file(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    first, other = thread("one"), thread("other")
    edit(path, [SetComments(SHEET, 3, 3, first), SetComments(SHEET, 4, 1, other)])
    part = next(n for n in parts(path) if "threadedComment" in n)
    mention = b"</text><mentions><mention startIndex='0'/></mentions></threadedComment>"
    repack(path, {part: lambda data: data.replace(b"</text></threadedComment>", mention)})
    both = replied(first, thread("two", author="Mika")[0])
    edit(path, [SetComments(SHEET, 3, 3, both)])
    assert threads(path) == {(3, 3): both, (4, 1): other}
    assert parts(path)[part].count(b"mentions>") == 4
    edit(path, [SetComments(SHEET, 3, 3, ())])
    assert threads(path) == {(4, 1): other}
    assert list(by_openpyxl(path)) == ["A4"]


def test_notes_of_other_programs_are_read_kept_and_replied_to(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.write_comment("C3", "Aya:\nslow", {"author": "Aya"}))
    (note,) = threads(path)[3, 3]
    assert note == Comment(NOTE, "Aya", "", "slow")
    edit(path, [SetComments(SHEET, 5, 1, thread("new")), SetCell(SHEET, 2, 1, "x")])
    assert by_openpyxl(path)["C3"].text == "Aya:\nslow"
    assert threads(path)[3, 3] == (note,)
    both = replied((note,), thread("why?", author="Mika")[0])
    edit(path, [SetComments(SHEET, 3, 3, both)])
    assert threads(path)[3, 3] == both
    assert len(by_openpyxl(path)) == 2
    edit(path, [SetComments(SHEET, 3, 3, (note,))])  # the reply is undone
    assert threads(path)[3, 3] == (note,)
    assert by_openpyxl(path)["C3"].author == "Aya"


def test_notes_and_threads_stand_in_files_with_buttons_and_header_pictures(tmp_path: Path) -> None:
    def feature(book: Any, sheet: Any) -> None:
        sheet.insert_button("J2", {"caption": "Press"})
        sheet.set_header("&L&[Picture]", {"image_left": io_picture()})
        sheet.protect()

    def io_picture() -> str:
        from lossless import picture

        path = tmp_path / "red.png"
        path.write_bytes(picture().read())
        return str(path)

    path = make(tmp_path / "x.xlsx", feature)
    edit(path, [SetComments(SHEET, 3, 3, thread("a"))])
    vml = [data for n, data in parts(path).items() if n.endswith(".vml")]
    assert sorted(b'ObjectType="Note"' in data for data in vml) == [False, True]
    assert any(b'ObjectType="Button"' in data and b'ObjectType="Note"' in data for data in vml)


def test_comments_move_with_rows_and_sheets(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    a, b = thread("a"), thread("b", "c")
    edit(path, [SetComments(SHEET, 3, 3, a), SetComments(SHEET, 5, 1, b), InsertRows(SHEET, 2, 2)])
    assert threads(path) == {(5, 3): a, (7, 1): b}
    edit(path, [MoveRows(SHEET, 7, 1, 2), DeleteRows(SHEET, 6, 1), RenameSheet(SHEET, "Other")])
    assert threads(path) == {(2, 1): b}
    assert list(by_openpyxl(path, "Other")) == ["A2"]
    vml = next(data for n, data in parts(path).items() if n.endswith(".vml"))
    assert vml.count(b"</v:shape>") == 1
    assert b"<x:Row>1</x:Row>" in vml


def test_a_deleted_sheet_comes_back_with_its_comments_after_others_were_written(tmp_path: Path) -> None:
    from rrp_sheets.workbook.edits import BringSheet

    path = make(tmp_path / "x.xlsx")
    a, b = thread("a"), thread("b")
    edit(path, [SetComments(SHEET, 3, 3, a)])
    (kept,) = edit(path, [DeleteSheet(SHEET)]).kept
    edit(path, [SetComments("Mine", 1, 1, b)])
    edit(path, [BringSheet(SHEET, kept)])
    assert (threads(path, 0), threads(path, 1)) == ({(3, 3): a}, {(1, 1): b})


# ---- any comments and edits

_TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Cn"], exclude_characters="_"), min_size=1)
_PLACE = st.tuples(st.integers(1, 9), st.integers(1, 4))
_EDITS = st.lists(
    st.one_of(
        st.tuples(st.just("comment"), _PLACE, st.lists(_TEXT, max_size=3)),
        st.tuples(st.just("insert"), st.integers(2, 9), st.integers(1, 2)),
        st.tuples(st.just("delete"), st.integers(2, 8), st.integers(1, 2)),
        st.tuples(st.just("move"), st.integers(2, 5), st.integers(6, 9)),
    ),
    max_size=8,
)


@settings(max_examples=example_count(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=_EDITS)
def test_any_comments_and_row_edits_agree_with_openpyxl(tmp_path: Path, made: list[Any]) -> None:
    wanted: Threads = {}
    edits: list[Edit] = []
    for what, where, more in made:
        if what == "comment":
            mine = thread(*(text.strip() or "x" for text in more))
            edits.append(SetComments(SHEET, *where, mine))
            wanted.pop(where, None)
            wanted |= {where: mine} if mine else {}
            continue
        rows = {
            "insert": InsertRows(SHEET, where, more), "delete": DeleteRows(SHEET, where, more),
            "move": MoveRows(SHEET, where, 1, more),
        }[what]  # fmt: skip
        edits.append(rows)
        moved = {(rows.mapped(row), column): t for (row, column), t in wanted.items()}
        wanted = {(row, column): t for (row, column), t in moved.items() if row is not None}
    file = tmp_path / "base.xlsx"
    if not file.exists():
        make(file, lambda book, sheet: sheet.insert_image("J2", "red.png", {"image_data": _picture()}))
    new = edited(file.read_bytes(), edits)
    assert threads(new) == wanted
    notes = {at: comment.text for at, comment in by_openpyxl(new).items()}
    assert len(notes) == len(wanted)
    assert sorted(text.rpartition(":\n    ")[2] for text in notes.values()) == sorted(
        t[-1].text.rpartition(":\n    ")[2] for t in wanted.values()
    )
    same_but_comments(file.read_bytes(), new)


def _picture() -> io.BytesIO:
    from lossless import picture

    return picture()


# ---- hostile files


def commented(path: Path) -> tuple[Path, str, str, str]:
    """A file with a thread in C3, and the names of its note, thread and box parts."""
    make(path)
    edit(path, [SetComments(SHEET, 3, 3, thread("a"))])
    names = parts(path)
    return (path, *(next(n for n in names if n.startswith(f"xl/{beginning}")) for beginning in (
        "comments", "threadedComments/", "drawings/vml",
    )))  # type: ignore[return-value]  # fmt: skip


def test_broken_parts_have_no_comments_and_stay(tmp_path: Path) -> None:
    path, note, threaded, _ = commented(tmp_path / "x.xlsx")
    repack(path, {note: b"<comments", threaded: b"<ThreadedComments><threadedComment"})
    assert threads(path) == {}
    edit(path, [SetCell(SHEET, 2, 1, "x")])
    assert parts(path)[note] == b"<comments"
    assert "cannot be understood" in str(refused(path, SetComments(SHEET, 3, 3, thread("b"))).message)


def test_a_box_that_is_missing_is_made_again(tmp_path: Path) -> None:
    path, _, _, box = commented(tmp_path / "x.xlsx")
    old = parts(path)
    with zipfile.ZipFile(path, "w") as package:
        for name, data in old.items():
            if name != box:
                package.writestr(name, data)
    more = replied(threads(path)[3, 3], thread("b")[0])
    edit(path, [SetComments(SHEET, 3, 3, more)])
    assert threads(path) == {(3, 3): more}
    assert list(by_openpyxl(path)) == ["C3"]
    assert sum(n.endswith(".vml") for n in parts(path)) == 1


def test_of_two_parts_with_notes_both_are_read_and_a_cell_has_one(tmp_path: Path) -> None:
    path, _, _, _ = commented(tmp_path / "x.xlsx")
    second = (
        b'<comments xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><authors><author>B</author></authors>'
        b'<commentList><comment ref="C3" authorId="0"><text><t>twice</t></text></comment>'
        b'<comment ref="A2" authorId="7"><text><t>elsewhere</t></text></comment>'
        b'<comment ref="A1048577" authorId="0"><text><t>beyond</t></text></comment>'
        b'<comment ref="XFE1" authorId="0"><text><t>beyond</t></text></comment></commentList></comments>'
    )
    add_part(path, "xl/commentsMore.xml", second, COMMENTS, "xl/worksheets/sheet1.xml", KIND)
    found = threads(path)
    assert {at: t[0].text for at, t in found.items()} == {(3, 3): "a", (2, 1): "elsewhere"}
    edit(path, [SetComments(SHEET, 3, 3, ())])
    assert {at: t[0].text for at, t in threads(path).items()} == {(2, 1): "elsewhere"}
    assert parts(path)["xl/commentsMore.xml"].count(b"beyond") == 2


def test_a_comment_of_a_megabyte_is_cut_for_reading_and_stays_whole(tmp_path: Path) -> None:
    path, _, threaded, _ = commented(tmp_path / "x.xlsx")
    long = b" ".join(str(n * n).encode() for n in range(90_000))
    repack(path, {threaded: lambda data: data.replace(b">a<", b">" + long + b"<")})
    (first,) = threads(path)[3, 3]
    assert len(first.text) == 32_767
    more = replied((first,), thread("b")[0])
    edit(path, [SetComments(SHEET, 3, 3, more)])
    assert long in parts(path)[threaded]
    assert threads(path)[3, 3] == more
    assert len(by_openpyxl(path)["C3"].text) <= 32_767


@pytest.mark.parametrize("text", ["", "  \n", "x" * (MOST_TEXT + 1), "a\0b", "\ud800"])
def test_a_text_that_is_no_comment_is_refused(text: str) -> None:
    from rrp_sheets.workbook.comments import checked_text

    with pytest.raises(SheetsError) as told:
        checked_text(text)
    assert told.value.remedy


@pytest.mark.parametrize("name", ["x.md", "x"])
def test_text_formats_say_that_they_keep_no_comments(tmp_path: Path, name: str) -> None:
    from rrp_sheets.workbook.files import write_sheets

    path = write_sheets(
        {"T": [["Input streams", "Connector", "Formula", "Output stream"], ["A", "map", "1", "B"]]}, tmp_path / name
    )
    with pytest.raises(SheetsError) as told:
        edit(path, [SetComments("T", 2, 1, thread("a"))])
    assert "no place for comments" in str(told.value.message)
    assert read_sheets(path)[0].cells[2, 1].text == "A"


def test_a_workbook_of_ours_takes_comments_in_every_sheet(tmp_path: Path) -> None:
    path = make_workbook({"T": [["From", "Operator"], ["a", "map"]], "U": [["x"]]}, tmp_path / "x.xlsx")
    mine = [thread("a"), thread("b", "c")]
    edit(path, [SetComments("T", 2, 1, mine[0]), SetComments("U", 1, 1, mine[1])])
    assert [threads(path, i) for i in (0, 1)] == [{(2, 1): mine[0]}, {(1, 1): mine[1]}]


@pytest.mark.parametrize("name", ["out.md", "out"])
def test_a_conversion_to_text_tells_which_comments_are_left_out(tmp_path: Path, name: str) -> None:
    from click.testing import CliRunner

    from rrp_sheets.cli.main import group
    from rrp_sheets.workbook.edits import SetLook

    path = make_workbook({"T": [["From", "Operator", "Parameter", "To"], ["A", "map", "1", "B"]]}, tmp_path / "x.xlsx")
    plain = CliRunner().invoke(group, ["convert", str(path), str(tmp_path / f"plain-{name}")])
    assert (plain.exit_code, "Note:" in plain.output) == (0, False)
    edit(path, [SetComments("T", 2, 3, thread("a")), SetLook("T", 2, 1, bold=True)])
    told = CliRunner().invoke(group, ["convert", str(path), str(tmp_path / name)])
    assert told.exit_code == 0
    assert "A cell has comments that are not in the copy" in told.output
    assert "T!C2" in told.output
    assert "Bold, colours and line breaks of cells are not in the copy." in told.output
