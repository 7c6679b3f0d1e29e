"""Sheets of a file: added, renamed, moved, deleted and brought back; all else stays."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from xml.etree.ElementTree import canonicalize

import openpyxl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lossless import FEATURES, make, parts, repack

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import read
from rrp_sheets.workbook.edits import AddSheet, BringSheet, DeleteSheet, MoveSheet, RenameSheet, SetCell
from rrp_sheets.workbook.files import edit, read_sheets
from rrp_sheets.workbook.schema import TITLES, recognise
from rrp_sheets.workbook.template import beginning

HEAD = beginning("behaviour")
LISTED = re.compile(r"\[Content_Types\]\.xml|docProps/app\.xml|xl/(workbook|styles|_rels/workbook|calcChain)\.")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A file of each kind: the template, and those with what other programs put in."""
    folder = tmp_path_factory.mktemp("made")
    files = {"template": api.new(folder / "template.xlsx")}
    for name in ("formulas", "tables", "comments", "outline", "chart", "chart sheet", "images", "properties"):
        files[name] = make(folder / f"{name.replace(' ', '-')}.xlsx", FEATURES[name])
    return files


def names(path: Path) -> list[str]:
    return [sheet.name for sheet in read_sheets(path)]


def same(part: str, before: bytes, after: bytes) -> bool:
    """Compare a part before and after; the lists of sheets may be written in another way."""
    if not LISTED.match(part):
        return before == after
    return canonicalize(before.decode(), with_comments=True) == canonicalize(after.decode(), with_comments=True)


def copied(path: Path, folder: Path) -> Path:
    return Path(shutil.copy(path, folder / path.name))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["template", "formulas", "tables", "comments", "outline", "chart", "images"])
def test_a_deleted_sheet_comes_back_with_all_its_parts(made: dict[str, Path], name: str, tmp_path: Path) -> None:
    path = copied(made[name], tmp_path)
    for sheet in names(path)[-3:]:
        before = parts(path)
        (kept,) = edit(path, [DeleteSheet(sheet)]).kept
        assert sheet not in names(path) and len(parts(path)) < len(before)
        edit(path, [BringSheet(sheet, kept)])
        after = parts(path)
        changed = {p for p in before if p != "xl/calcChain.xml" and not same(p, before[p], after[p])}
        # formulas are marked to be calculated anew, which is all that is left of it
        assert changed <= {"xl/workbook.xml"} and after.keys() >= before.keys() - {"xl/calcChain.xml"}
        assert b"fullCalcOnLoad" in after["xl/workbook.xml"] or not changed


def test_lists_of_sheets_keep_prefixes_comments_and_the_order_of_attributes(tmp_path: Path) -> None:
    path, book = make(tmp_path / "x.xlsx"), "xl/workbook.xml"

    def strange(data: bytes) -> bytes:
        data = data.replace(b"xmlns=", b"xmlns:x=", 1)
        data = re.sub(rb"<(/?)([a-z])", rb"<\1x:\2", data)
        data = re.sub(rb'<x:sheet (name="[^"]*") (sheetId="[^"]*")', rb"<x:sheet \2 \1", data)
        return data.replace(b"<x:sheets>", b"<x:sheets><!-- kept -->")

    repack(path, {book: strange})
    before = parts(path)[book]
    (kept,) = edit(path, [DeleteSheet("Mine")]).kept
    edit(path, [BringSheet("Mine", kept)])
    lists = [re.search(rb"(?s)<x:sheets>.*</x:sheets>", data) for data in (before, parts(path)[book])]
    assert lists[0] and lists[1] and lists[0][0] == lists[1][0] and b"<x:sheet sheetId=" in lists[0][0]


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(["template", "formulas", "chart sheet", "outline"]),
    st.lists(st.tuples(st.sampled_from(["add", "rename", "move", "delete"]), st.integers(0, 9)), max_size=6),
)
def test_whatever_is_done_to_sheets_the_others_stay(made, tmp_path, name, steps) -> None:
    path = copied(made[name], tmp_path)
    sheets = {s: s for s in names(path)}  # now: as it was called at first; empty for a new one
    first = parts(path)
    by_part = dict(
        zip(names(path), sorted(p for p in first if re.match(r"xl/worksheets/sheet\d+\.xml", p)), strict=True)
    )
    for number, (what, n) in enumerate(steps):
        sheet = list(sheets)[n % len(sheets)]
        if what == "add":
            edit(path, [AddSheet(f"New {number}", HEAD, sheet), SetCell(f"New {number}", 2, 1, "Red ball")])
            sheets[f"New {number}"] = ""
        elif what == "rename":
            edit(path, [RenameSheet(sheet, f"It's {number}")])
            sheets[f"It's {number}"] = sheets.pop(sheet)
        elif what == "move":
            edit(path, [MoveSheet(sheet, next(iter(sheets)))])
        elif len(sheets) > 1:
            edit(path, [DeleteSheet(sheet)])
            del sheets[sheet]
    now = parts(path)
    opened = openpyxl.load_workbook(path)
    assert sorted(names(path)) == sorted(sheets) == sorted(s.title for s in opened.worksheets)
    about = now["docProps/app.xml"].decode()
    if "TitlesOfParts" in about:  # xlsxwriter lists them there
        assert all(f"<vt:lpstr>{sheet}</vt:lpstr>" in about for sheet in sheets)
        assert about.count("<vt:lpstr>New ") <= len(sheets)
    for sheet, was in sheets.items():
        if was and name != "formulas":  # formulas follow what they refer to
            assert now[by_part[was]] == first[by_part[was]], sheet
    others = [p for p in first if p in now and not LISTED.match(p) and "worksheets" not in p and "chart" not in p]
    assert all(first[p] == now[p] for p in others)


def test_everything_of_excels_own_follows_a_name(made: dict[str, Path], tmp_path: Path) -> None:
    formulas, chart, outline = (copied(made[n], tmp_path) for n in ("formulas", "chart", "outline"))
    edit(formulas, [RenameSheet("Tracking", "Old & new's")])
    book = openpyxl.load_workbook(formulas)
    assert book["Mine"]["B1"].value == "=SUM('Old & new''s'!G2:G7)"
    assert book.defined_names["All"].attr_text == "'Old & new''s'!$G$2:$G$7"
    edit(chart, [RenameSheet("Mine", "Yours")])
    assert b"<c:f>Yours!$A$1:$A$3</c:f>" in parts(chart)["xl/charts/chart1.xml"]
    edit(outline, [RenameSheet("Tracking", "My plan"), AddSheet("First", HEAD, "My plan")])
    sheet = openpyxl.load_workbook(outline)["My plan"]
    assert (sheet.print_title_rows, sheet.print_area) == ("$1:$1", "'My plan'!$A$1:$G$7")
    assert b"<vt:lpstr>'My plan'!Print_Titles</vt:lpstr>" in parts(outline)["docProps/app.xml"]
    edit(formulas, [RenameSheet("Old & new's", "Tracking")])
    assert parts(formulas)["xl/worksheets/sheet2.xml"] == parts(made["formulas"])["xl/worksheets/sheet2.xml"]


def test_what_refers_to_a_deleted_sheet_says_so_and_is_mended_by_its_return(
    made: dict[str, Path], tmp_path: Path
) -> None:
    path = copied(made["formulas"], tmp_path)
    (kept,) = edit(path, [DeleteSheet("Tracking"), SetCell("Mine", 9, 1, "meanwhile")]).kept
    book = openpyxl.load_workbook(path)
    assert book["Mine"]["B1"].value == "=SUM(#REF!G2:G7)" and book.defined_names["All"].attr_text == "#REF!$G$2:$G$7"
    edit(path, [AddSheet("Another", HEAD), BringSheet("Tracking", kept)])  # which has taken its part and its number
    book = openpyxl.load_workbook(path)
    assert book["Mine"]["B1"].value == "=SUM(Tracking!G2:G7)" and book["Mine"]["A9"].value == "meanwhile"
    assert book.sheetnames == ["Tracking", "Mine", "Another"] and book["Tracking"]["B2"].value == "map"
    ids = re.findall(rb'sheetId="(\d+)"', parts(path)["xl/workbook.xml"])
    assert len(set(ids)) == 3


def test_a_sheet_that_fits_no_more_is_not_brought_back(made: dict[str, Path], tmp_path: Path) -> None:
    path = copied(made["outline"], tmp_path)
    (kept,) = edit(path, [DeleteSheet("Mine")]).kept
    openpyxl.load_workbook(path).save(path)  # another program: styles may have other numbers
    before = path.read_bytes()
    with pytest.raises(SheetsError, match="another program has saved"):
        edit(path, [BringSheet("Mine", kept)])
    assert path.read_bytes() == before


def test_a_new_sheet_looks_as_in_a_new_workbook(made: dict[str, Path], tmp_path: Path) -> None:
    path = copied(made["template"], tmp_path)
    edit(path, [AddSheet("Behaviour 2", HEAD, "Devices")])
    old, new = (openpyxl.load_workbook(path)[n] for n in ("Tracking", "Behaviour 2"))
    assert parts(path)["xl/styles.xml"] == parts(made["template"])["xl/styles.xml"]  # nothing is there twice
    assert new.freeze_panes == "A2" and new.print_title_rows == "$1:$1" and new.page_setup.orientation == "landscape"
    assert {v.formula1 for v in new.data_validations.dataValidation} >= {"List_connectors", "List_streams"}
    for column in "ABCDEF":
        assert new[f"{column}1"].fill.fgColor.rgb == old[f"{column}1"].fill.fgColor.rgb
        assert new[f"{column}9"].number_format == "@"
        assert new.column_dimensions[column].width == old.column_dimensions[column].width
    plain = copied(made["chart"], tmp_path)
    edit(plain, [AddSheet("Behaviour 2", HEAD)])
    foreign = openpyxl.load_workbook(plain)
    assert foreign["Behaviour 2"]["A1"].font.b and foreign["Behaviour 2"]["A5"].number_format == "@"
    assert not foreign["Mine"]["A1"].font.b and foreign.active.title == "Tracking"


def test_a_device_sheet_that_comes_back_anew_feeds_the_drop_downs_again(made: dict[str, Path], tmp_path: Path) -> None:
    path = copied(made["template"], tmp_path)
    edit(path, [DeleteSheet("Devices"), AddSheet("My devices", beginning("devices"))])
    assert openpyxl.load_workbook(path).defined_names["List_streams"].attr_text.startswith("'My devices'!$A$2:$A$")


if shutil.which("soffice"):

    def test_libreoffice_opens_what_was_made(made: dict[str, Path], tmp_path: Path, office: str) -> None:
        files = []
        for name in ("template", "chart sheet", "comments"):
            path = copied(made[name], tmp_path)
            edit(
                path,
                [AddSheet("Anna's way", HEAD, "Tracking"), RenameSheet("Tracking", "Old & new"), AddSheet("Z", HEAD)],
            )
            edit(path, [DeleteSheet("Z"), *([DeleteSheet("Devices")] if name == "template" else [])])
            files.append(path)
        command = ["soffice", office, "--headless", "--convert-to", "xlsx"]
        done = subprocess.run(
            [*command, "--outdir", str(tmp_path / "out"), *map(str, files)],
            capture_output=True,
            timeout=300,
            check=False,
        )
        for path in files:
            again = openpyxl.load_workbook(tmp_path / "out" / path.name)
            assert [n for n in again.sheetnames if n != "Picture"] == names(path), done.stderr
        assert again["Old & new"]["C3"].comment.text == "on the filter"


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("", "needs a name"), ("  \n ", "needs a name"), ("a/b", "contain “/”"), ("[x]", "contain “\\[”"), ("x" * 32, "32 letters"),
        ("𝄞" * 16, "32 letters"), ("'a", "apostrophe"), ("---", "letter or a digit"), ("history", "for itself"),
        ("TRACK ING", "“Tracking” already"), ("..", "letter or a digit"),
    ],
)  # fmt: skip
def test_names_that_no_sheet_can_have(made: dict[str, Path], tmp_path: Path, name: str, why: str) -> None:
    path = made["template"]
    before = path.read_bytes()
    for wrong in (AddSheet(name, HEAD), RenameSheet("Scene", name)):
        with pytest.raises(SheetsError, match=why):
            edit(path, [wrong])
    assert path.read_bytes() == before


def test_the_last_sheet_to_be_seen_stays(tmp_path: Path) -> None:
    path = make(tmp_path / "hidden.xlsx", lambda book, sheet: book.get_worksheet_by_name("Mine").hide())
    with pytest.raises(SheetsError, match="only sheet to be seen"):
        edit(path, [DeleteSheet("Tracking")])
    with pytest.raises(SheetsError, match="no sheet “Nothing”"):
        edit(path, [DeleteSheet("Nothing")])
    locked = b'<workbookProtection lockStructure="1"/><sheets>'
    repack(path, {"xl/workbook.xml": lambda data: data.replace(b"<sheets>", locked)})
    for wrong in (
        AddSheet("New", HEAD),
        RenameSheet("Mine", "Yours"),
        DeleteSheet("Mine"),
        MoveSheet("Mine", "Tracking"),
    ):
        with pytest.raises(SheetsError, match="structure is protected"):
            edit(path, [wrong])


def test_every_kind_begins_as_what_it_is(tmp_path: Path) -> None:
    path = api.new(tmp_path / "e.xlsx", template="empty")
    text = api.convert(path, tmp_path / "e.md")
    edits = [AddSheet(f"New {kind}", beginning(kind)) for kind in TITLES]
    for each in (path, text):
        edit(each, edits)
        found = read(each)
        kinds = {s.name: recognise(s).kind for s in found.sheets if s.name.startswith("New ")}
        assert {n: k.name if k else "table" for n, k in kinds.items()} == {f"New {kind}": kind for kind in TITLES}
        assert not [
            d for d in found.report if d.address and d.address.sheet.startswith("New ") and d.code != "SHEET015"
        ]


def test_sheets_of_markdown_and_of_a_folder(tmp_path: Path) -> None:
    source = api.new(tmp_path / "t.xlsx")
    text, folder = api.convert(source, tmp_path / "t.md"), api.convert(source, tmp_path / "t")
    for path in (text, folder):
        before = contents(path)
        (kept,) = edit(path, [DeleteSheet("Scene")]).kept
        assert "Scene" not in names(path)
        edit(path, [BringSheet("Scene", kept)])
        assert contents(path) == before
        edit(path, [AddSheet("Greeting", HEAD, "Scene"), SetCell("Greeting", 2, 1, "Face")])
        edit(path, [RenameSheet("Tracking", "Look"), MoveSheet("Greeting", "Look")])
        found = [n for n in names(path) if n not in ("Read me", "Lists")]
        assert found == ["Greeting", "Look", "Devices", "Helpers", "Scene", "Check", "Protocol"]
        assert read(path).workbook.behaviours[0].rows[0].inputs[0].text == "Face"
        with pytest.raises(SheetsError, match="already"):
            edit(path, [RenameSheet("Look", "scene")])
    with pytest.raises(SheetsError, match="cannot be the name of a file"):
        edit(folder, [RenameSheet("Look", ".hidden")])


def contents(path: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in ([path] if path.is_file() else path.iterdir())}


def test_a_list_of_titles_with_a_count_that_is_none_is_left_alone(tmp_path: Path) -> None:
    path = make(tmp_path / "x.xlsx")
    about = "docProps/app.xml"
    repack(path, {about: lambda data: re.sub(rb"<vt:i4>\d+</vt:i4>", b"<vt:i4>two</vt:i4>", data)})
    before = parts(path)[about]
    edit(path, [AddSheet("New", HEAD)])
    assert "New" in names(path) and parts(path)[about] == before
