"""Plans trajectories of joints through keyframes: smooth, within limits of position and velocity.

Between its keyframes a joint goes on a cubic curve that never swings over them (Fritsch and Carlson, SIAM Journal on
Numerical Analysis 17, 1980), so that limits that the keyframes keep are kept on the way. Where a joint would have to be
faster than it can, the way takes longer, for all joints alike.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.model.names import key
from rrp_sheets.robots.catalogue import Keyframe, Robot

FIRST = 3.5  # rad/s: nobody throws his arms up to begin
BACK = 2.4  # rad/s, at most, on the way back
SHORTEST = 0.3  # s, of the way back
MARGIN = 0.98  # of a joint's top velocity
ROUNDS = 60  # of lengthening what would be too fast; each brings it nearer
LOOKS = 8  # at the head's yaw between two keyframes
STILL = 1e-4  # rad: as good as there
QUICKEST = 0.5  # s, of each part of the way to a posture
CALM = 4.0  # rad/s at full speed: no joint is faster on the way to a posture
COUPLED = {"LHipYawPitch": "RHipYawPitch", "RHipYawPitch": "LHipYawPitch"}
"""One motor moves both."""
BodyPose = tuple[Mapping[str, float], float]
"""Angles of the joints (rad), and how far the torso leans forward (rad)."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A joint's way through the keyframes that name it: times (s), angles (rad), velocities (rad/s)."""

    times: tuple[float, ...]
    angles: tuple[float, ...]
    slopes: tuple[float, ...]

    @staticmethod
    def through(times: Sequence[float], angles: Sequence[float]) -> Trajectory:
        """The curve, at rest at both ends.

        >>> Trajectory.through([0, 1, 2], [0, 1, 0]).at(0.5)
        (0.5, 1.5)
        """
        steps = [b - a for a, b in itertools.pairwise(times)]
        rises = [(b - a) / h for a, b, h in zip(angles, angles[1:], steps, strict=False)]
        slopes = [0.0]
        for i in range(1, len(rises)):
            before, after = rises[i - 1], rises[i]
            if before * after <= 0:
                slopes.append(0.0)
                continue
            first, second = 2 * steps[i] + steps[i - 1], steps[i] + 2 * steps[i - 1]
            slopes.append((first + second) / (first / before + second / after))
        return Trajectory(tuple(times), tuple(angles), (*slopes, 0.0))

    def at(self, time: float) -> tuple[float, float]:
        """Angle and velocity."""
        if time >= self.times[-1]:
            return self.angles[-1], 0.0
        i = max(bisect.bisect_right(self.times, time) - 1, 0)
        h = self.times[i + 1] - self.times[i]
        s = min(max((time - self.times[i]) / h, 0.0), 1.0)
        a, b, m, n = self.angles[i], self.angles[i + 1], self.slopes[i], self.slopes[i + 1]
        rise = (b - a) / h
        angle = a + h * (s * m + s * s * (3 * rise - 2 * m - n) + s**3 * (m + n - 2 * rise))
        return angle, m + 2 * s * (3 * rise - 2 * m - n) + 3 * s * s * (m + n - 2 * rise)

    def fastest(self, i: int) -> float:
        """The largest speed between two of its keyframes, rad/s."""
        h = self.times[i + 1] - self.times[i]
        rise, m, n = (self.angles[i + 1] - self.angles[i]) / h, self.slopes[i], self.slopes[i + 1]
        a, b = 3 * (m + n - 2 * rise), 2 * (3 * rise - 2 * m - n)
        peaks = [abs(m), abs(n)]
        if a and 0 < -b / (2 * a) < 1:
            peaks.append(abs(m - b * b / (4 * a)))
        return max(peaks)


@dataclass(frozen=True, slots=True)
class Clamped:
    """An angle that a keyframe wants and the joint cannot take: what it takes instead."""

    frame: int
    joint: str
    wanted: float
    given: float


@dataclass(frozen=True, slots=True)
class JointPlan:
    """The ways of joints."""

    ways: Mapping[str, Trajectory]  # by the joint's name
    clamped: tuple[Clamped, ...]  # angles beyond a limit
    # keyframes (by their place) that come later than they should, each with a joint that is not fast enough
    slowed: tuple[tuple[int, str], ...]
    times: tuple[float, ...]  # of the keyframes as they are reached, s

    @property
    def length(self) -> float:
        """Time at which the last joint has arrived, s."""
        return max((way.times[-1] for way in self.ways.values()), default=0.0)


class JointLimits:
    """Limits of a robot's joints; those of the head's pitch depend on its yaw, interpolated in the robot's table."""

    def __init__(self, robot: Robot) -> None:
        self._limits = {joint.name: (joint.lower, joint.upper) for joint in robot.joints.values()}
        self._pitch_by_yaw: Mapping[str, Sequence[float]] | None = robot.data.get("head_pitch_by_yaw")

    def of(self, joint: str, yaw: float = 0.0) -> tuple[float, float]:
        """Return the limits of a joint, by its name in the catalogue, while the head is at a yaw (rad).

        >>> from rrp_sheets.robots import load_robot
        >>> [round(limit, 2) for limit in JointLimits(load_robot()).of("HeadPitch", 1.527)]
        [-0.33, 0.2]
        """
        lower, upper = self._limits[joint]
        if joint != "HeadPitch" or not self._pitch_by_yaw:
            return lower, upper
        low, high = pitch_limits(self._pitch_by_yaw, yaw)
        return max(low, lower), min(high, upper)


def pitch_limits(table: Mapping[str, Sequence[float]], yaw: float) -> tuple[float, float]:
    """Return the limits of the head's pitch at a yaw (rad), on the line between the two beside it in the table."""
    yaws = table["yaw"]
    i = min(max(bisect.bisect_right(yaws, yaw), 1), len(yaws) - 1)
    part = min(max((yaw - yaws[i - 1]) / (yaws[i] - yaws[i - 1]), 0.0), 1.0)
    low, high = (table[side][i - 1] + part * (table[side][i] - table[side][i - 1]) for side in ("lower", "upper"))
    return low, high


def moved(frames: Iterable[Keyframe]) -> tuple[str, ...]:
    """The joints that keyframes move: also those that the same motor moves, and the head's pitch with its yaw."""
    joints = dict.fromkeys(joint for frame in frames for joint in (*frame.angles, *frame.by))
    for joint in list(joints):
        if joint in COUPLED:
            joints[COUPLED[joint]] = None
        if joint == "HeadYaw":
            joints["HeadPitch"] = None
    return tuple(joints)


class Planner:
    """Plans the ways of a robot's joints through keyframes.

    They `start` there (rad; with the head's yaw, when its pitch is among them), and in the end go `home`, or stay.
    They use at most that `share` of their top velocity; none is faster than `peak` (rad/s).
    """

    def __init__(
        self, robot: Robot, start: Mapping[str, float], home: Mapping[str, float] | None = None, *,
        share: float = 1.0, peak: float = math.inf,
    ) -> None:  # fmt: skip
        self._robot, self._start, self._home = robot, start, home
        self._limits = JointLimits(robot)
        self._share, self._peak = share, peak
        self._clamped: list[Clamped] = []
        self._slowed: dict[tuple[int, str], None] = {}

    def plan(self, frames: Sequence[Keyframe]) -> JointPlan:
        """The ways through keyframes with rising times in s."""
        joints = moved(frames)
        goals = self._goals(frames)
        times = [0.0, *(frame.at for frame in frames)]
        if self._home is not None:
            last = {joint: goal[joint] for goal in goals for joint in goal}
            far = max((abs(self._home[j] - last.get(j, self._start[j])) for j in joints), default=0.0)
            times.append(times[-1] + max(SHORTEST, 1.5 * far / BACK))
            goals.append({joint: self._home[joint] for joint in joints})
        places = {j: [0, *(i for i, goal in enumerate(goals, 1) if j in goal)] for j in joints}
        angles = {j: [self._start[j], *(goals[i - 1][j] for i in at[1:])] for j, at in places.items()}
        ways, clock = self._timed(times, places, angles)
        slowed = tuple((i - 1, joint) for i, joint in self._slowed if 1 < i <= len(frames))
        return JointPlan(ways, tuple(self._clamped), slowed, tuple(clock[1 : len(frames) + 1]))

    def _goals(self, frames: Sequence[Keyframe]) -> list[dict[str, float]]:
        """The angles of every keyframe within the limits; a keyframe without any holds those before it."""
        goals: list[dict[str, float]] = []
        before: dict[str, float] = {}
        yaw = self._start.get("HeadYaw", 0.0)
        for n, frame in enumerate(frames):
            wanted = dict(frame.angles)
            wanted.update({j: (self._home or self._start)[j] + by for j, by in frame.by.items()})
            for joint, other in COUPLED.items():
                if joint in wanted:
                    wanted.setdefault(other, wanted[joint])
            yaw = wanted.get("HeadYaw", yaw)
            goal = {}
            for joint, angle in (wanted or before).items():
                low, high = self._limits.of(joint, yaw)
                goal[joint] = min(max(angle, low), high)
                if abs(goal[joint] - angle) > STILL and joint not in frame.by:
                    self._clamped.append(Clamped(n, joint, angle, goal[joint]))
            if "HeadYaw" in goal:
                low, high = self._limits.of("HeadPitch", yaw)
                pitch = before.get("HeadPitch", self._start["HeadPitch"])
                goal.setdefault("HeadPitch", min(max(pitch, low), high))
            goals.append(goal)
            before = {**before, **goal}
        self._keep_off_shoulders(goals)
        return goals

    def _keep_off_shoulders(self, goals: Sequence[dict[str, float]]) -> None:
        """Turned aside the head can nod less: also on the way between two keyframes."""
        yaw = self._start.get("HeadYaw", 0.0)
        before: dict[str, float] = {}
        for goal in goals:
            there = goal.get("HeadYaw", yaw)
            looks = [self._limits.of("HeadPitch", yaw + (there - yaw) * k / LOOKS) for k in range(LOOKS + 1)]
            low, high = max(look[0] for look in looks), min(look[1] for look in looks)
            for each in (before, goal):
                if "HeadPitch" in each:
                    each["HeadPitch"] = min(max(each["HeadPitch"], low), high)
            yaw, before = there, goal

    def _timed(
        self, times: Sequence[float], places: Mapping[str, list[int]], angles: Mapping[str, list[float]]
    ) -> tuple[dict[str, Trajectory], list[float]]:
        top = {j: min(MARGIN * self._share * self._robot.joints[key(j)].max_velocity, self._peak) for j in places}
        steps = [max(b - a, 1e-3) for a, b in itertools.pairwise(times)]
        ways: dict[str, Trajectory] = {}
        clock = list(times)
        for _ in range(ROUNDS):
            clock = [0.0]
            for step in steps:
                clock.append(clock[-1] + step)
            ways = {j: Trajectory.through([clock[i] for i in at], angles[j]) for j, at in places.items()}
            longer = self._longer(ways, places, top, len(steps))
            if max(longer, default=1.0) <= 1.0:
                break
            steps = [step * (ratio * 1.001 if ratio > 1 else 1.0) for step, ratio in zip(steps, longer, strict=True)]
        return ways, clock

    def _longer(
        self, ways: Mapping[str, Trajectory], places: Mapping[str, list[int]], top: Mapping[str, float], count: int
    ) -> list[float]:
        """Return the factor for each step by which it must take longer for joints that would be too fast."""
        longer = [1.0] * count
        for joint, at in places.items():
            for n, (first, last) in enumerate(itertools.pairwise(at)):
                limit = min(top[joint], FIRST) if first == 0 else top[joint]
                ratio = ways[joint].fastest(n) / limit
                if ratio > 1:
                    self._slowed[last, joint] = None
                for i in range(first, last):
                    longer[i] = max(longer[i], ratio)
        return longer


def posture_frames(robot: Robot, now: str, goal: str) -> list[Keyframe]:
    """Return the keyframes from one posture to another: sitting down leads through crouching, for example."""
    passed = route(now, goal, robot.data.get("posture_ways", {}))
    return [
        Keyframe(QUICKEST * n, {joint: float(angle) for joint, angle in robot.data["postures"][posture].items()})
        for n, posture in enumerate(passed, 1)
    ]


def route(now: str, goal: str, ways: Mapping[str, str]) -> list[str]:
    """Return the postures from one to another, by way of the first one that leads to both.

    >>> ways = {"Crouch": "StandInit", "Sit": "Crouch", "Lie": "Sit", "Kneel": "Crouch"}
    >>> route("Stand", "Sit", ways), route("Lie", "Stand", ways), route("Sit", "Kneel", ways), route("Sit", "Sit", ways)
    (['Crouch', 'Sit'], ['Sit', 'Crouch', 'Stand'], ['Crouch', 'Kneel'], ['Sit'])
    """
    up, down = _below(now, ways), _below(goal, ways)
    both = next((posture for posture in up if posture in down), None)
    if both is not None:
        up, down = up[: up.index(both) + 1], down[: down.index(both)]
    found = [*up[1:], *reversed(down)]
    return found if found[-1:] == [goal] else [*found, goal]


def _below(name: str, ways: Mapping[str, str]) -> list[str]:
    """Return a posture and those that lead up from it, without the one that is standing."""
    found = []
    while name in ways:
        found.append(name)
        name = ways[name]
    return found
