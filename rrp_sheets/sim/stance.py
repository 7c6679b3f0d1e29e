"""Standing, sitting and walking of the robot: on its own feet, or held by a guide.

Standing and looking around are physics. Moving arms and legs, turning and walking are *guided*: a constraint holds the
torso where the legs carry it, so that the robot never falls. It is not dynamic walking, and does not claim to be.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rrp_sheets.perception.pinhole import Vector
from rrp_sheets.sim.body import EASY, HALT_TIME, SOLE, STEP, Body, Glide
from rrp_sheets.sim.gait import JOINTS, STEP_TIME, TURN, FootPlace, Gait, Legs, Standing

FASTEST_TURN = TURN / (2 * STEP_TIME)  # rad/s
REST_AFTER = 0.4  # s without a step before the robot stands on its own again
UPRIGHT, LOW = 0.8, 0.17  # the torso's axis upward and height (m) of a robot on its feet
NEAR = 0.03  # rad: a leg's joint that is nearer to the start posture is there
FORCE = 400.0  # N; holds the robot's weight (53 N) without letting it sway
LEAD = 4.0  # steps of the physics: the constraint is behind by so much, and therefore sent ahead
FRONT, BACK, INNER, OUTER = 0.105, -0.047, 0.037, 0.046  # m, of a sole, from below the ankle
MARGIN = 0.03  # m: the robot does not tip over its soles' ends before its weight is so far beyond them
ROLL_VELOCITY, ROLL_ACCELERATION = 1.0, 4.0  # rad/s, rad/s²: of the torso that settles
SINK_VELOCITY = 0.6  # m/s, of the torso on its way down or up
TOUCHES = 0.01  # m: what is nearer to the floor stands on it, the nearer the firmer
SEARCH_RANGE = 0.5  # rad on both sides of the wanted lean; a guide holds the torso, so it cannot lean farther
SAME_WITHIN = 5e-4  # rad: two leans that are nearer are the same
SEARCH_EVERY = 4  # steps of the physics
LEANS_TRIED, SHARPENINGS = 57, 4  # leans that are tried, and how often nearer ones are
BALLS = {  # link, place on it and radius (m) of what may touch the floor besides the soles
    "torso": ((-0.024, 0.025, -0.088, 0.037), (-0.024, -0.025, -0.088, 0.037), (-0.015, 0.035, 0.09, 0.03),
              (-0.015, -0.035, 0.09, 0.03), (0.015, 0.035, 0.09, 0.03), (0.015, -0.035, 0.09, 0.03)),
    "Head": ((0.0, 0.0, 0.058, 0.057),),
    "LThigh": ((0.006, 0.003, -0.02, 0.033), (0.006, 0.003, -0.081, 0.033)),
    "RThigh": ((0.006, -0.003, -0.02, 0.033), (0.006, -0.003, -0.081, 0.033)),
    "LTibia": ((0.006, 0.0, -0.006, 0.03), (0.004, 0.002, -0.087, 0.031)),
    "RTibia": ((0.006, 0.0, -0.006, 0.03), (0.004, -0.002, -0.087, 0.031)),
    "LShoulder": ((0.0, -0.004, 0.0, 0.031),), "RShoulder": ((0.0, 0.004, 0.0, 0.031),),
    "LBicep": ((0.086, 0.012, 0.0, 0.024),), "RBicep": ((0.086, -0.012, 0.0, 0.024),),
    "LForeArm": ((0.03, 0.0, 0.0, 0.028),), "RForeArm": ((0.03, 0.0, 0.0, 0.028),),
    "l_wrist": ((0.045, 0.0, 0.0, 0.026),), "r_wrist": ((0.045, 0.0, 0.0, 0.026),),
}  # fmt: skip


class Stance:
    """Holds the robot up."""

    def __init__(self, bullet: Any, body: Body) -> None:
        self._b, self._body = bullet, body
        self._legs = Legs(body.robot.data["legs"])
        self._joints = [f"{side}{joint}" for side in "LR" for joint in JOINTS]
        self._guide = Guide(bullet, body)
        self._gait: Gait | None = None
        self._resting: Resting | None = None
        self._around = 0.0  # rad: the lean near which it settles
        self._steady = False
        self.loose = self._stepped = self._rested = False  # loose: it was pushed and is left to physics
        self.turning = 0.0  # rad/s, positive to the left
        self._calm = 0.0
        self._goal: FootPlace | None = None
        self.arrived = False  # the last walk has led to its end
        self._way: tuple[float, float, float] | None = None  # where to walk when it stands upright
        self._standing = self._stands_now()

    @property
    def walking(self) -> bool:
        """True while the robot walks, or is about to."""
        return self._way is not None or (self._gait is not None and not self._gait.at_rest)

    @property
    def stepping(self) -> bool:
        """True while the robot makes steps, including the last one."""
        return self._gait is not None

    @property
    def swings(self) -> str:
        """The foot in the air, `L` or `R`; empty when both are on the floor."""
        return self._gait.swings if self._gait is not None else ""

    @property
    def guided(self) -> bool:
        """True while the guide holds the torso."""
        return self._guide.holds

    @property
    def upright(self) -> bool:
        """True when the legs are as in the start posture, so that the robot can walk and turn."""
        body = self._body
        return all(
            abs(body.aimed(j) - body.start[j]) < NEAR and abs(body.position(j) - body.start[j]) < NEAR
            for j in self._joints
        )

    @property
    def on_feet(self) -> bool:
        """True while the robot stands or crouches, upright; else it sits, lies, or is falling."""
        torso = self._body.torso()
        return not self.loose and float(torso.rotation[2, 2]) > UPRIGHT and float(torso.position[2]) > LOW

    @property
    def settled(self) -> bool:
        """True when the torso has come to rest after the legs have moved."""
        return self._resting is None or self._resting.settled

    @property
    def middle(self) -> FootPlace:
        """The middle between the feet, with the torso's heading."""
        if self._gait is not None:
            return self._gait.middle
        left, right = (self._body.sole(side).position for side in "LR")
        x, y = (float(c) for c in (left + right)[:2] / 2)
        return FootPlace(x, y, self._heading())

    @property
    def bound(self) -> float | None:
        """Direction in which the robot walks, rad in the world; None when it does not go anywhere."""
        return self._gait.bound if self._gait is not None else None

    def turn(self, rate: float) -> None:
        """Turn the whole body at a rate (rad/s) until the next call; 0 stops."""
        if rate and self._stand():
            self._step_out().turn(max(-FASTEST_TURN, min(FASTEST_TURN, rate)))
        elif not rate and self._gait is not None:
            self._gait.close()

    def walk(self, forward: float, left: float, turn: float) -> None:
        """Walk some way (m, m), then turn (rad), then stand; take the start posture first if necessary."""
        if self._gait is None and not (self.upright and self.on_feet):
            self.follow_legs(0.0)
            for joint in self._joints:
                self._body.go(joint, self._body.start[joint], EASY)
        self._way = (forward, left, turn)
        self.arrived = False

    def stop_walking(self) -> None:
        """Finish the step and stand."""
        self._way = self._goal = None
        if self._gait is not None:
            self._gait.close()

    def steady(self) -> None:
        """Hold the torso from now on: swinging arms would make the robot fall, as it does not balance by itself."""
        self._steady = True
        if not self.loose:
            self._guide.hold()

    def follow_legs(self, lean: float | None = None) -> None:
        """Let the torso follow the legs' joints from now on, in any posture: the robot rests on the floor.

        It settles around a lean, rad: 0 standing or sitting, −1.5 on its back, 1.5 on its belly; None is as before.
        """
        if self.loose:
            return
        guide = self._guide
        guide.hold()
        self._gait, self.turning, self._way = None, 0.0, None
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
        """Leave the robot to physics, as something pushes it."""
        self.loose, self._stepped, self._rested = True, self._gait is not None, self._resting is not None
        self._guide.release()
        self._gait = self._resting = self._way = None
        self.turning = 0.0
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
        """Advance by one step of the physics."""
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
        """Return whether the robot can walk now: it does already, or it stands upright."""
        return self._gait is not None or (self.on_feet and self.settled and not self._legs_move() and self.upright)

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
        self.turning = (spot.yaw - self._guide.yaw) / STEP
        for joint, angle in joints.items():
            self._body.put(joint, angle)
        self._guide.move(place, self._standing.lean, spot.yaw)
        if gait.beside and self._goal is not None:
            self.arrived, self._goal = gait.at(self._goal), None
        self._calm = self._calm + STEP if gait.beside else 0.0
        if self._calm >= REST_AFTER:
            self._gait, self.turning = None, 0.0
            self._body.meet_floor(feet=True)
            if not self._steady:
                self._guide.release()

    def _stands_now(self) -> Standing:
        """Measure how the robot stands in its start posture, which it has when this is called."""
        middle, torso = self.middle, self._body.torso().position
        _, lean, _ = self._body.tilt()
        ahead, left, _ = middle.seen(FootPlace(float(torso[0]), float(torso[1]), 0.0))
        ankles = {}
        for side in "LR":
            at = self._body.link(f"{side.lower()}_ankle").position
            x, y, _ = middle.seen(FootPlace(float(at[0]), float(at[1]), 0.0))
            ankles[side] = np.array([x, y, float(at[2])])
        return Standing(np.array([ahead, left, float(torso[2])]), lean, ankles)

    def _heading(self) -> float:
        return self._guide.yaw if self._guide.holds else self._body.tilt()[2]


class Guide:
    """A constraint between the torso and the world; it acts from the first call of `hold` on."""

    def __init__(self, bullet: Any, body: Body) -> None:
        self._b, self._body = bullet, body
        self._constraint: int | None = None
        self.place: Vector = np.zeros(3)  # of the torso's frame, m
        self.lean = self.yaw = 0.0  # of the torso, rad

    @property
    def holds(self) -> bool:
        """True while the constraint acts."""
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
        """Remove the constraint."""
        if self._constraint is not None:
            self._b.removeConstraint(self._constraint)
            self._constraint = None


class Resting:
    """Computes where the torso, whose place, lean and yaw are given, rests on the floor while the joints move."""

    def __init__(self, bullet: Any, body: Body, place: Vector, lean: float, yaw: float) -> None:
        self._b, self._body = bullet, body
        self.place, self.yaw = place.copy(), yaw
        self._lean = Glide(lean)
        self._towards = 0.0
        self._halted = False
        self._count = 0
        soles = [(f"{s}_ankle", (x, y, SOLE, 0.0)) for s, inner, outer in (("l", -INNER, OUTER), ("r", -OUTER, INNER))
                 for x in (FRONT, BACK) for y in (inner, outer)]  # fmt: skip
        balls = [(link, ball) for link, many in BALLS.items() for ball in many]
        links = [body.links.get(link, -1) for link, _ in (*soles, *balls)]  # the torso is none
        self._used = sorted(set(links) - {-1})
        self._frames = [self._used.index(link) + 1 if link >= 0 else 0 for link in links]
        self._local = np.array([ball[:3] for _, ball in (*soles, *balls)])
        self._radius = np.array([ball[3] for _, ball in (*soles, *balls)])
        self._beyond = np.zeros_like(self._local)
        self._beyond[: len(soles), 0] = np.where(self._local[: len(soles), 0] > 0, MARGIN, -MARGIN)
        self._masses = np.array([bullet.getDynamicsInfo(body.id, i)[0] for i in range(-1, len(body.links))])
        self._before: Vector | None = None
        self._still = 0

    @property
    def lean(self) -> float:
        """Forward lean of the torso, rad."""
        return self._lean.position

    @property
    def settled(self) -> bool:
        """True when the torso has come to rest."""
        return self._still >= 24  # steps of the physics: a tenth of a second

    def settle(self, towards: float) -> None:
        """Settle anew, around a lean (rad)."""
        self._towards, self._halted, self._still = towards, False, 0

    def halt(self) -> None:
        """Come to rest at once, as it is, until `settle` is called."""
        self._halted = True
        self._lean.acceleration = max(ROLL_ACCELERATION, abs(self._lean.speed) / HALT_TIME)
        self._lean.halt()

    def step(self) -> None:
        """Advance by one step of the physics: compute where the torso goes next."""
        points, weight, wider = self._shape()
        if not self._halted and self._count % SEARCH_EVERY == 0:
            goal = self._rest(wider, weight)
            if abs(goal - self._lean.target) > SAME_WITHIN:
                self._lean.go(goal, ROLL_VELOCITY, ROLL_ACCELERATION)
        self._count += 1
        self._lean.step(STEP)
        c, s = math.cos(self.lean), math.sin(self.lean)
        heights = c * points[:, 2] - s * points[:, 0] - self._radius
        low = float(heights.min())
        turned = np.column_stack([c * points[:, 0] + s * points[:, 2], points[:, 1]])
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        flat = turned @ np.array([[cy, sy], [-sy, cy]])
        place = np.array([*self.place[:2], -low])
        if self._before is not None:
            firm = np.maximum(0.0, 1 - (heights - low) / TOUCHES)
            place[:2] -= firm @ (flat - self._before) / firm.sum()
        self._before = flat
        move = place - self.place
        move[2] = max(-SINK_VELOCITY * STEP, min(SINK_VELOCITY * STEP, move[2]))
        self.place = self.place + move
        calm = not self._lean.moving and float(np.abs(move).max()) < 2e-5
        self._still = self._still + 1 if calm else 0

    def _shape(self) -> tuple[Vector, Vector, Vector]:
        """Return in the torso's frame: what may touch the floor, the centre of mass, the soles' ends with margin."""
        b, body = self._b, self._body
        torso = body.torso()
        states = b.getLinkStates(body.id, list(range(len(body.links))), computeForwardKinematics=True)
        centre, _ = b.getBasePositionAndOrientation(body.id)
        masses = np.array([centre, *(s[0] for s in states)])
        back = torso.rotation.T
        weight = back @ (self._masses @ masses / self._masses.sum() - torso.position)
        turns, places = [np.eye(3)], [np.zeros(3)]
        for index in self._used:
            turns.append(back @ np.array(b.getMatrixFromQuaternion(states[index][5])).reshape(3, 3))
            places.append(back @ (np.array(states[index][4]) - torso.position))
        turned = np.array(turns)[self._frames]
        points = np.einsum("nij,nj->ni", turned, self._local) + np.array(places)[self._frames]
        return points, weight, points + np.einsum("nij,nj->ni", turned, self._beyond)

    def _rest(self, wider: Vector, weight: Vector) -> float:
        """Return the lean at which the weight is lowest: of several such leans the nearest."""

        def height(leans: Vector) -> Vector:
            c, s = np.cos(leans), np.sin(leans)
            low = np.outer(c, wider[:, 2]) - np.outer(s, wider[:, 0]) - self._radius
            lifted: Vector = c * weight[2] - s * weight[0] - low.min(axis=1)
            return lifted

        leans = self._towards + np.linspace(-SEARCH_RANGE, SEARCH_RANGE, LEANS_TRIED)
        heights = height(leans)
        lowest = np.flatnonzero((heights[1:-1] <= heights[:-2]) & (heights[1:-1] < heights[2:])) + 1
        if not len(lowest):
            return float(leans[heights.argmin()])
        lean = leans[lowest[np.abs(leans[lowest] - self.lean).argmin()]]
        wide = leans[1] - leans[0]
        for _ in range(SHARPENINGS):
            near = np.linspace(lean - wide, lean + wide, 9)
            lean, wide = near[height(near).argmin()], wide / 4
        return float(lean)
