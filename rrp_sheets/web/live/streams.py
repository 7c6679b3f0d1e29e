"""The streams of a run as its pages name them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from rrp_sheets.runs.view import RunStart


@dataclass(frozen=True, slots=True)
class StreamInfo:
    """A stream: its name on the pages, and what it is (sensor, stream, actuator, done or anonymous)."""

    name: str
    kind: str


def known_streams(start: RunStart) -> dict[str, StreamInfo]:
    """The streams of a run by their ids.

    A stream of a sheet has its plain name, with the sheet's only when two sheets have one of that name.
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
