"""Speed of the simulated robot beside real time while it follows a ball (faces: `bench_senses.py`).

Measured: the engine's door (`SimulatedWorld`) with the simulator's process, both pinned to one core, 240 Hz physics, the
head camera at 320×240; with film also the three pictures a second from outside. Not measured: starting and stopping
(the film is written then), the behaviour's rows and their trace (`bench_engine.py`), speech, an idle second core.
"""

from __future__ import annotations

import pytest
from onecore import go, one_core

from rrp_sheets.model.exchange import DeviceUse, SceneAction
from rrp_sheets.sim.world import PICTURE

LIMIT = 4.0  # times real time
MOST_MEMORY = 600.0  # MB, of the simulator's process
BALL = DeviceUse("ball", "Red ball", "RedBall", {"rate": 10})
BALL_SCENE = (
    SceneAction(0, "Red ball", "appear", {"at": (0.8, 0.0, 0.4), "size": 0.06, "colour": "red"}),
    SceneAction(1_000_000, "Red ball", "circle", {"radius": 0.3, "period": 4.0}),
)
AROUND_SCENE = (
    BALL_SCENE[0],
    SceneAction(1_000_000, "Red ball", "circle", {"radius": 0.8, "period": 20.0, "around": (0, 0, 0.4), "flat": True}),
)
CASES = {
    "head tracking, ball circles before it": (BALL, "Head", BALL_SCENE),
    "whole-body tracking, ball circles before it": (BALL, "Whole body", BALL_SCENE),
    "whole-body tracking, ball goes all around": (BALL, "Whole body", AROUND_SCENE),
}


@pytest.mark.parametrize("case", CASES)
def test_faster_than_real_time(case: str) -> None:
    with one_core() as where:
        bare, filmed = (go(*CASES[case], film=film) for film in (False, True))
    size = "×".join(map(str, PICTURE))
    print(
        f"\n{case} ({size}, {where}): {bare.ratio:.1f}× real time, {filmed.ratio:.1f}× with film (limit {LIMIT:g}×); "
        f"{filmed.megabytes:.0f} MB (limit {MOST_MEMORY:g})"
    )
    assert bare.ratio >= LIMIT
    assert filmed.megabytes < MOST_MEMORY
