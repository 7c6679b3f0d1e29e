"""Files that are written about a workbook never replace a workbook."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TextIO

import forked
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


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_trace_that_cannot_be_written_is_told_and_not_left_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rrp_sheets import api
    from rrp_sheets.engine import trace
    from rrp_sheets.engine.plan import make_plan
    from rrp_sheets.engine.trace import TraceWriter
    from rrp_sheets.errors import RunBroken

    opened: list[TextIO] = []
    real = trace.private_text
    monkeypatch.setattr(trace, "private_text", lambda path: opened.append(real(path)) or opened[-1])
    plan = make_plan(api.check(WORKBOOK))
    for path in (Path("/dev/full"), tmp_path / "no" / "folder"):
        with pytest.raises(RunBroken, match="cannot be written"):
            TraceWriter(path, plan, {})
    assert [file.closed for file in opened] == [True]


def test_a_folder_that_cannot_be_made_is_told_with_a_remedy(tmp_path: Path) -> None:
    from rrp_sheets.drivers.simulated import SimulatedWorld
    from rrp_sheets.robots import load_robot

    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(SheetsError, match="cannot be made") as caught:
        SimulatedWorld(load_robot(), [], [], out=blocked / "run")
    assert "--out" in caught.value.remedy


def test_formulas_from_a_closed_input_are_none() -> None:
    code = "import sys; sys.stdin = None; from rrp_sheets.cli.main import main; main()"
    ran = forked.run([sys.executable, "-c", code, "formula", "--json"], capture_output=True, text=True, timeout=300)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")
