"""Actuators that move joints to angles, and walk."""

from __future__ import annotations

import math

from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.names import key
from rrp_sheets.robots.trajectory import COUPLED
from rrp_sheets.sim.actuators.base import SimActuator, as_number
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.texts import N_

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

    def take(self, order: Command, us: int) -> None:
        """Send the joints to their angles."""
        body = self.parts.body
        named = str(self.settings["joint"] or "")
        joint = body.robot.joints.get(key(named))
        joints = (joint.name,) if joint else body.robot.groups.get(key(named), ())
        if not joints:
            self.fail(order, N_("{device}: there is no joint “{name}”.", device=self.spec.name, name=named))
            return
        values = list(order.value) if isinstance(order.value, (list, tuple)) else [order.value]
        angles = [as_number(v) for v in values]
        if len(angles) != len(joints) or any(a is None or not math.isfinite(a) for a in angles):
            many = N_("a list of {n} angles in rad ({joints})", n=len(joints), joints=", ".join(joints))
            self.wrong(order, N_("an angle in rad, for example 0.5") if len(joints) == 1 else many)
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

        self._tell_coupled(order, goals)
        moved = frozenset({*goals, *(COUPLED[name] for name in goals if name in COUPLED)})
        job = Job(order, self.uses, lambda order, us: self._move(order, goals), cease, over, joints=moved,
                  refused=self.refused)  # fmt: skip
        self.parts.arbiter.take(job, us)

    def _tell_coupled(self, order: Command, goals: dict[str, float]) -> None:
        """Give two joints that share one motor the angle that is named last, and report the change."""
        for other in [name for name in goals if name in COUPLED][1:]:
            name = COUPLED[other]
            asked, goals[name] = goals[name], goals[other]
            if asked != goals[other]:
                text = N_("{joint}: {asked:.4g} → {given:.4g} rad, as one motor moves it together with {other}.",
                          joint=name, asked=asked, given=goals[other], other=other)  # fmt: skip
                self.parts.tell(Notice("clamp", text, order.stream, order.row))

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


class Walk(SimActuator, device="Walk"):
    """Walks the way of its settings, or the one that arrives."""

    _way: Way | None = None
    _goes_on = False

    def take(self, order: Command, us: int) -> None:
        """Walk; a repeated command lets the walk continue, a different one begins from where the robot is."""
        asked = self._asked(order)
        if asked is None:
            self.wrong(order, N_("a way: (forward, left, turn) in m, m and rad, for example (0.3, 0, 0)"))
            return
        if not any(asked):
            text = N_("{name} walks nowhere: it needs Forward, Left or Turn, or a value that says so.",
                      name=self.spec.name)  # fmt: skip
            self.fail(order, text)
            return
        limits = [self.parts.body.robot.devices["walk"].settings[m.lower()] for m in MEASURES]
        way = tuple(
            self.clamp(
                order,
                N_("{device}: {measure}", device=self.spec.name, measure=m),
                a,
                (float(s.lower or 0), float(s.upper or 0)),
                unit,
            )
            for m, a, s, unit in zip(MEASURES, asked, limits, UNITS, strict=True)
        )
        self._goes_on = way == self._way and self.parts.stance.walking
        job = self._job(order, (way[0], way[1], way[2]))
        self.parts.arbiter.take(job, us)
        self._goes_on = False

    def _asked(self, order: Command) -> Way | None:
        """Return the way of the settings, or of the value when they are blank; None when that is not a way."""
        given = [as_number(self.settings.get(m.lower())) or 0.0 for m in MEASURES]
        value = order.value
        if not any(given) and isinstance(value, (list, tuple)) and len(value) in (2, 3):
            numbers = [as_number(v) for v in (*value, 0.0)[:3]]
            if any(n is None or abs(n) > 1e6 for n in numbers):
                return None
            given = [n or 0.0 for n in numbers]
        elif not any(given) and isinstance(value, (list, tuple)):
            return None
        return given[0], given[1], given[2]

    def _job(self, order: Command, way: Way) -> Job:
        stance = self.parts.stance
        blocked, looked_us = False, -LOOKS_US
        goes_on = self._goes_on

        def begin(order: Command, us: int) -> None:
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
                thing = self._in_the_way()
                if thing:
                    blocked = True
                    stance.stop_walking()
                    text = N_("{name} stops: {thing} is in the way.", name=self.spec.name, thing=thing)
                    self.parts.tell(Notice("note", text, order.stream, order.row))
            if stance.walking:
                return None
            self._way = None
            return not blocked and stance.arrived

        return Job(order, self.uses, begin, cease, over, refused=self.refused)

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
