"""How hard somebody pushes, and which way."""

from __future__ import annotations

import math
from collections.abc import Mapping

from rrp_sheets.model.values import Value

FORCES = {"gently": 11.0, "": 13.0, "hard": 40.0}  # N; from about 15 N the robot falls
_FROM = {"front": math.pi, "behind": 0.0, "left": -math.pi / 2, "right": math.pi / 2}  # which way it goes, rad


def force(values: Mapping[str, Value], yaw: float) -> tuple[float, float, float]:
    """The force of a push (N, in the world), from a side of a robot that is turned by `yaw` (rad).

    >>> [round(f) for f in force({"from": "behind", "how": "hard"}, 0.0)]
    [40, 0, 0]
    """
    newtons = FORCES[str(values.get("how") or "")]
    way = yaw + _FROM[str(values.get("from") or "front")]
    return newtons * math.cos(way), newtons * math.sin(way), 0.0
