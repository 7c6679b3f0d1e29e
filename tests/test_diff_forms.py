"""Forms of a comparison: text, JSON, HTML, the command's exit codes, and git."""

from __future__ import annotations

import html.parser
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import forked
import pytest
from click.testing import CliRunner
from test_diff import BASE, ROW_5, edited

from rrp_sheets import api
from rrp_sheets.cli.main import group
from rrp_sheets.cli.show import text_form
from rrp_sheets.compare.as_html import as_html
from rrp_sheets.compare.side import open_workbook
from rrp_sheets.resources import bundled

WORKBOOKS = sorted(bundled("workbooks").glob("*.xlsx"))
VARIED = {"attention-training", "greeter-with-memory", "story"}
"""Those that have between them all that any of them has to compare."""
PROGRAM = [sys.executable, "-c", "from rrp_sheets.cli.main import main; main()"]


@pytest.fixture
def pair(tmp_path):
    def make(after: str, before: str = BASE) -> tuple[str, str]:
        paths = tmp_path / "before.md", tmp_path / "after.md"
        for path, text in zip(paths, (before, after), strict=True):
            path.write_text(text, encoding="utf-8")
        return str(paths[0]), str(paths[1])

    return make


def run(*arguments: str):
    return CliRunner().invoke(group, ["diff", *arguments])


CHANGED = edited(
    (ROW_5, ROW_5.replace("< 20", "< 15") + "| | | Distance | map | 1 | One | |\n"), ("how far", "in metres")
)  # fmt: skip


def test_text(pair):
    result = run(*pair(CHANGED))
    assert result.exit_code == 1
    assert result.output == (
        "Different behaviour: 2 changes.\n"
        "  Tracking row 4: 20 → 15 in the formula steady < 15\n"
        "  Tracking row 5 added: Distance | map | 1 | One\n"
        "\n"
        "1 difference without effect on the behaviour:\n"
        "  Tracking row 2: notes how far → in metres\n"
    )


def test_quiet_leaves_out_what_has_no_effect(pair):
    result = run("-q", *pair(edited(("how far", "in metres"))))
    assert (result.exit_code, result.output) == (0, "Same behaviour. Only notes are different.\n")


def test_the_same_file_and_a_link_to_it(pair, tmp_path):
    before, _ = pair(BASE)
    (tmp_path / "link.md").symlink_to(before)
    for other in (before, str(tmp_path / "link.md")):
        result = run(before, other)
        assert (result.exit_code, result.output) == (0, "Same behaviour. There is no difference.\n")


def test_errors_are_told(pair):
    result = run(*pair(edited(("near(closeBall)", "near(")), edited(("near(closeBall)", "near("))))
    assert result.exit_code == 0
    assert "The second workbook (" in result.output and "has 1 error. Parts that could not be read" in result.output


def test_json(pair):
    result = run("--json", *pair(CHANGED))
    comparison = json.loads(result.output)
    assert result.exit_code == 1
    assert list(comparison) == ["schema", "same_behaviour", "first", "second", "changes"]
    assert comparison["schema"] == 1 and comparison["same_behaviour"] is False
    assert set(comparison["first"]) == {"source", "digest", "format", "errors"}
    change = next(c for c in comparison["changes"] if c["kind"] == "changed")
    assert change == {
        "kind": "changed", "part": "row", "sheet": "Tracking", "name": "", "what": "formula", "before": "steady < 20",
        "after": "steady < 15", "effect": True, "note": "", "row_before": 4, "row_after": 4,
        "text": "Tracking row 4: 20 → 15 in the formula steady < 15",
        "pieces": [{"kind": "same", "text": "steady < "}, {"kind": "gone", "text": "20"}, {"kind": "new", "text": "15"}],
    }  # fmt: skip


@pytest.mark.parametrize("json_too", [False, True])
def test_a_missing_file_is_unreadable(pair, json_too):
    before, _ = pair(BASE)
    flags = ["--json"] if json_too else []
    done = forked.run([*forked.COMMAND, "diff", before, "no.xlsx", *flags], capture_output=True, text=True)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    if json_too:
        assert json.loads(done.stdout)["error"]["code"] == "FILE001"
    else:
        assert "no.xlsx" in done.stderr


@pytest.mark.parametrize("arguments", [("a.md",), ("--text", "a.md", "b.md"), ("a.md", "b.md", "-o", "c.txt"), ()])
def test_wrong_use_is_told(arguments):
    result = run(*arguments)
    assert result.exit_code == 2 and ("Usage" in result.output)


# ---- HTML


class Page(html.parser.HTMLParser):
    """The tags of a page, checked for balance; its text; the addresses that it would load."""

    VOID = ("meta", "br", "link", "img", "hr", "input")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.open: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.words = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += data


def test_html_is_one_page_that_loads_nothing(pair, tmp_path):
    result = run(*pair(CHANGED), "-o", str(tmp_path / "page.html"))
    assert result.exit_code == 1 and result.output.startswith("Different behaviour: 2 changes. Written:")
    page = Page((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert not page.open and "script" not in page.tags and "link" not in page.tags
    assert not [name for name, _ in page.attributes if name in ("src", "href") or name.startswith("on")]
    assert (
        ("lang", "en") in page.attributes
        and ("scope", "col") in page.attributes
        and ("scope", "row") in page.attributes
    )
    assert page.tags.count("del") == 3 and page.tags.count("ins") == 8  # in the rows, in the list, one in the legend
    for said in ("Different behaviour: 2 changes.", "Tracking row 4", "steady < 15", "notes"):
        assert said in page.words


def test_html_goes_to_standard_output(pair):
    result = run("--html", *pair(BASE))
    assert result.exit_code == 0 and result.output.startswith("<!doctype html>")


HOSTILE = "<script>alert(1)</script>\"'&amp;"


def test_html_escapes_everything(tmp_path):
    name = "<img src=x onerror=alert(2)>"
    text = f"""
## {name}
| Inputs | Connector | Formula | Output | Notes |
|---|---|---|---|---|
| Red ball | map | "{HOSTILE}" | {HOSTILE} | {HOSTILE} |
| {HOSTILE} | subscribe | | Print | |

## Devices
| Stream | Device | {HOSTILE} |
|---|---|---|
| Say {HOSTILE} | {HOSTILE} | {HOSTILE} |

## Protocol
| Field | Value |
|---|---|
| {HOSTILE} | {HOSTILE} |
"""
    folder = tmp_path / "<b>"
    folder.mkdir()
    paths = folder / "a.md", folder / "b.md"
    paths[0].write_text(text, encoding="utf-8")
    paths[1].write_text(text.replace("alert", "prompt"), encoding="utf-8")
    for order in (paths, paths[::-1], (paths[0], Path(os.devnull))):
        page = Page(as_html(api.diff(*order)))
        assert not page.open
        assert not {"script", "img", "b"} & set(page.tags)
        assert not [name for name, _ in page.attributes if name.startswith("on") or name == "src"]


def test_text_cannot_act_on_a_terminal(pair):
    after = edited(("how far", "\x1b[31mred\x07\u202eright"), ("| Title | A study |", "| Title | A \x9b31m study |"))
    output = run(*pair(after)).output
    assert all(c.isprintable() or c == "\n" for c in output) and "red" in output


# ---- formats and git


@pytest.mark.parametrize("path", [
    pytest.param(path, marks=[pytest.mark.slow] * (path.stem not in VARIED), id=path.stem) for path in WORKBOOKS
])  # fmt: skip
def test_twins_have_the_same_behaviour(path, tmp_path):
    source = path.parent / "source" / f"{path.stem}.md"
    text = tmp_path / "text.md"
    text.write_text(text_form(open_workbook(path)), encoding="utf-8")
    odd = tmp_path / "x1Yz_blob"
    odd.write_bytes(path.read_bytes())
    for other in (source, text, odd):
        comparison = api.diff(path, other)
        assert comparison.same and not comparison.changes


def test_a_folder_of_csv_files(tmp_path):
    (tmp_path / "book").mkdir()
    (tmp_path / "book" / "Look.csv").write_text("Input;Connector;Formula;Output\nRed ball;filter;value.x > 1;Near\n")
    book = tmp_path / "book.md"
    book.write_text(
        "## Look\n| Input | Connector | Formula | Output |\n|---|---|---|---|\n| Red ball | filter | value.x>1 | Near |\n"
    )
    comparison = api.diff(tmp_path / "book", book)
    assert comparison.same and [c.kind for c in comparison.changes] == ["written"]
    blob = tmp_path / "blob"
    blob.write_bytes((tmp_path / "book" / "Look.csv").read_bytes())
    assert open_workbook(blob).format == "csv"


def git(folder: Path, *arguments: str) -> str:
    environment = {
        **{k: v for k, v in os.environ.items() if not k.startswith("GIT_")}, "HOME": str(folder), "LC_ALL": "C.UTF-8",
        "GIT_CONFIG_NOSYSTEM": "1", "GIT_AUTHOR_NAME": "T", "GIT_AUTHOR_EMAIL": "t@example.org",
        "GIT_COMMITTER_NAME": "T", "GIT_COMMITTER_EMAIL": "t@example.org",
    }  # fmt: skip
    done = subprocess.run(["git", *arguments], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


@pytest.fixture
def repository(tmp_path):
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    command = tmp_path / "rrp-sheets"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "from rrp_sheets.cli.main import main; main()" "$@"\n')
    command.chmod(0o755)
    folder = tmp_path / "study"
    folder.mkdir()
    git(folder, "init", "-q")
    git(folder, "config", "diff.rrp-sheets.textconv", f"'{command}' diff --text")
    (folder / ".gitattributes").write_text("*.xlsx diff=rrp-sheets\n")
    return folder, command


@pytest.mark.slow
def test_git_compares_workbooks_row_by_row(repository):
    folder, command = repository
    first, second = (bundled("workbooks", name) for name in ("complex-tracking.xlsx", "complex-tracking-fixed.xlsx"))
    shutil.copy(first, folder / "my protocol.xlsx")
    git(folder, "add", ".")
    git(folder, "commit", "-qm", "one")
    shutil.copy(second, folder / "my protocol.xlsx")
    shown = git(folder, "diff")
    assert "Binary" not in shown and "\n+| " in shown and "\n-| " in shown and "@@" in shown
    git(folder, "commit", "-qam", "two")
    assert "\n+| " in git(folder, "log", "-p", "-1")
    told = git(folder, "difftool", "-y", "-x", f"'{command}' diff", "HEAD~1")
    assert told.startswith("Different behaviour:")


@pytest.mark.slow
def test_git_shows_nothing_where_only_the_package_changed(repository):
    folder, _ = repository
    path = folder / "protocol.xlsx"
    shutil.copy(bundled("workbooks", "greeter.xlsx"), path)
    git(folder, "add", ".")
    git(folder, "commit", "-qm", "one")
    from openpyxl import load_workbook
    from openpyxl.styles import Font

    book = load_workbook(path)
    book.active["A1"].font = Font(italic=True)
    book.save(path)
    assert "@@" not in git(folder, "diff") and git(folder, "status", "--short").strip() == "M protocol.xlsx"


def test_git_goes_on_over_a_file_that_is_no_workbook(repository):
    folder, _ = repository
    for content in (b"PK\3\4 broken", b"PK\3\4 broken too"):
        (folder / "data.xlsx").write_bytes(content)
        git(folder, "add", ".")
        git(folder, "commit", "-qm", "data")
    shown = git(folder, "log", "-p", "--reverse")
    assert shown.count("+Not a workbook that can be read (FILE0") == 2


def test_the_text_holds_all_rows_of_a_table_that_a_formula_names(tmp_path):
    path = tmp_path / "book.md"
    words = "".join(f"| word {i} |\n" for i in range(40))
    path.write_text("## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n"
                    f"| Red ball | map | ROWS(Words) | N |\n\n## Words\n| A |\n|---|\n{words}", encoding="utf-8")  # fmt: skip
    book = api.convert(path, tmp_path / "book.xlsx")
    assert "| word 39 |" in text_form(open_workbook(book))


def test_a_file_that_git_does_not_have_is_the_null_device(pair):
    before, _ = pair(BASE)
    result = run(os.devnull, before)
    assert result.exit_code == 1 and "Behaviour Tracking added" in result.output


if shutil.which("soffice"):

    @pytest.fixture(scope="module")
    def saved(tmp_path_factory, office):
        """All workbooks and the template, and the folder where LibreOffice has saved each under its name."""
        folder = tmp_path_factory.mktemp("saved")
        books = {path.stem: path for path in (*WORKBOOKS, api.new(folder / "guided.xlsx"))}
        command = ["soffice", office, "--headless", "--convert-to", "xlsx",
                   "--outdir", str(folder / "out"), *map(str, books.values())]  # fmt: skip
        subprocess.run(command, check=True, capture_output=True, timeout=300)
        return books, folder / "out"

    @pytest.mark.parametrize("name", ["guided", *(path.stem for path in WORKBOOKS)])
    def test_what_libreoffice_saves_has_the_same_behaviour(name, saved):
        books, folder = saved
        path = books[name]
        comparison = api.diff(path, folder / path.name)
        assert comparison.second.digest != comparison.first.digest
        assert comparison.same and not comparison.changes
