"""Films the run: a few pictures a second of the robot from outside, with what it sees and says at that moment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.scene_actions import SceneAction
from rrp_sheets.model.values import Record, Value
from rrp_sheets.sim.camera import FilmCamera, Image, Shot
from rrp_sheets.sim.messages import Spec
from rrp_sheets.sim.motion import Point
from rrp_sheets.sim.stage import FRONT

if TYPE_CHECKING:
    from rrp_sheets.sim.film_file import FilmWriter
    from rrp_sheets.sim.world import SimWorld

SIZE = (560, 320)  # pixels
EVERY = 80  # physics steps between two pictures: 3 a second
MOST = 120  # pictures kept; of a longer run the duller one of each two is dropped, again and again
ROBOT_BOX = ((-0.12, 0.16), (-0.20, 0.20), (0.0, 0.68))  # m, what must be in the picture: raised hands too
AWAY = 0.2  # m: a robot that has walked farther is filmed from another place
INTERESTING = 2.3  # m from the robot: things farther away need not be in the picture
HIGHEST = 1.25  # m: what is higher need not be in the picture
RECENT_US = 700_000  # a detection is shown so long, unless the sensor's next picture has nothing
STALE_US = 100_000  # the robot's own picture may be older by so much than the one from outside
PAUSED_US = 1_000_000  # an actuator that had no command for so long begins something new
SPEAKS, BEGINS, SHINES, NOTED, TOLD = 2.0, 1.5, 1.0, 0.5, 0.2
"""Weights of what makes a moment worth showing: speech, a command that changes, other eyes, a note, anything else."""
SEES, SAYS = 1.0, 1.0  # as much: that something is seen, that it speaks, without being new
POSED, FAR = 7.0, 1.2  # as much: that arms or head are so far (rad) from where they are when it stands
AFTERWARDS = 3.0  # and so much less, when the run is over
MOST_NEWS = 4.0  # so that a first moment with many beginnings does not outweigh all others


class Film:
    """Collects shots while the world goes on."""

    def __init__(self, bullet: Any, world: SimWorld, spec: Spec, out: Path | None) -> None:
        self._world = world
        self._writer = _writer(out, spec.title) if out is not None else None
        self._names = {s.stream: s.name for s in spec.sensors}
        self._b, self._scene = bullet, spec.scene
        self._place = (0.0, 0.0)  # m, of the robot, where the camera expects it
        self._camera = FilmCamera(bullet, *_view(spec.scene, self._place), SIZE, _hiding(spec.scene))
        self.shots: list[Shot] = []
        self._every = EVERY
        self._next = 0
        self._news = 0.0
        self._seen: dict[str, tuple[int, str]] = {}
        self._ordered: dict[str, tuple[int, Value]] = {}
        self._eyes = world.eyes.shining
        self._step = 0
        self.over = False  # the run is over and the robot is brought to rest: less worth showing

    def tell(self, notice: Notice) -> None:
        """Let the next shot weigh more, because of a notice."""
        self._hurry({"say": SPEAKS, "person": SHINES, "sound": SHINES, "note": NOTED}.get(notice.kind, TOLD))

    def ordered(self, us: int, order: Command) -> None:
        """Take note of a command, which is news when it is the first for a while or differs from the one before.

        Only texts, colours and blanks are compared, as measured numbers and records always differ.
        """
        before_us, before = self._ordered.get(order.stream, (-PAUSED_US, None))
        value = None if isinstance(order.value, (int, float, dict, Record)) else order.value
        self._ordered[order.stream] = us, value
        if us - before_us >= PAUSED_US or value != before:
            self._hurry(BEGINS)

    def _hurry(self, news: float) -> None:
        """Let the next shot weigh more, and take it soon also in a long run whose shots are far apart."""
        self._news += news
        if news >= SHINES:
            self._next = min(self._next, self._step + EVERY)

    def saw(self, us: int, stream: str, value: Value) -> None:
        """Take note of a sensor's value; None when its newest picture has nothing."""
        if value is None:
            self._seen.pop(stream, None)
        elif isinstance(value, dict):
            far = value.get("distance")
            words = self._names.get(stream, stream)
            if isinstance(far, float):
                words += f" at {far:.2f}\N{NO-BREAK SPACE}m"
            who = value.get("name")
            self._seen[stream] = (us, f"{words}: {who}" if who else words)

    def go_on(self, step: int) -> None:
        """Take a shot when one is due."""
        self._step = step
        if step < self._next:
            return
        self._next = step + self._every
        self._take()
        if len(self.shots) > MOST:
            pairs = zip(self.shots[::2], [*self.shots[1::2], self.shots[-1]], strict=False)
            self.shots = [max(pair, key=lambda shot: shot.weight) for pair in pairs]
            self._every *= 2
            if self._writer is not None:
                self._writer.add(self.shots, thinned=True)

    def _take(self) -> None:
        world = self._world
        us = world.stage.us
        inside = world.sight.recent(STALE_US) if world.keeps_pictures else None
        eyes = world.eyes.shining
        if eyes != self._eyes:
            self._news += SHINES
            self._eyes = eyes
        sees = [words for seen_us, words in self._seen.values() if us - seen_us <= RECENT_US]
        weight = min(self._news, MOST_NEWS) + (SEES if sees else 0.0) + (SAYS if world.voice.saying else 0.0)
        weight += POSED * self._posed() - (AFTERWARDS if self.over else 0.0)
        self._news = 0.0
        outside, from_left = self.shoot(), bool(self._camera.pose.position[1] > 0)
        self.shots.append(Shot(us, outside, inside, world.voice.saying, eyes, ", ".join(sees), weight, from_left))
        if self._writer is not None:
            self._writer.add(self.shots, thinned=False)

    def _posed(self) -> float:
        """Return how far arms and head are from the start posture: 0 as there, 1 in the midst of a gesture."""
        body = self._world.body
        chains = body.robot.data["chains"]
        upper = [j.name for j in body.robot.joints.values() if chains[j.chain] != "legs" and j.unit]
        return min(max((abs(body.position(j) - body.start[j]) for j in upper), default=0.0) / FAR, 1.0) ** 2

    def shoot(self) -> Image:
        """Take a picture of the robot from outside."""
        self._world.stage.place()
        x, y, _ = (float(c) for c in self._world.body.torso().position)
        if math.dist((x, y), self._place) > AWAY:  # it has walked
            self._place = (x, y)
            self._camera = FilmCamera(self._b, *_view(self._scene, self._place), SIZE, _hiding(self._scene))
        return self._camera.shoot(self._shadows(self._world.stage.us), self._world.stage.light)

    def _shadows(self, us: int) -> list[tuple[float, float, float, float]]:
        """Soft shadows on the floor: (x, y, radius, darkness)."""
        body, stage = self._world.body, self._world.stage
        feet = [body.sole(side).position for side in "LR"]
        torso = body.torso().position
        shadows = [(float(f[0]) + 0.03, float(f[1]), 0.055, 0.38) for f in feet]
        shadows.append((float(torso[0]) - 0.03, float(torso[1]) + 0.03, 0.16, 0.22))
        for ball in stage.balls.values():
            x, y, z = ball.path.at(us)
            shadows.append((x - 0.1 * z, y + 0.1 * z, ball.radius * (0.9 + z), 0.45 / (1 + 2 * z)))
        for prop in stage.props.values():
            x, y, z = prop.path.at(us)
            wide = sorted(prop.size[:2])
            if prop.kind != "wall":
                shadows.append((x, y, 0.45 * wide[1], (0.2 if prop.kind == "table" else 0.4) / (1 + 4 * z)))
        shadows += [(p.face(us)[0], p.face(us)[1], 0.18, 0.45) for p in stage.persons.values()]
        return shadows

    def write(self) -> None:
        """Write the rest of `film.gif` and `strip.png` into the run's folder."""
        if self._writer is not None:
            try:
                self._writer.finish(self.shots)
            except OSError as error:
                self._world.unwritten("The film", error)


def _writer(out: Path, title: str) -> FilmWriter:
    from rrp_sheets.sim.film_file import FilmWriter  # loads Pillow, which a run without a film does not need

    return FilmWriter(out, title)


def _view(scene: Sequence[SceneAction], robot: tuple[float, float]) -> tuple[list[Point], Sequence[float]]:
    """Return the points that should be in the picture, and the sides (rad) from which it may be taken.

    The robot, where it is now, and the places where things near its start will be; from its right front, or more from
    the side when persons sit in front of it.
    """
    points = [(robot[0] + x, robot[1] + y, z) for x in ROBOT_BOX[0] for y in ROBOT_BOX[1] for z in ROBOT_BOX[2]]
    persons = False
    last: dict[str, Sequence[float]] = {}
    for action in scene:
        values, what = action.values, action.what
        place = values.get("to") or values.get("at") or (FRONT if action.verb == "seen" else None)
        if action.verb == "circle":
            place, radius = values.get("around") or last.get(action.thing), float(values["radius"])
            if place:
                points += [_near(place, (0, radius * side, radius * side)) for side in (1, -1)]
        if place:
            last[action.thing] = place
            if what in ("wall", "table"):  # they may stand out of the picture
                continue
            points += [_near(place, (0, side * 0.05, side * 0.05)) for side in (1, -1)]
            if what == "person":
                persons = True
                points += [
                    _near(place, (dx, dy, dz)) for dx in (-0.1, 0.1) for dy in (-0.1, 0.1) for dz in (-0.6, 0.12)
                ]
    return points, [math.radians(a) for a in ((-62, -70) if persons else (-26, -34, -42, -50, -58))]


def _hiding(scene: Sequence[SceneAction]) -> list[tuple[float, float, float]]:
    """Return the places of persons and walls that could hide the robot: (x, y, radius) in m."""
    radius = {"person": 0.35, "wall": 0.6}
    places = ((a.what, a.values.get("at") or a.values.get("to")) for a in scene)
    return [(float(place[0]), float(place[1]), radius[what]) for what, place in places if place and what in radius]


def _near(place: Sequence[float], offset: Point = (0.0, 0.0, 0.0)) -> Point:
    """Return the place, or one on the way to it when it is far from the origin."""
    x, y, z = place[0] + offset[0], place[1] + offset[1], (place[2] if len(place) > 2 else 0.4) + offset[2]
    far = math.hypot(x, y)
    shrink = min(1.0, INTERESTING / far) if far else 1.0
    return x * shrink, y * shrink, min(max(z, 0.0), HIGHEST)
