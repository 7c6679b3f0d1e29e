"""Walk actuator: walks some way, then turns."""

from __future__ import annotations

import math

from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.sim.actuators.base import Base, as_number
from rrp_sheets.sim.arbitration import Job

MEASURES = ("Forward", "Left", "Turn")
UNITS = (" m", " m", " rad")
HEIGHTS = (0.05, 0.2, 0.35, 0.5)  # m: where it looks for things in its way
CLEAR = 0.17  # m, from the robot's middle: what comes nearer is in its way
AHEAD = 0.06  # m: where the robot will be a moment later
LOOKS_US = 50_000  # between two looks at what is in the way
Way = tuple[float, float, float]


class Walk(Base):
    """Walks the way of its settings, or the one that arrives."""

    _way: Way | None = None
    _goes_on = False

    def take(self, order: Command, us: int) -> None:
        """Walk; a repeated command lets the walk continue, a different one begins from where the robot is."""
        asked = self._asked(order)
        if asked is None:
            self.wrong(order, "a way: (forward, left, turn) in m, m and rad, for example (0.3, 0, 0)")
            return
        if not any(asked):
            self.fail(
                order, f"{self.spec.name} walks nowhere: it needs Forward, Left or Turn, or a value that says so."
            )
            return
        limits = [self.parts.body.robot.devices["walk"].settings[m.lower()] for m in MEASURES]
        way = tuple(
            self.clamp(order, f"{self.spec.name}: {m}", a, (float(s.lower or 0), float(s.upper or 0)), unit)
            for m, a, s, unit in zip(MEASURES, asked, limits, UNITS, strict=True)
        )
        self._goes_on = way == self._way and self.parts.stance.walking
        job = self._job(order, (way[0], way[1], way[2]))
        self.parts.arbiter.take(job, us)
        self._goes_on = False

    def _asked(self, order: Command) -> Way | None:
        """Return the way of the settings, or of the value when they are blank; None when that is not a way."""
        given = [as_number(self.settings.get(m.lower())) or 0.0 for m in MEASURES]
        value = order.value
        if not any(given) and isinstance(value, (list, tuple)) and len(value) in (2, 3):
            numbers = [as_number(v) for v in (*value, 0.0)[:3]]
            if any(n is None or abs(n) > 1e6 for n in numbers):
                return None
            given = [n or 0.0 for n in numbers]
        elif not any(given) and isinstance(value, (list, tuple)):
            return None
        return given[0], given[1], given[2]

    def _job(self, order: Command, way: Way) -> Job:
        stance = self.parts.stance
        blocked, looked_us = False, -LOOKS_US
        goes_on = self._goes_on

        def begin(order: Command, us: int) -> None:
            if not goes_on:
                stance.walk(*way)
            self._way = way

        def cease(us: int) -> None:
            if not self._goes_on:
                stance.stop_walking()
                self._way = None

        def over(us: int) -> bool | None:
            nonlocal blocked, looked_us
            if not blocked and us >= looked_us + LOOKS_US:
                looked_us = us
                thing = self._in_the_way()
                if thing:
                    blocked = True
                    stance.stop_walking()
                    text = f"{self.spec.name} stops: {thing} is in the way."
                    self.parts.tell(Notice("note", text, order.stream, order.row))
            if stance.walking:
                return None
            self._way = None
            return not blocked and stance.arrived

        return Job(order, self.uses, begin, cease, over, refused=self.refused)

    def _in_the_way(self) -> str:
        """Return the name of the thing that the robot would walk into, or an empty text."""
        heading = self.parts.stance.bound
        if heading is None:
            return ""
        here = self.parts.body.torso().position
        there = (here[0] + AHEAD * math.cos(heading), here[1] + AHEAD * math.sin(heading))
        near, thing = self.parts.stage.nearest([(*there, z) for z in HEIGHTS])
        if near >= CLEAR:
            return ""
        now, _ = self.parts.stage.nearest([(float(here[0]), float(here[1]), z) for z in HEIGHTS])
        return thing if near < now or near == 0.0 else ""
