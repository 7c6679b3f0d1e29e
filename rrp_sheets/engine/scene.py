"""Scene of a run: the one that needs no Scene sheet, how each thing comes in, and rows that wait for events."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from rrp_sheets.engine.plan import Plan
from rrp_sheets.model.exchange import ROW_ABOVE, DeviceUse, Notice, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.scene.scene_words import BALL_SIZE, FACE_HEIGHT, choose_random_numbers
from rrp_sheets.texts import N_


def scene_of(plan: Plan, seed: int) -> tuple[tuple[SceneAction, ...], Sequence[tuple[int, str]]]:
    """Return the scene of a run, with what was drawn in words by the Scene row; the default one where there is none."""
    if plan.checked.scene is None:
        return default_scene(plan.outer_sensors, plan.checked.robot), ()
    return choose_random_numbers(plan.checked.scene, seed)


class SceneEntities:
    """Actions by which things of a scene come in: a ball with its size and colour, a person with number and name."""

    def __init__(self, plan: Plan, seed: int = 0) -> None:
        scene, _ = scene_of(plan, seed)
        self._entries: dict[str, SceneAction] = {}
        self.add(scene[::-1])  # as it came first

    def add(self, actions: Sequence[SceneAction]) -> None:
        """Remember things that come in."""
        for action in actions:
            if action.verb == "appear":
                self._entries[key(action.thing)] = action
            elif action.verb == "seen":
                values = {"at": (1.0, 0.0, FACE_HEIGHT), **{n: action.values.get(n) for n in ("id", "name")}}
                self._entries[key(action.thing)] = SceneAction(0, action.thing, "appear", values, kind="person")

    def entry(self, thing: str) -> SceneAction | None:
        """The action by which a thing comes in; None of one that the scene does not have."""
        return self._entries.get(key(thing))


class SceneTriggers:
    """The rows of a scene (drawn: every number is one) that wait, and what has become due.

    >>> rows = [SceneAction(1_000_000, "Operator", "press", row=2),
    ...         SceneAction(2_000_000, "Child", "say", row=3, cue="askdone"),
    ...         SceneAction(500_000, "Child", "touch", row=4, cue="+")]
    >>> triggers = SceneTriggers(rows)
    >>> triggers.heard("askdone", 900_000)
    >>> triggers.take()
    ()
    >>> triggers.heard("askdone", 4_000_000)
    >>> [(a.verb, a.time_us) for a in triggers.take()]
    [('say', 6000000), ('touch', 6500000)]
    """

    def __init__(self, scene: Sequence[SceneAction]) -> None:
        self._rows = sorted(scene, key=lambda a: a.row)
        self._armed: dict[str, list[tuple[int, int]]] = {}  # by stream: place of a row, and when its turn has come
        self._ready: list[SceneAction] = []
        self._open = {i for i, action in enumerate(self._rows) if action.cue}
        self.streams = frozenset(a.cue for a in self._rows if a.cue not in ("", ROW_ABOVE))
        if self._rows and self._rows[0].cue:
            self._turn(0, 0)
        for i, action in enumerate(self._rows):
            if not action.cue:
                self._turn(i + 1, action.time_us)

    def heard(self, stream: str, us: int) -> None:
        """Note that a stream (its id) has had an event."""
        armed = self._armed.pop(stream, [])
        late = [(i, since) for i, since in armed if since > us]
        if late:
            self._armed[stream] = late
        for i, since in armed:
            if since <= us:
                self._turn(i + 1, self._happens(i, us))

    def take(self) -> tuple[SceneAction, ...]:
        """Return the actions that have become due since the last call, with times of the run's clock."""
        ready, self._ready = tuple(self._ready), []
        return ready

    def left(self) -> list[Notice]:
        """Notes on the rows that have not had their event, for the end of the run."""
        return [
            Notice("note", N_("Scene row {row} never happened: its event never came.", row=a.row), row=f"Scene!{a.row}")
            for a in (self._rows[i] for i in sorted(self._open))
        ]

    def _turn(self, i: int, us: int) -> None:
        """The row above the row at place `i` happens at `us`."""
        while i < len(self._rows) and self._rows[i].cue == ROW_ABOVE:
            us = self._happens(i, us)
            i += 1
        if i < len(self._rows) and self._rows[i].cue:
            self._armed.setdefault(self._rows[i].cue, []).append((i, us))

    def _happens(self, i: int, us: int) -> int:
        action = self._rows[i]
        self._open.discard(i)
        self._ready.append(replace(action, time_us=us + action.time_us, cue=""))
        return us + action.time_us


PERSON = "person"
NEAR = "near"
BALL = " ball"
BETWEEN_US = 2_500_000  # between two things that people do
_DOERS = {"press": ("Operator", "label"), "touch": ("Person", "zone"), "say": ("Person", "words")}
HEIGHT = 0.574  # m: of the robot that the places below suit


def default_scene(sensors: Sequence[DeviceUse], robot: Robot) -> tuple[SceneAction, ...]:
    """A small scene in which these sensors have something to see, as the catalogue's `shows` says.

    Places suit a robot of NAO's height and grow with the robot.
    """
    shown: dict[str, None] = {}
    doings: list[tuple[str, Value]] = []
    for use in sensors:
        found = robot.find(use.device)
        if found is not None:
            settings = found.type.with_defaults(use.settings)
            for pattern in found.type.shows:
                verb, _, rest = pattern.partition(" ")
                if verb in _DOERS:
                    doings += [(verb, what) for what in _said_in(rest.strip(), settings, robot)]
                else:
                    shown[_filled(pattern, {k: str(v).casefold() for k, v in settings.items()})] = None
    grow = float(robot.data["robot"].get("height", HEIGHT)) / HEIGHT
    actions: list[SceneAction] = []
    for number, ball in enumerate(s for s in shown if s.endswith(BALL)):
        actions += _ball_play(ball.removesuffix(BALL), number, grow)
    if PERSON in shown:
        actions += _visit(grow)
    elif NEAR in shown:
        actions += _approach(grow)
    for place, (verb, what) in enumerate(dict.fromkeys(doings)):
        thing, name = _DOERS[verb]
        actions.append(SceneAction(1_000_000 + place * BETWEEN_US, thing, verb, {name: what}))
    return tuple(sorted(actions, key=lambda a: a.time_us))


def _filled(pattern: str, settings: Mapping[str, str]) -> str:
    """Fill settings into a text of the catalogue; it may come from anyone, so no format of Python's is read.

    >>> _filled("{colour} ball {colour.__class__} {other}", {"colour": "red"})
    'red ball {colour.__class__} {other}'
    """
    return re.sub(r"\{(\w+)\}", lambda place: settings.get(place[1], place[0]), pattern)


def _said_in(pattern: str, settings: Mapping[str, Value], robot: Robot) -> list[str]:
    """Return the texts of a pattern such as `{zone}`, filled in from the settings; a blank one is the first zone."""
    name = pattern.removeprefix("{").removesuffix("}")
    given = settings.get(name)
    if isinstance(given, tuple):
        return [str(g) for g in given]
    words = _filled(pattern, {k: str(v or "Left" if k == "side" else v or "") for k, v in settings.items()})
    zones = {key(z): z for z in robot.touch_zones}
    return [zones.get(key(words), words or next(iter(robot.touch_zones), ""))]


def _ball_play(colour: str, number: int, grow: float) -> list[SceneAction]:
    """A ball comes near, goes to both sides and away; a second one does so mirrored and later."""
    thing = "Ball" if colour.startswith("#") else f"{colour.capitalize()} ball"
    side, late = (1, -1)[number % 2], 1_500_000 * number
    moves = ((2, (0.42, 0.10, 0.42), 2), (6, (0.9, 0.45, 0.5), 2), (10, (0.8, -0.45, 0.36), 3), (15, (0.45, 0, 0.4), 2))

    def place(x: float, y: float, z: float) -> tuple[float, float, float]:
        return round(x * grow, 3), round(side * y * grow, 3), round(z * grow, 3)

    values: dict[str, Value] = {"at": place(1.0, 0.2, 0.4), "size": BALL_SIZE, "colour": colour}
    play = [SceneAction(late, thing, "appear", values)]
    for second, to, seconds in moves:
        play.append(SceneAction(late + second * 1_000_000, thing, "move", {"to": place(*to), "seconds": seconds}))
    return [*play, SceneAction(late + 19_000_000, thing, "disappear")]


def _approach(grow: float) -> list[SceneAction]:
    """A wall farther away, before which somebody comes near, waits, goes back and leaves."""
    face = FACE_HEIGHT * grow
    wall: dict[str, Value] = {"at": (2.2, 0.0, 0.0), "size": (2.0, 0.8 * grow)}
    return [
        SceneAction(0, "Wall", "appear", wall, kind="wall"),
        SceneAction(2_000_000, "Person", "appear", {"at": (1.6, 0.3, face)}, kind=PERSON),
        SceneAction(4_000_000, "Person", "move", {"to": (0.6, 0.1), "seconds": 4.0}, kind=PERSON),
        SceneAction(11_000_000, "Person", "move", {"to": (1.5, -0.3), "seconds": 3.0}, kind=PERSON),
        SceneAction(16_000_000, "Person", "disappear", kind=PERSON),
    ]


def _visit(grow: float) -> list[SceneAction]:
    """Somebody comes, moves a little, looks away for a moment and leaves; somebody else comes."""
    face = FACE_HEIGHT * grow
    first: dict[str, Value] = {"at": (1.1, 0.15, face), "id": 1}
    second: dict[str, Value] = {"at": (1.2, -0.2, face), "id": 2}
    return [
        SceneAction(1_000_000, "Person", "appear", first),
        SceneAction(6_000_000, "Person", "move", {"to": (1.0, -0.2), "seconds": 2.0}),
        SceneAction(10_000_000, "Person", "away"),
        SceneAction(12_000_000, "Person", "look"),
        SceneAction(15_000_000, "Person", "disappear"),
        SceneAction(17_000_000, "Person 2", "appear", second),
        SceneAction(24_000_000, "Person 2", "disappear"),
    ]
