"""The screens of runs, versions and the shelf in a real browser: what a click does, and that everyone can use them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, eventually, violations
from playwright.sync_api import expect
from recorded import END, EVENT, HEADER, write_run

from rrp_sheets import api
from rrp_sheets.resources import bundled

NINE = (
    "complex-tracking", "complex-tracking-fixed", "debugging-exercise", "distance-to-brightness", "greeter",
    "reflect-ball-colour", "say-ball-colour", "say-ball-colour-ja", "say-ball-colour-merge",
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine workbooks, and the record of a run of one."""
    made = tmp_path_factory.mktemp("books")
    for name in NINE:
        shutil.copy(bundled("workbooks", f"{name}.xlsx"), made)
    write_run(made, "1-recorded", HEADER | {"name": "say-ball-colour-ja.xlsx", "mode": "pilot"}, EVENT, END)
    return made


@pytest.fixture
def real(folder: Path) -> None:
    """A real run, of today, whose record has a mark besides."""
    ended = api.run_apart(folder / "say-ball-colour-ja.xlsx", api.RunSettings(seconds=4.0, fast=True, mode="pilot"))
    assert ended.result is not None
    trace = ended.result.folder / "trace.jsonl"
    lines = trace.read_text(encoding="utf-8").splitlines()
    lines.insert(-1, json.dumps({"t": 3.5, "happening": "mark", "text": "Kai laughs", "by": "Aya"}))
    trace.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.slow
@pytest.mark.usefixtures("real")
def test_a_run_is_looked_into(page: Any) -> None:
    page.goto("/runs")
    assert violations(page) == []
    page.get_by_role("link", name="today").click()
    expect(page.locator("body")).to_have_attribute("data-mode", "pilot")
    expect(page.locator("#marbles svg").first).to_be_visible()
    expect(page.locator("#curves canvas").first).to_be_visible()
    eventually(lambda: page.locator(".strip img").evaluate("e => e.naturalWidth") > 500)
    eventually(lambda: page.locator(".diagram img").evaluate("e => e.naturalWidth") > 100)
    loaded = (
        "e => new Promise((done) => { e.onloadedmetadata = () => done(e.duration); e.preload = 'metadata'; e.load(); })"
    )
    eventually(lambda: page.locator("audio").first.evaluate(loaded) > 0.3)
    assert violations(page) == []
    page.locator(".log li", has_text="Kai laughs").get_by_role("button").click()
    expect(page.locator("#marbles [name=from]")).to_have_value("1")
    page.get_by_text("Rows", exact=True).click()
    page.get_by_label("4 map").check()
    page.locator("#marbles").get_by_role("button", name="Show").click()
    expect(page.get_by_label("4 map")).to_be_hidden()  # the list would cover the marbles
    lanes = page.locator("#marbles .lane")
    expect(lanes).to_have_count(3)
    becomes(lambda: [lane.get_attribute("data-stream") for lane in lanes.all()], ["By hand", "今のボール", "ことば"])
    assert page.problems == []


@pytest.mark.slow
def test_versions_by_hand(page: Any, folder: Path) -> None:
    page.evaluate("localStorage.setItem('name', 'Aya')")
    page.goto("/book/greeter.xlsx/versions")
    assert violations(page) == []
    page.get_by_label("Name of the new version").fill("before the pilot")
    page.keyboard.press("Enter")
    expect(page.get_by_role("status").first).to_have_text("Saved as “before the pilot”.")
    expect(page.locator("td[data-head=By]")).to_have_text("Aya")
    before = (folder / "greeter.xlsx").read_bytes()
    api.set_cell(folder / "greeter.xlsx", "Protocol!B2", "Another title")
    page.reload()
    page.locator("summary", has_text="Restore").click()
    assert violations(page) == []
    page.get_by_role("button", name="Restore “before the pilot”").click()
    expect(page.get_by_role("status").first).to_contain_text("“before the pilot” is restored.")
    assert (folder / "greeter.xlsx").read_bytes() == before
    page.get_by_role("link", name="Compare “Before before the pilot came back” with now").click()
    expect(page.locator(".comparison .verdict")).to_contain_text("Same behaviour.")
    assert violations(page) == []
    page.get_by_role("button", name="Swap").click()
    expect(page.get_by_label("After")).to_contain_text("came back")
    assert page.problems == []


def test_the_shelf_searches_sorts_takes_files_and_gives_back(page: Any, folder: Path) -> None:
    page.goto("/")
    assert violations(page) == []
    expect(page.locator(".about-template")).to_contain_text("what to type where")
    page.get_by_label("from").select_option("simple-tracking")
    expect(page.locator(".about-template")).to_contain_text("looks after a ball")
    page.get_by_label("Search the workbooks").fill("remember face")
    expect(page.locator(".card:visible h3")).to_have_text(["Greeter"])
    page.get_by_role("link", name="last run").click()
    first = page.locator(".card").first
    expect(first.locator("h3")).to_have_text("ボールの色を言う")
    expect(first.locator(".last-run")).to_contain_text("ended as planned")
    data = list(bundled("workbooks", "simple-tracking.xlsx").read_bytes())
    script = """(data) => {
      const files = new DataTransfer();
      files.items.add(new File([new Uint8Array(data)], "dropped.xlsx"));
      for (const kind of ["dragover", "drop"])
        document.querySelector("main").dispatchEvent(new DragEvent(kind, {bubbles: true, cancelable: true, dataTransfer: files}));
    }"""
    page.evaluate(script, data)
    expect(page.get_by_role("link", name="Open dropped.xlsx")).to_be_visible()
    page.get_by_label("More about dropped.xlsx").click()
    page.locator(".card", has_text="dropped.xlsx").get_by_role("button", name="Archive").click()
    expect(page.get_by_role("status").first).to_contain_text("is now in the folder archive")
    page.get_by_text("Archive (1)").click()
    assert violations(page) == []
    page.get_by_role("button", name="Restore").click()
    expect(page.get_by_role("status").first).to_contain_text("dropped.xlsx is restored.")
    assert (folder / "dropped.xlsx").is_file()
    page.locator("h3 a", has_text="Greeter").click()
    page.wait_for_url("**/book/greeter.xlsx**")
    for name in ("Runs", "Versions", "Print", "Edit"):
        page.get_by_role("navigation", name="Pages").get_by_role("link", name=name, exact=True).click()
        expect(page.get_by_role("heading", level=1)).to_contain_text("greeter.xlsx")
    assert page.problems == []
