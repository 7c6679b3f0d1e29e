"""The page of a replay: whether a run comes out the same, and what another workbook would have done."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from acting import Run, Script, wish
from chromium import PAGES, until
from panel import HEADER as COLUMNS
from play import rows
from playwright.sync_api import expect
from recorded import END, EVENT, HEADER, HOSTILE, write_run

from rrp_sheets.errors import SheetsError
from rrp_sheets.replay.replaying import Stopped, replay_apart
from rrp_sheets.web.replay_jobs import Replays

BOOK = [["", "Head yaw", "filter", "headYaw > 3", "Far", ""], ["", "Far", "subscribe", "", "Say", ""]]
OTHER = [["", "Head yaw", "filter", "headYaw > 5", "Far", ""], BOOK[1]]
BOOKS = {"session.xlsx": {"T": [COLUMNS, *BOOK]}, "other.xlsx": {"T": [COLUMNS, *OTHER]}}


@pytest.fixture(scope="module")
def ran(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run in which somebody sent a value."""
    script = Script({10: [wish("send", stream="Head yaw", text="4.5")]})
    table = rows("\n".join(f"| {' | '.join(row[1:5])} |" for row in BOOK))
    made = Run(tmp_path_factory.mktemp("made"), table, script, [(n * 100, "headyaw", n) for n in range(9)])
    return Path(shutil.copytree(made.result.folder, folder / "runs" / "2026-01-02-120000-session"))


@pytest.fixture(scope="module")
def page(browser: Any, url: str, ran: Path) -> Iterator[Any]:
    opened = PAGES.take(browser, url)
    yield opened
    PAGES.put_back(opened)


def test_its_page_says_so_and_what_another_workbook_would_do(page: Any, url: str, ran: Path) -> None:
    page.goto(f"{url}/runs/{ran.name}")
    page.get_by_role("link", name="Replay", exact=True).click()
    verdict = page.locator(".replay-verdict")
    expect(verdict).to_contain_text("The same: ")
    page.get_by_label("Replay this run with").select_option(label="other.xlsx")
    page.get_by_role("button", name="Replay").click()
    expect(verdict).to_contain_text("Different: with other.xlsx, ")
    expect(page.locator(".marbles svg").first).to_be_visible()
    link = str(page.locator(".replay-rows a").first.get_attribute("href"))
    address, _, row_id = link.partition("#")
    assert address == "/book/other.xlsx/sheet/T"
    assert f'id="{row_id}"' in page.request.get(f"{url}{address}").text()


def test_what_cannot_be_replayed_says_why(page: Any, url: str, folder: Path) -> None:
    write_run(folder, "no-book", HEADER, EVENT, END)
    write_run(
        folder, "evil", {**HEADER, "name": HOSTILE, "streams": [{"stream": HOSTILE, "kind": HOSTILE}]}, EVENT, END
    )
    page.goto(f"{url}/runs/evil/replay")
    expect(page.locator("#replayed .is-error")).to_contain_text("The workbook of the run is not next to")
    for ref in ("book/../x.xlsx", "run/none", "version/1/none.xlsx", "nonsense", "book/<script>"):
        until(
            page, lambda ref=ref: "is-error" in page.request.get(f"{url}/runs/no-book/replay/result?with={ref}").text()
        )
    assert page.request.get(f"{url}/runs/none/replay").status == 404


def test_a_replay_that_nobody_waits_for_or_that_takes_too_long_is_ended(ran: Path) -> None:
    with pytest.raises(Stopped):
        replay_apart(ran, None, "en", lambda part: None, lambda: True)
    with pytest.raises(SheetsError, match="did not end"):
        replay_apart(ran, None, "en", lambda part: None, within=0.0)


def test_a_replay_is_done_once_and_told_to_all(ran: Path, tmp_path: Path) -> None:
    place = shutil.copytree(ran, tmp_path / "run")
    replays = Replays()
    job = replays.job("one", place, lambda stack: None, "en")
    assert replays.job("one", place, lambda stack: None, "en") is job
    deadline = time.monotonic() + 300
    while not job.over and time.monotonic() < deadline:
        job.done.wait(1)
        replays.job("one", place, lambda stack: None, "en")
    assert job.account is not None and job.account["same"]


def test_a_replay_is_given_up_when_the_services_are_closed(ran: Path) -> None:
    replays = Replays()
    replays.close()
    job = replays.job("one", ran, lambda stack: None, "en")
    assert job.done.wait(60) and job.given_up
