"""Postures: the whole body goes to where the catalogue says."""

from __future__ import annotations

from rrp_sheets.devices.gestures import Keyframe
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.names import key
from rrp_sheets.sim.actuators.keyframed import Keyframed
from rrp_sheets.sim.keyframes import Motion

REACHED = 0.05  # rad: nearer than this a joint is where it was sent
PATIENCE_US = 1_500_000  # joints that are not there so long after the motion are blocked: given up
QUICKEST = 0.5  # s
CALM = 4.0  # rad/s at full speed


class Posture(Keyframed):
    """Takes the posture of its setting, or the one that a value names."""

    def take(self, order: Command, us: int) -> None:
        """Take it."""
        robot = self.parts.body.robot
        named = self.settings.get("name") or order.value
        if not isinstance(named, str):
            self.wrong(order, "the name of a posture, for example StandInit")
            return
        name = next((p for p in robot.postures if key(p) == key(named)), None)
        if name is None:
            self.unknown(order, "posture", named, robot.postures)
            return
        goal = {joint: float(angle) for joint, angle in robot.data["postures"][name].items()}
        speed = float(self.settings["speed"])
        motion = Motion(self.parts.body, (Keyframe(QUICKEST, goal),), returns=False, share=speed, calm=CALM * speed)
        late = 0

        def arrived(us: int) -> bool | None:
            nonlocal late
            late = late or us + PATIENCE_US
            body = self.parts.body
            if all(abs(body.position(joint) - body.aimed(joint)) < REACHED for joint in goal):
                return True
            return None if us < late else False

        self.move(order, us, name, motion, home=False, arrived=arrived)
