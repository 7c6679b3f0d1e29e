"""`set`, `convert` and `check --report`, as a user types them."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import openpyxl
import pytest
from lossless import FEATURES, SHEET, make, parts, repack
from typed import run

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import read_sheets

WRONG = """## Tracking

| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | redBall.distance +* 2 | Distance |
| Distance | filtr | distance < 1 | Near |
| Neer | subscribe |  | Head tracker |
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    api.new(tmp_path / "my 手順.xlsx")
    return tmp_path / "my 手順.xlsx"


@pytest.fixture
def wrong(tmp_path: Path) -> Path:
    (tmp_path / "wrong.md").write_text(WRONG, encoding="utf-8")
    return tmp_path / "wrong.md"


# ---- set


def test_set_says_what_was_and_what_is(path):
    code, told = run("set", path, "Tracking!C3", "distance < 1")
    assert (code, told) == (0, "Tracking!C3: “distance < reach” → “distance < 1”\nCheck: Everything is in order.\n")
    assert run("set", path, "c3", "distance < 1")[1].startswith("Tracking!C3 is “distance < 1” already.")
    assert run("set", path, "C2", "0.7", "--sheet", "helpers")[1].startswith("Helpers!C2: “0.5” → “0.7”")
    assert run("set", path, "'Read me'!A40", "=note")[1].startswith("Read me!A40: empty → “=note”")
    assert run("set", path, "F3", "")[1].startswith("Tracking!F3: “reach is a number in the sheet Helpers” → empty")
    assert run("set", path, "C3", "-1")[1].startswith("Tracking!C3: “distance < 1” → “-1”")
    assert read(path).workbook.behaviours[0].rows[1].formula.text == "-1"


def test_set_tells_the_errors_there_are_now(path):
    code, told = run("set", path, "B3", "filtr")
    assert (
        code == 0 and "Check: 1 error.\nerror CONN002 Tracking!B3: " in told and told.endswith("Did you mean filter?\n")
    )
    _, told = run("set", path, "C2", "2 +")  # two errors: the one of this cell comes first
    assert "Check: 2 errors.\nerror FORM001 Tracking!C2: " in told and "\nerror CONN002 Tracking!B3: " in told
    assert "All of them" not in told


def test_set_shows_a_few_of_many_errors(path):
    for cell in ("B2", "B3", "B4"):
        run("set", path, cell, "nothing of the kind")
    run("set", path, "Scene!C2", "flies")
    _, told = run("set", path, "D4", "")
    assert told.count("\nerror ") == 3 and told.endswith(f'All of them: rrp-sheets check "{path}"\n')


def test_set_tells_a_warning(path):
    assert "Check: 1 warning.\nwarning LINT015 Tracking!C3: " in run("set", path, "C3", "3")[1]


@pytest.mark.parametrize(
    ("cell", "words"),
    [("Nope!A1", "There is no sheet “Nope”"), ("5C", "“5C” is not a cell"), ("", "is not a cell"), ("A0", "is not a cell"),
     ("XFE1", "is not a cell")],
)  # fmt: skip
def test_set_where_there_is_no_cell(path, cell, words):
    before = path.read_bytes()
    code, told = run("set", path, cell, "x")
    assert code == 2 and words in told and "→" in told
    assert path.read_bytes() == before


def test_set_in_text_files(wrong, tmp_path):
    assert run("set", wrong, "B3", "filter")[1].startswith("Tracking!B3: “filtr” → “filter”")
    assert wrong.read_text("utf-8") == WRONG.replace("filtr ", "filter ").replace("| filtr |", "| filter |")
    api.convert(wrong, tmp_path / "folder")
    assert run("set", tmp_path / "folder", "A4", "Near")[1].startswith("Tracking!A4: “Neer” → “Near”")
    assert [d.code for d in api.check(tmp_path / "folder").report.errors] == ["FORM001"]


# ---- convert


def test_convert(path, tmp_path):
    for out in ("x.md", "folder", "back.xlsx"):
        source = path if out != "back.xlsx" else tmp_path / "folder"
        assert run("convert", source, tmp_path / out) == (0, f"Created {tmp_path / out}.\n")
        assert not api.check(tmp_path / out).report.errors
    assert run("convert", path, "-o", tmp_path / "y.md") == (0, f"Created {tmp_path / 'y.md'}.\n")
    assert (tmp_path / "y.md").read_bytes() == (tmp_path / "x.md").read_bytes()
    for wrong in ((), (tmp_path / "z.md", "-o", tmp_path / "z.md")):
        code, told = run("convert", path, *wrong)
        assert code == 2 and "Name one file or folder to write" in told
    code, told = run("convert", path, tmp_path / "x.md")
    assert code == 2 and "already a file" in told


# ---- check --report


def report_of(path: Path, tmp_path: Path) -> Path:
    out = tmp_path / "report.xlsx"
    before = path.read_bytes()
    code, told = run("check", path, "--report", out)
    assert path.read_bytes() == before
    assert code == bool(api.check(path).report.errors) and f"Created {out}" in told
    return out


@pytest.mark.parametrize(
    ("environment", "option", "written"),
    [("C", (), "Findings"), ("ja_JP.UTF-8", (), "点検結果"),
     ("ja_JP.UTF-8", ("--language", "en"), "Findings"), ("en_US.UTF-8", ("--language", "ja"), "点検結果")],
)  # fmt: skip
def test_the_report_is_in_the_language_of_the_reader(wrong, tmp_path, monkeypatch, environment, option, written):
    monkeypatch.setenv("LC_ALL", environment)
    out = tmp_path / "report.xlsx"
    run("check", wrong, "--report", out, *option)
    book = openpyxl.load_workbook(out)
    assert book["Tracking"]["E1"].value == book.sheetnames[-1] == written
    assert ("This formula cannot be read" in book["Tracking"]["E2"].value) == (written == "Findings")


@pytest.mark.parametrize("kind", ["md", "xlsx"])
def test_findings_stand_beside_their_rows(wrong, tmp_path, kind):
    path = wrong if kind == "md" else api.convert(wrong, tmp_path / "wrong.xlsx")
    out = report_of(path, tmp_path)
    book = openpyxl.load_workbook(out)
    sheet = book["Tracking"]
    assert sheet["E1"].value == "Findings"
    for row, cell, code in [(2, "C2", "FORM001"), (3, "B3", "CONN002"), (4, "A4", "GRAPH001")]:
        assert sheet.cell(row, 5).value.startswith(f"{cell}: Error {code}: ") and " → " in sheet.cell(row, 5).value
        assert sheet[cell].fill.fgColor.rgb == sheet.cell(row, 5).fill.fgColor.rgb == "FFF8C9C4"
        assert sheet[cell].border.left.style == "medium" and sheet[cell].number_format == "@"
        assert sheet[cell].value == openpyxl.load_workbook(out)["Tracking"][cell].value
    assert sheet["D3"].fill.fgColor.rgb != "FFF8C9C4"
    assert sheet.column_dimensions["E"].width == 70
    last = book.worksheets[-1]
    assert (last.title, last["A1"].value) == ("Findings", "3 errors")
    assert last["A2"].value == "Some checks need the errors fixed first, so more problems may appear."
    assert [[c.value for c in row][:3] for row in last["A4:C6"]] == [
        ["Tracking!C2", "Error", "FORM001"], ["Tracking!B3", "Error", "CONN002"], ["Tracking!A4", "Error", "GRAPH001"],
    ]  # fmt: skip
    assert last["A4"].hyperlink.location == "'Tracking'!C2"
    assert [d.code for d in api.check(out).report.errors] == [d.code for d in api.check(path).report.errors]


@pytest.mark.slow
@pytest.mark.parametrize("feature", FEATURES)
@pytest.mark.filterwarnings("ignore:.*extension is not supported")
def test_a_report_keeps_all_other_parts(feature, tmp_path):
    path = make(tmp_path / "x.xlsx", FEATURES[feature])
    run("set", path, "B3", "filtr")
    before, after = parts(path), parts(report_of(path, tmp_path))
    added = {"xl/worksheets/findings1.xml"}
    allowed = {
        "xl/worksheets/sheet1.xml",
        "xl/workbook.xml",
        "xl/styles.xml",
        "[Content_Types].xml",
        "xl/_rels/workbook.xml.rels",
    }
    assert set(after) - set(before) == added and set(before) <= set(after)
    assert {n for n in before if before[n] != after[n]} <= allowed
    cells = {at: c.text for at, c in read_sheets(path)[0].cells.items()}
    marked = {at: c.text for at, c in read_sheets(tmp_path / "report.xlsx")[0].cells.items()}
    assert {at: t for at, t in marked.items() if at in cells} == cells
    new = {t for at, t in marked.items() if at not in cells}
    assert "Findings" in new and all(t == "Findings" or re.match(r"[A-Z]+\d+: ", t) for t in new)
    styles = after["xl/styles.xml"].decode()
    for name in ("fonts", "fills", "borders", "cellXfs"):
        count, inside = re.search(rf'<{name} count="(\d+)"[^>]*>(.*?)</{name}>', styles, re.DOTALL).groups()
        one = {"fonts": "font", "fills": "fill", "borders": "border", "cellXfs": "xf"}[name]
        assert int(count) == len(re.findall(rf"<{one}[ />]", inside))
    openpyxl.load_workbook(tmp_path / "report.xlsx")


def test_a_report_replaces_only_a_report(wrong, tmp_path):
    out = report_of(wrong, tmp_path)
    report_of(wrong, tmp_path)
    other = api.new(tmp_path / "other.xlsx")
    with pytest.raises(SheetsError, match="already a file"):
        api.mark(wrong, other, api.check(wrong).report)
    with pytest.raises(SheetsError, match=r"ends in \.xlsx"):
        api.mark(wrong, tmp_path / "x.pdf", api.check(wrong).report)
    assert out.exists()


def test_a_report_of_a_workbook_in_order(tmp_path):
    out = report_of(bundled("workbooks", "simple-tracking.xlsx"), tmp_path)
    assert openpyxl.load_workbook(out).worksheets[-1]["A1"].value == "Everything is in order."


def test_a_report_of_a_report_and_of_a_sheet_called_findings(wrong, tmp_path):
    wrong.write_text(WRONG + "\n## Findings\n\n| mine |\n|---|\n| 1 |\n", encoding="utf-8")
    first = report_of(wrong, tmp_path)
    (tmp_path / "again").mkdir()
    second = report_of(first, tmp_path / "again")
    names = openpyxl.load_workbook(second).sheetnames
    assert len(names) == len(set(names)) and names[1] == "Findings"


def test_a_report_of_a_workbook_without_styles(wrong, tmp_path):
    """Some programs write none; the findings are told all the same."""
    source = parts(make(tmp_path / "a.xlsx"))
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as package:
        for name, data in source.items():
            if name != "xl/styles.xml":
                named = re.sub(rb"<(?:Override|Relationship) [^>]*/styles[^>]*>", b"", data)
                package.writestr(name, re.sub(rb' (?:s|style)="\d+"', b"", named))
    path = tmp_path / "x.xlsx"
    path.write_bytes(out.getvalue())
    run("set", path, "B3", "filtr")
    sheet = openpyxl.load_workbook(report_of(path, tmp_path))[SHEET]
    assert sheet["H3"].value.startswith("B3: Error CONN002")


def test_a_report_of_a_sheet_with_odd_measures(wrong, tmp_path):
    path = api.convert(wrong, tmp_path / "odd.xlsx")

    def odd(data: bytes) -> bytes:
        data = re.sub(rb' ht="[^"]*"', b' ht="high"', data)
        return re.sub(rb"<cols>.*</cols>", b'<cols><col min="one" max="all" width="9"/></cols>', data)

    repack(path, {"xl/worksheets/sheet1.xml": odd})
    assert "Findings" in {c.text for c in read_sheets(report_of(path, tmp_path))[0].cells.values()}
