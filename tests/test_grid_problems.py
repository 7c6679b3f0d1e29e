"""Problems in the grid: told at their cell, quiet while a row is being typed, mended by a key or a button."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from chromium import becomes, eventually, some, until
from grid_books import EMPTY, TRACKING, Books
from playwright.sync_api import expect
from slow_answers import SlowAnswers

from rrp_sheets import api
from rrp_sheets.model.workbook import FALSE_WORDS, TRUE_WORDS, truth_of
from rrp_sheets.resources import bundled
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import read_sheets


@pytest.mark.slow
def test_a_problem_is_told_at_its_cell_leads_there_and_is_mended(shelf: Books) -> None:
    grid = shelf.open()
    grid.go("D3")
    grid.write("distence < 0.5")
    grid.page.wait_for_selector("td[aria-invalid=true]:has-text('distence')")
    described = some(lambda: grid.cell("D3").get_attribute("aria-describedby"))
    eventually(lambda: "Did you mean distance" in grid.page.locator(f"#{described.split()[0]}").text_content())
    grid.go("B2")
    grid.page.click(".problem-list a")
    becomes(lambda: grid.here, "D3")
    grid.press("F6")
    eventually(lambda: grid.page.evaluate("document.activeElement.closest('#panels') !== null"))
    grid.press("F6")
    becomes(lambda: grid.page.evaluate("document.activeElement.getAttribute('role')"), "gridcell")
    box = grid.page.locator(".mends:visible")
    eventually(lambda: "Apply fix: Write distance" in box.inner_text() and "Ctrl ." in box.inner_text())
    grid.press("Control+.")
    grid.expect("D3", "distance < 0.5")
    grid.status("Done: Write distance. Press Ctrl+Z to undo.")
    becomes(lambda: grid.here, "D3")
    grid.page.wait_for_selector("td[aria-invalid=true]", state="detached")
    grid.press("Control+z")
    grid.expect("D3", "distence < 0.5")
    for where in (".problem-list", ".mends:visible"):  # the same by the buttons
        grid.go("D3")
        grid.page.click(f"{where} [data-fix]")
        grid.expect("D3", "distance < 0.5")
        grid.go("D3")
        grid.press("Control+z")
        grid.expect("D3", "distence < 0.5")
        grid.page.wait_for_selector("td[aria-invalid=true]:has-text('distence')")


@pytest.mark.slow
def test_a_fix_adds_a_column_to_the_devices_which_every_page_shows_at_once(shelf: Books) -> None:
    row = ["", "Chest button", "subscribe", '"こんにちは"', "Say", ""]
    path = shelf.file({"T": [TRACKING["T"][0], row], "Devices": [["Stream", "Device"], ["Ask", "Say"]]})
    devices = shelf.open(path=path, sheet="Devices", name="other")
    grid = shelf.open(path=path, sheet="T")
    titles = devices.page.locator("[role=columnheader][data-c] .title")
    expect(titles).to_have_text(["Stream", "Device"])
    grid.go("D2")
    expect(grid.page.locator(".problem-list p").first).to_have_text(
        re.compile("^“.*“Say” speaks English.* LINT[0-9]{3}$")
    )
    grid.page.click(".problem-list [data-fix]")
    expect(titles).to_have_text(["Stream", "Device", "Language"])
    expect(devices.page.locator("tbody tr", has_text="ja")).to_contain_text("Say")
    expect(grid.page.locator(".problem-list li")).to_have_count(0)
    assert api.check(path).graph.streams["say"].settings["language"] == "ja"
    grid.press("Control+z")
    expect(titles).to_have_text(["Stream", "Device"])


LATER = """() => {
  const soon = window.setTimeout, late = [];
  window.setTimeout = (call, milliseconds, ...more) => milliseconds === 6000 ? -late.push(call) : soon(call, milliseconds, ...more);
  window.later = () => late.at(-1)();
}"""
"""Six seconds, after which a row is no longer being typed, go by at once when `later` is called."""


@pytest.mark.slow
def test_a_row_that_is_being_typed_does_not_scold_until_it_is_left(shelf: Books) -> None:
    grid = shelf.open(EMPTY)
    grid.go("B2")
    grid.write("Red ball", "Tab")
    row = grid.page.locator("tbody tr").first
    grid.page.wait_for_selector("tr.unfinished td.flagged")  # the check has told what is missing
    height = some(row.bounding_box)["height"]
    becomes(lambda: grid.page.locator(".mends:visible, td[aria-invalid=true]").count(), 0)
    dot = "getComputedStyle(document.querySelector('td.flagged'), '::after').content"
    eventually(lambda: "•" in grid.page.evaluate(dot))
    becomes(lambda: grid.page.locator(".problem-list li:not(.unfinished)").count(), 0)
    grid.press("ArrowDown")  # the row is left
    grid.page.wait_for_selector("td[aria-invalid=true]")
    eventually(lambda: "!" in grid.page.evaluate(dot) and row.bounding_box()["height"] == height)
    grid.page.evaluate(LATER)
    grid.go("C2")
    grid.write("sampel", "Tab")
    grid.page.wait_for_selector("tr.unfinished td.flagged:has-text('sampel')")
    becomes(lambda: grid.page.locator("td[aria-invalid=true]").count(), 0)
    grid.page.evaluate("window.later()")  # nothing typed for a while
    grid.page.wait_for_selector("td[aria-invalid=true]:has-text('sampel')")


def passes(path: Path) -> bool:
    """True when all tests of a workbook pass."""
    _, report = api.test(path)
    assert report is not None
    return report.passed


@pytest.mark.slow
def test_both_remedies_of_a_stale_combination_silence_it_and_its_test_then_passes(shelf: Books) -> None:
    pattern = bundled("workbooks") / "complex-tracking.xlsx"
    assert not passes(pattern)
    for number in range(2):
        path = shelf.folder / f"stale{number}.xlsx"
        shutil.copy(pattern, path)
        grid = shelf.open(path=path, sheet="Tracking")
        grid.page.wait_for_selector("td.is-warning:has-text('combineLatest')")
        rows = some(grid.page.locator("tbody tr").count)
        grid.go("B10")
        grid.press("Control+.")  # there are two: the key leads to them
        becomes(lambda: grid.page.evaluate("document.activeElement.dataset.fix"), "forget-old-value")
        grid.press(*["ArrowDown"] * number, "Enter")
        grid.page.wait_for_selector("td.flagged:not(.is-info)", state="detached")
        grid.page.wait_for_selector(".problems:has-text('no problems')")
        grid.saved()
        eventually(lambda: grid.page.locator("tbody tr").count() > rows and passes(path))
        grid.press("Control+z")
        grid.page.wait_for_selector("td.is-warning:has-text('combineLatest')")
        eventually(lambda: grid.page.locator("tbody tr").count() == rows and not passes(path))


SPEAKS = [["Input streams", "Connector", "Formula", "Output stream"],
          ["Chest button", "map", '"Hi"', "Hello"], ["Hello", "subscribe", "", "Say"]]  # fmt: skip
RISKS = ["Risk", "For whom", "How likely", "What reduces it", "Who ends the session when"]


BOREDOM = [["Boredom", "The child", "Possible", "Games", "The child, at any sign"]]


@pytest.mark.parametrize("mine", [[], pytest.param(BOREDOM, marks=pytest.mark.slow)])
def test_risks_that_a_fix_proposes_are_one_step_of_undo(shelf: Books, mine: list[list[str]]) -> None:
    grid = shelf.open({"T": SPEAKS, "Risks": [RISKS, *mine], "Protocol": [["Field", "Value"]]}, sheet="Risks")
    finding = grid.page.locator(".problem-list li", has_text="PROT012")
    finding.wait_for()

    def file() -> dict[str, dict[tuple[int, int], str]]:
        grid.saved()
        return {s.name: {at: cell.typed for at, cell in s.cells.items()} for s in read_sheets(grid.path)}

    def shown() -> list[str]:
        return [str(text) for text in grid.page.locator("tbody td[data-v]").all_inner_texts()]

    before, here = file(), shown()
    finding.locator("[data-fix=add-proposed]").click()
    grid.status("Done: Add the proposed rows. Press Ctrl+Z to undo.")
    expect(finding).to_have_count(0)
    after, there = file(), shown()
    proposed = read(grid.path).workbook.risks.rows[len(mine) :]
    assert len(proposed) > 1 and all(r.risk and r.whom and r.likely and r.reduces and r.ends for r in proposed)
    assert there[: len(here)] == here and len(there) == len(here) + 5 * len(proposed)
    grid.press("Control+z")
    finding.wait_for()
    assert (file(), shown()) == (before, here)
    grid.press("Control+z")
    grid.status("There is nothing to undo.")
    grid.press("Control+y")
    expect(finding).to_have_count(0)
    assert (file(), shown()) == (after, there)


def test_warnings_stay_in_the_list_below_an_error_which_says_that_checks_wait(shelf: Books) -> None:
    path = shelf.folder / "both.xlsx"
    shutil.copy(bundled("workbooks") / "complex-tracking.xlsx", path)
    grid = shelf.open(path=path, sheet="Tracking")
    codes = grid.page.locator(".problem-list .code")
    expect(codes).to_have_text(["LINT001"])
    becomes(lambda: grid.page.locator(".more-later").count(), 0)
    grid.go("A20")
    for text in "Red ball", "map", "redBall.distence", "Far":
        grid.write(text, "Tab")
    grid.press("Control+Home")
    expect(codes).to_have_text(["FORM007", "LINT001", "GRAPH011"])
    expect(grid.page.locator(".more-later")).to_have_text(
        "Some checks need the errors fixed first, so more problems may appear."
    )
    grid.page.locator(".problem-list [data-fix]").first.click()
    expect(codes).to_have_text(["LINT001", "GRAPH011"])
    becomes(lambda: grid.page.locator(".more-later").count(), 0)


def test_a_row_that_a_fix_inserts_is_shown_as_the_check_after_it_says_however_late_the_answer(shelf: Books) -> None:
    path = shelf.folder / "late.xlsx"
    shutil.copy(bundled("workbooks") / "complex-tracking.xlsx", path)
    grid = shelf.open(path=path, sheet="Tracking")
    grid.page.wait_for_selector("td.is-warning:has-text('combineLatest')")
    with SlowAnswers(grid.page) as slow:
        grid.go("B10")
        grid.press("Control+.", "Enter")
        until(grid.page, lambda: slow.asked)
        slow.step()  # it is made, and the page does not know it yet
        until(grid.page, lambda: grid.page.evaluate("heldEvents.some(([, data]) => data.includes('forgetAfter'))"))
        slow.events()
    grid.page.wait_for_selector("td[data-v=forgetAfter]")
    grid.page.wait_for_selector("td.flagged:not(.is-info)", state="detached")


@pytest.mark.slow
def test_the_tick_says_what_the_reader_does_with_words_of_other_languages(shelf: Books) -> None:
    rows = "".join(
        f"| {word} | Red ball | map | 1 | Y{i} |\n" for i, word in enumerate(["FALSCH", "いいえ", "はい", "WAHR", ""])
    )
    book = f"## Look\n| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n{rows}"
    (shelf.folder / "languages.md").write_text(book, encoding="utf-8")
    grid = shelf.open(path=shelf.folder / "languages.md", sheet="Look")

    def ticked(row: int, *, on: bool) -> None:
        expect(grid.page.locator(f"tbody tr:nth-child({row - 1}) td.on input")).to_be_checked(checked=on)

    for row, on in ((2, False), (3, False), (4, True), (5, True), (6, True)):
        ticked(row, on=on)
    for word, on in (("faux", False), ("はい", True), ("オフ", False)):
        grid.page.evaluate("text => navigator.clipboard.writeText(text)", word)
        grid.go("A4")
        grid.press("Control+v")
        ticked(4, on=on)
        grid.saved()
        assert read(grid.path).workbook.behaviours[0].rows[2].on is on
    words = [form for w in sorted(TRUE_WORDS | FALSE_WORDS) for form in (w, f" {w.upper()} ", f"'{w}", w + chr(0x200B))]
    words += ["ＦＡＬＳＥ", "ｵﾌ", "maybe", "", "０"]
    is_off = """async words => {
        const { Table } = await import(document.querySelector("script[src*='grid/main.js']").src.replace("main.js", "grid.js"));
        const table = new Table(document.querySelector("table[role=grid]"));
        return words.map((word) => table.isOff(word));
    }"""
    becomes(lambda: grid.page.evaluate(is_off, words), [truth_of(word) is False for word in words])


@pytest.mark.slow
def test_on_is_not_ticked_in_rows_where_nothing_stands(shelf: Books) -> None:
    grid = shelf.open(TRACKING)
    becomes(lambda: grid.page.locator("tbody tr:nth-child(-n+3) td.on input:checked").count(), 3)
    becomes(lambda: grid.page.locator("tbody td.on input").count(), 3)
    grid.go("F9")
    grid.write("a note")
    grid.page.wait_for_selector("tbody tr:nth-child(8) td.on input:checked")
