"""A live run of the grid, with all that people did to it, comes out the same when it is replayed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import panel
import pytest
from chromium import GridPage
from panel import LIVE, ended, row, run
from playwright.sync_api import expect

from rrp_sheets import api

BOOKS = {"session.xlsx": panel.SESSION}
pytestmark = pytest.mark.soak  # the same acts, without browser and simulator, are in test_replay.py


def ask(page: Any, action: str, **what: Any) -> None:
    answer = page.evaluate(  # read once: the answer to what is sent
        """([action, what]) => fetch(`/book/session.xlsx/run/${action}`, { method: "POST", body: JSON.stringify(what),
          headers: { "X-RRP": "grid", "Content-Type": "application/json" } }).then((r) => r.status)""", [action, what])  # fmt: skip
    assert answer == 200, (action, answer)


@pytest.fixture(scope="module")
def ran(browser: Any, url: str, folder: Path) -> Path:
    """The folder of a run that was edited, paused, switched, sent to, and sped up while it went on."""
    at = GridPage(browser, url, "session.xlsx", sheet="Tracking", name="Aya")
    page = at.page
    run(page)
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^\d"))
    at.go("D2")
    at.type("redBall.distance + 5")
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"))
    ask(page, "pause")
    ask(page, "send", stream="Red ball", text="distance=0.1")
    ask(page, "resume")
    ask(page, "switch", behaviour="Cheer", on=False)
    ask(page, "switch", behaviour="Cheer", on=True)
    ask(page, "press", label="Encourage")
    ask(page, "mark", note="that was all")
    expect(page.locator("#log")).to_contain_text("that was all")
    page.click("[data-run=stop]")
    ended(page)
    at.close()
    [place] = (folder / "runs").glob("*-session*")
    return place


def test_a_live_run_with_all_that_people_did_comes_out_the_same(ran: Path) -> None:
    text = (ran / "trace.jsonl").read_text()
    for kind in ("edit", "pause", "resume", "switch", "press"):
        assert f'"happening":"{kind}"' in text, kind
    assert '"stimulated":true' in text
    found = api.replay(ran)
    assert found.same, found.differences[:5]
    assert found.compared > 20
