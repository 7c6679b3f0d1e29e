"""Comments of cells in the grid: written, answered, resolved, undone, seen by others, and never lost."""

from __future__ import annotations

from typing import Any

import openpyxl
import pytest
from chromium import becomes, eventually, violations_by_look
from grid_books import Books, Shared
from playwright.sync_api import expect
from slow_answers import SlowAnswers

from rrp_sheets.workbook.comments import Comment, Thread, new_id, read_threads
from rrp_sheets.workbook.edits import SetComments
from rrp_sheets.workbook.files import edit, open_book


@pytest.fixture
def grid(shelf: Books) -> Shared:
    opened = shelf.open()
    opened.checked()
    return opened


def texts(grid: Shared) -> dict[tuple[int, int], list[str]]:
    """The comments in the file, by row and column."""
    grid.saved()
    return {at: [c.text for c in thread] for at, thread in threads(grid).items()}


def threads(grid: Shared) -> dict[tuple[int, int], Thread]:
    book, _ = open_book(grid.path)
    return read_threads(book, 0)  # type: ignore[arg-type]


def panel(grid: Shared) -> Any:
    return grid.page.locator(".thread")


def comment(grid: Shared, address: str, text: str) -> None:
    """Comment a cell by keys; the cursor is in it again."""
    grid.go(address)
    grid.press("Shift+F2")
    grid.page.keyboard.insert_text(text)
    grid.press("Control+Enter")
    panel(grid).locator("li", has_text=text).wait_for()
    grid.press("Escape")
    becomes(lambda: grid.here, address)


def marked(grid: Shared) -> list[str]:
    return [str(text) for text in grid.page.locator("td.commented .about-comments").all_text_contents()]


def test_a_comment_is_written_by_keys_and_is_in_the_file(grid: Shared) -> None:
    comment(grid, "D3", "Is 0.5 far enough?\nI think so.")
    becomes(lambda: texts(grid), {(3, 4): ["Is 0.5 far enough?\nI think so."]})
    assert openpyxl.load_workbook(grid.path)["T"]["D3"].comment is not None
    becomes(lambda: marked(grid), ["Comment: Is 0.5 far enough?\nI think so. (Somebody)"])
    cell = grid.page.locator("td.commented")
    expect(cell).to_have_accessible_description("Comment: Is 0.5 far enough? I think so. (Somebody)")
    becomes(lambda: grid.page.inner_text(".comment-count"), "1 cell with comments")
    grid.go("A2")
    grid.go("D3")
    grid.wait_spoken("Comment: Is 0.5 far enough?")


def test_each_comment_is_one_step_of_undo(grid: Shared) -> None:
    comment(grid, "D3", "one")
    comment(grid, "D3", "two")
    becomes(lambda: texts(grid), {(3, 4): ["one", "two"]})
    grid.press("Control+z")
    becomes(lambda: texts(grid), {(3, 4): ["one"]})
    grid.status("Undone: comments of D3.")
    grid.press("Control+z")
    becomes(lambda: texts(grid), {})
    becomes(lambda: marked(grid), [])
    grid.press("Control+y")
    grid.press("Control+y")
    becomes(lambda: texts(grid), {(3, 4): ["one", "two"]})


def test_own_comments_are_edited_and_deleted_and_threads_resolved(shelf: Books) -> None:
    aya, _ = shelf.two()
    comment(aya, "D3", "one")
    aya.press("Shift+F2")
    aya.page.get_by_role("button", name="Edit: one").click()
    aya.page.get_by_label("Edit the comment").fill("uno")
    aya.press("Control+Enter")
    becomes(lambda: texts(aya), {(3, 4): ["uno"]})
    aya.page.get_by_role("button", name="Resolve").click()
    becomes(lambda: threads(aya)[3, 4][0].done, True)
    expect(aya.page.locator("td.commented.resolved")).to_have_count(1)
    aya.page.get_by_role("button", name="Reopen").click()
    becomes(lambda: threads(aya)[3, 4][0].done, False)
    aya.page.get_by_role("button", name="Delete: uno").click()
    becomes(lambda: texts(aya), {})
    expect(panel(aya).locator("li")).to_have_count(0)


def test_two_people_see_each_others_comments_at_once_and_change_only_their_own(shelf: Books) -> None:
    aya, mika = shelf.two()
    aya.checked()
    mika.go("D3")
    mika.press("Shift+F2")
    mika.page.keyboard.insert_text("not sent yet")
    comment(aya, "D3", "from Aya")
    expect(panel(mika).locator("li")).to_contain_text("from Aya")
    expect(panel(mika).locator("li button")).to_have_count(0)
    mika.press("Control+Enter")
    becomes(lambda: [(c.author, c.text) for c in threads(aya)[3, 4]], [("Aya", "from Aya"), ("Mika", "not sent yet")])
    aya.press("Control+z")  # Mika has answered
    aya.status("Mika has replied to this comment. Delete the whole thread instead.")
    becomes(lambda: len(texts(aya)[3, 4]), 2)
    expect(mika.page.locator("td.commented")).to_have_count(1)


def test_both_comment_the_same_blank_cell_at_once_and_neither_is_lost(shelf: Books) -> None:
    aya, mika = shelf.two()
    for one in (aya, mika):
        one.checked()
        one.go("F2")
        one.press("Shift+F2")
        one.page.keyboard.insert_text("mine")
    aya.press("Control+Enter")
    mika.press("Control+Enter")
    eventually(lambda: sorted(c.author for c in threads(aya).get((2, 6), ())) == ["Aya", "Mika"])


def test_a_comment_shows_on_hover_and_where_the_cursor_rests(grid: Shared) -> None:
    comment(grid, "D3", "look here")
    grid.go("A2")
    card = grid.page.locator(".thread-card")
    expect(card).to_be_hidden()
    grid.page.locator("td.commented").hover()
    expect(card).to_contain_text("look here")
    grid.page.locator("tr[aria-rowindex='5'] td").first.hover()
    expect(card).to_be_hidden()
    grid.go("D3")
    expect(card).to_be_visible()
    grid.press("F2")
    grid.press("Escape")


def test_a_text_that_is_not_sent_stays_over_closing_and_reload(grid: Shared) -> None:
    grid.go("D3")
    grid.press("Shift+F2")
    grid.page.keyboard.insert_text("half a thought")
    grid.press("Escape")
    grid.status("Your comment on D3 has not been sent yet.")
    grid.page.reload()
    grid.page.get_by_role("button", name="Open", exact=True).click()
    expect(panel(grid).get_by_label("Your comment")).to_have_value("half a thought")
    grid.page.keyboard.press("Control+Enter")
    becomes(lambda: texts(grid), {(3, 4): ["half a thought"]})
    grid.page.reload()
    grid.checked()
    expect(grid.page.get_by_role("button", name="Open", exact=True)).to_have_count(0)


def test_a_comment_that_is_refused_is_given_back(shelf: Books) -> None:
    aya, mika = shelf.two()
    aya.checked()
    mika.checked()
    aya.go("D3")
    aya.press("Shift+F2")
    aya.page.keyboard.insert_text("my words")
    with SlowAnswers(aya.page) as late:
        aya.press("Control+Enter")
        late.release()
    becomes(lambda: texts(aya), {(3, 4): ["my words"]})
    aya.page.keyboard.insert_text("more words")
    mika.go("D3")
    mika.press("Control+-")
    becomes(lambda: len(mika.rows()), 2)
    aya.press("Control+Enter")
    expect(aya.page.locator("dialog textarea")).to_have_value("more words")
    aya.press("Escape")


def test_comments_go_with_rows_that_are_moved_deleted_and_brought_back(grid: Shared) -> None:
    comment(grid, "D3", "on the filter")
    grid.press("Alt+ArrowUp")
    becomes(lambda: texts(grid), {(2, 4): ["on the filter"]})
    grid.press("Control++")
    becomes(lambda: texts(grid), {(3, 4): ["on the filter"]})
    grid.press("Control+z")
    becomes(lambda: texts(grid), {(2, 4): ["on the filter"]})
    grid.go("D2")
    grid.press("Control+-")
    becomes(lambda: texts(grid), {})
    grid.press("Control+z")
    becomes(lambda: texts(grid), {(2, 4): ["on the filter"]})
    becomes(lambda: marked(grid), ["Comment: on the filter (Somebody)"])


def test_comments_go_with_cells_that_are_cut_and_pasted_as_one_step(grid: Shared) -> None:
    grid.context.grant_permissions(["clipboard-read", "clipboard-write"])
    comment(grid, "D3", "on the filter")
    grid.go("D3")
    grid.press("Shift+ArrowRight", "Control+x")
    grid.go("D6")
    grid.press("Control+v")
    becomes(lambda: texts(grid), {(6, 4): ["on the filter"]})
    grid.expect("D6", "distance < 0.5")
    grid.go("D9")
    grid.press("Control+v")  # once more: a copy
    grid.expect("D9", "distance < 0.5")
    becomes(lambda: texts(grid), {(6, 4): ["on the filter"]})
    grid.press("Control+z", "Control+z")
    grid.expect("D6", "")
    becomes(lambda: texts(grid), {(3, 4): ["on the filter"]})


@pytest.mark.slow
def test_a_copy_of_a_sheet_has_its_comments_and_a_deleted_one_comes_back_with_them(grid: Shared) -> None:
    comment(grid, "D3", "hello")
    grid.page.get_by_role("button", name="Menu of the sheet T").click()
    grid.page.get_by_role("menuitem", name="Duplicate").click()
    grid.page.wait_for_url("**/sheet/T*2*")
    grid.checked()
    becomes(lambda: marked(grid), ["Comment: hello (Somebody)"])
    book, _ = open_book(grid.path)
    both = [read_threads(book, i)[3, 4] for i in (0, 1)]  # type: ignore[arg-type]
    assert both[0][0].text == both[1][0].text
    assert both[0][0].id != both[1][0].id


def test_all_comments_are_listed_with_the_way_to_each(shelf: Books) -> None:
    head, row = ["From", "Operator", "Parameter", "To"], ["Red ball", "map", "1", "A"]
    path = shelf.file({"T": [head, row], "Mine": [["x"]], "Low": [["a title"], head, row]})
    made = (Comment(new_id(), "Aya", "2026-11-02T09:05:00Z", "open"),)
    done = (Comment(new_id(), "Mika", "2026-11-02T09:05:00Z", "settled", done=True),)
    edit(path, [SetComments("T", 2, 3, made), SetComments("Mine", 1, 1, done), SetComments("T", 1, 1, done),
                SetComments("Low", 1, 1, done), SetComments("Low", 2, 2, made)])  # fmt: skip
    grid = shelf.open(path=path, sheet="T")
    grid.checked()
    grid.page.locator(".comment-count").click()
    rows = grid.page.locator(".all-comments li")
    becomes(lambda: [text.split("\n")[-1] for text in rows.all_inner_texts()], ["open"] * 2)
    grid.page.get_by_label("Show resolved ones too").check()
    expect(rows).to_have_count(5)
    expect(rows.nth(3)).to_contain_text("Low A1")
    expect(rows.nth(3)).to_contain_text("This cell is not shown in the grid.")
    rows.get_by_role("link", name="T C2").click()
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on C2")
    becomes(lambda: grid.page.locator(".thread li b").all_inner_texts(), ["Aya"])
    grid.press("Escape")
    becomes(lambda: grid.here, "C2")
    grid.page.locator(".comment-count").click()
    rows.get_by_role("link", name="Low B2").click()  # a header of another sheet
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on B2")
    becomes(lambda: panel(grid).locator("li p").all_inner_texts(), ["open"])


def test_a_header_has_its_comments_which_are_answered_and_undone_there(shelf: Books) -> None:
    aya, mika = shelf.two()
    edit(aya.path, [SetComments("T", 1, 4, (Comment(new_id(), "Zed", "2026-11-02T09:05:00Z", "Metres?"),))])
    mark = aya.page.locator("thead .head-comments")
    expect(mark).to_have_attribute("aria-label", "Comments on D1. Comment: Metres? (Zed)")
    becomes(lambda: aya.page.inner_text(".comment-count"), "1 cell with comments")
    mark.focus()
    aya.page.keyboard.press("Enter")
    expect(panel(aya).get_by_role("heading")).to_have_text("Comments on D1")
    becomes(lambda: panel(aya).locator("li p").all_inner_texts(), ["Metres?"])
    aya.page.locator(".thread textarea").fill("Yes")
    aya.page.keyboard.press("Control+Enter")
    becomes(lambda: texts(aya), {(1, 4): ["Metres?", "Yes"]})
    told = "Comments on D1. 2 comments, the last one: Yes (Aya)"
    for page in aya, mika:
        expect(page.page.locator("thead .head-comments")).to_have_attribute("aria-label", told)
    aya.page.keyboard.press("Escape")
    expect(mark).to_be_focused()
    aya.go("B2")
    aya.press("Control+z")
    becomes(lambda: texts(aya), {(1, 4): ["Metres?"]})
    aya.status("Undone: comments of D1.")
    aya.page.locator(".comment-count").click()
    aya.page.get_by_role("link", name="T D1").click()
    aya.page.get_by_role("button", name="Delete thread").click()
    expect(mark).to_have_count(0)
    becomes(lambda: texts(aya), {})
    expect(mika.page.locator("thead .commented")).to_have_count(0)


def test_a_header_gets_its_first_comment_by_its_menu_and_by_keys(shelf: Books) -> None:
    grid = shelf.open()
    head = grid.page.locator("thead th[data-letter=C]")
    head.click(button="right")
    grid.page.get_by_role("menuitem", name="Comment …").click()
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on C1")
    grid.page.locator(".thread textarea").fill("In metres")
    grid.page.keyboard.press("Control+Enter")
    becomes(lambda: texts(grid), {(1, 3): ["In metres"]})
    expect(head.locator(".head-comments")).to_have_count(1)
    grid.page.keyboard.press("Escape")
    grid.page.locator("thead th[data-letter=B]").click()
    grid.page.keyboard.press("Shift+F2")
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on B1")
    grid.page.keyboard.press("Escape")


def test_a_sheet_of_ones_own_shows_its_comments_also_beyond_its_texts(shelf: Books) -> None:
    path = shelf.file({"T": [["From", "Operator", "Parameter", "To"], ["Red ball", "map", "1", "A"]], "Mine": [["x"]]})
    note = (Comment(new_id(), "Aya", "2026-11-02T09:05:00Z", "mine"),)
    edit(
        path,
        [SetComments("Mine", 1, 1, note), SetComments("Mine", 40, 3, note), SetComments("Mine", 1_048_576, 2, note)],
    )
    grid = shelf.open(path=path, sheet="T")
    grid.page.get_by_role("link", name="Mine").click()
    becomes(lambda: marked(grid), ["Comment: mine (Aya)"] * 2)
    grid.go("A1")
    grid.press("Shift+F2")
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on A1")
    becomes(lambda: panel(grid).locator("li p").all_inner_texts(), ["mine"])
    expect(panel(grid).locator("textarea")).to_be_hidden()  # such a sheet is not edited here
    grid.press("Escape")
    grid.page.locator(".comment-count").click()
    grid.page.get_by_role("link", name="Mine C40").click()
    expect(panel(grid).get_by_role("heading")).to_have_text("Comments on C40")
    grid.press("Escape")
    becomes(lambda: grid.here, "C40")


def test_comments_of_another_program_appear_while_the_page_is_open(grid: Shared) -> None:
    edit(grid.path, [SetComments("T", 2, 2, (Comment("note", "Zed", "", "a note from Excel"),))])
    becomes(lambda: marked(grid), ["Comment: a note from Excel (Zed)"])
    comment(grid, "B2", "an answer")
    becomes(
        lambda: [(c.author, c.text) for c in threads(grid)[2, 2]],
        [("Zed", "a note from Excel"), ("Somebody", "an answer")],
    )


def test_hostile_words_are_only_words(grid: Shared) -> None:
    bad = '<img src=x onerror=alert(1)> & "quotes" \' {n}'
    comment(grid, "D3", bad)
    becomes(lambda: texts(grid), {(3, 4): [bad]})
    becomes(lambda: marked(grid), [f"Comment: {bad} (Somebody)"])
    expect(grid.page.locator("td img, .thread img")).to_have_count(0)


@pytest.mark.slow
def test_the_panel_the_card_and_the_list_are_accessible(shelf: Books) -> None:
    aya, _ = shelf.two()
    aya.checked()
    edit(aya.path, [SetComments("T", 1, 2, (Comment(new_id(), "Zed", "2026-11-02T09:05:00Z", "of the header"),))])
    aya.page.locator(".head-comments").wait_for()
    comment(aya, "D3", "look here")
    aya.press("Shift+F2")
    panel(aya).locator("li").wait_for()
    assert violations_by_look(aya.page, without=[".diagram"]) == {}
    aya.page.get_by_role("button", name="All comments").click()
    aya.page.locator(".all-comments li").first.wait_for()
    assert violations_by_look(aya.page, without=[".diagram"]) == {}
    aya.press("Escape")
