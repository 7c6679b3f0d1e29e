"""The table of commands in the browser: what the help on keys, the menus and the buttons take from it."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes
from panel import HEADER
from playwright.sync_api import expect

import rrp_sheets.help
from rrp_sheets.resources import bundled

BOOKS = {"a.xlsx": {"T": [HEADER, ["", "Head yaw", "filter", "headYaw > 3", "Far", ""]]}}
HEAD = ["# Keys of the grid", "", "The grid in the browser (`rrp-sheets serve`) has the keys of a spreadsheet."]


@pytest.fixture(scope="module")
def commands(page: Any) -> list[dict[str, Any]]:
    """The entries of the table, without what they do."""
    page.goto("/")
    found: list[dict[str, Any]] = page.evaluate(
        """async () => {
            const { COMMANDS, hint } = await import("/static/commands.js");
            return COMMANDS.map((one) => ({ ...one, run: undefined, when: Boolean(one.when), hint: hint(one) }));
        }"""
    )
    return found


@pytest.mark.slow
def test_help_on_keys_has_the_lines_of_the_table(commands: list[dict[str, Any]]) -> None:
    lines = [*HEAD]
    for entry in commands:
        if "section" in entry:
            lines += ["", f"# {entry['section']}", ""]
        if "told" in entry:
            lines.append(f"* {entry['told']} | {entry['help']}")
    told = Path(rrp_sheets.help.__file__).with_name("keys.md").read_text(encoding="utf-8")
    assert told == "\n".join(lines) + "\n"


def test_each_key_does_one_thing_at_its_place(commands: list[dict[str, Any]]) -> None:
    always: set[tuple[str, str]] = set()
    for one in commands:
        meant = {
            (one.get("at", ""), key.removeprefix("Any+")) for key in one.get("keys", ())
        }  # F2 alone is also Any+F2
        assert not meant & always, "an entry before it does that always"
        always |= set() if one["when"] else meant
    names = Counter(one["name"] for one in commands if "name" in one)
    assert [name for name, count in names.items() if count > 1] == []


KEYS = {  # the key as the browser tells it, what is held (c, m, a, s) → what is done in a cell or its editor
    ("cell", "z", "c"): "undo", ("cell", "z", "m"): "undo", ("cell", "Z", "cs"): "redo", ("cell", "y", "c"): "redo",
    ("cell", "+", "c"): "insertAbove", ("cell", "+", "cs"): "insertAbove", ("cell", "-", "c"): "deleteRows",
    ("cell", " ", "s"): "Shift + Space, Ctrl + Space, Ctrl + A", ("cell", "ArrowUp", "a"): "moveUp",
    ("cell", "ArrowUp", "ca"): "Ctrl + arrow", ("cell", "ArrowUp", "c"): "Ctrl + arrow", ("cell", "x", ""): "any letter",
    ("cell", "X", "s"): "any letter", ("cell", "x", "c"): None, ("cell", "F2", ""): "F2", ("page", "F1", "ca"): "help",
    ("editor", "Enter", "a"): "Alt + Enter", ("editor", "Enter", "c"): "keepHere", ("editor", "F1", ""): None,
    ("editor", "Enter", "cs"): "showCells", ("page", "F8", "s"): "previousProblem",
}  # fmt: skip


def test_keys_that_are_pressed_do_what_the_table_says(page: Any) -> None:
    page.goto("/")
    script = """async (keys) => {
            const { COMMANDS, press } = await import("/static/commands.js");
            return keys.map(([at, key, held]) => {
                let done = null;
                for (const one of COMMANDS) Object.assign(one, { run: () => { done = one.name ?? one.told; }, when: undefined });
                press(at, { key, ctrlKey: held.includes("c"), metaKey: held.includes("m"), altKey: held.includes("a"),
                            shiftKey: held.includes("s"), preventDefault() {} }, {});
                return done;
            });
        }"""
    becomes(lambda: page.evaluate(script, [list(key) for key in KEYS]), list(KEYS.values()))


def test_every_button_of_a_page_names_a_command(commands: list[dict[str, Any]]) -> None:
    texts = [path.read_text(encoding="utf-8") for path in bundled("templates", "web").glob("*.html")]
    named = {name for text in texts for name in re.findall(r'data-do="([^"]*)"', text)}
    assert {"help", "name", "test"} <= named <= {one["name"] for one in commands if "name" in one}


@pytest.mark.slow
def test_buttons_of_a_workbook_without_sheets_do_no_harm(page: Any) -> None:
    def without_sheet(route: Any) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, body=re.sub(r'(?s)<table role="grid".*?</table>', "", answer.text()))

    before = len(page.problems)
    page.route("**/book/a.xlsx", without_sheet)
    page.goto("/book/a.xlsx")
    page.evaluate("""() => document.getElementById("listen").dispatchEvent(
        new CustomEvent("checked", { detail: { data: '{"errors": 0, "words": "new"}' } }))""")
    expect(page.locator("[role=grid]")).to_have_count(0)
    for name in ("undo", "redo", "rows", "find", "help", "name"):
        page.click(f"[data-do={name}]")
    page.unroute("**/book/a.xlsx")
    assert page.problems[before:] == []


def test_buttons_name_the_keys_of_their_commands(commands: list[dict[str, Any]]) -> None:
    hints = {one["name"]: one["hint"].replace(" ", "+") for one in commands if "name" in one}
    template = (bundled("templates", "web") / "grid.html").read_text(encoding="utf-8")
    told = dict(re.findall(r'data-do="(\w+)"[^>]* title="\{\{ _\("[^"(]*\(([^)]+)\)"', template))
    assert {"undo", "redo", "find", "help", "nextProblem"} == set(told)
    assert {name: hints[name] for name in told} == told
