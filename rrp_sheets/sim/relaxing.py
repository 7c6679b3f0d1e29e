"""What a behaviour that was switched off has moved goes back to the start posture, unless something else moves it."""

from __future__ import annotations

from rrp_sheets.sim.arbitration import Arbiter
from rrp_sheets.sim.body import EASY, Body
from rrp_sheets.sim.stance import Stance

RELAXED = 0.6  # of the unhurried speed
LEGS = frozenset({"LLeg", "RLeg"})


class Relaxing:
    """Brings limbs to rest.

    Args:
        body, stance: the robot.
        arbiter: knows what each actuator stream has moved, and what is in use.
    """

    def __init__(self, body: Body, stance: Stance, arbiter: Arbiter) -> None:
        self._body, self._stance, self._arbiter = body, stance, arbiter

    def relax(self, stream: str) -> None:
        """Let go of what an actuator stream has moved."""
        if self._body.fallen:
            return
        joints = self._joints(*self._arbiter.moved(stream))
        for uses, names in self._arbiter.in_use():
            joints -= self._joints(uses, names)
        legs = {j for j in joints if self._chain(j) in LEGS}
        if self._stance.stepping:  # it finishes its step and stands
            joints -= legs
        elif legs and any(abs(self._body.aimed(j) - self._body.start[j]) > 1e-6 for j in legs):
            self._stance.follow_legs(0.0)
        for joint in sorted(joints):
            self._body.go(joint, self._body.start[joint], RELAXED * EASY)

    def _joints(self, uses: frozenset[str], names: frozenset[str]) -> set[str]:
        """The joints of a command that names some, or of all that it uses."""
        chains = self._body.robot.data["chains"]
        return set(names) or {j for j in self._body.start if chains[self._chain(j)] in uses}

    def _chain(self, joint: str) -> str:
        return self._body.robot.joints[joint.lower()].chain
