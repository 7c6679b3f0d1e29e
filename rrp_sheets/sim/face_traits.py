"""Traits of a drawn face, in numbers, and the shape of a head. Light to import: the browser's view uses it too."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rrp_sheets.sim.colours import RGB

HEAD = 0.105  # m, half of its height
RINGS, AROUND = 22, 32
FRONT, BACK = 0.86, 0.95  # depth before and behind the ears, in half heights
NOSE = (0.13, -0.20, 0.10, 0.15)  # how far it sticks out, its height, half width and half height, in half heights
# Hair: centre (x, z) and radii (x, y as a part of the head's width, z), in half heights.
HAIR: dict[str, list[tuple[float, float, float, float, float]]] = {
    "short": [(-0.20, 0.14, 0.86, 1.05, 0.93)],
    "curly": [(-0.22, 0.22, 0.98, 1.20, 1.00)],
    "bob": [(-0.20, 0.14, 0.86, 1.08, 0.93), (-0.36, -0.22, 0.60, 1.18, 0.80)],
    "long": [(-0.20, 0.14, 0.86, 1.06, 0.93), (-0.42, -0.55, 0.52, 1.12, 1.20)],
    "tail": [(-0.20, 0.14, 0.86, 1.05, 0.93), (-1.10, 0.20, 0.26, 0.34, 0.30)],
    "bald": [],
}
_CHEEKS, _MOUTH = 0.1, -0.55  # heights at which a head is widest, and at which `jaw` is its width


@dataclass(frozen=True)
class Traits:
    """Measures and colours of a drawn face.

    Lengths are parts of half the head's height; the origin is the middle of the face, x to the right of who looks at
    it, y up. Colours are 0 to 1.

    Attributes:
        width, jaw: half widths at the cheeks and at the mouth; chin: 0.4 is broad, 0.7 pointed.
        eyes: (half distance, height, half width, opening, slant).
        brows: (height above the eyes, thickness, arch, slant).
        nose: (lower end's height, half width, how strong its shadow is).
        mouth: (height, half width, upper lip, lower lip, smile).
        style: of the hair: `short`, `bob`, `long`, `curly`, `bald`, `tail`.
        hairline: height at the middle; `parting` lifts it to one side, `fringe` is how ragged it is.
        glasses: `round`, `square` or empty.
        beard: 0 to 1; moustache: 0 to 1.
        lines: of age, 0 to 1; freckles: 0 to 1; rosy: cheeks, 0 to 1.
    """

    skin: RGB
    hair: RGB
    iris: RGB
    lips: RGB
    width: float = 0.78
    jaw: float = 0.62
    chin: float = 0.55
    eyes: tuple[float, float, float, float, float] = (0.33, 0.04, 0.165, 0.075, 0.0)
    brows: tuple[float, float, float, float] = (0.17, 0.03, 0.04, 0.0)
    nose: tuple[float, float, float] = (-0.27, 0.13, 1.0)
    mouth: tuple[float, float, float, float, float] = (-0.52, 0.24, 0.045, 0.065, 0.03)
    style: str = "short"
    hairline: float = 0.55
    parting: float = 0.0
    fringe: float = 0.02
    glasses: str = ""
    beard: float = 0.0
    moustache: float = 0.0
    lines: float = 0.0
    freckles: float = 0.0
    rosy: float = 0.3


def outline(traits: Traits, height: float) -> float:
    """Return half the width of the head at a height (-1 to 1).

    >>> face = Traits((1, 1, 1), (0, 0, 0), (0, 0, 0), (1, 0, 0))
    >>> outline(face, 1.0), outline(face, 0.1) > outline(face, -0.6) > outline(face, -0.95)
    (0.0, True)
    """
    if abs(height) >= 1:
        return 0.0
    if height >= _CHEEKS:
        return traits.width * math.sqrt(1 - ((height - _CHEEKS) / (1 - _CHEEKS)) ** 2)
    # A curve through the jaw's width at the mouth; the chin says how it closes below.
    down = (_CHEEKS - height) / (1 + _CHEEKS)
    power = math.log(1 - (traits.jaw / traits.width) ** (1 / traits.chin)) / math.log(
        (_CHEEKS - _MOUTH) / (1 + _CHEEKS)
    )
    return float(traits.width * (1 - down**power) ** traits.chin)
