"""Hostile texts in every place of a workbook, a run, a version and a person, on every page in a real browser.

Nothing runs, nothing is asked for elsewhere, and every page shows them as text.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

import pytest
from browser import HOME, book, checked, get, visit
from chromium import becomes, eventually, let_in, listening
from playwright.sync_api import expect

from rrp_sheets import api
from rrp_sheets.workbook.files import make_workbook

CELL = (
    "<script>alert(1)</script>\"'><img src=x onerror=alert(1)><svg/onload=alert(1)>javascript:alert(1)"
    "</title></textarea></script>--> ]]>{{7777*7}}{% raw %}${7777*7}&lt;b&gt;&quot;&#x3c;\u202e\u2066\u200b<b>bold</b>"
)
DOT = '"]; x [URL="javascript:alert(1)" label=<<IMG SRC="/etc/passwd"/>> shape=none image="x.png"]; //<TABLE HREF="x">'
SHEET = "<img src=x onerror=alert(1)>'&\""
NAME = "\"><img src=x onerror='alert(1)'> {{7777*7}} #&%20;<b>.xlsx"
PERSON = "<b>Eve</b><img src=x onerror=alert(1)>"
RUN = "20260101-000000-<img src=x onerror=alert(1)>"
BEHAVIOUR = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]


def hostile_sheets() -> dict[str, list[list[str]]]:
    """Every kind of sheet, with hostile texts in every kind of cell."""
    rows = [
        ["", "Red ball", "map", f'"{DOT}"', CELL[:60], CELL], ["", CELL[:60], "map", "value", DOT, DOT],
        ["", DOT, "subscribe", "", "Say", CELL], [CELL, CELL, CELL, CELL, CELL, CELL],
        ["", "Red ball", CELL, f"redBall.{CELL}", "X", f"{{x}} {CELL}"], [f"# {CELL}", "", "", "", "", ""],
    ]  # fmt: skip
    return {
        SHEET: [BEHAVIOUR, *rows],
        "Devices": [["Stream", "Device", "Text", CELL], [CELL, "Say", CELL, CELL], [DOT, CELL, DOT, ""]],
        "Helpers": [["Name", "Formula", "Notes"], [CELL, CELL, CELL], ["helper", f'"{DOT}"', CELL]],
        "Scene": [["Time (s)", "Thing", "Does", "Value"], ["0", CELL, "appears", CELL], [CELL, "Red ball", CELL, DOT]],
        "Test <b>": [["Time (s)", "Send", "Expect", "Notes"], ["0", f"Red ball: {CELL}", CELL, CELL]],
        "Protocol": [["Field", "Value"], ["Title", CELL], ["Purpose", CELL], ["Robot", CELL], [CELL, CELL]],
        "<b>Mine": [[CELL, DOT], [CELL, DOT]],
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("texts")
    make_workbook(hostile_sheets(), folder / NAME)
    (folder / f"{CELL[:20].replace('/', '')}.md").write_text(f"## {CELL}\n\nno rows\n", encoding="utf-8")
    (folder / "<b>broken<b>.xlsx").write_bytes(b"no workbook")
    runs = folder / "runs"
    good = {"T": [BEHAVIOUR, ["", "Red ball", "map", "redBall.x", "MARKX", ""], ["", "MARKX", "map", '"said"', "MARKY", ""],
                  ["", "MARKY", "subscribe", "", "Say", ""]]}  # fmt: skip
    make_workbook(good, folder / "good.xlsx")
    who = {"participant": CELL, "condition": CELL, "operator": PERSON}
    settings = api.RunSettings(seconds=1.0, fast=True, film=False, out=runs / RUN, **who)
    assert api.run_apart(folder / "good.xlsx", settings).result is not None
    trace = runs / RUN / "trace.jsonl"
    inside = json.dumps(CELL, ensure_ascii=False)[1:-1]
    trace.write_text(
        trace.read_text(encoding="utf-8").replace("MARKX", inside).replace("said", inside), encoding="utf-8"
    )
    return folder


@pytest.fixture(scope="module")
def client(folder: Path) -> Any:
    client = visit(folder)
    for name, title in ((NAME, CELL[:90].replace("\u202e", "")), ("good.xlsx", "<b>before</b>")):
        sent = {"data": {"title": title}, "headers": {"X-RRP": "grid", "Origin": HOME}}
        assert client.post(f"{book(name)}/versions/keep", base_url=HOME, **sent).status_code == 200
    return client


def kinds_of_pages() -> list[str]:
    """Each kind of page, and of question that comes back, once."""
    sheets = [f"{book(NAME)}/sheet/{quote(sheet, safe='')}" for sheet in hostile_sheets()]
    run = f"/runs/{quote(RUN, safe='')}"
    asked = quote(CELL, safe="")
    return [
        "/", *sheets, f"{book(NAME)}/run", f"{book(NAME)}/versions", f"{book(NAME)}/print", "/runs",
        f"{book(NAME)}/print/protocol", f"{book(NAME)}/print/protocol?reader=participants", run, f"{run}/marbles", f"/runs?book={asked}", f"/runs?words={asked}",
        f"/compare?first=book/{quote(NAME, safe='')}&second=version/1/{quote(NAME, safe='')}", f"/compare?first={asked}&second={asked}",
        f"/help?q={asked}", f"/help?topic={asked}", f"/book/{asked}", f"/runs/{asked}", f"/{asked}", f"/?sort={asked}",
        f"{book('<b>broken<b>.xlsx')}", f"{book(NAME)}/sheet/{asked}", f"{run}/lookback", f"{run}/lookback/diagram/0", f"{run}/replay?with={asked}",
    ]  # fmt: skip


def addresses() -> list[str]:
    """Every page that shows something of a workbook, a run or a person, and every question that comes back."""
    run, asked = f"/runs/{quote(RUN, safe='')}", quote(CELL, safe="")
    return [
        *kinds_of_pages(), book(NAME), f"/compare?book={quote(NAME, safe='')}", f"/book/{asked}/print", "/compare",
        f"{book(NAME)}/run/{quote(SHEET, safe='')}", f"{book('good.xlsx')}/versions", f"/runs/{asked}/marbles",
        f"{run}/lookback/overview.json", f"{run}/lookback/piece/0.json", f"{run}/replay",
        f"{run}/replay/result?with=book/{quote(NAME, safe='')}",
    ]  # fmt: skip


# ---- the raw answers ----


def test_no_answer_has_a_text_as_markup(client: Any) -> None:
    shown = checked(client, book(NAME))
    assert html.escape("<script>alert(1)</script>") in shown and "{{7777*7}}" in shown
    for address in addresses():
        answer = get(client, address)
        assert answer.status_code < 500, address
        for markup in ("<script>alert", "<img src=x", "<svg/onload", "<b>bold", "<b>Eve", "</title></text", "<IMG SRC"):
            assert markup not in answer.text, (address, markup)
        assert not re.search(r'\b(?:href|src|action|xlink:href)="\s*(?:javascript|data|vbscript):', answer.text, re.I)
        assert not re.search(r"<[^>]*\son[a-z]+=(?!alert)", re.sub(r'"[^"]*"', '""', answer.text)), address
        assert "54439" not in answer.text, address  # nothing is calculated


def test_data_for_scripts_is_not_taken_for_a_page(client: Any) -> None:
    for address in (f"{book(NAME)}/vocabulary", "/run/now", f"/runs/{quote(RUN, safe='')}/series.json"):
        answer = get(client, address)
        assert answer.mimetype == "application/json" and answer.headers["X-Content-Type-Options"] == "nosniff"


def test_diagrams_have_only_shapes_and_texts(client: Any) -> None:
    answer = get(client, f"{book(NAME)}/diagram/1.svg")
    root = ElementTree.fromstring(answer.text)
    tags = {element.tag.split("}")[1] for element in root.iter()}
    assert tags <= {
        "svg",
        "title",
        "desc",
        "g",
        "path",
        "text",
        "tspan",
        "rect",
        "circle",
        "ellipse",
        "line",
        "polygon",
    }
    for element in root.iter():
        assert not {k for k in element.attrib if k.startswith("on") or "href" in k or k == "src"}


def test_files_are_taken_along_under_harmless_names(client: Any) -> None:
    run = f"/runs/{quote(RUN, safe='')}"
    for address in (f"{book(NAME)}/file", f"{run}/trace.csv", f"{run}/everything.zip", f"{run}/file/trace.jsonl",
                    f"{run}/file/diagram.svg", f"{book('good.xlsx')}/versions/2/file"):  # fmt: skip
        answer = get(client, address)
        assert answer.status_code == 200, address
        disposition = answer.headers["Content-Disposition"]
        assert disposition.startswith("attachment") and "\n" not in disposition and answer.mimetype != "text/html"
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        answer.close()


# ---- the real browser ----

WATCH = """
window.seen = [];
document.addEventListener("securitypolicyviolation", (e) => window.seen.push(`${e.violatedDirective} ${e.blockedURI} ${e.sample}`));
"""
STRANGERS = """() => [...document.querySelectorAll("img, script, iframe, object, embed, a[href], svg a, foreignObject")]
  .map((e) => e.getAttribute("src") ?? e.getAttribute("href") ?? e.tagName)
  .filter((at) => /^(x|javascript:|data:|https?:)/i.test(at) || /^(iframe|object|embed|foreignobject)$/i.test(at))"""


@pytest.fixture(scope="module")
def troubles() -> list[str]:
    """Things that a page did and that a text must not make it do."""
    return []


@pytest.fixture(scope="module")
def page_of(browser: Any, url: str, client: Any, troubles: list[str]) -> Callable[[str], Any]:
    """The page of somebody, that takes down what it must not do."""

    @cache
    def opened(name: str) -> Any:
        context = browser.new_context()
        context.add_init_script(WATCH)
        let_in(context, url, name)
        page = context.new_page()
        page.on("dialog", lambda d: (troubles.append(f"dialog {page.url}"), d.dismiss()))
        page.on("pageerror", lambda e: troubles.append(f"{page.url} {e}"))
        page.on("request", lambda r: r.url.startswith(url) or troubles.append(f"asked for {r.url}"))
        return page

    return opened


@pytest.mark.slow
@pytest.mark.parametrize("shown", [kinds_of_pages, pytest.param(addresses, marks=pytest.mark.soak)])
def test_nothing_runs_on_any_page(
    page_of: Callable[[str], Any], url: str, troubles: list[str], shown: Callable[[], list[str]]
) -> None:
    page = page_of(PERSON)
    for address in shown():
        page.goto(f"{url}{address}")
        if page.query_selector("#listen"):
            listening(page)
            page.wait_for_selector("#panels:not([aria-busy])", state="attached")
        becomes(lambda: page.evaluate(STRANGERS), [], address)
        becomes(lambda: page.evaluate("window.seen"), [], address)
        expect(page.locator("img[src=x], b:text-is('bold'), b:text-is('Eve')"), address).to_have_count(0)
        assert not troubles, (address, troubles)


@pytest.mark.slow
def test_people_cells_and_suggestions_are_shown_as_text(
    page_of: Callable[[str], Any], url: str, troubles: list[str]
) -> None:
    pages = [page_of(name) for name in ("Anna", PERSON)]
    for page in pages:
        page.goto(f"{url}{book('good.xlsx')}")
        listening(page)
        page.wait_for_selector("#panels:not([aria-busy])", state="attached")
    anna, eve = pages
    anna.wait_for_function("t => document.getElementById('people').textContent.includes(t)", arg=PERSON)
    for header in ("Input streams", "Connector", "Formula", "Output stream", "Notes"):
        column = eve.locator("thead th").evaluate_all(
            "(all, name) => all.findIndex((h) => h.dataset.name === name)", header
        )
        eve.locator(f"tbody tr:nth-child(2) > :nth-child({column + 1})").click(position={"x": 3, "y": 3})
        eve.keyboard.press("F2")
        eve.keyboard.press("Control+A")
        eve.keyboard.insert_text(CELL)
        eve.keyboard.press("Enter")
        arrived = (
            "n => document.querySelector(`tbody tr:nth-child(2) > :nth-child(${n})`).dataset.v?.includes('<script>')"
        )
        anna.wait_for_function(arrived, arg=column + 1)
    eve.wait_for_selector("body:not([data-saving])")
    eve.keyboard.press("Control+F")
    eve.keyboard.insert_text(CELL)
    for page in pages:
        page.wait_for_function("() => document.getElementById('panels').textContent.includes('<script>alert(1)')")
        eventually(lambda: page.evaluate("window.seen") == [] and page.evaluate(STRANGERS) == [])
        expect(page.locator("img[src=x], svg[onload], b:text-is('bold')")).to_have_count(0)
    assert not troubles


@pytest.mark.usefixtures("unfilmed")
def test_a_run_shows_what_is_said_and_sent_as_text(
    page_of: Callable[[str], Any], url: str, folder: Path, troubles: list[str]
) -> None:
    said = "<img src=x onerror=alert(1)><b>Eve</b>"
    rows = [["", "Red ball", "map", f'"{said}"', "<b>X</b>", ""], ["", "<b>X</b>", "subscribe", "", "Say", ""]]
    devices = [["Stream", "Device", "Button"], ["<b>Go</b>", "Operator button", said]]
    make_workbook({"<b>T": [BEHAVIOUR, *rows], "Devices": devices}, folder / "run.xlsx")
    page = page_of(PERSON)
    page.goto(f"{url}/book/run.xlsx/run")
    listening(page)
    page.wait_for_selector("#panels:not([aria-busy])", state="attached")
    act = """async ([action, body]) => { const r = await fetch(`/book/run.xlsx/run/${action}`, {method: "POST",
      headers: {"Content-Type": "application/json", "X-RRP": "grid"}, body: JSON.stringify(body)}); return [r.status, await r.text()]; }"""
    who = {"client": "c", "name": PERSON}
    wish = {**who, "participant": said, "condition": said, "operator": said, "until": "stop", "mode": "simulated"}
    begun = page.evaluate(act, ["start", wish])  # read once: the answer to what is sent
    assert begun[0] == 200, begun
    page.wait_for_selector("body[data-run=running]")
    for action, more in (
        ("mark", {"note": CELL}), ("send", {"stream": "Red ball", "text": CELL}), ("press", {"label": said}),
        ("scene", {"thing": CELL[:90], "verb": said, "value": CELL[:190]}), ("put", {"thing": said, "x": 1, "y": 0, "z": 0}),
        ("switch", {"behaviour": said, "on": False}),
    ):  # fmt: skip
        # read once: it is the answer to what is sent
        assert page.evaluate(act, [action, {**who, **more}])[0] in (200, 400), action
    page.wait_for_function(
        "t => document.getElementById('log').textContent.includes(t)", arg="<script>alert(1)</script>"
    )
    page.wait_for_function("t => document.getElementById('log').textContent.includes(t)", arg=said)
    stop = """async (name) => (await fetch(`/run/stop?${new URLSearchParams({ name })}`,
      {method: "POST", headers: {"X-RRP": "grid"}})).status"""
    assert page.evaluate(stop, PERSON) == 200  # read once: the answer to what is sent
    page.wait_for_selector("body[data-run=ended]")
    eventually(lambda: page.evaluate("window.seen") == [] and page.evaluate(STRANGERS) == [] and not troubles)
    expect(page.locator("img[src=x], b:text-is('bold'), b:text-is('Eve'), b:text-is('X')")).to_have_count(0)
