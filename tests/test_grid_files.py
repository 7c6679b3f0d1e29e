"""Files of all kinds under the grid: Markdown, write-protected, open in Excel, deleted; Japanese; many columns; long texts."""

from __future__ import annotations

import pytest
from chromium import GridPage, becomes, eventually, violations
from grid_books import HEADER, ROWS, Books
from playwright.sync_api import expect

from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import read_sheets

MARKDOWN = """# A workbook

Some words of mine.

## Tracking

| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | redBall.distance | Distance |
| Distance | subscribe | | Print |

More words.
"""


@pytest.mark.slow
def test_a_markdown_workbook_is_edited_and_its_words_stay(shelf: Books) -> None:
    path = shelf.folder / "plan.md"
    path.write_text(MARKDOWN, encoding="utf-8")
    grid = shelf.open(path=path)
    grid.go("C2")
    grid.write("redBall.x")
    grid.go("A3")
    grid.press("Control++")
    grid.expect("B4", "subscribe")
    grid.go("A3")
    grid.write("Distance", "Tab")
    grid.write("filter", "Tab")
    grid.saved()
    assert [r[1:3] for r in grid.rows()] == [("map", "redBall.x"), ("filter", ""), ("subscribe", "")]
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# A workbook\n\nSome words of mine.\n") and text.endswith("\nMore words.\n")
    grid.press("Control+z", "Control+z", "Control+z", "Control+z")
    grid.expect("C2", "redBall.distance")
    grid.saved()
    assert path.read_text(encoding="utf-8") == MARKDOWN


def test_a_file_that_is_open_in_excel_deleted_protected_or_replaced_under_an_open_page(
    shelf: Books, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rrp_sheets.web.workbook_session.POLL_EVERY", 0.1)
    grid = shelf.open()
    notice = grid.page.locator("#notice")
    becomes(notice.inner_text, "")
    lock = grid.path.with_name(f"~${grid.path.name}")
    lock.write_bytes(b"x")
    grid.page.wait_for_selector("#notice:has-text('is open in Excel')")
    eventually(
        lambda: (
            "not change it, so that nothing is lost" in notice.inner_text() and "Close it there" in notice.inner_text()
        )
    )
    before = grid.path.read_bytes()
    grid.go("F2")
    grid.write("mine")
    dialog = grid.page.wait_for_selector("dialog.ask[open]")
    eventually(lambda: "is open in Excel" in dialog.inner_text())
    becomes(lambda: grid.page.locator("dialog.ask[open] textarea").input_value(), "mine")  # nothing typed is lost
    grid.page.click("dialog.ask[open] button")
    eventually(lambda: grid.path.read_bytes() == before and grid.text("F2") == "")
    lock.unlink()
    grid.page.wait_for_selector("#notice:has-text('Excel')", state="detached")
    grid.go("F2")
    grid.write("mine")
    grid.saved()
    assert grid.path.read_bytes() != before
    grid.checked()  # it is told what happens; one whose file goes sooner says that it was renamed or moved
    content = grid.path.read_bytes()
    grid.path.unlink()
    grid.page.wait_for_selector("#notice:has-text('no longer exists')")
    grid.path.write_bytes(content)
    grid.page.wait_for_selector("#notice:has-text('no longer exists')", state="detached")
    grid.path.chmod(0o444)
    grid.page.wait_for_selector("#notice:has-text('write-protected')")
    grid.path.chmod(0o644)
    grid.page.wait_for_selector("#notice:has-text('protected')", state="detached")
    other = shelf.file({"T": [HEADER, ["", "Face", "filter", "face.new", "New face", ""]]})
    grid.path.write_bytes(other.read_bytes())
    grid.expect("B2", "Face")


@pytest.mark.slow
def test_japanese_names_and_what_an_input_method_composes(shelf: Books) -> None:
    book = {
        "追跡": [
            HEADER,
            ["", "Red ball", "map", "redBall.distance", "距離", "近い"],
            ["", "距離", "filter", "距離 < 0.5", "", ""],
        ]
    }
    grid = shelf.open(book, sheet="追跡")
    grid.go("B4")
    assert "距離" in grid.offered("B4")
    grid.go("F3")
    grid.press("F2")
    session = grid.page.context.new_cdp_session(grid.page)
    session.send("Input.imeSetComposition", {"text": "こど", "selectionStart": 2, "selectionEnd": 2})
    compose = "key => document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key, keyCode: 229, bubbles: true, cancelable: true}))"
    for key in ("Enter", "Tab", "Escape", "ArrowDown"):  # they choose among what the input method proposes
        assert grid.page.evaluate(compose, key)  # read once: whether the key was left to the input method
        becomes(lambda: grid.page.locator(".editor textarea").count(), 1)
    session.send("Input.insertText", {"text": "子供"})
    grid.press("Enter")
    eventually(lambda: grid.text("F3") == "子供" and grid.here == "F4")
    assert grid.page.evaluate(compose, "a")  # read once: whether the key was left to the input method
    becomes(grid.page.locator(".editor textarea").count, 0)
    grid.saved()
    assert read(grid.path).workbook.behaviours[0].rows[1].output.text == ""
    assert read_sheets(grid.path)[0].cells[3, 6].text == "子供"


def test_an_input_method_composes_from_its_first_key_in_a_selected_cell(shelf: Books) -> None:
    grid = GridPage(shelf.browser, shelf.url, shelf.file().name, locale="ja-JP")
    session = grid.page.context.new_cdp_session(grid.page)
    field = grid.page.locator(".editor textarea")

    def compose(text: str) -> None:
        for kind in ("rawKeyDown", "keyUp"):
            session.send("Input.dispatchKeyEvent", {"type": kind, "key": "Process", "windowsVirtualKeyCode": 229})
        session.send("Input.imeSetComposition", {"text": text, "selectionStart": len(text), "selectionEnd": len(text)})

    count = "addEventListener('keydown', ({ keyCode }) => keyCode === 229 && (window.composed = (window.composed ?? 0) + 1), true)"
    grid.page.evaluate(count)
    grid.go("F3")
    for text in ("k", "こ", "こど"):
        compose(text)
        expect(field).to_have_value(text)
    for key in ("Enter", "Tab", "Escape", "ArrowDown"):
        session.send("Input.dispatchKeyEvent", {"type": "rawKeyDown", "key": key, "windowsVirtualKeyCode": 229})
    becomes(lambda: grid.page.evaluate("window.composed"), 7)
    expect(field).to_have_value("こど")
    session.send("Input.insertText", {"text": "子供"})
    expect(field).to_have_value("子供")
    grid.press("Enter")
    grid.expect("F3", "子供")
    becomes(lambda: grid.here, "F4")
    compose("ち")  # of the next cell, without a click
    session.send("Input.insertText", {"text": "近い"})
    grid.press("Tab")
    grid.expect("F4", "近い")
    grid.go("F4")
    grid.press("x", "Escape", "F2", "Escape", "Delete")  # keys without an input method do what they do elsewhere
    grid.expect("F4", "")
    grid.press("Control+Home", "Shift+Tab")  # out of the sheet
    becomes(lambda: grid.page.evaluate("document.activeElement.closest('td, .editor') === null"), True)
    grid.go("F2")
    compose("みぎ")
    expect(field).to_have_value("みぎ")
    grid.page.locator("[data-do=name]").focus()  # away from the sheet
    grid.expect("F2", "みぎ")
    expect(grid.page.locator(".waits, .typing, .editor, .waiting")).to_have_count(0)
    grid.close()


FITS = """() => {
  const [field, cell] = [document.activeElement, document.querySelector("td.at")].map((one) => one.getBoundingClientRect());
  return ["x", "y", "width", "height"].every((side) => Math.abs(field[side] - cell[side]) < 2);
}"""


@pytest.mark.parametrize(
    "locale", ["en-US", pytest.param("ko-KR", marks=pytest.mark.slow)]
)  # the latter with a field for an input method
def test_the_selected_cell_has_a_name_a_menu_and_an_outline(shelf: Books, locale: str) -> None:
    grid = GridPage(shelf.browser, shelf.url, shelf.file().name, locale=locale)
    focused = grid.page.locator(":focus")
    outline = "getComputedStyle(document.querySelector('.waiting') ?? document.querySelector('td.at')).outlineStyle"
    grid.go("F3")
    expect(focused).to_have_attribute("aria-label", "Notes, row 3: near")
    becomes(lambda: focused.evaluate("one => one.tagName"), {"en-US": "TD", "ko-KR": "TEXTAREA"}[locale])
    becomes(lambda: grid.page.evaluate(FITS), True)
    grid.press("ContextMenu")
    grid.page.get_by_role("menuitem", name="Clear").click()
    expect(focused).to_have_attribute("aria-label", "Notes, row 3: blank")
    grid.press("Control+z")
    expect(focused).to_have_attribute("aria-label", "Notes, row 3: near")
    assert violations(grid.page) == []
    becomes(lambda: grid.page.evaluate(outline), "solid")
    grid.page.evaluate("document.activeElement.blur()")
    becomes(lambda: grid.page.evaluate(outline), "none")
    grid.close()


@pytest.mark.slow
def test_sixty_columns_and_very_long_texts(shelf: Books) -> None:
    header = [*HEADER, *(f"Mine {n}" for n in range(54))]
    long = "word " * 4000
    rows = [[*ROWS[0], *[""] * 54], ["", "Distance", "subscribe", "", "Print", long.strip(), *[""] * 54]]
    grid = shelf.open({"T": [header, *rows]})
    heads = grid.page.locator("thead .letter")
    eventually(lambda: heads.last.inner_text() == "BH" and len([h for h in heads.all_inner_texts() if h]) == 60)
    grid.go("B2")
    grid.press("End")
    becomes(lambda: grid.here, "BH2")
    grid.write("last")
    eventually(lambda: grid.page.locator("tbody tr").nth(1).bounding_box()["height"] < 360)
    grid.saved()
    assert read_sheets(grid.path)[0].cells[2, 60].text == "last"
    grid.go("F3")
    grid.press("F2")
    grid.page.keyboard.type(" end")
    eventually(lambda: grid.page.locator(".editor textarea").bounding_box()["height"] <= 500)
    grid.press("Enter")
    grid.saved()
    assert read_sheets(grid.path)[0].cells[3, 6].text == f"{long.strip()} end"


@pytest.mark.slow
def test_rows_go_into_a_sheet_that_is_longer_than_its_drop_downs(shelf: Books, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "rrp_sheets.web.views.sheet.MOST_DRAWN_ROWS", 100
    )  # to draw the diagram takes longer than all else
    rows = [["", "Red ball", "map", f"redBall.x + {n}", f"S{n}", ""] for n in range(210)]
    grid = shelf.open({"T": [HEADER, *rows]})
    grid.go("C5")
    grid.press("Control++")
    grid.expect("E6", "S3")
    grid.press("Control+z")
    grid.expect("E5", "S3")
    assert len(grid.rows()) == 210
