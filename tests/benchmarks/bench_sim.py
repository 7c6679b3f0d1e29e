"""How fast the simulator is: `python tests/benchmarks/bench_sim.py`. Prints real-time factors on one core."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from rrp_sheets.devices import load_robot
from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.runtime.ports import Command, DeviceUse

SECONDS, RATE = 20, 30
BALL = DeviceUse("ball", "Red ball", "RedBall", {"rate": 10})
FACE = DeviceUse("face", "Face", "FaceDetection", {"rate": 2})
BALL_SCENE = (
    SceneAction(0, "Red ball", "appear", {"at": (0.8, 0.0, 0.4), "size": 0.06, "colour": "red"}),
    SceneAction(1_000_000, "Red ball", "circle", {"radius": 0.3, "period": 4.0}),
)
PERSON_SCENE = (SceneAction(0, "Person", "seen", {"id": 1, "name": "", "seconds": 60.0}),)


def factor(sensor: DeviceUse, mode: str, scene: tuple[SceneAction, ...], film: bool) -> float:
    """Simulated seconds per second, the start and the stop not counted."""
    tracker = DeviceUse("tracker", "Tracker", "Tracker", {"mode": mode, "effector": "None"})
    with tempfile.TemporaryDirectory() as folder:
        world = SimulatedWorld(load_robot(), (sensor,), (tracker,), scene, out=Path(folder), film=film)
        arrivals = world.start()
        before = time.perf_counter()
        for frame in range(1, SECONDS * RATE + 1):
            orders = [Command("tracker", True, "Bench!1", (sensor.stream,)) for _ in arrivals.events]
            arrivals = world.advance(frame * 1_000_000 // RATE, orders)
        passed = time.perf_counter() - before
        world.stop()
    return SECONDS / passed


def main() -> None:
    """Print the table."""
    print("| What | without film | with film |\n|---|---|---|")
    for name, sensor, mode, scene in (
        ("Head tracking, camera 320×240 at 10 Hz", BALL, "Head", BALL_SCENE),
        ("Whole body tracking", BALL, "Whole body", BALL_SCENE),
        ("A person in view, faces at 2 Hz", FACE, "Head", PERSON_SCENE),
    ):
        print(f"| {name} | {factor(sensor, mode, scene, False):.1f} | {factor(sensor, mode, scene, True):.1f} |")


if __name__ == "__main__":
    main()
