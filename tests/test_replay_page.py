"""A live run of the grid, with what people did to it, is replayed on its page: the same, and with another workbook."""

from __future__ import annotations

import re
import shutil
import time
from pathlib import Path
from typing import Any

import panel
import pytest
from chromium import GridPage, until, violations
from panel import LIVE, ended, row, run
from playwright.sync_api import expect
from recorded import END, EVENT, HEADER, HOSTILE, write_run

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.replay.apart import Stopped, replay_apart
from rrp_sheets.web.records.replays import Replays
from rrp_sheets.workbook.maker import make_workbook

BOOKS = {"session.xlsx": panel.SESSION}
OTHER = {
    **panel.SESSION,
    "Tracking": [*panel.TRACKING[:2], ["", "Distance", "filter", "distance < 9", "Near", ""], *panel.TRACKING[3:]],
}


def ask(page: Any, action: str, **what: Any) -> None:
    answer = page.evaluate(
        """([action, what]) => fetch(`/book/session.xlsx/run/${action}`, { method: "POST", body: JSON.stringify(what),
          headers: { "X-RRP": "grid", "Content-Type": "application/json" } }).then((r) => r.status)""", [action, what])  # fmt: skip
    assert answer == 200, (action, answer)


@pytest.fixture(scope="module")
def ran(browser: Any, url: str, folder: Path) -> Path:
    """The folder of a run that was edited, paused, switched, sent to, and sped up while it went on."""
    at = GridPage(browser, url, "session.xlsx", sheet="Tracking", name="Aya")
    page = at.page
    run(page)
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^\d"), timeout=15_000)
    at.go("D2")
    at.type("redBall.distance + 5")
    expect(row(page, 2).locator(LIVE)).to_have_text(re.compile(r"^5\.\d+ m$"), timeout=15_000)
    ask(page, "pause")
    ask(page, "send", stream="Red ball", text="distance=0.1")
    ask(page, "resume")
    ask(page, "switch", behaviour="Cheer", on=False)
    ask(page, "switch", behaviour="Cheer", on=True)
    ask(page, "press", label="Encourage")
    ask(page, "mark", note="that was all")
    expect(page.locator("#log")).to_contain_text("that was all", timeout=15_000)
    page.click("[data-run=stop]")
    ended(page)
    at.close()
    [place] = (folder / "runs").glob("*-session*")
    return place


@pytest.fixture(scope="module")
def page(browser: Any, url: str, ran: Path, folder: Path) -> Any:
    make_workbook(OTHER, folder / "other.xlsx")
    at = GridPage(browser, url, "session.xlsx")
    return at.page


def test_a_live_run_with_all_that_people_did_comes_out_the_same(ran: Path) -> None:
    text = (ran / "trace.jsonl").read_text()
    for kind in ("edit", "pause", "resume", "switch", "press"):
        assert f'"happening":"{kind}"' in text, kind
    assert '"stimulated":true' in text
    found = api.replay(ran)
    assert found.same, found.differences[:5]
    assert found.compared > 20


def test_its_page_says_so_and_what_another_workbook_would_do(page: Any, url: str, ran: Path) -> None:
    page.goto(f"{url}/runs/{ran.name}")
    page.get_by_role("link", name="Replay", exact=True).click()
    verdict = page.locator(".replay-verdict")
    expect(verdict).to_contain_text("The same: ", timeout=30_000)
    assert violations(page) == []
    page.get_by_label("Replay this run with").select_option(label="other.xlsx")
    page.get_by_role("button", name="Replay").click()
    expect(verdict).to_contain_text("Different: with other.xlsx, ", timeout=30_000)
    assert violations(page) == []
    expect(page.locator(".marbles svg").first).to_be_visible()
    link = page.locator(".replay-rows a").first
    assert re.search(r"/book/other\.xlsx/sheet/Tracking#\w+", link.get_attribute("href"))
    link.click()
    expect(page.locator("#formula-bar b")).to_have_text(re.compile(r"^[A-Z]\d"))


def test_what_cannot_be_replayed_says_why(page: Any, url: str, folder: Path) -> None:
    write_run(folder, "no-book", HEADER, EVENT, END)
    write_run(
        folder, "evil", {**HEADER, "name": HOSTILE, "streams": [{"stream": HOSTILE, "kind": HOSTILE}]}, EVENT, END
    )
    page.goto(f"{url}/runs/evil/replay")
    expect(page.locator("#replayed .is-error")).to_contain_text("The workbook that ran is not beside", timeout=30_000)
    for ref in ("book/../x.xlsx", "run/none", "version/1/none.xlsx", "nonsense", "book/<script>"):
        until(
            page, lambda ref=ref: "is-error" in page.request.get(f"{url}/runs/no-book/replay/result?with={ref}").text()
        )
    assert page.request.get(f"{url}/runs/none/replay").status == 404


def test_a_replay_that_nobody_waits_for_or_that_takes_too_long_is_ended(ran: Path) -> None:
    with pytest.raises(Stopped):
        replay_apart(ran, None, lambda part: None, lambda: True)
    with pytest.raises(SheetsError, match="does not come to an end"):
        replay_apart(ran, None, lambda part: None, within=0.0)


def test_a_replay_is_done_once_and_told_to_all(ran: Path, tmp_path: Path) -> None:
    place = shutil.copytree(ran, tmp_path / "run")
    replays = Replays()
    job = replays.job("one", place, lambda stack: None)
    assert replays.job("one", place, lambda stack: None) is job
    deadline = time.monotonic() + 60
    while not job.over and time.monotonic() < deadline:
        job.done.wait(1)
        replays.job("one", place, lambda stack: None)
    assert job.account is not None and job.account["same"]
