"""A column of a table with another name: in the formulas that certainly read it, and in those that perhaps do."""

from __future__ import annotations

from pathlib import Path

import pytest

from rrp_sheets.checks.table_columns import rename_column
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.workbook.files import make_workbook

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


def test_tests_of_a_stream_with_rows_of_the_table_follow(tmp_path: Path) -> None:
    test = [["Time (ms)", "Stream", "Send", "Expect"], ["0", "Part", "", "zone=1"], ["0", "Other", "", "zone=1"]]
    sure, _ = renamed(tmp_path, "part.ask", Test=test)
    assert sure == ["touchZone=1"]
