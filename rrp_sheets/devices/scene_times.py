"""The Time cells of the Scene sheet: of the run, after the row above, or after an event of a stream."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rrp_sheets.devices.scene_amounts import plain, span
from rrp_sheets.model.scene import ROW_ABOVE

_AFTER = re.compile(r"(.*?)\s*\+\s*([^+]*)", re.DOTALL)


@dataclass(frozen=True)
class When:
    """When something happens.

    Attributes:
        us: on the run's clock, or after what it waits for, microseconds.
        span_us: how much later it may be.
        cue: what it waits for: a stream as it is named in the cell, `+` for the row above, empty for nothing.
    """

    us: int
    span_us: int = 0
    cue: str = ""


def read_time(text: str) -> When | None:
    """What a Time cell says; None when it is no time. Whether there is such a stream is not known here.

    >>> read_time("2.5"), read_time("2..4 s")
    (When(us=2500000, span_us=0, cue=''), When(us=2000000, span_us=2000000, cue=''))
    >>> read_time("Ask done + 2"), read_time("+ 500 ms"), read_time("soon")
    (When(us=2000000, span_us=0, cue='Ask done'), When(us=500000, span_us=0, cue='+'), None)
    """
    text = plain(text)
    after = _AFTER.fullmatch(text)
    times = span(after[2] if after else text)
    if times is None:
        return None
    return When(times[0], times[1] - times[0], (after[1] or ROW_ABOVE) if after else "")
