"""How the robot stands, sits and walks: on its own feet, or held by a guide.

Standing and looking around are physics. Moving arms and legs, turning and walking are *guided*: an invisible hand holds
the torso where the legs carry it, so that the robot never falls. It is not dynamic walking, and does not claim to be.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rrp_sheets.sim.body import EASY, STEP, Body
from rrp_sheets.sim.gait import STEP_TIME, TURN, Gait, Spot, Standing
from rrp_sheets.sim.guide import Guide
from rrp_sheets.sim.legs import JOINTS, Legs
from rrp_sheets.sim.resting import Resting

FASTEST_TURN = TURN / (2 * STEP_TIME)  # rad/s
REST_AFTER = 0.4  # s without a step before the robot stands on its own again
UPRIGHT, LOW = 0.8, 0.17  # the torso's axis upward and height (m) of a robot on its feet
NEAR = 0.03  # rad: a leg's joint that is nearer to the start posture is there


class Stance:
    """Holds the robot up.

    Attributes:
        loose: whether it was pushed and is left to physics.
    """

    def __init__(self, bullet: Any, body: Body) -> None:
        self._b = bullet
        self._body = body
        self._legs = Legs(body.robot.data["legs"])
        self._joints = [f"{side}{joint}" for side in "LR" for joint in JOINTS]
        self._guide = Guide(bullet, body)
        self._gait: Gait | None = None
        self._resting: Resting | None = None
        self._around = 0.0  # rad: the lean near which it settles
        self._steady = False
        self.loose = self._stepped = self._rested = False
        self._rate = 0.0
        self._calm = 0.0
        self._goal: Spot | None = None
        self._arrived = False
        self._way: tuple[float, float, float] | None = None  # where to walk when it stands upright
        self._standing = self._stands_now()

    @property
    def turning(self) -> float:
        """How fast the body turns now, rad/s, positive to the left."""
        return self._rate

    @property
    def walking(self) -> bool:
        """Whether it walks, or is about to."""
        return self._way is not None or (self._gait is not None and not self._gait.at_rest)

    @property
    def stepping(self) -> bool:
        """Whether it makes steps, be it the last."""
        return self._gait is not None

    @property
    def swings(self) -> str:
        """The foot in the air, `L` or `R`; empty when both are on the floor."""
        return self._gait.swings if self._gait is not None else ""

    @property
    def guided(self) -> bool:
        """Whether the guide holds it."""
        return self._guide.holds

    @property
    def upright(self) -> bool:
        """Whether the legs are as in the start posture, so that it can walk and turn."""
        body = self._body
        return all(
            abs(body.aimed(j) - body.start[j]) < NEAR and abs(body.position(j) - body.start[j]) < NEAR
            for j in self._joints
        )

    @property
    def on_feet(self) -> bool:
        """Whether it stands or crouches, upright; else it sits, lies, or is falling."""
        torso = self._body.torso()
        return not self.loose and float(torso.rotation[2, 2]) > UPRIGHT and float(torso.position[2]) > LOW

    @property
    def settled(self) -> bool:
        """Whether the torso has come to rest after the legs have moved."""
        return self._resting is None or self._resting.settled

    @property
    def middle(self) -> Spot:
        """The middle between the feet, with the torso's heading."""
        if self._gait is not None:
            return self._gait.middle
        left, right = (self._body.sole(side).position for side in "LR")
        x, y = (float(c) for c in (left + right)[:2] / 2)
        return Spot(x, y, self._heading())

    @property
    def bound(self) -> float | None:
        """Which way it walks, rad in the world; None when it does not go anywhere."""
        return self._gait.bound if self._gait is not None else None

    @property
    def arrived(self) -> bool:
        """Whether the last walk has led to its end."""
        return self._arrived

    def turn(self, rate: float) -> None:
        """Turn the whole body at a rate (rad/s) until told otherwise; 0 stops."""
        if rate and self._stand():
            self._step_out().turn(max(-FASTEST_TURN, min(FASTEST_TURN, rate)))
        elif not rate and self._gait is not None:
            self._gait.close()

    def walk(self, forward: float, left: float, turn: float) -> None:
        """Walk some way (m, m), then turn (rad), then stand; upright first, when it is not."""
        if self._gait is None and not (self.upright and self.on_feet):
            self.follow_legs(0.0)
            for joint in self._joints:
                self._body.go(joint, self._body.start[joint], EASY)
        self._way = (forward, left, turn)
        self._arrived = False

    def stop_walking(self) -> None:
        """Finish the step and stand."""
        self._way = None
        self._goal = None
        if self._gait is not None:
            self._gait.close()

    def steady(self) -> None:
        """From now on hold the torso: swinging arms would make the robot fall, as it has no balance of its own."""
        self._steady = True
        if not self.loose:
            self._guide.hold()

    def follow_legs(self, lean: float | None = None) -> None:
        """From now on the torso follows the legs' joints, whatever their posture: the robot rests on the floor.

        Args:
            lean: around which the torso settles, rad: 0 standing or sitting, −1.5 on its back, 1.5 on its belly; None
                is as before.
        """
        if self.loose:
            return
        self._guide.hold()
        self._gait, self._rate, self._way = None, 0.0, None
        guide = self._guide
        if self._resting is None:
            self._body.meet_floor(feet=False)
            self._resting = Resting(self._b, self._body, guide.place, guide.lean, guide.yaw)
        self._around = self._around if lean is None else lean
        self._resting.settle(self._around)

    def halt(self) -> None:
        """Come to rest at once, wherever the feet are."""
        self._way = None
        if self._gait is not None:
            self._gait.halt()
        if self._resting is not None:
            self._resting.halt()

    def let_go(self) -> None:
        """Leave the robot to physics: something pushes it."""
        self.loose, self._stepped, self._rested = True, self._gait is not None, self._resting is not None
        self._guide.release()
        self._gait = self._resting = self._way = None
        self._rate = 0.0
        self._body.meet_floor(feet=True, limbs=True)

    def catch(self) -> None:
        """Take hold of the robot again, after a push that has not made it fall."""
        self.loose = False
        if self._stepped or self._rested:
            self.follow_legs()
            for joint in self._joints if self._stepped else ():
                self._body.go(joint, self._body.start[joint], EASY)
            return
        self._body.meet_floor(feet=True)
        if self._steady:
            self._guide.hold()

    def step(self) -> None:
        """One step of the physics."""
        if self._way is not None and self._stand():
            way, self._way = self._way, None
            gait = self._step_out()
            self._goal = gait.here.plus(*way)
            gait.go(self._goal)
        if self._gait is not None:
            self._take_step(self._gait)
        elif self._resting is not None and (not self._resting.settled or self._legs_move()):
            self._resting.step()
            self._guide.move(self._resting.place, self._resting.lean, self._resting.yaw)

    def _stand(self) -> bool:
        """Whether it can walk now: it does, or it stands upright."""
        if self._gait is not None:
            return True
        return self.on_feet and self.settled and not self._legs_move() and self.upright

    def _legs_move(self) -> bool:
        return any(self._body.stirs(joint) for joint in self._joints)

    def _step_out(self) -> Gait:
        if self._gait is None:
            self._guide.hold()
            self._gait = Gait(self._legs, self._standing, self.middle)
            self._resting = None
            self._body.meet_floor(feet=False)
        self._calm = 0.0
        return self._gait

    def _take_step(self, gait: Gait) -> None:
        spot, place, joints = gait.step(STEP)
        self._rate = (spot.yaw - self._guide.yaw) / STEP
        for joint, angle in joints.items():
            self._body.put(joint, angle)
        self._guide.move(place, self._standing.lean, spot.yaw)
        if gait.beside and self._goal is not None:
            self._arrived, self._goal = gait.at(self._goal), None
        self._calm = self._calm + STEP if gait.beside else 0.0
        if self._calm >= REST_AFTER:
            self._gait, self._rate = None, 0.0
            self._body.meet_floor(feet=True)
            if not self._steady:
                self._guide.release()

    def _stands_now(self) -> Standing:
        """How it stands in its start posture, which it has now."""
        middle, torso = self.middle, self._body.torso().position
        _, lean, _ = self._body.tilt()
        ahead, left, _ = middle.seen(Spot(float(torso[0]), float(torso[1]), 0.0))
        ankles = {}
        for side in "LR":
            at = self._body.link(f"{side.lower()}_ankle").position
            x, y, _ = middle.seen(Spot(float(at[0]), float(at[1]), 0.0))
            ankles[side] = np.array([x, y, float(at[2])])
        return Standing(np.array([ahead, left, float(torso[2])]), lean, ankles)

    def _heading(self) -> float:
        return self._guide.yaw if self._guide.holds else self._body.tilt()[2]
