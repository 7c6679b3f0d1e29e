"""Setting cells of an .xlsx: what is stored, and what is refused and why."""

from __future__ import annotations

import io
import re
from pathlib import Path

import openpyxl
import pytest
import xlsxwriter
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lossless import FEATURES, SHEET, cell, edited, make, parts, refused, repack

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, MoveRows, SetCell, parse_typed
from rrp_sheets.workbook.files import edit, read_sheets
from rrp_sheets.workbook.raw import Extent
from rrp_sheets.workbook.xlsx import XlsxBook

PART = "xl/worksheets/sheet1.xml"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return make(tmp_path / "a b プロトコル.xlsx")


# ---- what is stored


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "seen"),
    [
        ("text", "text"), ("=1+1", "=1+1"), ("+1", "+1"), ("'=x", "'=x"), ("007", "007"), ("#N/A", "#N/A"),
        ("a\nb", "a\nb"), ("a\r\nb\rc", "a\nb\nc"), ("  edges  ", "  edges  "), ("a\tb", "a\tb"), ("", ""),
        ("<c r='A1'>&amp; ]]>", "<c r='A1'>&amp; ]]>"), ("_x0041_", "_x0041_"), ("a\x07b", "a\x07b"),
        ("赤いボール 😀", "赤いボール 😀"), ("TRUE", "TRUE"), ("x" * 32_767, "x" * 32_767),
        (20, "20"), (0.1, "0.1"), (-3.0, "-3"), (1e300, "1e+300"), (True, "TRUE"), (False, "FALSE"), (None, ""),
    ],
)  # fmt: skip
@pytest.mark.parametrize("place", [(3, 3), (3, 12), (40, 7), (2, 7)])
def test_values_come_back(path, value, seen, place):
    edit(path, [SetCell(SHEET, *place, value)])
    found = read_sheets(path)[0].cells.get(place)
    assert (found.text if found else "") == seen
    assert found is None or not found.formula
    if "\x07" not in seen and "_x" not in seen:
        assert str(openpyxl.load_workbook(path)[SHEET].cell(*place).value or "") in (
            seen,
            str(value),
            str(float(20)),
            "",
        )


@pytest.mark.parametrize(
    ("text", "value"),
    [("20", 20.0), ("-0.5", -0.5), ("007", "007"), ("1e5", "1e5"), ("TRUE", True), ("FALSE", False), ("true", "true"), ("1.50", "1.50"), ("=A1", "=A1"),
     ("1/2", "1/2"), ("1234567890123456", "1234567890123456"), ("", None), ("1,5", "1,5"), ("-0", "-0"), (" 1", " 1")],
)  # fmt: skip
def test_what_is_typed(text, value):
    assert parse_typed(text) == value and type(parse_typed(text)) is type(value)


@pytest.mark.parametrize(
    ("value", "words"),
    [("x" * 32_768, "32,768 characters"), ("😀" * 16_384, "32,768 characters"), ("a\ufffeb", "U+FFFE"),
     ("a\ud800", "U+D800"), (float("nan"), "number nan"), (float("inf"), "number inf")],
)  # fmt: skip
def test_values_that_no_cell_can_hold(path, value, words):
    before = path.read_bytes()
    with pytest.raises(SheetsError) as told:
        edit(path, [SetCell(SHEET, 2, 1, "first"), SetCell(SHEET, 3, 3, value)])
    assert words in told.value.message and told.value.remedy
    assert path.read_bytes() == before  # all or nothing


def test_a_cell_keeps_its_style_and_new_ones_take_their_columns(path):
    def style(row, column):
        return openpyxl.load_workbook(path)[SHEET].cell(row, column).number_format

    assert style(3, 3) == "@"
    edit(path, [SetCell(SHEET, 3, 3, "new"), SetCell(SHEET, 30, 3, "new"), SetCell(SHEET, 30, 9, "new")])
    assert [style(3, 3), style(30, 3), style(30, 9)] == ["@", "@", "General"]


def test_numbers_go_as_text_into_cells_for_texts_and_dates(tmp_path):
    path = tmp_path / "x.xlsx"
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet(SHEET)
        for row, code in enumerate(["@", "yyyy-mm-dd", "h:mm", "0.00", "General"]):
            sheet.write_blank(row, 0, None, book.add_format({"num_format": code}))
    edit(path, [SetCell(SHEET, row, 1, 20) for row in range(1, 6)])
    values = [c.value for c in openpyxl.load_workbook(path)[SHEET]["A"]]
    assert values == ["20", "20", "20", 20, 20]


def test_cells_and_rows_are_put_in_their_order(path):
    edits = [SetCell(SHEET, r, c, f"{r},{c}") for r, c in [(20, 3), (12, 30), (12, 1), (12, 28), (9, 2), (15, 2)]]
    edit(path, edits)
    rows = openpyxl.load_workbook(path)[SHEET]
    assert [rows.cell(r, c).value for r, c in [(9, 2), (12, 1), (12, 28), (12, 30), (15, 2), (20, 3)]] == [
        "9,2", "12,1", "12,28", "12,30", "15,2", "20,3",
    ]  # fmt: skip
    assert b'<dimension ref="A1:AD20"/>' in parts(path)[PART]
    order = [int(n) for n in re.findall(rb'<row r="(\d+)"', parts(path)[PART])]
    assert order == sorted(order)


@pytest.mark.parametrize("strip", ["cells", "rows and cells", "dimension"])
def test_files_that_leave_things_out(path, strip):
    """Rows and cells without their numbers count on from the one before."""

    def change(data: bytes) -> bytes:
        if strip == "dimension":
            return re.sub(rb"<dimension[^>]*/>", b"", data)
        data = re.sub(rb'<c r="[A-Z]+\d+"', b"<c", data)
        return re.sub(rb'<row r="\d+"', b"<row", data) if strip != "cells" else data

    repack(path, {PART: change})
    before = {at: c.text for at, c in read_sheets(path)[0].cells.items()}
    edit(path, [SetCell(SHEET, 3, 9, "x"), SetCell(SHEET, 4, 2, "y"), SetCell(SHEET, 12, 2, "z")])
    after = {at: c.text for at, c in read_sheets(path)[0].cells.items()}
    assert after == before | {(3, 9): "x", (4, 2): "y", (12, 2): "z"}


def test_an_empty_sheet_is_filled(tmp_path):
    path = tmp_path / "x.xlsx"
    book = openpyxl.Workbook()
    book.save(path)
    edit(path, [SetCell("Sheet", 2, 2, "first")])
    assert cell(path, 2, 2) == "first"


# ---- what is refused


def test_sheets_and_cells_that_are_not_there(path):
    assert "There is no sheet “Nope”." in refused(path, SetCell("Nope", 1, 1, "x")).message
    assert "Tracking, Mine" in refused(path, SetCell("Nope", 1, 1, "x")).remedy
    for row, column in [(0, 1), (1, 0), (1_048_577, 1), (1, 16_385)]:
        assert "There is no cell" in refused(path, SetCell(SHEET, row, column, "x")).message
    edit(path, [SetCell("tra cking", 3, 3, "any spelling")])
    assert cell(path, 3, 3) == "any spelling"


def test_merged_cells(tmp_path):
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.merge_range("I2:J3", "first"))
    told = refused(path, SetCell(SHEET, 3, 10, "x"))
    assert told.message == "Tracking!J3 is hidden under I2: the cells I2:J3 are merged."
    assert "I2" in told.remedy
    edit(path, [SetCell(SHEET, 2, 9, "new")])
    assert cell(path, 2, 9) == "new"


def test_array_formulas(tmp_path):
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.write_array_formula("I2:I4", "{=G2:G4*2}"))
    assert "array formula that fills I2:I4" in refused(path, SetCell(SHEET, 2, 9, "x")).message
    assert "I2:I4" in refused(path, SetCell(SHEET, 3, 9, "x")).message


def test_a_formula_of_one_cell_is_replaced_and_the_others_are_calculated_anew(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["formulas"])
    edit(path, [SetCell(SHEET, 2, 8, "text"), SetCell(SHEET, 2, 10, "=text")])
    assert (cell(path, 2, 8), cell(path, 2, 10)) == ("text", "=text")
    assert b'fullCalcOnLoad="1"' in parts(path)["xl/workbook.xml"]
    assert openpyxl.load_workbook(path)[SHEET]["H3"].value == "=G3*2"


def test_shared_formulas_are_written_out_first(path):
    """Excel stores a formula once for the cells that it was filled into; the others survive its replacement."""

    def share(data: bytes) -> bytes:
        for row in range(2, 8):
            master = b' ref="H2:H7">G2*2&lt;3</f>' if row == 2 else b"/>"
            new = b'<c r="H%d"><f t="shared" si="0"%s<v>0</v></c></row>' % (row, master)
            begin = data.index(b'<row r="%d"' % row)
            end = data.index(b"</row>", begin)
            data = data[:end] + new + data[end + 6 :]
        return data

    repack(path, {PART: share})
    assert openpyxl.load_workbook(path)[SHEET]["H5"].value == "=G5*2<3"
    edit(path, [SetCell(SHEET, 2, 8, "gone"), MoveRows(SHEET, 7, 1, before=3)])
    column = [openpyxl.load_workbook(path)[SHEET].cell(row, 8).value for row in range(2, 8)]
    assert column == ["gone", "=G3*2<3", "=G4*2<3", "=G5*2<3", "=G6*2<3", "=G7*2<3"]


def test_excel_tables(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["tables"])
    assert "the header of the Excel table “Parts”" in refused(path, SetCell("Mine", 1, 6, "x")).message
    edit(path, [SetCell("Mine", 2, 6, "inside")])
    table = openpyxl.load_workbook(path)["Mine"].tables["Parts"]
    assert table.ref == "F1:G4"
    edit(path, [SetCell("Mine", 5, 7, "below"), SetCell("Mine", 6, 6, "below that"), SetCell("Mine", 7, 9, "beside")])
    table = openpyxl.load_workbook(path)["Mine"].tables["Parts"]
    assert (table.ref, table.autoFilter.ref) == ("F1:G6", "F1:G6")


# ---- any edits of any small workbook

TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\r\ufffe\uffff"), max_size=12)
VALUE = st.one_of(st.none(), st.booleans(), st.integers(-999, 999), TEXT)
ROW, COUNT = st.integers(2, 9), st.integers(1, 3)
EDIT = st.one_of(
    st.builds(SetCell, st.just("S"), st.integers(1, 9), st.integers(1, 5), VALUE),
    st.builds(InsertRows, st.just("S"), ROW, COUNT),
    st.builds(DeleteRows, st.just("S"), ROW, COUNT),
    st.builds(MoveRows, st.just("S"), ROW, COUNT, ROW),
)


def shown(value: object) -> str:
    return str(value).upper() if isinstance(value, bool) else "" if value is None else str(value)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=example_count(60))
@given(st.dictionaries(st.tuples(st.integers(1, 8), st.integers(1, 5)), VALUE, max_size=15), st.lists(EDIT, max_size=8))
def test_any_edits(cells, edits):
    data = io.BytesIO()
    with xlsxwriter.Workbook(data, {"in_memory": True}) as book:
        sheet = book.add_worksheet("S")
        for (row, column), value in cells.items():
            write = {bool: sheet.write_boolean, int: sheet.write_number}.get(type(value), sheet.write_string)
            write(row - 1, column - 1, "" if value is None else value)
        book.add_worksheet("Other").write(0, 0, "stays")
    wanted = {at: shown(value) for at, value in cells.items() if shown(value)}
    for one in edits:
        if isinstance(one, SetCell):
            wanted.pop((one.row, one.column), None)
            if shown(one.value):
                wanted[one.row, one.column] = shown(one.value)
        else:
            wanted = {(new, c): t for (r, c), t in wanted.items() if (new := one.mapped(r)) is not None}
    new = edited(data.getvalue(), edits)
    book = XlsxBook(new, "x.xlsx")
    assert {at: c.text for at, c in book.sheet(0, Extent.WHOLE).cells.items()} == wanted
    assert {at: c.text for at, c in book.sheet(1, Extent.WHOLE).cells.items()} == {(1, 1): "stays"}
    openpyxl.load_workbook(io.BytesIO(new))
    assert {n: d for n, d in parts(new).items() if n != PART} == {
        n: d for n, d in parts(data.getvalue()).items() if n != PART
    }
