"""Several people in one workbook: what they see of each other, and what happens when they change the same."""

from __future__ import annotations

from typing import Any

import pytest
from chromium import eventually, listening, until
from grid_books import HEADER, Books, Shared
from playwright.sync_api import expect

from rrp_sheets.workbook.files import read_sheets


@pytest.mark.slow
def test_one_sees_what_the_other_types_where_and_is_not_disturbed_by_it(shelf: Books) -> None:
    aya, mika = shelf.two()
    aya.go("F4")
    aya.page.keyboard.type("I am")
    mika.page.wait_for_selector("td.taken:has-text('Aya is editing')")
    mika.wait_spoken("Aya is editing: F4")
    aya.press("Escape")
    mika.page.wait_for_selector("td.taken", state="detached")
    aya.page.keyboard.type("half a")
    mika.page.wait_for_selector("td.taken")
    mika.go("E4")
    mika.write("Say")
    aya.expect("E4", "Say")
    mika.go("B2")
    mika.press("Control++")
    aya.page.wait_for_selector("tbody tr:nth-child(5)[aria-rowindex='6']")
    aya.page.keyboard.type(" note")
    aya.press("Enter")
    mika.expect("F5", "half a note")
    mika.page.wait_for_selector("td.taken", state="detached")
    aya.go("F5")
    aya.press("F2")
    mika.page.wait_for_selector("td.taken")
    mika.go("E5")
    mika.write("Print")
    aya.expect("E5", "Print")
    aya.press("Escape")
    eventually(lambda: not aya.page.locator("td.taken, .name-tag").count())  # nobody is told of their own editing


def quicker(aya: Shared, mika: Shared, cell: str, mine: str, theirs: str, *, offline: bool = False) -> Any:
    """Mika changes a cell while Aya's edit of it is on its way, or her line down; gives the dialog that asks Aya."""
    held: list[Any] = []

    def hold(route: Any) -> None:
        route.abort() if offline else held.append(route)

    aya.page.route("**/cells", hold)
    aya.go(cell)
    aya.write(mine)
    if offline:
        expect(aya.page.locator(".unsent")).to_contain_text("keeps your changes")
    else:
        until(aya.page, lambda: held)
    mika.go(cell)
    mika.write(theirs)
    mika.saved()
    for route in held:
        route.continue_()
    aya.page.unroute("**/cells", hold)
    return aya.page.wait_for_selector("dialog.ask[open]")


@pytest.mark.slow
def test_when_somebody_was_quicker_both_texts_are_shown_and_one_is_chosen(shelf: Books) -> None:
    """By mouse and by keyboard; or both are kept, one's own as a note of the row, or in the note itself."""
    aya, mika = shelf.two()
    ways = ("F4", "Keep theirs", "of Mika"), ("F2", "Keep mine", "of Aya"), ("F5", "Keep both", "of Mika\nof Aya")
    for cell, keep, left in ways:
        quicker(aya, mika, cell, "of Aya", "of Mika")
        for text in ("of Aya", "of Mika", f"{cell}: Mika has changed this cell"):
            expect(aya.page.locator("dialog[open]")).to_contain_text(text)
        if keep == "Keep theirs":
            assert aya.faults() == []
            aya.page.click(f"dialog button:text-is('{keep}')")
        else:  # the focus is on the first button
            aya.press(*["Tab"] * ["Keep mine", "Keep theirs", "Keep both"].index(keep), "Enter")
        for page in (aya, mika):
            page.expect(cell, left)
    quicker(aya, mika, "D3", "distance < 0.1", "distance < 0.2", offline=True)
    aya.page.click("dialog button:has-text('mine as a note')")
    for page in (aya, mika):
        page.expect("D3", "distance < 0.2")
        page.expect("F3", "near\nAya: distance < 0.1")
    aya.status("Both texts are saved.")


@pytest.mark.slow
def test_one_gives_oneself_a_name_and_others_see_where_one_is(shelf: Books) -> None:
    path = shelf.file()
    aya, mika = shelf.open(path=path), shelf.open(path=path, name="Mika")
    aya.page.click("[data-do=name]")
    aya.page.keyboard.type("<b>Aya")
    aya.page.keyboard.press("Enter")
    aya.go("D3")
    mika.page.wait_for_selector("#people:has-text('<b>Aya (D3) is here too')")
    mika.page.wait_for_selector("td.formula[data-who='<b>Aya']")
    aya.page.evaluate("localStorage.removeItem('name')")


@pytest.mark.soak  # in every run: test_tasks_together
def test_two_browsers_fill_200_cells_at_once_and_nothing_is_lost(shelf: Books) -> None:
    aya, mika = shelf.two()
    fill = """([letter, who]) => {
        const at = document.querySelector(`thead th[data-letter='${letter}']`).cellIndex;
        const rows = [...document.querySelectorAll("tbody tr")].slice(3, 23);
        const transfer = (cell, text) => {
            const clientY = 10 * cell.parentElement.sectionRowIndex;
            cell.dispatchEvent(new PointerEvent("pointerdown", { bubbles: true, button: 0, clientY }));
            const data = new DataTransfer();
            data.setData("text/plain", text);
            document.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true }));
        };
        for (let round = 0; round < 5; round++) rows.forEach((row, i) => transfer(row.cells[at], `${who} ${round} ${i}`));
    }"""
    aya.page.evaluate(fill, ["D", "aya"])
    mika.page.evaluate(fill, ["F", "mika"])
    for page in (aya, mika):
        page.saved()
    screens = []
    for page in (aya, mika):
        page.expect("D24", "aya 4 19")
        page.expect("F24", "mika 4 19")
        screens.append([(page.text(f"D{n}"), page.text(f"F{n}")) for n in range(5, 25)])
    assert screens[0] == screens[1] == [(f"aya 4 {i}", f"mika 4 {i}") for i in range(20)]
    sheet = read_sheets(aya.path)[0]
    assert [(sheet.cells[n, 4].typed, sheet.cells[n, 6].typed) for n in range(5, 25)] == screens[0]


@pytest.mark.slow
def test_what_another_changes_while_a_long_sheet_is_loaded_is_shown(shelf: Books) -> None:
    path = shelf.file({"T": [HEADER, *([["", "", "", "", "", "old"]] * 260)]})
    mika = shelf.open(path=path, name="Mika")
    mika.page.wait_for_selector("body[data-ready]")
    held: list[Any] = []
    aya = shelf.open(name="Aya")
    aya.page.route("**/rows/**", lambda route: held.append((route, route.fetch())))
    aya.page.goto(mika.page.url)
    until(aya.page, lambda: held)  # the rest of the rows is on its way, and older than what Mika changes
    listening(aya.page)
    aya.page.evaluate("addEventListener('grid', ({ detail }) => { window.told = detail.data; }, true)")
    mika.go("F250")
    mika.write("new")
    until(aya.page, lambda: "new" in (aya.page.evaluate("window.told") or ""))
    route, answer = held.pop()
    route.fulfill(response=answer)
    aya.expect("F250", "new")
    aya.page.unroute("**/rows/**")
