"""Trackers: head, whole body or arms follow what a sensor detects; the actuator that starts and ends them.

They know only the detections (angles in the picture, distance) and the robot's own joints: a closed loop through the
camera, as on a real robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value
from rrp_sheets.perception.pinhole import Pose, Vector
from rrp_sheets.sim.actuators.base import Parts, SimActuator
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.body import EASY, STEP, Body
from rrp_sheets.sim.stance import Stance
from rrp_sheets.texts import N_

BESIDE = 0.12  # m, of the target to the other side: so far the arm that points keeps pointing, across the body
HANGING, RAISED, OFF = 1.1, 0.9, 0.06  # rad: an arm that hangs lower or is raised higher keeps so far off the body
OPEN, STRAIGHT = 1.0, {"ElbowYaw": 0.0, "ElbowRoll": 0.0, "WristYaw": 0.0}
HEAD_VELOCITY, HEAD_ACCELERATION = 2.5, 18.0  # rad/s, rad/s²: brisk, without jerks
ARM_VELOCITY, ARM_ACCELERATION = 2.0, 10.0
CALM = 0.008  # rad: nearer to the middle of the picture the head keeps still
TURN_FROM, TURN_TO = 0.30, 0.05  # rad of head yaw: the body begins and stops turning
TURN_GAIN = 1.6  # rad/s of turning per rad of head yaw
LOST_AFTER = 1.0  # s without a detection: stop turning, it may be gone
FAR_AWAY = 1.0  # m: where a detection without distance (a face) is taken to be, for pointing
YIELDS_AFTER = 1.0  # s without an event: a tracker of another mode that gets one takes its place, as on the original
OVERLAP_US = 350_000  # between two arms' hand-over: the one that takes over is up before the other one goes down
ARMS = {"leftarm": "L", "rightarm": "R", "botharms": "LR", "nearestarm": "", "none": None}


class Pointing:
    """Chooses the arm that points at a place, and computes its joints."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._hand = np.array(body.robot.data["arm"]["hand"], dtype=np.float64)  # m, from the left shoulder, stretched

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


@dataclass(frozen=True)
class Detection:
    """Something that was seen, with the robot's head and camera pose at that moment."""

    us: int
    x: float  # rad, to the left of the picture's middle
    y: float  # rad, below it
    distance: float | None  # m, or None when the sensor does not tell
    yaw: float  # of the head, rad
    pitch: float
    camera: Pose  # from the robot's own joints

    def point(self) -> Vector:
        """Return the detected place in the world."""
        ray = np.array([1.0, math.tan(self.x), -math.tan(self.y)])
        ray *= (FAR_AWAY if self.distance is None else self.distance) / float(np.linalg.norm(ray))
        place: Vector = self.camera.position + self.camera.rotation @ ray
        return place


@dataclass
class Tracker:
    """One tracker stream's state."""

    stream: str
    mode: str
    arms: str | None
    parts: frozenset[str]  # what it moves: `head`, `left arm`, `right arm`, `legs`
    active: bool = False
    sensors: tuple[str, ...] = ()
    chosen: str = ""  # the arm that the value chose, for the nearest arm
    pointing: str = ""
    leaving: str = ""  # the arms that are lowered soon, as another one has taken over
    leaves_us: int = 0
    target: MotionPredictor = field(default_factory=MotionPredictor)  # of the target, in the world
    sight: MotionPredictor = field(default_factory=MotionPredictor)  # of the head that would look at it: yaw and pitch
    seen_us: int = -1
    ordered_us: int = -1


@dataclass
class Trackers:
    """All trackers of a run; the arbiter decides which of them may move what."""

    body: Body
    stance: Stance
    seen: dict[str, Detection] = field(default_factory=dict)
    _all: dict[str, Tracker] = field(default_factory=dict)
    _turning: bool = False

    def __post_init__(self) -> None:
        self.arms = Pointing(self.body)

    def add(self, stream: str, settings: Mapping[str, Value], parts: frozenset[str]) -> None:
        """Register a tracker stream, with the parts that it moves."""
        arms = ARMS.get(key(str(settings["effector"])))
        self._all[stream] = Tracker(stream, key(str(settings["mode"])), arms, parts)

    def follow(self, command: Command, us: int) -> None:
        """Let a tracker follow the newest detection of the command's sensors."""
        tracker, sensors = self._all[command.stream], command.sensors
        tracker.active, tracker.sensors, tracker.ordered_us = True, sensors, us
        tracker.chosen = _side(command.value)
        newest = max((self.seen[s] for s in sensors if s in self.seen), key=lambda d: d.us, default=None)
        if newest is not None and us - newest.us < LOST_AFTER * 1e6 and newest.us > tracker.seen_us:
            self._towards(tracker, newest)

    def pointing(self, stream: str) -> str:
        """Return the arms with which a tracker points now: `L`, `R`, `LR`, or none."""
        return self._all[stream].pointing

    def idle(self, stream: str, us: int) -> list[str]:
        """Return the streams of other active trackers that have had no event lately; an event of this one ends them."""
        others = [t for t in self._all.values() if t.stream != stream and t.active]
        return [t.stream for t in others if us - t.ordered_us > YIELDS_AFTER * 1e6]

    def stop(self, stream: str) -> None:
        """Stop a tracker: the head stays where it looks, arms are lowered, turning ends."""
        tracker = self._all.get(stream)
        if tracker is None or not tracker.active:
            return
        tracker.active = False
        if "legs" in tracker.parts:
            self._turning = False
            self.stance.turn(0.0)
        if "head" in tracker.parts:
            self.body.halt("HeadYaw")
            self.body.halt("HeadPitch")
        self._lower(tracker.pointing + tracker.leaving)
        tracker.pointing = tracker.leaving = ""

    def detected(self, detections: Mapping[str, Detection]) -> None:
        """Take new detections, by sensor stream, and let active trackers follow them."""
        self.seen.update(detections)
        for tracker in self._all.values():
            mine = next((detections[s] for s in tracker.sensors if s in detections), None)
            if tracker.active and mine is not None:
                self._towards(tracker, mine)

    def step(self, us: int) -> None:
        """Advance by one step of the physics: turn the body after the head, and lower arms that are replaced."""
        for each in self._all.values():
            if each.leaving and us >= each.leaves_us:
                self._lower(each.leaving)
                each.leaving = ""
        tracker = next((t for t in self._all.values() if t.active and t.mode == "wholebody"), None)
        if tracker is not None:
            yaw = self.body.aimed("HeadYaw")
            self._turning = abs(yaw) > (TURN_TO if self._turning else TURN_FROM)
            if us - tracker.seen_us > LOST_AFTER * 1e6:
                self._turning = False
            self.stance.turn(TURN_GAIN * yaw if self._turning else 0.0)
            if self.stance.turning:  # the head keeps looking where it looks while the body turns below it
                self._look(yaw - self.stance.turning * STEP, self.body.aimed("HeadPitch"))

    def _towards(self, tracker: Tracker, d: Detection) -> None:
        tracker.seen_us = d.us
        if "head" in tracker.parts and max(abs(d.x), abs(d.y)) > CALM:
            yaw, pitch = tracker.sight.seen(d.us, np.array([d.yaw + d.x, d.pitch + d.y]))
            self._look(float(yaw), float(pitch))
        if tracker.arms is not None:
            self._point(tracker, d)

    def _look(self, yaw: float, pitch: float) -> None:
        low, high = self.body.limits("HeadYaw")
        yaw = min(max(yaw, low), high)
        low, high = self.body.limits("HeadPitch", yaw)
        self.body.go("HeadYaw", yaw, HEAD_VELOCITY, HEAD_ACCELERATION)
        self.body.go("HeadPitch", min(max(pitch, low), high), HEAD_VELOCITY, HEAD_ACCELERATION)

    def _point(self, tracker: Tracker, d: Detection) -> None:
        target = tracker.target.seen(d.us, d.point())
        sides = tracker.arms or tracker.chosen or self.arms.nearer(target, tracker.pointing[:1])
        if tracker.pointing not in (sides, ""):
            # One arm goes up first; then the other one is lowered.
            tracker.leaving = "".join(s for s in tracker.pointing if s not in sides)
            tracker.leaves_us = d.us + OVERLAP_US
        tracker.pointing = sides
        tracker.leaving = "".join(s for s in tracker.leaving if s not in sides)
        self.stance.steady()
        for side in sides:
            for joint, angle in self.arms.joints(side, target).items():
                self.body.go(joint, angle, ARM_VELOCITY, ARM_ACCELERATION)

    def _lower(self, sides: str) -> None:
        for side in sides:
            for joint in self.body.robot.groups[key(f"{side}Arm")]:
                self.body.go(joint, self.body.start[joint], EASY)


class TrackerActuator(SimActuator, device="Tracker"):
    """Follows what the sensors that the row descends from detect."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        parts.trackers.add(spec.stream, spec.settings, self.uses)
        mode, effector = (key(str(spec.settings.get(name))) for name in ("mode", "effector"))
        self._moves_nothing = mode == "move" and effector == "none"

    def take(self, command: Command, us: int) -> None:
        """Follow the target until another command ends it."""
        if not self.parts.seeing.intersection(command.sensors):
            text = N_("{name} has nothing to follow: its row does not come from a sensor that sees something.",
                      name=self.spec.name)  # fmt: skip
            self.fail(command, text)
            return
        if self._moves_nothing:
            text = N_("{name} does not move: in the mode Move it needs an Effector, for example Nearest arm.",
                      name=self.spec.name)  # fmt: skip
            self.fail(command, text)
            return
        trackers, stream = self.parts.trackers, command.stream
        self.parts.arbiter.give_way(trackers.idle(stream, us), command.priority, us)
        job = Job(command, self.uses, trackers.follow, lambda us: trackers.stop(stream), endless=True,
                  refused=self.refused)  # fmt: skip
        self.parts.arbiter.take(job, us)


def _side(value: Value) -> str:
    """Return the arm that a value chooses: `left`, `right`, or an angle, positive to the left; else none.

    >>> _side("Left arm"), _side(-0.3), _side(True)
    ('L', 'R', '')
    """
    if isinstance(value, (Record, bool)):
        return ""
    if isinstance(value, (int, float)):
        return "L" if value >= 0 else "R"
    word = key(value) if isinstance(value, str) else ""
    return "L" if word.startswith("left") else "R" if word.startswith("right") else ""
