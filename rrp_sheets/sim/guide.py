"""The guide: holds the robot's torso at a place in the world, as an invisible hand would."""

from __future__ import annotations

from typing import Any

import numpy as np

from rrp_sheets.sim.body import Body, Vector

FORCE = 400.0  # N; holds the robot's weight (53 N) without letting it sway
LEAD = 4.0  # steps of the physics: the constraint is behind by so much, and therefore sent ahead


class Guide:
    """A constraint between the torso and the world; it acts from the first call of `hold` on.

    Attributes:
        place: of the torso's frame, m.
        lean, yaw: of the torso, rad.
    """

    def __init__(self, bullet: Any, body: Body) -> None:
        self._b = bullet
        self._body = body
        self._constraint: int | None = None
        self.place: Vector = np.zeros(3)
        self.lean = self.yaw = 0.0

    @property
    def holds(self) -> bool:
        """Whether it acts."""
        return self._constraint is not None

    def hold(self) -> None:
        """Hold the torso where it is."""
        if self._constraint is not None:
            return
        torso = self._body.torso()
        _, self.lean, self.yaw = self._body.tilt()
        self.place = torso.position
        centre = self._b.getDynamicsInfo(self._body.id, -1)[3]
        self._constraint = self._b.createConstraint(
            self._body.id, -1, -1, -1, self._b.JOINT_FIXED, [0, 0, 0], [-c for c in centre], torso.position.tolist(),
            [0, 0, 0, 1], self._b.getQuaternionFromEuler([0, self.lean, self.yaw]),
        )  # fmt: skip
        self.move(self.place, self.lean, self.yaw)

    def move(self, place: Vector, lean: float, yaw: float) -> None:
        """Hold the torso at a place (m), leaning forward and turned to the left (rad); called once for each step."""
        ahead = place + LEAD * (place - self.place)
        turned = self._b.getQuaternionFromEuler([0, lean + LEAD * (lean - self.lean), yaw + LEAD * (yaw - self.yaw)])
        self.place, self.lean, self.yaw = place, lean, yaw
        self._b.changeConstraint(
            self._constraint, jointChildPivot=ahead.tolist(), maxForce=FORCE, jointChildFrameOrientation=turned
        )

    def release(self) -> None:
        """Let go."""
        if self._constraint is not None:
            self._b.removeConstraint(self._constraint)
            self._constraint = None
