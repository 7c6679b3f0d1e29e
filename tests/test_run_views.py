"""Views of a run besides the robot: its eye, speech, plots, drives, and the diagram that lights up."""

from __future__ import annotations

import io
import re
from base64 import b64encode
from collections.abc import Iterator
from typing import Any

import pytest
from chromium import PAGES, becomes, eventually, frames, requests_of, some, until

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
from PIL import Image
from playwright.sync_api import expect
from run_panel import BOOK, Panel

BOOKS = {"b.xlsx": BOOK}


@pytest.fixture(scope="module")
def panel(browser: Any, url: str) -> Iterator[Panel]:
    made = Panel(browser, url)
    yield made
    assert not made.errors, made.errors
    PAGES.put_back(made.page)


@pytest.mark.slow
def test_without_webgl_words_say_so(panel: Panel) -> None:
    panel.live(t=1.0, robot=panel.real.robot)
    eventually(lambda: "cannot draw the robot in 3D" in panel.page.inner_text("#robot3d"))


def test_the_box_is_where_the_ball_is_in_the_picture(panel: Panel) -> None:
    panel.live(t=2.0, fields={"Red ball": panel.real.fields}, eye=5, streams={"Red ball": stream("…", 2.0, "sensor")})
    panel.picture()
    panel.page.wait_for_selector("#eye svg.shown rect.seen")
    pixels = np.asarray(Image.open(io.BytesIO(panel.real.jpeg)).convert("RGB"), dtype=int)
    high, wide = pixels.shape[:2]
    v, u = np.nonzero((pixels[:, :, 0] > 110) & (pixels[:, :, 1] < 80))
    seen = some(panel.page.locator("#eye rect.seen").bounding_box)
    frame = some(panel.page.locator("#eye canvas").bounding_box)
    scale = wide / frame["width"]
    left, top = (seen["x"] - frame["x"]) * scale, (seen["y"] - frame["y"]) * scale
    edges = (left, left + seen["width"] * scale, top, top + seen["height"] * scale)
    assert edges == pytest.approx((u.min(), u.max() + 1, v.min(), v.max() + 1), abs=4), "pixels of the camera"
    assert frame["height"] / frame["width"] == pytest.approx(high / wide, abs=0.02)
    words = f"Red ball {panel.real.fields['distance']:.2f} m"
    becomes(lambda: panel.page.locator("#eye svg text").text_content(), words)
    eventually(lambda: words in (panel.page.locator("#eye canvas").get_attribute("aria-label") or ""))
    panel.live(t=2.6)
    becomes(lambda: panel.page.locator("#eye rect.seen").count(), 0, "what was seen long ago is not shown")


def test_the_eye_is_open_only_where_it_is_seen_and_shows_the_newest_picture(panel: Panel) -> None:
    """Its pictures come with the events of the page: none is asked for, and none comes to a page that is hidden."""
    page, drawn = panel.page, panel.page.locator("#eye canvas")
    panel.view("log")
    panel.live(t=2.7, eye=70)
    becomes(panel.looked, [True])
    before = int(some(lambda: drawn.get_attribute("data-drawn")))
    flood = """([jpeg, n]) => { for (let i = 0; i < n; i++)
        document.dispatchEvent(new CustomEvent("rrp:eye", { detail: { jpeg, age: 0 } })); }"""
    with requests_of(page) as asked:
        page.evaluate(flood, [b64encode(panel.real.jpeg).decode(), 50])
        eventually(lambda: int(drawn.get_attribute("data-drawn")) > before)
        frames(page, 10)
        # read once: nothing is drawn any more
        number = int(drawn.get_attribute("data-drawn") or 0)
    assert number <= before + 2, "pictures that nobody could have seen are not drawn"
    assert not asked
    # a picture like the one before is not sent again: that one is not old
    panel.picture(age=9)
    eventually(lambda: re.fullmatch(r"Robot’s eye\s*old by \d+ s", page.locator("#eye figcaption").inner_text()))
    panel.live(t=2.8, eye=71)
    page.wait_for_function("() => !document.querySelector('#eye figcaption').innerText.includes('old')")
    # hidden, out of sight, a new connection, the end of the run
    hide = """on => { Object.defineProperty(document, "hidden", { value: on, configurable: true });
        document.dispatchEvent(new Event("visibilitychange")); }"""
    page.evaluate("() => { document.querySelector('.inset').hidden = true; }")
    becomes(panel.looked, [True, False])
    page.evaluate("() => { document.querySelector('.inset').hidden = false; }")
    becomes(panel.looked, [True, False, True])
    panel.tell("rrp:connection", lost=False)
    becomes(panel.looked, [True, False, True, True], "a new connection knows nothing")
    panel.run("ended")
    panel.tell("rrp:connection", lost=False)
    frames(page, 10)
    assert len(panel.looked()) == 4
    panel.run()
    becomes(panel.looked, [True, False, True, True, True])
    page.evaluate(hide, True)
    frames(page, 10)
    page.evaluate(hide, False)
    panel.run()  # the page's own run is none
    eventually(lambda: len(panel.looked()) > 5, "the connection of a hidden page was closed")


def stream(value: str, at: float, kind: str = "stream") -> dict[str, Any]:
    return {"v": value, "at": at, "n": 1, "kind": kind}


@pytest.mark.slow
def test_what_is_said_stands_in_a_bubble_with_its_age(panel: Panel) -> None:
    panel.live(t=3.0, robot={**panel.real.robot, "saying": "Hello Kai"})
    bubble = panel.page.locator("#speech .bubble")
    becomes(lambda: bubble.inner_text().strip(), "Hello Kai")
    becomes(lambda: panel.page.locator("#speech [aria-live]").text_content(), "The robot says: Hello Kai")
    panel.live(t=4.0, robot={**panel.real.robot, "saying": ""})
    panel.live(t=9.5, robot={**panel.real.robot, "saying": ""})
    eventually(lambda: "5 s ago" in bubble.inner_text() and "last said" not in bubble.inner_text())
    picture = some(panel.page.locator("#pictures").bounding_box)
    panel.live(t=14.0, robot={**panel.real.robot, "saying": ""})
    becomes(lambda: bubble.inner_text().split("\n"), ["last said: Hello Kai", "10 s ago"])
    panel.live(t=15.0, robot={**panel.real.robot, "saying": "Now I tell you something long. " * 9})
    eventually(lambda: (at := bubble.bounding_box())["y"] >= picture["y"] and at["height"] < 60, "two lines at most")
    becomes(lambda: panel.page.locator("#pictures").bounding_box(), picture, "nothing jumps")
    panel.tell("rrp:run", id="r2", phase="starting", book="b.xlsx", t=0)
    eventually(lambda: not bubble.is_visible(), "nothing was said yet")
    panel.run()
    panel.live(t=9.0, robot={**panel.real.robot, "saying": "Hello Kai"})
    becomes(lambda: panel.page.locator("#speech [aria-live]").text_content(), "The robot says: Hello Kai")


@pytest.mark.slow
def test_plots_and_drives(panel: Panel) -> None:
    page = panel.page
    panel.view("plots")
    events = []
    for n in range(120):
        t = 10 + n * 0.5
        points = [["Distance", [[t, n / 100]]], ["Red ball.x", [[t, 0.1]]], ["Red ball.id", [[t, 1]]]]
        drives = [["head", "T!4", 20.0, None]] if n == 20 else [["voice", "T!6", 62.0, 65.0]] if n == 110 else []
        events.append(
            {"t": t, "streams": {"Distance": stream(f"{n / 100:.2f} m", t)}, "plots": points, "drives": drives}
        )
    page.evaluate("all => { for (const detail of all) document.dispatchEvent(new CustomEvent('rrp:live', { detail })); }",
                  events)  # fmt: skip
    shown = page.locator("#plots li")
    becomes(lambda: shown.locator(".head span").all_text_contents(), ["Distance", "Red ball.x"], "an id is no curve")
    becomes(lambda: shown.first.locator("canvas").count(), 1)
    until(page, lambda: (panel.live(t=70.0), shown.first.locator("b").text_content())[1] == "1.19 m")
    colours = (
        "c => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;"
        " for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200 && d[i + 1] > d[i] + 40) n++; return n; }"
    )
    eventually(lambda: shown.first.locator("canvas").evaluate(colours) > 100, "the curve is in the streams' green")
    page.get_by_text("Choose what is plotted").click()
    page.get_by_role("checkbox", name="Red ball.id").check()
    becomes(shown.count, 3)
    page.get_by_text("As a table").click()
    page.wait_for_selector("#plots tr:has-text('Distance')")
    cells = page.locator("#plots tr:has-text('Distance') td")
    expect(cells.first).to_have_text("1.19 m")
    eventually(lambda: float(cells.nth(1).text_content()) > 0.5, "of the last 30 seconds only")
    panel.view("drives")
    expect(page.locator("#drives text.row")).to_have_text(["4", "6"])
    head, voice = (some(page.locator("#drives rect.busy").nth(n).bounding_box) for n in (0, 1))
    assert head["x"] < voice["x"] < head["x"] + head["width"]
    becomes(
        lambda: voice["width"] / page.locator("#drives path.rule").first.bounding_box()["width"],
        pytest.approx(0.1, abs=0.02),
    )
    page.wait_for_selector("#drives svg[aria-label*='head: row T!4']")


def test_a_whole_record_is_plotted_with_the_value_under_the_pointer(panel: Panel) -> None:
    page = panel.page
    panel.view("plots")
    page.evaluate("""async () => {
        const { plotRecord } = await import("/static/run/plots.js");
        const root = document.createElement("div");
        root.id = "record";
        document.querySelector("#plots").before(root);
        const points = [...Array(100).keys()].map((n) => [n / 10, n]);
        window.away = plotRecord(root, [{ name: "A", unit: "m", points }, { name: "B", kind: "sensor", points: [] }]);
    }""")
    heads = page.locator("#record .head")
    becomes(heads.all_inner_texts, ["A\n0 to 99 m", "B\nno value"])
    over = page.locator("#record .u-over").first
    over.hover()
    expect(heads.first).to_have_text(re.compile(r"^A.* s: .* m$", re.DOTALL))
    told = heads.first.inner_text()  # read once: the pointer rests, so it stays
    assert float(told.split("\n")[1].split(" s")[0]) == pytest.approx(5, abs=1), "the middle of ten seconds"
    page.evaluate("away()")
    becomes(lambda: page.locator("#record canvas").count(), 0)
    page.evaluate("document.querySelector('#record').remove()")


def test_rows_and_streams_of_the_last_second_are_lit_in_the_diagram(panel: Panel) -> None:
    page, ids = panel.page, panel.ids
    panel.view("diagram")
    panel.live(
        t=80.0, rows={ids[0]: row("0.46 m", 79.9), ids[1]: row("0.46 m", 70.0), ids[3]: {**row("", 79.9), "e": "Oh"}},
        streams={"Red ball": stream("…", 79.9, "sensor"), "Distance": stream("0.46 m", 79.9)},
    )  # fmt: skip
    lit = "[...document.querySelectorAll('#diagram .lit[data-row]')].map((b) => b.dataset.row)"
    becomes(lambda: page.evaluate(lit), ["2", "5"])
    becomes(lambda: page.locator("#diagram .failed").get_attribute("data-row"), "5")
    becomes(lambda: page.locator("#diagram [data-name='Distance'] .now").text_content(), "0.46 m")
    names = some(lambda: page.evaluate(
        "Object.fromEntries([...document.querySelectorAll('#diagram [role=button]')].map("
        "b => [b.id, b.dataset.row ?? b.dataset.name]))"))  # fmt: skip
    wires = "[...document.querySelectorAll('#diagram .arrow.lit')].map((w) => [w.dataset.from, w.dataset.to])"
    becomes(
        lambda: sorted((names[a], names[b]) for a, b in page.evaluate(wires)), [("2", "Distance"), ("Red ball", "2")]
    )
    panel.live(t=81.5)
    becomes(lambda: page.locator("#diagram .lit").count(), 0)
    world = page.locator("#diagram .arrow.world")
    becomes(
        lambda: (names[world.get_attribute("data-from")], names[world.get_attribute("data-to")]), ("Say", "Say done")
    )


def row(value: str, at: float) -> dict[str, Any]:
    return {"v": value, "at": at, "n": 1, "e": ""}


@pytest.mark.slow
def test_the_diagram_leads_to_the_rows_and_back_and_keeps_zoom_and_focus(panel: Panel) -> None:
    page = panel.page
    panel.view("diagram")
    box = page.get_by_role("button", name="Row 3, filter: distance < 0.8")
    box.click()
    becomes(lambda: page.inner_text("#formula-bar b"), "C3")
    eventually(lambda: "here" in (box.get_attribute("class") or ""))
    becomes(lambda: page.locator("#diagram .arrow.here").count(), 2)
    page.get_by_role("button", name="Larger").click()
    zoom = "getComputedStyle(document.querySelector('#panels')).getPropertyValue('--zoom')"
    eventually(lambda: float(page.evaluate(zoom)) > 1.1)
    wide = some(page.locator("#diagram svg").bounding_box)["width"]
    box.focus()
    page.keyboard.press("ArrowDown")
    becomes(lambda: page.evaluate("document.activeElement.dataset.name"), "Close ball")
    page.evaluate(
        "new Promise((done) => { document.addEventListener('htmx:after:swap', done, { once: true });"
        " htmx.trigger('#panels', 'recheck'); }).then(() => 0)"
    )
    becomes(lambda: page.evaluate("document.activeElement.dataset.name"), "Close ball")
    becomes(lambda: page.locator("#diagram svg").bounding_box()["width"], pytest.approx(wide, abs=1))
    page.keyboard.press("Enter")
    becomes(lambda: page.inner_text("#formula-bar b"), "C3", "a stream leads to the row that makes it")
    page.get_by_role("button", name="Fit").click()
    size = "(t) => parseFloat(t.getAttribute('font-size')) * t.getScreenCTM().a"
    sizes = f"[...document.querySelectorAll('#diagram text')].map({size})"
    eventually(lambda: min(page.evaluate(sizes)) >= 9.5, "readable without glasses")


LINES = [{"i": n, "t": 4.0 * n, "kind": kind, "text": "x", "row": "", "id": "", "by": "", "stream": "", "sound": ""}
         for n, kind in enumerate(("start", "speech", "mark", "button", "error"), 1)]  # fmt: skip


def test_the_timeline_is_under_every_tab_and_leads_back_to_its_time(panel: Panel) -> None:
    page, line = panel.page, panel.page.locator("#timeline")
    panel.tell("rrp:run", id="r4", phase="running", book="b.xlsx", t=24, folder="run 4")
    panel.tell("rrp:log", lines=LINES)
    becomes(lambda: line.locator("i").evaluate_all("marks => marks.map((m) => m.className)"),
            ["of-say", "of-mark", "of-hand", "of-error"])  # fmt: skip
    for n, view in ((2, "plots"), (3, "diagram"), (1, "log")):
        page.keyboard.press(f"Control+{n}")
        becomes(lambda: page.get_attribute(".below", "data-view"), view)
        expect(line).to_be_visible()
    box = some(line.bounding_box)
    assert box["height"] == pytest.approx(34, abs=1)
    page.mouse.move(box["x"] + box["width"] * 0.4, box["y"] + 10)
    becomes(line.locator("em").inner_text, "Look back at 0:12.0")
    page.evaluate("document.getElementById('timeline').addEventListener('click', (e) => e.preventDefault())")
    page.mouse.down()
    page.mouse.up()
    expect(line).to_have_attribute("href", re.compile("/runs/run%204/lookback#t=12.0$"))
    panel.tell("rrp:run", id="r4", phase="running", book="b.xlsx", t=31, folder="run 4")
    becomes(lambda: line.locator("small").nth(3).inner_text(), "0:30", "a longer run has a longer line")
    panel.run()


def test_when_it_has_ended_look_back_takes_the_place_of_pause(panel: Panel) -> None:
    page = panel.page
    back, pause = page.get_by_role("link", name="Look back", exact=True), page.get_by_role("button", name="Pause")
    expect(pause).to_be_visible()
    panel.tell("rrp:run", id="r5", phase="stopping", book="b.xlsx", t=3, folder="one")
    expect(page.locator("#run-phase")).to_have_text("Stopping: the robot is moving to its rest position …")
    panel.tell("rrp:run", id="r5", phase="ended", book="b.xlsx", t=3, folder="one",
               ended={"words": "Over.", "remedy": "", "how": "time", "broken": False})  # fmt: skip
    expect(back).to_have_attribute("href", "/runs/one/lookback")
    expect(pause).to_be_hidden()
    panel.run()
    expect(pause).to_be_visible()
    expect(back).to_be_hidden()


def test_a_phone_shows_of_each_row_its_number_output_and_value(panel: Panel) -> None:
    page = panel.page
    page.set_viewport_size({"width": 400, "height": 800})
    row = page.locator(f"[id='{panel.ids[0]}']")
    script = "row => [...row.cells].filter((c) => c.clientWidth > 20).map((c) => c.className.split(' ')[0])"
    becomes(lambda: row.evaluate(script), ["number", "output", "example"])
    eventually(lambda: page.evaluate("document.documentElement.scrollWidth") <= 400)
    page.get_by_role("button", name="All columns").click()
    eventually(lambda: len(row.evaluate(script)) > 5)
    page.get_by_role("button", name="All columns").click()
    page.set_viewport_size({"width": 1280, "height": 900})


def test_a_press_of_restart_is_not_lost_when_its_reason_changes(panel: Panel) -> None:
    panel.run(restart="Row 3 has another output stream.")
    restart = panel.page.locator("#run-notice button").element_handle()
    panel.run(restart="Tracking has more active rows.")
    expect(panel.page.locator("#run-notice")).to_contain_text("Tracking has more active rows.")
    becomes(lambda: restart.evaluate("button => button.isConnected"), True)
