"""How the robot stands: free, held, being turned, or with legs that were told to move.

Standing and looking around are physics. Moving arms and legs
and turning are *guided*: the torso is held by a constraint that follows what the legs do, so that the robot never
falls. It is not dynamic walking, and does not claim to be.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rrp_sheets.sim.body import STEP, Body, Vector

FASTEST_TURN = 0.7  # rad/s
TURN_CHANGE = 2.0  # rad/s², how fast the turning speeds up or slows down
STEPS_A_SECOND = 1.6  # of each foot
LIFT = 0.016  # m, of a foot when turning fastest
GUIDE_FORCE = 400.0  # N; holds the robot's weight (53 N) without letting it sway
REST_AFTER = 0.4  # s without turning before the feet are put down
GUIDE_SPEED = 0.5  # m/s, of the torso when it follows the legs


class Stance:
    """Holds the robot up."""

    def __init__(self, bullet: Any, body: Body) -> None:
        self._b = bullet
        self._body = body
        self._legs = body.robot.data["legs"]
        self._guide: int | None = None
        self._on_feet = False
        self._turns = False
        self._steady = False
        self._wanted = 0.0
        self._rate = 0.0
        self._calm = 0.0
        self._phase = 0.0
        self._yaw = 0.0
        self._lean = 0.0
        self._place: Vector = np.zeros(3)
        self._soles: dict[str, Vector] = {}

    @property
    def turning(self) -> float:
        """How fast the body turns now, rad/s, positive to the left."""
        return self._rate

    def turn(self, rate: float) -> None:
        """Turn the whole body at a rate (rad/s) until told otherwise; 0 stops."""
        self._wanted = 0.0 if self._on_feet else max(-FASTEST_TURN, min(FASTEST_TURN, rate))
        if self._wanted and not self._turns:
            self._hold()
            self._turns = True
            self._body.grip(False)

    def steady(self) -> None:
        """From now on hold the torso: swinging arms would make the robot fall, as it has no balance of its own."""
        self._steady = True
        self._hold()

    def follow_legs(self) -> None:
        """From now on the torso follows the legs' joints: the lower sole stays on the floor, level."""
        if self._on_feet:
            return
        self._hold()
        if self._turns:
            self._body.grip(True)
        self._wanted = self._rate = 0.0
        self._on_feet, self._turns = True, False
        self._soles = {side: self._body.sole(side).position for side in "LR"}

    def step(self) -> None:
        """One step of the physics."""
        if self._on_feet:
            self._follow()
        elif self._turns:
            self._turn()

    def _hold(self) -> None:
        if self._guide is not None:
            return
        torso = self._body.torso()
        _, self._lean, self._yaw = self._body.tilt()
        self._place = torso.position
        centre = self._b.getDynamicsInfo(self._body.id, -1)[3]
        self._guide = self._b.createConstraint(
            self._body.id, -1, -1, -1, self._b.JOINT_FIXED, [0, 0, 0], [-c for c in centre], torso.position.tolist(),
            [0, 0, 0, 1], self._b.getQuaternionFromEuler([0, self._lean, self._yaw]),
        )  # fmt: skip
        self._move_guide()

    def _move_guide(self) -> None:
        self._b.changeConstraint(
            self._guide, jointChildPivot=self._place.tolist(), maxForce=GUIDE_FORCE,
            jointChildFrameOrientation=self._b.getQuaternionFromEuler([0, self._lean, self._yaw]),
        )  # fmt: skip

    def _turn(self) -> None:
        change = TURN_CHANGE * STEP
        self._rate += max(-change, min(change, self._wanted - self._rate))
        self._yaw += self._rate * STEP
        self._calm = 0.0 if self._rate or self._wanted else self._calm + STEP
        height = LIFT * min(1.0, abs(self._rate) / (0.5 * FASTEST_TURN))
        if self._calm == 0.0:
            self._phase += 2 * math.pi * STEPS_A_SECOND * STEP
            for side, shift in (("L", 0.0), ("R", math.pi)):
                self._lift(side, height * max(0.0, math.sin(self._phase + shift)))
        elif self._calm >= REST_AFTER:
            self._release()
            return
        self._move_guide()

    def _lift(self, side: str, height: float) -> None:
        """Raise a foot (m) above where it stands in the start posture, the sole level."""
        a, b = self._legs["thigh"], self._legs["tibia"]
        hip, knee, ankle = (self._body.start[f"{side}{j}"] for j in ("HipPitch", "KneePitch", "AnklePitch"))
        lean = hip + knee + ankle
        ahead = -a * math.sin(hip) - b * math.sin(hip + knee) - height * math.sin(-lean)
        down = a * math.cos(hip) + b * math.cos(hip + knee) - height * math.cos(lean)
        reach = min(math.hypot(ahead, down), 0.999 * (a + b))
        knee = math.acos(max(-1.0, min(1.0, (reach**2 - a**2 - b**2) / (2 * a * b))))
        hip = -math.atan2(ahead, down) - math.asin(b * math.sin(knee) / reach)
        for joint, angle in (("HipPitch", hip), ("KneePitch", knee), ("AnklePitch", lean - hip - knee)):
            self._body.put(f"{side}{joint}", angle)

    def _release(self) -> None:
        for side in "LR":
            self._lift(side, 0.0)
        if not self._steady:
            self._b.removeConstraint(self._guide)
            self._guide = None
        self._turns = False
        self._calm = self._phase = 0.0
        self._body.grip(True)

    def _follow(self) -> None:
        """Put the torso where the legs carry it."""
        torso = self._body.torso()
        leans = {
            side: -sum(self._body.position(f"{side}{j}") for j in ("HipPitch", "KneePitch", "AnklePitch"))
            for side in "LR"
        }
        lean = min(leans.values(), key=lambda each: abs(each - self._lean))  # the leg that stands moves less
        change = STEP * 1.0  # rad
        self._lean += max(-change, min(change, max(-0.35, min(0.35, lean)) - self._lean))
        c, s, cy, sy = math.cos(self._lean), math.sin(self._lean), math.cos(self._yaw), math.sin(self._yaw)
        rotation = np.array([[cy * c, -sy, cy * s], [sy * c, cy, sy * s], [-s, 0, c]])
        reach = {side: rotation @ torso.rotation.T @ (self._body.sole(side).position - torso.position) for side in "LR"}
        side = min(reach, key=lambda each: float(reach[each][2]))
        place = np.array([*(self._soles[side] - reach[side])[:2], -reach[side][2]])
        move = place - self._place
        far = float(np.linalg.norm(move))
        self._place = self._place + move * min(1.0, GUIDE_SPEED * STEP / far if far else 1.0)
        self._move_guide()
