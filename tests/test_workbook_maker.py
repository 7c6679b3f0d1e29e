"""Made workbooks: text cells, drop-downs that never refuse, print setup, safe writing."""

from __future__ import annotations

import re
from pathlib import Path

import openpyxl
import pytest

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.workbook import FALSE_WORDS
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook
from rrp_sheets.workbook.maker import Offers, sheet_titles
from rrp_sheets.workbook.schema import FIELDS
from rrp_sheets.workbook.template import new_workbook, template_sheets

OFFERS = Offers(
    connectors=("map", "filter", "subscribe"),
    sensors=("Red ball", "Face"),
    actuators=("Say", "Head tracker"),
    choices={"Mode": ("Head", "Move"), "Thing": ("Red ball",)},
)
HEADERS = ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"]


@pytest.fixture
def template(tmp_path: Path) -> Path:
    return new_workbook(tmp_path / "new.xlsx", OFFERS)


def test_the_template_is_read_without_a_finding(template: Path) -> None:
    reading = read(template)
    assert list(reading.report) == []
    workbook = reading.workbook
    assert workbook.sheets == ("Read me", "Tracking", "Devices", "Helpers", "Scene", "Check", "Protocol", "Lists")
    assert [b.name for b in workbook.behaviours] == ["Tracking"]
    assert [r.connector.text for r in workbook.behaviours[0].rows] == ["map", "filter", "subscribe"]
    assert [d.stream.text for d in workbook.devices] == ["Red ball", "Head tracker"]
    assert len(workbook.tests[0].rows) == 4
    assert set(workbook.protocol.fields) == set(FIELDS)


def test_the_empty_template_has_the_same_sheets_without_rows(tmp_path: Path, template: Path) -> None:
    reading, guided = read(new_workbook(tmp_path / "empty.xlsx", OFFERS, empty=True)), read(template).workbook
    assert list(reading.report) == []
    workbook = reading.workbook
    assert set(workbook.sheets) == set(guided.sheets) - {"Read me", "Check"}
    assert [(b.name, b.rows) for b in workbook.behaviours] == [("Tracking", ())]
    assert not workbook.devices and not workbook.helpers
    assert workbook.scene  # a ball, so that the first rows have something to see
    assert set(workbook.protocol.fields) <= set(guided.protocol.fields)


def test_the_robot_of_the_template() -> None:
    assert ["Robot", "pepper"] in template_sheets("pepper")["Protocol"]


def test_table_cells_are_text_for_at_least_200_rows(template: Path) -> None:
    book = openpyxl.load_workbook(template)
    for name in ("Tracking", "Devices", "Helpers", "Scene", "Check", "Protocol"):
        sheet = book[name]
        width = sum(1 for c in sheet[1] if c.value)
        cells = [sheet.cell(r, c) for r in range(1, 202) for c in range(1, width + 1)]
        assert {c.number_format for c in cells} == {"@"}, name
        assert {c.font.name for c in cells} == {"Arial"}, name
        assert {c.data_type for c in cells if c.value is not None} == {"s"}, name


def test_pages(template: Path) -> None:
    book = openpyxl.load_workbook(template)
    for name in ("Tracking", "Devices", "Helpers", "Scene", "Check", "Protocol"):
        sheet = book[name]
        assert (sheet.page_setup.orientation, int(sheet.page_setup.paperSize)) == ("landscape", 9)
        assert (sheet.page_setup.fitToWidth, sheet.page_setup.fitToHeight) == (1, 0)
        assert sheet.sheet_properties.pageSetUpPr.fitToPage
        assert sheet.print_title_rows == "$1:$1"
        assert sheet.freeze_panes == "A2"


def test_drop_downs_offer_and_never_refuse(template: Path) -> None:
    book = openpyxl.load_workbook(template)
    offered = {}
    for rule in book["Tracking"].data_validations.dataValidation:
        assert not rule.showErrorMessage
        assert rule.showInputMessage
        assert rule.prompt
        offered[str(rule.sqref).rstrip("0123456789:")[:1]] = rule.formula1
    assert offered == {
        "A": "List_streams", "B": "List_connectors", "C": None, "D": "List_streams", "E": "List_onoroff", "F": None,
    }  # fmt: skip
    for name in filter(None, offered.values()):
        sheet, _, cells = book.defined_names[name].attr_text.partition("!")
        assert book[sheet.strip("'")][cells.replace("$", "")][0][0].value
    assert [c.value for c in book["Lists"]["A"]][:4] == ["Connectors", "map", "filter", "subscribe"]
    fields = {r.prompt.split(".")[0]: r.formula1 for r in book["Protocol"].data_validations.dataValidation}
    assert '"English,日本語"' in fields.values() and '"ends with the run,kept"' in fields.values()
    modes = [r for r in book["Devices"].data_validations.dataValidation if r.formula1 == "List_mode"]
    assert [str(r.sqref) for r in modes] == ["C2:C201"]


def test_unknown_names_are_marked(template: Path) -> None:
    marks = openpyxl.load_workbook(template)["Tracking"].conditional_formatting
    formulas = {str(m.sqref): [r.formula[0] for r in m.rules] for m in marks}
    assert "List_streams" in formulas["A2:A201"][0]
    assert "List_sensors" in formulas["A2:A201"][0]
    assert "List_connectors" in formulas["B2:B201"][0]


def test_the_same_rows_give_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = new_workbook(tmp_path / "a.xlsx", OFFERS).read_bytes()
    monkeypatch.setattr("time.time", lambda: 2e9)
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    (tmp_path / "other").mkdir()
    assert new_workbook(tmp_path / "other" / "a.xlsx", OFFERS).read_bytes() == first


def test_texts_stay_texts(tmp_path: Path) -> None:
    texts = ["=1+1", "+1", "#N/A", "007", "1/2", "TRUE", "'x", " x\ny ", "a\x00b", "_x000D_"]
    path = make_workbook({"A": [HEADERS, *([t, "map", t, "Y"] for t in texts)]}, tmp_path / "x.xlsx")
    sheet = openpyxl.load_workbook(path)["A"]
    assert {sheet.cell(r, 1).data_type for r in range(2, 12)} == {"s"}
    assert [sheet.cell(r, 3).value for r in range(2, 10)] == texts[:8]
    assert sheet["C10"].value == "a\ufffdb"


def test_an_existing_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "new.xlsx"
    path.write_text("mine")
    with pytest.raises(SheetsError, match=r"There is already a file “new\.xlsx”"):
        new_workbook(path, OFFERS)
    with pytest.raises(SheetsError, match="There is already"):
        make_workbook(template_sheets(), path, replace=False)
    assert path.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["new.xlsx"]


@pytest.mark.parametrize(("lock", "program"), [("~$x.xlsx", "Excel"), (".~lock.x.xlsx#", "LibreOffice")])
def test_a_file_open_elsewhere_is_left_alone(tmp_path: Path, lock: str, program: str) -> None:
    (tmp_path / lock).write_text("")
    with pytest.raises(SheetsError, match=f"is open in {program}"):
        make_workbook(template_sheets(), tmp_path / "x.xlsx")
    assert not (tmp_path / "x.xlsx").exists()


def test_names_and_folders_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(SheetsError, match=r"ends in \.xlsx"):
        new_workbook(tmp_path / "x.txt", OFFERS)
    with pytest.raises(SheetsError, match="cannot be written"):
        new_workbook(tmp_path / "nowhere" / "x.xlsx", OFFERS)


def test_a_text_too_long_for_a_cell(tmp_path: Path) -> None:
    with pytest.raises(SheetsError, match="A2"):
        make_workbook({"A": [HEADERS, ["x" * 32_768]]}, tmp_path / "x.xlsx")
    assert list(tmp_path.iterdir()) == []


def test_sheet_names(tmp_path: Path) -> None:
    names = ["x" * 40, "x" * 41, "a/b", "A_B", "History", "Lists", "'quoted'", ""]
    titles = sheet_titles(names)
    assert len({t.casefold() for t in titles.values()}) == len(names)
    assert all(0 < len(t) <= 31 for t in titles.values())
    path = make_workbook({n: [["a"], ["b"]] for n in names}, tmp_path / "x.xlsx", OFFERS)
    assert len(openpyxl.load_workbook(path).sheetnames) == len(names) + 1


def test_sheets_of_any_shape(tmp_path: Path) -> None:
    path = make_workbook({"Empty": [], "Blank": [[], ["", ""]], "A": [[], ["title"], [*HEADERS]]}, tmp_path / "x.xlsx")
    assert openpyxl.load_workbook(path)["A"].freeze_panes == "A4"


def test_rows_are_pale_that_the_reader_takes_for_switched_off(tmp_path: Path) -> None:
    """Also those that were switched off in another language: a spreadsheet program shows FALSE as FALSCH there."""
    sheet = openpyxl.load_workbook(make_workbook({"T": [HEADERS]}, tmp_path / "x.xlsx"))["T"]
    tests = [test for marks in sheet.conditional_formatting for rule in marks.rules for test in rule.formula]
    (off,) = (test for test in tests if "SEARCH" in test)
    texts = re.findall(r'"([^"]*)"', off)
    assert max(texts, key=len).strip(",").split(",") == sorted(FALSE_WORDS) and "falsch" in FALSE_WORDS
    assert max(map(len, texts)) <= 255
