"""The table of commands in the browser: what the help on keys, the menus and the buttons take from it."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from panel import HEADER

import rrp_sheets.topics
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


def test_help_on_keys_has_the_lines_of_the_table(commands: list[dict[str, Any]]) -> None:
    lines = [*HEAD]
    for entry in commands:
        if "section" in entry:
            lines += ["", f"# {entry['section']}", ""]
        if "told" in entry:
            lines.append(f"* {entry['told']} | {entry['help']}")
    told = Path(rrp_sheets.topics.__file__).with_name("keys.md").read_text(encoding="utf-8")
    assert told == "\n".join(lines) + "\n"


def test_each_key_does_one_thing_at_its_place(commands: list[dict[str, Any]]) -> None:
    always = Counter((one["at"], key) for one in commands if "at" in one and not one["when"] for key in one["keys"])
    assert [key for key, count in always.items() if count > 1] == []
    names = Counter(one["name"] for one in commands if "name" in one)
    assert [name for name, count in names.items() if count > 1] == []


def test_buttons_name_the_keys_of_their_commands(commands: list[dict[str, Any]]) -> None:
    hints = {one["name"]: one["hint"].replace(" ", "+") for one in commands if "name" in one}
    template = (bundled("templates", "web") / "grid.html").read_text(encoding="utf-8")
    told = dict(re.findall(r'data-do="(\w+)"[^>]* title="[^"(]*\(([^)]+)\)"', template))
    assert {"undo", "redo", "find", "help"} == set(told)
    assert {name: hints[name] for name in told} == told
