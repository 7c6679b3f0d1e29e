"""What one sees of a run: robot, eye, speech, plots, drives, and the diagram that lights up; with a real world's data."""

from __future__ import annotations

import io
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from chromium import FLAGS_3D, GridPage, frames, let_in, until

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import cv2
import numpy as np
import panel as sessions
from panel import ended, run, trace
from PIL import Image
from playwright.sync_api import TimeoutError

from rrp_sheets.devices import load_robot
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.sim.messages import Spec
from rrp_sheets.sim.world import SimWorld
from rrp_sheets.web.robotmodel import robot_model

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
ROWS = [
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "filter", "distance < 0.8", "Close ball", ""],
    ["", "Close ball", "subscribe", "", "Head tracker", ""],
    ["", "Head yaw", "map", '"Hello"', "Greeting", ""],
    ["", "Greeting", "subscribe", "", "Say", ""],
    ["", "Say done", "map", '"blue"', "Colour", ""],
    ["", "Colour", "subscribe", "", "Eye colour", ""],
]
SCENE = [*sessions.SCENE, ["0", "Kai", "appears", "at 1.1, -0.4, 0.75"]]
BOOKS = {"b.xlsx": {"T": [HEADER, *ROWS]}, "session.xlsx": {**sessions.SESSION, "Scene": SCENE}}
BROWSER_FLAGS = FLAGS_3D


@dataclass(frozen=True)
class Real:
    """A moment of a real world: what the panel is told of the robot, of its camera, and of what that sees."""

    robot: dict[str, Any]
    turned: dict[str, Any]
    fields: dict[str, float]
    jpeg: bytes
    camera: dict[str, float]


@pytest.fixture(scope="module")
def real() -> Real:
    ball = SceneAction(0, "Red ball", "appear", {"at": (0.55, 0.1, 0.42), "size": 0.06, "colour": "red"})
    world = SimWorld(Spec(load_robot(), scene=(ball,)))
    try:
        world.start()
        world.advance(100_000, ())
        before, picture, spot = _told(world), world.sight.look(), world.sight.detector().ball("red")
        assert spot is not None
        fields = {n: getattr(spot, n) for n in ("x", "y", "width", "height", "distance")}
        world.body.go("HeadYaw", 0.9)
        world.body.go("LShoulderPitch", -0.5, 4.0)
        world.advance(1_600_000, ())
        jpeg = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes()
        lens = {"hfov": world.body.hfov, "vfov": world.body.vfov}
        return Real(before, _told(world), fields, jpeg, lens)
    finally:
        world.close()


def _told(world: SimWorld) -> dict[str, Any]:
    state = world.state()
    things = {name: list(at) for name, at in state.things.items()}
    return {"joints": dict(state.joints), "base": list(state.base), "eyes": list(state.eyes), "saying": state.saying,
            "things": things}  # fmt: skip


class Panel:
    """The run panel, told what a run would tell it."""

    def __init__(self, browser: Any, url: str, real: Real, script: str = "") -> None:
        self.context = browser.new_context(viewport={"width": 1280, "height": 900})
        let_in(self.context, url)
        self.page = self.context.new_page()
        self.errors: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        if script:
            self.page.add_init_script(script)
        self.page.route("**/run/eye.jpg*", lambda route: route.fulfill(body=real.jpeg, content_type="image/jpeg"))
        self.page.goto(f"{url}/book/b.xlsx/run/T")
        self.page.wait_for_selector("#diagram svg")
        self.page.wait_for_selector("body[data-ready]")
        self.page.wait_for_selector("#drives svg", state="attached")
        # The server says that nothing runs, when the page joins and when it joins again: here it is told otherwise.
        self.page.evaluate("""() => { for (const told of ["run", "live", "log"]) document.getElementById("listen")
            .addEventListener(told, (event) => event.stopImmediatePropagation(), true); }""")
        self.ids = self.page.eval_on_selector_all("tbody tr", "rows => rows.map(r => r.id)")
        self.run(real)

    def tell(self, event: str, **detail: Any) -> None:
        script = "([event, detail]) => document.dispatchEvent(new CustomEvent(event, { detail }))"
        self.page.evaluate(script, [event, detail])

    def run(self, real: Real, phase: str = "running") -> None:
        self.page.evaluate("phase => { document.body.dataset.run = phase; }", phase)
        self.tell("rrp:run", id="r1", phase=phase, book="b.xlsx", t=0, camera=real.camera, mode="simulated",
                  behaviours=[], sensors=[], buttons=[], ended=None,
                  things=[{"name": "Red ball", "kind": "ball", "at": None}],
                  resources={"Head tracker": ["head"], "Say": ["voice"]}, rows={})  # fmt: skip

    def live(self, **detail: Any) -> None:
        self.tell("rrp:live", **detail)

    def still(self) -> int:
        """Wait until the robot is no longer drawn anew; how often it was drawn."""
        self.page.wait_for_selector("#robot3d canvas[data-state=still]")
        return int(self.page.locator("#robot3d canvas").get_attribute("data-drawn") or 0)

    def picture(self) -> Any:
        """The robot's picture as it is on the screen, without the frame that shows the focus."""
        data = self.page.locator("#robot3d canvas").screenshot()
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=int)[8:-8, 8:-8]


@pytest.fixture(scope="module")
def panel(browser: Any, url: str, real: Real) -> Any:
    made = Panel(browser, url, real)
    made.page.wait_for_selector("#robot3d[data-ready]")
    yield made
    assert not made.errors, made.errors
    made.context.close()


def test_the_model_has_every_joint_of_the_catalogue_and_all_its_meshes() -> None:
    robot = load_robot()
    model = robot_model(robot)
    joints = {j["name"] for j in model["joints"] if not j["fixed"]}
    assert set(model["rest"]) <= joints
    assert joints - set(model["rest"]) == set(model["follow"])
    links = {link["name"] for link in model["links"]}
    assert len(links) == len(model["joints"]) + 1, "one link is the root, each other hangs on a joint"
    for mesh in model["meshes"].values():
        assert len(mesh["points"]) == len(mesh["normals"])
        assert max(mesh["faces"]) < len(mesh["points"]) // 3
    assert model["units"]["distance"] == "m"


def test_the_robot_is_drawn_when_it_moves_and_only_then(panel: Panel, real: Real) -> None:
    panel.live(t=0.1, robot={**real.robot, "things": {}})
    panel.still()
    first = panel.picture()
    assert (first.min(axis=2) > 215).mean() > 0.02, "there is no white robot"
    panel.live(t=1.6, robot={**real.turned, "things": {}})
    drawn = panel.still()
    second = panel.picture()
    changed = (np.abs(first - second).sum(axis=2) > 60).mean()
    assert changed > 0.005, f"head and arm have moved, but only {changed:.2%} of the picture"
    frames(panel.page, 20)
    assert panel.still() == drawn, "nothing moves, and it is drawn all the same"


def test_balls_stand_in_the_room_and_one_can_look_around(panel: Panel, real: Real) -> None:
    def red(picture: Any) -> float:
        return float(((picture[:, :, 0] > 120) & (picture[:, :, 1] < 70) & (picture[:, :, 2] < 70)).mean())

    panel.live(t=1.6, robot={**real.turned, "things": {}})
    panel.still()
    assert red(panel.picture()) == 0
    panel.live(t=1.7, robot=real.turned)
    panel.still()
    framed = panel.picture()
    assert red(framed) > 0.0005
    box = panel.page.locator("#robot3d canvas").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    panel.page.mouse.move(*middle)
    panel.page.mouse.down()
    panel.page.mouse.move(middle[0] - 90, middle[1] + 30, steps=4)
    panel.page.mouse.up()
    panel.page.keyboard.press("+")
    panel.still()
    turned = (np.abs(framed - panel.picture()).sum(axis=2) > 60).mean()
    assert turned > 0.05
    panel.page.keyboard.press("0")
    panel.still()
    back = (np.abs(framed - panel.picture()).sum(axis=2) > 60).mean()
    assert back < turned / 3, "0 is the view from the front; only its fineness may have changed"


def test_a_ball_is_dragged_in_the_picture_and_elsewhere_the_view_turns(panel: Panel, real: Real) -> None:
    page, canvas, caption = panel.page, panel.page.locator("#robot3d canvas"), panel.page.locator("#robot3d .caption")
    canvas.press("0")
    panel.live(t=1.8, robot=real.robot)
    panel.still()
    puts: list[tuple[float, dict[str, Any]]] = []
    page.route("**/run/put", lambda route: (puts.append((time.monotonic(), route.request.post_data_json)),
                                            route.fulfill(json={})))  # fmt: skip
    begin = real.robot["things"]["Red ball"]
    page.evaluate("document.addEventListener('rrp:moved', ({ detail }) => { window.moved = detail.at; })")

    def drag(right: int, down: int, finger: Any = None) -> list[float]:
        """Drag the ball by pixels; where it is put in the end."""
        x, y = red_place(page)
        puts.clear()
        if finger:
            finger("touchStart", x, y)
            for n in range(1, 9):
                finger("touchMove", x + right * n / 8, y + down * n / 8)
            finger("touchEnd")
        else:
            page.mouse.move(x, y)
            page.wait_for_selector("#robot3d canvas.on-thing")
            page.mouse.down()
            page.mouse.move(x + right, y + down, steps=20)
            page.mouse.up()
        until(page, lambda: puts and [puts[-1][1][n] for n in "xyz"] == page.evaluate("window.moved"))
        panel.still()
        assert len(puts) <= 2 + 15 * (puts[-1][0] - puts[0][0]), "at most 15 a second"
        assert {p["thing"] for _, p in puts} == {"Red ball"}
        place = [puts[-1][1][n] for n in "xyz"]
        panel.live(t=1.9, robot={**real.robot, "things": {"Red ball": place}})  # as the world does
        pointer = pytest.approx((x + right, y + down), abs=9)
        until(page, lambda: red_place(page) == pointer)  # a busy machine shows what was drawn a little later
        return place

    assert caption.inner_text() == "Drag a thing to move it, elsewhere to look around"
    x, y, z = drag(0, -40)
    assert z > begin[2] + 0.05 and abs(y - begin[1]) < 0.05, "up as seen"
    shown = [float(text.split()[0]) for text in page.locator("#things output").all_inner_texts()[:3]]
    assert shown == pytest.approx([x, y, z], abs=0.006), "the sliders follow"
    aside = drag(-40, 0)
    assert aside[1] < y - 0.05 and aside[2] == pytest.approx(z, abs=0.03), "left as seen is right of the robot"
    session = page.context.new_cdp_session(page)

    def finger(kind: str, *at: float) -> None:
        points = [{"x": at[0], "y": at[1]}] if at else []
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = page.evaluate("scrollY")
    assert drag(0, 30, finger)[2] < aside[2] - 0.03, "a finger moves it down"
    assert page.evaluate("scrollY") == before, "and not the page"
    # two fingers: apart is nearer, as if it were drawn larger
    x, y = red_place(page)
    large = red_pixels(page)
    points = [{"x": x, "y": y, "id": 1}, {"x": x + 40, "y": y, "id": 2}]
    session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": points[:1]})
    session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": points})
    for wide in (44, 48, 52, 56):
        apart = [points[0], {**points[1], "x": x + wide}]
        session.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": apart})
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    until(page, lambda: puts and [puts[-1][1][n] for n in "xyz"] == page.evaluate("window.moved"))
    place = [puts[-1][1][n] for n in "xyz"]
    panel.live(t=1.9, robot={**real.robot, "things": {"Red ball": place}})
    until(page, lambda: red_pixels(page) > 1.2 * large)
    panel.live(t=1.9, robot=real.robot)
    # elsewhere, and when nothing runs, the view turns
    puts.clear()
    box = canvas.bounding_box()
    for phase in ("paused", "ended"):
        panel.run(real, phase)
        still = panel.picture()
        start = red_place(page) if phase == "ended" else (box["x"] + 20, box["y"] + 20)
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(start[0] + 60, start[1] + 10, steps=4)
        page.mouse.up()
        panel.still()
        assert (np.abs(still - panel.picture()).sum(axis=2) > 60).mean() > 0.02
    assert not puts
    assert caption.inner_text() == "Things can be moved while it runs. Drag to look around"
    page.unroute("**/run/put")
    panel.run(real)
    canvas.press("0")


def drawn(page: Any) -> Any:
    """The robot's picture as it is on the screen: red, green and blue, each (height, width)."""
    picture = page.locator("#robot3d canvas").screenshot()
    return np.moveaxis(np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=int), 2, 0)


def red(page: Any) -> tuple[Any, Any]:
    """Rows and columns of what is red in the robot's picture."""
    r, g, b = drawn(page)
    return np.nonzero((r > 120) & (g < 70) & (b < 70))


def jumper(page: Any) -> tuple[float, float]:
    """Where on the screen the first person's jumper is, which is bluish green."""
    r, g, b = drawn(page)
    v, u = np.nonzero((r < 120) & (g > r + 25) & (b > r + 25) & (b < g + 25))
    assert len(u) > 100, "there is nobody in the picture"
    box = page.locator("#robot3d canvas").bounding_box()
    return box["x"] + float(u.mean()), box["y"] + float(v.mean())


def red_pixels(page: Any) -> int:
    """How large the red ball is drawn."""
    return len(red(page)[0])


def red_place(page: Any) -> tuple[float, float]:
    """Where on the screen the middle of the red ball is."""
    box, (v, u) = page.locator("#robot3d canvas").bounding_box(), red(page)
    assert len(u), "there is no red ball"
    return box["x"] + float(u.mean()), box["y"] + float(v.mean())


def test_what_is_dragged_moves_in_the_world(browser: Any, url: str, folder: Path) -> None:
    at = GridPage(
        browser, url, "session.xlsx", name="Aya", reduced_motion="reduce"
    )  # draws what comes, nothing between
    page = at.page
    run(page)
    page.wait_for_selector("#robot3d[data-ready]")
    page.evaluate(
        "document.addEventListener('rrp:live', ({ detail }) => { window.robot = detail.robot ?? window.robot; })"
    )
    page.wait_for_function("() => window.robot?.things['Red ball']")
    page.wait_for_selector("#robot3d canvas[data-state=still]")
    x, y = red_place(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 40, steps=10)
    page.mouse.up()
    page.wait_for_function("() => window.robot.things['Red ball'][2] > 0.45", timeout=20_000)
    # a person too, taken anywhere from head to foot; whoever is moved stays on the floor
    page.locator("#robot3d canvas").press("0")
    page.wait_for_selector("#robot3d canvas[data-state=still]")
    where = page.evaluate("window.robot.things.Kai")
    x, y = jumper(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y, steps=10)
    page.wait_for_selector("#robot3d .caption:text-matches('^Kai: ')")
    page.mouse.up()
    page.wait_for_function("was => Math.hypot(...was.map((v, i) => v - window.robot.things.Kai[i])) > 0.1", arg=where)
    page.click("[data-run=stop]")
    ended(page)
    acts = [n for n in trace(folder, "session") if "put" in (n.get("detail") or {})]
    put = {n["detail"]["thing"]: n["detail"]["put"] for n in acts}
    assert put["Red ball"][2] > 0.45
    assert put["Kai"][2] == where[2] and put["Kai"][:2] != pytest.approx(where[:2], abs=0.1)
    assert not at.errors
    at.context.close()


def test_the_box_is_where_the_ball_is_in_the_picture(panel: Panel, real: Real) -> None:
    panel.live(t=2.0, fields={"Red ball": real.fields}, eye=5, streams={"Red ball": stream("…", 2.0, "sensor")})
    panel.page.wait_for_selector("#eye svg.shown rect.seen")
    pixels = np.asarray(Image.open(io.BytesIO(real.jpeg)).convert("RGB"), dtype=int)
    high, wide = pixels.shape[:2]
    v, u = np.nonzero((pixels[:, :, 0] > 110) & (pixels[:, :, 1] < 80))
    seen = panel.page.locator("#eye rect.seen").bounding_box()
    frame = panel.page.locator("#eye img").bounding_box()
    scale = wide / frame["width"]
    left, top = (seen["x"] - frame["x"]) * scale, (seen["y"] - frame["y"]) * scale
    edges = (left, left + seen["width"] * scale, top, top + seen["height"] * scale)
    assert edges == pytest.approx((u.min(), u.max() + 1, v.min(), v.max() + 1), abs=4), "pixels of the camera"
    assert frame["height"] / frame["width"] == pytest.approx(high / wide, abs=0.02)
    words = f"Red ball {real.fields['distance']:.2f} m"
    assert panel.page.locator("#eye svg text").text_content() == words
    assert words in (panel.page.locator("#eye img").get_attribute("alt") or "")
    panel.live(t=2.6)
    assert panel.page.locator("#eye rect.seen").count() == 0, "what was seen long ago is not shown"
    asked: list[str] = []
    panel.page.on("request", lambda request: asked.append(request.url) if "/run/eye.jpg" in request.url else None)
    burst = "() => { for (let eye = 10; eye < 60; eye++) document.dispatchEvent(new CustomEvent('rrp:live', { detail: { eye } })); }"
    panel.page.evaluate(burst)
    panel.page.wait_for_selector("#eye img[src$='&n=59']")
    assert len(asked) < 6, "pictures that nobody could have seen are not fetched"


def test_the_eye_goes_on_asking_whatever_comes(panel: Panel, real: Real) -> None:
    """Pictures are made only while somebody asks, so a page that waits for news of one waits forever."""
    page = panel.page
    asked: list[str] = []
    answers: list[Any] = []

    def answer(route: Any) -> None:
        asked.append(route.request.url)
        kind = answers.pop(0) if answers else "picture"
        if kind == "lost":
            route.abort()
        elif kind == "none":
            route.fulfill(status=204)
        else:
            route.fulfill(body=real.jpeg, content_type="image/jpeg", headers={"Cache-Control": "no-store"})

    def asks(more: int) -> None:
        for _ in range(more):
            with page.expect_request("**/run/eye.jpg*", timeout=6_000):
                pass

    page.route("**/run/eye.jpg*", answer)
    panel.live(t=2.7, eye=70)
    asks(2)  # the same number: nothing newer is told of
    assert len(set(asked)) == len(asked), "a browser shows a picture of the same address again without asking"
    answers += ["lost", "none"]
    asks(3)
    assert page.locator("#eye img").is_visible(), "what was seen last stays"
    assert re.fullmatch(r"Robot’s eye\s*old by \d+ s", page.locator("#eye figcaption").inner_text())
    panel.live(t=2.8, eye=71)
    page.wait_for_selector("#eye img[src$='&n=71']")
    page.wait_for_function("!document.querySelector('#eye figcaption').innerText.includes('old')")
    panel.run(real, "ended")
    frames(page, 10)  # what was asked before is answered
    with pytest.raises(TimeoutError), page.expect_request("**/run/eye.jpg*", timeout=1_500):
        pass  # nobody asks when nothing runs
    panel.run(real)
    page.unroute("**/run/eye.jpg*", answer)


def stream(value: str, at: float, kind: str = "stream") -> dict[str, Any]:
    return {"v": value, "at": at, "n": 1, "kind": kind}


def test_what_is_said_stands_in_a_bubble_with_its_age(panel: Panel, real: Real) -> None:
    panel.live(t=3.0, robot={**real.robot, "saying": "Hello Kai"})
    bubble = panel.page.locator("#speech .bubble")
    assert bubble.inner_text().strip() == "Hello Kai"
    assert panel.page.locator("#speech [aria-live]").text_content() == "The robot says: Hello Kai"
    panel.live(t=4.0, robot={**real.robot, "saying": ""})
    panel.live(t=9.5, robot={**real.robot, "saying": ""})
    assert "5 s ago" in bubble.inner_text() and "last said" not in bubble.inner_text()
    below = panel.page.locator("#robot3d").bounding_box()
    bubbles = [bubble.bounding_box()]
    panel.live(t=14.0, robot={**real.robot, "saying": ""})
    assert bubble.inner_text().split("\n") == ["last said: Hello Kai", "10 s ago"]
    panel.live(t=15.0, robot={**real.robot, "saying": "Now I tell you something long. " * 9})
    bubbles.append(bubble.bounding_box())
    assert all(b["y"] + b["height"] < below["y"] for b in bubbles), "it covers nothing of the robot"
    assert panel.page.locator("#robot3d").bounding_box() == below, "nothing jumps"
    panel.tell("rrp:run", id="r2", phase="starting", book="b.xlsx", t=0)
    assert bubble.inner_text().strip() == "Nothing was said yet"
    panel.run(real)
    panel.live(t=9.0, robot={**real.robot, "saying": "Hello Kai"})
    assert panel.page.locator("#speech [aria-live]").text_content() == "The robot says: Hello Kai"


def test_plots_and_drives(panel: Panel) -> None:
    page = panel.page
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
    assert shown.locator(".head span").all_text_contents() == ["Distance", "Red ball.x"], "an id is no curve"
    assert shown.first.locator("canvas").count() == 1
    until(page, lambda: (panel.live(t=70.0), shown.first.locator("b").text_content())[1] == "1.19 m")
    colours = shown.first.locator("canvas").evaluate(
        "c => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;"
        " for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200 && d[i + 1] > d[i] + 40) n++; return n; }"
    )
    assert colours > 100, "the curve is drawn in the streams' green"
    page.get_by_text("Choose what is plotted").click()
    page.get_by_role("checkbox", name="Red ball.id").check()
    assert shown.count() == 3
    page.get_by_text("As a table").click()
    page.wait_for_selector("#plots tr:has-text('Distance')")
    cells = page.locator("#plots tr:has-text('Distance') td").all_text_contents()
    assert cells[0] == "1.19 m" and float(cells[1]) > 0.5, "of the last 30 seconds only"
    rows = page.locator("#drives text.row").all_text_contents()
    assert rows == ["4", "6"]
    head, voice = (page.locator("#drives rect.busy").nth(n).bounding_box() for n in (0, 1))
    assert head["x"] < voice["x"] < head["x"] + head["width"]
    assert voice["width"] / page.locator("#drives path.rule").first.bounding_box()["width"] == pytest.approx(
        0.1, abs=0.02
    )
    page.wait_for_selector("#drives svg[aria-label*='head: row T!4']")


def test_a_whole_record_is_plotted_with_the_value_under_the_pointer(panel: Panel) -> None:
    page = panel.page
    page.evaluate("""async () => {
        const { plotRecord } = await import("/static/run/plots.js");
        const root = document.createElement("div");
        root.id = "record";
        document.querySelector("#plots").before(root);
        const points = [...Array(100).keys()].map((n) => [n / 10, n]);
        window.away = plotRecord(root, [{ name: "A", unit: "m", points }, { name: "B", kind: "sensor", points: [] }]);
    }""")
    heads = page.locator("#record .head")
    assert heads.all_inner_texts() == ["A\n0 to 99 m", "B\nno value"]
    over = page.locator("#record .u-over").first
    over.hover()
    told = heads.first.inner_text()
    assert told.startswith("A\n") and " s: " in told and told.endswith(" m")
    assert float(told.split("\n")[1].split(" s")[0]) == pytest.approx(5, abs=1), "the middle of ten seconds"
    page.evaluate("away()")
    assert page.locator("#record canvas").count() == 0
    page.evaluate("document.querySelector('#record').remove()")


def test_rows_and_streams_of_the_last_second_are_lit_in_the_diagram(panel: Panel) -> None:
    page, ids = panel.page, panel.ids
    panel.live(
        t=80.0, rows={ids[0]: row("0.46 m", 79.9), ids[1]: row("0.46 m", 70.0), ids[3]: {**row("", 79.9), "e": "Oh"}},
        streams={"Red ball": stream("…", 79.9, "sensor"), "Distance": stream("0.46 m", 79.9)},
    )  # fmt: skip
    lit = page.eval_on_selector_all("#diagram .lit[data-row]", "found => found.map(b => b.dataset.row)")
    assert lit == ["2", "5"]
    assert page.locator("#diagram .failed").get_attribute("data-row") == "5"
    assert page.locator("#diagram [data-name='Distance'] .now").text_content() == "0.46 m"
    wires = page.eval_on_selector_all("#diagram .arrow.lit", "found => found.map(w => [w.dataset.from, w.dataset.to])")
    names = page.evaluate("Object.fromEntries([...document.querySelectorAll('#diagram [role=button]')].map("
                          "b => [b.id, b.dataset.row ?? b.dataset.name]))")  # fmt: skip
    assert sorted((names[a], names[b]) for a, b in wires) == [("2", "Distance"), ("Red ball", "2")]
    panel.live(t=81.5)
    assert page.locator("#diagram .lit").count() == 0
    world = page.locator("#diagram .arrow.world")
    assert (names[world.get_attribute("data-from")], names[world.get_attribute("data-to")]) == ("Say", "Say done")


def row(value: str, at: float) -> dict[str, Any]:
    return {"v": value, "at": at, "n": 1, "e": ""}


def test_the_diagram_leads_to_the_rows_and_back_and_keeps_zoom_and_focus(panel: Panel) -> None:
    page = panel.page
    box = page.get_by_role("button", name="Row 3, filter: distance < 0.8")
    box.click()
    assert page.inner_text("#formula-bar b") == "C3"
    assert "here" in (box.get_attribute("class") or "")
    assert page.locator("#diagram .arrow.here").count() == 2
    page.get_by_role("button", name="Larger").click()
    zoom = float(page.evaluate("getComputedStyle(document.querySelector('#panels')).getPropertyValue('--zoom')"))
    wide = page.locator("#diagram svg").bounding_box()["width"]
    box.focus()
    page.keyboard.press("ArrowDown")
    assert page.evaluate("document.activeElement.dataset.name") == "Close ball"
    page.evaluate(
        "new Promise((done) => { document.addEventListener('htmx:after:swap', done, { once: true });"
        " htmx.trigger('#panels', 'recheck'); }).then(() => 0)"
    )
    assert page.evaluate("document.activeElement.dataset.name") == "Close ball"
    assert page.locator("#diagram svg").bounding_box()["width"] == pytest.approx(wide, abs=1)
    assert zoom > 1.1
    page.keyboard.press("Enter")
    assert page.inner_text("#formula-bar b") == "C3", "a stream leads to the row that makes it"
    page.get_by_role("button", name="Fit").click()
    sizes = page.eval_on_selector_all(
        "#diagram text", "found => found.map(t => parseFloat(t.getAttribute('font-size')) * t.getScreenCTM().a)"
    )
    assert min(sizes) >= 9.5, "readable without glasses"


def test_without_webgl_words_say_so(browser: Any, url: str, real: Real) -> None:
    none = ("const get = HTMLCanvasElement.prototype.getContext; HTMLCanvasElement.prototype.getContext = function (k, "
            "...more) { return k.startsWith('webgl') ? null : get.call(this, k, ...more); };")  # fmt: skip
    panel = Panel(browser, url, real, none)
    panel.page.wait_for_selector("#robot3d p")
    panel.live(t=1.0, robot=real.robot)
    assert "cannot draw the robot in 3D" in panel.page.inner_text("#robot3d")
    assert not panel.errors
    panel.context.close()
