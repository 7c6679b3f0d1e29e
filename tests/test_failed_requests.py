"""Pieces of pages that do not come: an error or an unreachable server is told in words and never shown as content."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import Any

import pytest
from acting import Run, Script
from chromium import listening, press_twice, set_clock
from panel import HEADER
from play import rows
from playwright.sync_api import expect

from rrp_sheets.resources import bundled
from rrp_sheets.web.app import create_app
from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan

ROWS = [["", "Head yaw", "filter", "headYaw > 3", "Far", ""], ["", "Far", "subscribe", "", "Say", ""]]
BOOKS = {"a.xlsx": {"T": [HEADER, *ROWS]}, "b.xlsx": {"T": [HEADER, ROWS[0]]}}
AWAY = "This page has no connection to the program. Check that the program is running, then try again."
GONE = "This is no longer there: somebody has renamed, moved or deleted it. Reload the page to see what there is now."
SIGNED_OUT = "You are not logged in any more, or the program was started again."
FAULT = "<main class='page message' id='main'><h1>A fault</h1><p>It broke.</p><p>→ Report it.</p></main>"
LOOKED_AT = "document.dispatchEvent(new Event('visibilitychange'))"  # a page that is looked at again asks at once
PLACES = {
    "/book/a.xlsx/print": ("**/print/protocol?*", ".paper-table", 500, FAULT, "It broke. Report it."),
    "/runs/one": ("**/runs/one/marbles?*", ".marble-form", 502, "<h1>Bad</h1>", "The program reported an error (502)."),
    "/compare?first=book/a.xlsx&second=book/b.xlsx": ("**/compare/drawn**", "main svg", 500, FAULT, "It broke. Report it."),
    "/runs/one/replay": ("**/replay/result*", ".replay-verdict", 404, FAULT, GONE),
    "/runs/one/lookback": ("**/lookback/diagram/**", ".ran-diagram svg", 403, FAULT, SIGNED_OUT),
}  # fmt: skip
FORMS = {
    "/": ("**/shelf/new", "form.new-book", ("name", "made")),
    "/book/a.xlsx/versions": ("**/versions/keep", "form.keep-form", ("title", "kept")),
    "/runs/delete?run=one": ("**/delete/now", "#deleting", ("typed", "one")),
}


@pytest.fixture(scope="module")
def page(page: Any, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A page of a server with a workbook and its run."""
    table = rows("\n".join(f"| {' | '.join(row[1:5])} |" for row in ROWS))
    made = Run(tmp_path_factory.mktemp("made"), table, Script({}), [(n * 100, "headyaw", n) for n in range(9)])
    shutil.copytree(made.result.folder, folder / "runs" / "one")
    page.route(
        "**/never", lambda route: route.abort()
    )  # without any route the browser would let the next one's request through
    return page


@pytest.mark.parametrize(
    "address", [pytest.param(a, marks=[pytest.mark.slow] * (not a.endswith(("print", "lookback")))) for a in PLACES]
)
def test_a_piece_that_does_not_come_is_told_and_asked_for_again(page: Any, address: str) -> None:
    pattern, content, status, body, words = PLACES[address]
    trouble = page.get_by_role("main").get_by_role("alert")
    page.route(pattern, lambda route: route.abort())
    page.goto(address)
    if address.endswith("lookback"):
        page.get_by_role("tab", name="Diagram").click()
    expect(trouble).to_contain_text(AWAY)
    expect(page.locator("main [aria-busy=true]")).to_have_count(0)
    page.unroute(pattern)
    page.route(pattern, lambda route: route.fulfill(status=status, body=body, content_type="text/html"))
    trouble.get_by_role("button", name="Try again").click()
    remedy = "Reload the page" if status in (403, 404) else "Try again"
    expect(trouble).to_have_text(f"{words} {remedy}")
    expect(page.locator("main h1", has_text="A fault")).to_have_count(0)
    expect(page.locator("main h1", has_text="Bad")).to_have_count(0)
    if address.endswith("print"):  # what is not there is not printed, and not said to be drawn
        expect(page.get_by_role("button", name="Print this page")).to_be_disabled()
        expect(page.locator("[data-ready]")).to_be_empty()
    page.unroute(pattern)
    trouble.get_by_role("button", name=remedy).click()
    expect(page.locator(content).first).to_be_visible()
    expect(trouble).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("address", FORMS)
def test_a_form_that_fails_stays_as_it_was_with_the_words_beside_it(page: Any, address: str) -> None:
    pattern, form, (name, typed) = FORMS[address]
    page.goto(address)
    field, trouble = page.locator(f"{form} [name={name}]"), page.locator(f"{form} + [role=alert]")
    for answer, words in (
        (lambda route: route.abort(), AWAY),
        (lambda route: route.fulfill(status=500, body=FAULT, content_type="text/html"), "It broke. Report it."),
    ):
        page.route(pattern, answer)
        field.fill(typed)
        field.press("Enter")
        expect(trouble).to_have_text(words)
        expect(field).to_have_value(typed)
        page.unroute(pattern)
    expect(page.locator("main")).to_have_count(1)


@pytest.mark.slow
def test_the_panels_of_a_grid_stay_when_their_renewal_fails(page: Any) -> None:
    page.goto("/book/a.xlsx")
    listening(page)
    page.wait_for_selector("#panels:not([aria-busy=true]) .problems")
    page.route("**/panels/*", lambda route: route.fulfill(status=500, body=FAULT, content_type="text/html"))
    page.evaluate("htmx.trigger('#panels', 'recheck')")
    expect(page.locator("#panels > [role=alert]")).to_have_text("It broke. Report it.")
    expect(page.locator("#panels .problems")).to_have_count(1)
    page.unroute("**/panels/*")
    page.evaluate("htmx.trigger('#panels', 'recheck')")
    expect(page.locator("#panels > [role=alert]")).to_have_count(0)
    page.route("**/help?*", lambda route: route.abort())
    page.keyboard.press("F1")
    expect(page.locator("#status")).to_have_text(f"Help is not available now. {AWAY}")
    page.unroute("**/help?*")


@pytest.mark.slow
def test_a_stop_that_does_nothing_says_why_on_every_page(page: Any) -> None:
    going = {"phase": "running", "book": "a.xlsx", "by": "Aya", "mode": "simulated", "since": 0}
    page.route("**/run/now", lambda route: route.fulfill(json=going))
    page.goto("/")
    told = page.locator("#run-strip .what")
    for answer, words in (
        (lambda route: route.abort(), AWAY),
        (lambda route: route.fulfill(status=409, json={"message": "No run is in progress."}), "No run is in progress."),
        (
            lambda route: route.fulfill(status=403, body=FAULT),
            "The program did not take your last action (error 403). Reload the page, then try again.",
        ),
        (
            lambda route: route.fulfill(body="{", content_type="application/json"),
            "The answer could not be shown. Reload the page.",
        ),
    ):
        expect(told).to_contain_text("Aya has been running a.xlsx")
        page.route("**/run/stop?*", answer)
        page.click("#run-strip .stop")
        expect(told).to_have_text(words)
        expect(told).to_have_role("alert")
        page.unroute("**/run/stop?*")
        page.route("**/run/stop?*", lambda route: route.fulfill(json={}))
        page.click("#run-strip .stop")
        expect(told).not_to_have_role("alert")
        page.unroute("**/run/stop?*")
    # a run that ends takes along what was said of it
    page.route("**/run/stop?*", lambda route: route.abort())
    page.click("#run-strip .stop")
    expect(told).to_have_text(AWAY)
    page.unroute("**/run/stop?*")
    page.unroute("**/run/now")
    page.evaluate(LOOKED_AT)
    expect(page.locator("#run-strip")).to_be_hidden(timeout=9_000)  # sooner than a refusal goes by itself


@pytest.mark.slow
def test_a_strip_that_hears_nothing_of_the_run_says_why(page: Any) -> None:
    going = {"phase": "running", "book": "a.xlsx", "by": "Aya", "mode": "simulated", "since": 0}
    told = page.locator("#run-strip .what")
    page.route("**/run/now", lambda route: route.fulfill(json=going))
    page.goto("/")
    expect(told).to_contain_text("Aya has been running a.xlsx")
    page.route("**/run/now", lambda route: route.abort())  # it asks again by itself
    expect(told).to_contain_text(f"This page cannot tell if a.xlsx is still running. {AWAY}")
    page.route("**/run/now", lambda route: route.fulfill(json=going))
    page.evaluate(LOOKED_AT)
    expect(told).to_contain_text("Aya has been running a.xlsx")
    page.route("**/run/now", lambda route: route.fulfill(status=403, body=FAULT))
    page.evaluate(LOOKED_AT)
    words = "You are not logged in any more, or the program"
    expect(told).to_contain_text(f"This page cannot tell if a.xlsx is still running. {words}")
    page.unroute("**/run/now")


@pytest.mark.slow
def test_keys_that_cannot_stop_a_run_say_why_unless_there_is_none(page: Any) -> None:
    page.goto("/book/a.xlsx")
    listening(page)
    with page.expect_response("**/run/stop?*") as answered:
        press_twice(page)
    assert answered.value.status == 409
    page.evaluate("fetch('/run/now').then(answer => answer.text())")  # a later answer: the page has taken that one
    expect(page.locator("#run-problem")).to_be_hidden()
    page.route("**/run/stop?*", lambda route: route.abort())
    press_twice(page)
    expect(page.locator("#run-problem")).to_contain_text(AWAY)
    expect(page.locator("#run-strip")).to_be_hidden()
    # of a run elsewhere the strip tells, and only the strip
    page.click("#run-problem button")
    going = {"phase": "running", "book": "b.xlsx", "by": "Aya", "mode": "simulated", "since": 0}
    page.evaluate("(detail) => document.dispatchEvent(new CustomEvent('rrp:elsewhere', { detail }))", going)
    press_twice(page)
    expect(page.locator("#run-strip .what")).to_have_text(AWAY)
    expect(page.locator("#run-problem")).to_be_hidden(timeout=9_000)  # sooner than a refusal goes by itself
    page.unroute("**/run/stop?*")


@pytest.mark.slow
def test_keys_stop_also_a_run_that_a_page_outside_the_grid_has_not_heard_of(page: Any) -> None:
    with page.expect_response("**/run/now"):
        page.goto("/")
    with page.expect_response("**/run/stop?*") as answered:
        press_twice(page)
    assert answered.value.status == 409
    page.evaluate("fetch('/run/now').then(answer => answer.text())")  # a later answer: the page has taken that one
    strip = page.locator("#run-strip")
    expect(strip).to_be_hidden()
    for answer, words in (
        (lambda route: route.abort(), AWAY),
        (
            lambda route: route.fulfill(status=500, body=FAULT),
            "The program did not take your last action (error 500). Reload the page, then try again.",
        ),
    ):
        page.route("**/run/stop?*", answer)
        press_twice(page)
        expect(strip.locator(".what")).to_have_text(words)
        expect(strip.locator(".what")).to_have_role("alert")
        expect(strip.locator(".badge, a").filter(visible=True)).to_have_count(0)
        expect(strip.get_by_role("button", name="Stop")).to_be_enabled()
        page.unroute("**/run/stop?*")
    going = {"phase": "stopping", "book": "a.xlsx", "by": "Aya", "mode": "simulated", "since": 0}
    set_clock(page)  # the page does not ask by itself any more
    page.goto("/")
    page.clock.pause_at(time.time() + 60)
    page.route("**/run/now", lambda route: route.fulfill(json=going))
    page.route("**/run/stop?*", lambda route: route.fulfill(json={}))
    page.evaluate(
        "import(document.querySelector('script[src*=\"run/strip.js\"]').src.replace('run/strip.js', 'api.js')).then(api => api.stop())"
    )
    expect(strip.locator(".what")).to_have_text("a.xlsx is being stopped.")
    page.unroute("**/run/stop?*")
    page.unroute("**/run/now")
    page.clock.resume()


@pytest.mark.slow
def test_a_pdf_that_cannot_be_made_says_why(page: Any) -> None:
    page.goto("/book/a.xlsx/print")
    for answer, words in (
        (lambda route: route.abort(), AWAY),
        (lambda route: route.fulfill(status=500, body=FAULT, content_type="text/html"), "It broke. Report it."),
    ):
        page.route("**/print/ready*", answer)
        page.get_by_role("button", name="Download the PDF").click()
        expect(page.locator(".print-said.is-error")).to_have_text(words)
        page.unroute("**/print/ready*")


def test_every_page_with_htmx_refuses_errors_as_content_and_its_settings_are_known() -> None:
    """A setting whose name htmx does not know would do nothing, in silence."""
    known = (bundled("templates", "web") / "../../rrp_sheets/_vendor/js/htmx.min.js").resolve()
    script = known.read_text(encoding="utf-8")
    for template in bundled("templates", "web").glob("*.html"):
        text = template.read_text(encoding="utf-8")
        assert "htmx-config" not in text or template.name == "parts.html", template.name
        assert "htmx.min.js" not in text or template.name in ("parts.html", "grid.html"), template.name
    settings = (
        (bundled("templates", "web") / "parts.html").read_text(encoding="utf-8").partition('htmx-config" content=')[2]
    )
    for name in ("includeIndicatorCSS", "noSwap", "defaultTimeout"):
        assert f'"{name}"' in settings and f"{name}:" in script


@pytest.mark.slow
def test_looking_back_says_why_there_is_nothing_to_see(page: Any) -> None:
    pattern = "**/lookback/overview.json"
    for answer, words in (
        (lambda route: route.abort(), AWAY),
        (lambda route: route.fulfill(status=500, body=FAULT, content_type="text/html"), "It broke. Report it."),
    ):
        page.route(pattern, answer)
        page.goto("/runs/one/lookback")
        expect(page.locator("#trouble")).to_have_text(words)
        page.unroute(pattern)


@pytest.mark.slow
def test_the_print_page_waits_as_long_as_a_protocol_may_take(page: Any) -> None:
    page.goto("/book/a.xlsx/print")
    page.wait_for_function("() => htmx.config.defaultTimeout === 150000 && htmx.config.noSwap.includes('5xx')")


def test_a_request_of_a_page_is_not_answered_with_the_login(tmp_path: Path) -> None:
    client = create_app(tmp_path, "t", Lan(Password("green otter lamp"), ("127.0.0.1",))).test_client()
    asked = {"Accept": "text/html", "Host": "127.0.0.1"}
    assert client.get("/", headers=asked).status_code == 303
    assert client.get("/", headers={**asked, "HX-Request": "true"}).status_code == 403
