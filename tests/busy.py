"""How busy the machine is with other things, for limits of wall-clock time."""

from __future__ import annotations

import os


def crowded() -> float:
    """By what a limit is multiplied, as others are at work on this machine; 1 when there is a core for everyone."""
    return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1)) if hasattr(os, "getloadavg") else 1.0
