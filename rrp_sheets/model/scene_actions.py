"""Actions of a Scene sheet, understood: the events of the simulated world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.model.values import Value

ROW_ABOVE = "+"
"""The cue of a row whose time counts from the row above it."""


@dataclass(frozen=True, slots=True)
class RandomRange:
    """A number that each run draws anew: `0.4..0.6`.

    >>> print(RandomRange(0.4, 0.6))
    0.4..0.6
    """

    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.low:g}..{self.high:g}"


@dataclass(frozen=True, slots=True)
class SceneAction:
    """One thing that happens at one time.

    Attributes:
        time_us: on the run's clock, microseconds; with a cue: after that.
        thing: the thing's name as shown ("Red ball", "Person").
        verb: `appear`, `move`, `circle`, `disappear`, `seen`, … (the tables in `devices/scene_words.py` list them).
        values: what the verb needs: positions in m (robot's starting frame, x forward, y left, z up), durations in s;
            numbers may be ranges until the run draws them.
        row: the Scene row, for messages.
        kind: of the thing: `ball`, `cup`, `person`, …; empty where the values tell.
        cue: the id of the stream whose next event it waits for, `+` for the row above, empty for a time of the run.
        span_us: how much later than `time_us` it may be: a range that the run draws.
    """

    time_us: int
    thing: str
    verb: str
    values: Mapping[str, Value] = field(default_factory=dict)
    row: int = 0
    kind: str = ""
    cue: str = ""
    span_us: int = 0

    @property
    def what(self) -> str:
        """The kind of the thing, also where only the values tell: a ball has a size."""
        return self.kind or ("ball" if "size" in self.values else "person")
