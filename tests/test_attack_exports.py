"""Exports with -o never replace other work, whatever the names are."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import openpyxl
import pytest
from click.testing import CliRunner
from recorded import END, EVENT, HEADER, write_run

from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import files
from rrp_sheets.workbook.files import write_atomically

WORKBOOK = Path(__file__).parents[1] / "workbooks" / "greeter.xlsx"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return write_run(tmp_path, "good", HEADER, EVENT, END)


@pytest.mark.parametrize("name", ["work.xlsx", "Protocol.csv", "odd.xlsx", "mine.csv"])
def test_a_table_of_a_run_replaces_only_such_a_table(run: Path, tmp_path: Path, name: str) -> None:
    work = {"work.xlsx": WORKBOOK.read_bytes(), "Protocol.csv": b"Title,Session\n", "odd.xlsx": b"PK\3\4 no zip"}
    target = tmp_path / name
    target.write_bytes(work.get(name, b"Score\n3\n"))
    before = target.read_bytes()
    for _ in range(2):
        ran = CliRunner().invoke(group, ["export", str(run), "-o", str(target)])
        assert isinstance(ran.exception, SheetsError) and "not a table of a run" in ran.exception.message
        assert target.read_bytes() == before
    target.unlink()
    for _ in range(2):  # its own is renewed
        assert CliRunner().invoke(group, ["export", str(run), "-o", str(target)]).exit_code == 0


@pytest.mark.parametrize("option", [["explain", str(WORKBOOK), "-o"], ["test", str(WORKBOOK), "--junit"]])
def test_a_record_is_no_place_for_a_text(option: list[str], run: Path) -> None:
    trace = run / "trace.jsonl"
    before = trace.read_bytes()
    ran = CliRunner().invoke(group, [*option, str(trace)])
    assert isinstance(ran.exception, SheetsError) and "a run's record" in ran.exception.message
    assert trace.read_bytes() == before


@pytest.mark.parametrize("target", ["", ".", "..", "folder"])
def test_a_folder_is_no_file_to_write(target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SheetsError, match="not a file that can be replaced"):
        write_atomically(Path(target), b"x")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


@pytest.mark.skipif(sys.platform == "win32", reason="names are of letters there, not of bytes")
def test_a_name_that_is_as_long_as_can_be(tmp_path: Path) -> None:
    for name in ("n" * 250 + ".svg", "日" * 83 + ".md"):
        write_atomically(tmp_path / name, b"x")
        write_atomically(tmp_path / name, b"y")
        assert (tmp_path / name).read_bytes() == b"y"
    with pytest.raises(SheetsError, match="too long") as caught:
        write_atomically(tmp_path / ("n" * 252 + ".svg"), b"x")
    assert caught.value.remedy == "Choose a shorter name."
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_name_of_another_systems_letters_is_printed(tmp_path: Path) -> None:
    file = tmp_path / os.fsdecode(b"gr\xe4.xlsx")
    file.write_bytes(WORKBOOK.read_bytes())
    ran = CliRunner().invoke(group, ["print", str(file), "-o", str(tmp_path / "out.pdf")])
    assert ran.exception is None or isinstance(ran.exception, SystemExit), ran.exception
    assert (tmp_path / "out.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_table_of_a_run_with_such_a_name_can_be_opened(run: Path, tmp_path: Path) -> None:
    odd = run.rename(run.with_name(os.fsdecode(b"gr\xe4")))
    target = tmp_path / "out.xlsx"
    assert CliRunner().invoke(group, ["export", str(odd), "-o", str(target)]).exit_code == 0
    assert openpyxl.load_workbook(target).properties.title == "Run gr\ufffd of good.md"


def test_a_table_that_cannot_be_made_whole_says_one_thing(
    run: Path, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    with (run / "trace.jsonl").open("a") as file:
        file.write('{"t": []}\n' * 3 + '{"t": 1}\n')
    ran = CliRunner().invoke(group, ["export", str(run), "-o", str(tmp_path / "out.xlsx")])
    assert isinstance(ran.exception, SheetsError)
    assert not list(tmp_path.glob("out*")) and not list(recwarn)


@pytest.mark.parametrize("there", [False, True])
def test_half_a_workbook_is_not_left_in_a_folder(there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "out"
    if there:
        folder.mkdir()
    real = os.link

    def full(half: str, path: Path) -> None:
        if Path(path).name == "Scene.csv":
            raise FileExistsError
        real(half, path)

    monkeypatch.setattr(files.os, "link", full)
    ran = CliRunner().invoke(group, ["convert", str(WORKBOOK), str(folder)])
    assert isinstance(ran.exception, SheetsError)
    assert [p.name for p in tmp_path.rglob("*")] == (["out"] if there else [])


def test_no_text_takes_the_place_of_a_workbook(tmp_path: Path) -> None:
    for name in ("t.md", "T.MARKDOWN", "old.xls", "mine.ods", "new.tsv", "macro.xltm"):
        target = tmp_path / name
        if name != "new.tsv":
            target.write_text("## T\n\n| From | To |\n|---|---|\n", encoding="utf-8")
        before = target.read_bytes() if target.exists() else None
        ran = CliRunner().invoke(group, ["explain", str(WORKBOOK), "-o", str(target)])
        assert isinstance(ran.exception, SheetsError) and "has the name of a workbook" in ran.exception.message, name
        assert (target.read_bytes() if target.exists() else None) == before


@pytest.mark.parametrize("there", [None, "", "# Notes\n\n| no | sheet |\n"])
def test_a_text_replaces_a_text_in_markdown(there: str | None, tmp_path: Path) -> None:
    target = tmp_path / "told.md"
    if there is not None:
        target.write_text(there, encoding="utf-8")
    for _ in range(2):  # the second time its own
        ran = CliRunner().invoke(group, ["explain", str(WORKBOOK), "-o", str(target)])
        assert ran.exit_code == 0 and "Written" in ran.output
