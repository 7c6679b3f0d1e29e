"""Drawings of the robot's model in given poses, as outlines in grey, for print; without physics and display."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from rrp_sheets.perception.pinhole import Lens, Pose
from rrp_sheets.robots import Robot
from rrp_sheets.robots.trajectory import BodyPose
from rrp_sheets.sim.body import Body
from rrp_sheets.sim.camera import FAR, NEAR, viewpoint
from rrp_sheets.sim.world import quiet

WIDTH, HEIGHT = 300, 340  # pixels, of which a drawing keeps the outlines
_FROM = math.radians(-20)  # where the drawings are made from; 0 is ahead of the robot
_LIGHT = (2.0, -0.6, 1.6)
_VFOV = math.radians(30.0)
_STANDING = ((-0.1, -0.25, 0.0), (0.2, 0.25, 0.66))  # m: the least room that a drawing shows
_TONES = ((0, 90), (90, 170), (170, 256))  # greys that are told apart within a part of the robot
_LEAST = 10  # square pixels: what is smaller is left out
_OFF = 0.7  # pixels that an outline may be off


def draw_poses(robot: Robot, strips: Sequence[Sequence[BodyPose]]) -> list[list[str]]:
    """Return the drawings of each strip as SVG texts: at one scale, with the robot's lowest part at one height."""
    with quiet(), quiet(2):  # PyBullet prints when it was built
        import pybullet
        from pybullet_utils.bullet_client import BulletClient  # type: ignore[import-untyped]

        bullet: Any = BulletClient(connection_mode=pybullet.DIRECT)
    bullet.createMultiBody()  # in the floor's place, for which the body asks
    body, made = Body(bullet, robot), dict[str, str]()
    lens = Lens(2 * math.atan(math.tan(_VFOV / 2) * WIDTH / HEIGHT), _VFOV, WIDTH, HEIGHT)
    drawings = []
    for strip in strips:
        room = np.array([*_STANDING, *(corner for pose in strip for corner in _take(bullet, body, pose))])
        (x, y, z), (to_x, to_y, to_z) = room.min(axis=0), room.max(axis=0)
        corners = np.array([(a, b, c) for a in (x, to_x) for b in (y, to_y) for c in (z, to_z)])
        _, camera = viewpoint(corners, _FROM, lens)
        drawn = []
        for pose in strip:
            name = f"{sorted(pose[0].items())} {pose[1]} {corners.tolist()}"
            if name not in made:
                _take(bullet, body, pose)
                made[name] = _drawn(bullet, lens, camera)
            drawn.append(made[name])
        drawings.append(drawn)
    return drawings


def _take(bullet: Any, body: Body, pose: BodyPose) -> tuple[Sequence[float], Sequence[float]]:
    """Put the model into a pose with its lowest part at height 0; return the box around it."""
    joints, lean = pose
    for joint, angle in joints.items():
        bullet.resetJointState(body.id, body.index[joint], angle)
    turned, links, height = bullet.getQuaternionFromEuler([0, lean, 0]), range(-1, len(body.index)), 1.0
    for _ in range(2):
        bullet.resetBasePositionAndOrientation(body.id, [0, 0, height], turned)
        boxes = np.array([bullet.getAABB(body.id, link) for link in links])
        height -= boxes[:, 0, 2].min()
    return boxes[:, 0].min(axis=0).tolist(), boxes[:, 1].max(axis=0).tolist()


def _drawn(bullet: Any, lens: Lens, camera: Pose) -> str:
    """Draw what the camera sees: of each part of the robot the outlines of its greys."""
    ahead = camera.position + camera.rotation[:, 0]
    view = bullet.computeViewMatrix(camera.position.tolist(), ahead.tolist(), camera.rotation[:, 2].tolist())
    projection = bullet.computeProjectionMatrixFOV(math.degrees(lens.vfov), WIDTH / HEIGHT, NEAR, FAR)
    picture = bullet.getCameraImage(
        WIDTH, HEIGHT, view, projection, shadow=0, lightDirection=_LIGHT, lightColor=[1, 1, 1],
        lightAmbientCoeff=0.75, lightDiffuseCoeff=0.35, lightSpecularCoeff=0.0, renderer=bullet.ER_TINY_RENDERER,
        flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
    )  # fmt: skip
    rgba = np.asarray(picture[2], dtype=np.uint8).reshape(HEIGHT, WIDTH, 4)
    grey, parts = cv2.cvtColor(rgba, cv2.COLOR_RGBA2GRAY), np.asarray(picture[4], dtype=np.int64).reshape(HEIGHT, WIDTH)
    paths = []
    for part in np.unique(parts[parts >= 0]):
        for low, high in _TONES:
            mask = (parts == part) & (grey >= low) & (grey < high)
            if mask.sum() < _LEAST:
                continue
            tone = f"{round(float(grey[mask].mean())):02x}"
            found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            for outline in (cv2.approxPolyDP(c, _OFF, True) for c in found if cv2.contourArea(c) >= _LEAST):
                points = " ".join(f"{x},{y}" for ((x, y),) in outline.tolist())
                paths.append(f'<path fill="#{tone * 3}" d="M{points}Z"/>')
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"'
    lines = '<g stroke="#333" stroke-width="1" stroke-linejoin="round">'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{lines}{"".join(paths)}</g></svg>'
