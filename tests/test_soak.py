"""What is too long for every day: `make soak`."""

from __future__ import annotations

import subprocess

import pytest

from rrp_sheets import api
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunView

pytestmark = pytest.mark.soak


class Memory(RunView):
    """Takes down how much memory (MB) the simulator's process holds after whole minutes of the run's clock."""

    def __init__(self, worlds):
        self.worlds, self.held = worlds, {}

    def frame(self, us):
        minute = us // 60_000_000
        if minute and minute not in self.held:
            shown = subprocess.run(["ps", "-o", "rss=", "-p", str(self.worlds[0].pid)], capture_output=True, check=True)
            self.held[minute] = int(shown.stdout) / 1024


def test_ten_simulated_minutes_do_not_grow_the_simulator(tmp_path, monkeypatch):
    worlds = []

    class Known(SimulatedWorld):
        def __init__(self, *arguments, **settings):
            super().__init__(*arguments, **settings)
            worlds.append(self)

    monkeypatch.setattr("rrp_sheets.drivers.simulated.SimulatedWorld", Known)
    memory = Memory(worlds)
    _, result = api.run(
        bundled("workbooks", "complex-tracking.xlsx"),
        api.RunSettings(seconds=600.1, fast=True, out=tmp_path / "o", film=False), memory,
    )  # fmt: skip
    assert result is not None and result.broken is None and result.summary.simulated >= 600
    print("\nsimulator, MB by minute:", {minute: round(held) for minute, held in memory.held.items()})
    assert memory.held[10] - memory.held[1] < 50
