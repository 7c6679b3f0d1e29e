"""Every page can be used by everyone: axe-core finds nothing (contrast AA among it) in each language, in light and dark,
wide and narrow, and no state is told by colour alone. The robot in 3D is looked at in test_run_robot.py."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from chromium import LOOKS, axe, let_in, serving, violations_by_look

from rrp_sheets.help.publishing import write_site
from rrp_sheets.resources import bundled
from rrp_sheets.texts import LANGUAGES
from rrp_sheets.web.password import Password
from rrp_sheets.web.requests import Lan
from rrp_sheets.workbook.files import make_workbook

if not axe():
    pytest.skip("axe-core cannot be fetched", allow_module_level=True)

from playwright.sync_api import expect

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
ROWS = [
    ["", "Red ball", "map", "redBall.distence", "Distance", ""],
    ["no", "Distance", "filter", "1", "Close", "off"],
    ["", "Red ball", "subscribe", "", "Head tracker", ""],
]
SENTENCES = [  # runs, with an error in a row, a button, a warning
    HEADER,
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "map", "1 / (distance - distance)", "Bad", ""],
    ["", "Bad", "subscribe", "", "Print", ""],
    ["", "Start", "map", '"hello"', "Words", ""],
    ["", "Words", "subscribe", "", "Say", ""],
    ["no", "Distance", "subscribe", "", "Head tracker", ""],
]
DEVICES = [["Stream", "Device", "Label", "Notes"], ["Start", "OperatorButton", "Start", ""]]
SCENE = [["Time (s)", "Thing", "Does", "Value"], ["0", "Red ball", "appears", "at 1, 0, 0.4"]]
SHEETS = ("Devices", "Helpers", "Scene", "Test", "Protocol", "Tracking")  # the last is what much is opened over
OPENED = "dialog[open], [role=menu], #find-bar, #help, .editor textarea"
ALL_LOOKS = [(scheme, width) for scheme in ("light", "dark") for width in (1280, 400)]
# Whatever has a colour with a meaning, and how it is told without the colour: by a word or a drawn shape within.
COLOURED = ".name.sensor, .name.stream, .name.actuator, .severity, .badge, .is-error, .is-warning, [aria-invalid=true], .stop, .mode"
WORDLESS = """selector => [...document.querySelectorAll(selector)].filter((e) => {
    const shown = e.checkVisibility({ contentVisibilityAuto: true }) && e.getBoundingClientRect().width > 0;
    const shape = e.querySelector("svg, img, input[type=checkbox]") || getComputedStyle(e, "::before").content !== "none";
    return shown && !e.innerText.trim() && !e.ariaLabel && !shape;
}).map((e) => e.outerHTML.slice(0, 120))"""

# Pictures are given their names with their drawing, not some time after it.
WATCH_NAMES = """(() => {
    const nameless = "[role=img]:not([aria-label], [aria-labelledby], [aria-hidden=true], :has(> title))";
    window.onceNameless = [];
    new MutationObserver(() => {
        for (const e of document.querySelectorAll(nameless)) if (e.checkVisibility()) window.onceNameless.push(e.outerHTML.slice(0, 120));
    }).observe(document, { childList: true, subtree: true, attributes: true, attributeFilter: ["hidden"] });
})()"""


class Tour:
    """A browser page that goes from screen to screen."""

    def __init__(self, page: Any, url: str) -> None:
        self.page, self.url = page, url
        page.add_init_script(WATCH_NAMES)

    def enter(self, language: str = "en") -> None:
        if not self.page.context.cookies():
            let_in(self.page.context, self.url)
        self.page.context.add_cookies([{"name": "rrp-language", "value": language, "url": self.url}])
        if self.page.url == "about:blank":
            return
        else:  # what one screen leaves to be typed on is not offered on the next
            self.page.evaluate("sessionStorage.clear()")

    def open(self, address: str, ready: str = "body") -> None:
        self.page.goto(f"{self.url}{address}")
        self.page.wait_for_selector(ready, state="attached")

    def sheet(self, book: str, sheet: str) -> None:
        self.open(f"/book/{book}/sheet/{sheet}", "body[data-ready]")
        self.page.wait_for_selector("#panels:not([aria-busy=true])", state="attached")

    def tracking(self) -> None:
        """The first sheet; what the screen before has opened over it is closed."""
        language = next(c["value"] for c in self.page.context.cookies() if c["name"] == "rrp-language")
        if (
            self.page.url.endswith("/book/all.xlsx/sheet/Tracking")
            and self.page.locator(f"html[lang={language}]").count()
        ):
            for _ in range(3):  # suggestions close before their cell
                self.page.keyboard.press("Escape")
                if not self.page.locator(OPENED).filter(visible=True).count():
                    return
        self.sheet("all.xlsx", "Tracking")

    def run(self) -> str:
        """The address of the newest run."""
        listed = self.page.request.get(f"{self.url}/runs").text()
        return re.findall(r'href="(/runs/\d[^"?/]*)"', listed)[0]

    def violations(self, looks: list[tuple[str, int]], unchanged: Sequence[str] = ()) -> dict[str, list[str]]:
        """Violations on the screen, by its look; parts that are as on another screen need not be looked at again."""
        found = violations_by_look(self.page, looks, unchanged)
        if wordless := self.page.evaluate(WORDLESS, COLOURED):
            found["by colour alone"] = wordless
        if nameless := self.page.evaluate("onceNameless"):
            found["without a name at first"] = nameless
        return found


def shelf(tour: Tour) -> None:
    tour.open("/")


def shelf_told(tour: Tour) -> None:
    tour.open("/", "form.new-book[data-htmx-powered]")
    tour.page.fill(".new-book [name=name]", "a/b")
    tour.page.keyboard.press("Enter")
    tour.page.wait_for_selector(".notice.is-error")


def menu_of_the_page(tour: Tour) -> None:
    tour.open("/")
    tour.page.click(".page-menu summary")


def nothing_yet(tour: Tour) -> None:
    """An empty sheet, which offers a first row."""
    tour.sheet("empty.xlsx", "T")
    tour.page.wait_for_selector("[data-first-row]")


def tutorial(tour: Tour) -> None:
    tour.sheet("tutorial.xlsx", "My robot")
    tour.page.wait_for_selector("#lesson .do-list .is-now")


def too_long(tour: Tour) -> None:
    """A sheet that is drawn in parts only."""
    tour.sheet("long.xlsx", "T")
    tour.page.wait_for_selector(".part-list")


def sheet(name: str) -> Callable[[Tour], None]:
    return lambda tour: tour.sheet("all.xlsx", name)


def wrong(tour: Tour) -> None:
    tour.sheet("wrong.xlsx", "T")
    tour.page.wait_for_selector("td[aria-invalid=true]")


def editing(tour: Tour) -> None:
    tour.tracking()
    tour.page.keyboard.type("r")
    tour.page.wait_for_selector("[role=option]")


def offered(tour: Tour) -> None:
    """Type into a cell, load the page again, and wait for the offered draft."""
    tour.sheet("all.xlsx", "Tracking")
    editing(tour)
    tour.page.reload()
    tour.page.wait_for_selector("dialog[open] textarea")


def menu(tour: Tour) -> None:
    tour.tracking()
    tour.page.click("[data-do=rows]")


def finding(tour: Tour) -> None:
    tour.tracking()
    tour.page.click("[data-do=find]")


def naming(tour: Tour) -> None:
    tour.tracking()
    tour.page.click("[data-do=name]")


def helped(tour: Tour) -> None:
    tour.tracking()
    tour.page.locator("[role=gridcell]:has-text('Red ball')").first.click(position={"x": 3, "y": 3})
    tour.page.keyboard.press("F1")
    tour.page.wait_for_selector("#help:not([hidden]) .help-topic")


def conflict(tour: Tour) -> None:
    tour.sheet("all.xlsx", "Tracking")
    tour.page.route("**/cells", lambda route: route.fulfill(json={
        "message": "Mika has also changed this cell.",
        "clashes": [{"sheet": "Tracking", "row": tour.page.locator("tbody tr").first.get_attribute("id"), "column": 2,
                     "place": "B2", "mine": "a", "theirs": "b", "who": "Mika"}], "rows": [],
    }))  # fmt: skip
    tour.page.keyboard.type("a")
    tour.page.keyboard.press("Enter")
    tour.page.wait_for_selector("dialog:not(#run-dialog)")


def asked(tour: Tour) -> None:
    tour.tracking()
    tour.page.click("[data-run=start]")
    tour.page.wait_for_selector("#run-dialog[open]")


def running(tour: Tour) -> None:
    if not tour.page.locator("#run-dialog[open]").count():
        asked(tour)
    tour.page.click("#run-dialog [type=submit]")
    tour.page.wait_for_selector("body[data-run=running]")
    tour.page.wait_for_selector("#log li")


def paused(tour: Tour) -> None:
    tour.page.click("[data-run=pause]")
    tour.page.wait_for_selector("body[data-run=paused]")


def ended(tour: Tour) -> None:
    tour.page.click("[data-run=stop]")
    tour.page.wait_for_selector("body[data-run=ended]")


def record(tour: Tour) -> None:
    tour.open(tour.run(), "#marbles svg")


def lookback(tour: Tour) -> None:
    tour.open(f"{tour.run()}/lookback#t=1.5", "#moments button")


def replay(tour: Tour) -> None:
    tour.open(f"{tour.run()}/replay?with=book/greeter.xlsx", ".replay-verdict")


def deleting(tour: Tour) -> None:
    tour.open("/runs")
    tour.page.locator(".choose input").first.check()
    tour.page.click("button[data-looks]")
    tour.page.wait_for_selector(".deleting [name=typed]")


def versions(tour: Tour) -> None:
    tour.open("/book/all.xlsx/versions")
    tour.page.fill(".keep-form [name=title]", "before the pilot")
    tour.page.keyboard.press("Enter")
    tour.page.get_by_text("before the pilot").first.wait_for()


def refused(tour: Tour) -> None:
    tour.page.context.clear_cookies()
    tour.open("/")


def at(address: str, ready: str = "body") -> Callable[[Tour], None]:
    return lambda tour: tour.open(address, ready)


# In this order: a run must have been started before it can end, and ended before there is a record.
SCREENS: dict[str, Callable[[Tour], None]] = {
    "shelf": shelf, "shelf, told what is wrong": shelf_told,
    "sheet with problems": wrong, "conflict": conflict, "draft offered": offered, **{f"sheet {name}": sheet(name) for name in SHEETS},
    "editing with suggestions": editing, "menu of rows": menu, "find": finding, "name": naming, "help in the grid": helped,
    "run dialog": asked, "run panel, running": running, "run panel, paused": paused, "run panel, ended": ended,
    "runs": at("/runs"), "record": record, "looking back": lookback, "replay": replay, "deleting runs": deleting,
    "no versions": at("/book/empty.xlsx/versions"), "versions": versions, "no runs": at("/runs?book=empty.xlsx"),
    "empty sheet": nothing_yet, "tutorial": tutorial, "long sheet": too_long, "menu of the page": menu_of_the_page,
    "compare": at("/compare?first=book/all.xlsx&second=book/wrong.xlsx", ".changed-rows svg"),
    "print": at("/book/all.xlsx/print", ".protocol"), "nothing there": at("/book/none.xlsx"),
    "print for participants": at("/book/all.xlsx/print?reader=participants", ".for-participants"),
    "help": at("/help?topic=scene", "main.docs-main"), "help, devices": at("/help/devices.html", ".diagram svg"),
    "help, a code": at("/help/FORM007.html?lang=ja", ".help-grid"), "help, connectors": at("/help/connectors.html?lang=ja", ".marble-picture"),
    "help, searched": at("/help/search.html?q=hand", ".docs-hits li"),
    "refused": refused,
}  # fmt: skip

ROWS_ELSEWHERE, PANELS, BARS = "[role=grid] tbody tr:not(:has(.at))", "#panels", (".topbar", ".runbar")
UNCHANGED: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("editing with suggestions", "menu of rows", "find", "name", "help in the grid", "run dialog", "conflict",
                     "draft offered", "run panel, paused"), (ROWS_ELSEWHERE, PANELS)),
    **dict.fromkeys((f"sheet {name}" for name in SHEETS[:-1]), BARS),
}  # fmt: skip
"""Parts that another screen shows in the same way: rows without the cursor and the panels beside them, as on “sheet Tracking”,
the bars above them, and what stands still in a run as while it goes on."""


@pytest.fixture(scope="module")
def tour(tmp_path_factory: pytest.TempPathFactory, browser: Any) -> Iterator[Tour]:
    folder = tmp_path_factory.mktemp("books")
    test = [["Time (ms)", "Stream", "Send", "Expect"], ["0", "Red ball", "distance=1", ""], ["0", "Distance", "", "1"]]
    helpers = [["Name", "Inputs", "Formula", "Notes"], ["Reach", "", "0.5", ""]]
    protocol = [["Field", "Value"], ["Title", "All of it"], ["Robot", "nao"]]
    sheets = {
        "Tracking": SENTENCES,
        "Devices": DEVICES,
        "Helpers": helpers,
        "Scene": SCENE,
        "Test": test,
        "Protocol": protocol,
    }
    make_workbook(sheets, folder / "all.xlsx")
    make_workbook({"T": [HEADER, *ROWS]}, folder / "wrong.xlsx")
    shutil.copy(bundled("workbooks", "greeter.xlsx"), folder)
    shutil.copy(bundled("templates", "workbooks", "tutorial.xlsx"), folder)
    make_workbook({"T": [HEADER, [""] * 6]}, folder / "empty.xlsx")
    long = [["", "Red ball", "map", "1", f"A{n}", ""] for n in range(502)]
    make_workbook({"T": [HEADER, ["# Waving", *[""] * 5], *long]}, folder / "long.xlsx")
    (folder / "broken.xlsx").write_bytes(b"no workbook")
    with serving(folder) as url:
        # what moves by itself, as values of a run do, would let each look wait
        context = browser.new_context(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
        yield Tour(context.new_page(), url)


def looks_of(screen: str) -> list[tuple[str, int]]:
    """The looks of a screen; sheets of the same template have one look each, by turns."""
    sheets = [f"sheet {name}" for name in SHEETS[:-1]]
    return [LOOKS[sheets.index(screen) % len(LOOKS)]] if screen in sheets else LOOKS


@pytest.mark.slow
@pytest.mark.parametrize(("language", "screen"), [(language, screen) for language in LANGUAGES for screen in SCREENS])
def test_no_screen_has_a_violation(tour: Tour, language: str, screen: str) -> None:
    tour.enter(language)
    SCREENS[screen](tour)
    expect(tour.page.locator("html")).to_have_attribute("lang", "en" if screen == "refused" else language)
    assert tour.violations(looks_of(screen), UNCHANGED.get(screen, ())) == {}
    tour.page.unroute_all()


@pytest.mark.slow
def test_no_published_help_page_has_a_violation(tour: Tour, tmp_path: Path) -> None:
    write_site(tmp_path / "help")
    page = tour.page.context.browser.new_page(reduced_motion="reduce")
    for place in ("index.html", "en/index.html", "ja/formulas.html", "ja/search.html?q=赤"):
        page.goto(f"{(tmp_path / 'help').as_uri()}/{place}")
        assert violations_by_look(page, LOOKS) == {}, place
    page.close()


@pytest.mark.slow
def test_the_login_has_no_violation(tour: Tour, tmp_path: Path) -> None:
    lan = Lan(Password("green otter lamp"), ("127.0.0.1",))
    with serving(tmp_path, lan) as url:
        login = Tour(tour.page.context.browser.new_page(), url)
        login.open("/")
        login.page.get_by_label("Your name").fill("Anna")
        login.page.get_by_label("Password").fill("red otter lamp")
        login.page.keyboard.press("Enter")
        login.page.get_by_role("alert").wait_for()
        assert login.violations(LOOKS) == {}
        login.page.close()


@pytest.mark.soak
@pytest.mark.parametrize("screen", SCREENS)
def test_no_screen_has_a_violation_in_its_other_looks(tour: Tour, screen: str) -> None:
    tour.enter()
    SCREENS[screen](tour)
    assert tour.violations([look for look in ALL_LOOKS if screen in UNCHANGED or look not in looks_of(screen)]) == {}
    tour.page.unroute_all()
