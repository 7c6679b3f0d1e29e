"""A whole session in Japanese in the browser, from the list of workbooks to the recording: no word of it is English."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from chromium import GridPage, eventually, listening, press_twice
from playwright.sync_api import Browser, Page, expect

HEAD = ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"]
BOOKS = {
    "挨拶.xlsx": {
        "追う": [
            HEAD,
            ["赤い玉", "map", "value.distance", "距離", "", ""],
            ["距離", "filter", "value < 2", "近い", "", "近いとき"],
            ["近い", "subscribe", "", "頭で追う", "", ""],
            ["合図", "map", "\"こんにちは\"", "挨拶", "", ""],
            ["挨拶", "subscribe", "", "話す", "", ""],
            ["誰か", "map", "x", "無題", "", "間違い"],
        ],
        "Devices": [
            ["Stream", "Device", "Label"],
            ["赤い玉", "Red ball", ""],
            ["頭で追う", "Head tracker", ""],
            ["合図", "Operator button", "始め"],
            ["話す", "Say input", ""],
        ],
        "Scene": [
            ["Time (s)", "Thing", "Does", "Value", "Notes"],
            ["0.1", "Red ball", "appears", "at 1, 0, 0.4", ""],
            ["0.5", "Red ball", "moves", "to 1, 0.3, 0.4 in 2 s", ""],
        ],
        "試し": [
            ["Time (ms)", "Stream", "Send", "Expect", "Notes"],
            ["0", "赤い玉", "distance=1", "", ""],
            ["0", "近い", "", "3", "外れる"],
        ],
        "Protocol": [["Field", "Value"], ["Title", "挨拶の練習"], ["Run", "追う"], ["Language", "ja"]],
    }
}  # fmt: skip
ENGLISH = """() => {
  const japanese = /[\\u3040-\\u30ff\\u4e00-\\u9fff]/, word = /[a-z]{2}/i, found = new Set();
  const ours = "script, style, code, kbd, .word, .formula, .name, .code, #languages, [lang=en], td[data-v]";
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_ELEMENT | NodeFilter.SHOW_TEXT);
  for (let node; (node = walk.nextNode()); ) {
    const texts = node.nodeType === Node.TEXT_NODE ? [node.parentElement.closest(ours) ? "" : node.textContent]
      : node.closest(ours) ? [] : ["title", "aria-label", "placeholder", "alt", "data-head", "label"].map((a) => node.getAttribute(a) ?? "");
    for (const text of texts) if (word.test(text) && !japanese.test(text)) found.add(text.trim());
  }
  return [...found];
}"""
SAME = re.compile(
    r"挨拶.*|RRP Sheets.*|NAO|SVG|Esc.*|CSV|PDF|English|A4|Letter|SHA-256|F\d+|Ctrl.*|Shift.*|Alt.*"
    r"|(?:Devices|Scene|Protocol|Input streams|Connector|Formula|Output stream|On|Notes|Stream|Device|Label)(?: \d+)?|Time \(ms\)|Send|Expect"
    r"|\.?[a-z-]+(?:-\d+)?\.(?:csv|xlsx|svg|png|gif|jsonl|toml|wav|pdf|zip|jpg)|\.(?:csv|xlsx|pdf|svg)"
    r"|map|filter|subscribe|[a-z]+(?:\.[a-z]+)? ?(?:< 2|x)?|value.*|-?[\d.,:/ 〜-]+(?:m|s|rad|kB|MB|Hz|ms|min|×)(?:[ /].*)?"
    r"|/.*/books|[a-z]+(?:-[a-z]+)+"  # the folder and the workbooks to start from
    r"|LINT\d+|GRAPH\d+|(?:Red ball|Head tracker).*|[0-9a-f]{8,}|.*!\d+|runs/.*|[A-Z]\d+ .*|.*℃"
)
"""What is the same in both languages: the workbook's own words, names, files, units, keys."""


def english(page: Page) -> list[str]:
    """Return the texts of a page that are English."""
    return [text for text in page.evaluate(ENGLISH) if not SAME.fullmatch(text)]


@pytest.fixture
def reader(browser: Browser, url: str) -> Iterator[GridPage]:
    here = GridPage(browser, url, "挨拶.xlsx", locale="ja", viewport={"width": 1400, "height": 900})
    yield here
    here.close()


@pytest.mark.slow
def test_a_session_is_in_japanese_from_the_workbook_to_the_recording(reader: GridPage, url: str) -> None:
    page = reader.page
    expect(page.locator(".problem-list li").first).to_be_visible()
    expect(page.locator("#row-words li").first).to_be_visible()
    assert not english(page), english(page)
    page.click("[data-do=rows]")
    expect(page.get_by_role("menuitem").first).to_be_visible()
    assert not english(page), english(page)
    reader.press("Escape", "F2", "Escape")
    page.goto(f"{url}/book/挨拶.xlsx/sheet/試し")
    expect(page.get_by_text("エラーがあるため実行していません").first).to_be_visible()
    assert not english(page), english(page)
    page.goto(f"{url}/book/挨拶.xlsx/sheet/追う")
    listening(page)
    reader.go("A7")
    reader.press("Delete")
    for letter in "BCDF":
        reader.go(f"{letter}7")
        reader.press("Delete")
    reader.saved()
    reader.go("F6")
    eventually(lambda: page.inner_text("#spoken") == "F6 Notes：空")
    expect(page.locator("[data-run=start]")).not_to_have_attribute("aria-disabled", "true")
    run_and_stop(page, url)
    page.goto(f"{url}/runs")
    assert not english(page), english(page)
    place = page.locator("a[href^='/runs/2']").first.get_attribute("href")
    page.goto(url + str(place))
    expect(page.locator("[data-writing]")).to_have_count(0)  # its last file is there: it does not load again
    expect(page.locator("#marbles svg").first).to_be_visible()
    assert not english(page), english(page)
    page.goto(f"{url}{place}/lookback")
    eventually(lambda: page.locator("table.ran-rows tr").count() > 0)
    expect(page.locator("table.ran-rows .sensor .only-spoken").first).to_have_text("センサー")
    assert not english(page), english(page)
    page.goto(f"{url}{place}/replay")
    expect(page.locator("main [role=status]")).to_contain_text("同じです")
    assert not english(page), english(page)
    for address in ("/", "/book/挨拶.xlsx/versions", "/compare", "/book/挨拶.xlsx/print"):
        page.goto(url + address)
        expect(page.locator("main")).to_be_visible()
        assert english(page) == [], address


def run_and_stop(page: Page, url: str) -> None:
    page.goto(f"{url}/book/挨拶.xlsx/run/追う")
    listening(page)
    page.click("[data-run=start]")
    expect(page.locator("#run-dialog [type=submit]")).to_be_visible()
    assert not english(page), english(page)
    page.click("#run-dialog [type=submit]")
    page.wait_for_selector("body[data-run=running]")
    page.locator("#press button").first.click()
    page.fill("#mark input", "笑った")
    page.keyboard.press("Enter")
    expect(page.locator("#log li[data-kind=speech]").first).to_be_visible()
    assert not english(page), english(page)
    for view in ("plots", "diagram", "drives", "send", "scene", "tests", "problems"):
        page.click(f"#views [data-view={view}]")
        assert english(page) == [], view
    page.locator("body").press("Escape")
    press_twice(page)
    page.wait_for_selector("body[data-run=ended]")
    assert not english(page), english(page)
