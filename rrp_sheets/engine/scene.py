"""Scene of a run: the action by which each thing comes in, to put it back by hand, and rows that wait for events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rrp_sheets.engine.plan import Plan
from rrp_sheets.model.exchange import ROW_ABOVE, Notice, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.scene.default_scene import default_scene
from rrp_sheets.scene.scene_words import FACE_HEIGHT, draw_scene
from rrp_sheets.texts import N_


class SceneEntities:
    """Actions by which things of a scene come in: a ball with its size and colour, a person with number and name."""

    def __init__(self, plan: Plan, seed: int = 0) -> None:
        checked = plan.checked
        scene, _ = draw_scene(checked.scene or (), seed)
        if checked.scene is None:
            scene = default_scene(plan.outer_sensors, checked.robot)
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
    """The rows of a scene that wait, and what has become due.

    Args:
        scene: drawn: every number is one.

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
                self._due(i, us)

    def take(self) -> tuple[SceneAction, ...]:
        """Return the actions that have become due since the last call, with times of the run's clock."""
        ready, self._ready = tuple(self._ready), []
        return ready

    def left(self) -> list[Notice]:
        """Notes on the rows that have not had their event, for the end of the run."""
        return [
            Notice("note", N_("{thing}: what this row waits for has not come.", thing=a.thing), row=f"Scene!{a.row}")
            for a in (self._rows[i] for i in sorted(self._open))
        ]

    def _turn(self, i: int, us: int) -> None:
        """The row above the row at place `i` happens at `us`."""
        while i < len(self._rows) and self._rows[i].cue == ROW_ABOVE:
            us = self._happens(i, us)
            i += 1
        if i < len(self._rows) and self._rows[i].cue:
            self._armed.setdefault(self._rows[i].cue, []).append((i, us))

    def _due(self, i: int, us: int) -> None:
        self._turn(i + 1, self._happens(i, us))

    def _happens(self, i: int, us: int) -> int:
        action = self._rows[i]
        self._open.discard(i)
        self._ready.append(replace(action, time_us=us + action.time_us, cue=""))
        return us + action.time_us
