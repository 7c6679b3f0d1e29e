"""Pushes and falls. The robot never falls by itself; after a fall its motors are off, which is reported."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rrp_sheets.model.exchange import Notice
from rrp_sheets.perception.pinhole import Vector
from rrp_sheets.sim.arbitration import Arbiter, Tell
from rrp_sheets.sim.body import Body
from rrp_sheets.sim.stance import Stance
from rrp_sheets.texts import N_

HELD = 10.0  # N: a push that the guide withstands
CHEST = 0.08  # m above the torso's frame, where a push acts
TIPPED = 0.8  # rad from how it stood before: it falls, and nothing will stop that
CALM_US = 1_000_000  # so long after a push it must have come to rest for the guide to take it again
CALM_RATE = 0.15  # rad/s, of the torso: at rest
UPSET = 0.12  # rad: a robot that is tilted by more is still on its way
FALLEN = N_(
    "The robot has fallen. Its motors rest, and it moves no more in this run; speech and eyes go on. "
    "Look in the Scene sheet for what pushes it, or run again."
)
LIES = N_("The robot lies on the floor: its motors rest, so this is not carried out.")


class Falling:
    """Applies pushes to the robot, and detects falls; the arbiter refuses commands that move a robot that lies."""

    def __init__(self, bullet: Any, body: Body, stance: Stance, arbiter: Arbiter, tell: Tell) -> None:
        self._b, self._body, self._stance = bullet, body, stance
        self._arbiter, self._tell = arbiter, tell
        self._force: Vector = np.zeros(3)
        self._left = 0.0  # s that the push still lasts
        self._calm_us = 0
        self._before = 0.0  # rad: how far the torso was from upright before the push

    def push(self, newtons: Sequence[float], seconds: float = 0.2) -> None:
        """Push the chest with a force (x, y, z in the world, N) for some seconds."""
        if self._stance.guided and math.hypot(*newtons) < HELD:
            return
        self._force, self._left = np.array(newtons, dtype=np.float64), seconds
        if not self._body.fallen and not self._stance.loose:
            self._before = self._from_upright()
            self._stance.let_go()

    def step(self, us: int, dt: float) -> None:
        """Prepare one step of the physics: apply the push, and check whether the robot falls."""
        if self._left > 0:
            self._left -= dt
            torso = self._body.torso()
            place = torso.position + torso.rotation[:, 2] * CHEST
            self._b.applyExternalForce(self._body.id, -1, self._force.tolist(), place.tolist(), self._b.WORLD_FRAME)
            self._calm_us = us + CALM_US
        if not self._stance.loose or self._body.fallen:
            return
        tilt = self._from_upright() - self._before
        if tilt > TIPPED:
            self._fall(us)
        elif us >= self._calm_us:
            self._catch(tilt, us)

    def _from_upright(self) -> float:
        return math.acos(max(-1.0, min(1.0, float(self._body.torso().rotation[2, 2]))))

    def _fall(self, us: int) -> None:
        self._body.fallen = True
        self._body.rest()
        self._arbiter.bar(frozenset(self._body.robot.data["chains"].values()), LIES, us)
        self._tell(Notice("error", FALLEN))

    def _catch(self, tilt: float, us: int) -> None:
        """Let the guide hold the robot again if it stands still, else try again later."""
        turning = float(np.abs(self._b.getBaseVelocity(self._body.id)[1]).max())
        if abs(tilt) < UPSET and turning < CALM_RATE:
            self._stance.catch()
        else:
            self._calm_us = us + CALM_US // 4
