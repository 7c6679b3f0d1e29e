"""Bold, fills and wrapping in an .xlsx file: read from the files of several programs, written with all else kept."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import openpyxl
import pytest
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lossless import SHEET, edited, make, parts, refused, repack

from rrp_sheets.workbook.edits import Edit, InsertRows, SetCell, SetLook
from rrp_sheets.workbook.files import edit, make_workbook, write_sheets
from rrp_sheets.workbook.looks import FILLS, PLAIN_LOOK, Look, SheetLooks, read_looks, shade, style_looks
from rrp_sheets.workbook.xlsx import XlsxBook


def looks(file: Path | bytes, sheet: int = 0) -> SheetLooks:
    """Looks of the cells of a sheet."""
    book = XlsxBook(file if isinstance(file, bytes) else file.read_bytes(), "x.xlsx")
    return read_looks(book, sheet, style_looks(book))


def cells(file: Path | bytes) -> Any:
    """The first sheet as openpyxl reads it."""
    return openpyxl.load_workbook(io.BytesIO(file) if isinstance(file, bytes) else file)[SHEET]


def test_looks_are_read_from_columns_and_cells_with_theme_and_tint(tmp_path: Path) -> None:
    def feature(book: Any, sheet: Any) -> None:
        sheet.set_column("E:E", 20, book.add_format({"bold": True}))
        sheet.write("A3", "x", book.add_format({"bg_color": "#FFFF00", "text_wrap": True}))
        sheet.write("B3", "x", book.add_format({"bold": True, "bg_color": "#FFFFFF"}))

    found = looks(make(tmp_path / "x.xlsx", feature))
    assert found.columns == {5: Look(bold=True)}
    assert found.cells[3, 1] == Look(fill="FFFF00")
    assert found.cells[3, 2] == Look(bold=True, fill="FFFFFF")
    assert [shade(fill) for fill in FILLS.values()] == list(FILLS)
    assert shade("FFFFFF") == ""


def test_a_look_adds_only_the_styles_that_are_missing(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    before = parts(path)
    edit(path, [SetLook(SHEET, r, 2, bold=True, fill="FFF2CC") for r in range(2, 6)])
    first = parts(path)
    assert [n for n in before if before[n] != first[n]] == ["xl/worksheets/sheet1.xml", "xl/styles.xml"]
    edit(path, [SetLook(SHEET, 6, 2, bold=True, fill="FFF2CC"), SetLook(SHEET, 40, 2, bold=True)])
    again = parts(path)
    assert again["xl/styles.xml"].count(b"<xf ") - first["xl/styles.xml"].count(b"<xf ") == 1
    cell = cells(path)["B6"]
    assert (cell.font.b, cell.fill.fgColor.rgb, cell.number_format, cell.alignment.wrap_text) == (
        True,
        "FFFFF2CC",
        "@",
        True,
    )
    assert cell.value == "filter"
    assert cells(path)["B40"].font.b


def test_taking_a_look_away_gives_the_style_that_was_there(tmp_path: Path) -> None:
    path = make_workbook({"T": [["From", "Operator"], ["a", "map"]]}, tmp_path / "x.xlsx")
    before = parts(path)["xl/worksheets/sheet1.xml"]
    edit(path, [SetLook("T", 2, 1, bold=True)])
    edit(path, [SetLook("T", 2, 1, bold=False)])
    now = openpyxl.load_workbook(path)["T"]
    assert repr(now["A2"].font) == repr(now["A3"].font)
    assert parts(path)["xl/worksheets/sheet1.xml"].count(b"<c ") == before.count(b"<c ")
    edit(path, [SetLook("T", 3, 1, wrap=False)])
    assert looks(path).cells[3, 1] == Look(wrap=False)


def test_inserted_rows_look_like_the_row_above_and_typed_texts_keep_the_look(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    edit(path, [SetLook(SHEET, 3, 1, bold=True), InsertRows(SHEET, 4, 2), SetCell(SHEET, 5, 1, "typed")])
    assert [cells(path)[f"A{n}"].font.b for n in range(2, 7)] == [False, True, True, True, False]
    assert cells(path)["A5"].value == "typed"


_LOOKS = st.lists(
    st.tuples(
        st.integers(2, 12), st.integers(1, 8), st.none() | st.booleans(), st.none() | st.sampled_from(["", *FILLS.values()]),
        st.none() | st.booleans(),
    ), max_size=12,
)  # fmt: skip


@settings(max_examples=example_count(60), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=_LOOKS)
def test_any_looks_agree_with_openpyxl_and_nothing_else_changes(tmp_path: Path, made: list[Any]) -> None:
    file = tmp_path / "base.xlsx"
    if not file.exists():
        make(file, lambda book, sheet: sheet.write_comment("C3", "on the filter"))
    before = file.read_bytes()
    new = edited(before, [SetLook(SHEET, *one) for one in made])
    wanted: dict[tuple[int, int], dict[str, Any]] = {}
    for row, column, bold, fill, wrap in made:
        changes = {"bold": bold, "fill": fill, "wrap": wrap}
        wanted.setdefault((row, column), {}).update({n: v for n, v in changes.items() if v is not None})
    sheet, old, found = cells(new), cells(before), looks(new)
    for (row, column), look in wanted.items():
        cell, was = sheet.cell(row, column), old.cell(row, column)
        mine = found.cells.get((row, column), found.columns.get(column, PLAIN_LOOK))
        assert {n: getattr(mine, n) for n in look} == look
        assert bool(cell.font.b) == look.get("bold", bool(was.font.b))
        assert (cell.fill.fgColor.rgb[2:] if cell.fill.patternType else "") == look.get("fill", "")
        if was.value is not None:  # openpyxl does not give a cell that is missing the style of its column
            assert (cell.value, cell.number_format, cell.font.name) == (was.value, was.number_format, was.font.name)
    same = {n for n, data in parts(before).items() if parts(new)[n] == data}
    assert {n for n in parts(before) if n not in same} <= {"xl/worksheets/sheet1.xml", "xl/styles.xml"}


@pytest.mark.parametrize("name", ["x.md", "x"])
def test_text_formats_say_that_they_keep_no_looks(tmp_path: Path, name: str) -> None:
    path = write_sheets({"T": [["From", "Operator", "Parameter", "To"], ["A", "map", "1", "B"]]}, tmp_path / name)
    with pytest.raises(Exception, match="no place for bold"):
        edit(path, [SetLook("T", 2, 1, bold=True)])


def test_a_file_without_styles_or_with_broken_ones_is_left_as_it_is(tmp_path: Path) -> None:
    change: Edit = SetLook(SHEET, 2, 1, bold=True)
    path = repack(make(tmp_path / "x.xlsx"), {"xl/styles.xml": b'<styleSheet xmlns="urn:x"/>'})
    assert "no formats" in str(refused(path, change).message)
    assert looks(path) == SheetLooks()
