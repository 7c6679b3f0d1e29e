"""Body of the robot in the physics engine: joints, links, head camera, eyes, and motions through keyframes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rrp_sheets.model.names import key
from rrp_sheets.perception.pinhole import Pose, Vector
from rrp_sheets.robots.catalogue import Keyframe, Robot
from rrp_sheets.robots.trajectory import COUPLED, Clamped, JointLimits, JointPlan, Planner, moved
from rrp_sheets.sim.appearance import RGB

STEPS_A_SECOND = 240  # of the physics
STEP = 1 / STEPS_A_SECOND  # s
STIFFNESS = 0.3  # position gain of the motors: joint error below 0.002 rad when standing
EASY = 1.2  # rad/s: unhurried motion, for postures and for lowering an arm
ACCELERATION = 12.0  # rad/s²: of a calm motion; NAO's motors allow several times that
SOLE = -0.04519  # m, of the sole below the ankle's frame
SPAWN_GAP = 0.0005  # m above the floor at the start, so that the feet do not begin inside it
THUMBS = {"LHand": "LThumbJoint", "RHand": "RThumbJoint"}
"""The thumb follows the hand's motor."""
FLOOR = 0  # the first body of the physics
GEARS = 0.15  # of a motor's force: what its gears resist when it rests
HALT_TIME = 0.08  # s, in which every motion ends when all is stopped
ARRIVED = 1e-5  # rad; nearer than this the set point is put on its target


@dataclass(slots=True)
class Glide:
    """A set point that moves to its target.

    >>> g = Glide(0.0); g.go(1.0, velocity=1.0, acceleration=4.0)
    >>> steps = 0
    >>> while g.moving: g.step(1 / 240); steps += 1
    >>> g.position, 1.2 < steps / 240 < 1.3
    (1.0, True)
    """

    position: float  # of the set point, rad
    speed: float = 0.0  # rad/s, signed
    target: float = math.nan  # where it is going, rad
    velocity: float = 1.0  # the largest on the way, rad/s
    acceleration: float = 10.0  # the largest, rad/s²

    def __post_init__(self) -> None:
        if math.isnan(self.target):
            self.target = self.position

    @property
    def moving(self) -> bool:
        """True while the target is not reached."""
        return self.position != self.target or self.speed != 0.0

    def go(self, target: float, velocity: float, acceleration: float) -> None:
        """Head for a new target, from the present position and speed."""
        self.target, self.velocity, self.acceleration = target, velocity, acceleration

    def halt(self) -> None:
        """Stop as fast as the acceleration allows."""
        self.target = self.position + self.speed * abs(self.speed) / (2 * self.acceleration)

    def step(self, dt: float) -> None:
        """Let `dt` seconds pass."""
        left = self.target - self.position
        change = self.acceleration * dt
        if abs(left) < max(ARRIVED, change * dt) and abs(self.speed) <= 2 * change:
            self.position, self.speed = self.target, 0.0
            return
        # The speed from which it can still brake in the remaining way, less half a step's worth against overshoot.
        room = max(0.0, math.sqrt(2 * self.acceleration * abs(left)) - change / 2)
        wanted = math.copysign(min(self.velocity, room), left)
        self.speed += max(-change, min(change, wanted - self.speed))
        self.position += self.speed * dt


class Body:
    """The robot, standing in its start posture at the world's origin, looking along x."""

    def __init__(self, bullet: Any, robot: Robot) -> None:
        self._b, self.robot = bullet, robot
        urdf = str(robot.folder / robot.data["robot"]["urdf"])
        self.id: int = bullet.loadURDF(urdf, flags=bullet.URDF_USE_INERTIA_FROM_FILE)
        infos = [bullet.getJointInfo(self.id, i) for i in range(bullet.getNumJoints(self.id))]
        self.index: dict[str, int] = {i[1].decode(): i[0] for i in infos}
        self.links: dict[str, int] = {i[12].decode(): i[0] for i in infos}
        self._force: dict[str, float] = {i[1].decode(): i[10] for i in infos}
        self._com = np.array(bullet.getDynamicsInfo(self.id, -1)[3])
        self.start = dict(robot.data["postures"][robot.data["robot"]["start_posture"]])
        self._limits = JointLimits(robot)
        self._glides: dict[str, Glide] = {}
        self._moving: dict[str, Glide] = {}
        self._put: set[str] = set()  # joints that are put somewhere in this step
        self._put_before: set[str] = set()
        self.limp = False  # whether its motors are off, so that only gravity moves its joints
        self.fallen = False
        camera = robot.data["camera"]["top"]
        self.hfov, self.vfov = float(camera["hfov"]), float(camera["vfov"])
        self._camera = (camera["parent"], camera["xyz"], bullet.getQuaternionFromEuler(camera["rpy"]))
        self._stand_up()

    def _stand_up(self) -> None:
        b = self._b
        for name, angle in self.start.items():
            self._glides[name] = Glide(angle)
            for joint in (name, THUMBS.get(name)):
                if joint:
                    b.resetJointState(self.id, self.index[joint], angle)
        # The posture leans: turn the torso so that the soles are level, then put them on the floor.
        lean = -(self.start["LHipPitch"] + self.start["LKneePitch"] + self.start["LAnklePitch"])
        turned = b.getQuaternionFromEuler([0, lean, 0])
        b.resetBasePositionAndOrientation(self.id, [0, 0, 1], turned)
        sole = self.sole("L").position
        torso = self.torso().position
        place = torso - np.array([sole[0], 0.0, sole[2] - SPAWN_GAP])
        b.resetBasePositionAndOrientation(self.id, (place + self.torso().rotation @ self._com).tolist(), turned)
        self.meet_floor(feet=True)
        for name in self._glides:
            self._drive(name)

    def meet_floor(self, *, feet: bool, limbs: bool = False) -> None:
        """Set whether the feet and the other links collide with the floor, and their friction."""
        for name, link in {**self.links, "torso": -1}.items():
            foot = name in ("l_ankle", "r_ankle")
            self._b.setCollisionFilterPair(self.id, FLOOR, link, -1, int(feet if foot else limbs))
            self._b.changeDynamics(self.id, link, frictionAnchor=int(foot), lateralFriction=1.0 if foot else 0.6)

    def _drive(self, name: str, speed: float = 0.0) -> None:
        """Send a motor to its set point; given the set point's speed, the joint does not lag behind it."""
        if self.limp:
            return
        position = self._glides[name].position
        for joint in (name, THUMBS.get(name)):
            if joint:
                self._b.setJointMotorControl2(
                    self.id, self.index[joint], self._b.POSITION_CONTROL, position,
                    targetVelocity=speed, positionGain=STIFFNESS, force=1.5 * self._force[joint],
                )  # fmt: skip

    def step(self) -> None:
        """Move the set points by one step of the physics."""
        for name, glide in list(self._moving.items()):
            glide.step(STEP)
            self._drive(name, glide.speed)
            if not glide.moving:
                del self._moving[name]
        for name in sorted(self._put_before - self._put - self._moving.keys()):
            self._drive(name)  # what put it there has ended
        self._put_before, self._put = self._put, set()

    def go(self, joint: str, target: float, velocity: float = EASY, acceleration: float = ACCELERATION) -> None:
        """Send a joint to an angle (rad), which must be within its limits."""
        for name in (joint, COUPLED.get(joint)):
            if name:
                brake = max(acceleration, self._brake(name))
                self._glides[name].go(target, velocity, brake)
                self._moving[name] = self._glides[name]

    def coast(self, joint: str, speed: float) -> None:
        """Bring a joint that was `put` until now to rest, from the speed (rad/s) that it had."""
        glide = self._glides[joint]
        glide.speed = speed
        glide.acceleration = max(ACCELERATION, self._brake(joint))
        glide.halt()
        self._moving[joint] = glide

    def _brake(self, joint: str) -> float:
        """Return the deceleration (rad/s²) that keeps a moving joint within its limits."""
        glide = self._glides[joint]
        if not glide.speed:
            return 0.0
        low, high = self.limits(joint, self._glides["HeadYaw"].position)
        room = max(high - glide.position if glide.speed > 0 else glide.position - low, 1e-4)
        return min(glide.speed**2 / (2 * room), abs(glide.speed) / STEP)

    def put(self, joint: str, angle: float) -> None:
        """Set a joint's set point at once: for motions that are computed step by step."""
        self._moving.pop(joint, None)
        speed = (angle - self._glides[joint].position) / STEP if joint in self._put_before else 0.0
        self._glides[joint] = Glide(angle)
        self._put.add(joint)
        self._drive(joint, speed)

    def halt(self, joint: str) -> None:
        """Stop a joint's motion."""
        if joint in self._moving:
            self._moving[joint].halt()

    def freeze(self) -> None:
        """Bring every joint to rest within HALT_TIME."""
        for glide in self._moving.values():
            glide.acceleration = max(glide.acceleration, abs(glide.speed) / HALT_TIME)
            glide.halt()

    def switch_off_motors(self) -> None:
        """Switch off all motors; only their gears resist."""
        self.limp = True
        self._moving.clear()
        for joint, force in self._force.items():
            if force:
                self._b.setJointMotorControl2(
                    self.id, self.index[joint], self._b.VELOCITY_CONTROL, targetVelocity=0.0, force=GEARS * force
                )

    def aimed(self, joint: str) -> float:
        """Return the angle that the joint is being sent to, rad."""
        return self._glides[joint].target

    def set_point(self, joint: str) -> float:
        """Return the angle that the motor is set to at present, rad."""
        return self._glides[joint].position

    def position(self, joint: str) -> float:
        """Return the actual angle of the joint, rad."""
        return float(self._b.getJointState(self.id, self.index[joint])[0])

    def joints_used(self, uses: frozenset[str], names: frozenset[str]) -> set[str]:
        """Return the joints that a command names, else all joints of the resources that it uses."""
        chains, joints = self.robot.data["chains"], self.robot.joints
        return set(names) or {j for j in self.start if chains[joints[key(j)].chain] in uses}

    def positions(self) -> dict[str, float]:
        """Return the actual angles of all joints, rad."""
        states = self._b.getJointStates(self.id, [self.index[name] for name in self.start])
        return {name: float(state[0]) for name, state in zip(self.start, states, strict=True)}

    def on_its_way(self, joint: str) -> bool:
        """Return whether a joint's set point is still moving to its target."""
        return joint in self._moving

    def stirs(self, joint: str) -> bool:
        """Return whether a joint is on its way, or was set by `put` in this step or the one before."""
        return joint in self._moving or joint in self._put or joint in self._put_before

    def moving(self) -> bool:
        """Return whether any joint is on its way."""
        return bool(self._moving)

    def limits(self, joint: str, yaw: float = 0.0) -> tuple[float, float]:
        """Return a joint's limits in rad; those of the head's pitch depend on its yaw, to clear the shoulders.

        Between the yaws of the catalogue they are interpolated.
        """
        return self._limits.of(joint, yaw)

    def torso(self) -> Pose:
        """The torso's frame in the world (the physics reports the centre of mass instead)."""
        position, quaternion = self._b.getBasePositionAndOrientation(self.id)
        rotation = self._matrix(quaternion)
        return Pose(np.array(position) - rotation @ self._com, rotation)

    def link(self, name: str) -> Pose:
        """A link's frame in the world."""
        state = self._b.getLinkState(self.id, self.links[name], computeForwardKinematics=True)
        return Pose(np.array(state[4]), self._matrix(state[5]))

    def sole(self, side: str) -> Pose:
        """The middle of a sole (`L` or `R`), under the ankle."""
        ankle = self.link(f"{side.lower()}_ankle")
        return Pose(ankle.position + ankle.rotation[:, 2] * SOLE, ankle.rotation)

    def camera(self) -> Pose:
        """The head camera: x looks ahead, y left, z up."""
        parent, xyz, quaternion = self._camera
        state = self._b.getLinkState(self.id, self.links[parent], computeForwardKinematics=True)
        position, orientation = self._b.multiplyTransforms(state[4], state[5], xyz, quaternion)
        return Pose(np.array(position), self._matrix(orientation))

    def tilt(self) -> tuple[float, float, float]:
        """Roll, pitch and yaw of the torso, rad."""
        roll, pitch, yaw = self._b.getEulerFromQuaternion(self._b.getBasePositionAndOrientation(self.id)[1])
        return roll, pitch, yaw

    def shine(self, red: float, green: float, blue: float) -> None:
        """Give both eyes a colour, 0 to 1."""
        dark = 0.12  # what an eye that is off looks like
        rgba = [dark + (1 - dark) * c for c in (red, green, blue)] + [1.0]
        for eye in ("LeftEye", "RightEye"):
            self._b.changeVisualShape(self.id, self.links[eye], rgbaColor=rgba)

    def _matrix(self, quaternion: Any) -> Vector:
        return np.array(self._b.getMatrixFromQuaternion(quaternion)).reshape(3, 3)


class Eyes:
    """Both eyes: a colour and a brightness."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.colour: RGB = (1.0, 1.0, 1.0)
        self.brightness = 1.0
        self.show()

    @property
    def shining(self) -> RGB:
        """Colour of the eyes as it is seen: dimmed by the brightness."""
        red, green, blue = (round(c * self.brightness, 4) for c in self.colour)
        return red, green, blue

    def show(self, colour: RGB | None = None) -> None:
        """Apply a new colour, if there is one, and the brightness to the robot's model."""
        self.colour = colour or self.colour
        self._body.shine(*self.shining)


class Motion:
    """Joints on their way through keyframes, after motions of theirs that are under way have come to rest.

    When it is stopped, the joints go on from where they are with the speed that they have.

    Args:
        body: whose joints they are.
        frames: with rising times in s.
        returns: whether the joints go back to where they were, or were being sent.
        share: of the joints' top velocity that may be used.
        peak: rad/s: no joint is faster.
    """

    def __init__(
        self, body: Body, frames: Sequence[Keyframe], *, returns: bool = True, share: float = 1.0,
        peak: float = math.inf,
    ) -> None:  # fmt: skip
        self._body, self._frames, self._returns = body, frames, returns
        self._share, self._peak = share, peak
        self._plan: JointPlan | None = None
        self._time = 0.0
        self.joints = moved(frames)
        self.going = False  # it has begun and is not over
        self.home: dict[str, float] = {}  # where the joints were, or were being sent, when it began
        self.clamped: list[Clamped] = []  # the angles that could not be taken; known when it begins to move

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
        home = self.home if self._returns else None
        planner = Planner(self._body.robot, start, home, share=self._share, peak=self._peak)
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
