"""The run panel of a browser, told what a run would tell it: with a moment of a real world."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
from chromium import PAGES

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

_HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
_ROWS = [
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "filter", "distance < 0.8", "Close ball", ""],
    ["", "Close ball", "subscribe", "", "Head tracker", ""],
    ["", "Head yaw", "map", '"Hello"', "Greeting", ""],
    ["", "Greeting", "subscribe", "", "Say", ""],
    ["", "Say done", "map", '"blue"', "Colour", ""],
    ["", "Colour", "subscribe", "", "Eye colour", ""],
]
BOOK = {"T": [_HEADER, *_ROWS]}


@dataclass(frozen=True)
class Real:
    """A moment of a real world: what the panel is told of the robot, of its camera, and of what that sees."""

    robot: dict[str, Any]
    turned: dict[str, Any]
    fields: dict[str, float]
    jpeg: bytes
    camera: dict[str, float]


@lru_cache(maxsize=1)
def real_moment() -> Real:
    """Made once for all tests of a worker."""
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
    """The run panel, told what a run would tell it; `media` is what the browser says of its user's wishes."""

    def __init__(self, browser: Any, url: str, **media: Any) -> None:
        self.real = real_moment()
        self.page = PAGES.take(browser, url, viewport={"width": 1280, "height": 900})
        self.page.emulate_media(**media)
        self.context, self.errors = self.page.context, self.page.problems
        self._looks: list[bool] = []
        self.page.route("**/run/look", self._look)
        self.page.goto(f"{url}/book/b.xlsx/run/T")
        self.page.wait_for_selector("#diagram svg", state="attached")
        self.page.wait_for_selector("body[data-ready]")
        # Each view that comes later than the page makes it tell anew which run it knows of: none.
        views = (
            "() => ['eye', 'speech', 'plots', 'drives'].every((id) => document.getElementById(id).childElementCount)"
        )
        self.page.wait_for_function(views)
        self.page.wait_for_selector("#robot3d[data-ready], #robot3d > p", state="attached")
        # The server says that nothing runs, when the page joins and when it joins again: here it is told otherwise.
        self.page.evaluate("""() => { for (const told of ["run", "live", "log"]) document.getElementById("listen")
            .addEventListener(told, (event) => event.stopImmediatePropagation(), true); }""")
        self.ids = self.page.eval_on_selector_all("tbody tr", "rows => rows.map(r => r.id)")
        self.run()

    def view(self, name: str) -> None:
        """Choose what is shown below the rows."""
        self.page.click(f"#views [data-view={name}]")

    def tell(self, event: str, **detail: Any) -> None:
        script = "([event, detail]) => document.dispatchEvent(new CustomEvent(event, { detail }))"
        self.page.evaluate(script, [event, detail])

    def run(self, phase: str = "running", **more: Any) -> None:
        self.page.evaluate("phase => { document.body.dataset.run = phase; }", phase)
        self.tell("rrp:run", id="r1", phase=phase, book="b.xlsx", t=0, camera=self.real.camera, mode="simulated",
                  behaviours=[], sensors=[], buttons=[], ended=None,
                  things=[{"name": "Red ball", "kind": "ball", "at": None}],
                  resources={"Head tracker": ["head"], "Say": ["voice"]}, rows={},
                  **more)  # fmt: skip

    def live(self, **detail: Any) -> None:
        self.tell("rrp:live", **detail)

    def picture(self, age: float = 0) -> None:
        """Send the picture of the moment, taken so many seconds ago."""
        self.tell("rrp:eye", jpeg=b64encode(self.real.jpeg).decode(), age=age)

    def looked(self) -> list[bool]:
        """Each time that the page said whether it shows the robot's eye."""
        self.page.evaluate("0")  # requests are taken while something is asked of the page
        return list(self._looks)

    def _look(self, route: Any) -> None:
        self._looks.append(route.request.post_data_json["on"])
        route.fulfill(json={})
