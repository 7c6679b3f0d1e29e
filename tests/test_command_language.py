"""Commands in the reader's language: from the catalogue alone, chosen as other programs do, on every terminal."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from gettext import NullTranslations
from pathlib import Path

import click
import pytest
from recorded import END, EVENT, HEADER, write_run
from typed import run

from rrp_sheets import texts
from rrp_sheets.cli.language import in_readers_language, of_environment
from rrp_sheets.cli.main import COMMANDS, group
from rrp_sheets.render.style import columns
from rrp_sheets.render.texts import texts as render_texts

PATHS = [os.fsencode(path) for path in sys.path]
PROGRAM = f"""
import os, sys
sys.path[:] = map(os.fsdecode, {PATHS})
from rrp_sheets.cli.main import main
for *sys.argv[1:], wanted in (["--help", 0], ["check", os.fsdecode({os.fsencode("誤.md")}), 1], ["chekc", 2]):
    try:
        main()
    except SystemExit as end:
        assert (end.code or 0) == wanted, (sys.argv, end.code)
    else:
        assert wanted == 0, sys.argv
"""
"""Commands without Python's own reading of .pth files, which fails where a path is not in the locale's letters."""

HEAD = "| Input streams | Connector | Formula | Output stream | On | Notes |\n|---|---|---|---|---|---|"
WRONG = "| 近い | map | 距離な | 遠い | | |\n"
TESTS = """
## ためし

| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | 赤い玉 | distance=0.3 | |
| 0 | 近い | | 0.3 |
| 10 | 近い | | 9 |
"""
BOOK = f"""## うごき

{HEAD}
| 赤い玉 | map | 赤い玉.distance | 距離 | | |
| 距離 | filter | 距離 < 1 | 近い | | |
| 近い | subscribe | | 頭 | | |
{WRONG}
## Devices

| Stream | Device | Mode |
|---|---|---|
| 赤い玉 | Red ball | |
| 頭 | Tracker | Head |
"""


class Brackets(NullTranslations):
    """A language in which every text of the catalogue stands between brackets."""

    def gettext(self, message: str) -> str:
        return f"⟦{message}⟧" if message else ""

    def pgettext(self, context: str, message: str) -> str:
        return self.gettext(message)

    def ngettext(self, one: str, many: str, n: int) -> str:
        return self.gettext(one if n == 1 else many)


@pytest.fixture
def brackets(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(texts, "_catalogue", lambda language: Brackets())
    monkeypatch.setattr("gettext.dgettext", lambda domain, message: Brackets().gettext(message))
    monkeypatch.setattr("gettext.dngettext", lambda domain, one, many, n: Brackets().ngettext(one, many, n))
    monkeypatch.setenv("LANGUAGE", "")
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    render_texts.cache_clear()
    yield
    render_texts.cache_clear()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a workbook, one with an error, and a run."""
    monkeypatch.chdir(tmp_path)
    Path("誤.md").write_text(BOOK, encoding="utf-8")
    Path("良.md").write_text(BOOK.replace(WRONG, "") + TESTS, encoding="utf-8")
    write_run(tmp_path, "1", HEADER | {"participant": "甲", "condition": "対照", "name": "良.md"}, EVENT, END)
    return tmp_path


def outside(said: str) -> set[str]:
    """The words of a text that stand in no brackets, without options, files, codes and cells."""
    while (rest := re.sub("⟦[^⟦⟧]*⟧", " ", said)) != said:
        said = rest
    said = re.sub(r"--?[a-z][\w-]*|[\w/-]+\.(xlsx|md|jsonl|svg|csv|zip|toml|gif|png)|\b[A-Z]+\d+\b", " ", said)
    return set(re.findall(r"[A-Za-z][A-Za-z']+", said))


# ---- all words are in the catalogue
NAMES = {"rrp", "sheets", "en", "ja", *COMMANDS}
ROW = {
    "map",
    "filter",
    "subscribe",
    "distance",
    "red",
    "width",
    "height",
    "row",
}  # of the workbook, its values and Python


@pytest.mark.usefixtures("brackets")
@pytest.mark.parametrize("command", ["", *COMMANDS, "runs list", "runs delete"])
def test_help_has_no_text_outside_the_catalogue(command: str) -> None:
    code, said = run(*command.split(), "--help")
    assert code == 0 and said.count("⟦") > 3
    placeholders = {word for word in outside(said) if word.isupper()}
    lines = {
        "git",
        "config",
        "diff",
        "textconv",
        "text",
        "echo",
        "gitattributes",
        "xlsx",
        "list",
        "delete",
    }  # to be typed
    lines |= {
        "high",
        "five",
        "my",
        "pose",
        "simulated",
        "pilot",
        "letter",
        "nao",
        "guided",
        "board",
        "participants",
    } | {"High", "BUNDLE"}
    joints = {"RShoulderPitch", "RElbowRoll", "RHand"}
    assert outside(said) - placeholders - NAMES - lines - joints == set()


@pytest.mark.usefixtures("brackets")
@pytest.mark.parametrize(
    ("typed", "wanted"),
    [
        ("check 誤.md", 1), ("check 誤.md --fix 直.md", 1), ("check 良.md --report 報.xlsx", 0), ("test 良.md", 1),
        ("explain 良.md", 0), ("explain 良.md -o 説.txt", 0), ("diagram 良.md -o 図.svg", 0), ("marbles 誤.md", 1),
        ("marbles 良.md -o 図.svg", 0), ("convert 良.md 良.xlsx", 0), ("new 新.xlsx", 0), ("new 良.md", 2),
        ("diff 良.md 誤.md", 1), ("diff 良.md 良.md", 0), ("diff 良.md 誤.md -o 差.html", 1), ("print 誤.md", 1),
        ("run 誤.md --fast", 1), ("runs .", 0), ("runs . --participant 乙", 0), ("runs delete . --participant 乙", 2),
        ("runs delete . --participant 甲 --yes", 0), ("export runs/1 -o 表.csv", 0), ("export runs/1 -o 表.doc", 2),
        ("faces .", 0), ("faces . --forget 誰", 2), ("faces . --forget-all", 0), ("formula 1+あ", 1), ("formula", 2),
        ("formula 1+あ --input あ", 2), ("replay runs/1", 2), ("serve 無", 2), ("tutorial 無", 2), ("help ううう", 2),
        ("check", 2), ("check --nothing", 2), ("chekc", 2), ("print 良.md --paper b5", 2), ("run 良.md --for あ", 2),
        ("marbles 良.md --from あ", 2), ("check 良.md --apply あ", 2), ("diff 良.md", 2), ("runs delete .", 2),
        ("check 無.xlsx", 2), ("run 無.md", 2), ("check 無.zip", 2), ("pack 無.md", 2), ("--version", 0),
    ],
)  # fmt: skip
def test_a_command_prints_no_text_outside_the_catalogue(folder: Path, typed: str, wanted: int) -> None:
    code, said = run(*typed.split())
    assert code == wanted and "⟦" in said
    placeholders = {word for word in outside(said) if word.isupper()}
    assert outside(said) - placeholders - NAMES - ROW - {"list", "delete", "md"} == set()


@pytest.mark.usefixtures("brackets")
def test_changes_of_a_workbook_are_told_by_the_catalogue(folder: Path) -> None:
    assert run("convert", "良.md", "良.xlsx")[0] == 0
    for typed in (
        ["set", "良.xlsx", "C3", "距離 < 2"], ["set", "良.xlsx", "C3", "距離 <"], ["set", "良.xlsx", "Z", "あ"],
        ["rename", "良.xlsx", "距離", "きょり", "--preview"], ["rename", "良.xlsx", "距離", "きょり"],
        ["rename", "良.xlsx", "無", "有"],
    ):  # fmt: skip
        _, said = run(*typed)
        assert "⟦" in said and outside(said) - ROW == set()


@pytest.mark.usefixtures("brackets")
@pytest.mark.slow
def test_a_run_is_told_by_the_catalogue(folder: Path) -> None:
    pytest.importorskip("pybullet")
    code, said = run("run", "良.md", "--fast", "--for", "1s", "--out", "出")
    assert code == 0 and said.count("⟦") > 10 and outside(said) == set()


# ---- the language that is chosen
@pytest.mark.parametrize(
    ("variables", "language"),
    [
        ({}, ""), ({"LANG": "C.UTF-8"}, ""), ({"LANG": "POSIX"}, ""), ({"LANG": "ja_JP.UTF-8"}, "ja"),
        ({"LANG": "ja"}, "ja"), ({"LANG": "en_GB.UTF-8"}, "en"), ({"LANG": "ja_JP", "LC_MESSAGES": "en_US"}, "en"),
        ({"LC_ALL": "ja_JP.eucJP", "LANG": "en_US"}, "ja"), ({"LC_ALL": "C", "LANG": "ja_JP.UTF-8"}, ""),
        ({"LANG": "en_US.UTF-8", "LANGUAGE": "xx:ja:en"}, "ja"), ({"LANG": "C", "LANGUAGE": "ja"}, ""),
        ({"LANG": "fr_FR.UTF-8"}, ""), ({"LANG": "../../ja"}, ""), ({"LANG": "_"}, ""), ({"LANG": "ja@x"}, "ja"),
    ],
)  # fmt: skip
def test_the_environment_names_the_language_as_for_other_programs(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], language: str
) -> None:
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert of_environment() == language


@pytest.mark.parametrize(
    "typed", [["--language", "ja", "--help"], ["--help", "--language=ja"], ["help", "check", "--language", "ja"]]
)
def test_the_option_goes_before_the_environment(monkeypatch: pytest.MonkeyPatch, typed: list[str]) -> None:
    monkeypatch.setenv("LC_ALL", "en_US.UTF-8")
    code, said = run(*typed)
    assert code == 0 and "使い方:" in said
    assert os.environ.get("LANGUAGE") in (None, "")
    assert "Usage:" in run("--help")[1]


def test_an_unknown_language_is_refused_in_the_known_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    code, said = run("check", "x.md", "--language", "xx")
    assert code == 2 and "'xx'は使えません" in said


def test_a_workbook_is_told_of_in_the_readers_language_or_else_in_its_own(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("日.md").write_text(BOOK + "\n## Protocol\n\n| Field | Value |\n|---|---|\n| Language | 日本語 |\n", "utf-8")
    monkeypatch.setenv("LC_ALL", "C")
    assert "エラー1件" in run("check", "日.md")[1] and "1 error" in run("check", "誤.md")[1]
    monkeypatch.setenv("LC_ALL", "en_US.UTF-8")
    assert "1 error" in run("check", "日.md")[1] and "エラー1件" in run("check", "誤.md", "--language", "ja")[1]


@pytest.mark.parametrize("typed", ["check 誤.md --json", "test 良.md --json", "runs . --json", "formula 1+x --json"])
def test_what_programs_read_is_the_same_in_every_language(
    folder: Path, monkeypatch: pytest.MonkeyPatch, typed: str
) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    english = run(*typed.split())
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    assert re.sub(r'"seconds": [\d.]+', "", run(*typed.split())[1]) == re.sub(r'"seconds": [\d.]+', "", english[1])


# ---- every terminal
@pytest.mark.parametrize(
    "environment",
    [
        {"LC_ALL": "C"}, {"LC_ALL": "ja_JP.UTF-8", "PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "ja_JP.SJIS", "PYTHONUTF8": "0"}, pytest.param({"LC_ALL": "ja_JP.UTF-8"}, marks=pytest.mark.slow),
        pytest.param({"LC_ALL": "nonsense.☃"}, marks=pytest.mark.slow),
        pytest.param({"LANG": "ja_JP.eucJP"}, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_no_locale_breaks_a_command(folder: Path, environment: dict[str, str]) -> None:
    others = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "LANG", "PYTHONIO"))}
    done = subprocess.run(
        [sys.executable, "-S", "-c", PROGRAM], env=others | environment, capture_output=True, timeout=120
    )
    assert done.returncode == 0 and b"Traceback" not in done.stderr, done.stderr


@pytest.mark.parametrize("width", [50, 60, 78])
def test_japanese_help_fits_the_terminal(monkeypatch: pytest.MonkeyPatch, width: int) -> None:
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    monkeypatch.setattr("click.formatting.FORCED_WIDTH", width)
    for command in ("", *COMMANDS):
        lines = run(*command.split(), "--help")[1].splitlines()[1:]
        assert [
            line for line in lines if columns(line) > width + 1 and not re.search("  |http|git |[\\w-]{20}", line)
        ] == []
        assert not [line for line in lines if line.strip()[:1] in "、。）」ー" and line.strip()]


def test_english_help_is_as_click_writes_it() -> None:
    plain = click.Context(group, info_name="rrp-sheets")
    for name in ("check", "diff"):
        command = group.get_command(plain, name)
        assert command is not None
        context = in_readers_language(command).make_context(name, [], resilient_parsing=True)
        assert "\n  " in context.get_help() and max(map(len, context.get_help().splitlines())) <= 78


def test_lists_of_japanese_texts_align(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_run(folder, "2", HEADER | {"participant": "参加者", "name": "greeting.md"}, EVENT, END)
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    lines = run("runs", ".")[1].splitlines()
    assert lines[0].startswith("日時") and len(lines) == 3
    assert len({columns(line[: line.index("8.0秒")]) for line in lines[1:]}) == 1
