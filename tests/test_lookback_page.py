"""The page that looks back at a run, in a real browser: what one sees at a time is what was then."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, eventually, some, until, violations
from playwright.sync_api import expect
from test_lookback import BOOK, events, go, rows_of_the_trace

from rrp_sheets.recording.metadata import EXACT, clock
from rrp_sheets.recording.timeline import value_text
from rrp_sheets.resources import bundled
from rrp_sheets.workbook.files import make_workbook

STORE = bundled("templates", "web", "static") / "records" / "lookback" / "store.js"
TWO = {
    **BOOK,
    "Other <b>": [
        BOOK["Look"][0],
        ["", "Yaw", "map", "yaw + 1", "More", ""],
        ["", "More", "subscribe", "", "Print", ""],
    ],
}
EDIT = {
    "t": 2.0, "happening": "edit", "text": "distance < 0.95 → distance < 2", "by": "Aya", "row": "Look!4",
    "detail": {"place": "Look!4", "was": "distance < 0.95", "now": "distance < 2"},
}  # fmt: skip
MARK = {"t": 2.5, "happening": "mark", "text": "<img src=x onerror=alert(1)>", "by": "Kai"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A real run with an edit and a mark besides, and one without what was recorded beside the trace."""
    made = tmp_path_factory.mktemp("books")
    run = go(make_workbook(TWO, made / "look.xlsx"), made / "runs" / "one")
    trace = run / "trace.jsonl"
    header, *rest, summary = trace.read_text(encoding="utf-8").splitlines()
    lines = sorted([*map(json.loads, rest), EDIT, MARK], key=lambda e: e["t"])
    trace.write_text("\n".join([header, *map(json.dumps, lines), summary]) + "\n", encoding="utf-8")
    shutil.copytree(run, made / "runs" / "old", ignore=shutil.ignore_patterns("poses*", "camera*"))
    return made


def look(page: Any, run: str, fragment: str = "") -> None:
    page.goto("about:blank")
    page.goto(f"/runs/{run}/lookback{fragment}")
    expect(page.locator("#play")).to_be_enabled()
    expect(page.locator(".ran-diagram svg").first).to_be_attached()


def choose(page: Any, view: str) -> None:
    """Choose what is shown below the rows."""
    page.get_by_role("tab", name=view, exact=True).click()


def shown(page: Any) -> dict[str, str]:
    """The value of each row of the first behaviour that is on."""
    script = "rows => rows.map((r) => [`Look!${r.cells[0].textContent}`, r.querySelector('.value').textContent])"
    return dict(page.locator("#sheet-0 tbody tr:not(.off)").evaluate_all(script))


def words(place: Path, t: float) -> dict[str, str]:
    """The same, computed from the trace alone."""
    units = {"Look!2": "m", "Look!4": "m", "Look!5": "m"}
    failed = {e["row"]: (e["t"], e["error"]) for e in events(place) if "error" in e and e["t"] <= t}
    found = {
        row: value_text(v, units.get(row, ""))
        for row, (_, v) in rows_of_the_trace(place, t).items()
        if not isinstance(v, dict)
    }
    return {**found, **{row: text for row, (_, text) in failed.items()}}


@pytest.mark.slow
def test_pieces_that_cannot_be_read_are_asked_for_again(page: Any) -> None:
    before = len(page.problems)
    script = STORE.read_text(encoding="utf-8")
    soon = script.replace("AGAIN_MS = 1500", "AGAIN_MS = 100")
    assert soon != script
    unreadable = {"piece": ["null", "["], "poses": ["null", "{}"]}
    asked = dict.fromkeys(unreadable, 0)

    def answer(route: Any, kind: str) -> None:
        route.fulfill(body=unreadable[kind][asked[kind] % 2], content_type="application/json")
        asked[kind] += 1

    page.goto("about:blank")
    page.route("**/lookback/store.js*", lambda route: route.fulfill(body=soon, content_type="text/javascript"))
    page.route("**/piece/0.json", lambda route: answer(route, "piece"))
    page.route("**/poses/0.json", lambda route: answer(route, "poses"))
    page.goto("/runs/one/lookback")
    until(page, lambda: min(asked.values()) > 1)
    expect(page.locator("#player")).to_have_attribute("aria-busy", "")
    page.unroute("**/piece/0.json")
    page.unroute("**/poses/0.json")
    expect(page.locator("#player")).not_to_have_attribute("aria-busy", "")
    page.get_by_label("Time of the run").press("End")
    eventually(lambda: "m" in shown(page).get("Look!2", ""))
    page.unroute("**/lookback/store.js*")
    assert page.problems[before:] == []


@pytest.mark.slow
def test_values_by_keyboard_at_times_are_those_of_the_trace(page: Any, folder: Path) -> None:
    look(page, "one", "#t=1.2")
    expect(page.locator("#now")).to_have_text("0:01.2")
    slider = page.get_by_label("Time of the run")
    slider.focus()
    for key, t in (
        ("ArrowRight", 1.3),
        ("ArrowLeft", 1.2),
        ("Home", 0.0),
        ("PageUp", 3.6),
        ("End", 3.6),
        ("PageDown", 0.0),
        ("ArrowUp", 0.1),
    ):
        page.keyboard.press(key)
        expect(page.locator("#now")).to_have_text(f"0:{t:04.1f}")
        mine, theirs = shown(page), words(folder / "runs" / "one", t)
        assert {row: text for row, text in mine.items() if text != "none yet" and row != "Look!8"} == {
            row: text for row, text in theirs.items() if row in mine
        }, t
    becomes(lambda: slider.get_attribute("aria-valuetext"), "0:00.1 of 0:03.6")
    expect(page).to_have_url(re.compile("#t=0.1$"))


@pytest.mark.slow
def test_it_plays_and_stops_with_space_and_jumps_from_moment_to_moment(page: Any, folder: Path) -> None:
    look(page, "one")
    page.get_by_label("Speed").select_option("4")
    page.locator("#time").focus()
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_text("Pause")
    expect(page.locator("#now")).to_have_text("0:03.6")
    expect(page.locator("#play")).to_have_text("Play")
    first = min(e["t"] for e in events(folder / "runs" / "one") if "error" in e)
    page.locator("#time").press("Home")
    page.keyboard.press(".")
    expect(page.locator("#now")).to_have_text(f"0:{int(first * 10 + 0.5) / 10:04.1f}")
    for time in (clock(first, EXACT), "0:02.50"):
        expect(page.locator("#moments time").get_by_text(time, exact=True).first).to_be_attached()
    page.get_by_role("button", name="Mark <img src=x onerror=alert(1)> by Kai").click()
    expect(page.locator("#now")).to_have_text("0:02.5")
    expect(page.locator("#moments [aria-current]")).to_contain_text("onerror")
    eventually(lambda: page.locator("#moments img, .ticks img").count() == 0 and page.locator(".tick").count() >= 3)
    page.keyboard.press(",")
    expect(page.locator("#now")).to_have_text("0:02.0")
    assert page.problems == []


@pytest.mark.slow
def test_a_time_is_rounded_alike_by_the_server_and_in_the_browser(page: Any) -> None:
    look(page, "one")
    times = [0, 0.04999, 1.45, 49.433, 49.467, 59.949, 59.96, 59.996, 83.5, 3599.97, 3723, *(n / 30 for n in range(60))]
    script = """async (times) => {
        const main = document.querySelector("script[src*='lookback/main.js']").src;
        const { clock, EXACT } = await import(new URL("../../run/time.js", main));
        return times.map((t) => [clock(t), clock(t, EXACT)]);
    }"""
    becomes(lambda: page.evaluate(script, times), [[clock(t), clock(t, EXACT)] for t in times])
    assert clock(49.433) != clock(49.467) and clock(49.467) == "0:49.5"


@pytest.mark.slow
def test_edits_are_in_place_the_diagram_is_lit_and_what_the_camera_saw_is_there(page: Any, folder: Path) -> None:
    look(page, "one", "#t=2.4")
    formula = page.locator("#r0-4 .formula")
    expect(formula).to_have_text("distance < 2")
    becomes(lambda: formula.get_attribute("data-edited"), "since 0:02.0, was distance < 0.95")
    choose(page, "Diagram")
    expect(page.locator("#diagram-0 svg [data-row='2'].lit")).to_be_visible()
    expect(page.locator("#diagram-0 svg [data-row='3'].failed")).to_be_visible()
    expect(page.locator("#eye img")).to_be_visible()
    becomes(lambda: page.locator("#eye img").evaluate("e => e.decode().then(() => e.naturalWidth)"), 320)
    expect(page.locator("#eye rect.seen")).to_have_count(1)
    expect(page.locator("#robot-facts")).to_contain_text("Red ball")
    expect(page.locator("#said")).to_contain_text("There you are")
    page.keyboard.press("Control+2")
    expect(page.locator("#curves canvas").first).to_be_visible()
    page.locator("#time").press("Home")
    expect(formula).to_have_text("distance < 0.95")
    expect(page.locator("#said")).to_have_text(re.compile("The robot hasn’t spoken yet"))
    expect(page.locator("#diagram-0 svg .row.lit")).to_have_count(1)  # the joint's sensor gives a value at once
    page.get_by_role("tab", name="Other <b>").click()
    page.keyboard.press("Control+3")
    expect(page.locator("#diagram-1 svg [data-row='2'].lit")).to_be_visible()
    page.locator("#diagram-1 [data-row='3'][role=button]").click()
    becomes(lambda: page.evaluate("document.activeElement.textContent"), "3", "a box of the diagram leads to its row")
    assert violations(page) == []
    assert page.problems == []


@pytest.mark.slow
def test_a_run_that_was_recorded_before_has_rows_and_diagram_and_says_what_is_missing(page: Any) -> None:
    look(page, "old", "#t=2.4")
    expect(
        page.get_by_text("This recording does not have the robot’s movements, so the robot cannot be shown.")
    ).to_be_visible()
    expect(page.get_by_text("No pictures of the camera were kept in this run.")).to_be_visible()
    assert shown(page)["Look!2"].endswith(" m")
    expect(page.locator("#said")).to_contain_text("There you are")


def test_the_record_leads_there_and_what_is_not_there_is_told(page: Any, folder: Path) -> None:
    page.goto("/runs/one")
    page.get_by_role("link", name="look back at 0:02.50").click()
    expect(page.locator("#now")).to_have_text("0:02.5")
    (folder / "runs" / "bad").mkdir(exist_ok=True)
    (folder / "runs" / "bad" / "trace.jsonl").write_text('{"type":"header","streams":[]}\nbroken\n')
    page.goto("/runs/bad/lookback")
    expect(page.locator("#trouble")).to_contain_text("is not the recording of a run")
    for address in (
        "none/lookback",
        "one/lookback/piece/99.json",
        "one/lookback/picture/99.jpg",
        "one/lookback/other/1.json",
    ):
        assert page.request.get(f"/runs/{address}").status in (404, 422), address


def test_the_robot_is_as_large_as_during_the_run_and_a_phone_shows_what_is_needed(page: Any) -> None:
    page.set_viewport_size({"width": 1400, "height": 900})
    look(page, "one")
    share = "() => document.getElementById('pictures').getBoundingClientRect().width / innerWidth"
    eventually(lambda: page.evaluate(share) >= 0.43)
    room = some(page.locator("#pictures").bounding_box)
    choose(page, "Plots")
    assert some(page.locator("#pictures").bounding_box) == room, "what is below the rows does not move it"
    page.set_viewport_size({"width": 400, "height": 800})
    column = page.get_by_role("columnheader", name="Input streams")
    expect(column).to_be_hidden()
    expect(page.get_by_role("columnheader", name="Output stream")).to_be_visible()
    page.get_by_role("button", name="All columns").click()
    expect(column).to_be_visible()
    eventually(lambda: page.evaluate("document.documentElement.scrollWidth") <= 400)
    page.set_viewport_size({"width": 1280, "height": 800})
    choose(page, "Moments")
