"""Pages that several test files use one after the other are as new each time, or not used again."""

from __future__ import annotations

from typing import Any

from chromium import PAGES, set_clock

KEPT = "[location.pathname, localStorage.length, sessionStorage.length, document.cookie, innerWidth]"


def test_a_page_that_is_used_again_is_as_new(browser: Any, url: str) -> None:
    page = PAGES.take(browser, url, "Somebody")
    cookies = page.context.cookies()
    asked: list[str] = []
    page.route("**/help*", lambda route: (asked.append(route.request.url), route.abort()))
    page.goto(url)
    page.set_viewport_size({"width": 400, "height": 300})
    page.evaluate("() => { localStorage.a = sessionStorage.b = document.cookie = 'c=1'; }")
    page.evaluate("() => { setTimeout(() => { throw new Error('mine'); }); }")
    page.wait_for_function("() => true")
    page.context.new_page()
    PAGES.put_back(page)
    again = PAGES.take(browser, url, "Somebody")
    assert again is page and again.problems == [] and len(again.context.pages) == 1
    assert again.evaluate(KEPT) == ["/static/login.css", 0, 0, "", 1280]  # read once: nothing runs there
    assert again.context.cookies() == cookies
    assert again.goto(f"{url}/help").ok and not asked
    assert again.evaluate("localStorage.name") == "Somebody"  # read once: the page has begun with it
    assert PAGES.take(browser, url, "Another") is not page
    PAGES.put_back(again)


def test_a_page_with_a_clock_of_its_own_is_not_used_again(browser: Any, url: str) -> None:
    page = PAGES.take(browser, url)
    set_clock(page)
    PAGES.put_back(page)
    assert page.is_closed()
