"""Film strips of every gesture and posture, to be looked at: `make strips`, or `python tests/benchmarks/strips.py OUT [NAME …]`.

One PNG each: the simulated robot from the front left and, below, from its side, at eight moments.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from PIL import Image, ImageDraw

from rrp_sheets.devices import load_robot
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.sim.camera import FilmCamera
from rrp_sheets.sim.messages import Spec
from rrp_sheets.sim.strip import font_of
from rrp_sheets.sim.world import STEPS_A_SECOND, SimWorld

MOMENTS, TILE = 8, (230, 250)
BOX = [(x, y, z) for x in (-0.2, 0.25) for y in (-0.25, 0.25) for z in (0.0, 0.66)]
LYING = [(x, y, z) for x in (-0.35, 0.45) for y in (-0.3, 0.3) for z in (0.0, 0.6)]
LONGEST = 20.0  # s


def strip(device: str, name: str, out: Path, before: str = "") -> None:
    """One gesture or posture; `before`: a posture to take first."""
    robot = load_robot()
    uses = [DeviceUse("a", name, device, robot.devices[device.casefold()].with_defaults({"name": name}))]
    if before:
        uses.append(DeviceUse("b", before, "Posture", robot.devices["posture"].with_defaults({"name": before})))
    world = SimWorld(Spec(robot, actuators=tuple(uses), dones={"a": "adone", "b": "bdone"}))
    world.start()
    frame = 0

    def until(stream: str) -> float:
        nonlocal frame
        began = frame
        orders = [Command(stream, True, "Strip!2")]
        while True:
            frame += 1
            outcome = world.advance(frame * 1_000_000 // 30, orders)
            orders = []
            for note in outcome.notices:
                print(f"{name}: {note.kind} {note.text}")
            shots.append([camera.shoot([]) for camera in cameras] if stream == "a" and frame % 2 else None)
            for done, value in outcome.events:
                if done == f"{stream}done":
                    print(f"{name}: {value['seconds']:.2f} s, completed {value['completed']}")
                    return (frame - began) / 30
            if frame > LONGEST * 30:
                print(f"{name}: NOT OVER after {LONGEST} s")
                return LONGEST

    shots: list = []
    cameras = [FilmCamera(world._b, BOX if device == "Gesture" else LYING, [math.radians(a)], TILE) for a in (-32, -88)]
    if before:
        until("b")
        shots.clear()
    until("a")
    taken = [s for s in shots if s]
    chosen = [taken[round(k * (len(taken) - 1) / (MOMENTS - 1))] for k in range(MOMENTS)]
    sheet = Image.new("RGB", (MOMENTS * TILE[0], 2 * TILE[1] + 30), (255, 255, 255))
    ImageDraw.Draw(sheet).text((8, 4), f"{name}{f', from {before}' if before else ''}", (30, 40, 50), font_of(18, True))
    for k, pair in enumerate(chosen):
        for row, picture in enumerate(pair):
            sheet.paste(Image.fromarray(picture), (k * TILE[0], 30 + row * TILE[1]))
    path = (
        out
        / f"{device.casefold()}-{name.casefold().replace(' ', '-').replace(chr(39), '')}{'-' + before if before else ''}.png"
    )
    sheet.save(path)
    world.close()
    print(path, f"({STEPS_A_SECOND} Hz)")


def main() -> None:
    """Make them all, or those that are named."""
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    robot, wanted = load_robot(), sys.argv[2:]
    for name in robot.gestures:
        if not wanted or name in wanted:
            strip("Gesture", name, out)
    for name in robot.postures:
        if not wanted or name in wanted:
            strip("Posture", name, out)


if __name__ == "__main__":
    main()
