"""Pages that several test files use one after the other are as new each time, or not used again."""

from __future__ import annotations

from typing import Any

import pytest
from chromium import PAGES, set_clock

KEPT = "[location.pathname, localStorage.length, sessionStorage.length, document.cookie, innerWidth, window.name]"
LOOK = """() => ["print", "(prefers-color-scheme: dark)", "(prefers-reduced-motion)", "(prefers-contrast: more)",
  "(forced-colors: active)"].filter((query) => matchMedia(query).matches)"""
HELD = """() => new Promise((done) => addEventListener("mousemove", (e) =>
  done([e.buttons, e.altKey, e.ctrlKey, e.metaKey, e.shiftKey]), { once: true }))"""


@pytest.mark.slow
def test_a_page_that_is_used_again_is_as_new(browser: Any, url: str) -> None:
    page = PAGES.take(browser, url, "Somebody")
    cookies = page.context.cookies()
    asked: list[str] = []
    for target in (page, page.context):
        target.route("**/help*", lambda route: (asked.append(route.request.url), route.abort()))
    page.goto(url)
    page.set_viewport_size({"width": 400, "height": 300})
    page.evaluate("() => { localStorage.a = sessionStorage.b = document.cookie = 'c=1'; window.name = 'x'; }")
    page.evaluate("() => { setTimeout(() => { throw new Error('mine'); }); }")
    page.wait_for_function("() => true")
    page.context.new_page()
    page.emulate_media(
        media="print", color_scheme="dark", reduced_motion="reduce", forced_colors="active", contrast="more"
    )
    page.mouse.down()
    for key in ("Alt", "Control", "Meta", "Shift"):
        page.keyboard.down(key)
    PAGES.put_back(page)
    again = PAGES.take(browser, url, "Somebody")
    assert again is page and again.problems == [] and len(again.context.pages) == 1
    assert again.evaluate(KEPT) == ["/static/login.css", 0, 0, "", 1280, ""]  # read once: nothing runs there
    assert again.context.cookies() == cookies
    assert again.goto(f"{url}/help").ok and not asked
    assert again.evaluate(LOOK) == []  # read once: nothing changes it
    again.evaluate(f"() => {{ window.held = ({HELD})(); }}")
    again.mouse.move(30, 30)
    assert again.evaluate("window.held") == [0, False, False, False, False]  # read once: it is waited for there
    assert again.evaluate("localStorage.name") == "Somebody"  # read once: the page has begun with it
    another = PAGES.take(browser, url, "Another")
    assert another is not page
    PAGES.put_back(another)
    PAGES.put_back(again)


def test_a_page_with_a_clock_of_its_own_is_not_used_again(browser: Any, url: str) -> None:
    page = PAGES.take(browser, url)
    set_clock(page)
    PAGES.put_back(page)
    assert page.is_closed()


@pytest.mark.slow
def test_a_page_of_a_test_that_has_failed_is_not_used_again(browser: Any, url: str) -> None:
    free, taken = PAGES.take(browser, url), PAGES.take(browser, url)
    PAGES.put_back(free)
    PAGES.spoil_taken()
    PAGES.put_back(taken)
    assert taken.is_closed() and not free.is_closed()


@pytest.mark.slow
def test_a_page_that_was_closed_is_not_used_again(browser: Any, url: str) -> None:
    page = PAGES.take(browser, url)
    PAGES.put_back(page)
    page.context.close()
    again = PAGES.take(browser, url)
    assert not again.is_closed()
    PAGES.put_back(again)
