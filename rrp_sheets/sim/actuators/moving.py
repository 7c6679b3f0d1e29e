"""Actuators that move the robot: joints to angles, walking, and postures and gestures through keyframes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rrp_sheets.model import japanese
from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import Record, show
from rrp_sheets.perception.pinhole import Vector
from rrp_sheets.robots.catalogue import Keyframe
from rrp_sheets.robots.trajectory import CALM, COUPLED, posture_frames
from rrp_sheets.sim.actuators.base import SimActuator, as_number
from rrp_sheets.sim.actuators.tracker import Detection, Pointing
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.body import Motion
from rrp_sheets.texts import N_, sentences

REACHED = 0.03  # rad: nearer than this a joint is where it was sent
PATIENCE_US = 1_000_000  # a joint that is not there so long after its motion is blocked: given up
MEASURES = ("Forward", "Left", "Turn")
UNITS = (" m", " m", " rad")
HEIGHTS = (0.05, 0.2, 0.35, 0.5)  # m: where it looks for things in its way
CLEAR = 0.17  # m, from the robot's middle: what comes nearer is in its way
AHEAD = 0.06  # m: where the robot will be a moment later
LOOKS_US = 50_000  # between two looks at what is in the way
Way = tuple[float, float, float]


class SetJointPosition(SimActuator, device="SetJointPosition"):
    """Moves a joint or a group."""

    def take(self, command: Command, us: int) -> None:
        """Send the joints to their angles."""
        body = self.parts.body
        named = str(self.settings["joint"] or "")
        joint = body.robot.joints.get(key(named))
        joints = (joint.name,) if joint else body.robot.groups.get(key(named), ())
        if not joints:
            self.fail(command, N_("{device}: there is no joint “{name}”.", device=self.spec.name, name=named))
            return
        values = list(command.value) if isinstance(command.value, (list, tuple)) else [command.value]
        angles = [as_number(v) for v in values]
        if len(angles) != len(joints) or None in angles:
            many = N_("a list of {n} angles in rad ({joints})", n=len(joints), joints=", ".join(joints))
            self.wrong(command, N_("an angle in rad, for example 0.5") if len(joints) == 1 else many)
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

        self._tell_coupled(command, goals)
        moved = frozenset({*goals, *(COUPLED[name] for name in goals if name in COUPLED)})
        job = Job(command, self.uses, lambda command, us: self._move(command, goals), cease, over, joints=moved,
                  refused=self.refused)  # fmt: skip
        self.parts.arbiter.take(job, us)

    def _tell_coupled(self, command: Command, goals: dict[str, float]) -> None:
        """Give two joints that share one motor the angle that is named last, and report the change."""
        for other in [name for name in goals if name in COUPLED][1:]:
            name = COUPLED[other]
            asked, goals[name] = goals[name], goals[other]
            if asked != goals[other]:
                text = N_("{joint}: {asked:.4g} → {given:.4g} rad, as one motor moves it together with {other}.",
                          joint=name, asked=asked, given=goals[other], other=other)  # fmt: skip
                self.parts.tell(Notice("clamp", text, command.stream, command.row))

    def _move(self, command: Command, angles: dict[str, float]) -> None:
        body = self.parts.body
        share = float(self.settings["speed"])
        yaw = angles.get("HeadYaw", body.aimed("HeadYaw"))
        for name, angle in angles.items():
            joint = body.robot.joints[key(name)]
            if joint.chain in ("LLeg", "RLeg"):
                self.parts.stance.follow_legs()
            elif joint.chain != "Head":
                self.parts.stance.steady()
            limited = self.clamp(command, name, angle, body.limits(name, yaw), unit=f" {joint.unit}".rstrip())
            velocity = share * joint.max_velocity
            body.go(name, limited, velocity, 4 * velocity)
        if "HeadYaw" in angles and "HeadPitch" not in angles:
            # A head that is turned may look up and down less.
            low, high = body.limits("HeadPitch", yaw)
            pitch = body.aimed("HeadPitch")
            if not low <= pitch <= high:
                limited = self.clamp(command, "HeadPitch", pitch, (low, high), " rad")
                body.go("HeadPitch", limited, share * body.robot.joints["headpitch"].max_velocity)


class Walk(SimActuator, device="Walk"):
    """Walks the way of its settings, or the one that arrives."""

    _way: Way | None = None
    _goes_on = False

    def take(self, command: Command, us: int) -> None:
        """Walk; a repeated command lets the walk continue, a different one begins from where the robot is."""
        asked = self._asked(command)
        if asked is None:
            self.wrong(command, N_("a way: (forward, left, turn) in m, m and rad, for example (0.3, 0, 0)"))
            return
        if not any(asked):
            text = N_("{name} does not walk: it needs Forward, Left or Turn, or a value for them.",
                      name=self.spec.name)  # fmt: skip
            self.fail(command, text)
            return
        way = self._limited(command, asked)
        self._goes_on = way == self._way and self.parts.stance.walking
        self.parts.arbiter.take(self._job(command, way), us)
        self._goes_on = False

    def _limited(self, command: Command, asked: Way) -> Way:
        limited = []
        for measure, value, unit in zip(MEASURES, asked, UNITS, strict=True):
            setting = self.parts.body.robot.devices["walk"].settings[measure.lower()]
            what = N_("{device}: {measure}", device=self.spec.name, measure=measure)
            limits = (float(setting.lower or 0), float(setting.upper or 0))
            limited.append(self.clamp(command, what, value, limits, unit))
        return limited[0], limited[1], limited[2]

    def _asked(self, command: Command) -> Way | None:
        """Return the way of the settings, or of the value when they are blank; None when that is not a way."""
        given = [as_number(self.settings.get(m.lower())) or 0.0 for m in MEASURES]
        value = command.value
        if not any(given) and isinstance(value, (list, tuple)):
            numbers = [as_number(v) for v in (*value, 0.0)[:3]]
            if len(value) not in (2, 3) or any(n is None or abs(n) > 1e6 for n in numbers):
                return None
            given = [n or 0.0 for n in numbers]
        return given[0], given[1], given[2]

    def _job(self, command: Command, way: Way) -> Job:
        stance = self.parts.stance
        blocked, looked_us = False, -LOOKS_US
        goes_on = self._goes_on

        def begin(command: Command, us: int) -> None:
            if not goes_on:
                stance.walk(*way)
            self._way = way

        def cease(us: int) -> None:
            if not self._goes_on:
                stance.stop_walking()
                self._way = None

        def over(us: int) -> bool | None:
            nonlocal blocked, looked_us
            if not blocked and us >= looked_us + LOOKS_US:
                looked_us = us
                if thing := self._in_the_way():
                    blocked = True
                    stance.stop_walking()
                    text = N_("{name} stops: {thing} is in the way.", name=self.spec.name, thing=thing)
                    self.parts.tell(Notice("note", text, command.stream, command.row))
            if stance.walking:
                return None
            self._way = None
            return not blocked and stance.arrived

        return Job(command, self.uses, begin, cease, over, refused=self.refused)

    def _in_the_way(self) -> str:
        """Return the name of the thing that the robot would walk into, or an empty text."""
        heading = self.parts.stance.bound
        if heading is None:
            return ""
        here = self.parts.body.torso().position
        there = (here[0] + AHEAD * math.cos(heading), here[1] + AHEAD * math.sin(heading))
        near, thing = self.parts.stage.nearest([(*there, z) for z in HEIGHTS])
        if near >= CLEAR:
            return ""
        now, _ = self.parts.stage.nearest([(float(here[0]), float(here[1]), z) for z in HEIGHTS])
        return thing if near < now or near == 0.0 else ""


RAISED, HELD = 0.8, 1.9  # s: when an arm points, and until when
KEYFRAMES_REACHED = 0.06  # rad: nearer than this a joint is where it was sent
KEYFRAMES_PATIENCE_US = 3_000_000  # joints that are not there so long after the motion are blocked: given up


class Keyframed(SimActuator):
    """An actuator that makes one motion after the other.

    A command that repeats the present motion lets it go on, so that a stream that repeats itself does not keep it at
    its beginning; the earlier command has then ended, not completed. Once the joints only go back to where they were, a
    command begins a motion of its own.
    """

    _motion: Motion | None = None
    _doing = _next = ""

    def move(
        self, command: Command, us: int, what: str, motion: Motion, *, home: bool,
        arrived: Callable[[int], bool | None] = lambda us: True,
        during: Callable[[Motion], None] = lambda motion: None,
    ) -> None:  # fmt: skip
        """Make a motion; by its name, `what`, a repeated command is recognised.

        When it is broken off, the joints stay or go back `home`. `during` is called at every step, and after the end
        of the motion `arrived`, until it returns whether the command was completed.
        """

        def begin(command: Command, us: int) -> None:
            if self._goes_on(what):
                return
            self._motion, self._doing = motion, what
            self._hold(motion)
            self.parts.motions.begin(motion)

        def cease(us: int) -> None:
            if self._motion is not None and self._next != what:
                self._motion.halt(home=home)
                self._motion = None

        def over(us: int) -> bool | None:
            going = self._motion
            self._tell_clamped(command, going)
            if going is None or not going.going:
                return arrived(us)
            during(going)
            return None

        self._next = what if self._goes_on(what) else ""
        joints = self.parts.body.robot.joints
        chains = self.parts.body.robot.data["chains"]
        uses = frozenset(chains[joints[key(j)].chain] for j in motion.joints)
        job = Job(command, uses, begin, cease, over, joints=frozenset(motion.joints), refused=self.refused)
        self.parts.arbiter.take(job, us)
        self._next = ""

    def _goes_on(self, what: str) -> bool:
        motion = self._motion
        return motion is not None and motion.going and not motion.returning and self._doing == what

    def _hold(self, motion: Motion) -> None:
        """Have the torso held while arms or legs move, as the robot does not balance by itself."""
        chains = {self.parts.body.robot.joints[key(j)].chain for j in motion.joints}
        if chains & {"LLeg", "RLeg"}:
            self.parts.stance.follow_legs()
        elif chains - {"Head"}:
            self.parts.stance.steady()

    def _tell_clamped(self, command: Command, motion: Motion | None) -> None:
        while motion is not None and motion.clamped:
            c = motion.clamped.pop(0)
            text = N_("{joint}: {wanted:.4g} → {given:.4g} rad, its limit there.", joint=c.joint, wanted=c.wanted,
                      given=c.given)  # fmt: skip
            self.parts.tell(Notice("clamp", text, command.stream, command.row))

    def unknown(self, command: Command, template: str, name: str, names: Sequence[str]) -> None:
        """Report that no posture or gesture has a name, with the names that may be meant."""
        said = N_(template, device=self.spec.name, name=show(name[:60]))
        self.fail(command, sentences(said, proposal(name, names)))


def proposal(name: str, names: Sequence[str]) -> str:
    """Return a sentence that proposes the name nearest to an unknown one, or lists all names.

    >>> proposal("Wve", ["Nod", "Wave"]), proposal("Zzz", ["Nod", "Wave"])
    ('Did you mean Wave?', 'There are: Nod, Wave.')
    >>> proposal("手をふる", ["Nod", "Wave"])
    'Did you mean 手を振る?'
    """
    if japanese.LETTERS.search(name):
        names = japanese.japanese(japanese.MOVES, names)
    guess = nearest(name, names)
    return N_("Did you mean {guess}?", guess=guess) if guess else N_("There are: {names}.", names=", ".join(names))


class GestureActuator(Keyframed, device="Gesture"):
    """Makes the gesture of its setting, the one that a value names, or points at what was detected."""

    def take(self, command: Command, us: int) -> None:
        """Make the gesture, or point."""
        named, motions = self.settings.get("name") or command.value, self.parts.body.robot.motions
        if isinstance(named, Record) and {"x", "y"} <= set(named.values):
            self._point(command, us, named)
            return
        if not isinstance(named, str):
            self.wrong(command, N_("the name of a gesture, for example Wave, or something detected to point at"))
            return
        gesture = motions.get(key(named))
        if gesture is None:
            self.unknown(command, N_("{device}: there is no gesture {name}."), named, self.parts.body.robot.gestures)
            return
        tempo, times = as_number(self.settings.get("tempo")), as_number(self.settings.get("times"))
        frames = gesture.timed(tempo, max(1, round(times or 1)))
        self.move(command, us, key(gesture.name), Motion(self.parts.body, frames), home=True)

    def _point(self, command: Command, us: int, seen: Record) -> None:
        place = self._place(command, seen)
        pointing = Pointing(self.parts.body)
        side = pointing.nearer(place, "")
        pose = pointing.joints(side, place)
        frames = (Keyframe(RAISED, pose), Keyframe(HELD, pose))
        self.move(command, us, f"point {side}", Motion(self.parts.body, frames), home=True)

    def _place(self, command: Command, seen: Record) -> Vector:
        """Return where the seen thing is, from the camera's pose of its detection if that is known, else from now."""
        x, y = (as_number(seen.values[axis]) or 0.0 for axis in "xy")
        known = [self.parts.trackers.seen[s] for s in command.sensors if s in self.parts.trackers.seen]
        like = next((d for d in sorted(known, key=lambda d: -d.us) if (d.x, d.y) == (x, y)), None)
        camera = like.camera if like is not None else self.parts.body.camera()
        x, y = (min(max(angle, -1.4), 1.4) for angle in (x, y))
        return Detection(0, x, y, as_number(seen.values.get("distance")), 0.0, 0.0, camera).point()


class Posture(Keyframed, device="Posture"):
    """Takes the posture of its setting, or the one that a value names."""

    def take(self, command: Command, us: int) -> None:
        """Move into the posture."""
        robot = self.parts.body.robot
        named = self.settings.get("name") or command.value
        if not isinstance(named, str):
            self.wrong(command, N_("the name of a posture, for example StandInit"))
            return
        name = next((p for p in robot.postures if key(p) == key(named)), None)
        if name is None:
            self.unknown(command, N_("{device}: there is no posture {name}."), named, robot.postures)
            return
        frames = posture_frames(robot, self._now(), name)
        speed = float(self.settings["speed"])
        motion = Motion(self.parts.body, frames, returns=False, share=speed, peak=CALM * speed)
        lean = robot.data.get("posture_leans", {}).get(name, 0.0)
        late, leaning = 0, math.nan

        def during(motion: Motion) -> None:
            nonlocal leaning
            wanted = lean if motion.passed >= len(frames) - 1 else 0.0  # up from the floor first
            if wanted != leaning:
                leaning = wanted
                self.parts.stance.follow_legs(wanted)

        def arrived(us: int) -> bool | None:
            nonlocal late
            late = late or us + KEYFRAMES_PATIENCE_US
            body, goal = self.parts.body, frames[-1].angles
            near = (abs(body.position(joint) - body.aimed(joint)) < KEYFRAMES_REACHED for joint in goal)
            if self.parts.stance.settled and all(near):
                return True
            return None if us < late else False

        self.move(command, us, name, motion, home=False, arrived=arrived, during=during)

    def _angles(self, posture: str) -> dict[str, float]:
        return {joint: float(angle) for joint, angle in self.parts.body.robot.data["postures"][posture].items()}

    def _now(self) -> str:
        """Return the posture that the legs are nearest to."""
        body = self.parts.body
        legs = [j.name for j in body.robot.joints.values() if j.chain in ("LLeg", "RLeg")]
        return min(
            body.robot.postures, key=lambda p: math.fsum((self._angles(p)[leg] - body.aimed(leg)) ** 2 for leg in legs)
        )
