"""What rests against the robot's hands, feet and head: a touch by contact, without anybody touching.

Where the robot feels is in the catalogue: points of its links, each with the zone that it belongs to.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rrp_sheets.sim.body import Body
from rrp_sheets.sim.stage import Stage

EVERY = 8  # physics steps between two looks: 30 a second
REACH = 1.0  # m from the torso: farther away nothing touches


class Contacts:
    """Looks which zones something rests against."""

    def __init__(self, body: Body, stage: Stage) -> None:
        self._body, self._stage = body, stage
        self._pads: list[dict[str, Any]] = body.robot.data["touch"].get("pads", [])

    def due(self, step: int) -> bool:
        """Whether to look at this step; nothing in the room, nothing to look for."""
        return step % EVERY == 0 and self._stage.has_solids

    def zones(self) -> frozenset[str]:
        """The zones in contact now."""
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
