"""CSV and Markdown: written, read back, and edited with all other lines as they were."""

from __future__ import annotations

import csv
import functools
import os
import re
import stat
from pathlib import Path

import pytest
import xlsxwriter
from examples import example_count
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.resources import bundled
from rrp_sheets.workbook import files, read
from rrp_sheets.workbook.edits import (
    AddSheet,
    BringSheet,
    DeleteRows,
    DeleteSheet,
    InsertRows,
    MoveRows,
    MoveSheet,
    RenameSheet,
    SetCell,
)
from rrp_sheets.workbook.files import (
    FORMATS,
    XLSX,
    FileChanged,
    edit,
    make_workbook,
    read_sheets,
    write_csv,
    write_sheets,
)
from rrp_sheets.workbook.reading import to_rows
from rrp_sheets.workbook.text_books import from_csv, from_markdown, to_csv, to_markdown
from rrp_sheets.workbook.text_patch import csv_text

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
MANY_SHEETS = {"exercise-coach", "greeter-with-memory", "reception", "say-ball-colour-ja"}
MARKDOWN = """# About

Some prose with | bars |.

## Tracking

| Input streams | Connector | Formula          | Output stream |
|:--------------|:---------:|------------------|---------------|
| Red ball      | map       | redBall.distance | Distance      |
| Distance      | filter    | `distance < 0.5` | Near          |
| Near | subscribe |  | Head tracker |

More prose.

## Mine

| a | b |
|---|---|
| 1 | 2 |
"""


def texts(path: Path) -> dict[str, dict[tuple[int, int], str]]:
    return {s.name: {at: c.text for at, c in s.cells.items()} for s in read_sheets(path)}


# ---- the twins

TWINS = [f"x{one.suffixes[0]}" for one in FORMATS if one is not XLSX]


@functools.cache
def checked_and_explained(path: Path):
    return api.check(path), api.explain(path)[0]


def converted(name, tmp_path):
    """The files of a workbook in every format, after their cells were compared."""
    source = bundled("workbooks", f"{name}.xlsx")
    wanted = texts(source)
    lists = "リスト" if "リスト" in wanted else "Lists"
    generated = wanted.pop(lists)
    path = source
    for out in (*TWINS, "folder", "back.xlsx"):
        path = api.convert(path, tmp_path / out)
        found = texts(path)
        assert (lists in found) is (out == "back.xlsx") and found.pop(lists, generated) == generated
        assert found == wanted and list(found) == list(wanted)
    assert texts(tabbed(tmp_path / "folder", tmp_path / "tabbed")) == wanted
    return source, path


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in WORKBOOKS if n not in MANY_SHEETS])  # of those the next test does it too
def test_the_cells_of_a_workbook_are_the_same_in_every_format(name, tmp_path):
    """Through Markdown, CSV and tab-separated files and back."""
    converted(name, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [n if n in MANY_SHEETS else pytest.param(n, marks=pytest.mark.soak) for n in WORKBOOKS]
)
def test_a_workbook_means_the_same_in_every_format(name, tmp_path):
    """The same findings, behaviours, scene and sentences."""
    source, path = converted(name, tmp_path)
    for twin in (*(api.check(tmp_path / name) for name in TWINS), api.check(tmp_path / "tabbed"), api.check(path)):
        book, words = checked_and_explained(source)
        assert [(d.code, str(d.address), d.message) for d in book.report] == [
            (d.code, str(d.address), d.message) for d in twin.report
        ]
        for graph in ("behaviours", "streams"):
            assert repr(getattr(book.graph, graph)) == repr(getattr(twin.graph, graph))
        assert book.scene == twin.scene
    assert words == api.explain(tmp_path / "x.md")[0] == api.explain(path)[0]


def tabbed(folder: Path, target: Path) -> Path:
    """A folder of CSV files as Excel saves "Text (Tab delimited)", but in UTF-8."""
    target.mkdir()
    for file in folder.iterdir():
        if file.suffix != ".csv":
            (target / file.name).write_bytes(file.read_bytes())
            continue
        text = file.read_text("utf-8-sig")
        rows = list(csv.reader(text.removeprefix("sep=,\n").splitlines(keepends=True)))
        with (target / f"{file.stem}.tsv").open("w", encoding="utf-8", newline="") as out:
            csv.writer(out, "excel-tab").writerows(rows)
    return target


@pytest.mark.parametrize("twin", [*TWINS, "folder"])
def test_edits_are_the_same_in_every_format(twin, tmp_path):
    rows = {"T": [["Input streams", "Connector", "Formula", "Output stream"], ["Red ball", "map", "1", "X"]]}
    book = make_workbook(rows | {"Mine": [["a"], ["1"]]}, tmp_path / "x.xlsx")
    other = api.convert(book, tmp_path / twin)
    changes = [
        [SetCell("T", 3, 1, "X"), SetCell("T", 3, 2, "filter"), SetCell("T", 3, 3, 0.5), SetCell("T", 2, 3, True)],
        [InsertRows("T", 2), SetCell("T", 2, 4, "=new"), MoveRows("T", 2, 1, 5), SetCell("T", 3, 3, None)],
        [DeleteRows("T", 2), AddSheet("More", [["a", "b"], ["c"]], before="T"), RenameSheet("Mine", "Ours")],
        [MoveSheet("More"), DeleteSheet("Ours")],
    ]
    for edits in changes:
        kept = [edit(path, edits, expected_digest=read(path).digest).kept for path in (book, other)]
        assert texts(other) == texts(book)
    for path, (back,) in zip((book, other), kept, strict=True):
        edit(path, [BringSheet("Ours", back)])
    assert texts(other) == texts(book) and "Ours" in texts(book)


LISTS = [["Connectors", "Sensors", "Actuators", "All devices", "On or off"], ["map", "Red ball", "Say", "Say", "TRUE"]]


def test_generated_lists_of_any_name_are_made_again(tmp_path):
    """Additions of earlier versions are gone; what somebody has written stays."""
    row = [["Input streams", "Connector", "Formula", "Output stream"], ["Red ball", "map", "1", "X"]]
    old = {"T": row, "Lists": LISTS, "Lists for drop-downs": LISTS, "Lists for drop-downs 21": LISTS}
    own = {"Lists for drop-downs 3": [*LISTS, ["mine"]], "My lists": LISTS}
    write_sheets(old | own, tmp_path / "x.md")
    book = api.convert(tmp_path / "x.md", tmp_path / "x.xlsx")
    assert list(texts(book)) == ["T", "Lists for drop-downs 3", "My lists", "Lists"]
    assert list(texts(api.convert(book, tmp_path / "y.md"))) == ["T", *own]
    named = [row[0], ["Red ball", "map", "INDEX(Lists; 1)", "X"]]
    write_sheets({"T": named, "Lists": LISTS}, tmp_path / "n.md")
    book = api.convert(tmp_path / "n.md", tmp_path / "n.xlsx")
    assert list(texts(book)) == ["T", "Lists"]
    assert list(texts(api.convert(book, tmp_path / "m.md"))) == ["T", "Lists"]  # a formula needs it
    write_sheets({"T": row, "lists": [["x"]]}, tmp_path / "l.md")
    book = api.convert(tmp_path / "l.md", tmp_path / "l.xlsx")
    assert list(texts(book)) == ["T", "lists", "Lists for drop-downs"]
    assert list(texts(api.convert(book, tmp_path / "l"))) == ["lists", "T"] or list(texts(tmp_path / "l")) == [
        "T",
        "lists",
    ]


def test_sheets_of_one_name_are_not_merged(tmp_path):
    (tmp_path / "x.md").write_text("## T\n\n| a |\n|---|\n| 1 |\n\n## T\n\n| b |\n|---|\n| 2 |\n")
    for out in ("x.xlsx", "f", "y.md"):
        with pytest.raises(SheetsError, match="Two sheets are called “T”"):
            api.convert(tmp_path / "x.md", tmp_path / out)
        assert not (tmp_path / out).exists()


TEXT = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=10)
SPICY = st.text("=+-@'\"`|\\<br>,;\t\n #a1 /", max_size=9)
ROWS = st.lists(st.lists(st.one_of(TEXT, SPICY), max_size=4), min_size=1, max_size=5)


def kept(rows: list[list[str]], edges: bool) -> dict[tuple[int, int], str]:
    """Cells of the rows that come back: those with a content; Markdown loses spaces at the edges of a text and its lines."""
    cells = {(r, c): t for r, row in enumerate(rows, 1) for c, t in enumerate(row, 1) if t.strip()}
    return cells if edges else {at: t.strip() for at, t in cells.items()}


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=example_count(100))
@given(ROWS)
def test_any_rows_come_back(tmp_path, rows):
    folder = tmp_path / "csv"
    for old in folder.glob("*") if folder.exists() else ():
        old.unlink()
    write_csv({"S": rows, "R": [["x"]]}, folder)
    doubtful = {at for at, t in kept(rows, True).items() if from_csv(to_csv(t).strip('"').replace('""', '"')) != t}
    found = texts(folder)["S"]
    assert {a: t for a, t in found.items() if a not in doubtful} == {
        a: t for a, t in kept(rows, True).items() if a not in doubtful
    }
    write_sheets({"S": rows, "R": [["x"]]}, tmp_path / "x.md")
    wanted = kept(rows, False)
    assert {a: t.replace(" \n", "\n") for a, t in texts(tmp_path / "x.md")["S"].items()} == {
        a: t.replace(" \n", "\n") for a, t in wanted.items()
    }
    (folder / "S.csv").unlink()
    (folder / "S.tsv").write_text(csv_text(rows, "\t"), "utf-8")
    assert texts(folder)["S"] == found


LITERAL = st.sampled_from(["_x0041_", "_x000D_", "a_x005F_x0041_", "_X0041_"])


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=25)
@given(st.lists(st.lists(st.one_of(TEXT, SPICY, LITERAL), max_size=4), min_size=1, max_size=5))
def test_any_rows_come_back_from_xlsx(tmp_path, rows):
    make_workbook({"S": rows, "Blank": [], "R": [["x"]]}, tmp_path / "x.xlsx")
    found = texts(tmp_path / "x.xlsx")
    assert {at: t for at, t in found.pop("S").items() if t.strip()} == kept(rows, True)
    assert found == {"Blank": {}, "R": {(1, 1): "x"}}
    write_sheets(to_rows(read_sheets(tmp_path / "x.xlsx")), tmp_path / "x.md")
    again = texts(tmp_path / "x.md")
    assert list(again) == ["S", "Blank", "R"]
    assert {a: t.replace(" \n", "\n") for a, t in again["S"].items()} == {
        a: t.replace(" \n", "\n") for a, t in kept(rows, False).items()
    }


@settings(max_examples=example_count(300))
@given(st.one_of(TEXT, SPICY))
def test_cells_of_markdown_both_ways(text):
    written = to_markdown(text)
    assert "\n" not in written
    assert from_markdown(written).replace(" \n", "\n") == text.strip().replace(" \n", "\n")


@settings(max_examples=example_count(300))
@given(SPICY)
def test_no_field_of_csv_is_calculated(text):
    (field,) = next(csv.reader([to_csv(text)])) if to_csv(text) and "\n" not in text else ("",)
    assert not field.startswith(("=", "+", "-", "@", "\t")) or re.fullmatch(r"[+-]?\d+([.,]\d+)?", field)


@pytest.mark.parametrize("text", ["=1+1", "@SUM(A1)", "+x", "-x", "'=1", "''=1", "=a'b", "-don't", '="a"&"b"'])
def test_dangerous_texts_come_back(text, tmp_path):
    write_csv({"S": [[text, "b"]]}, tmp_path / "f")
    raw = (tmp_path / "f" / "S.csv").read_text("utf-8-sig")
    assert raw.lstrip('"').startswith("'")
    assert texts(tmp_path / "f")["S"][1, 1] == text


@pytest.mark.parametrize("text", ["'-' & x", "'='", "'@' & name"])
def test_quoted_signs_written_by_hand_stay(text, tmp_path):
    (tmp_path / "T.csv").write_text(f"From,Operator,Parameter,To\nball,map,{text},X\n")
    assert read(tmp_path).workbook.behaviours[0].rows[0].formula.text == text


def test_values_that_excel_calculated(tmp_path):
    """In a formula cell what was typed, elsewhere what the user sees."""
    with xlsxwriter.Workbook(tmp_path / "x.xlsx") as book:
        sheet = book.add_worksheet("T")
        sheet.write_row(0, 0, ["Input streams", "Connector", "Formula", "Output stream"])
        sheet.write_formula(1, 0, "=Mine!A1", None, "Red ball")
        sheet.write(1, 1, "map")
        sheet.write_formula(1, 2, "=redBall.distance<0.5", None, "#NAME?")
        sheet.write(1, 3, "=Near")
        mine = book.add_worksheet("Mine")
        for row in range(60):
            mine.write(row, 0, "Red ball" if row == 0 else row)
    api.convert(tmp_path / "x.xlsx", tmp_path / "x.md")
    found = texts(tmp_path / "x.md")
    assert [found["T"][2, c] for c in (1, 2, 3)] == ["Red ball", "map", "=redBall.distance<0.5"]
    assert len(found["Mine"]) == 60  # beyond what is read of a user's own sheet


def test_sheets_keep_their_order_and_names(tmp_path):
    sheets = {name: [["a", "b;c;d"], ["1"]] for name in ["Zoo", "10 x", "2 x", "Übung #", "a b"]}
    write_csv(sheets, tmp_path / "f")
    assert list(texts(tmp_path / "f")) == list(sheets)
    write_sheets(sheets, tmp_path / "x.md")
    assert list(texts(tmp_path / "x.md")) == list(sheets)
    assert texts(tmp_path / "x.md") == texts(tmp_path / "f")
    digest = read(tmp_path / "f").digest
    (tmp_path / "f" / "order.txt").write_text("a b\n")
    assert list(texts(tmp_path / "f")) == ["a b", "2 x", "10 x", "Zoo", "Übung #"]
    assert read(tmp_path / "f").digest != digest


def test_nothing_is_overwritten(tmp_path):
    source = bundled("workbooks", "greeter.xlsx")
    api.convert(source, tmp_path / "f")
    with pytest.raises(SheetsError, match="CSV files in “f” already"):
        api.convert(source, tmp_path / "f")
    api.convert(source, tmp_path / "x.md")
    with pytest.raises(SheetsError, match=r"already a file “x\.md”"):
        api.convert(source, tmp_path / "x.md", replace=False)
    with pytest.raises(SheetsError, match="nothing to convert"):
        api.convert(source, tmp_path / "y.xlsx")
    with pytest.raises(SheetsError, match="not a format that can be written"):
        api.convert(source, tmp_path / "y.ods")
    (tmp_path / "z.md").write_text("## a/b\n\n| a |\n|---|\n| 1 |\n")
    with pytest.raises(SheetsError, match="cannot be a file"):
        api.convert(tmp_path / "z.md", tmp_path / "g")


# ---- editing Markdown


@pytest.fixture
def markdown(tmp_path):
    path = tmp_path / "x.md"
    path.write_text(MARKDOWN, encoding="utf-8")
    return path


def changed_lines(path: Path, before: str = MARKDOWN) -> list[str]:
    old, new = before.splitlines(), path.read_text("utf-8").splitlines()
    return [line for line in new if line not in old]


def test_one_line_of_markdown_changes(markdown):
    done = edit(markdown, [SetCell("Tracking", 3, 3, "distance | 2")], expected_digest=read(markdown).digest)
    assert changed_lines(markdown) == [r"| Distance      | filter    | distance \| 2    | Near          |"]
    assert done.digest == read(markdown).digest
    edit(markdown, [SetCell("Tracking", 4, 3, "a\nb"), SetCell("Mine", 2, 4, 7)])
    assert changed_lines(markdown)[1:] == ["| Near | subscribe | a<br>b | Head tracker |", "| 1 | 2 |  | 7 |"]
    assert texts(markdown)["Mine"][2, 4] == "7"


def test_rows_of_markdown(markdown):
    edit(markdown, [MoveRows("Tracking", 4, 1, before=2), InsertRows("Tracking", 3), SetCell("Mine", 4, 2, "new")])
    assert [texts(markdown)["Tracking"].get((r, 1)) for r in range(1, 6)] == [
        "Input streams", "Near", None, "Red ball", "Distance",
    ]  # fmt: skip
    assert texts(markdown)["Mine"][4, 2] == "new"
    edit(markdown, [DeleteRows("Tracking", 3), MoveRows("Tracking", 2, 1, before=5), DeleteRows("Mine", 3, 2)])
    assert markdown.read_text("utf-8") == MARKDOWN
    for change in (InsertRows("Tracking", 1), DeleteRows("Mine", 1), MoveRows("Tracking", 2, 1, before=1)):
        with pytest.raises(SheetsError, match="has the headers"):
            edit(markdown, [change])


def test_windows_line_breaks_and_a_missing_last_one_stay(markdown):
    text = MARKDOWN.rstrip("\n").replace("\n", "\r\n")
    markdown.write_bytes(b"\xef\xbb\xbf" + text.encode())
    edit(markdown, [SetCell("Mine", 2, 1, "9")])
    assert markdown.read_bytes() == b"\xef\xbb\xbf" + text.replace("| 1 |", "| 9 |").encode()
    edit(markdown, [SetCell("Mine", 3, 1, "10")])
    assert markdown.read_bytes().endswith(b"| 9 | 2 |\r\n| 10 |  |\r\n")


# ---- editing CSV


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "book"
    place.mkdir()
    (place / "T.csv").write_bytes(
        'From;Operator;Parameter;To\r\n"Red ball";map;"a;""b""";Distance\r\n\r\nDistance;filter;x < 1;Near\r\n'.encode(
            "cp1252"
        )
    )
    (place / "Mine.csv").write_text("a,b\n1,2")
    return place


def test_one_field_of_csv_changes(folder):
    before = (folder / "T.csv").read_bytes()
    done = edit(folder, [SetCell("T", 2, 3, "c;d"), SetCell("T", 4, 3, "=x")], expected_digest=read(folder).digest)
    assert (folder / "T.csv").read_bytes() == before.replace(b'"a;""b"""', b'"c;d"').replace(b"x < 1", b"'=x")
    assert done.digest == read(folder).digest
    edit(folder, [SetCell("Mine", 2, 4, "z"), SetCell("Mine", 4, 1, "last")])
    assert (folder / "Mine.csv").read_bytes() == b"a,b\n1,2,,z\n,,,\nlast,,,\n"


def test_rows_of_csv(folder):
    before = (folder / "T.csv").read_bytes()
    edit(folder, [MoveRows("T", 4, 1, before=2), InsertRows("T", 3)])
    assert [texts(folder)["T"].get((r, 1)) for r in range(1, 6)] == ["From", "Distance", None, "Red ball", None]
    edit(folder, [DeleteRows("T", 3), MoveRows("T", 2, 1, before=5)])
    assert (folder / "T.csv").read_bytes() == before
    with pytest.raises(SheetsError, match="has the headers"):
        edit(folder, [DeleteRows("T", 1)])


def test_an_encoding_that_cannot_hold_a_letter_gives_way(folder):
    (folder / "T.csv").write_bytes("From;Operator;Parameter;To\nBäll;map;1;X\n".encode("cp1252"))
    edit(folder, [SetCell("T", 2, 3, "é")])
    assert (folder / "T.csv").read_bytes().decode("cp1252").endswith("Bäll;map;é;X\n")
    edit(folder, [SetCell("T", 2, 3, "赤")])
    assert (folder / "T.csv").read_bytes().decode("utf-8-sig").endswith("Bäll;map;赤;X\n")


def test_conflicts_in_text_files(folder, markdown):
    for path in (folder, markdown):
        digest = read(path).digest
        sheet = "Mine"
        edit(path, [SetCell(sheet, 2, 1, "theirs")])
        with pytest.raises(FileChanged):
            edit(path, [SetCell(sheet, 2, 1, "mine")], expected_digest=digest)
        assert texts(path)[sheet][2, 1] == "theirs"
    (folder / ".~lock.T.csv#").write_text("")
    with pytest.raises(SheetsError, match="open in LibreOffice"):
        edit(folder, [SetCell("T", 2, 1, "x")])
    edit(folder, [SetCell("Mine", 2, 1, "x")])  # only the other file is open


def contents(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def when_stored(monkeypatch, act):
    """Call `act` with the number of files that were stored before, whenever one is."""
    real, count = files.os.fsync, []

    def fsync(handle):
        if stat.S_ISREG(os.fstat(handle).st_mode):
            act(len(count))
            count.append(handle)
        real(handle)

    monkeypatch.setattr(files.os, "fsync", fsync)


def refuse_once(monkeypatch, name):
    """The system refuses once to rename or delete the file of that name, or to give it to another file."""
    left = [name]
    for function in ("replace", "rename", "unlink"):
        real = getattr(os, function)

        def refused(*paths, real=real, **options):
            if left and any(Path(p).name == name for p in paths):
                left.clear()
                raise PermissionError(13, "Permission denied")
            return real(*paths, **options)

        monkeypatch.setattr(files.os, function, refused)


BOTH = [SetCell("T", 2, 1, "x"), SetCell("Mine", 2, 1, "y")]


def test_when_the_disk_is_full_all_files_of_a_folder_stay(folder, monkeypatch):
    before = contents(folder)

    def full(count):
        if count:
            raise OSError(28, "No space left on device")

    when_stored(monkeypatch, full)
    with pytest.raises(SheetsError, match="No space left"):
        edit(folder, BOTH)
    assert contents(folder) == before


def test_what_leads_back_is_not_swept_away(folder, monkeypatch):
    """Somebody opens the workbook while an edit of it that fails is under way; what is kept for the way back is old."""
    for name in "T.csv", "Mine.csv":
        os.utime(folder / name, (1, 1))
    (folder / "T.csv.Mine.csv").write_bytes(b"a\n1\n")  # its temporary files begin as those of T.csv
    before, real = contents(folder), os.unlink

    def opened_meanwhile(*paths, **options):
        if Path(paths[0]).name == "Mine.csv":
            files.clean_up(folder)
            raise PermissionError(13, "Permission denied")
        real(*paths, **options)

    monkeypatch.setattr(files.os, "unlink", opened_meanwhile)
    with pytest.raises(SheetsError, match="Permission denied"):
        edit(folder, [*BOTH, SetCell("T.csv.Mine", 2, 1, "z"), DeleteSheet("Mine")])
    assert contents(folder) == before


def test_what_a_killed_program_left_in_a_folder_is_cleaned_up(folder):
    before = contents(folder)
    (folder / ".New.csv.0123abcd.part").write_bytes(b"half")
    (folder / ".theirs.part").write_bytes(b"another program's")
    os.utime(folder / ".New.csv.0123abcd.part", (1, 1))
    files.clean_up(folder)
    assert contents(folder) == before | {".theirs.part": b"another program's"}


def test_a_linked_file_that_is_open_is_left(folder, tmp_path_factory):
    far = tmp_path_factory.mktemp("far")
    (folder / "T.csv").rename(far / "far.csv")
    (folder / "T.csv").symlink_to(far / "far.csv")
    (far / ".~lock.far.csv#").write_text("")
    before = contents(folder)
    with pytest.raises(SheetsError, match="open in LibreOffice"):
        edit(folder, BOTH)
    assert contents(folder) == before


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("name", ["T.csv", "Mine.csv"])
def test_when_a_file_cannot_be_replaced_the_others_stay(folder, monkeypatch, name, links):
    def no_links(*paths, **options):
        raise OSError(95, "Operation not supported")

    if not links:
        monkeypatch.setattr(files.os, "link", no_links)
    before = contents(folder)
    refuse_once(monkeypatch, name)
    with pytest.raises(SheetsError, match="Permission denied"):
        edit(folder, [*BOTH, AddSheet("New", [["a"]], before="Mine"), MoveSheet("T", "Mine")])
    assert contents(folder) == before
    edit(folder, [*BOTH, AddSheet("New", [["a"]], before="Mine"), MoveSheet("T", "Mine")])
    assert sorted(contents(folder)) == ["Mine.csv", "New.csv", "T.csv", "order.txt"]


def test_a_sheet_whose_file_cannot_be_deleted_stays(folder, monkeypatch):
    before = contents(folder)
    refuse_once(monkeypatch, "Mine.csv")
    with pytest.raises(SheetsError, match="Permission denied"):
        edit(folder, [RenameSheet("Mine", "Ours")])
    assert contents(folder) == before


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("Mine.csv", RenameSheet("Mine", "Ours")),
        ("order.txt", MoveSheet("T", "Mine")),
        ("Ours.csv", RenameSheet("Mine", "Ours")),
    ],
)
@pytest.mark.parametrize("there", [True, False])
def test_what_another_program_saves_meanwhile_stays(folder, monkeypatch, name, change, there):
    if there and name != "Ours.csv":
        (folder / name).write_text("Mine\nT\n")
    before = contents(folder)
    when_stored(monkeypatch, lambda count: (folder / name).write_text("theirs, theirs"))
    with pytest.raises(SheetsError, match=r"at this moment|already a file"):
        edit(folder, [change])
    assert contents(folder) == before | {name: b"theirs, theirs"}


def test_what_another_program_saves_while_a_folder_is_read_stays(folder, monkeypatch):
    real, saved = files.file_bytes, []

    def then_saved(path, *most):
        data = real(path, *most)
        if path.name == "T.csv" and not saved:
            path.write_bytes(b"From;Operator;Parameter;To\r\ntheirs;map;;\r\n")
            saved.append(path)
        return data

    monkeypatch.setattr(files, "file_bytes", then_saved)
    for place in (folder, folder / "T.csv"):
        saved.clear()
        (folder / "T.csv").write_bytes(b"From;Operator;Parameter;To\r\nold;map;;\r\n")
        with pytest.raises(SheetsError, match="at this moment"):
            edit(place, [SetCell("T", 2, 1, "mine")])
    assert b"theirs" in (folder / "T.csv").read_bytes()


@pytest.mark.parametrize("read", [True, False])
def test_a_file_that_goes_while_a_folder_is_read(folder, monkeypatch, read):
    real = files.file_bytes

    def gone(path, *most):
        data = real(path, *most) if read else b""
        path.unlink(missing_ok=True)
        return data or real(path, *most)

    monkeypatch.setattr(files, "file_bytes", gone)
    with pytest.raises(SheetsError, match="was changed by"):
        edit(folder, [SetCell("T", 2, 1, "mine")])


def test_the_folder_is_read_as_it_was_edited_through_a_link(folder):
    (folder / "T.csv").rename(folder.parent / "far.csv")
    (folder / "T.csv").symlink_to(folder.parent / "far.csv")
    edit(folder, BOTH)
    assert (folder / "T.csv").is_symlink() and b"x" in (folder.parent / "far.csv").read_bytes()
    edit(folder, [RenameSheet("T", "Ours")])
    assert sorted(contents(folder)) == ["Mine.csv", "Ours.csv"] and (folder.parent / "far.csv").exists()


def test_an_order_of_the_users_own_is_not_replaced(tmp_path):
    (tmp_path / "order.txt").write_text("2 pizzas\n")
    for sheets in ({"B": [["x"]], "A": [["y"]]}, {"A": [["x"]]}):
        with pytest.raises(SheetsError, match=r"already a file “order\.txt”"):
            write_csv(sheets, tmp_path)
        assert contents(tmp_path) == {"order.txt": b"2 pizzas\n"}


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=example_count(60))
@example([["0"]], 2, 1, ";1")  # in a narrow table, what could be the file's own delimiter
@example([["0"]], 2, 2, ";;")
@given(
    ROWS.filter(lambda rows: any(t.strip() for row in rows for t in row)), st.integers(2, 6), st.integers(1, 5), SPICY
)
def test_any_edit_of_any_text(tmp_path, rows, row, column, text):
    """The edited cell comes back, all others are what they were."""
    for old in (tmp_path / "csv").glob("*") if (tmp_path / "csv").exists() else ():
        old.unlink()
    sheets = {"S": rows, "R": [["x"]]}
    for path in (write_csv(sheets, tmp_path / "csv"), write_sheets(sheets, tmp_path / "x.md")):
        before = texts(path)
        if "S" not in before:
            continue
        edit(path, [SetCell("S", row, column, text)])
        after = texts(path)
        mine = after["S"].pop((row, column), "")
        before["S"].pop((row, column), None)
        assert after == before
        clean = from_csv(text) if path.is_dir() else text
        if "'" not in text:
            assert mine.strip().replace(" \n", "\n") == clean.strip().replace(" \n", "\n")


def test_rows_helper_keeps_numbers(folder):
    assert to_rows(read_sheets(folder))["T"][2] == []


# ---- tab-separated files


def test_a_folder_of_tab_separated_files(tmp_path):
    (tmp_path / "T.tsv").write_text("From\tOperator\tParameter\tTo\nRed ball\tmap\tMAX(1, 2)\tX\n", "utf-8")
    (tmp_path / "Mine.TSV").write_text("a, b, c\n1, 2, 3", "utf-8")  # one column
    assert texts(tmp_path) == {
        "Mine": {(1, 1): "a, b, c", (2, 1): "1, 2, 3"},
        "T": {(1, 1): "From", (1, 2): "Operator", (1, 3): "Parameter", (1, 4): "To",
              (2, 1): "Red ball", (2, 2): "map", (2, 3): "MAX(1, 2)", (2, 4): "X"},
    }  # fmt: skip
    edit(tmp_path, [SetCell("T", 2, 4, "a\tb"), SetCell("Mine", 2, 2, "z"), AddSheet("New", rows=[["p,q", "r"]])])
    assert (tmp_path / "T.tsv").read_text("utf-8").endswith('MAX(1, 2)\t"a\tb"\n')
    assert (tmp_path / "Mine.TSV").read_text("utf-8") == "a, b, c\n1, 2, 3\tz"
    assert texts(tmp_path)["New"] == {(1, 1): "p,q", (1, 2): "r"} and (tmp_path / "New.tsv").is_file()
    edit(tmp_path, [RenameSheet("New", "Newer"), DeleteSheet("Mine")])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["Newer.tsv", "T.tsv", "order.txt"]
    edit(tmp_path / "T.tsv", [SetCell("T", 2, 1, "Blue ball")])  # one file is a workbook, too
    assert read(tmp_path / "T.tsv").workbook.behaviours[0].rows[0].inputs[0].text == "Blue ball"


def test_two_files_of_one_sheet_are_refused(tmp_path):
    for suffix in ("csv", "tsv"):
        (tmp_path / f"T.{suffix}").write_text("a\tb\n")
    with pytest.raises(UnreadableFile, match=r"“T\.csv” and “T\.tsv” are both the sheet “T”") as caught:
        read(tmp_path)
    assert caught.value.code == "FILE021" and caught.value.remedy
    with pytest.raises(SheetsError, match="CSV files in"):
        write_csv({"S": [["x"]]}, tmp_path)
