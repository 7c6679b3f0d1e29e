"""The legs' joints for a foot that is to be somewhere, in closed form: three axes meet in the hip, two in the ankle.

A leg is a chain: the hip's yaw-pitch (about an axis of 45°), roll and pitch, the thigh, the knee, the shin, the
ankle's pitch and roll.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rrp_sheets.sim.body import Vector

JOINTS = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")
SLOPE = math.pi / 4  # rad, of the hip's first axis
STRETCHED = 0.999  # of the leg's length: nearer to its end a knee would jerk
CLOSE = 1e-5  # rad, of the hip's first joint: near enough when the foot's direction is searched for
ROUNDS = 8


class Legs:
    """The geometry of the legs.

    Args:
        data: `[legs]` of the robot's catalogue, in m: `thigh`, `tibia`, `hip` (x, y, z of the left one in the torso).
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._thigh, self._tibia = float(data["thigh"]), float(data["tibia"])
        self._hip = tuple(float(c) for c in data["hip"])

    def hip(self, side: str) -> Vector:
        """Where a leg begins, in the torso's frame."""
        x, y, z = self._hip
        return np.array([x, y if side == "L" else -y, z])

    def joints(self, side: str, ankle: Vector, rotation: Vector) -> dict[str, float]:
        """The joints (rad) for an ankle at a place (m) with an orientation (a matrix), both in the torso's frame.

        A foot that is out of reach is put as near as the leg goes.
        """
        a, b = self._thigh, self._tibia
        x, y, z = (float(c) for c in rotation.T @ (self.hip(side) - ankle))  # the hip as seen from the foot
        roll = math.atan2(y, z)
        z = math.hypot(y, z)
        reach = math.hypot(x, z)
        far = min(max(reach, 0.3 * (a + b)), STRETCHED * (a + b))
        knee = math.acos(max(-1.0, min(1.0, (far**2 - a**2 - b**2) / (2 * a * b))))
        ankle_pitch = math.atan2(-a * math.sin(knee), b + a * math.cos(knee)) - math.atan2(x, z)
        # What is left of the foot's orientation is the hip's: a turn about y, one about x, one about y.
        slope = SLOPE if side == "L" else -SLOPE
        turn = _about_x(slope) @ rotation @ _about_x(-roll) @ _about_y(-knee - ankle_pitch)
        sign = 1.0 if side == "L" else -1.0
        hip_roll = sign * math.acos(max(-1.0, min(1.0, turn[1, 1]))) - slope
        hip_pitch = math.atan2(sign * turn[1, 0], -sign * turn[1, 2])
        yaw_pitch = math.atan2(sign * turn[0, 1], sign * turn[2, 1])
        angles = (yaw_pitch, hip_roll, hip_pitch, knee, ankle_pitch, roll)
        return {f"{side}{joint}": angle for joint, angle in zip(JOINTS, angles, strict=True)}

    def turned(
        self, side: str, ankle: Vector, tilt: Vector, yaw: float, yaw_pitch: float
    ) -> tuple[dict[str, float], float]:
        """The joints for an ankle at a place when the other leg has chosen the hip's first joint, which both share.

        Args:
            side: of the foot.
            ankle: in the torso's frame, m.
            tilt: the level in the torso's frame: a matrix.
            yaw: where the foot's direction (rad, against the torso's) is looked for first.
            yaw_pitch: of the other leg, rad.

        Returns:
            The joints, and the foot's direction.
        """
        name = f"{side}{JOINTS[0]}"
        before = joints = self.joints(side, ankle, tilt @ _about_z(yaw))
        off, step = joints[name] - yaw_pitch, 0.02
        for _ in range(ROUNDS):
            if abs(off) < CLOSE or abs(step) < 1e-9:
                break
            joints = self.joints(side, ankle, tilt @ _about_z(yaw + step))
            slope = (joints[name] - before[name]) / step
            yaw += step
            off, before = joints[name] - yaw_pitch, joints
            step = max(-0.3, min(0.3, -off / slope)) if slope else 0.0
        return joints, yaw


def _about_x(angle: float) -> Vector:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def _about_y(angle: float) -> Vector:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def _about_z(angle: float) -> Vector:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
