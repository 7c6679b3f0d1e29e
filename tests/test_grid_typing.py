"""Typed text goes where the person sees it: while answers are slow, while others edit, and while the file changes."""

from __future__ import annotations

import random
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, requests_of, until
from grid_books import ROWS, Books, Shared
from playwright.sync_api import expect
from slow_answers import EDITS, SlowAnswers

from rrp_sheets.workbook.edits import DeleteRows, InsertRows, SetCell
from rrp_sheets.workbook.files import edit, read_sheets

EDITOR = ".editor textarea"
BLANK_ROWS = 20
ROWS_PASTED = 220  # more than FIRST_ROWS, and than one body of the table


def texts(path: Path, sheet: str = "T") -> list[tuple[str, ...]]:
    """Texts of the rows of a sheet, blank ones too, up to the last filled one."""
    (found,) = (s for s in read_sheets(path) if s.name == sheet)
    last = max((row for row, _ in found.cells), default=1)
    return [
        tuple(found.cells[n, c].typed if (n, c) in found.cells else "" for c in range(1, 7)) for n in range(2, last + 1)
    ]


def outside(grid: Shared, *edits: Any) -> None:
    """Another program writes the file, and the server sees it."""
    grid.saved()
    edit(grid.path, list(edits))
    assert grid.page.request.get(grid.page.url).ok


# ---- another program changes the file


@pytest.mark.slow
def test_an_editor_and_a_selection_stay_with_their_rows_while_another_program_changes_the_file(shelf: Books) -> None:
    grid = shelf.open()
    grid.go("B7")
    grid.page.keyboard.type("Gree")
    outside(grid, SetCell("T", 2, 6, "by Excel"))
    grid.expect("F2", "by Excel")
    grid.page.keyboard.type("n ball")
    expect(grid.page.locator(EDITOR)).to_have_value("Green ball")
    grid.press("Tab")
    grid.type("map")
    grid.expect("B7", "Green ball")
    grid.saved()
    found = texts(grid.path)
    assert found[0] == ("", "Red ball", "map", "redBall.distance", "Distance", "by Excel")
    assert found[5] == ("", "Green ball", "map", "", "", "")
    grid.go("F3")  # the editor goes with its row, and keeps its selected text
    grid.press("F2")
    grid.page.locator(EDITOR).evaluate("field => field.setSelectionRange(1, 3)")
    outside(grid, InsertRows("T", 2, 2), SetCell("T", 2, 6, "new"), SetCell("T", 5, 4, "distance < 0.7"))
    grid.expect("D5", "distance < 0.7")
    becomes(lambda: grid.here, "F5")
    grid.page.keyboard.type("ev")
    grid.press("Enter")
    grid.saved()
    assert [row[5] for row in texts(grid.path)] == ["new", "", "by Excel", "nevr", "", "", "", ""]
    grid.go("B5")  # a selection goes with its rows
    grid.press("Shift+ArrowRight", "Shift+ArrowDown")
    outside(grid, DeleteRows("T", 4, 1))
    grid.expect("C4", "filter")
    becomes(lambda: grid.here, "C5")
    selected = grid.page.locator("td[aria-selected]")
    expect(selected).to_have_count(4)
    grid.press("Delete")
    grid.saved()
    assert [row[1:3] for row in texts(grid.path)][2:4] == [("", ""), ("", "")]
    grid.go("F4")  # a text whose row is deleted can be copied
    grid.page.keyboard.type("not to be lost")
    outside(grid, DeleteRows("T", 4, 1))
    grid.expect("E4", "Head tracker")
    grid.page.keyboard.type("!")
    grid.press("Enter")
    expect(grid.page.locator("dialog textarea")).to_have_value("not to be lost!")
    assert not grid.errors


# ---- answers are slow


def insert_above(grid: Shared) -> None:
    grid.press("Control++")


@pytest.mark.slow
def test_keys_after_insert_above_go_into_the_new_row_and_can_be_copied_when_it_is_refused(shelf: Books) -> None:
    grid = shelf.open()
    with SlowAnswers(grid.page) as slow:
        grid.go("B3")
        insert_above(grid)
        for text in ("Face", "map", "1", "Name"):
            grid.type(text, "Tab")
        becomes(lambda: (grid.text("B3"), grid.text("B4")), ("Face", "Distance"))
        slow.release()
    made = texts(grid.path)
    assert [row[1:5] for row in made][1:3] == [("Face", "map", "1", "Name"), tuple(ROWS[1][1:5])]
    with SlowAnswers(grid.page) as slow:
        grid.go("B4")
        insert_above(grid)
        grid.type("Second face")
        grid.expect("B4", "Second face")
        slow.refuse("The file is open in Excel.")
        slow.settle()
    grid.expect("B4", "Distance")
    expect(grid.page.locator("dialog textarea")).to_have_value("Second face")
    grid.saved()
    assert [row[1] for row in texts(grid.path)] == [row[1] for row in made]


def note(grid: Shared, text: str) -> None:
    """Save a text in F3."""
    grid.go("F3")
    grid.type(text)
    grid.saved()


@pytest.mark.slow
def test_what_is_for_the_grid_waits_for_what_an_undo_brings_back(shelf: Books) -> None:
    grid = shelf.open()
    note(grid, "far")
    with SlowAnswers(grid.page) as slow:
        grid.go("B6")
        grid.press("Control+z")
        grid.type("very close")
        grid.type("below")
        becomes(lambda: (grid.text("F3"), grid.text("B6")), ("far", ""))
        slow.release()
    grid.expect("F3", "very close")
    grid.expect("F4", "below")
    becomes(lambda: grid.text("B6"), "")
    note(grid, "a note")
    with SlowAnswers(grid.page) as slow:
        grid.press("Control+z", "ArrowLeft", "ArrowLeft")
        grid.page.keyboard.type("x")  # in a formula, where an arrow moves within the text
        grid.page.evaluate(CHOOSE, "Fill down")  # a menu that waits ends the edit before it
        grid.press("ArrowLeft")
        grid.type("map")
        slow.release()
    assert texts(grid.path)[1][2:4] == ("map", "redBall.distance"), "filled from the row above, after the edit"
    note(grid, "far")
    with SlowAnswers(grid.page) as slow:
        grid.press("Control+z")
        grid.type("quite close")
        grid.page.keyboard.type("and")
        grid.page.evaluate("import('/static/grid/dialog.js').then(({ open }) => open('Question', []))")
        until(grid.page, lambda: slow.asked)
    grid.expect("F3", "very close")
    expect(grid.page.locator("#saved")).to_have_text("Saving …")  # until the dialog is closed, too
    grid.press("Escape")
    grid.expect("F3", "quite close")
    expect(grid.page.locator(EDITOR)).to_have_value("and")
    grid.press("Enter")
    becomes(lambda: grid.here, "F5")
    expect(grid.page.locator("#saved")).to_have_text("Saved")
    note(grid, "far")
    with SlowAnswers(grid.page) as slow:  # what is not for the grid does not wait
        grid.page.get_by_role("button", name="Undo").click()
        grid.page.locator("[data-do=find]").press("Enter")
        grid.page.keyboard.type("Di")
        expect(grid.page.locator("#find-bar [name=find]")).to_have_value("Di")
        grid.press("Escape")
        grid.page.locator("[data-do=undo]").focus()
        grid.press("n", "o", "Tab")
        grid.page.mouse.click(*centre(grid, "E4"))
        grid.page.evaluate(PASTE, "pasted")
        becomes(lambda: grid.text("F3"), "far")
        slow.release()
    grid.expect("E4", "pasted")
    becomes(lambda: (texts(grid.path)[1][5], grid.here), ("no", "E4"))


@pytest.mark.slow
def test_no_draft_stays_of_what_waited_while_the_sheet_was_given_another_name(shelf: Books) -> None:
    grid, mika = shelf.two()
    grid.go("F3")
    grid.type("far")
    grid.saved()
    with SlowAnswers(grid.page) as slow:
        grid.press("Control+z")
        grid.type("very close")
        mika.page.dblclick("#tabs a[aria-current]")
        mika.page.locator("dialog[open] input").fill("Other")
        mika.press("Enter")
        expect(grid.page.locator("#tabs a[aria-current]")).to_have_text("Other")
        slow.release()
    grid.expect("F3", "very close")
    grid.saved()
    becomes(lambda: grid.page.evaluate("Object.keys(sessionStorage).filter(k => k.startsWith('drafts:'))"), [])


def centre(grid: Shared, address: str) -> tuple[float, float]:
    box = grid.cell(address).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.mark.slow
def test_rows_of_two_people_and_another_program_come_to_the_same_order_whatever_arrives_first(shelf: Books) -> None:
    """Aya's answer comes before what Mika did earlier, and after what Mika did later."""
    aya, mika = shelf.two()
    with SlowAnswers(aya.page) as slow:
        mika.go("B3")
        insert_above(mika)
        mika.type("M1")
        mika.saved()
        aya.go("B3")
        insert_above(aya)
        aya.type("A1")
        slow.settle()
        mika.go("B3")
        insert_above(mika)
        mika.type("M2")
        mika.saved()
        slow.events()
    wanted = [row[1] for row in texts(aya.path)]
    assert sorted(wanted) == sorted(["M1", "A1", "M2", *(row[1] for row in ROWS)])
    for page in (aya, mika):
        for number, text in enumerate(wanted, 2):
            page.expect(f"B{number}", text)
    aya.go("B3")  # an undo that would delete what another has typed is refused, and the keys after it count
    insert_above(aya)
    aya.saved()
    mika.expect("B4", wanted[1])
    mika.go("F3")
    mika.type("theirs")
    mika.saved()
    with SlowAnswers(aya.page) as slow:
        aya.press("Control+z", "ArrowRight")
        aya.type("map")
        slow.release()
        aya.status("Mika has changed row 3 since")
    assert texts(aya.path)[1] == ("", "", "map", "", "", "theirs")
    mika.expect("C3", "map")
    mika.go("F4")
    mika.page.keyboard.type("mine")
    edit(aya.path, [SetCell("T", 2, 6, "by Excel"), InsertRows("T", 3, 1)])
    mika.press("Enter")  # before the server has looked at the file by itself, on an idle machine
    for page in (aya, mika):
        page.expect("F2", "by Excel")
        page.expect("F4", "theirs")
        page.expect("F5", "mine")


@pytest.mark.slow
def test_two_who_edit_the_same_cell_are_both_heard_however_late_the_answers(shelf: Books) -> None:
    aya, mika = shelf.two()
    with SlowAnswers(aya.page) as slow:
        mika.go("F3")
        mika.page.keyboard.type("from M")
        mika.page.wait_for_selector(".editor")
        mika.page.wait_for_function(
            "() => performance.getEntriesByType('resource').some((e) => e.name.endsWith('/lock'))"
        )
        aya.go("F3")
        aya.page.keyboard.type("from A")
        for _ in ("request", "answer"):
            until(aya.page, slow.step)
        aya.status("Mika is editing this cell")
        aya.page.keyboard.type("ya")
        mika.page.keyboard.type("ika")
        mika.press("Enter")
        mika.saved()
        aya.press("Enter")
        slow.release()
        expect(aya.page.locator("dialog[open]")).to_contain_text("from Mika")
        expect(aya.page.locator("dialog[open]")).to_contain_text("from Aya")


@pytest.mark.slow
def test_hundreds_of_rows_are_pasted_and_gone_on_below_before_any_answer(shelf: Books) -> None:
    grid = shelf.open()
    grid.go("B5")
    with SlowAnswers(grid.page) as slow:
        grid.page.evaluate(PASTE, "\n".join(f"S{n}\tmap" for n in range(ROWS_PASTED)) + "\n")
        grid.press("Control+End", "Enter")
        grid.type("the end")
        grid.page.evaluate(CHOOSE, "Insert above")
        grid.type("after it")
        slow.release()
    found = texts(grid.path)
    assert (found[3][1], found[ROWS_PASTED + 2][1], len(found)) == ("S0", f"S{ROWS_PASTED - 1}", ROWS_PASTED + 5)
    assert (found[-2][5], found[-1][5]) == ("the end", "after it")


# ---- there is always room below


def room(grid: Shared) -> int:
    return int(
        grid.page.evaluate("""() => {
      const rows = [...document.querySelectorAll("#grid-scroll tbody tr")];
      return rows.length - 1 - rows.findLastIndex((row) => row.querySelector("td[data-v]"));
    }""")
    )


def test_there_are_blank_rows_below_whatever_is_filled(shelf: Books) -> None:
    grid = shelf.open()
    grid.go("F20")
    with SlowAnswers(grid.page) as slow:
        grid.page.evaluate(PASTE, "y\n" * 30)
        assert room(grid) >= BLANK_ROWS
        grid.press("Control+End", "Enter")
        grid.type("below")
        grid.press("Shift+Enter", "Alt+ArrowDown")
        slow.release()
    grid.expect("F51", "below")
    for _ in range(2):
        assert room(grid) >= BLANK_ROWS
        grid.press("Control+End", "Alt+ArrowDown", "ArrowDown", "Control+-")
        grid.saved()
    assert room(grid) >= BLANK_ROWS
    outside(grid, SetCell("T", 75, 6, "far below"))
    grid.expect("F75", "far below")
    assert room(grid) >= BLANK_ROWS
    grid.page.reload()
    grid.expect("F75", "far below")
    assert room(grid) >= BLANK_ROWS


# ---- the page goes while something is typed

DIALOG = "dialog[aria-label='You were typing']"


def elsewhere(shelf: Books) -> str:
    """The address of a page on which nothing is typed; the shelf would draw all workbooks."""
    return f"{shelf.url}/help"


def typing(grid: Shared, cell: str, text: str) -> None:
    grid.go(cell)
    grid.page.keyboard.type(text)
    expect(grid.page.locator(EDITOR)).to_have_value(text)


def away(grid: Shared, shelf: Books, cell: str, text: str) -> None:
    """Type into a cell and leave the page."""
    typing(grid, cell, text)
    grid.page.goto(elsewhere(shelf))


@pytest.mark.slow
def test_what_is_typed_survives_a_reload_and_others_see_the_cell_free_when_its_page_closes(shelf: Books) -> None:
    aya, mika = shelf.two()
    typing(aya, "F4", "half a no")
    mika.page.wait_for_selector("td.taken:has-text('Aya is editing')")
    aya.page.evaluate("() => window.fetch = () => new Promise(() => {})")  # nobody is told that the page goes
    aya.page.reload()
    expect(aya.page.locator(f"{DIALOG} textarea")).to_have_value("half a no")
    expect(aya.page.locator(".name-tag")).to_have_count(0)
    mika.page.wait_for_selector("td.taken", state="detached")
    aya.page.get_by_role("button", name="Continue typing").click()
    mika.page.wait_for_selector("td.taken:has-text('Aya is editing')")
    aya.page.keyboard.type("te")
    aya.press("Enter")
    mika.expect("F4", "half a note")
    aya.saved()
    aya.page.reload()
    aya.page.wait_for_selector("body[data-ready]")
    expect(aya.page.locator(DIALOG)).to_have_count(0)
    typing(aya, "F4", "half")
    mika.page.wait_for_selector("td.taken:has-text('Aya is editing')")
    aya.page.evaluate("() => window.fetch = () => new Promise(() => {})")
    aya.page.goto("about:blank")
    mika.page.wait_for_selector("td.taken", state="detached")


@pytest.mark.slow
def test_what_is_typed_survives_going_back_and_a_crash_and_is_thrown_away_when_asked(shelf: Books) -> None:
    grid = shelf.open()
    away(grid, shelf, "F4", "half")
    grid.page.go_back()
    expect(grid.page.locator(f"{DIALOG} textarea")).to_have_value("half")
    grid.page.get_by_role("button", name="Discard").click()
    grid.page.reload()
    grid.page.wait_for_selector("body[data-ready]")
    expect(grid.page.locator(DIALOG)).to_have_count(0)
    becomes(lambda: grid.text("F4"), "")
    typing(grid, "F4", "half")
    kept = grid.page.evaluate("() => ({ ...sessionStorage })")
    grid.press("Escape")
    grid.page.goto(elsewhere(shelf))
    grid.page.evaluate(
        "kept => { for (const [name, text] of Object.entries(kept)) sessionStorage.setItem(name, text); }", kept
    )
    grid.page.go_back()
    expect(grid.page.locator(f"{DIALOG} textarea")).to_have_value("half")
    grid.page.get_by_role("button", name="Discard").click()
    becomes(lambda: grid.page.evaluate("Object.keys(sessionStorage).filter(k => k.startsWith('drafts:'))"), [])


@pytest.mark.slow
def test_what_waits_behind_an_undo_is_among_what_is_not_saved_and_offered_after_a_reload(shelf: Books) -> None:
    grid = shelf.open()
    note(grid, "far")
    grid.page.route("**/undo", lambda route: route.abort())
    grid.press("Control+z")
    grid.type("important")
    grid.page.keyboard.type("twoo")
    grid.press("Backspace")
    grid.type(" lines", "Alt+Enter")
    grid.page.evaluate(PASTE, "pasted")
    expect(grid.page.locator(".unsent b")).to_have_text("3 changes are not saved.")
    grid.page.get_by_role("button", name="Show changes").click()
    dialog = grid.page.get_by_label("Changes that are not saved")
    expect(dialog.locator("textarea")).to_have_value("Undo\nimportant\ntwo lines\npasted")
    dialog.get_by_role("button", name="Close").click()
    grid.page.reload()
    expect(grid.page.locator(f"{DIALOG} textarea")).to_have_value("important\ntwo lines\npasted")
    expect(grid.page.locator(DIALOG)).to_contain_text("it is not saved. Copy your text")
    grid.page.locator(DIALOG).get_by_role("button", name="Close").click()
    grid.page.unroute("**/undo")
    grid.expect("F3", "near")
    grid.saved()
    grid.page.reload()
    grid.page.wait_for_selector("body[data-ready]")
    expect(grid.page.locator(DIALOG)).to_have_count(0)


@pytest.mark.slow
def test_a_draft_meets_a_changed_cell_or_a_deleted_row(shelf: Books) -> None:
    aya, mika = shelf.two()
    away(aya, shelf, "F3", "mine")
    mika.go("F3")
    mika.type("theirs")
    mika.saved()
    aya.page.go_back()
    aya.page.get_by_role("button", name="Continue typing").click()
    aya.press("Enter")
    expect(aya.page.locator("dialog[open]")).to_contain_text("Somebody else was quicker")
    aya.page.get_by_role("button", name="Keep theirs").click()
    aya.saved()
    away(aya, shelf, "F4", "not to be lost")
    mika.go("B4")
    mika.press("Control+-")
    mika.saved()
    aya.page.go_back()
    expect(aya.page.locator(f"{DIALOG} textarea")).to_have_value("not to be lost")
    expect(aya.page.locator(DIALOG)).to_contain_text("F4, and its row has been deleted")
    expect(aya.page.get_by_role("button", name="Continue typing")).to_have_count(0)


@pytest.mark.slow
def test_a_duplicated_tab_is_another_page_and_does_not_offer_what_the_first_one_types(shelf: Books) -> None:
    grid = shelf.open()
    typing(grid, "F4", "half")
    with grid.context.expect_page() as opened:
        grid.page.evaluate(
            "() => { window.open(location.href); }"
        )  # takes the session's storage along, as a duplicate does
    other = opened.value
    try:
        other.wait_for_selector("td.taken:has-text('Somebody is editing')")
        other.wait_for_function("() => !Object.keys(sessionStorage).some((name) => name.startsWith('drafts:'))")
        expect(other.locator(DIALOG)).to_have_count(0)
        grid.page.keyboard.type(" a note")
        grid.press("Enter")
        grid.saved()
    finally:
        other.close()
    becomes(lambda: grid.text("F4"), "half a note")


# ---- the property: whatever the order of the answers, the file is as if there were no delay

WORDS = ("Face", "q 1", "0.5", "two words", "Näh", "x")
KEYS = ("Enter", "Tab", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Shift+Enter", "Shift+Tab")
MENU = ("Insert above", "Insert below", "Duplicate", "Move up", "Move down", "Delete rows", "Fill down")
CHOOSE = """name => {
  document.querySelector("[data-do=rows]").click();
  [...document.querySelectorAll("[role=menuitem]")].find((item) => item.textContent.startsWith(name)).click();
}"""
PASTE = """text => {
  const clipboardData = new DataTransfer();
  clipboardData.setData("text/plain", text);
  document.activeElement.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
}"""
Action = tuple[str, Any]


def drawn_action(drawn: random.Random) -> Action:
    """Something that a person does."""
    kind = drawn.choices(
        ("type", "key", "menu", "undo", "redo", "paste", "clear", "select", "edit", "insert"),
        (8, 8, 5, 2, 1, 2, 1, 2, 1, 2),
    )[0]
    if kind == "type":
        return kind, (drawn.choice(WORDS), drawn.choice(KEYS[:6]))
    if kind == "key":
        return kind, drawn.choice(KEYS)
    if kind == "menu":
        return kind, drawn.choice(MENU)
    if kind == "paste":
        rows = drawn.choice((1, 2, 3, 30))
        return kind, "\n".join("\t".join(drawn.choice(WORDS) for _ in range(2)) for _ in range(rows)) + "\n"
    if kind == "select":
        return kind, drawn.choice(("Shift+ArrowDown", "Shift+ArrowUp", "Shift+ArrowRight"))
    return kind, drawn.choice(WORDS)


def do(grid: Shared, action: Action) -> None:
    kind, value = action
    if kind == "type":
        grid.page.keyboard.type(value[0])
        grid.press(value[1])
    elif kind in ("key", "select"):
        grid.press(value)
    elif kind == "menu":
        grid.page.evaluate(CHOOSE, value)
    elif kind == "paste":
        grid.page.evaluate(PASTE, value)
    elif kind == "edit":
        grid.press("F2", "Home")
        grid.page.keyboard.type(value)
        grid.press("Delete", "Enter")
    else:
        grid.press({"undo": "Control+z", "redo": "Control+y", "clear": "Delete", "insert": "Control++"}[kind])


def same_words(grid: Shared) -> Shared:
    """Suggestions do not depend on when the check has ended."""
    grid.page.evaluate(
        "() => document.querySelector('#listen').addEventListener('checked', (e) => e.stopImmediatePropagation(), true)"
    )
    return grid


def shown(grid: Shared) -> list[list[str]]:
    """Texts that the page shows, blank rows at the end left out."""
    script = """() => [...document.querySelectorAll("#grid-scroll tbody tr")].map((row) =>
      [...row.cells].filter((cell) => !cell.matches("th, .example")).map((cell) => cell.dataset.v ?? ""))"""
    rows = [list(row) for row in grid.page.evaluate(script)]
    while rows and not any(rows[-1]):
        rows.pop()
    return rows


def compared(slow: Shared, plain: Shared, answers: SlowAnswers, seed: int, count: int, rounds: int) -> None:
    """Do the same on both pages, on one of them with answers that are held; the files are the same after each round."""
    drawn = random.Random(seed)
    done: list[Action] = []
    for _ in range(rounds):
        for _ in range(count):
            action = drawn_action(drawn)
            done.append(action)
            do(plain, action)
            plain.saved()
            do(slow, action)
            answers.draw(drawn)
        answers.release()
        told = f"seed {seed}: {done}"
        assert texts(slow.path) == texts(plain.path), told
        assert shown(slow) == shown(plain), told
        becomes(lambda: slow.here == plain.here, True, told)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "count"), [(None, 10), *(pytest.param(seed, 14, marks=pytest.mark.soak) for seed in range(10))]
)
def test_any_sequence_with_held_answers_gives_the_file_of_the_same_without_delay(
    shelf: Books, seed: int | None, count: int
) -> None:
    seed = date.today().toordinal() if seed is None else seed  # another sequence each day
    slow, plain = (same_words(shelf.open(name=name)) for name in ("Slow", "Plain"))
    for page in (slow, plain):
        page.go("B3")
    with SlowAnswers(slow.page) as answers:
        compared(slow, plain, answers, seed, count, rounds=2)


LATE = """seed => {
  let state = seed + 1;
  const late = () => new Promise((done) => setTimeout(done, (state = (state * 48271) % 2147483647) % 1000));
  const send = window.fetch.bind(window);
  window.fetch = async (address, ...more) => {
    await late();
    const answer = await send(address, ...more);
    await late();
    return answer;
  };
}"""


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(100, 120))
def test_any_sequence_with_answers_up_to_two_seconds_late_gives_the_same_file(shelf: Books, seed: int) -> None:
    late, plain = (same_words(shelf.open(name=name)) for name in ("Slow", "Plain"))
    late.page.evaluate(LATE, seed)
    for page in (late, plain):
        page.go("B3")
    drawn = random.Random(seed)
    actions = [drawn_action(drawn) for _ in range(20)]
    for action in actions:
        do(plain, action)
        plain.saved()
    for action in actions:
        do(late, action)
    late.page.wait_for_selector("body:not([data-saving])", timeout=300_000)
    assert texts(late.path) == texts(plain.path), actions
    becomes(lambda: (shown(late), late.here) == (shown(plain), plain.here), True, actions)


@pytest.mark.slow
def test_an_edit_of_a_cell_takes_three_requests_and_none_where_a_sheet_can_only_be_read(shelf: Books) -> None:
    grid = shelf.open()
    grid.checked()
    grid.go("D5")
    grid.type("distance <")
    grid.page.wait_for_selector(
        "#panels .problem-list"
    )  # the check of the opened file has been told: checks are told in order
    row = grid.page.locator("tbody tr").nth(0).get_attribute("id")
    with grid.page.expect_response(
        lambda answer: answer.url.endswith("/stand") and f'"{row}"' in answer.request.post_data
    ):
        grid.go("F2")
    grid.page.evaluate(
        "() => { window.checks = 0; document.getElementById('listen').addEventListener('checked', () => window.checks++); }"
    )
    with requests_of(grid.page) as asked:
        grid.type("only a note")
        grid.saved()
        grid.page.wait_for_function("() => window.checks > 0")
        until(grid.page, lambda: any("/panels/" in address for address in asked))
    assert sorted(address.partition("/book/")[2].split("/")[1] for address in asked) == ["cells", "lock", "panels"]
    before = shown(grid)
    grid.page.evaluate("() => (document.querySelector('[role=grid]').ariaReadOnly = 'true')")
    with requests_of(grid.page) as asked:
        grid.go("B3")
        for action in MENU:
            grid.page.evaluate(CHOOSE, action)
        grid.page.evaluate(PASTE, "x\ty\n" * 40)
        grid.press("a", "Delete")
        grid.status("cannot change this sheet here")
    assert shown(grid) == before
    assert not [address for address in asked if EDITS.search(address)]
