"""The robot of a run in 3D: drawn when it moves, looked at from all sides, its things dragged; with a real world."""

from __future__ import annotations

import io
import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import (
    FLAGS_3D,
    PAGES,
    GridPage,
    becomes,
    eventually,
    frames,
    some,
    until,
    violations_by_look,
)

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import numpy as np
import panel as sessions
from panel import ended, run, trace
from PIL import Image
from playwright.sync_api import expect
from run_panel import BOOK, Panel

from rrp_sheets import api
from rrp_sheets.robots import load_robot
from rrp_sheets.web.robotmodel import robot_model

SCENE = [*sessions.SCENE, ["0", "Kai", "appears", "at 1.1, -0.4, 0.75"]]
BOOKS = {"b.xlsx": BOOK, "session.xlsx": {**sessions.SESSION, "Scene": SCENE}}
pytestmark = pytest.mark.usefixtures("unfilmed")
BROWSER_FLAGS = FLAGS_3D


class RobotPanel(Panel):
    """The run panel, and the robot's picture in it."""

    def still(self) -> int:
        """Wait until the robot is no longer drawn anew; how often it was drawn."""
        self.page.wait_for_selector("#robot3d canvas[data-state=still]")
        return int(self.page.locator("#robot3d canvas").get_attribute("data-drawn") or 0)

    def picture(self) -> Any:
        """The robot's picture as it is on the screen, without the frame that shows the focus."""
        data = screenshot(self.page)
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=int)[8:-8, 8:-8]


@pytest.fixture(scope="module")
def panel(browser: Any, url: str) -> Iterator[RobotPanel]:
    made = RobotPanel(browser, url)
    made.page.wait_for_selector("#robot3d[data-ready]")
    yield made
    assert not made.errors, made.errors
    PAGES.put_back(made.page)


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
    painted = {tuple(v["colour"]) for link in model["links"] for v in link["visuals"]}
    assert len(painted) > 2, "the colours of its file"


@pytest.mark.slow
def test_the_robot_is_drawn_when_it_moves_and_only_then(panel: RobotPanel) -> None:
    panel.live(t=0.1, robot={**panel.real.robot, "things": {}})
    panel.still()
    first = panel.picture()
    assert (first.min(axis=2) > 215).mean() > 0.02, "there is no white robot"
    panel.live(t=1.6, robot={**panel.real.turned, "things": {}})
    drawn = panel.still()
    second = panel.picture()
    changed = (np.abs(first - second).sum(axis=2) > 60).mean()
    assert changed > 0.005, f"head and arm have moved, but only {changed:.2%} of the picture"
    frames(panel.page, 20)
    assert panel.still() == drawn, "nothing moves, and it is drawn all the same"


@pytest.mark.slow
def test_balls_stand_in_the_room_and_one_can_look_around(panel: RobotPanel) -> None:
    def red(picture: Any) -> float:
        return float(((picture[:, :, 0] > 120) & (picture[:, :, 1] < 70) & (picture[:, :, 2] < 70)).mean())

    panel.live(t=1.6, robot={**panel.real.turned, "things": {}})
    panel.still()
    assert red(panel.picture()) == 0
    panel.live(t=1.7, robot=panel.real.turned)
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


@pytest.mark.slow
def test_a_ball_is_dragged_in_the_picture_and_elsewhere_the_view_turns(panel: RobotPanel) -> None:
    page, canvas, caption = panel.page, panel.page.locator("#robot3d canvas"), panel.page.locator("#robot3d .caption")
    page.emulate_media(reduced_motion="reduce")  # draws what comes, nothing between
    canvas.press("0")
    panel.live(t=1.8, robot=panel.real.robot)
    panel.still()
    puts: list[tuple[float, dict[str, Any]]] = []
    page.route("**/run/put", lambda route: (puts.append((time.monotonic(), route.request.post_data_json)),
                                            route.fulfill(json={})))  # fmt: skip
    begin = panel.real.robot["things"]["Red ball"]
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
            page.mouse.move(x + right, y + down, steps=12)
            page.mouse.up()
        until(page, lambda: puts and [puts[-1][1][n] for n in "xyz"] == page.evaluate("window.moved"))
        panel.still()
        assert len(puts) <= 2 + 15 * (puts[-1][0] - puts[0][0]), "at most 15 a second"
        assert {p["thing"] for _, p in puts} == {"Red ball"}
        place = [puts[-1][1][n] for n in "xyz"]
        panel.live(t=1.9, robot={**panel.real.robot, "things": {"Red ball": place}})  # as the world does
        pointer = pytest.approx((x + right, y + down), abs=9)
        until(page, lambda: red_place(page) == pointer)  # a busy machine shows what was drawn a little later
        return place

    becomes(caption.inner_text, "Drag an object to move it, drag elsewhere to look around")
    x, y, z = drag(0, -60)
    assert z > begin[2] + 0.05 and abs(y - begin[1]) < 0.05, "up as seen"
    panel.view("scene")
    told = page.locator("#things output")
    becomes(
        lambda: [float(text.split()[0]) for text in told.all_inner_texts()[:3]],
        pytest.approx([x, y, z], abs=0.006), "the sliders follow",
    )  # fmt: skip
    aside = drag(-60, 0)
    assert aside[1] < y - 0.05 and aside[2] == pytest.approx(z, abs=0.03), "left as seen is right of the robot"
    session = page.context.new_cdp_session(page)

    def finger(kind: str, *at: float) -> None:
        points = [{"x": at[0], "y": at[1]}] if at else []
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = page.evaluate("scrollY")  # read once: the page stands still
    assert drag(0, 30, finger)[2] < aside[2] - 0.03, "a finger moves it down"
    becomes(lambda: page.evaluate("scrollY"), before, "and not the page")
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
    panel.live(t=1.9, robot={**panel.real.robot, "things": {"Red ball": place}})
    until(page, lambda: red_pixels(page) > 1.2 * large)
    panel.live(t=1.9, robot=panel.real.robot)
    # elsewhere, and when nothing runs, the view turns
    puts.clear()
    box = canvas.bounding_box()
    for phase in ("paused", "ended"):
        panel.run(phase)
        canvas.press("0")  # the view was turned: the ball may be out of it
        panel.still()
        still = panel.picture()
        start = red_place(page) if phase == "ended" else (box["x"] + 20, box["y"] + 20)
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(start[0] + 60, start[1] + 10, steps=4)
        page.mouse.up()
        panel.still()
        assert (np.abs(still - panel.picture()).sum(axis=2) > 60).mean() > 0.02
    assert not puts
    becomes(caption.inner_text, "Drag to look around. In a run, drag objects too")
    page.unroute("**/run/put")
    panel.run()
    canvas.press("0")
    page.emulate_media(reduced_motion="no-preference")


def test_the_robot_is_touched_by_a_click_by_holding_and_by_keys(panel: RobotPanel) -> None:
    page, canvas = panel.page, panel.page.locator("#robot3d canvas")
    page.emulate_media(reduced_motion="reduce")
    canvas.press("0")
    panel.live(t=2.2, robot=panel.real.robot)
    panel.still()
    asked: list[str] = []

    def take(route: Any) -> None:
        sent = route.request.post_data_json
        asked.append(f"{sent['zone']} {sent['step']}")
        route.fulfill(json={})

    page.route("**/run/touch", take)

    def middle(zone: str) -> tuple[float, float]:
        box = some(page.get_by_role("button", name=f"Touch: {zone}").bounding_box)
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def click(zone: str) -> None:
        page.mouse.move(*middle(zone))
        page.wait_for_selector(f".zone.under[aria-label='Touch: {zone}']")
        page.mouse.down()
        page.mouse.up()

    def told(do: Callable[[], None]) -> list[str]:
        """The requests when something is done; a short press that a busy page hears late is a longer touch."""
        asked.clear()
        do()
        until(page, lambda: asked and asked[-1].endswith((" once", " end")))
        return list(asked)

    hint, head = page.locator("#touch-hint"), page.get_by_role("button", name="Touch: Head")
    page.mouse.move(1, 1)
    becomes(hint.inner_text, "Click the robot to touch it")
    becomes(lambda: {one.get_attribute("aria-describedby") for one in (canvas, head)}, {"touch-hint"})
    head.focus()
    becomes(hint.inner_text, "Head: click to touch, hold to keep touching")
    panel.run()  # told again, as with each change of the run
    expect(hint).to_have_text("Head: click to touch, hold to keep touching")
    head.blur()
    room = some(canvas.bounding_box)
    page.mouse.click(room["x"] + 12, room["y"] + room["height"] - 60)  # the floor
    expect(hint).to_contain_text("The robot feels nothing there. It feels: ")
    expect(hint).to_contain_text("Chest")
    page.mouse.move(*middle("Chest"))
    becomes(hint.inner_text, "Chest: click to touch, hold to keep touching")
    becomes(lambda: canvas.evaluate("canvas => getComputedStyle(canvas).cursor"), "pointer")
    for zone in ("Head", "Chest", "Left hand", "Right foot"):
        until(page, lambda zone=zone: told(lambda: click(zone)) == [f"{zone} once"])
    asked.clear()
    page.mouse.down()  # as long as it is held
    page.wait_for_selector(".zone.held[aria-label='Touch: Right foot']")
    until(page, lambda: asked[:2] == ["Right foot begin", "Right foot on"])
    page.mouse.up()
    until(page, lambda: asked[-1] == "Right foot end")
    becomes(lambda: page.locator(".zone.held").count(), 0)

    def look_around() -> None:
        canvas.press("0")
        panel.still()
        x, y = middle("Chest")
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y, steps=4)
        page.mouse.up()
        page.get_by_role("button", name="Touch: Head").press("Enter")

    until(page, lambda: told(look_around) == ["Head once"])  # a drag touches nothing
    panel.run("ended")
    becomes(lambda: page.locator(".zone:enabled").count(), 0)
    expect(hint).to_be_hidden()
    panel.run()
    canvas.press("0")
    page.unroute("**/run/touch")
    page.emulate_media(reduced_motion="no-preference")


def test_a_thing_that_is_clicked_has_its_sliders_in_the_picture(panel: RobotPanel) -> None:
    page = panel.page
    page.emulate_media(reduced_motion="reduce")
    page.locator("#robot3d canvas").press("0")
    panel.live(t=2.4, robot=panel.real.robot)
    panel.still()
    card = page.locator("#thing-card")
    page.mouse.click(*red_place(page))
    becomes(card.locator("h3").first.inner_text, "Red ball")
    becomes(lambda: card.locator("input[type=range]").count(), 3)
    card.get_by_role("button", name="Close").click()
    becomes(card.is_visible, False)
    becomes(lambda: page.locator("#things .thing").count(), 2, "the ball and the room")
    page.click("#swap")
    wide = lambda one: page.locator(one).bounding_box()["width"]  # noqa: E731
    eventually(lambda: wide("#eye") > 2 * wide("#robot3d"))
    page.click("#swap")
    eventually(lambda: wide("#robot3d") > 2 * wide("#eye"))
    page.emulate_media(reduced_motion="no-preference")


def test_the_room_is_large_and_tests_and_problems_do_not_move_it(panel: RobotPanel) -> None:
    page = panel.page
    page.set_viewport_size({"width": 1400, "height": 900})
    room = page.locator("#robot3d .room")
    eventually(lambda: room.bounding_box()["width"] >= 0.4 * 1400)
    place = some(room.bounding_box)
    for view in ("problems", "diagram", "log"):
        panel.view(view)
        becomes(lambda: page.locator(".below").get_attribute("data-view"), view)
        becomes(room.bounding_box, place)
    tabs = page.locator("#views [role=tab]")
    tabs.first.press("ArrowRight")
    becomes(lambda: page.evaluate("document.activeElement.dataset.view"), "plots")
    page.keyboard.press("Home")
    becomes(lambda: page.locator(".below").get_attribute("data-view"), "log")
    page.set_viewport_size({"width": 1280, "height": 900})


@pytest.mark.slow
def test_the_panel_with_the_robot_in_it_has_no_violation(panel: RobotPanel) -> None:
    panel.live(t=2.0, robot=panel.real.robot)
    panel.still()
    assert violations_by_look(panel.page) == {}
    panel.page.emulate_media(color_scheme="light")


def screenshot(page: Any) -> bytes:
    """The robot's picture as a PNG. That of a locator waits for two frames of a page that draws 3D in software."""
    place = some(page.locator("#robot3d canvas").bounding_box)
    show = "shown => { for (const part of document.querySelectorAll('.inset, .speech, .zones, .card'))"
    show += " part.style.visibility = shown ? '' : 'hidden'; }"  # they lie on the picture
    page.evaluate(show, False)
    picture = page.screenshot(clip=place, timeout=300_000)  # as `at_rest`
    page.evaluate(show, True)
    return bytes(picture)


def drawn(page: Any) -> Any:
    """The robot's picture as it is on the screen: red, green and blue, each (height, width)."""
    picture = screenshot(page)
    return np.moveaxis(np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=int), 2, 0)


@pytest.mark.slow
def test_the_view_stays_while_the_pointer_is_on_something(panel: RobotPanel) -> None:
    page, things = panel.page, panel.real.robot["things"]
    page.emulate_media(reduced_motion="reduce")
    page.locator("#robot3d canvas").press("0")
    panel.live(t=2.0, robot=panel.real.robot)
    panel.still()
    x, y = at_rest(page, red_place)
    page.mouse.move(x, y)
    page.wait_for_selector("#robot3d canvas.on-thing")
    wider = {**panel.real.robot, "things": {**things, "Wall": [0.6, 1.4, 0.3]}}
    panel.live(t=2.1, robot=wider)
    panel.still()
    assert red_place(page) == pytest.approx((x, y), abs=2), "one can press what one points at"
    page.mouse.move(x, y - 120)
    panel.still()
    until(page, lambda: math.dist(red_place(page), (x, y)) > 15)
    page.emulate_media(reduced_motion="no-preference")


def red(page: Any) -> tuple[Any, Any]:
    """Rows and columns of what is red in the robot's picture."""
    r, g, b = drawn(page)
    return np.nonzero((r > 120) & (g < 70) & (b < 70))


def jumper(page: Any) -> tuple[float, float]:
    """Place on the screen of the first person's jumper, which is bluish green."""
    r, g, b = drawn(page)
    v, u = np.nonzero((r < 120) & (g > r + 25) & (b > r + 25) & (b < g + 25))
    assert len(u) > 100, "there is nobody in the picture"
    box = page.locator("#robot3d canvas").bounding_box()
    return box["x"] + float(u.mean()), box["y"] + float(v.mean())


def red_pixels(page: Any) -> int:
    """Number of pixels of the red ball."""
    return len(red(page)[0])


def red_place(page: Any) -> tuple[float, float]:
    """Place on the screen of the middle of the red ball."""
    box, (v, u) = some(page.locator("#robot3d canvas").bounding_box), red(page)
    assert len(u), "there is no red ball"
    return box["x"] + float(u.mean()), box["y"] + float(v.mean())


def at_rest(page: Any, read: Callable[[Any], tuple[float, float]]) -> tuple[float, float]:
    """Read a place until it stays: during a run, a slow machine draws one picture after the other."""
    places: list[tuple[float, float]] = []

    def stays() -> bool:
        try:
            places.append(read(page))
        except AssertionError:  # it was not drawn yet
            return False
        return len(places) > 2 and all(math.dist(one, places[-1]) < 2 for one in places[-3:])

    eventually(stays, places, 300)  # a picture of such a page takes a busy machine up to half a minute
    return places[-1]


def drag_thing(page: Any, name: str, read: Callable[[Any], tuple[float, float]], right: int, down: int) -> None:
    """Drag a thing of a running world by so many pixels: pressed when it is outlined, which also keeps the view still."""

    def outlined() -> bool:
        page.mouse.move(*at_rest(page, read))
        return page.locator("#robot3d canvas.on-thing").count() > 0

    eventually(outlined, name, 300)
    x, y = read(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=10)
    page.wait_for_selector(f"#robot3d .caption:text-matches('^{name}: ')")
    page.mouse.up()


@pytest.mark.slow
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
    drag_thing(page, "Red ball", red_place, 0, -80)
    page.wait_for_function("() => window.robot.things['Red ball'][2] > 0.45")
    # a person too, taken anywhere from head to foot; whoever is moved stays on the floor
    page.locator("#robot3d canvas").press("0")
    where = some(lambda: page.evaluate("window.robot.things.Kai"))
    drag_thing(page, "Kai", jumper, 90, 0)
    page.wait_for_function("was => Math.hypot(...was.map((v, i) => v - window.robot.things.Kai[i])) > 0.1", arg=where)
    page.click("[data-run=stop]")
    ended(page)
    acts = [n for n in trace(folder, "session") if "put" in (n.get("detail") or {})]
    put = {n["detail"]["thing"]: n["detail"]["put"] for n in acts}
    assert put["Red ball"][2] > 0.45
    assert put["Kai"][2] == where[2] and put["Kai"][:2] != pytest.approx(where[:2], abs=0.1)
    at.close()


@pytest.mark.slow
def test_looking_back_at_the_robot_has_no_violation(browser: Any, url: str, folder: Path) -> None:
    ended = api.run_apart(folder / "session.xlsx", api.RunSettings(seconds=2.0, fast=True, film=False))
    assert ended.result is not None
    page = PAGES.take(browser, url, reduced_motion="reduce")
    page.goto(f"{url}/runs/{ended.result.folder.name}/lookback#t=1.5")
    page.wait_for_selector(".ran-diagram svg", state="attached")
    page.wait_for_selector("canvas[data-state=still]")
    assert violations_by_look(page) == {}
    PAGES.put_back(page)
