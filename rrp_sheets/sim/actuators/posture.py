"""Posture actuator: moves the whole body into a posture of the catalogue, by way of those between."""

from __future__ import annotations

import math
from collections.abc import Mapping

from rrp_sheets.devices.gestures import Keyframe
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.names import key
from rrp_sheets.sim.actuators.keyframed import Keyframed
from rrp_sheets.sim.keyframes import Motion

REACHED = 0.06  # rad: nearer than this a joint is where it was sent
PATIENCE_US = 3_000_000  # joints that are not there so long after the motion are blocked: given up
QUICKEST = 0.5  # s, of each part of the way
CALM = 4.0  # rad/s at full speed


class Posture(Keyframed):
    """Takes the posture of its setting, or the one that a value names."""

    def take(self, order: Command, us: int) -> None:
        """Move into the posture."""
        robot = self.parts.body.robot
        named = self.settings.get("name") or order.value
        if not isinstance(named, str):
            self.wrong(order, "the name of a posture, for example StandInit")
            return
        name = next((p for p in robot.postures if key(p) == key(named)), None)
        if name is None:
            self.unknown(order, "posture", named, robot.postures)
            return
        route = self._route(name)
        frames = [Keyframe(QUICKEST * n, self._angles(posture)) for n, posture in enumerate(route, 1)]
        speed = float(self.settings["speed"])
        motion = Motion(self.parts.body, frames, returns=False, share=speed, peak=CALM * speed)
        lean = robot.data.get("posture_leans", {}).get(name, 0.0)
        late, leaning = 0, math.nan

        def during(motion: Motion) -> None:
            nonlocal leaning
            wanted = lean if motion.passed >= len(route) - 1 else 0.0  # up from the floor first
            if wanted != leaning:
                leaning = wanted
                self.parts.stance.follow_legs(wanted)

        def arrived(us: int) -> bool | None:
            nonlocal late
            late = late or us + PATIENCE_US
            body, stance = self.parts.body, self.parts.stance
            goal = frames[-1].angles
            if stance.settled and all(abs(body.position(joint) - body.aimed(joint)) < REACHED for joint in goal):
                return True
            return None if us < late else False

        self.move(order, us, name, motion, home=False, arrived=arrived, during=during)

    def _angles(self, posture: str) -> dict[str, float]:
        return {joint: float(angle) for joint, angle in self.parts.body.robot.data["postures"][posture].items()}

    def _route(self, name: str) -> list[str]:
        """Return the postures to pass through, with the last one: as sitting down leads through crouching."""
        return route(self._now(), name, self.parts.body.robot.data.get("posture_ways", {}))

    def _now(self) -> str:
        """Return the posture that the legs are nearest to."""
        body = self.parts.body
        legs = [j.name for j in body.robot.joints.values() if j.chain in ("LLeg", "RLeg")]
        return min(
            body.robot.postures,
            key=lambda p: math.fsum((self._angles(p)[leg] - body.aimed(leg)) ** 2 for leg in legs),
        )


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
