"""Suggestions of devices that the workbook does not have yet: choosing one adds it to the sheet Devices, as one undo step."""

from __future__ import annotations

import re

import openpyxl
import pytest
from chromium import becomes, eventually
from effort import Recorder
from grid_books import HEADER, Books, Shared
from playwright.sync_api import expect

from rrp_sheets.workbook import read
from rrp_sheets.workbook.template import empty_sheets

DEVICES = ["Stream", "Device", "Name", "Zone", "Notes"]
ROWS = [["", "Red ball", "map", "redBall.distance", "Hand distance", ""], ["", "", "subscribe", "", "", ""]]
SHEETS = {"T": [HEADER, *ROWS], "Devices": [DEVICES, ["Gaze", "Touch", "", "Head", ""]]}


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open(SHEETS, sheet="T")
    opened.checked()
    return opened


def devices(grid: Shared) -> list[tuple[str, str, dict[str, str]]]:
    """The devices of the workbook, as the file has them."""
    grid.saved()
    found = read(grid.path).workbook.devices
    return [
        (d.stream.text, d.device.text, {name: cell.text for name, cell in d.settings.items() if cell}) for d in found
    ]


def listed(grid: Shared) -> list[tuple[str, str]]:
    """The suggestions with what they do, and the groups that they are in."""
    return [
        (str(name), str(state))
        for name, state in grid.page.locator(".suggestions").evaluate(
            """list => [...list.querySelectorAll(".group-name, [role=option]")].map((one) => (one.matches(".group-name")
                ? [one.textContent, ""] : [one.querySelector(".name").textContent, one.querySelector(".adds")?.textContent ?? ""]))"""
        )
    ]


def take(grid: Shared, name: str) -> None:
    """Click on a suggestion."""
    grid.page.locator("[role=option] > .name").filter(has_text=re.compile(f"^{name}$")).click()


def test_suggestions_are_in_groups_and_say_what_they_do(grid: Shared) -> None:
    grid.go("B4")
    grid.page.keyboard.type("hand")
    becomes(lambda: listed(grid)[:8], [
        ("This workbook", ""), ("Hand distance", "row 2"), ("Sensors", ""), ("Left hand touch", "+ Devices"), ("Right hand touch", "+ Devices"),
        ("Gaze", "in use"), ("Touch", "+ Devices"), ("Joint position", "+ Devices"),
    ])  # fmt: skip
    expect(
        grid.page.get_by_role("group", name="Sensors").get_by_role("option").first.locator("mark").first
    ).to_have_text("hand")
    assert grid.faults() == []
    grid.press("Escape")
    grid.go("E3")
    grid.page.keyboard.type("wave")
    becomes(
        lambda: listed(grid)[:4],
        [("Gestures and postures", ""), ("Wave", "+ Devices"), ("Actuators", ""), ("Gesture", "+ Devices")],
    )
    grid.press("Escape")


def test_a_chosen_device_is_added_in_the_same_step(grid: Shared) -> None:
    grid.go("B4")
    grid.page.keyboard.type("left hand")
    grid.press("Tab")
    grid.expect("B4", "Left hand touch")
    grid.status("Added to Devices: Left hand touch. Press Ctrl+Z to undo.")
    becomes(
        lambda: devices(grid),
        [("Gaze", "Touch", {"zone": "Head"}), ("Left hand touch", "Touch", {"zone": "Left hand"})],
    )
    grid.go("E3")
    grid.page.keyboard.type("wav")
    grid.page.get_by_role("option", name="Wave").click()
    grid.press("Enter")
    becomes(lambda: devices(grid)[2:], [("Wave", "Gesture", {"name": "Wave"})])
    grid.go("A2")
    grid.press("Control+z")
    becomes(lambda: (grid.text("E3"), len(devices(grid))), ("", 2))
    grid.press("Control+z")
    becomes(lambda: (grid.text("B4"), len(devices(grid))), ("", 1))
    grid.press("Control+y")
    becomes(lambda: (grid.text("B4"), len(devices(grid))), ("Left hand touch", 2))


def test_what_is_typed_otherwise_or_given_up_adds_nothing(grid: Shared) -> None:
    grid.go("B4")
    grid.page.keyboard.type("left hand")
    grid.page.get_by_role("option", name="Left hand touch").click()
    grid.press("Escape", "Escape")
    grid.go("B5")
    grid.page.keyboard.type("left hand")
    grid.page.get_by_role("option", name="Left hand touch").click()
    grid.page.locator(".editor textarea").fill("Gaze")
    grid.press("Enter")
    grid.expect("B5", "Gaze")
    assert [name for name, *_ in devices(grid)] == ["Gaze"]


def test_a_workbook_without_devices_has_the_name_alone(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, *ROWS]})
    grid.checked()
    grid.go("B4")
    grid.page.keyboard.type("touc")
    becomes(lambda: listed(grid)[0], ("Touch", ""))
    grid.press("Tab")
    grid.expect("B4", "Touch")
    grid.saved()


def test_a_word_that_is_spelled_nearly_right_is_asked_for(grid: Shared) -> None:
    grid.go("B4")
    grid.page.keyboard.type("hend")
    expect(grid.page.locator(".signature p")).to_have_text("No name fits “hend”. Did you mean “hand”?")
    assert grid.faults() == []
    grid.page.get_by_role("button", name="hand", exact=True).click()
    becomes(lambda: grid.page.input_value(".editor textarea"), "hand")
    eventually(lambda: ("Left hand touch", "+ Devices") in listed(grid))
    grid.page.locator(".editor textarea").fill("zzzz")
    expect(grid.page.locator(".signature")).to_be_hidden()
    grid.press("Escape")


def test_an_input_method_takes_no_suggestion_by_itself(grid: Shared) -> None:
    grid.go("B4")
    grid.press("F2")
    session = grid.page.context.new_cdp_session(grid.page)
    session.send("Input.imeSetComposition", {"text": "red", "selectionStart": 3, "selectionEnd": 3})
    eventually(lambda: ("Red ball", "in use") in listed(grid))
    expect(grid.page.locator(".suggestions [aria-selected=true]")).to_have_count(0)
    session.send("Input.insertText", {"text": "red"})  # the composition ends
    becomes(lambda: grid.page.input_value(".editor textarea"), "red")
    expect(grid.page.locator(".suggestions [aria-selected=true] .name")).to_have_text("Red ball")
    grid.press("Escape", "Escape")


@pytest.mark.slow
def test_a_wave_at_a_touched_hand_takes_less_than_half_a_minute_by_mouse(shelf: Books) -> None:
    recorder = Recorder()
    page = shelf.open(empty_sheets(), sheet="Tracking", name="Effort").page
    recorder.watch(page.context)
    grid = shelf.open(empty_sheets(), sheet="Tracking", name="Effort")
    grid.checked()
    recorder.begin()
    for address, typed, name in (
        ("A2", "hand", "Left hand touch"), ("B2", "", "filter"), ("C2", "", "leftHandTouch"), ("B3", "", "subscribe"), ("D3", "wave", "Wave"),
    ):  # fmt: skip
        grid.cell(address).dblclick(position={"x": 8, "y": 8})
        grid.page.keyboard.type(typed)
        take(grid, name)
        if address == "C2":
            grid.page.keyboard.type(".")
            take(grid, "pressed")
    grid.cell("A4").click()
    effort = recorder.effort()
    grid.saved()
    row, last = read(grid.path).workbook.behaviours[0].rows
    assert (row.inputs_cell.text, row.formula.text, last.output.text) == (
        "Left hand touch",
        "leftHandTouch.pressed",
        "Wave",
    )
    expect(grid.page.locator(".problems")).to_contain_text("no problems")
    print(effort)
    assert effort.seconds <= 30, effort


def test_a_name_that_is_typed_in_full_is_added_too(grid: Shared) -> None:
    grid.go("E3")
    grid.press("F2")
    grid.page.keyboard.insert_text("arms up")  # nothing is chosen from the list
    grid.press("Enter")
    grid.expect("E3", "arms up")
    becomes(lambda: devices(grid)[1:], [("Arms up", "Gesture", {"name": "Arms up"})])
    grid.go("B4")
    grid.press("F2")
    grid.page.keyboard.insert_text("Head touch")
    grid.press("Enter")
    becomes(lambda: [stream for stream, *_ in devices(grid)], ["Gaze", "Arms up", "Head touch"])
    grid.go("E2")
    grid.press("F2", "Control+a")
    grid.page.keyboard.insert_text("Nod")  # of a row that calculates, it is a stream of its own
    grid.press("Enter")
    grid.expect("E2", "Nod")
    assert [stream for stream, *_ in devices(grid)] == ["Gaze", "Arms up", "Head touch"]


def paste(grid: Shared, text: str) -> None:
    grid.page.evaluate(
        """text => { const data = new DataTransfer(); data.setData("text/plain", text);
        document.activeElement.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true })); }""",
        text,
    )


def test_only_devices_that_were_added_are_told(shelf: Books) -> None:
    heads, lists = ["有効", "入力", "コネクター", "式", "出力"], ["ストリーム", "デバイス", "名前"]
    sheets = {
        "T": [heads, ["", "接触", "subscribe", "", "手を振る"]],
        "デバイス": [lists, ["身ぶり", "身ぶり", ""], ["接触", "接触", ""]],
    }
    grid = shelf.open(sheets, sheet="T")
    grid.checked()
    grid.go("B3")
    paste(grid, "接触\tsubscribe\t\t身ぶり\nボール\tsubscribe\t\t身ぶり\n")
    grid.status("Added to デバイス: ボール. Press Ctrl+Z to undo.")


def test_names_that_are_pasted_are_added_in_the_same_step(grid: Shared) -> None:
    grid.go("B4")
    paste(grid, "Left hand touch\tsubscribe\t\tWave\n")
    grid.expect("E4", "Wave")
    becomes(lambda: [stream for stream, *_ in devices(grid)], ["Gaze", "Left hand touch", "Wave"])
    grid.press("Control+z")
    becomes(lambda: [stream for stream, *_ in devices(grid)], ["Gaze"])
    grid.expect("E4", "")


def test_a_click_into_the_line_above_the_sheet_opens_the_cell(grid: Shared) -> None:
    grid.go("D2")
    grid.page.click("#formula-bar code")
    expect(grid.page.locator("td textarea, .edit textarea, textarea:focus").first).to_be_focused()
    grid.page.keyboard.type(" + 1")
    grid.press("Enter")
    grid.expect("D2", "redBall.distance + 1")


def columns(grid: Shared, sheet: str = "Devices") -> list[str]:
    """The headers of the sheet Devices, as the file has them."""
    grid.saved()
    return [str(cell.value) for cell in openpyxl.load_workbook(grid.path)[sheet][1] if cell.value]


def test_a_chosen_device_brings_the_column_of_the_setting_that_it_needs(grid: Shared) -> None:
    grid.go("B4")
    grid.page.keyboard.type("word")
    take(grid, "Word recognized")
    grid.press("Enter")
    grid.status("Added to Devices: Word recognized. Press Ctrl+Z to undo.")
    becomes(lambda: columns(grid), [*DEVICES, "Words"])
    assert devices(grid)[1:] == [("Word recognized", "Word recognized", {})]
    grid.go("A2")
    grid.press("Control+z")
    becomes(lambda: (grid.text("B4"), columns(grid), len(devices(grid))), ("", DEVICES, 1))


def test_a_fix_adds_the_row_and_the_column_and_leads_to_the_cell(shelf: Books) -> None:
    rows = [["", "Start", "subscribe", "", "Say parameter", ""]]
    grid = shelf.open({"T": [HEADER, *rows], "Devices": SHEETS["Devices"]}, sheet="T")
    grid.checked()
    grid.go("E2")
    grid.press("Control+.")
    grid.page.wait_for_url("**/sheet/Devices#*")
    becomes(lambda: grid.here, "F3")
    grid.write("Hello")
    becomes(lambda: devices(grid)[1:], [("Say parameter", "Say parameter", {"text": "Hello"})])


def test_a_fix_adds_the_column_of_a_setting_and_leads_to_its_cell(shelf: Books) -> None:
    rows = [["Heard", "Word recognized", ""], ["Gaze", "Touch", ""]]
    grid = shelf.open({"T": [HEADER, *ROWS], "Devices": [["Stream", "Device", "Notes"], *rows]}, sheet="Devices")
    grid.checked()
    grid.go("A2")
    grid.press("Control+.")
    becomes(lambda: grid.here, "D2")
    grid.write("yes, no")
    becomes(lambda: devices(grid)[0], ("Heard", "Word recognized", {"words": "yes, no"}))


@pytest.mark.parametrize(
    ("header", "headers", "added"),
    [
        (HEADER, ["Stream", "Device", "Notes"], "Every"),
        pytest.param(
            ["入力ストリーム", "コネクター", "式", "出力ストリーム"],
            ["ストリーム", "デバイス", "メモ"],
            "間隔",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_column_is_added_from_the_menu_of_a_header(
    shelf: Books, header: list[str], headers: list[str], added: str
) -> None:
    grid = shelf.open({"T": [header], "Devices": [headers, ["Tick", "Timer", ""]]}, sheet="Devices")
    grid.checked()
    grid.go("B2")
    grid.page.locator("thead th[data-letter=C]").click(button="right")
    grid.page.get_by_role("menuitem", name="Add a column …").click()
    offered = grid.page.locator("dialog .choice")
    expect(offered).to_have_count(1)
    expect(offered).to_contain_text(re.compile(f"{added}.*Tick.*Blank means 1 s", re.DOTALL))
    assert grid.faults() == []
    offered.click()
    becomes(lambda: columns(grid), [*headers, added])
    becomes(lambda: grid.here, "D2")  # once the page has loaded again
    grid.write("3 s")
    becomes(lambda: devices(grid), [("Tick", "Timer", {"every": "3 s"})])
    grid.go("A2")
    grid.press("Control+z", "Control+z")
    becomes(lambda: columns(grid), headers)


@pytest.mark.parametrize(
    ("sheet", "headers", "name", "offered", "added"),
    [
        ("Gestures", ["Name", "Time (s)", "HeadYaw", "Notes"], "HeadPitch", "HeadPitch.*-0.67 .* to 0.51", "HeadPitch"),
        ("T", HEADER, "Priority", "Priority.*the larger one wins", "Priority"),
        ("Words", ["Ask", "Answer"], "Where", "", "Where"),
    ],
)
def test_other_sheets_get_further_columns_too(
    shelf: Books, sheet: str, headers: list[str], name: str, offered: str, added: str
) -> None:
    reads = ["", "Start", "subscribe", "INDEX(Words[Ask]; 1)", "Print"]  # which makes that sheet a table
    grid = shelf.open({"T": [HEADER, reads], sheet: [headers, ["Greet", "1", "0.2"][: len(headers)]]}, sheet=sheet)
    grid.checked()
    grid.go("B2")
    grid.page.locator("thead th[data-letter=B]").click(button="right")
    grid.page.get_by_role("menuitem", name="Add a column …").click()
    if offered:
        choices = grid.page.locator("dialog .choice")
        choice = choices.filter(has=grid.page.get_by_text(name, exact=True))
        expect(choice).to_contain_text(re.compile(offered, re.DOTALL))
        expect(choices.filter(has=grid.page.get_by_text("HeadYaw", exact=True))).to_have_count(0)
        assert grid.faults() == []
        choice.click()
    else:
        grid.page.get_by_label("Name", exact=True).fill(name)
        grid.page.keyboard.press("Enter")
    becomes(lambda: columns(grid, sheet), [*headers, added])
    place = f"{chr(ord('A') + len(headers))}2"
    becomes(lambda: grid.here, place)  # once the page has loaded again
    grid.write("0.3")
    becomes(lambda: str(openpyxl.load_workbook(grid.path)[sheet][place].value), "0.3")
    grid.go("A2")
    grid.press("Control+z", "Control+z")
    becomes(lambda: columns(grid, sheet), headers)


@pytest.mark.parametrize("sheet", ["Devices", "T"])
def test_a_header_that_is_fixed_says_so_and_takes_no_text(grid: Shared, shelf: Books, sheet: str) -> None:
    grid = shelf.open(path=grid.path, sheet=sheet)
    grid.checked()
    grid.go("B2")
    held = {"Devices": "Touch", "T": "Red ball"}[sheet]
    header = grid.page.locator("thead th[data-letter=B]")
    header.locator(".title").dblclick()
    grid.status("choose “Add a column …”")
    becomes(lambda: grid.page.evaluate("String(getSelection())"), "")
    header.locator(".title").click()
    grid.page.keyboard.type("Hello")
    grid.page.keyboard.press("Delete")
    expect(grid.page.locator(".editor")).to_have_count(0)
    grid.expect("B2", held)
    grid.page.keyboard.press("ArrowDown")
    becomes(lambda: grid.here, "B2")
