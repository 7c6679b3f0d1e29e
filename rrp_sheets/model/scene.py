"""What happens in the simulated world, understood: the actions of a Scene sheet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.model.values import Value


@dataclass(frozen=True, slots=True)
class SceneAction:
    """One thing that happens at one time.

    Attributes:
        time_us: on the run's clock, microseconds.
        thing: the thing's name as shown ("Red ball", "Person").
        verb: `appear`, `move`, `circle`, `disappear`, `seen`, … (the grammar in `devices/scene.py` lists them).
        values: what the verb needs: positions in m (robot's starting frame, x forward, y left, z up), durations in s.
        row: the Scene row, for messages.
    """

    time_us: int
    thing: str
    verb: str
    values: Mapping[str, Value] = field(default_factory=dict)
    row: int = 0
