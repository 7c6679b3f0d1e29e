"""The grid in a real browser: keys, ranges, clipboard, rows, suggestions, problems."""

from __future__ import annotations

from pathlib import Path

import pytest
from chromium import CHROMIUM, GridPage, browsing, serving

from rrp_sheets.workbook import read
from rrp_sheets.workbook.editing import read_sheets
from rrp_sheets.workbook.maker import make_workbook

if not CHROMIUM:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
ROWS = [
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "filter", "distance < 0.5", "Close ball", "near"],
    ["", "Close ball", "subscribe", "", "Head tracker", ""],
]


@pytest.fixture(scope="module")
def browser():
    with browsing() as found:
        yield found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    make_workbook({"T": [HEADER, *ROWS]}, tmp_path / "b.xlsx")
    make_workbook({"T": [HEADER, ["", "", "", "", "", ""]]}, tmp_path / "empty.xlsx")
    return tmp_path


@pytest.fixture
def url(folder: Path):
    with serving(folder) as address:
        yield address


@pytest.fixture
def grid(browser, url: str):
    page = GridPage(browser, url, "b.xlsx")
    yield page
    page.close()


def rows_of(path: Path) -> list[tuple[str, str, str, str]]:
    found = read(path).workbook.behaviours[0].rows
    return [(r.inputs_cell.text, r.connector.text, r.formula.text, r.output.text) for r in found]


def test_the_first_behaviour_typed_by_keyboard_alone(browser, url: str, folder: Path) -> None:
    page = GridPage(browser, url, "empty.xlsx")
    for row in ("red b", "map", "redBall.dist", "Distance"), ("dist", "fil", "distance < 0.5", "Close ball"), (
        "close", "sub", "", "head t"):  # fmt: skip
        inputs, connector, formula, output = row
        page.type(inputs, "Tab")
        page.type(connector, "Tab")
        if formula == "redBall.dist":
            page.page.keyboard.type(formula)
            page.press("Tab")  # takes the suggestion
        elif formula:
            page.page.keyboard.type(formula)
        page.press("Tab")
        page.type(output)
        page.press("Home", "ArrowRight")
    page.saved()
    assert rows_of(folder / "empty.xlsx") == [
        ("Red ball", "map", "redBall.distance", "Distance"),
        ("Distance", "filter", "distance < 0.5", "Close ball"),
        ("Close ball", "subscribe", "", "Head tracker"),
    ]
    page.page.wait_for_selector("#diagram [data-row='4']")
    assert "no problems" in page.page.inner_text(".problems")
    page.close()


@pytest.mark.parametrize(
    ("start", "keys", "end"),
    [
        ("B2", "ArrowRight", "C2"), ("B2", "ArrowDown ArrowDown", "B4"), ("C3", "ArrowUp ArrowLeft", "B2"),
        ("B2", "Tab Tab", "D2"), ("C2", "Shift+Tab", "B2"), ("F2", "Tab", "A3"), ("A3", "Shift+Tab", "F2"),
        ("C2", "Enter", "C3"), ("B2", "Tab Tab Enter", "B3"), ("B2", "Tab ArrowDown Enter", "C4"), ("C3", "Shift+Enter", "C2"), ("D3", "Home", "A3"), ("B3", "End", "F3"),
        ("D4", "Control+Home", "A2"), ("A2", "Control+End", "F4"), ("B2", "Control+ArrowDown", "B4"),
        ("B4", "Control+ArrowUp", "B2"), ("B2", "Control+ArrowRight", "E2"), ("A2", "Control+ArrowRight", "B2"),
    ],
)  # fmt: skip
def test_keys_lead_where_they_lead_in_a_spreadsheet(grid: GridPage, start: str, keys: str, end: str) -> None:
    grid.go(start)
    grid.press(*keys.split())
    assert grid.here == end


def test_typing_replaces_f2_edits_escape_takes_back(grid: GridPage) -> None:
    grid.go("D3")
    grid.type("1")
    assert grid.text("D3") == "1" and grid.here == "D4"
    grid.go("D2")
    grid.press("F2")
    grid.type(" * 2")
    assert grid.text("D2") == "redBall.distance * 2"
    grid.go("D2")
    grid.page.keyboard.type("xyz")
    grid.press("Escape")
    assert grid.text("D2") == "redBall.distance * 2" and grid.here == "D2"


def test_delete_undo_and_redo(grid: GridPage, folder: Path) -> None:
    grid.go("D2")
    grid.press("Shift+ArrowDown", "Delete")
    grid.saved()
    assert [r[2] for r in rows_of(folder / "b.xlsx")] == ["", "", ""]
    grid.press("Control+z")
    grid.expect("D3", "distance < 0.5")
    grid.saved()
    assert rows_of(folder / "b.xlsx")[0][2] == "redBall.distance"
    grid.press("Control+y")
    grid.saved()
    assert [r[2] for r in rows_of(folder / "b.xlsx")] == ["", "", ""]


def test_cells_are_copied_and_pasted_as_a_spreadsheet_does(grid: GridPage, folder: Path) -> None:
    text = 'say "hi"\tline 1\nline 2'
    grid.page.evaluate("text => navigator.clipboard.writeText(text)", '"say ""hi"""\t"line 1\nline 2"\r\nplain\t\r\n')
    grid.go("D6")
    grid.press("Control+v")
    grid.saved()
    assert (grid.text("D6"), grid.text("E6"), grid.text("D7"), grid.text("E7")) == (*text.split("\t"), "plain", "")
    grid.press("Control+c")
    copied = grid.page.evaluate("navigator.clipboard.readText()")
    assert copied.replace("\r\n", "\n") == '"say ""hi"""\t"line 1\nline 2"\nplain\t'


def test_one_value_fills_a_whole_selection_and_pasting_past_the_end_adds_rows(grid: GridPage) -> None:
    grid.page.evaluate("navigator.clipboard.writeText('x')")
    grid.go("F2")
    grid.press("Shift+ArrowDown", "Shift+ArrowDown", "Control+v")
    assert [grid.text(f"F{n}") for n in (2, 3, 4)] == ["x", "x", "x"]
    grid.page.evaluate("navigator.clipboard.writeText(Array(40).fill('y').join('\\n'))")
    grid.go("F5")
    grid.press("Control+v")
    grid.expect("F44", "y")


def test_rows_are_inserted_moved_duplicated_and_deleted(grid: GridPage, folder: Path) -> None:
    grid.go("D3")
    grid.press("Control++")
    grid.expect("D4", "distance < 0.5")
    grid.press("Control+-")
    grid.expect("D3", "distance < 0.5")
    grid.go("C2")
    grid.press("Alt+ArrowDown")
    grid.expect("D2", "distance < 0.5")
    grid.saved()
    assert [r[1] for r in rows_of(folder / "b.xlsx")] == ["filter", "map", "subscribe"]
    assert grid.here == "C3"


def test_the_fill_handle_repeats_the_selection(grid: GridPage) -> None:
    grid.go("F3")
    handle = grid.page.locator(".fill-handle").bounding_box()
    target = grid.cell("F6").bounding_box()
    grid.page.mouse.move(handle["x"] + 4, handle["y"] + 4)
    grid.page.mouse.down()
    grid.page.mouse.move(target["x"] + 20, target["y"] + 10, steps=5)
    grid.page.mouse.up()
    assert [grid.text(f"F{n}") for n in (3, 4, 5, 6)] == ["near"] * 4


def test_a_problem_is_told_at_its_cell_and_leads_there(grid: GridPage) -> None:
    grid.go("D3")
    grid.type("distence < 0.5")
    grid.page.wait_for_selector("td[aria-invalid=true]:has-text('distence')")
    cell = grid.cell("D3")
    described = cell.get_attribute("aria-describedby")
    assert "Did you mean distance" in grid.page.inner_text(f"#{described.split()[0]}")
    grid.go("B2")
    grid.page.wait_for_selector(".problem-list a")
    grid.page.click(".problem-list a")
    assert grid.here == "D3"
    grid.type("distance < 0.5")
    grid.page.wait_for_selector("td[aria-invalid=true]", state="detached")


def test_the_diagram_follows_and_leads_to_its_row(grid: GridPage) -> None:
    grid.go("D3")
    grid.type("distance < 0.25")
    grid.page.wait_for_selector("#diagram text:text('0.25')")
    grid.page.locator("#diagram [data-row='4']").click()
    assert grid.here == "C4"
    assert grid.page.locator("#diagram .here").get_attribute("data-row") == "4"


def test_examples_stand_beside_the_rows(grid: GridPage) -> None:
    assert grid.page.inner_text("tbody tr:nth-child(1) .example") == "0.5 m"


def test_suggestions_tell_fields_with_their_help(grid: GridPage) -> None:
    grid.go("D2")
    grid.page.keyboard.type("redBall.")
    options = grid.page.locator("[role=option]").all_inner_texts()
    assert any(o.startswith("distance") and "(m)" in o for o in options)
    grid.press("Escape", "Escape")


def test_find_and_replace(grid: GridPage) -> None:
    grid.go("B2")
    grid.press("Control+f")
    grid.page.keyboard.type("distance")
    grid.page.keyboard.press("Tab")
    grid.page.keyboard.type("Nearness")
    grid.page.click("[data-find=all]")
    grid.expect("B3", "Nearness")
    assert grid.text("E2") == "Nearness"


def test_hostile_texts_are_texts(grid: GridPage) -> None:
    grid.go("E2")
    grid.type("<img src=x onerror=alert(1)>")
    grid.go("F2")
    grid.type('"><script>alert(1)</script>')
    grid.saved()
    grid.page.wait_for_timeout(500)
    assert grid.page.locator("tbody img, tbody script, #diagram img").count() == 0
    assert grid.text("F2") == '"><script>alert(1)</script>'


# ---- several people


def test_what_one_types_the_other_sees(browser, url: str) -> None:
    aya, mika = (GridPage(browser, url, "b.xlsx", name=n) for n in ("Aya", "Mika"))
    aya.go("F4")
    aya.type("from Aya")
    mika.expect("F4", "from Aya")
    aya.close()
    mika.close()


def test_a_cell_under_edit_survives_rows_inserted_above(browser, url: str, folder: Path) -> None:
    aya, mika = (GridPage(browser, url, "b.xlsx", name=n) for n in ("Aya", "Mika"))
    aya.go("F4")
    aya.page.keyboard.type("half a")
    mika.go("B2")
    mika.press("Control++")
    aya.page.wait_for_selector("tbody tr:nth-child(5)[aria-rowindex='6']")
    aya.page.keyboard.type(" note")
    aya.press("Enter")
    mika.expect("F5", "half a note")
    aya.close()
    mika.close()


def test_a_cell_that_someone_edits_is_shown_as_taken(browser, url: str) -> None:
    aya, mika = (GridPage(browser, url, "b.xlsx", name=n) for n in ("Aya", "Mika"))
    aya.go("F4")
    aya.page.keyboard.type("I am")
    mika.page.wait_for_selector("td.taken:has-text('Aya is editing')")
    aya.press("Escape")
    mika.page.wait_for_selector("td.taken", state="detached")
    aya.close()
    mika.close()


def test_when_somebody_was_quicker_both_texts_are_shown_and_one_is_chosen(browser, url: str, folder: Path) -> None:
    aya, mika = (GridPage(browser, url, "b.xlsx", name=n) for n in ("Aya", "Mika"))
    for keep, left in ("Keep theirs", "of Mika"), ("Keep mine", "of Aya"):
        aya.page.route("**/cells", lambda route: route.abort())  # the line is down while Mika types
        aya.go("F4")
        aya.type("of Aya")
        aya.page.wait_for_selector("#status:has-text('kept here')")
        mika.go("F4")
        mika.type("of Mika")
        mika.saved()
        aya.page.unroute("**/cells")
        dialog = aya.page.wait_for_selector("dialog")
        text = dialog.inner_text()
        assert "of Aya" in text and "of Mika" in text and "F4: Mika has changed this cell" in text
        aya.page.click(f"dialog button:text-is('{keep}')")
        for page in (aya, mika):
            page.expect("F4", left)
        mika.go("F4")
        mika.type("x")
        aya.expect("F4", "x")
    aya.close()
    mika.close()


def test_one_gives_oneself_a_name_and_others_see_where_one_is(browser, url: str) -> None:
    aya, mika = GridPage(browser, url, "b.xlsx"), GridPage(browser, url, "b.xlsx", name="Mika")
    aya.page.click("[data-do=name]")
    aya.page.keyboard.type("<b>Aya")
    aya.page.keyboard.press("Enter")
    aya.go("D3")
    mika.page.wait_for_selector("#people:has-text('<b>Aya (D3) is here too')")
    mika.page.wait_for_selector("td.formula[data-who='<b>Aya']")
    aya.close()
    mika.close()


def test_two_browsers_fill_200_cells_at_once_and_nothing_is_lost(browser, url: str, folder: Path) -> None:
    aya, mika = (GridPage(browser, url, "b.xlsx", name=n) for n in ("Aya", "Mika"))
    fill = """([letter, who]) => {
        const at = document.querySelector(`thead th[data-letter='${letter}']`).cellIndex;
        const rows = [...document.querySelectorAll("tbody tr")].slice(3, 23);
        const transfer = (cell, text) => {
            cell.dispatchEvent(new PointerEvent("pointerdown", { bubbles: true, button: 0 }));
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
    sheet = read_sheets(folder / "b.xlsx")[0]
    assert [(sheet.cells[n, 4].typed, sheet.cells[n, 6].typed) for n in range(5, 25)] == screens[0]
    aya.close()
    mika.close()


# ---- mending


def test_a_fix_is_applied_by_its_button_and_taken_back(grid: GridPage) -> None:
    grid.go("D3")
    grid.type("distence < 0.5")
    button = grid.page.wait_for_selector(".problem-list [data-fix]")
    assert button.inner_text().startswith("Apply fix: ")
    button.click()
    grid.expect("D3", "distance < 0.5")
    grid.page.wait_for_selector("#status:has-text('Ctrl+Z takes it back')")
    grid.go("D3")
    grid.press("Control+z")
    grid.expect("D3", "distence < 0.5")


# ---- other ways than the keyboard


FIRST = [
    ("Red ball", "map", "redBall.distance", "Distance"), ("Distance", "filter", "distance < 0.5", "Close ball"),
    ("Close ball", "subscribe", "", "Head tracker"),
]  # fmt: skip


def open_cell(page: GridPage, letter: str, number: int, touch: bool) -> None:
    """Open a cell's editor; again when a message has come or gone above it just then."""
    for _ in range(5):
        cell = page.cell(f"{letter}{number}")
        if touch:
            cell.tap(position={"x": 6, "y": 6})  # the first tap selects, unless the cursor is there already
            if not page.page.locator(".editor textarea").count():
                cell.tap(position={"x": 6, "y": 6})
        else:
            cell.dblclick(position={"x": 6, "y": 6})
        page.page.wait_for_timeout(100)
        label = page.page.locator(".editor textarea").get_attribute("aria-label") or ""
        if label.endswith(f", row {number}"):
            return
        page.page.keyboard.press("Escape")
    raise AssertionError(f"{letter}{number} cannot be opened")


@pytest.mark.parametrize("touch", [True, False], ids=["touch", "mouse"])
def test_the_first_behaviour_without_keys_that_move(browser, url: str, folder: Path, touch: bool) -> None:
    page = GridPage(browser, url, "empty.xlsx", has_touch=touch)
    for number, row in enumerate(FIRST, 2):
        for letter, text in zip("BCDE", row, strict=True):
            if not text:
                continue
            open_cell(page, letter, number, touch)
            page.page.keyboard.insert_text(text[:2])
            option = page.page.locator("[role=option]").filter(has_text=text).first
            if letter in "BC" or text == "Head tracker":
                option.tap() if touch else option.click()
            else:
                page.page.keyboard.insert_text(text[2:])
    page.cell("F9").tap() if touch else page.go("F9")
    page.saved()
    assert rows_of(folder / "empty.xlsx") == FIRST
    page.close()
