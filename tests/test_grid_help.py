"""Help beside the grid: on the cell at hand, by search, by links; and sheets of one's own."""

from __future__ import annotations

import pytest
from chromium import becomes, eventually
from grid_books import HEADER, Books
from playwright.sync_api import expect

from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.topics import text_on

SHEETS = {
    "T": [
        HEADER,
        ["", "Red ball", "map", "CLAMP(redBall.distance; 0; 1)", "Distance", ""],
        ["", "Gaze", "sample", "500 ms", "Slow", ""],
        ["", "Slow", "filter", "slwo > 1", "Big", ""],
        ["", "Big", "subscribe", "", "Say", ""],
    ],
    "Devices": [["Stream", "Device", "Notes"], ["Gaze", "Head yaw", ""]],
    "Scene": [["Time (s)", "Thing", "Does", "Value", "Notes"], ["1", "Red ball", "appears", "at 1, 0.2, 0.4", ""]],
    "Read me": [["A title of mine"], [""], ["This sheet is for people only, and its texts are rather long at times."]],
}
HELP = {"C3": "sample (connector)", "D2": "CLAMP(value; low; high)", "B2": "Red ball (sensor)", "E5": "Say (actuator)",
        "B3": "Head yaw (sensor)", "A2": "Keys of the grid", "D4": "FORM"}  # fmt: skip


@pytest.mark.slow
def test_f1_explains_what_stands_in_the_cell_or_is_typed_and_gives_the_focus_back(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="T")
    grid.page.wait_for_selector("td[aria-invalid=true]")
    grid.page.wait_for_function("() => document.getElementById('panels').ariaBusy !== 'true'")
    panel = grid.page.locator("#help")
    for address, head in HELP.items():
        grid.go(address)
        grid.press("F1")
        panel.locator(".help-topic h3").first.wait_for()
        eventually(lambda: panel.locator(".help-topic h3").first.inner_text().startswith(head), address)
        grid.press("Escape")
        eventually(lambda: panel.is_hidden() and grid.here == address)
        becomes(lambda: grid.page.evaluate("document.activeElement.getAttribute('role')"), "gridcell")
    editor = grid.page.locator(".editor textarea")
    grid.go("D9")
    grid.page.keyboard.type('"a" & ABS(')
    grid.press("F1")
    expect(panel.locator("h3").first).to_have_text("ABS(value)")
    expect(editor).to_have_value('"a" & ABS(')
    panel.locator(".help-ways summary").click()
    panel.locator("a:text-is('Functions')").first.click()  # which is another piece of help
    expect(panel.locator("h3").first).not_to_have_text("ABS(value)")
    expect(editor).to_have_value('"a" & ABS(')
    grid.press("Escape")
    expect(panel).to_be_hidden()
    grid.page.keyboard.type("3")
    grid.page.click("[data-do=help]")
    expect(panel).to_be_visible()
    grid.press("Escape")
    grid.type(")")
    grid.expect("D9", '"a" & ABS(3)')
    becomes(lambda: grid.here, "D10")
    grid.page.keyboard.type("half")
    grid.press("F1")
    expect(panel).to_be_visible()
    grid.page.locator("[data-do=find]").focus()  # whatever else has the focus ends it
    grid.expect("D10", "half")
    expect(editor).to_have_count(0)
    grid.page.click("#help [data-help-close]")


HELPED = {
    "T": [
        HEADER,
        ["", "Red ball", "map", "isNear(redBall.distance; ABS(-1))", "Near", ""],
        ["", "Near", "map", "near + 1", "Count", ""],
        ["", "Count, Near", "map", "近い(near, count)", "Filter", ""],
        ["", "Filter", "map", "pow(filter; 2)", "Squared", ""],
        ["", "Filter", "map", "round(filter)", "Rounded", ""],
        ["", "Squared, Rounded", "map", "Is near", "Both", ""],
    ],
    "Helpers": [
        ["Name", "Inputs", "Formula", "Notes"],
        ["Is near", "distance, limit", "=CLAMP(distance; 0; limit)", "limit is in metres\n<b>see `SMOOTH`</b>"],
        ["近い", "a, b", "a + b", ""],
        ["Round", "x", "x * 10", ""],
    ],
}
ABOUT = {"D2": ["isNear(distance; limit)", "ABS(value)", "Red ball (sensor)"], "D4": ["近い(a; b)"], "D5": ["POWER("],
         "D6": ["round(x)"], "D7": ["isNear(distance; limit)"]}  # fmt: skip


def test_f1_on_a_call_of_a_helper_explains_the_helper_first(shelf: Books) -> None:
    grid = shelf.open(HELPED, sheet="T")
    grid.checked()
    panel = grid.page.locator("#help")
    heads = panel.locator(".help-topic > h3:first-child")
    for address, about in ABOUT.items():
        grid.go(address)
        grid.press("F1")
        for place, head in enumerate(about):
            expect(heads.nth(place), address).to_contain_text(head)
        expect(panel, address).not_to_contain_text("COUNT(")  # a stream of that name is no function
        expect(panel, address).not_to_contain_text("filter (connector)")
        grid.press("Escape")
    grid.go("D2")
    grid.press("F1")
    expect(panel.locator(".help-topic").first).to_contain_text("A helper of this workbook: Helpers!A2.")
    expect(panel.locator(".help-topic pre").first).to_have_text("CLAMP(distance; 0; limit)\n")
    expect(panel.locator("h4:text-is('Notes') ~ p")).to_have_text(["limit is in metres", "<b>see SMOOTH</b>"])
    grid.press("Escape")
    grid.page.click(".tabs span:text-is('Helpers')")
    grid.page.wait_for_selector("body[data-ready] table.of-helpers")
    grid.checked()
    grid.go("A3")
    grid.press("F1")
    expect(heads.first).to_have_text("近い(a; b)")
    grid.press("Escape")


def test_f1_on_a_stream_says_where_it_is_made_and_used(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="T")
    grid.checked()
    topic = grid.page.locator("#help .help-topic")
    grid.go("B4")
    grid.press("F1")
    expect(topic.first.locator("h3")).to_have_text("Slow")
    expect(topic.first).to_contain_text("A stream of this workbook.")
    expect(topic.first.locator("h4")).to_have_text(["Made by", "Used by", "For example"])
    expect(topic.first).to_contain_text("T!3")
    expect(topic.first).to_contain_text("T!4")
    assert grid.faults() == []
    grid.press("Escape")
    grid.go("B3")
    grid.press("F1")  # the device, then what this workbook does with it
    expect(topic.nth(1).locator("h3").first).to_have_text("Gaze")
    expect(topic.nth(1)).to_contain_text("The device “Head yaw”, as Devices!A2 says.")
    grid.press("Escape")
    grid.go("D2")
    grid.press("F2", "Home")
    for _ in range(7):
        grid.press("ArrowRight")
    grid.press("F1")  # the caret is in redBall
    expect(topic.first.locator("h3")).to_have_text("Red ball (sensor)")
    expect(topic.nth(1)).to_contain_text("The device “Red ball”, with its usual settings.")
    expect(topic.nth(2)).to_contain_text("CLAMP(value; low; high)")
    grid.press("Escape", "Escape", "Escape")


def test_help_on_a_stream_that_is_gone_shows_the_other_topics(shelf: Books) -> None:
    name = shelf.file(SHEETS).name
    answer = shelf.page.request.get(f"{shelf.url}/help?book={name}&topic=stream:T!gone&topic=stream:&topic=ABS")
    assert answer.status == 200 and "ABS(value)" in answer.text()
    assert shelf.page.request.get(f"{shelf.url}/help?book=none.xlsx&topic=stream:T!Slow").status == 404


def test_help_on_a_helper_that_is_gone_shows_the_other_topics(shelf: Books) -> None:
    name = shelf.file(HELPED).name
    answer = shelf.page.request.get(f"{shelf.url}/help?book={name}&topic=helper:gone&topic=ABS")
    assert answer.status == 200 and "ABS(value)" in answer.text()
    assert shelf.page.request.get(f"{shelf.url}/help?book=none.xlsx&topic=helper:gone").status == 404
    assert shelf.page.request.get(f"{shelf.url}/help?topic=ABS").status == 200


@pytest.mark.slow
def test_help_has_what_the_command_line_says_and_a_picture_and_a_sheet_of_ones_own_is_read(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="T")
    grid.go("C3")
    grid.press("F1")
    panel = grid.page.locator("#help .help-topic")
    panel.locator("svg.marble-picture").wait_for()
    for word in as_text(list(text_on("sample"))[1:3]).split():
        expect(panel).to_contain_text(word)
    eventually(lambda: grid.page.locator("#help svg .is-out .marble").count() >= 2)
    assert grid.faults() == []
    grid.page.click("#help .help-ways summary")
    grid.page.click("#help .help-ways a:text-is('Functions')")
    grid.page.click("#help a:text-is('CLAMP(value; low; high)')")
    grid.page.wait_for_selector("#help h3:has-text('CLAMP')")
    assert grid.page.url.endswith("/sheet/T")  # no other page
    grid.page.fill("#help input", "touch")
    grid.press("Enter")
    grid.page.wait_for_selector("#help .help-found a:text-is('Touch')")
    grid.page.fill("#help input", "nosuchthing")
    grid.page.wait_for_selector("#help:has-text('No results for “nosuchthing”')")
    eventually(lambda: "Try a single word" in grid.page.inner_text("#help-results"))
    grid.page.fill("#help input", "")
    grid.page.keyboard.type(
        "How do I make the robot say hello?"
    )  # searched for without Enter, and the field is left alone
    grid.page.wait_for_selector("#help:has-text('Try one of these') .help-found a:text-is('Say')")
    becomes(lambda: grid.page.input_value("#help input"), "How do I make the robot say hello?")
    becomes(lambda: grid.page.evaluate("document.activeElement.name"), "q")
    grid.page.click("#help [data-help-close]")
    eventually(lambda: grid.page.locator("#help").is_hidden())
    grid.page.click("[data-do=help]")
    grid.page.wait_for_selector("#help h3:has-text('sample')")
    grid.press("Escape")
    grid.page.click(".tabs span:text-is('Read me')")
    grid.page.wait_for_selector("body[data-ready] table.of-own")
    becomes(lambda: grid.page.locator("#diagram").count(), 0)  # it is that of another sheet
    eventually(lambda: grid.text("A1") == "A title of mine" and grid.text("A3").startswith("This sheet is for people"))
    before = grid.path.read_bytes()
    grid.go("A3")
    grid.page.keyboard.type("x")
    becomes(lambda: grid.page.locator(".editor").count(), 0)
    grid.press("Delete", "Control++", "Control+-")
    grid.status("You cannot change this sheet here.")
    eventually(lambda: grid.path.read_bytes() == before and grid.here == "A3")
    assert grid.faults() == []


def test_hostile_searches_are_texts(shelf: Books) -> None:
    page = shelf.page
    answer = page.request.get(f"{shelf.url}/help?q=<script>alert(1)</script>&topic=<img src=x>")
    assert answer.status == 200 and "<script" not in answer.text() and "<img" not in answer.text()
