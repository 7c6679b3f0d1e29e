"""The sonar: how far away the nearest thing in front of the chest is, by rays.

Two beams, left and right of the middle, each a cone full of rays so close that at arm's length nothing larger than a
ball passes between them. The floor is not measured: its echo goes away from the robot.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rrp_sheets.sim.body import Body, Pose, Vector
from rrp_sheets.sim.stage import Stage

if TYPE_CHECKING:
    from rrp_sheets.model.exchange import DeviceUse
    from rrp_sheets.sim.sensors import Senses

NEAREST, FARTHEST = 0.2, 2.5  # m
APART = math.radians(2.5)  # between neighbouring rays
SIDES = ("left", "right")


@lru_cache(maxsize=4)
def cone(opening: float) -> Vector:
    """Unit vectors around x, as rows: rings of rays out to half of `opening` (rad)."""
    rings = max(1, round(opening / 2 / APART))
    rays = [(1.0, 0.0, 0.0)]
    for ring in range(1, rings + 1):
        off = opening / 2 * ring / rings
        for k in range(6 * ring):
            turn = 2 * math.pi * k / (6 * ring)
            rays.append((math.cos(off), math.sin(off) * math.cos(turn), math.sin(off) * math.sin(turn)))
    return np.array(rays)


class Beam:
    """One side of the sonar.

    Args:
        body: it is fixed to.
        beam: its place, as the catalogue has it.
    """

    def __init__(self, body: Body, beam: dict[str, Any]) -> None:
        self._body = body
        self._beam = beam
        self._rays = cone(math.radians(float(beam["cone"])))

    def pose(self) -> Pose:
        """Where it is and where it looks (its x)."""
        torso = self._body.torso()
        turned = _rotation(*(float(a) for a in self._beam["rpy"]))
        return Pose(torso.position + torso.rotation @ np.array(self._beam["xyz"]), torso.rotation @ turned)

    def measure(self, stage: Stage) -> float:
        """The distance of the nearest thing in the cone, m; `FARTHEST` when nothing is there."""
        pose = self.pose()
        solids = [s for s in stage.solids() if s.distance(pose.position) < FARTHEST]
        rays = self._rays @ pose.rotation.T
        nearest = min((float(s.hits(pose.position, rays).min()) for s in solids), default=FARTHEST)
        return min(max(nearest, NEAREST), FARTHEST)


class Sonar:
    """Distances by rays: of one side, or the nearer of both."""

    locates = False

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        side = str(spec.settings.get("side") or "").casefold()
        beams = senses.body.robot.data["sonar"]
        self._beams = [Beam(senses.body, beams[name]) for name in SIDES if side in ("", name)]
        self._stage = senses.stage

    def read(self) -> list[Any]:
        """What it measures now."""
        return [{"distance": min(beam.measure(self._stage) for beam in self._beams)}]


def _rotation(roll: float, pitch: float, yaw: float) -> Vector:
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])  # fmt: skip
