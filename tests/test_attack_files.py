"""What is written about a workbook never takes a workbook's place."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError

WORKBOOK = Path(__file__).parents[1] / "workbooks" / "greeter.xlsx"


@pytest.mark.parametrize("option", [["explain", "-o"], ["test", "--junit"], ["check", "--fix"], ["check", "--report"]])
@pytest.mark.parametrize("name", ["a.xlsx", "linked.md"])
def test_the_workbook_itself_is_not_overwritten(option: list[str], name: str, tmp_path: Path) -> None:
    file = tmp_path / "a.xlsx"
    file.write_bytes(WORKBOOK.read_bytes())
    if name == "linked.md":
        (tmp_path / name).symlink_to(file)
    ran = CliRunner().invoke(group, [option[0], str(file), option[1], str(tmp_path / name)])
    assert isinstance(ran.exception, SheetsError)
    assert file.read_bytes() == WORKBOOK.read_bytes()


@pytest.mark.parametrize("option", [["explain", "-o"], ["test", "--junit"]])
def test_another_workbook_is_not_overwritten(option: list[str], tmp_path: Path) -> None:
    other = tmp_path / "other.xlsx"
    other.write_bytes(b"somebody's work")
    ran = CliRunner().invoke(group, [option[0], str(WORKBOOK), option[1], str(other)])
    assert isinstance(ran.exception, SheetsError)
    assert other.read_bytes() == b"somebody's work"
