"""The grid in a real browser: keys, ranges, clipboard, rows, finding. Whole behaviours are typed in test_tasks.py."""

from __future__ import annotations

import pytest
from chromium import becomes, eventually
from grid_books import Books
from playwright.sync_api import expect


@pytest.fixture
def grid(shelf: Books):
    return shelf.open()


WAYS = [
    ("B2", "ArrowRight", "C2"), ("B2", "ArrowDown ArrowDown", "B4"), ("C3", "ArrowUp ArrowLeft", "B2"),
    ("B2", "Tab Tab", "D2"), ("C2", "Shift+Tab", "B2"), ("F2", "Tab", "A3"), ("A3", "Shift+Tab", "F2"),
    ("C2", "Enter", "C3"), ("B2", "Tab Tab Enter", "B3"), ("B2", "Tab ArrowDown Enter", "C4"),
    ("C3", "Shift+Enter", "C2"), ("D3", "Home", "A3"), ("B3", "End", "F3"), ("D4", "Control+Home", "A2"),
    ("A2", "Control+End", "F4"), ("B2", "Control+ArrowDown", "B4"), ("B4", "Control+ArrowUp", "B2"),
    ("B2", "Control+ArrowRight", "E2"), ("A2", "Control+ArrowRight", "B2"),
]  # fmt: skip


def test_keys_lead_where_they_lead_in_a_spreadsheet_and_find_replaces(grid) -> None:
    ended = []
    for start, keys, _ in WAYS:
        grid.go(start)
        grid.press(*keys.split())
        ended.append((start, keys, grid.here))
    assert ended == WAYS
    grid.go("B2")
    grid.press("Control+f")
    grid.page.keyboard.type("distance")
    grid.page.keyboard.press("Tab")
    grid.page.keyboard.type("Nearness")
    grid.page.click("[data-find=all]")
    grid.expect("B3", "Nearness")
    becomes(lambda: grid.text("E2"), "Nearness")


def test_typing_replaces_f2_edits_escape_takes_back_and_hostile_texts_are_texts(grid) -> None:
    grid.go("D3")
    grid.write("1")
    eventually(lambda: grid.text("D3") == "1" and grid.here == "D4")
    grid.go("D2")
    grid.press("F2")
    grid.write(" * 2")
    becomes(lambda: grid.text("D2"), "redBall.distance * 2")
    grid.go("D2")
    bar = grid.page.locator("#formula-bar code")
    grid.page.keyboard.type("xyz")
    expect(bar).to_have_text("xyz")
    grid.press("Escape")
    expect(bar).to_have_text("redBall.distance * 2")
    eventually(lambda: grid.text("D2") == "redBall.distance * 2" and grid.here == "D2")
    grid.go("E2")
    grid.write("<img src=x onerror=alert(1)>")
    grid.go("F2")
    grid.write('"><script>alert(1)</script>')
    grid.saved()
    grid.page.wait_for_selector("#diagram:has-text('<img')")
    becomes(lambda: grid.page.locator("tbody img, tbody script, #diagram img").count(), 0)
    becomes(lambda: grid.text("F2"), '"><script>alert(1)</script>')


def test_delete_undo_and_redo_tell_what_and_lead_there(grid) -> None:
    grid.go("D2")
    grid.press("Shift+ArrowDown", "Delete")
    assert [r[2] for r in grid.rows()] == ["", "", ""]
    grid.go("B20")
    grid.press("Control+z")
    grid.expect("D3", "distance < 0.5")
    assert grid.rows()[0][2] == "redBall.distance"
    grid.status("Undone: 2 cells from D2 on.")
    becomes(lambda: grid.here, "D2")
    grid.go("F3")
    grid.write("far away")
    grid.go("B20")
    grid.press("Control+z")
    grid.status("Undone: F3 is “near” again.")
    becomes(lambda: grid.here, "F3")
    grid.page.locator("#counts").click()  # as anywhere but in a field
    grid.press("Control+y")
    grid.status("Redone: F3 is “far away” again.")
    grid.go("A3")
    grid.press("Control+-")
    grid.expect("C3", "subscribe")
    grid.go("B9")
    grid.press("Control+z")
    grid.status("Undone: row 3 is back.")
    eventually(lambda: grid.here == "B3" and grid.text("C3") == "filter")


def test_keys_work_anywhere_but_behind_a_dialog(grid) -> None:
    for text in ("one", "two", "three"):
        grid.go("F3")
        grid.write(text)
    grid.page.locator("#grid-scroll").focus()  # around the cells
    grid.press("Control+z")
    grid.status("Undone: F3 is “two” again.")
    grid.saved()
    becomes(lambda: grid.text("F3"), "two")
    grid.page.locator("[data-do=name]").click()
    grid.page.evaluate("document.activeElement.blur()")
    grid.press("Control+z")
    grid.page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    grid.press("Control+s")
    grid.status("Everything that you enter is saved at once.")
    grid.expect("F3", "two")
    grid.write("typed", then="Control+s")
    grid.expect("F3", "typed")
    expect(grid.cell("F3")).to_be_focused()
    grid.go("B2")
    grid.press("Control+h")
    expect(grid.page.locator("#find-bar [name=find]")).to_be_focused()
    grid.press("Escape")


TSV = '"say ""hi"""\t"line 1\nline 2"\r\nplain\t\r\n'


def test_cells_are_copied_and_pasted_as_a_spreadsheet_does(grid) -> None:
    for key, address in ("c", "F3"), ("x", "E2"):  # a blank cell that is copied empties where it is pasted
        grid.go("F2")
        grid.press(f"Control+{key}")
        grid.go(address)
        grid.press("Control+v")
        becomes(lambda address=address: grid.text(address), "")
    assert [r[3] for r in grid.rows()] == ["", "Close ball", "Head tracker"]
    text = 'say "hi"\tline 1\nline 2'
    grid.page.evaluate("text => navigator.clipboard.writeText(text)", TSV)
    grid.go("D6")
    grid.press("Control+v")
    grid.saved()
    becomes(
        lambda: (grid.text("D6"), grid.text("E6"), grid.text("D7"), grid.text("E7")), (*text.split("\t"), "plain", "")
    )
    grid.press("Control+c")
    becomes(lambda: grid.page.evaluate("navigator.clipboard.readText()"), TSV.replace("\r\n", "\n"))
    grid.page.evaluate("navigator.clipboard.writeText('a\\tb\\tc')")
    grid.go("E9")
    grid.press("Control+v")
    grid.status("1 column did not fit and was skipped.")


@pytest.mark.slow
def test_texts_of_another_program_go_into_an_editor_a_selection_and_rows_past_the_end(grid) -> None:
    """The line break that ends a cell of another program is left out, and quotes are taken apart and put together."""
    for copied, becomes_text in ("near\r\n", "is near"), ("\n", "is "), ("a\nb", "is a\nb"):
        grid.page.evaluate("text => navigator.clipboard.writeText(text)", copied)
        grid.go("F9")
        grid.page.keyboard.type("is ")
        grid.press("Control+v", "Control+Enter")
        becomes(lambda: grid.text("F9"), becomes_text)
    grid.page.evaluate("navigator.clipboard.writeText('x')")
    grid.go("F2")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown", "Control+v")
    becomes(lambda: [grid.text(f"F{n}") for n in (2, 3, 4)], ["x", "x", "x"])
    grid.page.evaluate("navigator.clipboard.writeText(Array(40).fill('y').join('\\n'))")
    grid.go("F10")
    grid.press("Control+v")
    grid.expect("F49", "y")
    # quotes, line breaks of all kinds, tabs within quotes, a formula that begins with a quote, a last line break
    cells = [["a\tb", 'q"q', "l1\nl2"], ['"near" & x', "", "é日本"], ["", "", ""]]
    there = grid.page.evaluate(  # read once: no state of the page
        """async cells => {
            const { format, parse } = await import("/static/grid/clipboard.js");
            const text = format(cells);
            return [text, parse(text), parse(text.replace(/\\n$/, "")), parse(text.replaceAll("\\n", "\\r\\n")), parse('"near" & x\\tb\\n'), parse("a\\rb")];
        }""",
        cells,
    )
    assert there[1:4] == [cells, cells, cells]
    assert there[4:] == [[['"near" & x', "b"]], [["a"], ["b"]]]
    assert there[0].startswith('"a\tb"\t"q""q"\t"l1\nl2"\n')


@pytest.mark.slow
def test_cells_are_selected_filled_and_broken_into_lines_and_rows_inserted_moved_and_deleted(grid) -> None:
    grid.go("F3")
    handle = grid.page.locator(".fill-handle").bounding_box()
    target = grid.cell("F6").bounding_box()
    grid.page.mouse.move(handle["x"] + 4, handle["y"] + 4)
    grid.page.mouse.down()
    grid.page.mouse.move(target["x"] + 20, target["y"] + 10, steps=5)
    grid.page.mouse.up()
    becomes(lambda: [grid.text(f"F{n}") for n in (3, 4, 5, 6)], ["near"] * 4)
    grid.press("Control+z")
    becomes(lambda: [grid.text(f"F{n}") for n in (3, 4, 5, 6)], ["near", "", "", ""])
    grid.go("F3")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown", "Control+d")
    becomes(lambda: [grid.text(f"F{n}") for n in (3, 4, 5)], ["near"] * 3)
    grid.go("D3")
    grid.press("Shift+ ", "Delete")
    becomes(lambda: [grid.text(f"{c}3") for c in "BCDEF"], [""] * 5)
    grid.press("Control+z")
    grid.expect("C3", "filter")
    grid.go("B2")
    grid.press("PageDown")
    eventually(lambda: int(grid.here[1:]) > 10)
    grid.press("PageUp")
    becomes(lambda: grid.here, "B2")
    grid.go("F2")
    grid.page.keyboard.type("one")
    grid.press("Alt+Enter")
    grid.write("two")
    becomes(lambda: grid.text("F2"), "one\ntwo")
    grid.press("Control+a", "Delete")
    assert not any(any(row) for row in grid.rows())
    grid.press("Control+z")
    grid.expect("C2", "map")
    grid.go("D3")
    grid.press("Control++")
    grid.expect("D4", "distance < 0.5")
    grid.press("Control+-")
    grid.expect("D3", "distance < 0.5")
    grid.go("C2")
    grid.press("Alt+ArrowDown")
    grid.expect("D2", "distance < 0.5")
    assert [r[1] for r in grid.rows()] == ["filter", "map", "subscribe"]
    becomes(lambda: grid.here, "C3")


SCROLLED = "document.getElementById('grid-scroll').scrollTop"


@pytest.mark.slow
def test_the_cursor_stays_when_rows_columns_or_all_are_selected_and_deleted(grid) -> None:
    selected = grid.page.locator("td[aria-selected]")
    every = grid.page.locator("tbody tr").count() * 6
    rows = ("Shift+ ", 6), ("Control+Shift+ArrowDown", 12), ("Shift+ArrowUp", 6), ("Shift+ArrowDown", 12)
    columns = ("Control+ ", every // 6), ("Shift+ArrowRight", every // 3), ("Control+a", every)
    for steps in rows, columns:
        grid.go("C3")
        for keys, count in steps:
            grid.press(keys)
            expect(selected).to_have_count(count)
            becomes(lambda: (grid.here, grid.page.evaluate(SCROLLED)), ("C3", 0))
    grid.press("Control+-")
    becomes(lambda: (grid.here, grid.text("C3")), ("C3", ""))
    assert grid.rows() == []
    grid.press("Control+z")
    grid.expect("C3", "filter")
    for row, count, *keys in ("3", 6), ("5", 18, "Shift"), ("2", 12, "Shift"):
        grid.page.locator(f"th.number:text-is('{row}')").click(modifiers=keys)
        expect(selected).to_have_count(count)
        becomes(lambda: grid.here, "A3")
    grid.go("D2")
    grid.press("Shift+ArrowDown", "Control+-")
    becomes(lambda: (grid.here, grid.text("C2")), ("D3", "subscribe"))
    grid.type("9")
    becomes(lambda: (grid.text("D3"), grid.here), ("9", "D4"))
