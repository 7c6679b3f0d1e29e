"""The tutorial beside the sheet: one lesson at a time, with its steps, its test, and the way on."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from browser import HOME, get, visit
from chromium import becomes, eventually
from grid_books import Books, Shared
from playwright.sync_api import expect

from rrp_sheets.documents import Document
from rrp_sheets.help.tutorial import LESSONS
from rrp_sheets.resources import bundled
from rrp_sheets.web.views.lessons import lesson_panel
from rrp_sheets.web.workbook_tests import Results, WorkbookTests
from rrp_sheets.web.workbook_tests import Tested as Result
from rrp_sheets.workbook import read

TUTORIAL = bundled("templates", "workbooks", "tutorial.xlsx")
ROW = ("Hello heard", "subscribe", '"Hello!"', "Say")
MARKS = "#lesson [aria-current=step][data-lesson-go]"


def opened(shelf: Books, name: str) -> Shared:
    """A tutorial that nobody has begun."""
    path = Path(shutil.copy(TUTORIAL, shelf.folder / name))
    page = shelf.open(path=path)
    page.checked()
    expect(page.page.locator(".lesson-check")).to_contain_text("not passed yet")
    return page


def at(page: Shared, number: int) -> None:
    expect(page.page.locator(MARKS)).to_have_attribute("data-lesson-go", str(number))


def states(page: Shared) -> list[str]:
    return [str(c) for c in page.page.locator(".do-list li").evaluate_all("all => all.map((one) => one.className)")]


def rows(page: Shared) -> Any:
    return page.page.evaluate(
        "[...document.querySelectorAll('[role=grid] tbody tr')].map((r) => [...r.cells].map((c) => c.dataset.v ?? ''))"
    )


def test_a_lesson_is_done_when_its_test_passes(shelf: Books) -> None:
    page = opened(shelf, "done.xlsx")
    assert page.faults() == []
    following = page.page.locator("[data-lesson-do=next]")
    expect(following).to_have_attribute("aria-disabled", "true")
    becomes(lambda: states(page), ["is-now", "is-later", "is-later", "is-later"])
    following.click(force=True)
    page.status("This lesson is not done yet. Finish it, or choose Skip.")
    at(page, 1)
    page.go("B5")
    page.type(ROW[0], "Tab")
    becomes(lambda: states(page), ["is-done", "is-now", "is-later", "is-later"])
    for text in ROW[1:]:
        page.type(text, "Tab")
    expect(page.page.locator(".lesson-check")).to_have_text("✓ Test “Lesson 1 Hello” passed.")
    becomes(lambda: states(page), ["is-done"] * 4)
    following.click()
    at(page, 2)
    page.status("Lesson 2 of 10: Near")
    expect(following).to_have_attribute("aria-disabled", "true")
    expect(page.page.locator("#lesson .lesson-marks .is-done")).to_have_count(1)


def test_progress_is_of_its_workbook_and_survives_a_reload(shelf: Books) -> None:
    page = opened(shelf, "one.xlsx")
    page.page.click("#lesson >> text=Skip")
    at(page, 2)
    page.page.click("#lesson [data-lesson-go='5']")
    at(page, 5)
    page.page.reload()
    at(page, 5)
    other = opened(shelf, "two.xlsx")
    at(other, 1)


def test_it_is_closed_and_opened_again_from_the_help(shelf: Books) -> None:
    page = opened(shelf, "closed.xlsx")
    page.page.click("[data-lesson-do=close]")
    expect(page.page.locator("#lesson")).to_be_hidden()
    page.page.reload()
    page.checked()
    expect(page.page.locator("#lesson")).to_be_hidden()
    page.press("F1")
    page.page.click("#help >> text=Open the tutorial")
    expect(page.page.locator("#lesson-title")).to_be_focused()
    expect(page.page.locator("#help")).to_be_hidden()


def test_show_me_plays_a_step_and_changes_nothing(shelf: Books) -> None:
    page = opened(shelf, "shown.xlsx")
    page.go("B3")
    page.type("Blue ball")
    page.saved()
    page.checked()
    before, file = rows(page), page.path.read_bytes()
    page.page.click("[data-lesson-do=show]")
    expect(page.page.locator(".shown-step")).to_have_text("Hello heard")
    becomes(lambda: page.here, "B5")
    expect(page.page.locator(".shown-step")).to_have_count(0)  # it goes by itself
    page.page.click("[data-lesson-do=show]")
    eventually(lambda: page.page.locator(".shown-step").count() == 1)
    page.press("ArrowDown")
    expect(page.page.locator(".shown-step")).to_have_count(0)
    becomes(lambda: rows(page), before)
    assert page.path.read_bytes() == file
    page.press("Control+z")  # one's own edit is the newest still
    page.expect("B3", "Red ball")
    page.page.emulate_media(reduced_motion="reduce")  # where nothing may move, it is shown at once
    page.page.click("[data-lesson-do=show]")
    expect(page.page.locator(".shown-step")).to_have_text("Hello heard")
    page.press("Escape")
    expect(page.page.locator(".shown-step")).to_have_count(0)
    page.page.emulate_media(reduced_motion="no-preference")


def test_other_workbooks_have_no_lesson(tmp_path: Path) -> None:
    shutil.copy(bundled("workbooks", "greeter.xlsx"), tmp_path)
    client = visit(tmp_path)
    assert 'id="lesson"' not in get(client, "/book/greeter.xlsx").text
    assert get(client, "/book/greeter.xlsx/lesson/1").status_code == 404


@pytest.mark.parametrize(
    ("language", "lesson", "term"),
    [("en", "Lesson 1 Hello", "connector"), ("ja", "レッスン1 あいさつをする", "コネクター")],
)
def test_a_tutorial_is_made_in_the_language_of_the_reader(
    language: str, lesson: str, term: str, tmp_path: Path
) -> None:
    client = visit(tmp_path)
    headers = {"X-RRP": "grid", "Origin": HOME, "Accept-Language": language}
    assert client.post("/shelf/tutorial", base_url=HOME, headers=headers).headers["HX-Redirect"]
    assert lesson in read(tmp_path / "tutorial.xlsx").workbook.sheets
    panel = get(client, "/book/tutorial.xlsx/lesson/1", Accept_Language=language).text
    assert 'data-topic="connector"' in panel and f">{term}</a>" in panel


@pytest.mark.parametrize("number", [0, 11, 99_999])
def test_a_lesson_that_is_not_there_is_the_first_to_do(number: int, tmp_path: Path) -> None:
    shutil.copy(TUTORIAL, tmp_path)
    document = Document(tmp_path / "tutorial.xlsx", None)
    tests = WorkbookTests(document, None, lambda _: None, lambda: False)  # type: ignore[arg-type]
    tests.results = Results((Result("Lesson 1 Hello", "passes"), Result("Lesson 2 Near", "fails")))
    panel = lesson_panel(tests, document, "tutorial.xlsx", "My robot", number)
    assert panel is not None and (panel.place, panel.title) == (2, "Near")


@pytest.fixture(scope="module", params=["tutorial.xlsx", "tutorial.ja.xlsx"])
def tutorial(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Document:
    """A tutorial that nobody has begun, without a page."""
    return Document(Path(shutil.copy(TUTORIAL.with_name(request.param), tmp_path_factory.mktemp("tutorial"))), None)


@pytest.mark.parametrize("number", range(1, len(LESSONS) + 1))
def test_each_lesson_knows_where_its_steps_are_written(tutorial: Document, number: int) -> None:
    tests = WorkbookTests(tutorial, None, lambda _: None, lambda: False)  # type: ignore[arg-type]
    panel = lesson_panel(tests, tutorial, tutorial.path.name, next(iter(tutorial.grids)), number)
    assert panel is not None and panel.shows and all(step.cells for step in panel.steps)
    assert panel.steps[0].state == "now"
