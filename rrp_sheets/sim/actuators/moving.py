"""Actuators that follow what sensors detect, and that move joints to angles."""

from __future__ import annotations

import math

from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.names import key
from rrp_sheets.sim.actuators.base import Base, Parts, as_number
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.body import COUPLED

REACHED = 0.03  # rad: nearer than this a joint is where it was sent
PATIENCE_US = 1_000_000  # a joint that is not there so long after its motion is blocked: given up


class Track(Base):
    """Follows what the sensors that the row descends from detect."""

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        parts.trackers.add(spec.stream, spec.settings, self.uses)

    def take(self, order: Command, us: int) -> None:
        """Follow the target until another command ends it."""
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


class SetJointPosition(Base):
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
                text = f"{name}: {asked:.4g} → {goals[other]:.4g} rad, as one motor moves it together with {other}."
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
