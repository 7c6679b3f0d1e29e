"""Presses and touches by people, on the robot and the run panel, as the scene gives them.

They are known, not perceived: the catalogue marks the sensors that are fed from here. A touch lasts half a second,
unless the scene gives another time.
"""

from __future__ import annotations

from rrp_sheets.model.exchange import Notice, SceneAction
from rrp_sheets.model.names import key
from rrp_sheets.robots.catalogue import Robot
from rrp_sheets.texts import N_

TOUCH_US = 500_000
_UNNOTICED = {
    "press": N_("{thing} presses {what}: no sensor of this workbook notices it."),
    "touch": N_("{thing} touches {what}: no sensor of this workbook notices it."),
}


class Signals:
    """Presses and touches at the present step.

    Attributes:
        presses: the buttons' labels.
        touches: the zones, and whether the touch begins (else it ends).
    """

    def __init__(self, robot: Robot) -> None:
        self._zones = {key(zone): zone for zone in robot.touch_zones}
        self._until: dict[str, int] = {}  # when each zone that is touched is let go
        self._resting: frozenset[str] = frozenset()  # zones that something rests against
        self._open: list[tuple[SceneAction, str, str]] = []  # what nothing has noticed yet, and what it says
        self.presses: list[str] = []
        self.touches: list[tuple[str, bool]] = []

    def begin(self, us: int) -> None:
        """Begin a new step: clear presses and touches, and end touches whose time is over."""
        self.presses, self.touches = [], []
        for zone, until in list(self._until.items()):
            if until <= us:
                del self._until[zone]
                if zone not in self._resting:
                    self.touches.append((zone, False))

    def contact(self, zones: frozenset[str]) -> None:
        """Set the zones that things rest against now, in place of earlier ones."""
        for zone in sorted(zones ^ self._resting):
            if zone not in self._until:  # somebody touches it already, or still
                self.touches.append((zone, zone in zones))
        self._resting = zones

    def act(self, action: SceneAction) -> None:
        """Take a press or a touch from the scene."""
        verb, what = action.verb, str(next(iter(action.values.values()), ""))
        if verb == "press":
            self.presses.append(what)
        elif verb == "touch":
            what = self._zones.get(key(what), what)
            if what not in self._until and what not in self._resting:  # one that is touched is only touched longer
                self.touches.append((what, True))
            seconds = action.values.get("seconds")
            lasts = TOUCH_US if seconds is None else round(float(seconds) * 1e6)
            self._until[what] = max(self._until.get(what, 0), action.time_us + lasts)
        self._open.append((action, verb, what))

    def noticed(self, verb: str, what: str) -> None:
        """Mark a press or a touch as noticed by a sensor."""
        self._open = [(a, v, w) for a, v, w in self._open if (v, w) != (verb, what)]

    def unnoticed(self) -> list[Notice]:
        """Return notes on presses and touches that no sensor has noticed, once."""
        notes = []
        for action, verb, what in self._open:
            if verb in _UNNOTICED:
                text = N_(_UNNOTICED[verb], thing=action.thing, what=what)
                notes.append(Notice("note", text, row=f"Scene!{action.row}" if action.row else ""))
        self._open.clear()
        return notes
