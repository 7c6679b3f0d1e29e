"""Tests that are too long for every day: `make soak`."""

from __future__ import annotations

import os
import subprocess

import pytest

from rrp_sheets import api
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.engine.run_events import RunObserver

pytestmark = pytest.mark.soak


class Memory(RunObserver):
    """Takes down how much memory (MB) the simulator's process holds after whole minutes of the run's clock."""

    def __init__(self, worlds):
        self.worlds, self.held = worlds, {}

    def frame(self, us):
        minute = us // 60_000_000
        if minute and minute not in self.held:
            shown = subprocess.run(["ps", "-o", "rss=", "-p", str(self.worlds[0].pid)], capture_output=True, check=True)
            self.held[minute] = int(shown.stdout) / 1024


BOOK = """
# Busy
## Behaviour
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | subscribe | | Follow |
| Every 11 s | subscribe | | Speak |
| Every 17 s | subscribe | | Wave |
| Every 40 s | subscribe | | Turn |
| Face | filter | face.new | New face |
| New face | subscribe | | Remember |
## Devices
| Stream | Device | Every | Text | Name | Turn | Rate | Mode |
|---|---|---|---|---|---|---|---|
| Red ball | Red ball | | | | | | |
| Follow | Tracker | | | | | | Head |
| Face | Face detection | | | | | 2 | |
| Every 11 s | Timer | 11 s | | | | | |
| Every 17 s | Timer | 17 s | | | | | |
| Every 40 s | Timer | 40 s | | | | | |
| Speak | Say parameter | | I have been here for a long time. | | | | |
| Wave | Gesture | | | Wave | | | |
| Turn | Walk | | | | 360° | | |
| Remember | Remember face | | | | | | |
## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0 | Red ball | appears | at 0.8, 0, 0.45 |
| 0 | Red ball | circles | radius 0.3 period 6 s |
| 2 | Anna | enters | at 1.2, 0.3, 0.6 |
"""
MINUTES = int(os.environ.get("SOAK_MINUTES", "30"))  # of the run's clock


def test_a_busy_half_hour_does_not_grow_the_simulator(tmp_path, monkeypatch):
    worlds = []

    class Known(SimulatedWorld):
        def __init__(self, *arguments, **settings):
            super().__init__(*arguments, **settings)
            worlds.append(self)

    monkeypatch.setattr("rrp_sheets.drivers.simulated.SimulatedWorld", Known)
    memory = Memory(worlds)
    (tmp_path / "busy.md").write_text(BOOK)
    settings = api.RunSettings(seconds=60 * MINUTES + 0.1, fast=True, out=tmp_path / "o", film=False)
    _, result = api.run(tmp_path / "busy.md", settings, memory)
    assert result is not None and result.broken is None and result.summary.simulated >= 60 * MINUTES
    done = result.summary.commands
    assert all(done[name] >= MINUTES for name in ("Follow", "Speak", "Wave", "Turn"))
    print("\nsimulator, MB by minute:", {minute: round(held) for minute, held in memory.held.items()})
    assert memory.held[MINUTES] - memory.held[1] < 50
    assert max(memory.held.values()) < 600
