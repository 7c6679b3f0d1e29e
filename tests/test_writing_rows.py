"""Inserting, deleting and moving rows of an .xlsx: what goes with them, and where it is refused."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import openpyxl
import pytest
from lossless import FEATURES, SHEET, make, parts, repack
from openpyxl.worksheet.datavalidation import DataValidation
from test_writing_lossless import PIVOT, pivot, threaded

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.files import edit, make_workbook, read_sheets
from rrp_sheets.workbook.patch.package_edit import PackageEdit

PART = "xl/worksheets/sheet1.xml"
UP = MoveRows(SHEET, 5, 1, before=3)  # rows 3, 4 become 4, 5


def refused(path: Path, *edits) -> SheetsError:
    before = path.read_bytes()
    with pytest.raises(SheetsError) as told:
        edit(path, edits)
    assert path.read_bytes() == before and told.value.remedy
    return told.value


def notes(path: Path) -> list[str]:
    """The column Notes, from row 2 on."""
    cells = read_sheets(path)[0].cells
    return [cells[r, 6].text if (r, 6) in cells else "" for r in range(2, max(r for r, _ in cells) + 1)]


@pytest.mark.parametrize(
    ("change", "seen"),
    [
        (UP, "first fourth second third fifth sixth"),
        (MoveRows(SHEET, 2, 2, before=8), "third fourth fifth sixth first second"),
        (MoveRows(SHEET, 2, 2, before=6), "third fourth first second fifth sixth"),
        (MoveRows(SHEET, 6, 2, before=2), "fifth sixth first second third fourth"),
        (MoveRows(SHEET, 7, 1, before=10), "first second third fourth fifth - - sixth"),
        (InsertRows(SHEET, 2, 2), "- - first second third fourth fifth sixth"),
        (InsertRows(SHEET, 7), "first second third fourth fifth - sixth"),
        (InsertRows(SHEET, 8), "first second third fourth fifth sixth"),
        (DeleteRows(SHEET, 2), "second third fourth fifth sixth"),
        (DeleteRows(SHEET, 4, 99), "first second"),
        (DeleteRows(SHEET, 50, 9), "first second third fourth fifth sixth"),
    ],
)
def test_rows_go_where_they_should(tmp_path, change, seen):
    path = make(tmp_path / "x.xlsx")
    edit(path, [change])
    assert notes(path) == seen.replace("-", "").split(" ")


def test_heights_formats_and_outlines_go_with_their_rows(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["outline"])
    before = openpyxl.load_workbook(path)[SHEET]
    assert (before.row_dimensions[5].height, before.row_dimensions[6].height) == (30, 39.75)
    edit(path, [MoveRows(SHEET, 5, 2, before=2)])
    after = openpyxl.load_workbook(path)[SHEET]
    assert [after.row_dimensions[n].height for n in (2, 3, 5, 6)] == [30, 39.75, None, None]
    assert [after.row_dimensions[n].outlineLevel for n in (2, 3, 5, 6)] == [1, 1, 0, 0]
    assert after.print_area == before.print_area and after.auto_filter.ref == before.auto_filter.ref


def test_new_rows_look_like_the_row_above(tmp_path):
    def feature(book, sheet):
        sheet.set_row(3, 33)
        for column in range(9):
            sheet.write_blank(3, column, None, book.add_format({"num_format": "@", "bg_color": "lime"}))

    path = make(tmp_path / "x.xlsx", feature)
    edit(path, [InsertRows(SHEET, 5, 2)])
    sheet = openpyxl.load_workbook(path)[SHEET]
    for row in (5, 6):
        assert sheet.row_dimensions[row].height == 33
        assert {sheet.cell(row, c).fill.fgColor.rgb for c in range(1, 10)} == {"FF00FF00"}
        assert {sheet.cell(row, c).value for c in range(1, 10)} == {None}
    edit(path, [InsertRows(SHEET, 2)])
    assert openpyxl.load_workbook(path)[SHEET]["A2"].font.b is not True  # not like the header


def test_comments_go_with_their_rows(tmp_path):
    path = threaded(tmp_path / "x.xlsx")
    edit(path, [UP])
    sheet = openpyxl.load_workbook(path)[SHEET]
    assert {c.coordinate: c.comment.text for row in sheet for c in row if c.comment} == {
        "C3": "on the map", "C4": "on the filter",
    }  # fmt: skip
    after = parts(path)
    assert b'threadedComment ref="C3"' in after["xl/threadedComments/threadedComment1.xml"]
    boxes = after["xl/drawings/vmlDrawing1.vml"].decode()
    assert re.findall(r"<x:Row>(\d+)</x:Row>", boxes) == ["3", "2"]
    edit(path, [DeleteRows(SHEET, 3)])
    after = parts(path)
    assert after["xl/comments1.xml"].count(b"<comment ") == 1 and b'ref="C3"' in after["xl/comments1.xml"]
    assert b"<threadedComment " not in after["xl/threadedComments/threadedComment1.xml"]
    assert after["xl/drawings/vmlDrawing1.vml"].count(b"<v:shape ") == 1


def test_the_boxes_of_comments_keep_their_distance(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["comments"])

    def anchors():
        found = re.findall(rb"<x:Anchor>([^<]*)</x:Anchor>", parts(path)["xl/drawings/vmlDrawing1.vml"])
        return [[int(n) for n in a.split(b",")] for a in found]

    before = anchors()
    edit(path, [InsertRows(SHEET, 3, 10)])
    for old, new in zip(before, anchors(), strict=True):
        assert [b - a for a, b in zip(old, new, strict=True)] == [0, 0, 10, 0, 0, 0, 10, 0]


def test_buttons_stay_when_comments_move(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["buttons"])
    before = parts(path)["xl/drawings/vmlDrawing1.vml"]
    edit(path, [MoveRows(SHEET, 4, 1, before=8)])
    after = parts(path)["xl/drawings/vmlDrawing1.vml"]
    button = re.compile(rb'<v:shape [^>]*>(?:(?!</v:shape>).)*ObjectType="Button".*?</v:shape>', re.DOTALL)
    assert button.search(after)[0] == button.search(before)[0]
    assert b"<x:Row>6</x:Row>" in after


def test_links_go_with_their_rows(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["links"])

    def links():
        sheet = openpyxl.load_workbook(path)[SHEET]
        return {c.coordinate: c.hyperlink.target or c.hyperlink.location for row in sheet for c in row if c.hyperlink}

    edit(path, [UP])
    assert links() == {"F3": "Mine!A1", "F4": "https://example.org/a?b=1&c=2"}
    edit(path, [DeleteRows(SHEET, 3, 2)])
    assert links() == {} and b"<hyperlinks" not in parts(path)[PART]


def test_formulas_of_the_sheet_follow_their_rows(tmp_path):
    def feature(book, sheet):
        for row in range(2, 8):
            sheet.write_formula(f"H{row}", f"=G{row}*2+$G${row}")
            sheet.write_formula(f"I{row}", f'=I{row - 1}+1&"G3"' if row > 2 else "=1")
        sheet.write_formula("K1", "=SUM(G2:G7)+G3+Mine!A3")
        sheet.write_array_formula("J4:J4", "{=SUM(G4:H4)}")

    path = make(tmp_path / "x.xlsx", feature)
    edit(path, [InsertRows(SHEET, 3, 2)])
    sheet = openpyxl.load_workbook(path)[SHEET]
    assert [sheet["H2"].value, sheet["H5"].value, sheet["I5"].value] == ["=G2*2+$G$2", "=G5*2+$G$5", '=I2+1&"G3"']
    assert sheet["K1"].value == "=SUM(G2:G9)+G5+Mine!A3"
    assert (sheet["J6"].value.ref, sheet["J6"].value.text) == ("J6", "=SUM(G6:H6)")
    edit(path, [DeleteRows(SHEET, 3, 2)])
    assert openpyxl.load_workbook(path)[SHEET]["K1"].value == "=SUM(G2:G7)+G3+Mine!A3"


def test_formulas_of_ours_are_no_references(tmp_path):
    """`=a5*2` in the column Formula means the stream a5; it neither follows nor hinders."""
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.write_formula("C3", "=a5*2", None, "#NAME?"))
    edit(path, [UP])
    assert openpyxl.load_workbook(path)[SHEET]["C4"].value == "=a5*2"


FAR = MoveRows(SHEET, 2, 1, before=12)
REFERRING = {
    "the formula in Mine!E1": lambda book, sheet: book.get_worksheet_by_name("Mine").write("E1", "=Tracking!G3*2"),
    "the formula in Tracking!L9": lambda book, sheet: sheet.write("L9", "=SUM(G2:G4)"),
    "the name “Third”": lambda book, sheet: book.define_name("Third", "=Tracking!$G$3"),
    "the name “Some”": lambda book, sheet: book.define_name("Some", "=Tracking!$G$2:$G$4"),
    "a drop-down list": lambda book, sheet: sheet.data_validation("A9", {"validate": "list", "source": "=$G$2:$G$4"}),
    "a conditional format": lambda book, sheet: book.get_worksheet_by_name("Mine").conditional_format(
        "A1:A9", {"type": "formula", "criteria": "=Tracking!$G$3>1", "format": book.add_format({"bold": True})}
    ),
    "a shape or a button": lambda book, sheet: sheet.insert_textbox("J2", "x", {"textlink": "=$G$3"}),
}


@pytest.mark.parametrize("who", REFERRING)
def test_references_that_cannot_follow(tmp_path, who):
    path = make(tmp_path / "x.xlsx", REFERRING[who])
    if who == "a shape or a button":
        repack(path, {"xl/drawings/drawing1.xml": lambda data: data.replace(b'"$G$3"', b'"Tracking!$G$3"')})
    change = FAR if "L9" not in who else MoveRows(SHEET, 3, 1, before=8)
    told = refused(path, change)
    assert who.casefold() in told.message.casefold() and "would then mean something else" in told.message


def test_rows_are_inserted_in_a_sheet_whose_shape_has_no_linked_cell(tmp_path):
    path = make(tmp_path / "x.xlsx", REFERRING["a shape or a button"])
    repack(path, {"xl/drawings/drawing1.xml": lambda data: data.replace(b'textlink="$G$3"', b'textlink=""')})
    edit(path, [InsertRows(SHEET, 3, 1)])
    with zipfile.ZipFile(path) as book:
        assert b'textlink=""' in book.read("xl/drawings/drawing1.xml")


def test_charts_and_pivot_tables(tmp_path):
    def feature(book, sheet):
        chart = book.add_chart({"type": "line"})
        chart.add_series({"values": "=Tracking!$G$2:$G$5"})
        sheet.insert_chart("J2", chart)

    path = make(tmp_path / "x.xlsx", feature)
    assert "A chart refers to the rows 2 to 5" in refused(path, MoveRows(SHEET, 6, 1, before=3)).message
    edit(path, [MoveRows(SHEET, 5, 1, before=3)])  # within the range: the same contents
    path = pivot(tmp_path / "y.xlsx")
    assert b'ref="A1:G7"' in PIVOT
    assert "A pivot table" in refused(path, InsertRows(SHEET, 4)).message
    edit(path, [UP])


def test_rules_that_cover_the_table_stay_and_hinder_nothing(tmp_path):
    def feature(book, sheet):
        FEATURES["conditional formats"](book, sheet)
        FEATURES["validations"](book, sheet)
        book.define_name("Everything", "=Tracking!$A$2:$G$200")

    path = make(tmp_path / "x.xlsx", feature)
    before = re.findall(rb"<(?:conditionalFormatting|dataValidation)\b.*?>", parts(path)[PART])
    edit(path, [UP, InsertRows(SHEET, 4), DeleteRows(SHEET, 2)])
    assert re.findall(rb"<(?:conditionalFormatting|dataValidation)\b.*?>", parts(path)[PART]) == before


def test_the_header_stays(tmp_path):
    path = make(tmp_path / "x.xlsx")
    for change in (
        InsertRows(SHEET, 1),
        DeleteRows(SHEET, 1),
        MoveRows(SHEET, 3, 1, before=1),
        MoveRows(SHEET, 1, 1, 4),
    ):
        told = refused(path, change)
        assert "Row 1 of “Tracking” has the headers" in told.message and "2" in told.remedy
    edit(path, [InsertRows("Mine", 1)])  # a sheet of the user's own has none
    assert read_sheets(path)[1].cells[2, 1].text == "10"


def test_merged_cells_and_filters_and_arrays(tmp_path):
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.merge_range("I4:J5", "first"))
    for change in (UP, InsertRows(SHEET, 5), InsertRows(SHEET, 2), DeleteRows(SHEET, 5)):
        assert "the merged cells I4:J5" in refused(path, change).message
    edit(path, [MoveRows(SHEET, 6, 1, before=8), InsertRows(SHEET, 6), DeleteRows(SHEET, 7)])
    path = make(tmp_path / "y.xlsx", lambda book, sheet: sheet.write_array_formula("I4:I5", "{=G4:G5}"))
    assert "an array formula I4:I5" in refused(path, UP).message
    path = make(tmp_path / "z.xlsx", lambda book, sheet: book.get_worksheet_by_name("Mine").autofilter("A2:A3"))
    assert "head of a filter" in refused(path, InsertRows("Mine", 1)).message


def test_excel_tables_grow_and_shrink(tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES["tables"])

    def reach():
        return openpyxl.load_workbook(path)[SHEET].tables["Behaviour"].ref

    edit(path, [UP])
    assert reach() == "A1:G7"
    edit(path, [InsertRows(SHEET, 4, 2)])
    assert reach() == "A1:G9"
    edit(path, [DeleteRows(SHEET, 2, 3)])
    assert reach() == "A1:G6"
    edit(path, [SetCell(SHEET, 7, 1, "below"), InsertRows(SHEET, 12)])
    assert reach() == "A1:G7"
    for change in (
        MoveRows(SHEET, 6, 1, before=9),
        DeleteRows(SHEET, 7, 2),
        InsertRows("Mine", 1),
        DeleteRows(SHEET, 2, 6),
    ):
        assert "edge of the Excel table" in refused(path, change).message


@pytest.mark.parametrize("change", [InsertRows(SHEET, 0), InsertRows(SHEET, 3, 0), DeleteRows(SHEET, -1), MoveRows(SHEET, 3, -1, 5),
                                    InsertRows(SHEET, 3, 10**9), MoveRows(SHEET, 3, 1, 10**9)])  # fmt: skip
def test_rows_that_are_none(tmp_path, change):
    assert "There are no such rows" in refused(make(tmp_path / "x.xlsx"), change).message


def test_the_last_row_of_a_sheet_is_in_use(tmp_path):
    path = make(tmp_path / "x.xlsx", lambda book, sheet: sheet.write(1_048_575, 0, "last"))
    assert "no row fits in" in refused(path, InsertRows(SHEET, 4)).message


def test_what_covers_the_whole_table_grows_with_it(tmp_path):
    """Drop-downs, colours and lists of a sheet of ours, also of one longer than they were made for."""
    header = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
    rows = [["", "Red ball", "map", "redBall.x", f"S{n}", ""] for n in range(300)]
    devices = [["Stream", "Device", "Notes"], *([f"B{n}", "Red ball", ""] for n in range(250))]
    path = tmp_path / "x.xlsx"
    make_workbook({"T": [header, *rows], "Devices": devices}, path)

    def marks() -> tuple[set[str], set[str]]:
        book = openpyxl.load_workbook(path)
        sheet = book["T"]
        lists = {str(block) for v in sheet.data_validations.dataValidation for block in v.sqref.ranges}
        formats = {str(block) for f in sheet.conditional_formatting for block in f.sqref.ranges}
        formulas = {r for f in sheet.conditional_formatting for rule in f.rules for t in rule.formula
                    for r in re.findall(r"\$E\$2:\$E\$\d+", t)}  # fmt: skip
        return lists | formats | formulas, {book.defined_names["List_streams"].attr_text}

    assert {re.sub(r"\D+", " ", m).split()[-1] for m in marks()[0]} == {"301"}
    edit(path, [InsertRows("T", 100, 2), InsertRows("Devices", 3)])
    assert {re.sub(r"\D+", " ", m).split()[-1] for m in marks()[0]} == {"353"}  # the last row is 303, and 50 to spare
    assert marks()[1] == {"'Devices'!$A$2:$A$302"}
    edit(path, [SetCell("T", 354, 2, "Red ball")])
    assert {re.sub(r"\D+", " ", m).split()[-1] for m in marks()[0]} == {"404"}
    edit(path, [SetCell("T", 355, 2, "Red ball"), InsertRows("T", 20)])
    assert {re.sub(r"\D+", " ", m).split()[-1] for m in marks()[0]} == {"404"}  # still enough


@pytest.mark.parametrize("name", ["Anna's", "A & B", '"Mine"'])
def test_drop_downs_of_a_quoted_sheet_grow_with_it(tmp_path, name):
    header = ["Input streams", "Connector", "Formula", "Output stream"]
    path = make_workbook({"T": [header], name: [header, ["Red ball", "map", "1", "X"]]}, tmp_path / "x.xlsx")
    book = openpyxl.load_workbook(path)
    quoted = name.replace("'", "''")
    offered = DataValidation("list", formula1=f"'{quoted}'!$A$2:$A$3", sqref="A2:A99")
    book["T"].data_validations.dataValidation = [offered]
    book.save(path)
    edit(path, [InsertRows(name, 3), SetCell(name, 4, 1, "Red ball")])
    (offered,) = openpyxl.load_workbook(path)["T"].data_validations.dataValidation
    assert offered.formula1 == f"'{quoted}'!$A$2:$A$54"


def test_a_part_that_was_written_is_parsed_as_it_is_now(tmp_path):
    package = PackageEdit(make(tmp_path / "x.xlsx").read_bytes(), "x.xlsx")
    package.write("docProps/core.xml", b"<new/>")
    assert package.part("docProps/core.xml").root.tag == "new"
    package.write("docProps/core.xml", b"")
    assert package.read("docProps/core.xml") == b""
    assert parts(package.to_bytes())["docProps/core.xml"] == b""
