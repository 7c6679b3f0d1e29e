"""Factors for limits of time, from the load and the speed of the machine."""

from __future__ import annotations

import os
import time

LOOP_SECONDS = 0.045  # of processor time, for `_loop` on the machine on which the limits were set


def crowded() -> float:
    """By what a limit is multiplied, as others are at work on this machine; 1 when there is a core for everyone."""
    return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1)) if hasattr(os, "getloadavg") else 1.0


def slowness() -> float:
    """By what a limit of processor time is multiplied on a slower machine; at least 1."""
    return max(1.0, _loop() / LOOP_SECONDS)


def _loop() -> float:
    began = time.process_time()
    found: dict[int, str] = {}
    for number in range(300_000):
        found[number % 1000] = str(number)
    return time.process_time() - began
