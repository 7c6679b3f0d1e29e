"""Sensors of the simulated robot: sonar, camera, faces, joints, torso, buttons, touch, words; and their rates."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from rrp_sheets.model.exchange import DeviceUse, Notice, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.perception.faces import Faces
from rrp_sheets.perception.pinhole import Pixels, Pose, Vector
from rrp_sheets.perception.vision import Detector, Spot
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.sim.appearance import parse_colour
from rrp_sheets.sim.body import STEPS_A_SECOND, Body
from rrp_sheets.sim.camera import Eye
from rrp_sheets.sim.stage import Stage
from rrp_sheets.sim.talk import Hearing
from rrp_sheets.texts import N_

NEAREST, FARTHEST = 0.2, 2.5  # m
APART = math.radians(2.5)  # between neighbouring rays
SIDES = ("left", "right")
DEGREE = 0.0175  # rad: a torso that turns less has not turned
STILL = 2.5e-4  # rad: a joint that moves less has not moved (the physics trembles less than that when standing)


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
    """One side of the sonar; `beam` is its place, as the catalogue has it."""

    def __init__(self, body: Body, beam: dict[str, Any]) -> None:
        self._body = body
        self._beam = beam
        self._rays = cone(math.radians(float(beam["cone"])))

    def pose(self) -> Pose:
        """Return the beam's place and orientation; it measures along its x."""
        torso = self._body.torso()
        turned = _rotation(*(float(a) for a in self._beam["rpy"]))
        return Pose(torso.position + torso.rotation @ np.array(self._beam["xyz"]), torso.rotation @ turned)

    def measure(self, stage: Stage) -> float:
        """Return the distance of the nearest thing in the cone, m; `FARTHEST` when nothing is there."""
        pose = self.pose()
        solids = [s for s in stage.solids() if s.distance(pose.position) < FARTHEST]
        rays = self._rays @ pose.rotation.T
        nearest = min((float(s.hits(pose.position, rays).min()) for s in solids), default=FARTHEST)
        return min(max(nearest, NEAREST), FARTHEST)


def _rotation(roll: float, pitch: float, yaw: float) -> Vector:
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])  # fmt: skip


class Sight:
    """Present view of the head camera. One picture serves all sensors of the same instant."""

    def __init__(self, eye: Eye, fine: Eye, body: Body, stage: Stage) -> None:
        self._eye, self._fine, self._body, self._stage = eye, fine, body, stage
        self.us = -1
        self.picture: Pixels | None = None
        self._pose: Pose | None = None
        self._detector: Detector | None = None
        self._latest: tuple[int, Pixels] | None = None

    def pose(self) -> Pose:
        """Return the pose of the camera; from the first call in an instant on, the picture before it is gone."""
        if self.us != self._stage.us or self._pose is None:
            self.us = self._stage.us
            self.picture, self._detector, self._pose = None, None, self._body.camera()
        return self._pose

    def look(self) -> Pixels:
        """Return the picture of this instant."""
        pose = self.pose()  # first: it discards the picture of another instant
        if self.picture is None:
            self._stage.place()
            self.picture = self._eye.look(pose, self._stage.light)
            self._latest = self.us, self.picture
        return self.picture

    def look_closely(self) -> Pixels:
        """Take a finer picture, for faces."""
        self._stage.place()
        return self._fine.look(self.pose(), self._stage.light)

    def recent(self, stale_us: int) -> Pixels:
        """Return the newest picture if it is not older than `stale_us`, else a new one: for displays and records."""
        if self._latest is not None and self._stage.us - self._latest[0] <= stale_us:
            return self._latest[1]
        return self.look()

    def forget(self) -> None:
        """Discard the picture, as something was moved while the world stood still."""
        self.us, self._latest = -1, None

    def detector(self) -> Detector:
        """Return the detector for the picture of this instant."""
        picture = self.look()
        if self._detector is None:
            self._detector = Detector(picture, self._eye.lens)
        return self._detector


@dataclass(frozen=True)
class Senses:
    """Parts of the simulated world that sensors use."""

    body: Body
    sight: Sight
    faces: Faces
    signals: Signals
    hearing: Hearing
    stage: Stage


class SimSensor(ABC):
    """Gives the values of one sensor stream.

    A subclass names the devices of the catalogue that it is for: `class Sonar(SimSensor, devices=("Sonar",))`.
    """

    locates = False  # whether its values tell where something is, so that a tracker can follow it

    def __init_subclass__(cls, devices: Sequence[str]) -> None:
        SENSORS.update(dict.fromkeys(devices, cls))

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        self.spec, self.senses = spec, senses

    @abstractmethod
    def read(self) -> list[Value]:
        """Return the present values; records as mappings of their fields."""


SENSORS: dict[str, type[SimSensor]] = {}
"""The class for each device."""


class Sonar(SimSensor, devices=("Sonar",)):
    """Distances by rays: of one side, or the nearer of both."""

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        super().__init__(spec, senses)
        side = str(spec.settings.get("side") or "").casefold()
        beams = senses.body.robot.data["sonar"]
        self._beams = [Beam(senses.body, beams[name]) for name in SIDES if side in ("", name)]

    def read(self) -> list[Value]:
        """Measure the distance."""
        return [{"distance": min(beam.measure(self.senses.stage) for beam in self._beams)}]


class BallSensor(SimSensor, devices=("RedBall", "GreenBall", "BlueBall", "Ball")):
    """A ball of a colour, or the largest of any colour."""

    locates = True

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        super().__init__(spec, senses)
        self._colour = senses.body.robot.devices[key(spec.device)].colour

    def read(self) -> list[Value]:
        """The ball, if one is in the picture."""
        detector = self.senses.sight.detector()
        if self._colour == "any":
            found = detector.any_ball()
        else:
            spot = detector.ball(self._colour)
            found = (self._colour, spot) if spot else None
        if found is None:
            return []
        colour, ball = found
        return [{**_angles(ball), "distance": ball.distance, "colour": colour}]


class Blob(SimSensor, devices=("Blob",)):
    """The largest spot of a colour."""

    locates = True

    def read(self) -> list[Value]:
        """The spot, if there is one."""
        settings = self.spec.settings
        colour = parse_colour(settings["colour"])
        spot = self.senses.sight.detector().spot(colour, float(settings["threshold"])) if colour else None
        return [{**_angles(spot), "area": spot.area}] if spot else []


class Face(SimSensor, devices=("FaceDetection",)):
    """Faces in the picture."""

    locates = True

    def read(self) -> list[Value]:
        """Every face that is found."""
        return list(self.senses.faces.see())


class JointPosition(SimSensor, devices=("JointPosition",)):
    """A joint's position, when it has changed."""

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        super().__init__(spec, senses)
        joint = senses.body.robot.joints.get(key(str(spec.settings["joint"])))
        self._joint = joint.name if joint else ""
        self._last: float | None = None

    def read(self) -> list[Value]:
        """The position in rad, or nothing when it is the same as before."""
        if not self._joint:
            return []
        position = self.senses.body.position(self._joint)
        if self._last is not None and abs(position - self._last) < STILL:
            return []
        self._last = position
        return [round(position, 4) + 0.0]


class Orientation(SimSensor, devices=("Orientation",)):
    """Roll, pitch and yaw of the torso, when they have changed."""

    _last: tuple[float, float, float, bool] | None = None

    def read(self) -> list[Value]:
        """The angles in rad, or nothing when they are much the same as before."""
        body = self.senses.body
        roll, pitch, yaw = body.tilt()
        now = (roll, pitch, yaw, body.fallen)
        last = self._last
        if last and last[3] == now[3] and all(abs(a - b) < DEGREE for a, b in zip(now[:3], last[:3], strict=True)):
            return []
        self._last = now
        return [{"roll": roll, "pitch": pitch, "yaw": yaw, "fallen": now[3]}]


class Button(SimSensor, devices=("OperatorButton",)):
    """An operator's button, which the scene presses."""

    _count = 0

    def read(self) -> list[Value]:
        """One value for each press of this step."""
        label, values = str(self.spec.settings.get("label") or self.spec.name), list[Value]()
        for pressed in self.senses.signals.presses:
            if key(pressed) == key(label):
                self._count += 1
                self.senses.signals.noticed("press", pressed)
                values.append({"label": label, "count": self._count})
        return values


class Touched(SimSensor, devices=("Touch", "Bumper", "ChestButton")):
    """Touches of some zones: all, the feet, the chest, or one of them."""

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        super().__init__(spec, senses)
        zone, side = spec.settings.get("zone"), spec.settings.get("side")
        zones = senses.body.robot.touch_zones
        if spec.device == "Bumper":
            zones = (f"{side} foot",) if side else ("Left foot", "Right foot")
        elif spec.device == "ChestButton":
            zones = ("Chest",)
        self._zones = frozenset((str(zone),) if zone else zones)

    def read(self) -> list[Value]:
        """The touches that begin or end now."""
        values = list[Value]()
        for zone, pressed in self.senses.signals.touches:
            if zone in self._zones:
                self.senses.signals.noticed("touch", zone)
                values.append({"pressed": pressed, "zone": zone})
        return values


class WordSensor(SimSensor, devices=("WordRecognized",)):
    """Words that are recognised in what people have just said."""

    def __init__(self, spec: DeviceUse, senses: Senses) -> None:
        super().__init__(spec, senses)
        self._listener = senses.hearing.listen(spec.stream, tuple(spec.settings.get("words") or ()))

    def read(self) -> list[Value]:
        """Return the words in the utterances that have just ended."""
        found = self.senses.hearing.words(self._listener) if self._listener is not None else []
        return [{"word": word, "confidence": sure} for word, sure in found]


class SamplingClock:
    """Times at which a sensor is read: every 1/rate s, at the physics' step then or next after; else every step."""

    def __init__(self, spec: DeviceUse) -> None:
        self._rate = float(spec.settings.get("rate") or STEPS_A_SECOND)
        self._next = 0

    def due(self, step: int) -> bool:
        """Return whether to read at this step; must be called at every step."""
        if step * self._rate < self._next * STEPS_A_SECOND - 1e-6:
            return False
        self._next += 1
        return True


def tidy(value: Value) -> Value:
    """Round measured numbers to millionths, so that traces of two runs are the same to the byte."""
    if isinstance(value, float):
        return round(float(value), 6) + 0.0  # no minus zero, no numpy number
    if isinstance(value, dict):
        return {name: tidy(v) for name, v in value.items()}
    return value


def _angles(spot: Spot) -> dict[str, Value]:
    return {"x": spot.x, "y": spot.y, "width": spot.width, "height": spot.height}


TOUCH_US = 500_000  # a touch lasts so long, unless the scene gives another time
_UNNOTICED = {
    "press": N_("{thing} presses {what}: no sensor of this workbook notices it."),
    "touch": N_("{thing} touches {what}: no sensor of this workbook notices it."),
}


class Signals:
    """Presses and touches by people at the present step, on the robot and the run panel, as the scene gives them.

    They are known, not perceived: the catalogue marks the sensors that are fed from here.
    """

    def __init__(self, robot: Robot) -> None:
        self._zones = {key(zone): zone for zone in robot.touch_zones}
        self._until: dict[str, int] = {}  # when each zone that is touched is let go
        self._resting: frozenset[str] = frozenset()  # zones that something rests against
        self._open: list[tuple[SceneAction, str, str]] = []  # what nothing has noticed yet, and what it says
        self.presses: list[str] = []  # the buttons' labels
        self.touches: list[tuple[str, bool]] = []  # the zones, and whether the touch begins (else it ends)

    def begin(self, us: int) -> None:
        """Begin a new step: clear presses and touches, and end touches whose time is over."""
        self.presses, self.touches = [], []
        for zone, until in list(self._until.items()):
            if until <= us:
                del self._until[zone]
                if zone not in self._resting:
                    self.touches.append((zone, False))

    def contact(self, zones: frozenset[str]) -> None:
        """Set the zones that things rest against now, in place of earlier ones."""
        for zone in sorted(zones ^ self._resting):
            if zone not in self._until:  # somebody touches it already, or still
                self.touches.append((zone, zone in zones))
        self._resting = zones

    def act(self, action: SceneAction) -> None:
        """Take a press or a touch from the scene."""
        verb, what = action.verb, str(next(iter(action.values.values()), ""))
        if verb == "press":
            self.presses.append(what)
        elif verb == "touch":
            what = self._zones.get(key(what), what)
            seconds = action.values.get("seconds")
            until = action.time_us + (TOUCH_US if seconds is None else round(float(seconds) * 1e6))
            if what in self._until:  # one that is touched is only touched longer, or let go at once
                self._until[what] = until if seconds == 0 else max(self._until[what], until)
                return
            if what not in self._resting:
                self.touches.append((what, True))
            self._until[what] = until
        self._open.append((action, verb, what))

    def noticed(self, verb: str, what: str) -> None:
        """Mark a press or a touch as noticed by a sensor."""
        self._open = [(a, v, w) for a, v, w in self._open if (v, w) != (verb, what)]

    def unnoticed(self) -> list[Notice]:
        """Return notes on presses and touches that no sensor has noticed, once."""
        notes = []
        for action, verb, what in self._open:
            if verb in _UNNOTICED:
                text = N_(_UNNOTICED[verb], thing=action.thing, what=what)
                notes.append(Notice("note", text, row=f"Scene!{action.row}" if action.row else ""))
        self._open.clear()
        return notes
