"""A run whose workbook is edited meanwhile, or whose process dies, as the run panel tells it."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path

import panel
import pytest
from chromium import GridPage, becomes, eventually, some
from panel import LIVE, ended, row, run, running
from playwright.sync_api import expect
from processes import workers

pytestmark = pytest.mark.usefixtures("unfilmed")
BOOKS = panel.BOOKS


def test_edited_formulas_are_used_in_the_run_or_it_is_said_why_not(browser, url: str, folder: Path) -> None:
    at = GridPage(browser, url, "session.xlsx", sheet="Tracking", name="Aya")
    page = at.page
    run(page)
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^0\.\d+ m$"))
    at.go("D2")
    at.write("redBall.distance + 5")
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"))
    expect(page.locator("#log li[data-kind=edit]")).to_contain_text(re.compile(r"Row 2 used from 0:\d\d\.\d on by Aya"))
    # a row that is inserted above moves no value to another row
    at.go("B2")
    at.press("Control++")
    expect(row(page, 3).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"))
    expect(row(page, 3)).to_have_class(re.compile("lit"))
    expect(row(page, 2).locator(LIVE)).to_have_text("")
    at.press("Control+-")
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"))
    # what is wrong with a cell lies above the values beside it
    at.go("D2")
    at.write("redBall.distence")
    at.go("D2")
    expect(page.locator("td.at > .mends")).to_be_visible()
    eventually(
        lambda: page.locator("td.at > .mends").evaluate("""box => {
        const { right, bottom } = box.getBoundingClientRect();
        const value = document.querySelector("td.example").getBoundingClientRect();
        return right > value.left + 20 && box.contains(document.elementFromPoint(right - 8, bottom - 8));
    }""")
    )
    at.write("redBall.distance + 5")
    # rows that are not the ones that run
    at.go("E3")
    at.write("Very near")
    at.go("B4")
    at.write("Very near")
    expect(page.locator("#run-notice")).to_contain_text("Still running the old rows")
    expect(page.locator("body")).to_have_attribute("data-run", "running")
    page.click("#run-notice button")
    expect(page.locator("#log li[data-kind=edit]")).to_have_count(0)  # a new run has a new log
    running(page)
    expect(page.locator("#run-notice")).to_be_hidden()
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"))
    becomes(lambda: page.locator("#log li").last.inner_text().count("Started by Aya"), 1)
    page.click("[data-run=stop]")
    ended(page)
    at.close()


@pytest.mark.parametrize(
    ("which", "module"),
    [("the run's process", "engine_process"), pytest.param("the simulator", "server", marks=pytest.mark.slow)],
)
def test_a_run_whose_process_dies_says_so_and_can_run_again(
    browser, url: str, folder: Path, which: str, module: str
) -> None:
    at = GridPage(browser, url, "session.xlsx")
    before = workers(os.getpid(), module)
    run(at.page, operator="OP-1")
    # who has no name of their own is the operator
    eventually(lambda: at.page.inner_text("#run-operator b") == "OP-1" and at.page.locator("#run-by").is_hidden())
    becomes(lambda: at.page.inner_text("[data-do=name] span"), "OP-1")
    expect(row(at.page, 2).locator(LIVE)).to_have_text(re.compile(r"^\d"))
    found = some(lambda: len(new := workers(os.getpid(), module) - before) == 1 and new)  # one more may be about to end
    os.kill(found.pop(), signal.SIGKILL)
    assert "The run stopped unexpectedly at " in ended(at.page)
    becomes(lambda: at.page.locator("#run-notice.is-error").count(), 1)
    becomes(lambda: "simulator ended" in at.page.inner_text("#run-notice"), which == "the simulator")
    run(at.page)
    at.page.click("[data-run=stop]")
    assert ended(at.page).startswith("Stopped by OP-1")
    # Stop that comes after the end is no mistake
    becomes(
        lambda: at.page.evaluate(
            "fetch('/run/stop', {method: 'POST', headers: {'X-RRP': 'grid'}}).then(r => r.status)"
        ),
        200,
    )
    at.close()
