"""Bodies of persons, seated on the floor or standing; `heads` adds the head.

A body looks along the figure's x. Its measures follow from the height of the face alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rrp_sheets.sim.colours import RGB
from rrp_sheets.sim.face_traits import HEAD
from rrp_sheets.sim.figures import CompoundShape, ellipsoid, turned

STANDS_ABOVE = 0.85  # m: a face higher than that belongs to somebody who stands
NECK = 1.1 * HEAD  # m, from the middle of the face down to the top of the neck
TROUSERS: tuple[RGB, ...] = ((0.44, 0.46, 0.52), (0.50, 0.46, 0.42), (0.40, 0.44, 0.44), (0.52, 0.50, 0.54))
SHOE: RGB = (0.34, 0.33, 0.33)
"""Pale or grey, as clothes are: none is taken for a ball."""
Spot = tuple[float, float, float]
Colours = tuple[RGB, RGB, RGB]
"""Of shirt, trousers and skin."""


def is_seated(face: float, posture: str) -> bool:
    """Return whether a person sits; without a posture the height of the face decides.

    >>> is_seated(0.62, ""), is_seated(1.5, ""), is_seated(0.62, "standing")
    (True, False, False)
    """
    return posture == "seated" or (not posture and face < STANDS_ABOVE)


def body(bullet: Any, figure: CompoundShape, clothes: RGB, skin: RGB, face: float, posture: str = "") -> None:
    """Add a body to a figure.

    Args:
        bullet: the physics.
        figure: takes its parts.
        clothes: the colour of the shirt.
        skin: of the hands and the neck.
        face: the height of the middle of the face, m.
        posture: `seated` or `standing`; empty as the height tells.
    """
    trousers = TROUSERS[int(100 * clothes[0]) % len(TROUSERS)]
    if is_seated(face, posture):
        _sit(bullet, figure, (clothes, trousers, skin), face - NECK)
    else:
        _stand(bullet, figure, (clothes, trousers, skin), face - NECK)


def _sit(bullet: Any, figure: CompoundShape, colours: Colours, neck: float) -> None:
    """Add a body that sits cross-legged, the hands on the knees."""
    trousers = colours[1]
    wide = 0.27 * neck + 0.02
    _torso(bullet, figure, colours, 0.02, neck, wide)
    thick = 0.105 * neck + 0.01
    for side in (1.0, -1.0):
        hip, knee = (-0.02, side * 0.55 * wide, thick), (0.44 * neck, side * 1.35 * wide, thick * 1.05)
        ankle = (0.36 * neck, -side * 0.30 * wide, thick * 0.72)
        limb(bullet, figure, hip, knee, thick * 1.15, thick * 0.92, trousers)
        limb(bullet, figure, knee, ankle, thick * 0.85, thick * 0.62, trousers)
        foot = (ankle[0], -side * 0.55 * wide, 0.04)
        figure.add(ellipsoid(bullet, (0.10 * neck, 0.06 * neck, 0.05 * neck), SHOE), foot)
        shoulder, elbow = (0.0, side * 0.88 * wide, neck * 0.84), (0.10 * neck, side * 1.18 * wide, neck * 0.46)
        _arm(bullet, figure, colours, shoulder, elbow, (0.40 * neck, side * 1.10 * wide, neck * 0.33), neck)


def _stand(bullet: Any, figure: CompoundShape, colours: Colours, neck: float) -> None:
    """Add a body that stands upright, the arms hanging."""
    trousers = colours[1]
    wide, hips = 0.115 * neck + 0.045, 0.55 * neck
    _torso(bullet, figure, colours, hips - 0.04 * neck, neck, wide)
    for side in (1.0, -1.0):
        thick = 0.052 * neck + 0.012
        hip, knee, ankle = ((0.0, side * 0.50 * wide, h) for h in (hips, 0.29 * neck, 0.05 * neck))
        limb(bullet, figure, hip, knee, thick * 1.15, thick * 0.88, trousers)
        limb(bullet, figure, knee, ankle, thick * 0.86, thick * 0.66, trousers)
        figure.add(ellipsoid(bullet, (0.075 * neck, 0.035 * neck, 0.030 * neck), SHOE),
                   (0.03 * neck, side * 0.52 * wide, 0.030 * neck))  # fmt: skip
        shoulder, elbow = (0.0, side * 0.92 * wide, neck * 0.91), (-0.01 * neck, side * 1.22 * wide, neck * 0.70)
        _arm(bullet, figure, colours, shoulder, elbow, (0.04 * neck, side * 1.24 * wide, neck * 0.51), 0.62 * neck)


def _torso(bullet: Any, figure: CompoundShape, colours: Colours, low: float, neck: float, wide: float) -> None:
    """Add a torso from the hips to the neck, flatter than wide."""
    tall = neck - low
    outline = [
        (0.0, 0.0), (wide * 0.80, 0.01), (wide * 0.90, tall * 0.06), (wide * 0.84, tall * 0.25),
        (wide * 0.80, tall * 0.42), (wide * 0.90, tall * 0.66), (wide * 0.94, tall * 0.80),
        (wide * 0.82, tall * 0.89), (wide * 0.46, tall * 0.955),
        (0.042, tall * 0.98), (0.0, tall * 0.98),
    ]  # fmt: skip
    figure.add(turned(bullet, outline, colours[0], (0.68, 1.0)), (0, 0, low))


def _arm(
    bullet: Any, figure: CompoundShape, colours: Colours, shoulder: Spot, elbow: Spot, hand: Spot, size: float
) -> None:
    thick = 0.058 * size + 0.008
    limb(bullet, figure, shoulder, elbow, thick, thick * 0.86, colours[0])
    limb(bullet, figure, elbow, hand, thick * 0.80, thick * 0.62, colours[2])
    figure.add(ellipsoid(bullet, (thick * 0.85, thick * 0.75, thick * 1.0), colours[2]), hand)


def limb(bullet: Any, figure: CompoundShape, start: Spot, end: Spot, thick: float, thin: float, colour: RGB) -> None:
    """Add a round part of an arm or a leg between two places, `thick` (radius, m) here and `thin` there."""
    long = math.dist(start, end)
    outline = [(0.0, -thick * 0.9), (thick * 0.70, -thick * 0.6), (thick, 0.0), (thin, long),
               (thin * 0.70, long + thin * 0.6), (0.0, long + thin * 0.9)]  # fmt: skip
    along = [(e - s) / long for s, e in zip(start, end, strict=True)]
    figure.add(turned(bullet, outline, colour, around=12), start, _upright_to(along))


def _upright_to(way: Sequence[float]) -> Spot | tuple[float, float, float, float]:
    """Return the rotation (a quaternion) that turns z into a direction."""
    x, y, z = way
    if z < -0.999999:  # upside down: any axis across
        return 1.0, 0.0, 0.0, 0.0
    half = math.sqrt((1 + z) / 2)
    return -y / (2 * half), x / (2 * half), 0.0, half
