"""The simulated world, in lockstep with the engine's clock: robot, scene, devices, contacts, pushes, faces."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rrp_sheets.model.exchange import Arrivals, Command, Notice, SceneAction, WorldSnapshot, WorldState
from rrp_sheets.model.values import Value
from rrp_sheets.perception.faces import FaceModels, Faces
from rrp_sheets.perception.pinhole import Lens, Pixels, Vector
from rrp_sheets.robots.catalogue import REST_POSTURE
from rrp_sheets.sim.actuators import Eyes, Parts, make_actuator
from rrp_sheets.sim.actuators.tracker import Detection, Trackers
from rrp_sheets.sim.arbitration import Arbiter, Tell
from rrp_sheets.sim.body import EASY, STEP, STEPS_A_SECOND, Body, Motions
from rrp_sheets.sim.camera import Eye, jpeg
from rrp_sheets.sim.film import STALE_US, Film
from rrp_sheets.sim.people import Heads, Looks
from rrp_sheets.sim.portraits import studied
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.recording import Recording
from rrp_sheets.sim.sensors import SENSORS, SamplingClock, Senses, Sight, Signals, tidy
from rrp_sheets.sim.sounds import Speech, Voice
from rrp_sheets.sim.stage import Stage
from rrp_sheets.sim.stance import Stance
from rrp_sheets.sim.talk import Hearing, Talk
from rrp_sheets.texts import N_

SOLVER_ROUNDS = 30  # of 50 usual: joints stay within 0.003 rad, a fifth faster
SETTLING = 120  # steps before time 0, in which the feet come to stand on the floor
PICTURE = (320, 240)  # pixels of the head camera
HOLD_US = 1_000_000  # after Stop the robot first holds still
REST_WITHIN_US = 4_000_000  # and is then given so long to reach its rest
REPEAT_US = 5_000_000  # the same complaint of the same stream is told again only after so long
FORCES = {"gently": 11.0, "": 13.0, "hard": 40.0}  # N; from about 15 N the robot falls
_FROM = {"front": math.pi, "behind": 0.0, "left": -math.pi / 2, "right": math.pi / 2}  # which way it goes, rad
EVERY = 8  # physics steps between two looks for contacts: 30 a second
REACH = 1.0  # m from the torso: farther away nothing touches
USERS = ("FaceDetection", "RememberFace")
"""The devices that look at faces; without them no network is loaded."""
FACE_PICTURE = (640, 480)  # pixels, for faces: with half of that they are found to half the distance
RELAXED = 0.6  # of the unhurried speed, on the way back to the start posture
LEGS = frozenset({"LLeg", "RLeg"})


class SimWorld:
    """A world that advances only on request; an advance ends early when `halted`, asked before each step, is true."""

    def __init__(self, spec: Spec, halted: Callable[[], bool] = lambda: False) -> None:
        # Here, not above: on machines without pybullet everything else can still be imported and tested.
        import pybullet
        from pybullet_utils.bullet_client import BulletClient  # type: ignore[import-untyped]

        with quiet():
            self._b: Any = BulletClient(connection_mode=pybullet.DIRECT)
        self._b.setGravity(0, 0, -9.81)
        self._b.setTimeStep(STEP)
        self._b.setPhysicsEngineParameter(numSolverIterations=SOLVER_ROUNDS, deterministicOverlappingPairs=1)
        # The floor is painted behind the pictures; drawn here, its shape would be a checkerboard.
        unseen = self._b.createVisualShape(
            self._b.GEOM_MESH, vertices=[[0, 0, -9], [1e-4, 0, -9], [0, 1e-4, -9]], indices=[0, 1, 2]
        )
        self._b.createMultiBody(0, self._b.createCollisionShape(self._b.GEOM_PLANE), unseen)
        self._spec, self._halted = spec, halted
        out = Path(spec.out) if spec.out else None
        self._step = self._us = 0
        self._notices: list[Notice] = []
        self._told: dict[tuple[str, str, str], int] = {}
        self._film: Film | None = None
        self.body = Body(self._b, spec.robot)
        for _ in range(SETTLING):
            self._b.stepSimulation()
        self.signals = Signals(spec.robot)
        models = cache(FaceModels)
        heads = Heads(self._b, models)
        self.stage = Stage(self._b, spec.scene, self._by_people, heads)
        self.contacts = Contacts(self.body, self.stage)
        self.stance = Stance(self._b, self.body)
        lens = Lens(self.body.hfov, self.body.vfov, *PICTURE)
        fine = Lens(self.body.hfov, self.body.vfov, *FACE_PICTURE)
        self.sight = Sight(Eye(self._b, lens), Eye(self._b, fine), self.body, self.stage)
        self.faces = make_faces(spec, self.sight, self.stage, heads, fine, models)
        self.eyes = Eyes(self.body)
        speech = Speech(self._tell, halted)
        speech.prepare(spec.actuators, spec.scene)
        self.voice = Voice(out, self._tell, speech)
        self.talk = Talk(self.stage, speech, out, self._tell, spec.seed)
        self.hearing = Hearing(self.talk, speech, self._tell, spec.sensors)
        self.trackers = Trackers(self.body, self.stance)
        self.motions = Motions()
        senses = Senses(self.body, self.sight, self.faces, self.signals, self.hearing, self.stage)
        self._sensors = [
            (s.stream, SENSORS[s.device](s, senses), SamplingClock(s)) for s in spec.sensors if s.device in SENSORS
        ]
        seeing = frozenset(stream for stream, sensor, _ in self._sensors if sensor.locates)
        self.arbiter = Arbiter(spec.dones, self._tell)
        self.falling = Falling(self._b, self.body, self.stance, self.arbiter, self._tell)
        parts = Parts(self.body, self.stance, self.eyes, self.voice, self.faces, self.trackers, self.motions,
                      self.arbiter, self._tell, seeing, self.stage,
                      Path(spec.beside) if spec.beside else None)  # fmt: skip
        made = {a.stream: make_actuator(a, parts) for a in spec.actuators}
        self._actuators = {stream: actuator for stream, actuator in made.items() if actuator is not None}
        self.keeps_pictures = spec.camera and bool(seeing)  # of its camera: none when no row looks through it
        self._film = Film(self._b, self, spec, out) if spec.film else None
        self._recording = Recording(self, out, self.keeps_pictures) if spec.record and out else None

    def start(self) -> Arrivals:
        """Return the outcome of time 0."""
        return self._collect(self._instant())

    def advance(self, now_us: int, orders: Sequence[Command]) -> Arrivals:
        """Carry out commands, go on until `now_us`, and return the outcome."""
        for order in orders:
            if actuator := self._actuators.get(order.stream):
                if order.release:
                    relax(order.stream, self.body, self.stance, self.arbiter)
                elif order.value is None:
                    actuator.blank(order, self._us)
                else:
                    actuator.take(order, self._us)
                if self._film is not None:
                    self._film.ordered(self._us, order)
        events = self.arbiter.ended()
        last = (now_us * STEPS_A_SECOND + 500_000) // 1_000_000  # the nearest step
        while self._step < last and not self._halted():
            self._move()
            events += self._instant()
        self._us = max(self._us, now_us)
        return self._collect(events)

    def halt(self) -> None:
        """Silence the robot and halt every joint, as a rest begins."""
        self.arbiter.stop(None, self._us)
        self.body.freeze()
        self.stance.halt()

    def stop(self) -> Arrivals:
        """Silence the robot, hold still, take the rest posture, and write the film; return the outcome."""
        self.halt()
        ended = self.arbiter.ended()
        if self._film is not None:
            self._film.over = True
        if self._recording is not None:
            self._recording.close()
            self._recording = None
        self._pass(HOLD_US)
        if not self.body.fallen:
            if self.stance.on_feet:
                self.stance.follow_legs(0.0)
                for name, angle in self.body.robot.data["postures"][REST_POSTURE].items():
                    self.body.go(name, angle, EASY)
                self._pass(REST_WITHIN_US, lambda: not self.body.moving() and self.stance.settled)
            self.body.switch_off_motors()
        if self._film is not None:
            self._film.write()
        return self._collect(ended)

    def close(self) -> None:
        """Free the physics."""
        self._b.disconnect()

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Apply scene actions that are triggered by hand, now."""
        self.stage.by_hand(actions)
        self.sight.forget()

    def show(self, picture: bool) -> WorldSnapshot:
        """Return the world for a display, with the camera picture if wanted; the run does not depend on it."""
        return WorldSnapshot(self.state(), jpeg(self.sight.recent(STALE_US)) if picture else b"")

    def state(self) -> WorldState:
        """Return the present state of the world."""
        return WorldState(
            joints=self.body.positions(), base=(*(float(c) for c in self.body.torso().position), *self.body.tilt()),
            eyes=self.eyes.shining, saying=self.voice.saying, things=self.stage.places(),
            driving=self.arbiter.driving(), looks=self.stage.looks(), light=self.stage.light, noise=self.stage.noise,
        )  # fmt: skip

    def watch(self) -> Pixels:
        """Return a picture of the robot from outside."""
        if self._film is None:
            self._film = Film(self._b, self, self._spec, None)
        return self._film.shoot()

    def unwritten(self, what: str, error: Exception) -> None:
        """Report that a file of the run's record cannot be written; the run goes on without it."""
        why = (error.strerror if isinstance(error, OSError) else "") or str(error)
        told = N_("{what} cannot be saved ({reason}). Free some disk space before the next run.", what=what, reason=why)
        self._tell(Notice("note", told))

    def _by_people(self, action: SceneAction) -> None:
        """Carry out what people do without moving: they press, touch, speak, push."""
        if action.verb == "push":
            self.falling.push(force(action.values, self.body.tilt()[2]))
        elif action.verb == "say":
            self.talk.say(action)
        else:
            self.signals.act(action)

    def _move(self) -> None:
        self._step += 1
        self._us = self._step * 1_000_000 // STEPS_A_SECOND
        self.trackers.step(self._us)
        self.motions.step()
        self.stance.step()
        self.body.step()
        self.falling.step(self._us, STEP)
        self._b.stepSimulation()

    def _instant(self) -> list[tuple[str, Value]]:
        """Process the present step (scene, voice, sensors, film) and return its events."""
        self.signals.begin(self._us)
        self.stage.go_on(self._us)
        self.talk.go_on(self._us, bool(self.voice.saying), self.voice.is_playing)
        if self.contacts.due(self._step):
            self.signals.contact(self.contacts.zones())
        events: list[tuple[str, Value]] = []
        seen: dict[str, Detection] = {}
        for stream, sensor, clock in self._sensors:
            if clock.due(self._step):
                values = [tidy(v) for v in sensor.read()]
                events += [(stream, v) for v in values]
                if sensor.locates and self._film is not None:
                    self._film.saw(self._us, stream, values[0] if values else None)
                if sensor.locates and values:
                    seen[stream] = self._detection(values[0])
        for note in (*self.signals.unnoticed(), *self.hearing.notes()):
            self._tell(note)
        if seen:
            self.trackers.detected(seen)
        self._after()
        return events + self.arbiter.ended()

    def _pass(self, us: int, until: Callable[[], bool] = lambda: False) -> None:
        """Advance for some time after the end of the run, or until a condition is met."""
        end = self._us + us
        while self._us < end and not until():
            self._halted()  # a sign of life
            self._move()
            self.stage.us = self._us  # what moves goes on moving, but nothing new happens
            self._after()

    def _after(self) -> None:
        self.arbiter.go_on(self._us)
        if self._film is not None:
            self._film.go_on(self._step)
        if self._recording is not None:
            self._recording.go_on(self._step)

    def _detection(self, values: dict[str, Value]) -> Detection:
        return Detection(
            self._us, values["x"], values["y"], values.get("distance"), self.body.position("HeadYaw"),
            self.body.position("HeadPitch"), self.sight.pose(),
        )  # fmt: skip

    def _tell(self, notice: Notice) -> None:
        if notice.kind in ("error", "clamp"):
            # A stream at camera rate must not fill the log with one complaint.
            which = (notice.kind, notice.stream, notice.row)
            if self._us < self._told.get(which, -REPEAT_US) + REPEAT_US:
                return
            self._told[which] = self._us
        self._notices.append(notice)
        if self._film is not None:
            self._film.tell(notice)

    def _collect(self, events: list[tuple[str, Value]]) -> Arrivals:
        notices, self._notices = self._notices, []
        return Arrivals(tuple(events), tuple(notices))


def force(values: Mapping[str, Value], yaw: float) -> tuple[float, float, float]:
    """Return the force of a push (N, in the world), from a side of a robot that is turned by `yaw` (rad).

    >>> [round(f) for f in force({"from": "behind", "how": "hard"}, 0.0)]
    [40, 0, 0]
    """
    newtons = FORCES[str(values.get("how") or "")]
    way = yaw + _FROM[str(values.get("from") or "front")]
    return newtons * math.cos(way), newtons * math.sin(way), 0.0


@contextmanager
def quiet(descriptor: int = 1) -> Iterator[None]:
    """Drop what C code writes to a descriptor (1: standard output) within the block, where Python must not use it."""
    flush = ctypes.CDLL(None).fflush  # the library's lines are buffered, and would come out at the program's end
    sys.stdout.flush()
    flush(None)
    kept, nowhere = os.dup(descriptor), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, descriptor)
        os.close(kept)
        os.close(nowhere)


class Contacts:
    """Finds the touch zones that something rests against."""

    def __init__(self, body: Body, stage: Stage) -> None:
        self._body, self._stage = body, stage
        self._pads: list[dict[str, Any]] = body.robot.data["touch"].get("pads", [])

    def due(self, step: int) -> bool:
        """Return whether to look at this step; without things in the room, there is nothing to find."""
        return step % EVERY == 0 and bool(self._stage.things())

    def zones(self) -> frozenset[str]:
        """Return the touch zones that are in contact now."""
        torso = self._body.torso().position
        near = [s for s in self._stage.solids() if s.distance(torso) < REACH]
        found = set()
        for pad in self._pads if near else ():
            if pad["zone"] in found:
                continue
            link = self._body.link(pad["link"]) if pad["link"] in self._body.links else self._body.torso()
            point = link.position + link.rotation @ np.array(pad["xyz"])
            if any(s.distance(point) <= pad["radius"] for s in near):
                found.add(pad["zone"])
        return frozenset(found)


def make_faces(
    spec: Spec, sight: Sight, stage: Stage, heads: Heads, lens: Lens, models: Callable[[], FaceModels]
) -> Faces:
    """Make the robot's knowledge of faces, as it is at the beginning of a run.

    Raises:
        SheetsError: a picture that the scene names, or the file of remembered faces, cannot be used.
        MissingPart: the networks are missing, and a device needs them.
    """
    for action in spec.scene:
        if picture := str(action.values.get("picture") or ""):
            heads.portrait(0, picture)
    faces = Faces(sight.look_closely, sight.pose, lambda: stage.us, lens, models)
    if any(use.device in USERS for use in (*spec.sensors, *spec.actuators)):
        if spec.faces:
            faces.know_from(Path(spec.faces))
        for known in Looks(spec.scene).known:
            # As if the robot had been shown this person's picture before.
            views = studied(heads.portrait(known.face, known.picture), models())
            faces.memory.know(known.number, known.name, views)
        models()
    return faces


def relax(stream: str, body: Body, stance: Stance, arbiter: Arbiter) -> None:
    """Bring the joints that an actuator stream has moved, and no running command uses, back to the start posture."""
    if body.fallen:
        return
    chain = {joint.name: joint.chain for joint in body.robot.joints.values()}
    joints = body.joints_used(*arbiter.moved(stream))
    for uses, names in arbiter.in_use():
        joints -= body.joints_used(uses, names)
    legs = {j for j in joints if chain[j] in LEGS}
    if stance.stepping:  # it finishes its step and stands
        joints -= legs
    elif legs and any(abs(body.aimed(j) - body.start[j]) > 1e-6 for j in legs):
        stance.follow_legs(0.0)
    for joint in sorted(joints):
        body.go(joint, body.start[joint], RELAXED * EASY)


HELD = 10.0  # N: a push that the guide withstands
CHEST = 0.08  # m above the torso's frame, where a push acts
TIPPED = 0.8  # rad from how it stood before: it falls, and nothing will stop that
CALM_US = 1_000_000  # so long after a push it must have come to rest for the guide to take it again
CALM_RATE = 0.15  # rad/s, of the torso: at rest
UPSET = 0.12  # rad: a robot that is tilted by more is still on its way
FALLEN = N_("The robot has fallen. Its motors are off for the rest of this run; speech and eyes still work. Check "
            "what pushes it in the Scene sheet, or run again.")  # fmt: skip
LIES = N_("The robot lies on the floor with its motors off, so it cannot do this.")


class Falling:
    """Applies pushes, which alone make the robot fall, and detects falls: the arbiter then refuses what moves it."""

    def __init__(self, bullet: Any, body: Body, stance: Stance, arbiter: Arbiter, tell: Tell) -> None:
        self._b, self._body, self._stance = bullet, body, stance
        self._arbiter, self._tell = arbiter, tell
        self._force: Vector = np.zeros(3)
        self._left = 0.0  # s that the push still lasts
        self._calm_us = 0
        self._before = 0.0  # rad: how far the torso was from upright before the push

    def push(self, newtons: Sequence[float], seconds: float = 0.2) -> None:
        """Push the chest with a force (x, y, z in the world, N) for some seconds."""
        if self._stance.guided and math.hypot(*newtons) < HELD:
            return
        self._force, self._left = np.array(newtons, dtype=np.float64), seconds
        if not self._body.fallen and not self._stance.loose:
            self._before = self._from_upright()
            self._stance.let_go()

    def step(self, us: int, dt: float) -> None:
        """Prepare one step of the physics: apply the push, and check whether the robot falls."""
        if self._left > 0:
            self._left -= dt
            torso = self._body.torso()
            place = torso.position + torso.rotation[:, 2] * CHEST
            self._b.applyExternalForce(self._body.id, -1, self._force.tolist(), place.tolist(), self._b.WORLD_FRAME)
            self._calm_us = us + CALM_US
        if not self._stance.loose or self._body.fallen:
            return
        tilt = self._from_upright() - self._before
        if tilt > TIPPED:
            self._body.fallen = True
            self._body.switch_off_motors()
            self._arbiter.bar(frozenset(self._body.robot.data["chains"].values()), LIES, us)
            self._tell(Notice("error", FALLEN))
        elif us >= self._calm_us:
            turning = float(np.abs(self._b.getBaseVelocity(self._body.id)[1]).max())
            if abs(tilt) < UPSET and turning < CALM_RATE:  # it stands still: the guide holds it again
                self._stance.catch()
            else:
                self._calm_us = us + CALM_US // 4

    def _from_upright(self) -> float:
        return math.acos(max(-1.0, min(1.0, float(self._body.torso().rotation[2, 2]))))
