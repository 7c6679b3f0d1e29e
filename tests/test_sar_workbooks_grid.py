"""Every therapy workbook in the browser: from the shelf, run, its buttons pressed, its speech heard, stopped, looked at."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from chromium import becomes, let_in
from panel import ended, run, trace
from playwright.sync_api import expect
from test_sar_workbooks import checked
from test_workbooks import THERAPY

pytestmark = pytest.mark.soak


@pytest.mark.parametrize("name", THERAPY)
def test_a_session_with_every_button(browser, url: str, folder: Path, name: str) -> None:
    context = browser.new_context(viewport={"width": 1400, "height": 1000})
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    let_in(context, url)
    page.goto(url)
    page.evaluate("localStorage.setItem('name', 'Aya')")
    # from the shelf: a workbook of one's own, made from this one
    page.fill("form[hx-post*=new] [name=name]", f"my-{name}")
    page.select_option("form[hx-post*=new] [name=template]", name)
    page.click("form[hx-post*=new] button")
    page.wait_for_url("**/book/**")
    page.wait_for_selector("#listen[data-htmx-powered]", state="attached")
    becomes(lambda: page.locator(".badge.error").count(), 0)
    run(page, participant="P-01")
    labels = [b["label"] for b in buttons(name)]
    if labels:
        expect(page.locator("#press button")).to_have_count(len(labels))
    for place in range(len(labels)):
        page.locator("#press button").nth(place).click()
        expect(page.locator("#press button").nth(place).locator("small")).to_contain_text("pressed")
    speech = page.locator("#log li[data-kind=speech]").first
    expect(speech).to_be_visible()
    becomes(lambda: speech.locator("button").count(), 1)
    # a button ends what is being said, and its file with it: the newest one is whole
    newest = page.locator("#log li[data-kind=speech]").count()
    script = "n => fetch(`/run/sound/say-${n}.wav`).then(async r => [r.status, (await r.blob()).size])"
    sound = page.evaluate(script, f"{newest:03}")  # read once: the file is whole when its line is there
    assert sound[0] == 200 and sound[1] > 10_000
    speech.locator("button").click()
    pictures = os.environ.get("PICTURES")
    if pictures:
        page.wait_for_timeout(3000)
        page.screenshot(path=f"{pictures}/{name}.png")
    page.click("[data-run=stop]")
    assert ended(page).startswith("Stopped by Aya at ")
    lines = trace(folder, f"my-{name}")
    pressed = [e["text"] for e in lines if e.get("happening") == "press"]
    assert set(labels) <= set(pressed)
    assert [e for e in lines if e.get("happening") in ("error", "clamp")] == []
    # the record
    record = max((folder / "runs").glob(f"*-my-{name}*"), key=lambda p: p.stat().st_mtime)
    page.goto(f"{url}/runs/{record.name}")
    expect(page.locator("main")).to_contain_text("P-01")
    if pictures:
        page.screenshot(path=f"{pictures}/{name}-record.png", full_page=True)
    assert not errors
    context.close()


def buttons(name: str) -> list[dict[str, str]]:
    """The operator's buttons of a workbook."""
    streams = checked(name).graph.streams.values()
    used = [s for s in streams if s.device and s.device.type.name == "OperatorButton"]
    return [{"stream": s.name, "label": str(s.settings["label"] or s.name)} for s in used]
