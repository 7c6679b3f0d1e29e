"""Scene rows that wait: for the row above, or for an event of a stream (`Ask done + 2`).

Such a row has its turn when the row above it in the sheet has happened. The first event of its stream from then on
starts its time; a row without a stream starts its time at once. One event never starts two rows of which one waits for
the other: so rows under each other that wait for the same stream answer one event after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rrp_sheets.model.exchange import Notice
from rrp_sheets.model.scene import ROW_ABOVE, SceneAction


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
        """A stream (its id) has had an event."""
        armed = self._armed.pop(stream, [])
        late = [(i, since) for i, since in armed if since > us]
        if late:
            self._armed[stream] = late
        for i, since in armed:
            if since <= us:
                self._due(i, us)

    def take(self) -> tuple[SceneAction, ...]:
        """What has become due since it was last asked, with times of the run's clock."""
        ready, self._ready = tuple(self._ready), []
        return ready

    def left(self) -> list[Notice]:
        """Notes on the rows that have not had their event, for the end of the run."""
        return [
            Notice("note", f"{a.thing}: what this row waits for has not come.", row=f"Scene!{a.row}")
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
