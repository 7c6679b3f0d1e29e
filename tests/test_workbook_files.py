"""The formats: .xlsx as Excel writes it, folders of CSV files, and that all formats give one model."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import openpyxl
import pytest
import xlsxwriter
from busy import work_within
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openpyxl.worksheet.formula import ArrayFormula

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.workbook import Reading, read, to_sheets
from rrp_sheets.workbook.files import FORMATS, WORKBOOK_SUFFIXES, make_workbook

HEADERS = ["Input streams", "Connector", "Formula", "Output stream", "On", "Priority", "Notes"]


def codes(reading: Reading) -> list[tuple[str, str]]:
    return reading.report.flatten(["code", "cell"])


def workbook(path: Path, *rows: list[object], headers: list[str] = HEADERS):  # type: ignore[no-untyped-def]
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Tracking"
    sheet.append(headers)
    for row in rows:
        sheet.append(row)
    return book, sheet


def saved(book: openpyxl.Workbook, path: Path) -> Reading:
    book.save(path / "x.xlsx")
    return read(path / "x.xlsx")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "text", "original"),
    [
        (1000.0, "1000", "1000"),
        (0.1, "0.1", "0.1"),
        (True, "TRUE", "TRUE"),
        ("=ball.distance<20", "ball.distance<20", "=ball.distance<20"),
        ("=_xlfn.SINGLE(ball)+_xlfn._xlws.FILTER(a)", "ball+FILTER(a)", None),
        (ArrayFormula("C2", "=a+b"), "a+b", "=a+b"),
        ("  spaces ", "spaces", "  spaces "),
        ("=IF(x<1,2,3)", "IF(x<1,2,3)", "=IF(x<1,2,3)"),
        (-0.5, "-0.5", "-0.5"),
        (2e20, "2e+20", None),
    ],
)
def test_values_of_formula_cells(tmp_path: Path, value: object, text: str, original: str | None) -> None:
    book, _ = workbook(tmp_path, ["x", "map", value, "Y"])
    reading = saved(book, tmp_path)
    cell = reading.workbook.behaviours[0].rows[0].formula
    assert codes(reading) == []
    assert cell.text == text
    assert original is None or cell.original == original


@pytest.mark.slow
@pytest.mark.parametrize(
    "value", [dt.datetime(2026, 1, 2), dt.time(12, 30), dt.date(2026, 5, 4), dt.timedelta(hours=2)]
)
@pytest.mark.parametrize("column", [1, 2, 3, 4, 5, 6])
def test_dates_are_errors(tmp_path: Path, value: object, column: int) -> None:
    book, sheet = workbook(tmp_path, ["x", "map", "1", "Y"])
    sheet.cell(2, column, value)
    found = codes(saved(book, tmp_path))
    assert ("SHEET006", f"{'ABCDEF'[column - 1]}2") in found


def test_dates_in_notes_protocol_and_own_sheets_are_fine(tmp_path: Path) -> None:
    book, _ = workbook(tmp_path, ["x", "map", "1", "Y", None, None, dt.date(2026, 1, 2)])
    protocol = book.create_sheet("Protocol")
    protocol.append(["Field", "Value"])
    protocol.append(["Approved on", dt.date(2026, 1, 2)])
    protocol.append(["Time limit", dt.time(0, 10)])
    book.create_sheet("Mine").append([dt.date(2026, 1, 2)])
    reading = saved(book, tmp_path)
    assert codes(reading) == [("SHEET006", "B3")]
    assert reading.workbook.protocol.text("Approved on") == "2026-01-02"
    assert reading.workbook.behaviours[0].rows[0].notes == "2026-01-02"


def test_the_date_message_says_what_to_do(tmp_path: Path) -> None:
    book, _ = workbook(tmp_path, ["x", "map", dt.date(2026, 1, 2), "Y"])
    (finding,) = saved(book, tmp_path).report
    assert finding.remedy == "Format the cell as Text and type it again."
    assert str(finding.address) == "Tracking!C2"


def test_evaluated_formulas_in_name_cells(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "x.xlsx") as book:
        sheet = book.add_worksheet("Tracking")
        sheet.write_row(0, 0, HEADERS)
        sheet.write_formula(1, 0, "=Names!A1", None, "Red ball")  # the user sees Red ball
        sheet.write_row(1, 1, ["map"])
        sheet.write_formula(1, 2, "=ball.x<20", None, "#NAME?")
        sheet.write_formula(1, 3, "=Result", None, "#NAME?")
    row = read(tmp_path / "x.xlsx").workbook.behaviours[0].rows[0]
    assert [row.inputs[0].text, row.formula.text] == ["Red ball", "ball.x<20"]


def test_error_values(tmp_path: Path) -> None:
    book, _ = workbook(tmp_path, ["x", "map", "#REF!", "Y"])
    assert codes(saved(book, tmp_path)) == [("SHEET007", "C2")]


def test_shared_formulas(tmp_path: Path) -> None:
    import zipfile

    book, _ = workbook(tmp_path, ["x", "map", "=A2+1", "Y"], ["x", "map", "=0", "Z"])
    book.save(tmp_path / "a.xlsx")
    with zipfile.ZipFile(tmp_path / "a.xlsx") as old, zipfile.ZipFile(tmp_path / "x.xlsx", "w") as new:
        for name in old.namelist():
            data = old.read(name).replace(b"<f>A2+1</f>", b'<f t="shared" ref="C2:C3" si="0">A2+1</f>')
            new.writestr(name, data.replace(b"<f>0</f>", b'<f t="shared" si="0"/>'))
    rows = read(tmp_path / "x.xlsx").workbook.behaviours[0].rows
    assert [r.formula.text for r in rows] == ["A2+1", "A3+1"]


def test_merged_and_hidden(tmp_path: Path) -> None:
    book, sheet = workbook(tmp_path, *(["x", "map", "1", f"Y{i}"] for i in range(9)))
    sheet.merge_cells("A3:A4")
    sheet.merge_cells("C6:D6")
    sheet.merge_cells("Z1:Z9")
    sheet.merge_cells("A60:B61")  # below the table
    for row in (5, 6, 9, 40):
        sheet.row_dimensions[row].hidden = True
    reading = saved(book, tmp_path)
    assert codes(reading) == [("SHEET008", "A4"), ("SHEET009", "A5"), ("SHEET008", "D6"), ("SHEET009", "A9")]
    assert "Rows 5 to 6" in next(d for d in reading.report if d.code == "SHEET009").message


def test_hidden_sheet_and_hidden_rows_that_are_off(tmp_path: Path) -> None:
    book, sheet = workbook(tmp_path, ["x", "map", "1", "Y", "off"], ["x", "map", "1", "Z"])
    sheet.row_dimensions[2].hidden = True
    sheet.sheet_state = "hidden"
    book.create_sheet("Mine")
    assert codes(saved(book, tmp_path)) == [("SHEET010", "")]


def test_own_columns_and_own_sheets_are_left_alone(tmp_path: Path) -> None:
    book, _ = workbook(tmp_path, ["1", "x", "map", "1", "Y", dt.date(2026, 1, 1)],
                       headers=["#", *HEADERS[:4], "When"])  # fmt: skip
    mine = book.create_sheet("Mine")
    for i in range(2_000):
        mine.append([i, "#NAME?", dt.date(2026, 1, 1)])
    reading = saved(book, tmp_path)
    assert codes(reading) == []
    assert len(reading.workbook.behaviours[0].rows) == 1
    assert max(row for row, _ in reading.sheets[1].cells) == 20


def test_tables_of_an_xlsx(tmp_path: Path) -> None:
    book, _ = workbook(tmp_path, ["x", "map", "INDEX(Parts; x)", "Y"])
    parts = book.create_sheet("Parts")
    parts.append([])
    parts.append([None, "Zone", "Points"])
    parts.append([None, "Head", 2.0])
    parts.append([None, "Foot", True])
    assert saved(book, tmp_path).workbook.tables["parts"] == (("Zone", "Points"), ("Head", "2"), ("Foot", "TRUE"))


@pytest.mark.slow
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_csv_dialects(tmp_path: Path, delimiter: str, encoding: str) -> None:
    lines = [delimiter.join(HEADERS[:4]), delimiter.join(['"Größe, x\ny"', "map", '"IF(a;b,1)"', "Y"])]
    (tmp_path / "Grüße.csv").write_bytes("\r\n".join(lines).encode(encoding))
    reading = read(tmp_path)
    (row,) = reading.workbook.behaviours[0].rows
    assert (reading.format, reading.workbook.sheets, codes(reading)) == ("csv", ("Grüße",), [])
    assert [c.text for c in row.inputs] == ["Größe", "x", "y"]
    assert row.formula.text == "IF(a;b,1)"


def test_csv_folder_order_and_hint(tmp_path: Path) -> None:
    (tmp_path / "10 Look.csv").write_text("sep=;\n" + ";".join(HEADERS[:4]) + "\nx;map;a,b,c,d,e,f;Y\n")
    (tmp_path / "2 Greet.CSV").write_text(",".join(HEADERS[:4]) + "\n'=x,map,'=1,Y\n")
    (tmp_path / "~$lock.csv").write_text("x")
    (tmp_path / "notes.txt").write_text("x")
    reading = read(tmp_path)
    assert [b.name for b in reading.workbook.behaviours] == ["2 Greet", "10 Look"]
    assert [b.rows[0].number for b in reading.workbook.behaviours] == [2, 2]
    assert [b.rows[0].formula.text for b in reading.workbook.behaviours] == ["1", "a,b,c,d,e,f"]


def test_the_digest_of_a_folder_names_its_sheets(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x")
    first = read(tmp_path).digest
    (tmp_path / "a.csv").rename(tmp_path / "b.csv")
    assert read(tmp_path).digest != first


def test_a_name_too_long_for_the_system() -> None:
    with pytest.raises(UnreadableFile) as error:
        read("x" * 5_000)
    assert error.value.code in ("FILE001", "FILE016")


TEXT = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cs", "Cc"), exclude_characters="\u2028\u2029\ufffe\uffff"),
    max_size=30,
)
CELL = st.one_of(
    TEXT, st.sampled_from(["=x", "'=x", "'a'", "“a”", "#x", "#NAME?", "a|b", "a, b、c", "\\", "12", "off"])
)
ROWS = st.lists(st.lists(CELL, min_size=7, max_size=7), max_size=6)
QUICK = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def content(w: Workbook) -> object:
    """Content of a workbook, without places."""
    return [
        [(r.number, [c.text for c in r.inputs], r.connector.text, r.formula.text, r.output.text, r.on, r.priority)
         for r in b.rows]
        for b in w.behaviours
    ]  # fmt: skip


@pytest.mark.slow
@given(rows=ROWS)
@QUICK
def test_formats_are_twins(rows: list[list[str]], tmp_path: Path) -> None:
    import csv

    rows = [[c.strip() for c in row] for row in rows]
    folder = tmp_path / "folder"
    folder.mkdir(exist_ok=True)
    with (folder / "A.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([HEADERS, *rows])
    lines = ["| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in [HEADERS, *rows]]
    lines.insert(1, "|" + "---|" * 7)
    (tmp_path / "x.md").write_text("\n".join(["## A", *lines]), encoding="utf-8")
    readings = [read(folder)]
    if not any(c.endswith("\\") or "\\|" in c or "<br" in c.casefold() for row in rows for c in row):
        readings.append(read(tmp_path / "x.md"))
    for one in FORMATS:
        path = tmp_path / f"written{one.suffixes[0]}"
        path.write_bytes(one.write({"A": [HEADERS, *rows]}))
        readings.append(read(path))
    first = readings[0]
    for other in readings[1:]:
        assert content(other.workbook) == content(first.workbook)
        assert codes(other) == codes(first)


@given(data=st.binary(max_size=400), suffix=st.sampled_from([".csv", "", *WORKBOOK_SUFFIXES]))
@QUICK
def test_arbitrary_bytes(data: bytes, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"x{suffix}"
    path.write_bytes(data)
    try:
        read(path)
    except UnreadableFile as error:
        assert error.message


@given(at=st.integers(0, 10_000), byte=st.integers(0, 255))
@settings(max_examples=example_count(150), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_flipped_byte(at: int, byte: int, tmp_path: Path) -> None:
    source = tmp_path / "good.xlsx"
    if not source.exists():
        workbook(tmp_path, ["x", "map", "1", "Y"])[0].save(source)
    data = bytearray(source.read_bytes())
    data[at % len(data)] = byte
    (tmp_path / "bad.xlsx").write_bytes(data)
    try:
        read(tmp_path / "bad.xlsx")
    except UnreadableFile as error:
        assert error.message


def test_a_copy_as_xlsx_says_the_same(tmp_path: Path) -> None:
    text = "## A\n| From | Connector | Formula | To |\n|---|---|---|---|\n| x, y | map | =PICK(Words) | Y |\n"
    (tmp_path / "x.md").write_text(text + "## Words\n| W |\n|---|\n| =hello |\n| 007 |\n")
    first = read(tmp_path / "x.md")
    make_workbook(to_sheets(first), tmp_path / "copy.xlsx")
    copy = read(tmp_path / "copy.xlsx")
    assert content(copy.workbook) == content(first.workbook)
    assert copy.workbook.tables == first.workbook.tables == {"words": (("W",), ("=hello",), ("007",))}


@pytest.mark.slow
def test_reading_is_fast(tmp_path: Path) -> None:
    # about 0.05 s and 0.4 s, after a first time that imports; the limits leave room for a slow machine
    for rows, limit in ((100, 60.0), (1_000, 1.0), (10_000, 6.0)):
        with xlsxwriter.Workbook(tmp_path / "x.xlsx") as book:
            sheet = book.add_worksheet("Tracking")
            sheet.write_row(0, 0, HEADERS)
            for i in range(1, rows):
                sheet.write_row(i, 0, [f"Stream {i - 1}", "map", f"stream{i - 1} + {i}", f"Stream {i}", "", i % 7])
        with work_within(limit):
            read(tmp_path / "x.xlsx")
