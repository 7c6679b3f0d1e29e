"""Motions of joints through keyframes, for postures, gestures and talking hands."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rrp_sheets.robots.catalogue import Keyframe
from rrp_sheets.robots.trajectory import Clamped, JointPlan, Planner, moved
from rrp_sheets.sim.body import EASY, STEP, Body


class Motion:
    """Joints on their way through keyframes.

    Motions of these joints that are under way are brought to rest first. It can be stopped at any time: the joints then
    go on from where they are, with the speed that they have.

    Args:
        frames: with rising times in s.
        returns: whether the joints go back to where they were, or were being sent.
        share: of the joints' top velocity that may be used.
        peak: rad/s: no joint is faster.

    Attributes:
        going: whether it has begun and is not over.
        home: where the joints were, or were being sent, when it began.
        clamped: the angles that could not be taken; known when it begins to move.
    """

    def __init__(
        self,
        body: Body,
        frames: Sequence[Keyframe],
        *,
        returns: bool = True,
        share: float = 1.0,
        peak: float = math.inf,
    ) -> None:
        self._body = body
        self._frames = frames
        self._returns = returns
        self._share, self._peak = share, peak
        self._plan: JointPlan | None = None
        self._time = 0.0
        self.joints = moved(frames)
        self.going = False
        self.home: dict[str, float] = {}
        self.clamped: list[Clamped] = []

    def begin(self) -> None:
        """Begin the motion: from now on `step` moves the joints."""
        self.going = True
        for joint in self.joints:
            self.home[joint] = self._body.aimed(joint)
            self._body.halt(joint)

    def step(self) -> None:
        """Advance by one step of the physics."""
        plan = self._plan or self._planned()
        if plan is None:
            return
        self._time += STEP
        for joint, way in plan.ways.items():
            angle = way.at(self._time)[0]
            if joint == "HeadPitch":  # whatever comes: another row may be turning the head that this one lets nod
                low, high = self._body.limits(joint, self._yaw())
                angle = min(max(angle, low), high)
            self._body.put(joint, angle)
        self.going = self._time < plan.length

    @property
    def passed(self) -> int:
        """Number of keyframes that the motion has passed."""
        return sum(self._time >= time for time in self._plan.times) if self._plan is not None else 0

    @property
    def returning(self) -> bool:
        """True when all keyframes are over and the joints only go back to where they were."""
        return self._returns and self._plan is not None and self.passed == len(self._plan.times)

    def halt(self, *, home: bool = False) -> None:
        """Stop: the joints come to rest, or go back to where they were."""
        if not self.going:
            return
        self.going = False
        for joint in self.joints:
            if self._plan is not None:
                self._body.coast(joint, self._plan.ways[joint].at(self._time)[1])
            if home:
                self._body.go(joint, self.home[joint], EASY)

    def _planned(self) -> JointPlan | None:
        """Make the plan once the joints are at rest; None before."""
        if any(self._body.on_its_way(joint) for joint in self.joints):
            return None
        start = {joint: self._body.aimed(joint) for joint in (*self.joints, "HeadYaw")}
        planner = Planner(
            self._body.robot, start, self.home if self._returns else None, share=self._share, peak=self._peak
        )
        self._plan = planner.plan(self._frames)
        self.clamped.extend(self._plan.clamped)
        return self._plan

    def _yaw(self) -> float:
        if self._plan is not None and "HeadYaw" in self._plan.ways:
            return self._plan.ways["HeadYaw"].at(self._time)[0]
        return self._body.position("HeadYaw")


class Motions:
    """Motions that are under way."""

    def __init__(self) -> None:
        self._going: list[Motion] = []

    def begin(self, motion: Motion) -> None:
        """Begin a motion, which `step` then advances."""
        motion.begin()
        self._going.append(motion)

    def step(self) -> None:
        """Advance all motions by one step of the physics."""
        self._going = [motion for motion in self._going if motion.going]
        for motion in self._going:
            motion.step()
