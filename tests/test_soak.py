"""What is too long for every day: `make soak`."""

from __future__ import annotations

import random
import resource
import subprocess
import time

import pytest

from rrp_sheets import api
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.values import Failure, record_from_mapping
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunView

pytestmark = pytest.mark.soak

WORDS = [
    *"()[]{}.,:+-*/%<>=", " ", "**", "==", " and ", " or ", "not ", " if ", " else ", " for q in ", "x", "q", "ball.x",
    "balls", "name", "1", "0", "9**9", "1e15", "999", "'a'", "[1]", "range(999)", "sum(", "IF(", "max(", "sorted(",
    "f'{x}'", "None", "TRUE", "concat(", "str(", "sqrt(", "IFERROR(", "balls[0:2]", "[q for q in range(999)]", "*999",
]  # fmt: skip


def test_three_hundred_thousand_random_formulas():
    ball = record_from_mapping("ball", {"x": 3.0, "colour": "red"})
    inputs = {"ball": ball, "x": 5, "balls": [1, 2, 3], "name": "Kim"}
    scope = make_scope([(n, getattr(v, "type", None)) for n, v in inputs.items()])
    interpreter = GuardedInterpreter()
    chance = random.Random(7)
    counts = {"ok": 0, "error": 0, "rejected": 0}
    slowest = 0.0
    for _ in range(300_000):
        text = "".join(chance.choice(WORDS) for _ in range(chance.randint(1, 14)))
        began = time.perf_counter()
        try:
            result = compile_formula(text, scope).prepare(interpreter)(*inputs.values())
            assert not isinstance(result, Failure) or result.code != "FORM109", text
            counts["error" if isinstance(result, Failure) else "ok"] += 1
        except FormulaProblem as problem:
            assert problem.message and problem.remedy
            counts["rejected"] += 1
        slowest = max(slowest, time.perf_counter() - began)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"\n{counts}, slowest {slowest * 1000:.0f} ms, peak memory {peak:.0f} MB")
    assert counts["ok"] > 5_000 and slowest < 1 and peak < 500
    assert inputs["balls"] == [1, 2, 3]


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
