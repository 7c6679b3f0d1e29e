"""Names and kinds of a run's streams, as its pages show them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from rrp_sheets.runs.view import RunStart


@dataclass(frozen=True, slots=True)
class StreamInfo:
    """Name of a stream on the pages, and its kind (sensor, stream, actuator, done or anonymous)."""

    name: str
    kind: str


def known_streams(start: RunStart) -> dict[str, StreamInfo]:
    """Return the streams of a run by their ids.

    The sheet's name is part of a stream's name only when two sheets have a stream of that name.
    """
    plain = Counter(label.partition("!")[2] or label for label in start.streams.values())
    known = {}
    for stream, label in start.streams.items():
        _, _, name = label.partition("!")
        if name.startswith("#"):
            known[stream] = StreamInfo(label, "anonymous")
        elif name:
            known[stream] = StreamInfo(name if plain[name] == 1 else label, "stream")
        else:
            known[stream] = StreamInfo(label, _kind(stream, label, start))
    return known


def _kind(stream: str, label: str, start: RunStart) -> str:
    if stream in start.actuators:
        return "actuator"
    ends = {f"{name} done".casefold() for name in start.actuators.values()}
    return "done" if label.casefold() in ends else "sensor"
