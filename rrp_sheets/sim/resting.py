"""How a body in any posture comes to rest on the floor: on its soles, sitting, lying.

Of all ways to lean, gravity takes the one nearest by in which the body's weight is lowest: standing, that is with level
soles; with the legs stretched out in front, it is sitting on thighs and heels.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rrp_sheets.sim.body import HALT_TIME, SOLE, STEP, Body, Vector
from rrp_sheets.sim.motion import Glide

FRONT, BACK, INNER, OUTER = 0.105, -0.047, 0.037, 0.046  # m, of a sole, from below the ankle
MARGIN = 0.03  # m: the robot does not tip over its soles' ends before its weight is so far beyond them
ROLL_VELOCITY, ROLL_ACCELERATION = 1.0, 4.0  # rad/s, rad/s²: of the torso that settles
SINK_VELOCITY = 0.6  # m/s, of the torso on its way down or up
TOUCHES = 0.01  # m: what is nearer to the floor stands on it, the nearer the firmer
WITHIN = 0.5  # rad around where it is to settle: it does not tip over, as a guide holds it
SAME = 5e-4  # rad: a rest that is nearer is the same
SEARCH_EVERY = 4  # steps of the physics
AROUND, SHARPENINGS = 57, 4  # leans that are tried, and how often nearer ones are
BALLS = {  # link, place on it and radius (m) of what may touch the floor besides the soles
    "torso": ((-0.024, 0.025, -0.088, 0.037), (-0.024, -0.025, -0.088, 0.037), (-0.015, 0.035, 0.09, 0.03),
              (-0.015, -0.035, 0.09, 0.03), (0.015, 0.035, 0.09, 0.03), (0.015, -0.035, 0.09, 0.03)),
    "Head": ((0.0, 0.0, 0.058, 0.057),),
    "LThigh": ((0.006, 0.003, -0.02, 0.033), (0.006, 0.003, -0.081, 0.033)),
    "RThigh": ((0.006, -0.003, -0.02, 0.033), (0.006, -0.003, -0.081, 0.033)),
    "LTibia": ((0.006, 0.0, -0.006, 0.03), (0.004, 0.002, -0.087, 0.031)),
    "RTibia": ((0.006, 0.0, -0.006, 0.03), (0.004, -0.002, -0.087, 0.031)),
    "LShoulder": ((0.0, -0.004, 0.0, 0.031),), "RShoulder": ((0.0, 0.004, 0.0, 0.031),),
    "LBicep": ((0.086, 0.012, 0.0, 0.024),), "RBicep": ((0.086, -0.012, 0.0, 0.024),),
    "LForeArm": ((0.03, 0.0, 0.0, 0.028),), "RForeArm": ((0.03, 0.0, 0.0, 0.028),),
    "l_wrist": ((0.045, 0.0, 0.0, 0.026),), "r_wrist": ((0.045, 0.0, 0.0, 0.026),),
}  # fmt: skip


class Resting:
    """Finds where the torso goes while the joints move.

    Args:
        bullet: the physics.
        body: the robot.
        place, lean, yaw: of the torso now.
    """

    def __init__(self, bullet: Any, body: Body, place: Vector, lean: float, yaw: float) -> None:
        self._b, self._body = bullet, body
        self.place = place.copy()
        self.yaw = yaw
        self._lean = Glide(lean)
        self._towards = 0.0
        self._halted = False
        self._count = 0
        soles = [(f"{s}_ankle", (x, y, SOLE, 0.0)) for s, inner, outer in (("l", -INNER, OUTER), ("r", -OUTER, INNER))
                 for x in (FRONT, BACK) for y in (inner, outer)]  # fmt: skip
        balls = [(link, ball) for link, many in BALLS.items() for ball in many]
        links = [body.links.get(link, -1) for link, _ in (*soles, *balls)]  # the torso is none
        self._used = sorted(set(links) - {-1})
        self._frames = [self._used.index(link) + 1 if link >= 0 else 0 for link in links]
        self._local = np.array([ball[:3] for _, ball in (*soles, *balls)])
        self._radius = np.array([ball[3] for _, ball in (*soles, *balls)])
        self._soles = len(soles)
        self._beyond = np.zeros_like(self._local)
        self._beyond[: self._soles, 0] = np.where(self._local[: self._soles, 0] > 0, MARGIN, -MARGIN)
        self._masses = np.array([bullet.getDynamicsInfo(body.id, i)[0] for i in range(-1, len(body.links))])
        self._before: Vector | None = None
        self._still = 0

    @property
    def lean(self) -> float:
        """Of the torso, rad, positive forward."""
        return self._lean.position

    @property
    def settled(self) -> bool:
        """Whether the torso has come to rest."""
        return self._still >= 24  # steps of the physics: a tenth of a second

    def settle(self, towards: float) -> None:
        """Settle anew, around a lean (rad)."""
        self._towards = towards
        self._halted, self._still = False, 0

    def halt(self) -> None:
        """Come to rest at once, as it is, until told to settle."""
        self._halted = True
        self._lean.acceleration = max(ROLL_ACCELERATION, abs(self._lean.speed) / HALT_TIME)
        self._lean.halt()

    def step(self) -> None:
        """One step of the physics: where the torso goes next."""
        points, weight, wider = self._shape()
        if not self._halted and self._count % SEARCH_EVERY == 0:
            goal = self._rest(wider, weight)
            if abs(goal - self._lean.target) > SAME:
                self._lean.go(goal, ROLL_VELOCITY, ROLL_ACCELERATION)
        self._count += 1
        self._lean.step(STEP)
        c, s = math.cos(self.lean), math.sin(self.lean)
        heights = c * points[:, 2] - s * points[:, 0] - self._radius
        low = float(heights.min())
        turned = np.column_stack([c * points[:, 0] + s * points[:, 2], points[:, 1]])
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        flat = turned @ np.array([[cy, sy], [-sy, cy]])
        place = np.array([*self.place[:2], -low])
        if self._before is not None:
            firm = np.maximum(0.0, 1 - (heights - low) / TOUCHES)
            place[:2] -= firm @ (flat - self._before) / firm.sum()
        self._before = flat
        move = place - self.place
        move[2] = max(-SINK_VELOCITY * STEP, min(SINK_VELOCITY * STEP, move[2]))
        self.place = self.place + move
        calm = not self._lean.moving and float(np.abs(move).max()) < 2e-5
        self._still = self._still + 1 if calm else 0

    def _shape(self) -> tuple[Vector, Vector, Vector]:
        """In the torso's frame: what may touch the floor, the centre of the weight, and the soles' ends with margin."""
        b, body = self._b, self._body
        torso = body.torso()
        count = len(body.links)
        states = b.getLinkStates(body.id, list(range(count)), computeForwardKinematics=True)
        centre, _ = b.getBasePositionAndOrientation(body.id)
        masses = np.array([centre, *(s[0] for s in states)])
        weight = torso.rotation.T @ (self._masses @ masses / self._masses.sum() - torso.position)
        back = torso.rotation.T
        turns, places = [np.eye(3)], [np.zeros(3)]
        for index in self._used:
            turns.append(back @ np.array(b.getMatrixFromQuaternion(states[index][5])).reshape(3, 3))
            places.append(back @ (np.array(states[index][4]) - torso.position))
        turned = np.array(turns)[self._frames]
        points = np.einsum("nij,nj->ni", turned, self._local) + np.array(places)[self._frames]
        wider = points + np.einsum("nij,nj->ni", turned, self._beyond)
        return points, weight, wider

    def _rest(self, wider: Vector, weight: Vector) -> float:
        """The lean at which the weight is lowest: of several such leans the nearest."""

        def height(leans: Vector) -> Vector:
            c, s = np.cos(leans), np.sin(leans)
            low = np.outer(c, wider[:, 2]) - np.outer(s, wider[:, 0]) - self._radius
            lifted: Vector = c * weight[2] - s * weight[0] - low.min(axis=1)
            return lifted

        leans = self._towards + np.linspace(-WITHIN, WITHIN, AROUND)
        heights = height(leans)
        lowest = np.flatnonzero((heights[1:-1] <= heights[:-2]) & (heights[1:-1] < heights[2:])) + 1
        if not len(lowest):
            return float(leans[heights.argmin()])
        lean = leans[lowest[np.abs(leans[lowest] - self.lean).argmin()]]
        wide = leans[1] - leans[0]
        for _ in range(SHARPENINGS):
            near = np.linspace(lean - wide, lean + wide, 9)
            lean, wide = near[height(near).argmin()], wide / 4
        return float(lean)
