"""The things of the scene: balls, persons, furniture, light and noise, and what the Scene sheet makes them do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from rrp_sheets.model.names import key
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Value
from rrp_sheets.sim import figures
from rrp_sheets.sim.actors import Ball, Person
from rrp_sheets.sim.heads import Heads
from rrp_sheets.sim.looks import Looks
from rrp_sheets.sim.paths import Circle, Line, Point, Still
from rrp_sheets.sim.people import body
from rrp_sheets.sim.solids import Solid
from rrp_sheets.sim.things import Prop, make_prop

BESIDE = 0.4  # m, between persons who are seen at the same time
FRONT: Point = (1.0, 0.0, 0.62)  # where a person who "is seen" has the face: in view without moving the head
LATER_US = 5_000  # a time so much after now has not come yet


class Stage:
    """Everything in the world except the robot. Positions are functions of the time, so nothing drifts.

    Attributes:
        balls, persons, props: what is there, by key.
    """

    def __init__(
        self, bullet: Any, actions: Sequence[SceneAction], other: Callable[[SceneAction], None], heads: Heads
    ) -> None:
        self._b = bullet
        self._heads = heads
        self._looks = Looks(actions)
        self._other = other  # what people do without moving: presses, touches, words
        self._waiting: list[SceneAction] = []
        self.balls: dict[str, Ball] = {}
        self.persons: dict[str, Person] = {}
        self.props: dict[str, Prop] = {}
        self._levels: dict[str, Line] = {"light": _level(1.0), "noise": _level(0.0)}
        self._solids: tuple[int, tuple[Solid, ...]] | None = None
        self.us = 0
        self._acts: dict[str, Callable[[SceneAction], None]] = {
            "appear": self._appear, "move": self._move, "circle": self._circle, "disappear": self._disappear,
            "away": self._turn, "look": self._turn, "seen": self._seen, "set": self._set,
        }  # fmt: skip
        self.plan(actions)

    def plan(self, actions: Sequence[SceneAction]) -> None:
        """Let further actions happen at their times; those of one time in their order, those that wait never."""
        new = [action for action in actions if not action.cue]
        self._waiting = sorted([*self._waiting, *new], key=lambda a: a.time_us)

    def by_hand(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen now: things at once, also while the world stands still; the rest in the next step."""
        for action in actions:
            if action.verb in self._acts and action.time_us <= self.us + LATER_US:
                self._do(action)
            else:
                self.plan((action,))

    def go_on(self, us: int) -> None:
        """Let everything act that is due until `us`."""
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

    # ---- what else there is to know of the room
    @property
    def light(self) -> float:
        """How bright the room is now, 0 to 1."""
        return self._levels["light"].at(self.us)[0]

    @property
    def noise(self) -> float:
        """How loud the room is now, 0 to 1."""
        return self._levels["noise"].at(self.us)[0]

    @property
    def has_solids(self) -> bool:
        """Whether anything is there that a ray or a hand could meet."""
        return bool(self.balls or self.persons or self.props)

    def things(self) -> Iterator[Ball | Person | Prop]:
        """Everything that is there."""
        yield from self.balls.values()
        yield from self.persons.values()
        yield from self.props.values()

    def solids(self) -> tuple[Solid, ...]:
        """The shapes of everything, where it is now."""
        if self._solids is None or self._solids[0] != self.us:
            self._solids = self.us, tuple(solid for thing in self.things() for solid in thing.solids(self.us))
        return self._solids[1]

    def nearest(self, points: Iterable[Sequence[float]]) -> tuple[float, str]:
        """How near the nearest thing is to any of some points (m), and its name; infinite and empty without one."""
        solids = self.solids()
        return min(((s.distance(point), s.name) for point in points for s in solids), default=(math.inf, ""))

    def places(self) -> dict[str, tuple[float, ...]]:
        """Where everything is, by its name: a ball's middle, a person's face, else the middle of the underside."""
        return {thing.name: thing.path.at(self.us) for thing in self.things()}

    def looks(self) -> dict[str, Mapping[str, Value]]:
        """What everything looks like, by its name, for displays."""
        found: dict[str, Mapping[str, Value]] = {
            b.name: {"kind": "ball", "size": [2 * b.radius] * 3, "colour": b.colour} for b in self.balls.values()
        }
        for p in self.persons.values():
            found[p.name] = {"kind": "person", "height": p.height, "seated": p.seated, "number": p.number,
                             "face": -1 if p.picture else p.drawn, "away": not p.looks}  # fmt: skip
        for t in self.props.values():
            found[t.name] = {"kind": t.kind, "size": list(t.size), "colour": t.colour, "turned": t.turned}
        return found

    # ---- verbs
    def _appear(self, action: SceneAction) -> None:
        name, values, kind = key(action.thing), action.values, action.what
        at = _point(values["at"])
        if kind == "person":
            self._enter(name, action, at)
            return
        self._disappear(action)
        if kind == "ball":
            radius, colour = float(values["size"]) / 2, str(values["colour"])
            figure = figures.ball(self._b, colour, radius)
            self.balls[name] = Ball(action.thing, figure, radius, Still(at), colour)
        else:
            at = self._upon(at, values)
            self.props[name] = make_prop(self._b, action.thing, kind, values, at)

    def _upon(self, at: Point, values: Mapping[str, Value]) -> Point:
        """The place, on the table where the values say so: on the nearest one, if there is any."""
        if values.get("on") != "table":
            return at
        tables = [t for t in self.props.values() if t.kind == "table"]
        if not tables:
            return at
        table = min(tables, key=lambda t: math.dist(t.path.at(self.us)[:2], at[:2]))
        return at[0], at[1], table.top(self.us)

    def _enter(self, name: str, action: SceneAction, at: Point) -> Person:
        old = self.persons.pop(name, None)
        if old:
            old.figure.remove()
        values = action.values
        number = self._looks.number(action)
        posture, picture = str(values.get("posture") or ""), str(values.get("picture") or "")
        portrait = self._heads.portrait(self._looks.face(number), picture)
        figure = figures.Figure(self._b)
        clothes = figures.CLOTHES[(number - 1) % len(figures.CLOTHES)]
        body(self._b, figure, clothes, portrait.skin, at[2], posture)
        self._heads.add(figure, portrait, at[2])
        person = Person(
            action.thing, number, str(values.get("name") or ""), figure, Still(at), at[2], posture=posture,
            drawn=self._looks.face(number), picture=picture, voice=str(values.get("voice") or ""),
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
        thing = self._thing(action)
        if thing is not None:
            start = thing.path.at(action.time_us)
            end = self._upon(_point(action.values["to"], start[2]), action.values)
            thing.path = Line(start, end, action.time_us, round(float(action.values["seconds"]) * 1e6))

    def _circle(self, action: SceneAction) -> None:
        thing = self._thing(action)
        if thing is not None:
            start, values = thing.path.at(action.time_us), action.values
            middle = _point(values["around"], start[2]) if values.get("around") else start
            period = round(float(values["period"]) * 1e6)
            thing.path = Circle(
                start, middle, float(values["radius"]), period, action.time_us, bool(values.get("flat"))
            )

    def _disappear(self, action: SceneAction) -> None:
        name = key(action.thing)
        thing = self.balls.pop(name, None) or self.persons.pop(name, None) or self.props.pop(name, None)
        if thing is not None:
            thing.figure.remove()

    def _turn(self, action: SceneAction) -> None:
        person = self.persons.get(key(action.thing))
        if person is not None:
            person.looks = action.verb == "look"

    def _set(self, action: SceneAction) -> None:
        """Light and noise become so strong, at once or slowly."""
        now = self._levels[action.what].at(action.time_us)
        end = (float(action.values["share"]), 0.0, 0.0)
        lasts = round(float(action.values.get("seconds") or 0.0) * 1e6)
        self._levels[action.what] = Line(now, end, action.time_us, lasts)

    def _thing(self, action: SceneAction) -> Ball | Person | Prop | None:
        name = key(action.thing)
        return self.balls.get(name) or self.persons.get(name) or self.props.get(name)


def _level(share: float) -> Line:
    return Line((share, 0.0, 0.0), (share, 0.0, 0.0), 0, 0)


def _point(value: Value, height: float = 0.0) -> Point:
    """A position; one of two numbers keeps the height."""
    x, y, *z = (float(v) for v in value)
    return x, y, z[0] if z else height
