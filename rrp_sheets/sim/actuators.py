"""The actuators: what each does with a value. Wrong values are told on their row, never an exception."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from rrp_sheets.model.exchange import Command, DeviceUse, Happening
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.sim.arbitration import Arbiter, Job
from rrp_sheets.sim.body import Body
from rrp_sheets.sim.colours import EXAMPLE, RGB, parse_colour
from rrp_sheets.sim.faces import Faces
from rrp_sheets.sim.stance import Stance
from rrp_sheets.sim.tracker import Trackers
from rrp_sheets.sim.voice import Voice

Tell = Callable[[Happening], None]
REACHED = 0.03  # rad: nearer than this a joint is where it was sent
PATIENCE_US = 1_000_000  # a joint that is not there so long after its motion is blocked: given up


class Eyes:
    """Both eyes: a colour and a brightness."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.colour: RGB = (1.0, 1.0, 1.0)
        self.brightness = 1.0
        self.show()

    @property
    def shining(self) -> RGB:
        """The colour as it is seen."""
        red, green, blue = (round(c * self.brightness, 4) for c in self.colour)
        return red, green, blue

    def show(self) -> None:
        """Paint the eyes."""
        self._body.shine(*self.shining)


@dataclass(frozen=True)
class Parts:
    """What actuators work with."""

    body: Body
    stance: Stance
    eyes: Eyes
    voice: Voice
    faces: Faces
    trackers: Trackers
    arbiter: Arbiter
    tell: Tell
    seeing: frozenset[str]  # the sensor streams that tell where something is


class Actuator(Protocol):
    """Carries out the orders of one actuator stream."""

    def take(self, order: Command, us: int) -> None:
        """Carry out an order, which is not blank."""
        ...

    def blank(self, order: Command, us: int) -> None:
        """End what the stream does and has waiting."""
        ...


class _Base:
    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        self.spec = spec
        self.parts = parts
        self.settings: Mapping[str, Value] = spec.settings
        self.uses = parts.body.robot.devices[key(spec.device)].resources_for(spec.settings)

    def blank(self, order: Command, us: int) -> None:
        """End what the stream does and has waiting."""
        self.parts.arbiter.stop(order.stream, us)

    def wrong(self, order: Command, needs: str) -> None:
        """Tell that a value cannot be used here."""
        self.fail(order, f"{self.spec.name} cannot use {show(order.value)}: it needs {needs}.")

    def fail(self, order: Command, text: str, kind: str = "error") -> None:
        """Tell why an order is not carried out; it is over."""
        self.parts.tell(Happening(kind, text, order.stream, order.row))
        self.parts.arbiter.at_once(order, completed=False)

    @property
    def refused(self) -> str:
        """What is told when something of a larger priority is going on."""
        return f"{self.spec.name} does nothing now: what moves the robot has a higher priority."

    def clamp(self, order: Command, what: str, value: float, limits: tuple[float, float], unit: str = "") -> float:
        """The value within its limits, telling when that changes it."""
        limited = min(max(value, limits[0]), limits[1])
        if limited != value:
            text = f"{what}: {value:.4g} → {limited:.4g}{unit}, its limit."
            self.parts.tell(Happening("clamp", text, order.stream, order.row))
        return limited


class EyeLedColor(_Base):
    """Eyes in the colour that arrives."""

    def take(self, order: Command, us: int) -> None:
        """Paint the eyes."""
        colour = parse_colour(order.value)
        if colour is None:
            self.wrong(order, f"a colour, for example {EXAMPLE}")
            return
        self.parts.eyes.colour = colour
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)


class EyeColor(_Base):
    """Eyes in the colour of the setting."""

    def take(self, order: Command, us: int) -> None:
        """Paint the eyes."""
        colour = parse_colour(self.settings.get("colour"))
        if colour is None:
            self.fail(order, f"{self.spec.name}: its setting Colour needs a colour, for example {EXAMPLE}.")
            return
        self.parts.eyes.colour = colour
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)


class EyeBrightness(_Base):
    """How bright the eyes shine."""

    def take(self, order: Command, us: int) -> None:
        """Dim or brighten the eyes."""
        number = as_number(order.value)
        if number is None:
            self.wrong(order, "a number from 0 to 1")
            return
        colour = parse_colour(self.settings.get("colour"))
        if colour is not None:
            self.parts.eyes.colour = colour
        self.parts.eyes.brightness = self.clamp(order, "Brightness", number, (0.0, 1.0))
        self.parts.eyes.show()
        self.parts.arbiter.at_once(order)


class _Say(_Base):
    def say(self, text: str, order: Command, us: int) -> None:
        """Say a text, at once or after what is being said."""
        voice, settings = self.parts.voice, self.settings
        if not text.strip():
            self.parts.arbiter.at_once(order)
            return

        def begin(order: Command, us: int) -> None:
            voice.say(text, order, settings, us)

        refused = f"“{text}” is not said: what is being said has a higher priority."
        self.parts.arbiter.take(Job(order, self.uses, begin, voice.stop, voice.over, refused=refused), us)


class SayInput(_Say):
    """Says what arrives."""

    def take(self, order: Command, us: int) -> None:
        """Say a text or a number."""
        value = order.value
        number = as_number(value)
        if isinstance(value, str):
            self.say(value, order, us)
        elif number is not None:
            self.say(f"{number:.6g}", order, us)
        else:
            self.wrong(order, "a text to say")


class SayParameter(_Say):
    """Says the text of its setting."""

    def take(self, order: Command, us: int) -> None:
        """Say it."""
        self.say(str(self.settings.get("text") or ""), order, us)


class RememberFace(_Base):
    """Remembers a new face."""

    def take(self, order: Command, us: int) -> None:
        """Remember the face of the record that arrives, else the new face in view."""
        value = order.value
        name = str(self.settings.get("name") or "")
        number = None
        if isinstance(value, str) and value.strip():
            name = value.strip()
        elif isinstance(value, Record):
            given = as_number(value.values.get("id"))
            number = int(given) if given is not None else None
        if not self.parts.faces.anyone:
            self.parts.faces.look(self.parts.body.camera())
        if not self.parts.faces.anyone:
            self.fail(order, "There is no face to remember in view.", "note")
            return
        remembered = self.parts.faces.remember(name, number)
        if remembered:
            self.parts.tell(Happening("note", f"The face is remembered as {remembered}.", order.stream, order.row))
        self.parts.arbiter.at_once(order, completed=bool(remembered))


class Track(_Base):
    """Follows what the sensors that the row descends from detect."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        parts.trackers.add(spec.stream, spec.settings, self.uses)

    def take(self, order: Command, us: int) -> None:
        """Follow until something else happens."""
        if not self.parts.seeing.intersection(order.sensors):
            self.fail(
                order,
                f"{self.spec.name} has nothing to follow: its row does not come from a sensor that sees something.",
            )
            return
        if key(str(self.settings.get("mode"))) == "move" and key(str(self.settings.get("effector"))) == "none":
            self.fail(
                order,
                f"{self.spec.name} moves nothing: in the mode Move it needs an Effector, for example Nearest arm.",
            )
            return
        trackers, stream = self.parts.trackers, order.stream
        self.parts.arbiter.give_way(trackers.idle(stream, us), order.priority, us)
        job = Job(order, self.uses, trackers.follow, lambda us: trackers.stop(stream), endless=True,
                  refused=self.refused)  # fmt: skip
        self.parts.arbiter.take(job, us)


class SetJointPosition(_Base):
    """Moves a joint or a group."""

    def take(self, order: Command, us: int) -> None:
        """Send the joints to their angles."""
        body = self.parts.body
        named = str(self.settings["joint"] or "")
        joint = body.robot.joints.get(key(named))
        joints = (joint.name,) if joint else body.robot.groups.get(key(named), ())
        if not joints:
            self.fail(order, f"{self.spec.name}: there is no joint “{named}”.")
            return
        values = list(order.value) if isinstance(order.value, (list, tuple)) else [order.value]
        angles = [as_number(v) for v in values]
        if len(angles) != len(joints) or any(a is None or not math.isfinite(a) for a in angles):
            many = f"a list of {len(joints)} angles in rad ({', '.join(joints)})"
            self.wrong(order, "an angle in rad, for example 0.5" if len(joints) == 1 else many)
            return
        goals = dict(zip(joints, (a for a in angles if a is not None), strict=True))
        late = 0  # when the joints should have been where they were sent

        def cease(us: int) -> None:
            for name in goals:
                body.halt(name)

        def over(us: int) -> bool | None:
            nonlocal late
            if any(body.on_its_way(name) for name in goals):
                late = us + PATIENCE_US
                return None
            if all(abs(body.position(name) - body.aimed(name)) < REACHED for name in goals):
                return True
            return None if us < late else False

        job = Job(order, self.uses, lambda order, us: self._move(order, goals), cease, over, joints=frozenset(goals),
                  refused=self.refused)  # fmt: skip
        self.parts.arbiter.take(job, us)

    def _move(self, order: Command, angles: dict[str, float]) -> None:
        body = self.parts.body
        share = float(self.settings["speed"])
        yaw = angles.get("HeadYaw", body.aimed("HeadYaw"))
        for name, angle in angles.items():
            joint = body.robot.joints[key(name)]
            if joint.chain in ("LLeg", "RLeg"):
                self.parts.stance.follow_legs()
            elif joint.chain != "Head":
                self.parts.stance.steady()
            limited = self.clamp(order, name, angle, body.limits(name, yaw), unit=f" {joint.unit}".rstrip())
            velocity = share * joint.max_velocity
            body.go(name, limited, velocity, 4 * velocity)
        if "HeadYaw" in angles and "HeadPitch" not in angles:
            # A head that is turned may look up and down less.
            low, high = body.limits("HeadPitch", yaw)
            pitch = body.aimed("HeadPitch")
            if not low <= pitch <= high:
                limited = self.clamp(order, "HeadPitch", pitch, (low, high), " rad")
                body.go("HeadPitch", limited, share * body.robot.joints["headpitch"].max_velocity)


class Print(_Base):
    """Shows the value in the log."""

    def take(self, order: Command, us: int) -> None:
        """Show it."""
        value = order.value
        text = value if isinstance(value, str) else show(value)
        self.parts.tell(Happening("note", text, order.stream, order.row))
        self.parts.arbiter.at_once(order)

    def blank(self, order: Command, us: int) -> None:
        """A blank is shown like any other value."""
        self.parts.tell(Happening("note", show(None), order.stream, order.row))


class Later(_Base):
    """What the simulated robot does not carry out yet: every command is over at once, not completed."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._told = False

    def take(self, order: Command, us: int) -> None:
        """Say so, once."""
        if self._told:
            self.parts.arbiter.at_once(order, completed=False)
            return
        self._told = True
        self.fail(order, f"{self.spec.name}: the simulated robot does not carry out {self.spec.device} yet.", "note")


ACTUATORS: Mapping[str, Callable[[DeviceUse, Parts], Actuator]] = {
    "EyeLedColor": EyeLedColor, "EyeColor": EyeColor, "EyeBrightness": EyeBrightness, "SayInput": SayInput,
    "SayParameter": SayParameter, "RememberFace": RememberFace, "Tracker": Track,
    "SetJointPosition": SetJointPosition, "Print": Print,
}  # fmt: skip


def make_actuator(spec: DeviceUse, parts: Parts) -> Actuator | None:
    """What carries out the orders of an actuator stream; None when the engine does."""
    if parts.body.robot.devices[key(spec.device)].engine:
        return None
    return ACTUATORS.get(spec.device, Later)(spec, parts)


def as_number(value: Value) -> float | None:
    """The value as a number, or None when it is none (TRUE and FALSE are none).

    >>> as_number(2), as_number(True), as_number("2")
    (2.0, None, None)
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return float(value)
