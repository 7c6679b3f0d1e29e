"""Looking around the robot's 3D view with mouse, wheel, keys and fingers: where the viewer is; nothing is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from chromium import PAGES, becomes, frames

FRONT = (-0.5, 0.2, 1.448)  # rad, rad, m: of the robot alone, in a picture of this shape
STEP = 0.12  # rad, of an arrow key
PIXEL = 0.008  # rad, of a drag
OPENING = """async () => {
  const [{ Orbit }, THREE] = await Promise.all([import("/static/run/stage3d.js"), import("/static/vendor/js/three.module.js")]);
  document.body.innerHTML = `<div class="robot3d"><div class="room"><canvas tabindex="0"></canvas></div></div>`;
  const style = Object.assign(document.createElement("link"), { rel: "stylesheet", href: "/static/run-views.css" });
  await new Promise((done) => { style.onload = done; document.head.append(style); });
  document.body.style.cssText = "display: block; margin: 0; height: 3000px";
  document.querySelector(".robot3d").style.width = "314px";
  const canvas = document.querySelector("canvas");
  const camera = new THREE.PerspectiveCamera(30, 0.8, 0.05, 60);
  const robot = [];
  for (const x of [-0.1, 0.14]) for (const y of [-0.17, 0.17]) for (const z of [0, 0.59]) robot.push(new THREE.Vector3(x, y, z));
  window.changes = 0;
  window.orbit = new Orbit(canvas, camera, () => { window.changes += 1; });
  window.walk = (x) => { orbit.frame([{ points: robot, somebody: false }], new THREE.Vector3(x, 0, 0), false); orbit.settle(1); };
  walk(0);
  window.view = () => {
    const { x, y, z } = camera.position.clone().sub(orbit.target);
    const distance = Math.hypot(x, y, z);
    return [Math.atan2(y, x), Math.asin(z / distance), distance];
  };
  window.wheels = [];
  addEventListener("wheel", (event) => wheels.push(event.defaultPrevented));
}"""


class View:
    """A view of a robot that is not drawn."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.canvas = page.locator("canvas")
        self.fingers = page.context.new_cdp_session(page)

    def shows(self, azimuth: float, elevation: float, distance: float) -> None:
        """Wait until the viewer is there."""
        becomes(lambda: self.page.evaluate("view()"), pytest.approx((azimuth, elevation, distance), abs=0.002))

    def front(self) -> None:
        """Go back to the view from the front."""
        self.canvas.press("0")
        self.shows(*FRONT)

    def wheel(self, pixels: float, *, taken: bool) -> None:
        """Turn the wheel; the view takes it, or the page does."""
        self.page.evaluate("() => { wheels.length = 0; }")
        self.page.mouse.move(30, 30)
        self.page.mouse.wheel(0, pixels)
        becomes(lambda: self.page.evaluate("wheels"), [taken])

    def touch(self, kind: str, *places: tuple[float, float]) -> None:
        """Put fingers on the screen, move them, or take them all away."""
        points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)]
        self.fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


@pytest.fixture(scope="module")
def opened(browser: Any, url: str) -> Iterator[View]:
    page = PAGES.take(browser, url, viewport={"width": 400, "height": 500})
    page.goto(url)
    page.evaluate(OPENING)
    yield View(page)
    assert not page.problems
    PAGES.put_back(page)


@pytest.fixture
def view(opened: View) -> View:
    opened.page.evaluate("() => { scrollTo(0, 0); walk(0); }")
    opened.front()
    return opened


@pytest.mark.slow
def test_wheel_zooms_when_the_picture_has_the_focus_or_ctrl_is_held(view: View) -> None:
    azimuth, elevation, distance = FRONT
    notch = 0.95**2.4
    view.page.evaluate("document.activeElement.blur()")
    view.wheel(200, taken=False)
    becomes(lambda: view.page.evaluate("scrollY > 100"), True)
    view.page.evaluate("scrollTo(0, 0)")
    view.shows(*FRONT)
    view.page.keyboard.down("Control")
    view.wheel(-200, taken=True)
    view.page.keyboard.up("Control")
    view.shows(azimuth, elevation, distance * notch**2)
    view.front()  # it has the focus now
    view.wheel(200, taken=True)
    view.shows(azimuth, elevation, distance / notch**2)
    view.wheel(1e5, taken=True)
    view.shows(azimuth, elevation, 6)
    view.wheel(-1e5, taken=True)
    view.shows(azimuth, elevation, 0.45)


def test_keys_turn_and_zoom(view: View) -> None:
    azimuth, elevation, distance = FRONT
    for key, seen in (
        ("ArrowLeft", (azimuth + STEP, elevation, distance)),
        ("ArrowRight", FRONT),
        ("ArrowUp", (azimuth, elevation + STEP, distance)),
        ("ArrowDown", FRONT),
        ("+", (azimuth, elevation, distance * 0.85)),
        ("-", FRONT),
        ("=", (azimuth, elevation, distance * 0.85)),
        ("Home", FRONT),
        ("a", FRONT),
    ):
        view.canvas.press(key)
        view.shows(*seen)


@pytest.mark.slow
def test_view_turns_neither_over_the_top_nor_below_the_floor(view: View) -> None:
    for key, elevation in (("ArrowUp", math.pi / 2 - 0.12), ("ArrowDown", math.pi / 2 - 1.62)):
        for _ in range(15):
            view.canvas.press(key)
        view.shows(FRONT[0], elevation, FRONT[2])
    for _ in range(12):
        view.canvas.press("-")
    becomes(lambda: view.page.evaluate("orbit.object.position.z"), pytest.approx(0.03))


def test_mouse_turns_and_a_double_click_brings_the_front_back(view: View) -> None:
    mouse = view.page.mouse
    view.page.evaluate("document.activeElement.blur()")
    mouse.move(30, 30)
    mouse.down()
    mouse.move(110, 40, steps=4)
    turned = (FRONT[0] - 80 * PIXEL, FRONT[1] + 10 * PIXEL, FRONT[2])
    view.shows(*turned)
    mouse.up()
    becomes(lambda: view.page.evaluate("document.activeElement.tagName"), "CANVAS")
    mouse.move(200, 200)
    view.shows(*turned)
    mouse.dblclick(30, 30)
    view.shows(*FRONT)


def test_one_finger_turns_and_two_zoom(view: View) -> None:
    view.touch("touchStart", (30, 30))
    for right in range(10, 90, 10):
        view.touch("touchMove", (30 + right, 30))
    view.touch("touchEnd")
    view.shows(FRONT[0] - 80 * PIXEL, *FRONT[1:])
    view.front()
    view.touch("touchStart", (30, 30))
    view.touch("touchStart", (30, 30), (130, 30))
    for wide in (105, 110, 115, 120, 125, 130):
        view.touch("touchMove", (30, 30), (30 + wide, 30))
    view.touch("touchEnd")
    view.shows(*FRONT[:2], FRONT[2] / 1.3)


def test_finger_that_goes_up_scrolls_the_page(view: View) -> None:
    view.touch("touchStart", (30, 330))
    for up in range(10, 200, 10):
        view.touch("touchMove", (30, 330 - up))
    view.touch("touchEnd")
    becomes(lambda: view.page.evaluate("scrollY > 50"), True)


def test_turned_view_goes_along_with_the_robot_and_the_framed_one_follows_it(view: View) -> None:
    view.canvas.press("ArrowLeft")
    turned = (FRONT[0] + STEP, *FRONT[1:])
    view.shows(*turned)
    before = view.page.evaluate("orbit.target.x")  # read once: nothing moves by itself
    view.page.evaluate("walk(0.5)")
    view.shows(*turned)
    becomes(lambda: view.page.evaluate("orbit.target.x"), pytest.approx(before + 0.5))


def test_nothing_changes_by_itself(view: View) -> None:
    view.canvas.press("ArrowLeft")
    view.shows(FRONT[0] + STEP, *FRONT[1:])
    changes = view.page.evaluate("changes")  # read once: the key has done what it does
    frames(view.page, 5)
    becomes(lambda: view.page.evaluate("changes"), changes)
