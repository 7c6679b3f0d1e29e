"""The help page of every code: its form, and its examples, which are executed."""

from __future__ import annotations

import datetime as dt
import json
import re
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest
from click.testing import CliRunner
from play import Played, check, example, rows
from test_hostile_files import REFUSED

from rrp_sheets import api
from rrp_sheets.cli.formula import formula_command
from rrp_sheets.diagnostics import CODES, Severity
from rrp_sheets.diagnostics.catalogue import PAGES, completed, load_page, parse_page
from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.runners import FrameRunner
from rrp_sheets.formulas import compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.functions import define
from rrp_sheets.graph import StreamKind
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.registry import Registry
from rrp_sheets.robots import load_robot

HERE = Path(__file__).name
WITH_PAGE = sorted(path.stem for path in PAGES.glob("*.md"))
TABLED = [code for code in WITH_PAGE if load_page(code).wrong]
UNTABLED = [code for code in WITH_PAGE if not load_page(code).wrong]
AT_RUN_TIME = [code for code in TABLED if code.startswith("FORM1")]


def test_every_code_has_a_page_and_every_page_a_code():
    assert sorted(CODES) == WITH_PAGE


def test_a_page_is_prose_of_its_own_code():
    for code in WITH_PAGE:
        page = load_page(code)
        assert page.code == code
        for text in (page.means, page.why, page.mend, *([page.untabled] if page.untabled else [])):
            assert len(text) > 30 and text[-1] in ".?!”)" and (text[0] == text[0].upper() or text[0] == "`"), text
            assert not re.search(r"[{}]|\*\*|https?:", text), text


@pytest.mark.slow
def test_the_wrong_example_gives_this_code_and_nothing_else():
    codes = sorted(set(TABLED) - set(AT_RUN_TIME))
    given = {code: {d.code for d in check(completed(load_page(code).wrong)).report} for code in codes}
    assert {code: found for code, found in given.items() if found != {code}} == {}


@pytest.mark.slow
def test_the_right_example_gives_nothing():
    given = {c: check(completed(load_page(c).right)).report.flatten(["code", "cell", "message"]) for c in TABLED}
    assert {code: found for code, found in given.items() if found} == {}


@pytest.mark.slow
@pytest.mark.parametrize("code", AT_RUN_TIME)
@pytest.mark.parametrize("which", ["wrong", "right"])
def test_examples_of_what_goes_wrong_while_running(code, which):
    markdown = completed(getattr(load_page(code), which))
    assert {d.code for d in check(markdown).report if d.severity is Severity.ERROR} == set()
    assert codes_of_a_run(markdown) == ({code} if which == "wrong" else set())


def codes_of_a_run(markdown: str) -> set[str]:
    """The errors of a run in which every sensor gives its example once."""
    checked = check(markdown)
    played = Played(checked)
    sensors = [s for s in checked.graph.streams.values() if s.kind is StreamKind.SENSOR]
    world = ScriptedWorld((1000, s.id, example(s.name) if s.device.type.payload else 0.1) for s in sensors)
    FrameRunner(world, lambda: FrameEngine(make_plan(checked), played)).go(100_000, RunObserver())
    return {error for _, _, error in played.errors}


@pytest.mark.parametrize(
    "text",
    ["# A\n", "# A\n## Wrong\n", "# A\n## What it means\nx\n## Why it matters\ny\n## How to fix it\nz\n## Right\n"],
)
def test_a_page_without_the_fixed_form_is_refused(text):
    with pytest.raises(ValueError, match="has the sections"):
        parse_page(text)


# ---- codes that no table can show


def sheet(path: Path, *lines: list[object]):
    """A workbook of one behaviour, its sheet for changing, and where to save it."""
    book = openpyxl.Workbook()
    book.active.title = "Tracking"
    for line in (["Input streams", "Connector", "Formula", "Output stream"], *lines):
        book.active.append(line)
    return book, book.active


def _saved(book, path: Path) -> set[str]:
    book.save(path / "x.xlsx")
    return {d.code for d in api.check(path / "x.xlsx").report}


LOOKING = (["Red ball", "sample", "1 s", "Now"], ["Now", "subscribe", None, "Print"])


def a_date(path):
    return _saved(sheet(path, ["Red ball", "map", dt.date(2026, 3, 4), "Now"], LOOKING[1])[0], path)


def merged(path):
    book, page = sheet(path, *LOOKING)
    page.merge_cells("B2:C2")
    page["B2"] = "timestamp"
    return _saved(book, path)


def hidden_row(path):
    book, page = sheet(path, *LOOKING)
    page.row_dimensions[3].hidden = True
    return _saved(book, path)


def hidden_sheet(path):
    book, page = sheet(path, *LOOKING)
    book.create_sheet("Mine")
    page.sheet_state = "hidden"
    return _saved(book, path)


def a_broken_function(path):
    def broken(value):
        """Breaks off."""
        raise ZeroDivisionError if value else ValueError

    functions: Registry = Registry("function")
    functions.add("BROKEN", define(broken))
    formula = compile_formula("broken(x)", make_scope([("x", None)], functions=functions))
    return {formula.prepare(GuardedInterpreter())(0).code}


def no_object(path):
    answers = CliRunner().invoke(formula_command, ["--json"], input="5 + 1\n").output
    return {json.loads(answer)["code"] for answer in answers.splitlines()}


def found(markdown: str) -> set[str]:
    return {d.code for d in check(markdown).report}


def a_device_that_is_not_simulated(path):
    robot = load_robot()
    names = {n: replace(f, type=replace(f.type, simulated=f.type.name != "Sonar")) for n, f in robot.names.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rrp_sheets.checks.check.load_robot", lambda name: replace(robot, names=names))
        return found(rows("| Sonar | sample | 1 s | Ahead |\n| Ahead | subscribe | | Print |"))


TABLE = "\n## Parts\n| Ask |\n|---|\n" + "| Who? |\n" * 1001
MANY = [f"S{i}" for i in range(51)]
MAKERS = {
    "SHEET001": lambda path: found("## Mine\n| When | Do | With |\n|---|---|---|\n| 1 | 2 | 3 |\n"),
    "SHEET006": a_date,
    "DEV009": a_device_that_is_not_simulated,
    "SHEET008": merged,
    "SHEET009": hidden_row,
    "SHEET010": hidden_sheet,
    "SHEET016": lambda path: found(rows(f"| Red ball | map | {'1' * 40_000} | X |\n| X | subscribe | | Print |")),
    "SHEET018": lambda path: found(rows("| Red ball | subscribe | | Print |\n\nMore\n\n| a |\n|---|\n| b |")),
    "SHEET019": lambda path: found(rows("| Red ball | map | ROWS(Parts) | X |\n| X | subscribe | | Print |") + TABLE),
    "SHEET021": lambda path: found(
        rows(
            "\n".join(f"| Red ball | map | {i} | {name} |" for i, name in enumerate(MANY))
            + f"\n| {', '.join(MANY)} | merge | | All |\n| All, {MANY[-1]} | subscribe | | Print |"
        )
    ),
    "GRAPH012": lambda path: found(
        rows("| Red ball | sample | 1 s | |\n" + "| | map | value | |\n" * 500 + "| | subscribe | | Print |")
    ),
    "FORM022": no_object,
    "FORM109": a_broken_function,
}


@pytest.mark.parametrize("code", sorted(MAKERS))
def test_what_no_table_can_show_gives_this_code_and_nothing_else(code, tmp_path):
    assert MAKERS[code](tmp_path) == {code}


def test_every_other_code_is_made_by_a_test_of_files():
    others = (path.read_text(encoding="utf-8") for path in Path(__file__).parent.glob("test_*.py") if path.name != HERE)
    texts = "".join(others)
    files = {code for _, _, code in REFUSED.values()} | {c for c in UNTABLED if c[:4] == "FILE" and f'"{c}"' in texts}
    assert files.isdisjoint(MAKERS) and files | set(MAKERS) == set(UNTABLED)
