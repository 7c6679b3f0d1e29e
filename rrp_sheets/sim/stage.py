"""The things of the scene: balls and persons, and what the Scene sheet makes them do."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rrp_sheets.model.names import key
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Value
from rrp_sheets.sim import figures
from rrp_sheets.sim.paths import Circle, Line, Point, Still

BESIDE = 0.4  # m, between persons who are seen at the same time
AWAY = math.radians(110)  # how far a person who looks away turns
FRONT: Point = (1.0, 0.0, 0.62)  # where a person who "is seen" has the face: in view without moving the head


@dataclass
class Ball:
    """A ball in the world."""

    name: str
    figure: figures.Figure
    radius: float
    path: Still | Line | Circle


@dataclass
class Person:
    """A person in the world.

    Attributes:
        number: the id that face detection gives.
        known: the name the robot knows already, or empty.
        looks: False when looking away.
        until_us: when the person leaves by themselves, or None.
    """

    name: str
    number: int
    known: str
    figure: figures.Figure
    path: Still | Line | Circle
    height: float
    looks: bool = True
    until_us: int | None = None

    def face(self, us: int) -> Point:
        """Where the face is at a time."""
        return self.path.at(us)

    def heading(self, us: int) -> float:
        """Which way the face looks, rad: towards the robot's place, or away."""
        x, y, _ = self.path.at(us)
        return math.atan2(-y, -x) + (0.0 if self.looks else AWAY)


class Stage:
    """Everything in the world except the robot. Positions are functions of the time, so nothing drifts."""

    def __init__(self, bullet: Any, actions: Sequence[SceneAction], other: Callable[[SceneAction], None]) -> None:
        self._b = bullet
        self._other = other  # what people do without moving: presses, touches, words
        self._waiting: list[SceneAction] = []
        self.balls: dict[str, Ball] = {}
        self.persons: dict[str, Person] = {}
        self._numbers: dict[str, int] = {}
        self.us = 0
        self._acts: dict[str, Callable[[SceneAction], None]] = {
            "appear": self._appear, "move": self._move, "circle": self._circle, "disappear": self._disappear,
            "away": self._turn, "look": self._turn, "seen": self._seen,
        }  # fmt: skip
        self.plan(actions)

    def plan(self, actions: Sequence[SceneAction]) -> None:
        """Let further actions happen at their times; those of one time in their order."""
        self._waiting = sorted([*self._waiting, *actions], key=lambda a: a.time_us)

    def by_hand(self, actions: Sequence[SceneAction]) -> None:
        """Let something happen now: things at once, also while the world stands still; the rest in the next step."""
        for action in actions:
            if action.verb in self._acts:
                self._acts[action.verb](action)
            else:
                self.plan((action,))

    def go_on(self, us: int) -> None:
        """Let everything act that is due until `us`."""
        while self._waiting and self._waiting[0].time_us <= us:
            action = self._waiting.pop(0)
            self._acts.get(action.verb, self._other)(action)
        for name, person in list(self.persons.items()):
            if person.until_us is not None and person.until_us <= us:
                person.figure.remove()
                del self.persons[name]
        self.us = us

    def place(self) -> None:
        """Put every figure where it is now; before a picture is drawn."""
        for ball in self.balls.values():
            ball.figure.place(ball.path.at(self.us))
        for person in self.persons.values():
            x, y, z = person.path.at(self.us)
            person.figure.place((x, y, z - person.height), person.heading(self.us))

    def _appear(self, action: SceneAction) -> None:
        name, values = key(action.thing), action.values
        at = _point(values["at"])
        if "size" in values:
            self._disappear(action)
            radius = float(values["size"]) / 2
            figure = figures.ball(self._b, str(values["colour"]), radius)
            self.balls[name] = Ball(action.thing, figure, radius, Still(at))
        else:
            self._enter(name, action, at)

    def _enter(self, name: str, action: SceneAction, at: Point) -> Person:
        old = self.persons.pop(name, None)
        if old:
            old.figure.remove()
        given = action.values.get("id")
        if given is None:
            taken = set(self._numbers.values())
            given = self._numbers.get(name) or next(n for n in range(1, len(taken) + 2) if n not in taken)
        number = int(given)
        self._numbers[name] = number
        known = str(action.values.get("name") or "")
        figure = figures.person(self._b, number - 1, at[2])
        person = Person(action.thing, number, known, figure, Still(at), at[2])
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
            thing.path = Line(
                start, _point(action.values["to"], start[2]), action.time_us,
                round(float(action.values["seconds"]) * 1e6),
            )  # fmt: skip

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
        thing = self.balls.pop(name, None) or self.persons.pop(name, None)
        if thing is not None:
            thing.figure.remove()

    def _turn(self, action: SceneAction) -> None:
        person = self.persons.get(key(action.thing))
        if person is not None:
            person.looks = action.verb == "look"

    def _thing(self, action: SceneAction) -> Ball | Person | None:
        name = key(action.thing)
        return self.balls.get(name) or self.persons.get(name)


def _point(value: Value, height: float = 0.0) -> Point:
    """A position; one of two numbers keeps the height."""
    x, y, *z = (float(v) for v in value)
    return x, y, z[0] if z else height
