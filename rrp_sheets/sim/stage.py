"""Things of the scene: balls, persons, furniture, light and noise, their shapes, and the Scene sheet's actions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.sim import shapes
from rrp_sheets.sim.appearance import BALL_COLOURS, HEAD, RGB, parse_colour
from rrp_sheets.sim.people import Heads, Looks, body, is_seated
from rrp_sheets.sim.shapes import Cylinder, Solid, SolidBox, Sphere

Point = tuple[float, float, float]
BESIDE = 0.4  # m, between persons who are seen at the same time
FRONT: Point = (1.0, 0.0, 0.62)  # where a person who "is seen" has the face: in view without moving the head
LATER_US = 5_000  # a time so much after now has not come yet
AWAY = math.radians(150)  # how far a person who looks away turns
WIDE, SEATED_WIDE = 0.15, 0.19  # of a face's height: how wide a person is who stands, who sits (radius)
Size = tuple[float, float, float]
WALL_THICK, TOP_THICK, LEG = 0.05, 0.025, 0.035  # m: of a wall, of a table's top, and of its legs
WOOD: RGB = (0.80, 0.68, 0.52)
LEG_WOOD: RGB = (0.8 * 0.80, 0.8 * 0.68, 0.8 * 0.52)
PLASTER: RGB = (0.80, 0.82, 0.80)
CARDBOARD: RGB = (0.72, 0.58, 0.42)
CUP_WIDE = 0.8  # of its height


@dataclass(frozen=True, slots=True)
class Still:
    """Path of a thing that stays at one place."""

    place: Point

    def at(self, us: int) -> Point:
        """Return the place at a time of the run."""
        return self.place


@dataclass(frozen=True, slots=True)
class LinePath:
    """Path from one place to another at constant speed.

    >>> LinePath((0, 0, 0), (1, 0, 2), 0, 1_000_000).at(500_000)
    (0.5, 0.0, 1.0)
    """

    start: Point
    end: Point
    from_us: int
    for_us: int

    def at(self, us: int) -> Point:
        """Return the place at a time of the run."""
        part = 1.0 if self.for_us <= 0 else min(max((us - self.from_us) / self.for_us, 0.0), 1.0)
        x, y, z = (a + part * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y, z


@dataclass(frozen=True, slots=True)
class Circle:
    """Path around a middle, upright (facing the robot) or flat, leaving from `start` without a jump."""

    start: Point
    middle: Point
    radius: float
    period_us: int
    from_us: int
    flat: bool = False

    def at(self, us: int) -> Point:
        """Return the place at a time of the run: in the first quarter of a round it swings onto the circle.

        >>> c = Circle((1.0, 0.0, 0.4), (0.0, 0.0, 0.4), 0.5, 4_000_000, 0, flat=True)
        >>> c.at(0), [round(x, 3) for x in c.at(1_000_000)]
        ((1.0, 0.0, 0.4), [0.0, 0.5, 0.4])
        """
        passed = max(us - self.from_us, 0)
        part = min(1.0, 4 * passed / self.period_us)
        mx, my, mz = self.middle
        dx, dy, dz = self.start[0] - mx, self.start[1] - my, self.start[2] - mz
        a, b, off = (dx, dy, dz) if self.flat else (dy, dz, dx)
        far = math.hypot(a, b)
        angle = (math.atan2(b, a) if far > 1e-9 else -math.pi / 2) + 2 * math.pi * passed / self.period_us
        radius = far + part * (self.radius - far)
        a, b, off = radius * math.cos(angle), radius * math.sin(angle), off * (1 - part)
        return (mx + a, my + b, mz + off) if self.flat else (mx + off, my + a, mz + b)


Path = Still | LinePath | Circle


class Stage:
    """Everything in the world except the robot. Positions are functions of the time, so nothing drifts."""

    def __init__(
        self, bullet: Any, actions: Sequence[SceneAction], other: Callable[[SceneAction], None], heads: Heads
    ) -> None:
        self._b, self._heads, self._looks = bullet, heads, Looks(actions)
        self._other = other  # what people do without moving: presses, touches, words
        self._waiting: list[SceneAction] = []
        self.balls: dict[str, Ball] = {}  # by key, as are persons and props
        self.persons: dict[str, ScenePerson] = {}
        self.props: dict[str, Prop] = {}
        self._levels: dict[str, Path] = {"light": Still((1.0, 0.0, 0.0)), "noise": Still((0.0, 0.0, 0.0))}
        self._solids: tuple[int, tuple[Solid, ...]] | None = None
        self.us = 0
        self._acts: dict[str, Callable[[SceneAction], None]] = {
            "appear": self._appear, "move": self._move, "circle": self._circle, "disappear": self._disappear,
            "away": self._turn, "look": self._turn, "seen": self._seen, "set": self._set,
        }  # fmt: skip
        self.plan(actions)

    def plan(self, actions: Sequence[SceneAction]) -> None:
        """Schedule further actions at their times, in order at equal times; those that wait for a cue are left out."""
        self._waiting = sorted([*self._waiting, *(a for a in actions if not a.cue)], key=lambda a: a.time_us)

    def by_hand(self, actions: Sequence[SceneAction]) -> None:
        """Apply actions on things now, also while the world stands still; the rest happens in the next step."""
        for action in actions:
            if action.verb in self._acts and action.time_us <= self.us + LATER_US:
                self._do(action)
            else:
                self.plan((action,))

    def go_on(self, us: int) -> None:
        """Carry out all actions that are due until `us`."""
        while self._waiting and self._waiting[0].time_us <= us:
            self._do(self._waiting.pop(0))
        for name, person in list(self.persons.items()):
            if person.until_us is not None and person.until_us <= us:
                person.figure.remove()
                del self.persons[name]
        self.us = us

    def _do(self, action: SceneAction) -> None:
        self._solids = None
        self._acts.get(action.verb, self._other)(action)

    def place(self) -> None:
        """Put every figure where it is now; before a picture is drawn."""
        for ball in self.balls.values():
            ball.figure.place(ball.path.at(self.us))
        for prop in self.props.values():
            prop.figure.place(prop.path.at(self.us), prop.turned)
        for person in self.persons.values():
            x, y, z = person.path.at(self.us)
            person.figure.place((x, y, z - person.height), person.heading(self.us))

    @property
    def light(self) -> float:
        """Present brightness of the room, 0 to 1."""
        return self._levels["light"].at(self.us)[0]

    @property
    def noise(self) -> float:
        """Present loudness of the room, 0 to 1."""
        return self._levels["noise"].at(self.us)[0]

    def things(self) -> list[Ball | ScenePerson | Prop]:
        """Return everything that is there."""
        return [*self.balls.values(), *self.persons.values(), *self.props.values()]

    def solids(self) -> tuple[Solid, ...]:
        """Return the shapes of everything, where it is now."""
        if self._solids is None or self._solids[0] != self.us:
            self._solids = self.us, tuple(solid for thing in self.things() for solid in thing.solids(self.us))
        return self._solids[1]

    def nearest(self, points: Iterable[Sequence[float]]) -> tuple[float, str]:
        """Return the least distance of a thing from the points (m), and its name; infinite and empty without one."""
        solids = self.solids()
        return min(((s.distance(point), s.name) for point in points for s in solids), default=(math.inf, ""))

    def places(self) -> dict[str, tuple[float, ...]]:
        """Return the places by name: a ball's middle, a person's face, else the middle of the underside."""
        return {thing.name: thing.path.at(self.us) for thing in self.things()}

    def looks(self) -> dict[str, Mapping[str, Value]]:
        """Return the appearance of everything, by its name, for displays."""
        found: dict[str, Mapping[str, Value]] = {
            b.name: {"kind": "ball", "size": [2 * b.radius] * 3, "colour": b.colour} for b in self.balls.values()
        }
        for p in self.persons.values():
            found[p.name] = {"kind": "person", "height": p.height, "seated": p.seated, "number": p.number,
                             "face": -1 if p.picture else p.drawn, "away": not p.looks}  # fmt: skip
        for t in self.props.values():
            found[t.name] = {"kind": t.kind, "size": list(t.size), "colour": t.colour, "turned": t.turned}
        return found

    def _appear(self, action: SceneAction) -> None:
        name, values, kind = key(action.thing), action.values, action.what
        at = _point(values["at"])
        if kind == "person":
            self._enter(name, action, at)
            return
        self._disappear(action)
        if kind == "ball":
            radius, colour = float(values["size"]) / 2, str(values["colour"])
            figure = shapes.ball(self._b, colour, radius)
            self.balls[name] = Ball(action.thing, figure, radius, Still(at), colour)
        else:
            at = self._upon(at, values)
            self.props[name] = make_prop(self._b, action.thing, kind, values, at)

    def _upon(self, at: Point, values: Mapping[str, Value]) -> Point:
        """The place, on the table where the values say so: on the nearest one, if there is any."""
        tables = [t for t in self.props.values() if t.kind == "table"] if values.get("on") == "table" else []
        table = min(tables, key=lambda t: math.dist(t.path.at(self.us)[:2], at[:2]), default=None)
        return (at[0], at[1], table.path.at(self.us)[2] + table.size[2]) if table else at

    def _enter(self, name: str, action: SceneAction, at: Point) -> ScenePerson:
        if old := self.persons.pop(name, None):
            old.figure.remove()
        values = action.values
        number = self._looks.number(action)
        posture, picture = str(values.get("posture") or ""), str(values.get("picture") or "")
        portrait = self._heads.portrait(self._looks.face(number), picture)
        figure = shapes.CompoundShape(self._b)
        clothes = shapes.CLOTHES[(number - 1) % len(shapes.CLOTHES)]
        body(self._b, figure, clothes, portrait.skin, at[2], posture)
        self._heads.add(figure, portrait, at[2])
        person = ScenePerson(
            action.thing, number, figure, Still(at), at[2], posture=posture, drawn=self._looks.face(number),
            picture=picture, voice=str(values.get("voice") or ""),
        )  # fmt: skip
        self.persons[name] = person
        return person

    def _seen(self, action: SceneAction) -> None:
        x, y, z = FRONT
        taken = [p.path.at(action.time_us)[1] for p in self.persons.values()]
        spots = [y + BESIDE * k for k in (0, 1, -1, 2, -2)]
        y = next((s for s in spots if all(abs(s - t) > BESIDE / 2 for t in taken)), y)
        name = f"{key(action.thing)} {action.values.get('id')}"
        person = self._enter(name, action, (x, y, z))
        person.until_us = action.time_us + round(float(action.values["seconds"]) * 1e6)

    def _move(self, action: SceneAction) -> None:
        if thing := self._thing(action):
            start = thing.path.at(action.time_us)
            end = self._upon(_point(action.values["to"], start[2]), action.values)
            thing.path = LinePath(start, end, action.time_us, round(float(action.values["seconds"]) * 1e6))

    def _circle(self, action: SceneAction) -> None:
        if thing := self._thing(action):
            start, values = thing.path.at(action.time_us), action.values
            middle = _point(values["around"], start[2]) if values.get("around") else start
            radius, period = float(values["radius"]), round(float(values["period"]) * 1e6)
            thing.path = Circle(start, middle, radius, period, action.time_us, bool(values.get("flat")))

    def _disappear(self, action: SceneAction) -> None:
        name = key(action.thing)
        if thing := self.balls.pop(name, None) or self.persons.pop(name, None) or self.props.pop(name, None):
            thing.figure.remove()

    def _turn(self, action: SceneAction) -> None:
        if person := self.persons.get(key(action.thing)):
            person.looks = action.verb == "look"

    def _set(self, action: SceneAction) -> None:
        """Change light or noise to a level, at once or slowly."""
        now = self._levels[action.what].at(action.time_us)
        end = (float(action.values["share"]), 0.0, 0.0)
        lasts = round(float(action.values.get("seconds") or 0.0) * 1e6)
        self._levels[action.what] = LinePath(now, end, action.time_us, lasts)

    def _thing(self, action: SceneAction) -> Ball | ScenePerson | Prop | None:
        name = key(action.thing)
        return self.balls.get(name) or self.persons.get(name) or self.props.get(name)


def _point(value: Value, height: float = 0.0) -> Point:
    """Return a position; one of two numbers gets the given height."""
    x, y, *z = (float(v) for v in value)
    return x, y, z[0] if z else height


@dataclass
class Ball:
    """A ball in the world."""

    name: str
    figure: shapes.CompoundShape
    radius: float
    path: Path
    colour: str = ""

    def solids(self, us: int) -> list[Solid]:
        """Return its shape, where it is at a time."""
        return [Sphere(self.name, self.path.at(us), self.radius)]


@dataclass
class ScenePerson:
    """A person in the world.

    Attributes:
        number: the id that the face sensor gives for them when the robot knows them from the beginning.
        looks: False when looking away.
        until_us: when the person leaves by themselves, or None.
        posture: `seated`, `standing`, or empty: the height tells.
        drawn: which of the drawn faces.
        picture: the file of the face, or empty for the drawn one.
        voice: `child`, `female`, `male`, or empty.
    """

    name: str
    number: int
    figure: shapes.CompoundShape
    path: Path
    height: float
    looks: bool = True
    until_us: int | None = None
    posture: str = ""
    drawn: int = 0
    picture: str = ""
    voice: str = ""

    def heading(self, us: int) -> float:
        """Return the direction of the face, rad: towards the origin, where the robot begins, or away from it."""
        x, y, _ = self.path.at(us)
        return math.atan2(-y, -x) + (0.0 if self.looks else AWAY)

    @property
    def seated(self) -> bool:
        """True if the person sits."""
        return is_seated(self.height, self.posture)

    def solids(self, us: int) -> list[Solid]:
        """Return the shapes of the body and of the head on it."""
        x, y, z = self.path.at(us)
        body = z - HEAD
        radius = min((SEATED_WIDE if self.seated else WIDE) * self.height + 0.03, 0.25)
        return [Cylinder(self.name, (x, y, body / 2), radius, max(body, 0.01)), Sphere(self.name, (x, y, z), HEAD)]


@dataclass
class Prop:
    """A cup, a box, a table or a wall in the world.

    Attributes:
        size: along its own x (deep), y (wide) and z (high), m.
        turned: to the left, rad.
        colour: a name, or empty.
    """

    name: str
    kind: str
    figure: shapes.CompoundShape
    path: Path
    size: Size
    turned: float = 0.0
    colour: str = ""

    def solids(self, us: int) -> list[Solid]:
        """Return its shapes, where they are at a time."""
        x, y, z = self.path.at(us)
        deep, wide, high = self.size
        if self.kind == "cup":
            return [Cylinder(self.name, (x, y, z + high / 2), wide / 2, high)]
        if self.kind != "table":
            return [SolidBox(self.name, (x, y, z + high / 2), self.size, self.turned)]
        c, s = math.cos(self.turned), math.sin(self.turned)
        legs = [(x + c * ox - s * oy, y + s * ox + c * oy, z + high / 2) for ox, oy in _corners(deep, wide)]
        return [
            SolidBox(self.name, (x, y, z + high - TOP_THICK / 2), (deep, wide, TOP_THICK), self.turned),
            *(SolidBox(self.name, leg, (LEG, LEG, high), self.turned) for leg in legs),
        ]


def make_prop(bullet: Any, name: str, kind: str, values: Any, at: Point) -> Prop:
    """Create a cup, box, table or wall as its row of the Scene sheet says."""
    colour = str(values.get("colour") or "")
    size = _size(kind, values.get("size"))
    figure = shapes.CompoundShape(bullet)
    if kind == "cup":
        _cup(bullet, figure, size, colour)
    elif kind == "table":
        _table(bullet, figure, size)
    else:
        paint = PLASTER if kind == "wall" else _rgb(colour, CARDBOARD)
        figure.add(block(bullet, size, paint), (0, 0, size[2] / 2))
    return Prop(name, kind, figure, Still(at), size, float(values.get("turned") or 0.0), colour)


def _size(kind: str, said: Any) -> Size:
    if kind == "cup":
        return CUP_WIDE * float(said), CUP_WIDE * float(said), float(said)
    if kind == "wall":
        wide, high = (float(s) for s in said)
        return WALL_THICK, wide, high
    wide, deep, high = (float(s) for s in said)
    return deep, wide, high


def _corners(deep: float, wide: float) -> list[tuple[float, float]]:
    x, y = deep / 2 - LEG, wide / 2 - LEG
    return [(side * x, other * y) for side in (1, -1) for other in (1, -1)]


def _cup(bullet: Any, figure: shapes.CompoundShape, size: Size, colour: str) -> None:
    """Add a beaker: open at the top, wider there than below, without a handle."""
    radius, high = size[1] / 2, size[2]
    outline = [
        (0.0, 0.0), (radius * 0.72, 0.0), (radius * 0.76, high * 0.04), (radius, high), (radius * 0.93, high),
        (radius * 0.68, high * 0.08), (0.0, high * 0.08),
    ]  # fmt: skip
    figure.add(shapes.turned(bullet, outline, _rgb(colour, (0.95, 0.95, 0.93))), (0, 0, 0))


def _table(bullet: Any, figure: shapes.CompoundShape, size: Size) -> None:
    deep, wide, high = size
    figure.add(block(bullet, (deep, wide, TOP_THICK), WOOD), (0, 0, high - TOP_THICK / 2))
    under = high - TOP_THICK
    for x, y in _corners(deep, wide):
        figure.add(block(bullet, (LEG, LEG, under), LEG_WOOD), (x, y, under / 2))


def block(bullet: Any, size: Sequence[float], colour: RGB) -> int:
    """Create a block around its middle, lit separately on each side, and return its number."""
    points: list[list[float]] = []
    normals: list[list[float]] = []
    faces: list[int] = []
    for axis in range(3):
        for side in (1.0, -1.0):
            normal = [side if k == axis else 0.0 for k in range(3)]
            first = len(points)
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                point = [0.0, 0.0, 0.0]
                point[axis], point[u], point[v] = side * size[axis] / 2, a * size[u] / 2, b * size[v] / 2
                points.append(point)
                normals.append(normal)
            order = (0, 1, 2, 0, 2, 3) if side > 0 else (0, 2, 1, 0, 3, 2)
            faces += [first + i for i in order]
    return shapes.mesh(bullet, points, faces, normals, colour)


def _rgb(colour: str, otherwise: RGB) -> RGB:
    return BALL_COLOURS.get(colour) or parse_colour(colour) or otherwise if colour else otherwise
