"""Film strips of every gesture, posture, way of walking and tracker, to be looked at: `make strips`.

`python tests/benchmarks/strips.py OUT [NAME …]` makes those that are named.

One PNG each: the simulated robot from the front left and, below, from its side, at eight moments.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from PIL import Image, ImageDraw

from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.camera import FilmCamera
from rrp_sheets.sim.film import font_of
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import STEPS_A_SECOND, SimWorld

MOMENTS, TILE = 8, (230, 250)
BOX = [(x, y, z) for x in (-0.2, 0.25) for y in (-0.25, 0.25) for z in (0.0, 0.66)]
LYING = [(x, y, z) for x in (-0.35, 0.45) for y in (-0.3, 0.3) for z in (0.0, 0.6)]
WIDE = [(x, y, z) for x in (-0.2, 0.45) for y in (-0.1, 0.1) for z in (0.0, 0.58)]
LONGEST = 20.0  # s
WALKS = {
    "forward": {"forward": 0.3}, "backward": {"forward": -0.2}, "sideways": {"left": 0.2}, "turning": {"turn": 1.2},
}  # fmt: skip
TRACKERS = {
    "head": ("Head", "None"), "whole body": ("Whole body", "None"), "left arm": ("Move", "Left arm"),
    "right arm": ("Move", "Right arm"), "both arms": ("Move", "Both arms"), "nearest arm": ("Move", "Nearest arm"),
}  # fmt: skip
BALL = DeviceUse("ball", "Red ball", "RedBall", {"rate": 10})
CIRCLE, TRACKED = (0.6, 0.0, 0.42), 6.0  # m; s


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
    save([s for s in shots if s], out, device, f"{name}{f', from {before}' if before else ''}")
    world.close()


def save(taken: list, out: Path, kind: str, title: str) -> None:
    """Eight of the pairs of pictures, side by side."""
    chosen = [taken[round(k * (len(taken) - 1) / (MOMENTS - 1))] for k in range(MOMENTS)]
    sheet = Image.new("RGB", (MOMENTS * TILE[0], 2 * TILE[1] + 30), (255, 255, 255))
    ImageDraw.Draw(sheet).text((8, 4), f"{kind}: {title}", (30, 40, 50), font_of(18, True))
    for k, pair in enumerate(chosen):
        for row, picture in enumerate(pair):
            sheet.paste(Image.fromarray(picture), (k * TILE[0], 30 + row * TILE[1]))
    path = out / f"{kind}-{title}.png".casefold().replace(" ", "-").replace("'", "").replace(",", "")
    sheet.save(path)
    print(path, f"({STEPS_A_SECOND} Hz)")


def walking(name: str, out: Path) -> None:
    """One way of walking, filmed from where the robot began."""
    robot = load_robot()
    use = DeviceUse("a", name, "Walk", robot.devices["walk"].with_defaults(WALKS[name]))
    world = SimWorld(Spec(robot, actuators=(use,), dones={"a": "adone"}))
    world.start()
    cameras = [FilmCamera(world._b, WIDE, [math.radians(a)], TILE) for a in (-32, -88)]
    taken, over, frame = [], False, 0
    while not over and frame < LONGEST * 30:
        frame += 1
        outcome = world.advance(frame * 1_000_000 // 30, [Command("a", True, "Strip!2")] if frame == 1 else [])
        over = any(done == "adone" for done, _ in outcome.events)
        if frame % 2:
            taken.append([camera.shoot([]) for camera in cameras])
    world.close()
    save(taken, out, "Walk", name)


def tracking(name: str, out: Path) -> None:
    """A tracker, while a ball goes in a circle."""
    mode, effector = TRACKERS[name]
    robot = load_robot()
    uses = (
        DeviceUse(
            "t", "Tracker", "Tracker", robot.devices["tracker"].with_defaults({"mode": mode, "effector": effector})
        ),
        DeviceUse("h", "Head", "Tracker", robot.devices["tracker"].with_defaults({"mode": "Head", "effector": "None"})),
    )
    scene = (
        SceneAction(0, "Red ball", "appear", {"at": CIRCLE, "size": 0.06, "colour": "red"}),
        SceneAction(500_000, "Red ball", "circle", {"radius": 0.2, "period": 5.0, "around": CIRCLE}),
    )
    world = SimWorld(Spec(robot, (BALL,), uses, scene))
    events = world.start().events
    cameras = [FilmCamera(world._b, WIDE, [math.radians(a)], TILE) for a in (-52, -88)]
    taken = []
    for frame in range(1, round(TRACKED * 30) + 1):
        orders = [
            Command(stream, True, "Strip!2", ("ball",)) for _ in events for stream in ("th" if mode == "Move" else "t")
        ]
        events = world.advance(frame * 1_000_000 // 30, orders).events
        if frame % 2:
            taken.append([camera.shoot([]) for camera in cameras])
    world.close()
    save(taken, out, "Tracker", name)


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
    for table, make in ((WALKS, walking), (TRACKERS, tracking)):
        for name in table:
            if not wanted or name in wanted:
                make(name, out)


if __name__ == "__main__":
    main()
