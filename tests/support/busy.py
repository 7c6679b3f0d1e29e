"""Factors for limits of time, from the load and the speed of the machine, and measured spans that have such a limit."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LOOP_SECONDS = 0.045  # of processor time, for `_loop` on the machine on which the limits were set
MOST_STRETCHED = 10.0
"""The most by which waiting stretches a limit; the share of time in which somebody waits does not tell how many wait."""


class Span:
    """A span of time that begins now, and how crowded the machine is in it."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self._crowded = crowded()
        self._waited = _pressure()[1]

    def seconds(self) -> float:
        """Seconds since it began."""
        return time.monotonic() - self.began

    def crowded(self) -> float:
        """By what a limit of the span until now is multiplied: the load of the last minute comes late."""
        waited = _pressure()[1] - self._waited
        self._crowded = max(self._crowded, crowded(), _stretched(waited / max(self.seconds(), 0.001)))
        return self._crowded


@contextmanager
def within(seconds: float) -> Iterator[Span]:
    """Assert that what is done takes less than some seconds, or accordingly longer on a crowded machine."""
    span = Span()
    yield span
    took = span.seconds()
    assert took < seconds * span.crowded(), f"{took:.2f} s, on a machine crowded {span.crowded():.1f} times"


@contextmanager
def work_within(seconds: float, about: object = "") -> Iterator[None]:
    """Assert that what is done takes less than some seconds of processor time, or accordingly longer on a slow machine."""
    began = time.process_time()
    yield
    took = time.process_time() - began
    assert took < seconds or took < seconds * slowness(), f"{took:.2f} s of processor time {about}"


def crowded() -> float:
    """By what a limit is multiplied, as others are at work on this machine; 1 when there is a core for everyone."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    tasks = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    with suppress(OSError):  # Linux tells those of this moment, too
        tasks = max(tasks, int(Path("/proc/loadavg").read_text().split()[3].partition("/")[0]))
    return max(1.0, tasks / cores, _stretched(_pressure()[0]))


def slowness() -> float:
    """By what a limit of processor time is multiplied on a slower machine; at least 1."""
    return max(1.0, _loop() / LOOP_SECONDS)


def _stretched(share: float) -> float:
    """Return the factor for work that goes on only while nobody waits for a core.

    Args:
        share: of the time in which somebody does.
    """
    return 1 / max(1 - share, 1 / MOST_STRETCHED)


def _pressure() -> tuple[float, float]:
    """The share of the last ten seconds in which somebody waited for a core, and the sum of all such seconds."""
    try:
        some = dict(part.split("=") for part in Path("/proc/pressure/cpu").read_text().splitlines()[0].split()[1:])
    except OSError:  # not Linux, or a kernel that does not count it
        return 0.0, 0.0
    return float(some["avg10"]) / 100, float(some["total"]) / 1_000_000


def _loop() -> float:
    began = time.process_time()
    found: dict[int, str] = {}
    for number in range(300_000):
        found[number % 1000] = str(number)
    return time.process_time() - began
