"""Walking and turning: where the feet are put, the torso between them, and the joints of the legs.

Pure geometry on the floor. Each step swings one foot while the other stands; the torso goes to the middle between both,
as one motor turns both feet outwards by the same angle: a turn to the left is opened by the left foot, closed by the
right one, and so is a step aside.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrp_sheets.perception.pinhole import Vector
from rrp_sheets.sim.body import HALT_TIME

STEP_TIME = 0.36  # s
STRIDE, ASIDE, TURN = 0.034, 0.030, 0.40  # m, m, rad: how far a foot is put from beside the other one
LIFT = 0.018  # m, of the foot that swings
SWAY = 0.010  # m, of the torso towards the foot that stands
SWING = (0.1, 0.9)  # of a step's time: when the foot is in the air
ARRIVED = 1e-6  # m and rad
AHEAD = 3.0  # rad: how far ahead the goal of a turn without end is
SPREAD = (STRIDE, ASIDE, TURN)
JOINTS = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")
SLOPE = math.pi / 4  # rad, of the hip's first axis
STRETCHED = 0.999  # of the leg's length: nearer to its end a knee would jerk
CLOSE = 1e-5  # rad, of the hip's first joint: near enough when the foot's direction is searched for
ROUNDS = 8


@dataclass(frozen=True, slots=True)
class FootPlace:
    """A place on the floor with a heading: m, m, rad.

    >>> start = FootPlace(1.0, 0.0, math.pi / 2)
    >>> there = start.plus(0.5, 0.0, 0.1)
    >>> round(there.x, 3), round(there.y, 3)
    (1.0, 0.5)
    >>> [round(c, 3) for c in start.seen(there)]
    [0.5, 0.0, 0.1]
    """

    x: float
    y: float
    yaw: float

    def plus(self, forward: float, left: float, turn: float = 0.0) -> FootPlace:
        """Return the place at an offset from this one, in its frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return FootPlace(self.x + c * forward - s * left, self.y + s * forward + c * left, self.yaw + turn)

    def seen(self, other: FootPlace) -> tuple[float, float, float]:
        """Return another place as seen from this one: ahead, to the left, turned."""
        c, s, x, y = math.cos(self.yaw), math.sin(self.yaw), other.x - self.x, other.y - self.y
        return c * x + s * y, c * y - s * x, other.yaw - self.yaw

    def to(self, other: FootPlace, part: float, turned: float | None = None) -> FootPlace:
        """Return a place on the way to another: `part` of the way (0 to 1), and `turned` of the turn if given."""
        x, y = self.x + part * (other.x - self.x), self.y + part * (other.y - self.y)
        return FootPlace(x, y, self.yaw + (part if turned is None else turned) * (other.yaw - self.yaw))


@dataclass(frozen=True)
class Standing:
    """Posture of the robot before and after it walks; places in m, from the middle between the feet."""

    torso: Vector
    lean: float  # of the torso, rad, positive forward
    ankles: Mapping[str, Vector]


class Gait:
    """Steps towards a goal, which may change at any time; at the start the feet stand beside each other."""

    def __init__(self, legs: Legs, standing: Standing, start: FootPlace) -> None:
        self._legs, self._standing = legs, standing
        self._feet = {"L": start, "R": start}  # where the middle is for each that has the other one beside it
        self.middle = start  # between the feet, at the end of the last step
        self._goal = self._from = self._to = self._lifted = start
        self._spread = SPREAD
        self._speed = self._speed_then = (0.0, 0.0)  # m/s, of the middle when the step begins and ends
        self.swings, self._next = "", "L"  # swings: the foot that makes the step, empty between steps
        self._time = 0.0
        self._pace = self._height = 1.0
        self._halts = False

    @property
    def beside(self) -> bool:
        """True when both feet are on the floor, beside each other, with nothing to do."""
        return not self.swings and self.at(self._goal)

    @property
    def here(self) -> FootPlace:
        """Place where the robot would stand if it went no further: where a foot was put last, or is being put."""
        return self._feet[self.swings or ("R" if self._next == "L" else "L")]

    @property
    def at_rest(self) -> bool:
        """True when nothing moves any more: the goal is reached, or the gait was halted."""
        return self.beside or (self._halts and self._pace == self._height == 0.0)

    def go(self, goal: FootPlace, spread: tuple[float, float, float] = SPREAD) -> None:
        """Walk to a goal; the step that is going on is finished first.

        Args:
            goal: for the middle between the feet.
            spread: how far one foot is put from beside the other at most: ahead and aside (m), turned (rad).
        """
        if not self._halts:
            self._goal, self._spread = goal, spread

    def turn(self, rate: float) -> None:
        """Turn on the spot at a rate (rad/s) until another goal is given; 0 ends it."""
        about = min(TURN, 2 * STEP_TIME * abs(rate))
        self.go(self.here.plus(0.0, 0.0, math.copysign(AHEAD, rate) if rate else 0.0), (STRIDE, ASIDE, about))

    def close(self) -> None:
        """Finish the step and put the feet beside each other."""
        self.turn(0.0)

    def halt(self) -> None:
        """Come to rest at once, where it is; the foot in the air goes straight down. It does not walk again."""
        self._halts = True

    def step(self, dt: float) -> tuple[FootPlace, Vector, dict[str, float]]:
        """Let `dt` seconds pass; return the torso's spot, its place (x, y, z in m), and the legs' joints (rad)."""
        if self._halts:
            self._pace = max(0.0, self._pace - dt / HALT_TIME)
            self._height = max(0.0, self._height - dt / HALT_TIME)
        if not self.swings and not self._halts and not self.at(self._goal):
            self._plan()
        if self.swings:
            self._time = min(self._time + dt * self._pace, STEP_TIME)
        pose = self._pose(min(1.0, self._time / STEP_TIME))
        if self.swings and self._time >= STEP_TIME - 1e-9:
            self.swings, self.middle = "", self._to
        return pose

    @property
    def bound(self) -> float | None:
        """Direction in which the robot walks, rad; None when it stands or turns on the spot."""
        to = self._goal
        ahead, left = to.x - self.middle.x, to.y - self.middle.y
        return None if self.beside or max(abs(ahead), abs(left)) < ARRIVED else math.atan2(left, ahead)

    def at(self, goal: FootPlace) -> bool:
        """Return whether both feet are where a goal wants them."""
        return all(_near(foot, goal) for foot in self._feet.values())

    def _plan(self) -> None:
        """Choose the next step."""
        if _near(self._feet["L"], self._feet["R"]):
            # The foot on the side that it goes or turns to begins.
            _, left, turn = self.middle.seen(self._goal)
            way = left if abs(left) > ARRIVED else turn
            self._next = "L" if way > ARRIVED else "R" if way < -ARRIVED else self._next
        self.swings, self._next = self._next, "R" if self._next == "L" else "L"
        stands = self._feet[self._next]
        put = stands.plus(*self._offset(*stands.seen(self._goal)))
        if _near(put, self._goal):
            put = self._goal
        self._lifted, self._feet[self.swings] = self._feet[self.swings], put
        self._from, self._to, self._time = self.middle, stands.to(put, 0.5), 0.0
        goes_on = not self.at(self._goal) and not _near(put, self._goal)
        self._speed = self._speed_then
        x, y = self._to.x - self._from.x, self._to.y - self._from.y
        self._speed_then = (x / STEP_TIME, y / STEP_TIME) if goes_on else (0.0, 0.0)

    def _offset(self, ahead: float, left: float, turn: float) -> tuple[float, float, float]:
        """Return the swinging foot's next offset from beside the standing foot, on the way to a goal."""
        far, aside, about = self._spread
        sign = 1.0 if self.swings == "L" else -1.0
        if max(abs(ahead), abs(left)) > ARRIVED:
            turn = 0.0  # first to the place, then the turn
        steps = max(abs(ahead) / max(far, ARRIVED), 2 * abs(left) / max(aside, ARRIVED), 1.0)
        far, aside = abs(ahead) / steps, min(aside, 2 * abs(left) / steps)  # so that the way is straight
        return (
            min(max(ahead, -far), far),
            sign * min(max(sign * left, 0.0), aside),
            sign * min(max(sign * turn, 0.0), about),
        )

    def _pose(self, part: float) -> tuple[FootPlace, Vector, dict[str, float]]:
        """The pose at a part of the step, 0 to 1."""
        standing, swings = self._standing, self.swings
        swing = min(max((part - SWING[0]) / (SWING[1] - SWING[0]), 0.0), 1.0)
        eased = swing**3 * (10 - 15 * swing + 6 * swing**2)
        middle, feet = self.middle, dict(self._feet)
        sway = height = 0.0
        if swings:
            x, y = (
                _between(getattr(self._from, c), getattr(self._to, c), a * STEP_TIME, b * STEP_TIME, part)
                for c, a, b in zip("xy", self._speed, self._speed_then, strict=True)
            )
            middle = FootPlace(x, y, self._from.yaw + eased * (self._to.yaw - self._from.yaw))
            feet[swings] = self._lifted.to(self._feet[swings], eased)
            height = LIFT * math.sin(math.pi * swing) ** 2 * self._height
            sway = (-SWAY if swings == "L" else SWAY) * math.sin(math.pi * part) ** 2
        x, y, z = standing.torso
        spot = middle.plus(float(x), float(y) + sway)
        torso = np.array([spot.x, spot.y, float(z)])
        stands = self._next
        joints = self._leg(stands, feet[stands], torso, spot.yaw, 0.0, None)
        other = "R" if stands == "L" else "L"
        joints |= self._leg(other, feet[other], torso, spot.yaw, height, joints[f"{stands}{JOINTS[0]}"])
        return spot, torso, joints

    def _leg(
        self, side: str, foot: FootPlace, torso: Vector, yaw: float, height: float, shared: float | None
    ) -> dict[str, float]:
        """The joints of a leg whose foot is at a spot and at a height; `shared` is the joint that the other has set."""
        ahead, left, up = self._standing.ankles[side]
        at = foot.plus(float(ahead), float(left))
        forward, aside, _ = FootPlace(float(torso[0]), float(torso[1]), yaw).seen(at)
        level = _about_y(-self._standing.lean)
        ankle = level @ np.array([forward, aside, float(up) + height - float(torso[2])])
        turned = foot.yaw - yaw
        if shared is not None:
            return self._legs.turned(side, ankle, level, turned, shared)[0]
        return self._legs.joints(side, ankle, level @ _about_z(turned))


def _near(one: FootPlace, other: FootPlace) -> bool:
    return max(abs(one.x - other.x), abs(one.y - other.y), abs(one.yaw - other.yaw)) < ARRIVED


def _between(start: float, end: float, speed: float, speed_then: float, part: float) -> float:
    """Interpolate smoothly between two places, with given speeds at both (per the whole way's time)."""
    t, t2, t3 = part, part**2, part**3
    return (2 * t3 - 3 * t2 + 1) * start + (t3 - 2 * t2 + t) * speed + (3 * t2 - 2 * t3) * end + (t3 - t2) * speed_then


class Legs:
    """Geometry of the legs, and the joints for given places of the feet.

    Args:
        data: `[legs]` of the robot's catalogue, in m: `thigh`, `tibia`, `hip` (x, y, z of the left one in the torso).
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._thigh, self._tibia = float(data["thigh"]), float(data["tibia"])
        self._hip = tuple(float(c) for c in data["hip"])

    def hip(self, side: str) -> Vector:
        """Return the place of a leg's upper end, in the torso's frame."""
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
        """The joints, and the foot's direction, when the other leg has chosen the hip's first joint, which both share.

        `ankle` (m) and `tilt`, the level as a matrix, are in the torso's frame; `yaw` is a first guess of the foot's
        direction, relative to the torso's, and `yaw_pitch` the joint of the other leg (rad).
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
