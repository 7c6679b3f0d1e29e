"""The workbooks for socially assistive robotics: in order, tested by their own sheets, and changed as therapists do."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import pytest
from test_workbooks import FOLDER, THERAPY

from rrp_sheets import api
from rrp_sheets.checks import Checked
from rrp_sheets.testing import run_tests

REHEARSED = {
    "attention-training": ("Start", 14.0),
    "mixed-control": ("Prompt", 17.0),
}
"""Those that are run here for some seconds, with what begins them."""


@functools.cache
def checked(name: str) -> Checked:
    return api.check(FOLDER / f"{name}.xlsx")


def source(name: str) -> str:
    return (FOLDER / "source" / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", THERAPY)
def test_nothing_is_found_not_even_information(name: str) -> None:
    assert checked(name).report.flatten(["code", "cell"]) == []


@pytest.mark.parametrize("name", THERAPY)
def test_it_says_what_it_is_for_and_how_to_change_it(name: str) -> None:
    book = checked(name).workbook
    for field in ("Title", "Purpose", "Participants", "What happens", "To change it", "Data kept", "Retention"):
        assert len(book.protocol.text(field)) > 10, field
    assert "operator" in book.protocol.text("What happens")
    assert book.protocol.text("Time limit") and book.scene
    notes = [row.notes for b in book.behaviours for row in b.rows]
    assert sum(1 for note in notes if note) >= len(notes) // 8


@pytest.mark.parametrize("name", THERAPY)
def test_its_own_tests_hold(name: str) -> None:
    report = run_tests(checked(name))
    assert len(report.cases) >= 3
    assert [c.case.name for c in report.cases if not c.passed] == []
