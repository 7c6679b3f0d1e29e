"""Pointing with an arm: the line from the shoulder through the hand goes to a target, whose motion is predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rrp_sheets.sim.body import Body, Vector

BESIDE = 0.12  # m, of the target to the other side: so far the arm that points keeps pointing, across the body
HANGING, RAISED, OFF = 1.1, 0.9, 0.06  # rad: an arm that hangs lower or is raised higher keeps so far off the body
OPEN, STRAIGHT = 1.0, {"ElbowYaw": 0.0, "ElbowRoll": 0.0, "WristYaw": 0.0}


class Pointing:
    """Chooses the arm that points at a place, and computes its joints.

    Args:
        body: the robot; `[arm]` of its catalogue has the place of the left `hand` from the shoulder, stretched (m).
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        data: Mapping[str, Any] = body.robot.data["arm"]
        self._hand = np.array(data["hand"], dtype=np.float64)

    def joints(self, side: str, target: Vector) -> dict[str, float]:
        """Return the joints of an arm (`L` or `R`) that point at a place in the world, as far as their limits allow."""
        torso = self._body.torso()
        towards = torso.rotation.T @ (target - self._body.link(f"{side}Shoulder").position)
        ahead, left, up = (float(c) for c in towards / np.linalg.norm(towards))
        x, y, z = (float(c) for c in self._hand)
        y = y if side == "L" else -y
        wide = math.hypot(x, y)
        low, high = self._body.limits(f"{side}ShoulderRoll")
        # Behind the shoulder it points up or down beside itself rather than through the body.
        pitch = math.atan2(-up, ahead) if ahead > 0.05 else -math.copysign(math.pi / 2, up)
        if pitch > HANGING or pitch < -RAISED:  # beside the thigh or the head, not through it
            low, high = (max(low, OFF), high) if side == "L" else (low, min(high, -OFF))
        reach = max(-1.0, min(1.0, left * math.hypot(wide, z) / wide))
        roll = min(max(math.asin(reach) - math.atan2(y, x), low), high)
        along = x * math.cos(roll) - y * math.sin(roll)
        pose = {"ShoulderPitch": pitch + math.atan2(z, along), "ShoulderRoll": roll, **STRAIGHT, "Hand": OPEN}
        joints = {}
        for joint, angle in pose.items():
            low, high = self._body.limits(side + joint)
            joints[side + joint] = min(max(angle, low), high)
        return joints

    def nearer(self, target: Vector, now: str) -> str:
        """Return the arm that is to point at a place: the one on its side, or the present one until far beyond."""
        torso = self._body.torso()
        left = float((torso.rotation.T @ (target - torso.position))[1])
        if now == "L":
            return "R" if left < -BESIDE else "L"
        if now == "R":
            return "L" if left > BESIDE else "R"
        return "L" if left >= 0 else "R"


class MotionPredictor:
    """Predicts where a thing that is seen now and then will be a moment later, if it goes on as it did.

    >>> predictor = MotionPredictor()
    >>> for us in (0, 100_000, 200_000, 300_000): ahead = predictor.seen(us, np.array([us / 1e6, 0.0]))
    >>> 0.42 < float(ahead[0]) < 0.46
    True
    """

    LEAD = 0.14  # s: what a motion lags behind its target, and half the time until the next picture
    SMOOTH = 0.6  # of the newest speed
    LONGEST_US = 700_000  # what has not been seen for longer begins anew

    def __init__(self) -> None:
        self._us = -self.LONGEST_US
        self._last: Vector | None = None
        self._speed: Vector | None = None

    def seen(self, us: int, where: Vector) -> Vector:
        """Take a sighting (µs, any coordinates); return where the thing will be."""
        passed = us - self._us
        if self._last is None or not 0 < passed <= self.LONGEST_US:
            self._speed = None
        else:
            speed = (where - self._last) / (passed / 1e6)
            self._speed = speed if self._speed is None else self._speed + self.SMOOTH * (speed - self._speed)
        self._us, self._last = us, where
        return where if self._speed is None else where + self._speed * self.LEAD
