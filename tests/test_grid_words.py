"""Suggestions in every kind of cell of every sheet."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, eventually, requests_of, until
from grid_books import HEADER, TRACKING, Books, Shared
from playwright.sync_api import expect

SHEETS = {
    "T": [
        HEADER,
        ["", "Red ball", "map", "redBall.distance", "Distance", ""],
        ["", "Distance, Gaze", "combineLatest", "distance + gaze", "Sum", ""],
        ["", "Sum", "subscribe", "", "Say", ""],
        ["", "Say done", "sample", "1 s", "", ""],
    ],
    "Devices": [
        ["Stream", "Device", "Joint", "Label", "Rate", "Notes"], ["Gaze", "Joint position", "", "", "", ""], ["Go", "Operator button", "", "", "", ""],
    ],
    "Helpers": [["Name", "Inputs", "Formula", "Notes"], ["near", "how far", "", ""], ["limit", "", "0.5", ""]],
    "Scene": [["Time (s)", "Thing", "Does", "Value", "Notes"], ["1", "Red ball", "appears", "", ""], ["2", "Child", "enters", "", ""], ["3", "Operator", "presses", "", ""]],
    "Try": [["Time (ms)", "Stream", "Send", "Expect", "Notes"], ["0", "Red ball", "", "", ""], ["1", "", "", "", ""]],
    "Protocol": [["Field", "Value"], ["Engine", ""], ["Run", ""], ["", ""]],
    "Colours": [["Word", "Colour"], ["yes", "green"], ["no", "red"]],
    "Uses": [HEADER, ["", "Red ball", "map", 'LOOKUP("yes"; colours; "Colour")', "C", ""]],
}  # fmt: skip

IN_JAPANESE = {
    "追う": [["入力ストリーム", "コネクター", "式", "出力ストリーム"], ["Red ball", "subscribe", "", "Head tracker"]],
    "シーン": [["時間（秒）", "対象", "動作", "値", "メモ"], ["1", "赤いボール2", "現れる", "", ""], ["2", "子ども", "入ってくる", "", ""],
               ["3", "操作者", "ボタンを押す", "", ""], ["4", "", "", "", ""]],
    "試し": [["時間（ミリ秒）", "ストリーム", "送信", "期待", "メモ"], ["0", "Red ball", "", "", ""]],
    "プロトコル": [["項目", "内容"], ["エンジン", ""]],
}  # fmt: skip


@pytest.fixture(scope="module")
def book(shelf: Books) -> Path:
    """A workbook whose cells nobody changes."""
    return shelf.file(SHEETS)


@pytest.fixture
def at(shelf: Books, book: Path):
    found: dict[str, Shared] = {}
    cursor: list[str] = []

    def offered(sheet: str, address: str, typed: str = "") -> list[str]:
        if sheet not in found:
            found.clear()
            cursor.clear()
            found[sheet] = shelf.open(path=book, sheet=sheet)
            found[sheet].checked()
        if cursor == [address]:
            return found[sheet].offered_here(typed)
        cursor[:] = [address]
        return found[sheet].offered(address, typed)

    return offered


@pytest.mark.slow
def test_behaviours(at) -> None:
    assert {"Gaze", "Red ball", "Say done", "Distance", "Sum"} <= {
        *at("T", "B6", " "),
        *at("T", "B6", "g"),
        *at("T", "B6", "sa"),
        *at("T", "B6", "red"),
        *at("T", "B6", "su"),
        *at("T", "B6", "dis"),
    }
    assert at("T", "B6", "Distance, ga")[0] == "Gaze"
    assert at("T", "C6", "co")[0] == "combineLatest" and "once" in at("T", "C6", "on")
    assert {"distance", "gaze", "near(how far)", "limit"} <= {
        *at("T", "D3", "dis"),
        *at("T", "D3", "gaz"),
        *at("T", "D3", "nea"),
        *at("T", "D3", "lim"),
    }
    assert {"distance", "x"} <= {*at("T", "D2", "redBall.")}
    assert at("T", "D2", "cla")[0] == "CLAMP(value; low; high)"
    assert "500 ms" in at("T", "D5", " ")
    assert at("T", "E4", "head t")[0] == "Head tracker" and "Say" in at("T", "E4", "sa")
    assert at("T", "E2", "new name") == []
    assert at("T", "E2", " ") == ["Distance"], "named as the field"
    assert at("T", "E3", " ") == []
    assert "Say" in at("T", "E5", "sa"), "which a fix sends to by a subscribe row"
    assert {"redBall.distance", "redBall.x"} <= {*at("T", "D2", " ")}
    assert at("T", "A2", "f") == ["FALSE"]
    assert at("T", "D2", '"redBall.') == []  # within a text


OTHER_WORDS = [
    ("B2", "speech", "Word recognized"), ("B2", "child", "Face"), ("E4", "nod", "Gesture"), ("E4", "speak", "Say"),
    ("E4", "raise", "Set joint position"), ("E4", "look", "Head tracker"), ("D2", '"sit', "Sit"),
]  # fmt: skip


@pytest.mark.parametrize(("cell", "typed", "name"), [
    ("B2", "hand", "Touch"), ("E4", "wave", "Gesture"), ("E4", "music", "Play sound"), ("D2", '"wav', "Wave"),
    ("D2", '"クラ', ""), *(pytest.param(*one, marks=pytest.mark.slow) for one in OTHER_WORDS),
])  # fmt: skip
def test_plain_words_find_what_is_meant(at, cell: str, typed: str, name: str) -> None:
    assert (name in (found := at("T", cell, typed))) is bool(name), found


@pytest.mark.parametrize(
    ("cell", "typed", "name"),
    [("B5", "顔", "Face"), ("B5", "押す", "Operator button"), ("E4", "歩く", "Walk"), ("D2", "redBall.色", "colour")],
)
def test_so_do_japanese_ones(shelf: Books, book: Path, cell: str, typed: str, name: str) -> None:
    grid = shelf.open(path=book, sheet="T")
    grid.checked()
    grid.go(cell)
    grid.press("F2", "Control+a")
    grid.page.keyboard.insert_text(typed)  # as an input method does
    eventually(lambda: name in grid.page.locator("[role=option] .name").all_inner_texts())
    grid.press("Escape", "Escape")


def test_single_joints_come_last(at) -> None:
    found = at("T", "B2", "hand")
    assert found.index("Touch") < found.index("L hand")


def test_a_finished_word_hides_no_others(at) -> None:
    assert {"Ball", "Red ball", "Blue ball"} <= set(at("T", "B2", "Ball"))
    assert at("T", "B2", "Distance, Gaze") == [], "a complete name alone is no suggestion"


@pytest.mark.slow
def test_devices_offer_what_the_device_takes(at, shelf: Books) -> None:
    assert at("Devices", "B4", "oper")[0] == "Operator button"
    assert "HeadYaw" in at("Devices", "C2", "heady")
    readonly = "[...document.querySelectorAll('tbody tr:nth-child(2) td.untaken')].map(c => c.getAttribute('aria-label').split(',')[0])"
    becomes(lambda: shelf.page.evaluate(readonly), ["Joint", "Rate"])  # a button has only a label
    becomes(lambda: shelf.page.evaluate(readonly.replace("nth-child(2)", "nth-child(1)")), ["Label"])


@pytest.mark.slow
def test_helpers(at) -> None:
    assert "how far" in at("Helpers", "C2", "how") or "howFar" in at("Helpers", "C2", "how")
    assert at("Helpers", "C2", "roun")[0].startswith("ROUND")
    assert at("Helpers", "C2", "lim")[0] == "limit"


@pytest.mark.slow
def test_scenes(at) -> None:
    assert "Red ball" in at("Scene", "B5", "red")
    assert at("Scene", "C2", "m")[0] == "moves" and "enters" not in at("Scene", "C2", "e")
    assert "enters" in at("Scene", "C3", "e")
    assert "at 1, 0.2, 0.4" in at("Scene", "D2", "a")
    assert "at 1, 0" in at("Scene", "D3", "a")
    assert at("Scene", "D4", "g") == ["Go"] or at("Scene", "D4", "s") == ["Start"]


@pytest.mark.slow
def test_scenes_and_tests_in_japanese(shelf: Books) -> None:
    def offered(cell: str, typed: str, word: str) -> list[str]:
        page.go(cell)
        page.press("F2", "Control+a")
        page.page.keyboard.insert_text(typed)  # as an input method does
        names = page.page.locator("[role=option] .name")
        eventually(lambda: word in names.all_inner_texts())
        found = [str(name) for name in names.all_inner_texts()]
        page.press("Escape", "Escape")
        return found

    book = shelf.file(IN_JAPANESE)
    page = shelf.open(path=book, sheet="シーン")
    page.checked()
    offered("B5", "赤", "赤いボール")
    assert "現れる" not in offered("C2", "動", "動く")
    assert "動く" not in offered("C3", "入", "入ってくる")
    offered("D2", "位", "位置 1, 0.2, 0.4")
    offered("D3", "位", "位置 1, 0")
    page = shelf.open(path=book, sheet="試し")
    page.checked()
    assert "なしまたは空" in offered("D2", "な", "なし")
    assert offered("C2", "距離=0.2; 色=", "赤") == ["赤", "緑", "青"] and offered("D2", 'colour="', "赤")[0] == "赤"
    page = shelf.open(path=book, sheet="追う")
    page.checked()
    offered("B2", "fil", "filter")
    expect(page.cell("B2").locator(".word")).to_have_attribute("title", "controls an actuator")
    assert "Wave" not in offered("C2", '"手', "手を振る") + offered("C2", '"wav', "手を振る")
    assert offered("C2", 'touch.場所 = "', "頭")[1:3] == ["左手", "右手"] and offered(
        "C2", 'touch.zone <> "左', "左足"
    ) == ["左手", "左足"]
    assert offered("C2", "redBall.col", "色") + offered("C2", "redBall.距", "距離") == ["色", "距離"]


@pytest.mark.slow
def test_tests(at) -> None:
    assert "Red ball" in at("Try", "B3", "red") and "Distance" in at("Try", "B3", "dis")
    assert "distance=" in at("Try", "C2", "d") and "x=" in at("Try", "C2", "distance=1; x")
    assert {"any", "nothing", "nothing or blank"} <= {*at("Try", "D2", "a"), *at("Try", "D2", "no")}


@pytest.mark.slow
def test_protocols(at, shelf: Books) -> None:
    assert "Seed" in at("Protocol", "A4", "se")
    assert at("Protocol", "B2", "ev") == ["event loop"]
    assert at("Protocol", "B3", "T, u") == ["Uses"]


@pytest.mark.slow
def test_tables_of_ones_own(at) -> None:
    assert "colours" in at("Uses", "D2", "col")


@pytest.mark.slow
def test_tab_and_enter_take_what_is_offered(shelf: Books) -> None:
    grid = shelf.open(SHEETS, sheet="Try")
    grid.checked()
    for address, typed, then, text in (
        ("B2", "Dis", "Tab", "Distance"), ("B3", "Su", "Enter", "Sum"), ("D2", "an", "Tab Tab", "any"),
        ("D3", "noth", "Enter Enter", "nothing"), ("C2", "5 s", "Enter", "5 s"),
    ):  # fmt: skip
        grid.go(address)
        grid.page.keyboard.type(typed)
        grid.press(*then.split())
        assert grid.text(address) == text, address
        becomes(lambda: grid.page.locator(".editor").count(), 0)
    grid = shelf.open(path=grid.path, sheet="T")
    grid.checked()
    for typed, then, text in (
        ("redBall.dist", "Enter Enter", "redBall.distance"), ("value", "Enter", "value"), ("4 > 5 s", "Enter", "4 > 5 s"),
    ):  # fmt: skip
        grid.go("D2")
        grid.page.keyboard.type(typed)
        grid.press(*then.split())
        becomes(lambda: grid.text("D2"), text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sheet", "address", "typed", "chosen"),
    [
        ("Scene", "D2", "", "at 1, 0.2, 0.4"),  # a value that may be anything else too
        ("Devices", "B4", "say", "Say parameter"),  # a complete name, which a longer one continues
    ],
)
def test_tab_and_enter_take_a_suggestion_that_was_chosen(
    shelf: Books, sheet: str, address: str, typed: str, chosen: str
) -> None:
    grid = shelf.open(SHEETS, sheet=sheet)
    grid.checked()
    option = grid.page.locator(".suggestions [aria-selected=true] .name")
    for keys in ("Tab",), ("Enter", "Enter"):
        grid.go(address)
        grid.page.keyboard.type(typed) if typed else grid.press("F2")
        for _ in range(20):
            before = option.all_inner_texts()  # read once: the next key alone changes it
            grid.press("ArrowDown")
            eventually(lambda before=before: option.all_inner_texts() not in ([], before), keys)
            if option.all_inner_texts() == [chosen]:
                break
        else:
            raise AssertionError(f"{chosen} is not offered, to be taken by {keys}")
        grid.press(*keys)
        becomes(lambda: grid.text(address), chosen, keys)
        becomes(lambda: grid.page.locator(".editor").count(), 0, keys)
        grid.press("Control+z")
        becomes(lambda: grid.text(address), "", keys)


@pytest.mark.slow
def test_suggestions_come_when_the_words_have_come_and_leave_what_is_wrong_in_sight(shelf: Books) -> None:
    held: list[Any] = []

    def hold(route: Any) -> None:
        held.append(route)

    shelf.page.route("**/vocabulary", hold)
    grid = shelf.open({**TRACKING, "Try": [SHEETS["Try"][0], ["0", "Dista", "1", "", ""]]}, sheet="Try")
    grid.page.wait_for_selector("body[data-ready]")
    grid.go("B2")
    grid.press("F2")
    until(grid.page, lambda: held)
    expect(grid.page.locator(".suggestions [role=option]")).to_have_count(0)
    for route in held:
        route.continue_()
    grid.page.wait_for_selector(".suggestions [role=option]")
    expect(grid.page.locator(".suggestions [aria-selected=true]")).to_have_count(0)
    grid.page.unroute("**/vocabulary")
    grid.press("Escape", "Escape")
    grid.page.wait_for_selector("td[aria-invalid=true]")
    grid.go("B2")
    grid.press("F2")
    grid.page.wait_for_selector(".suggestions [role=option]")
    grid.page.wait_for_selector(".editor .mend >> text=Dista")  # the one may be shown before the other
    script = """() => { const [wrong, offered] = ['.editor .mend', '.editor .suggestions'].map((part) =>
      document.querySelector(part)?.getBoundingClientRect());
      return wrong?.height && offered?.height && wrong.bottom <= offered.top; }"""
    grid.page.wait_for_function(script)
    becomes(lambda: grid.page.locator("td .mend:visible").count(), 0)
    grid.press("Escape", "Escape")
    becomes(lambda: grid.page.locator("td .mend:visible").count(), 1)


@pytest.mark.slow
def test_words_are_fetched_only_when_they_have_changed(shelf: Books) -> None:
    grid = shelf.open()
    grid.checked()
    with requests_of(grid.page) as asked:
        grid.go("F2")
        grid.page.evaluate(
            "() => { window.checks = 0; document.getElementById('listen').addEventListener('checked', () => window.checks++); }"
        )
        grid.write("only a note")
        grid.page.wait_for_function("() => window.checks > 0")
        grid.page.wait_for_selector("#panels:not([aria-busy=true])")
        words = [address for address in asked if address.endswith("/vocabulary")]
        assert not words
        grid.go("E2")
        grid.write("Length")
        until(grid.page, lambda: [address for address in asked if address.endswith("/vocabulary")])
        assert "Length" in grid.offered("B3", "Len")
        words = [address for address in asked if address.endswith("/vocabulary")]
    assert len(words) <= 2, "once for each check at most"


@pytest.mark.slow
def test_a_text_for_a_device_that_takes_none_is_kept_and_leads_to_the_device_that_takes_it(shelf: Books) -> None:
    rows = [["Stream", "Device", "Text", "Notes"], ["Say praise", "", "", ""], ["Neck", "Head yaw", "", ""]]
    grid = shelf.open({**SHEETS, "Devices": rows}, sheet="Devices")
    grid.checked()
    grid.go("B2")
    grid.page.keyboard.type("Say")
    expect(grid.page.locator("[role=option]", has_text="text that arrives").first).to_be_visible()
    expect(
        grid.page.locator("[role=option]", has_text=re.compile("^Say parameter.*of its setting")).first
    ).to_be_visible()
    grid.press("Tab")
    becomes(lambda: grid.text("B2"), "Say")
    grid.page.keyboard.type("Well done!")
    eventually(lambda: "Say parameter" in grid.page.inner_text(".signature"))
    grid.press("Enter")
    grid.go("C2")
    grid.page.click("td.at .mend [data-fix]:has-text('Use Say parameter')")
    grid.expect("B2", "Say parameter")
    becomes(lambda: grid.text("C2"), "Well done!")
    grid.page.wait_for_selector("td[data-v='Well done!']:not(.flagged)")
    grid.go("C3")
    grid.page.keyboard.type("x")
    eventually(lambda: "Leave the cell blank" in grid.page.inner_text(".signature"))
    grid.press("Escape")
