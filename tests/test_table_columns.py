"""A column of a table with another name: in the formulas that certainly read it, and in those that perhaps do."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from rrp_sheets import api
from rrp_sheets.checks.table_columns import rename_column
from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.workbook.files import make_workbook, read_sheets

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]
PARTS = [["Ask", "Zone"], ["Where is my head?", "1"], ["And my hand?", "2"]]
OTHERS = [["Zone", "Size"], ["1", "20"]]


def renamed(
    tmp_path: Path, formula: str, new: str = "Touch zone", **more: list[list[str]]
) -> tuple[list[str], list[str]]:
    """The formula where the column Zone of Parts is certainly meant, and where it is perhaps meant too."""
    rows = [
        HEADER, ["Red ball", "map", "INDEX(Parts; 1)", "Part"], ["Red ball", "map", "INDEX(Others; 1)", "Other"],
        ["Part, Other, Red ball", "combineLatest", formula, "Made"],
    ]  # fmt: skip
    path = make_workbook({"T": rows, "Parts": PARTS, "Others": OTHERS, **more}, tmp_path / "x.xlsx")
    _, checked = read_and_check(path)
    found = rename_column(checked, "Parts", "Zone", new, PARTS[0])
    return [e.text for e in found.edits], [e.text for e in found.unsure]


@pytest.mark.parametrize(("formula", "new"), [
    ("Parts[Zone]", "Parts[Touch zone]"),
    ('XLOOKUP("x"; Parts[Ask]; Parts).zone + redBall.distance', 'XLOOKUP("x"; Parts[Ask]; Parts).touchZone + redBall.distance'),
    ("part.zone + other.zone", "part.touchZone + other.zone"),
    ("[p.zone for p in Parts]", "[p.touchZone for p in Parts]"),
    ("PICK(Parts).zone & f\"{part.zone} zone\"", "PICK(Parts).touchZone & f\"{part.touchZone} zone\""),
    ("SUM(Parts[Zone]) - SUM(Others[Zone])", "SUM(Parts[Touch zone]) - SUM(Others[Zone])"),
    ('INDEX(Parts; 1).zone & "Parts[Zone] part.zone"', 'INDEX(Parts; 1).touchZone & "Parts[Zone] part.zone"'),
])  # fmt: skip
def test_what_certainly_reads_the_column_changes(tmp_path: Path, formula: str, new: str) -> None:
    assert renamed(tmp_path, formula) == ([new], [])


@pytest.mark.parametrize("formula", [
    "Others[Zone]", "other.zone", "[o.zone for o in Others]", "INDEX(Others; 1).zone", "Parts[Ask]", "redBall.distance",
])  # fmt: skip
def test_what_reads_something_else_stays(tmp_path: Path, formula: str) -> None:
    assert renamed(tmp_path, formula) == ([], [])


def test_what_perhaps_reads_it_is_told_apart(tmp_path: Path) -> None:
    helpers = [["Name", "Inputs", "Formula"], ["zone of", "row", "row.zone + SUM(Parts[Zone])"]]
    sure, unsure = renamed(tmp_path, "part.ask", Helpers=helpers)
    assert sure == ["row.zone + SUM(Parts[Touch zone])"]
    assert unsure == ["row.touchZone + SUM(Parts[Touch zone])"]


@pytest.mark.parametrize("new", ["", "Ask", "ask", "=x", "a]b", "!!"])
def test_a_name_that_cannot_be_a_column_is_refused(tmp_path: Path, new: str) -> None:
    with pytest.raises(SheetsError) as told:
        renamed(tmp_path, "Parts[Zone]", new)
    assert told.value.remedy


BOOK = {
    "T": [
        HEADER, ["Red ball", "map", "INDEX(Parts; 1)", "Part"], ["Part", "map", "zoneOf(part) + part.zone", "Where"],
        ["Where", "map", "where + SUM(Parts[Zone]) + SUM(Others[Zone])", "Size"], ["Size", "subscribe", "", "Print"],
    ],
    "Helpers": [["Name", "Inputs", "Formula"], ["zone of", "row", "row.zone"]], "Parts": PARTS, "Others": OTHERS,
}  # fmt: skip
SURE = {"Parts!B1: “Zone” → “Touch zone”", "T!C3: “zoneOf(part) + part.zone” → “zoneOf(part) + part.touchZone”",
        "T!C4: “where + SUM(Parts[Zone]) + SUM(Others[Zone])” → “where + SUM(Parts[Touch zone]) + SUM(Others[Zone])”"}  # fmt: skip
UNSURE = "“row.zone” → “row.touchZone”"


def command(path: Path, *words: str) -> list[str]:
    """The lines that the command rename prints."""
    return CliRunner().invoke(group, ["rename", str(path), *words]).output.splitlines()


def texts(path: Path) -> dict[str, str]:
    """The texts of the cells by their places."""
    return {f"{s.name} {place}": cell.typed for s in read_sheets(path) for place, cell in s.cells.items()}


@pytest.fixture(params=["xlsx", "md"])
def book(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = make_workbook(BOOK, tmp_path / "parts.xlsx")
    return path if request.param == "xlsx" else api.convert(path, tmp_path / "parts.md")


@pytest.mark.parametrize("old", [["Parts[Zone]"], ["parts[zone]"], ["Parts!Zone"], ["Zone", "--sheet", "Parts"]])
def test_the_command_renames_a_column_in_its_header_and_where_it_is_certainly_read(book: Path, old: list[str]) -> None:
    before = texts(book)
    perhaps = f"Helpers!C2 perhaps reads this column: {UNSURE}. If it does, add --also Helpers!C2."
    name, *more = old
    told = command(book, name, "Touch zone", *more, "--preview")
    assert (set(told[:3]), told[3:]) == (SURE, [perhaps, "3 cells would change."]) and texts(book) == before
    told = command(book, name, "Touch zone", *more)
    assert (set(told[:3]), told[3:5]) == (SURE, [perhaps, "3 cells changed."])
    changed = {place: text for place, text in texts(book).items() if before[place] != text}
    assert changed == {
        "Parts (1, 2)": "Touch zone", "T (3, 3)": "zoneOf(part) + part.touchZone",
        "T (4, 3)": "where + SUM(Parts[Touch zone]) + SUM(Others[Zone])",
    }  # fmt: skip


def test_the_command_renames_what_perhaps_reads_the_column_where_that_is_asked(book: Path) -> None:
    told = command(book, "Parts[Zone]", "Touch zone", "--also", "Helpers!C2")
    assert (set(told[:4]), told[4]) == ({*SURE, f"Helpers!C2: {UNSURE}"}, "4 cells changed.")
    assert api.check(book).report.errors == [] and texts(book)["Helpers (2, 3)"] == "row.touchZone"


@pytest.mark.parametrize(("words", "said"), [
    (["Zone", "Place"], "“Zone” is a name in Parts and Others."),  # two tables have it
    (["Parts[Zon]", "Place"], "The table “Parts” has no column “Zon”."),
    (["Lists[Zone]", "Place"], "No formula reads a table “Lists”."),
    (["Parts[Zone]", "Ask"], "The table has a column “Ask” already."),
    (["Parts[Zone]", "Place", "--also", "T!C2"], "T!C2 is not one of the uncertain cells."),
    (["Nobody", "Place"], "No row, device or helper has the name “Nobody”."),
])  # fmt: skip
def test_the_command_says_why_it_cannot_rename_a_column(tmp_path: Path, words: list[str], said: str) -> None:
    path = make_workbook(BOOK, tmp_path / "parts.xlsx")
    before = path.read_bytes()
    refused = CliRunner().invoke(group, ["rename", str(path), *words]).exception
    assert isinstance(refused, SheetsError) and (refused.message, path.read_bytes()) == (said, before)
    assert refused.remedy


def test_a_name_that_a_stream_and_a_column_have_is_the_streams_unless_the_table_is_named(tmp_path: Path) -> None:
    path = make_workbook({**BOOK, "Others": [["Where", "Zone"], ["1", "20"]]}, tmp_path / "parts.xlsx")
    assert "T!D3: “Where” → “Place”" in command(path, "Where", "Place", "--preview")
    assert command(path, "Others[Where]", "Place", "--preview")[0] == "Others!A1: “Where” → “Place”"
    assert command(path, "Ask", "Question", "--preview")[0] == "Parts!A1: “Ask” → “Question”"  # nothing else has it


def test_tests_of_a_stream_with_rows_of_the_table_follow(tmp_path: Path) -> None:
    test = [["Time (ms)", "Stream", "Send", "Expect"], ["0", "Part", "", "zone=1"], ["0", "Other", "", "zone=1"]]
    sure, _ = renamed(tmp_path, "part.ask", Test=test)
    assert sure == ["touchZone=1"]


def test_a_stream_with_brackets_in_its_name_is_renamed(tmp_path: Path) -> None:
    rows = [
        ["Input streams", "Connector", "Formula", "Output stream"],
        ["Red ball", "map", "redBall.distance", "Far [cm]"],
    ]
    path = make_workbook({"T": [*rows, ["Far [cm]", "subscribe", "", "Print"]]}, tmp_path / "b.xlsx")
    assert command(path, "Far [cm]", "Near", "--preview")[:2] == [
        "T!D2: “Far [cm]” → “Near”",
        "T!A3: “Far [cm]” → “Near”",
    ]
