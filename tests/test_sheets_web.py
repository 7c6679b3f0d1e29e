"""The tabs in a real browser: the life of a sheet by keyboard, and what others at the same workbook see of it."""

from __future__ import annotations

from typing import Any

import pytest
from chromium import becomes, some
from grid_books import Books, Shared
from playwright.sync_api import expect

from rrp_sheets.workbook import read

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
SHEETS = {
    "Tracking": [HEADER, ["", "Red ball", "map", "redBall.distance", "Distance", ""]],
    "Check": [
        ["Time (ms)", "Stream", "Send", "Expect"],
        ["0", "Red ball", "", ""],
        ["0", "Tracking!Distance", "", "any"],
    ],
    "Protocol": [["Field", "Value"], ["Run", "Tracking"]],
}


def tabs(page: Any) -> list[str]:
    return [str(text).strip() for text in page.locator("#tabs a").all_inner_texts()]


def opened(page: Any, sheet: str) -> None:
    """Wait until the page shows a sheet and hears of changes."""
    page.wait_for_url(f"**/sheet/{sheet.replace(' ', '%20')}")
    page.wait_for_selector("#listen[data-htmx-powered]", state="attached")


def choose(page: Any, name: str) -> None:
    page.locator("[role=menu]:not([hidden]) [role=menuitem]", has_text=name).press("Enter")


@pytest.mark.slow
def test_the_life_of_a_sheet_by_keyboard(shelf: Books) -> None:
    grid = shelf.open(SHEETS)
    page = grid.page
    page.focus("[data-tab=add]")
    grid.press("Enter")
    kinds = some(page.locator("#kinds [role=menuitem]:visible").all_inner_texts)
    assert [k.split("\n")[0].strip() for k in kinds] == [
        "Behaviour",
        "Devices",
        "Helpers",
        "Scene",
        "Gestures",
        "Test",
        "Risks",
        "Table",
    ]
    expect(page.locator("#kinds [role=menuitem]").first).to_be_focused()
    assert not grid.faults()
    grid.press("Escape")
    expect(page.locator("[data-tab=add]")).to_be_focused()
    grid.press("Enter", "Enter")
    becomes(lambda: page.locator("dialog[open] input").input_value(), "Behaviour 2")
    grid.write("check")
    expect(page.locator("dialog[open] [role=alert]")).to_contain_text("“Check” already")
    assert not grid.faults()
    page.locator("dialog[open] input").fill("Greeting <b>")
    grid.press("Enter")
    opened(page, "Greeting%20%3Cb%3E")
    grid.status("so it runs too")
    becomes(lambda: tabs(page), ["Tracking", "Greeting <b>", "Check", "Protocol"])
    becomes(lambda: grid.here, "B2")  # ready to type
    grid.write("Face", "Tab")
    grid.saved()
    page.focus("#tabs a[aria-current]")
    grid.press("F2")
    page.locator("dialog[open] input").fill("Say hello")
    grid.press("Enter")
    grid.status("is now called “Say hello”")
    opened(page, "Say hello")
    grid.write("map")  # the page goes on as it was
    grid.saved()
    found = read(grid.path).workbook
    assert found.protocol.text("Run") == "Tracking, Say hello"
    assert [(r.inputs_cell.text, r.connector.text) for r in found.behaviours[1].rows] == [("Face", "map")]
    page.focus("#tabs [data-tab=menu]")
    grid.press("Enter")
    choose(page, "Move left")
    expect(page.locator("#tabs a").first).to_have_text("Say hello")
    page.focus("#tabs a[aria-current]")
    grid.press("Delete")
    expect(page.locator("dialog[open]")).to_contain_text("It has 1 row. Press Ctrl+Z to undo.")
    expect(page.locator("dialog[open] .naming")).to_contain_text("Protocol!B2: Tracking, Say hello")
    assert not grid.faults()
    page.locator("dialog[open] button", has_text="Delete").press("Enter")
    opened(page, "Tracking")
    grid.status("“Say hello” is deleted")
    grid.press("Control+z")
    grid.status("“Say hello” is restored")
    expect(page.locator("#tabs a").first).to_have_text("Say hello")
    for told in ("“Say hello” is moved", "changed in Say hello", "“Say hello” is now called “Greeting <b>”"):
        grid.press("Control+z")
        grid.status(told)
    assert read(grid.path).workbook.protocol.text("Run") == "Tracking, Greeting <b>"


def test_a_table_of_ones_own_is_filled_in_at_once_and_a_sheet_that_is_gone_is_told_kindly(shelf: Books) -> None:
    grid = shelf.open(SHEETS)
    page = grid.page
    page.click("[data-tab=add]")
    choose(page, "Table")
    name, columns = page.locator("dialog[open] input").all()
    name.fill("Parts")
    columns.fill("Field, Value")
    columns.press("Enter")
    expect(page.locator("dialog[open] [role=alert]")).to_contain_text("make a sheet the protocol")
    columns.fill("Step, Say")
    columns.press("Enter")
    opened(page, "Parts")
    grid.go("A2")
    grid.write("1", "Tab")
    grid.write("Hello")
    grid.saved()
    page.reload()
    grid.expect("B2", "Hello")
    answer = page.goto(f"{shelf.url}/book/{grid.path.name}/sheet/Nothing")
    assert answer.status == 404
    page.click("text=Open the workbook")
    page.wait_for_selector("[role=grid]")


def test_others_are_told_and_lose_nothing(shelf: Books) -> None:
    path = shelf.file(SHEETS)
    aya, mika = (
        shelf.open(path=path, sheet="Tracking", name="Aya"),
        shelf.open(path=path, sheet="Tracking", name="Mika"),
    )
    mika.go("F2")
    mika.page.keyboard.type("half a")
    rename(aya, "Look")
    mika.status("Aya has renamed “Tracking” to “Look”.")
    mika.page.keyboard.type(" note")
    mika.press("Enter")
    mika.saved()
    assert read(path).workbook.behaviours[0].rows[0].notes == "half a note"
    assert mika.page.url.endswith("/sheet/Look") and read(path).workbook.tests[0].rows[1].stream.text == "Look!Distance"
    aya.expect("F2", "half a note")
    mika.go("F2")
    mika.press("F2")
    mika.page.keyboard.type(" again")
    aya.page.wait_for_selector("td.taken")
    delete(aya)
    expect(aya.page.locator("dialog[open] [role=alert]")).to_contain_text("Mika is editing a cell of it")
    aya.press("Escape")
    mika.press("Escape")
    aya.page.wait_for_selector("td.taken", state="detached")
    delete(aya)
    opened(aya.page, "Check")
    expect(mika.page.locator("#notice")).to_contain_text("Aya has deleted “Look”.")
    mika.go("F2")
    mika.page.keyboard.type("x")
    mika.status("cannot change this sheet here")
    aya.press("Control+z")
    mika.page.wait_for_selector("#notice:empty", state="attached")  # it is back, and the page with it
    mika.expect("F2", "half a note")


def rename(grid: Shared, name: str) -> None:
    grid.page.dblclick("#tabs a[aria-current]")
    grid.page.locator("dialog[open] input").fill(name)
    grid.press("Enter")
    grid.page.wait_for_selector(f"#tabs a[aria-current]:has-text({name!r})")


def delete(grid: Shared) -> None:
    grid.page.click("#tabs a[aria-current]", button="right")
    choose(grid.page, "Delete")
    grid.page.locator("dialog[open] button", has_text="Delete").click()


@pytest.mark.slow
def test_a_page_of_another_program_loads_again_when_nothing_is_typed(shelf: Books) -> None:
    page, path = shelf.page, shelf.file(SHEETS)

    def old(route: Any) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, body=answer.text().replace('data-program="', 'data-program="old'))

    page.route(f"**/book/{path.name}", old, times=1)
    page.goto(f"{shelf.url}/book/{path.name}", wait_until="commit")
    grid = Shared(page, path)
    page.wait_for_selector("#listen:not([data-program^=old])", state="attached")  # it has loaded again by itself
    page.wait_for_selector("#listen[data-htmx-powered]", state="attached")
    grid.go("F2")
    page.keyboard.type("being typed")
    send = "v => document.getElementById('listen').dispatchEvent(new CustomEvent('program', { detail: { data: JSON.stringify({ version: v }) } }))"
    page.evaluate(send, "another")
    grid.status("when you have finished typing")
    with page.expect_event("load"):  # the address is changed before, so that the cursor comes back
        grid.press("Enter")
    grid.expect("F2", "being typed")


@pytest.mark.slow
def test_why_a_run_cannot_start_leads_to_the_place(shelf: Books) -> None:
    wrong = {**SHEETS, "Check": [SHEETS["Check"][0], ["0", "Red ball", "", ""], ["0", "Nothing", "", "any"]]}
    grid = shelf.open(wrong)
    grid.page.set_viewport_size({"width": 1280, "height": 700})
    grid.page.click("#run-why button:has-text('Go to Check!B3')")
    opened(grid.page, "Check#*")
    becomes(lambda: grid.here, "B3")
    grid.page.set_viewport_size({"width": 1280, "height": 800})
