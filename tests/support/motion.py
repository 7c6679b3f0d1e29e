"""A robot in its simulated world, within this process, that can be looked at after every step of the physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rrp_sheets.model.exchange import Command, DeviceUse, Notice, SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

ROBOT = load_robot()
STEP_US = 1_000_000 / 240
RED = DeviceUse("ball", "Red ball", "RedBall", {"rate": 10})


def use(stream: str, device: str, **settings: Any) -> DeviceUse:
    """A device, named as its stream, with the catalogue's defaults."""
    return DeviceUse(stream, stream.title(), device, ROBOT.devices[device.lower()].with_defaults(settings))


class Robot:
    """A world that goes on step by step; takes down what it tells and what commands end."""

    def __init__(
        self, actuators: Sequence[DeviceUse] = (), sensors: Sequence[DeviceUse] = (), scene: Sequence[SceneAction] = ()
    ) -> None:
        dones = {a.stream: f"{a.stream} done" for a in actuators}
        self.world = SimWorld(Spec(ROBOT, tuple(sensors), tuple(actuators), tuple(scene), dones=dones))
        self.body, self.stance = self.world.body, self.world.stance
        self.steps = 0
        self.told: list[Notice] = []
        self.events: list[tuple[str, Any]] = list(self.world.start().events)
        self._sensors = tuple(s.stream for s in sensors)

    def order(self, *commands: tuple[str, Any], release: bool = False, priority: float = 0.0) -> None:
        """Give commands, at the present instant."""
        orders = [Command(s, v, f"Test!{n}", self._sensors, priority, release) for n, (s, v) in enumerate(commands, 2)]
        self._take(self.world.advance(round(self.steps * STEP_US), orders))

    def go(self, seconds: float, each: Callable[[], object] = lambda: None, every: int = 1) -> None:
        """Let time pass, and look at something after every so many steps."""
        until = self.steps + round(seconds * 240)
        while self.steps < until:
            self.steps = min(self.steps + every, until)
            self._take(self.world.advance(round(self.steps * STEP_US), ()))
            each()

    def until_done(self, stream: str, seconds: float, every: int = 1) -> None:
        """Let time pass until a command of a stream has ended, or at most some seconds."""
        before, until = len(self.dones(stream)), self.steps + round(seconds * 240)
        while len(self.dones(stream)) == before and self.steps < until:
            self.go(0.1, every=every)

    def dones(self, stream: str) -> list[Mapping[str, Any]]:
        """The ends of a stream's commands."""
        return [value for name, value in self.events if name == f"{stream} done"]

    def joints(self) -> np.ndarray:
        """Angles of all joints."""
        return np.array([self.body.position(name) for name in self.body.start])

    def ends(self, side: str) -> np.ndarray:
        """The corners of a sole in the world."""
        sole = self.body.sole(side)
        return np.array(
            [sole.position + sole.rotation @ np.array([x, y, 0.0]) for x in (0.1, -0.045) for y in (0.035, -0.035)]
        )

    def _take(self, outcome: Any) -> None:
        self.told += outcome.notices
        self.events += outcome.events
