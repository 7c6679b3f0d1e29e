"""Appearance of what is drawn: colours as users write them, traits of faces, and people, who do not exist.

Light to import: the browser's view uses it too.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value

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


RGB = tuple[float, float, float]
COLOURS: dict[str, RGB] = {
    "white": (1.0, 1.0, 1.0), "black": (0.0, 0.0, 0.0), "off": (0.0, 0.0, 0.0),
    "grey": (0.5, 0.5, 0.5), "gray": (0.5, 0.5, 0.5),
    "red": (1.0, 0.0, 0.0), "green": (0.0, 1.0, 0.0), "blue": (0.0, 0.0, 1.0),
    "yellow": (1.0, 1.0, 0.0), "orange": (1.0, 0.5, 0.0), "pink": (1.0, 0.4, 0.7),
    "purple": (0.6, 0.0, 0.8), "violet": (0.5, 0.0, 1.0), "magenta": (1.0, 0.0, 1.0),
    "cyan": (0.0, 1.0, 1.0), "turquoise": (0.1, 0.8, 0.7), "brown": (0.5, 0.3, 0.1),
    "light blue": (0.5, 0.8, 1.0), "light green": (0.5, 1.0, 0.5), "dark blue": (0.0, 0.0, 0.5),
    "dark green": (0.0, 0.4, 0.0), "dark red": (0.5, 0.0, 0.0),
}  # fmt: skip
BALL_COLOURS: dict[str, RGB] = {"red": (0.90, 0.05, 0.05), "green": (0.05, 0.65, 0.12), "blue": (0.08, 0.22, 0.92)}
"""The colours that the ball sensors look for, as toys have them."""
EXAMPLE = "red, #ff8000 or (1, 0.5, 0)"
_BY_KEY = {key(name): rgb for name, rgb in COLOURS.items()}


def parse_colour(value: Value) -> RGB | None:
    """The colour, or None when the value is not one.

    >>> parse_colour("Red"), parse_colour("#FF0000"), parse_colour((0, 0.5, 1)), parse_colour(7)
    ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.5, 1.0), None)
    """
    if isinstance(value, str):
        text = value.strip()
        if re.fullmatch(r"#[0-9a-fA-F]{6}", text):
            return int(text[1:3], 16) / 255, int(text[3:5], 16) / 255, int(text[5:7], 16) / 255
        return _BY_KEY.get(key(text))
    if isinstance(value, Record):
        value = value.values.get("colour")
        return parse_colour(value) if isinstance(value, str) else None
    if isinstance(value, (list, tuple)) and len(value) == 3:
        if not all(isinstance(c, (int, float)) and not isinstance(c, bool) and 0 <= c <= 1 for c in value):
            return None
        return float(value[0]), float(value[1]), float(value[2])
    return None


@dataclass(frozen=True)
class Traits:
    """Measures and colours of a drawn face.

    Lengths are parts of half the head's height; the origin is the middle of the face, x to the right of who looks at
    it, y up. Colours are 0 to 1.

    Attributes:
        eyes: (half distance, height, half width, opening, slant).
        brows: (height above the eyes, thickness, arch, slant).
        nose: (lower end's height, half width, how strong its shadow is).
        mouth: (height, half width, upper lip, lower lip, smile).
    """

    skin: RGB
    hair: RGB
    iris: RGB
    lips: RGB
    width: float = 0.78  # half of it, at the cheeks
    jaw: float = 0.62  # half its width, at the mouth
    chin: float = 0.55  # 0.4 is broad, 0.7 pointed
    eyes: tuple[float, float, float, float, float] = (0.33, 0.04, 0.165, 0.075, 0.0)
    brows: tuple[float, float, float, float] = (0.17, 0.03, 0.04, 0.0)
    nose: tuple[float, float, float] = (-0.27, 0.13, 1.0)
    mouth: tuple[float, float, float, float, float] = (-0.52, 0.24, 0.045, 0.065, 0.03)
    style: str = "short"  # of the hair: a name in `HAIR`
    hairline: float = 0.55  # height at the middle
    parting: float = 0.0  # lifts the hairline to one side
    fringe: float = 0.02  # how ragged the hairline is
    glasses: str = ""  # `round`, `square` or empty
    beard: float = 0.0  # how much of it, 0 to 1
    moustache: float = 0.0  # 0 to 1
    lines: float = 0.0  # of age, 0 to 1
    freckles: float = 0.0  # 0 to 1
    rosy: float = 0.3  # cheeks, 0 to 1


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


PEOPLE: tuple[Traits, ...] = (
    Traits(  # a girl with freckles
        skin=(0.95, 0.78, 0.68), hair=(0.42, 0.27, 0.15), iris=(0.36, 0.25, 0.16), lips=(0.8, 0.45, 0.42),
        width=0.72, jaw=0.56, chin=0.62, eyes=(0.29, -0.035, 0.175, 0.07, -0.02), brows=(0.22, 0.03, 0.055, -0.03),
        nose=(-0.36, 0.165, 0.591), mouth=(-0.5, 0.28, 0.025, 0.085, 0.044), style="tail", hairline=0.338,
        fringe=0.04, freckles=0.8, rosy=0.9,
    ),
    Traits(  # a boy
        skin=(0.42, 0.28, 0.2), hair=(0.08, 0.06, 0.06), iris=(0.16, 0.09, 0.06), lips=(0.52, 0.26, 0.25),
        width=0.84, jaw=0.56, chin=0.62, eyes=(0.38, -0.06, 0.185, 0.1, -0.009), brows=(0.134, 0.027, 0.055, -0.022),
        nose=(-0.255, 0.158, 0.601), mouth=(-0.5, 0.19, 0.06, 0.062, 0.018), hairline=0.605, fringe=0.0, rosy=0.1,
    ),
    Traits(  # a girl with a bob
        skin=(0.86, 0.66, 0.5), hair=(0.07, 0.06, 0.07), iris=(0.13, 0.08, 0.05), lips=(0.75, 0.42, 0.38),
        width=0.752, jaw=0.56, chin=0.49, eyes=(0.38, -0.056, 0.161, 0.066, 0.04), brows=(0.22, 0.017, 0.029, 0.008),
        nose=(-0.284, 0.095, 0.46), mouth=(-0.56, 0.248, 0.06, 0.076, 0.018), style="bob", hairline=0.3, rosy=0.4,
    ),
    Traits(  # a woman with long fair hair
        skin=(0.97, 0.83, 0.75), hair=(0.86, 0.7, 0.42), iris=(0.35, 0.52, 0.66), lips=(0.82, 0.48, 0.46),
        width=0.731, jaw=0.56, chin=0.62, eyes=(0.367, 0.055, 0.135, 0.062, -0.02),
        brows=(0.151, 0.017, 0.037, 0.006), nose=(-0.263, 0.165, 0.854), mouth=(-0.5, 0.28, 0.049, 0.042, 0.06),
        style="long", hairline=0.62, parting=0.12, rosy=0.5,
    ),
    Traits(  # a man with a beard
        skin=(0.8, 0.62, 0.45), hair=(0.14, 0.1, 0.08), iris=(0.25, 0.16, 0.09), lips=(0.66, 0.38, 0.34), width=0.84,
        jaw=0.56, chin=0.495, eyes=(0.334, 0.08, 0.137, 0.058, -0.02), brows=(0.12, 0.045, 0.034, -0.018),
        nose=(-0.274, 0.09, 1.195), mouth=(-0.57, 0.19, 0.033, 0.076, 0.054), hairline=0.484, parting=-0.06,
        beard=0.85, moustache=0.9, lines=0.3, rosy=0.0,
    ),
    Traits(  # an old woman with glasses
        skin=(0.95, 0.78, 0.68), hair=(0.72, 0.71, 0.7), iris=(0.4, 0.48, 0.52), lips=(0.72, 0.45, 0.43),
        width=0.742, jaw=0.59, chin=0.62, eyes=(0.298, 0.08, 0.185, 0.085, -0.02), brows=(0.22, 0.017, 0.01, -0.007),
        nose=(-0.359, 0.165, 0.883), mouth=(-0.536, 0.244, 0.025, 0.074, 0.018), style="curly", hairline=0.416,
        fringe=0.03, glasses="round", lines=1.0, rosy=0.4,
    ),
    Traits(  # a young woman
        skin=(0.6, 0.42, 0.3), hair=(0.1, 0.07, 0.06), iris=(0.2, 0.12, 0.07), lips=(0.62, 0.32, 0.32), width=0.723,
        jaw=0.662, chin=0.62, eyes=(0.364, 0.08, 0.185, 0.058, 0.04), brows=(0.127, 0.031, 0.055, 0.008),
        nose=(-0.36, 0.165, 1.11), mouth=(-0.5, 0.191, 0.06, 0.079, 0.041), style="curly", hairline=0.512,
        fringe=0.04, rosy=0.2,
    ),
    Traits(  # a bald man with glasses
        skin=(0.97, 0.83, 0.75), hair=(0.55, 0.26, 0.12), iris=(0.38, 0.46, 0.36), lips=(0.78, 0.5, 0.46),
        width=0.823, jaw=0.709, chin=0.48, eyes=(0.301, -0.004, 0.16, 0.058, 0.0), brows=(0.164, 0.033, 0.01, 0.006),
        nose=(-0.31, 0.14, 1.0), mouth=(-0.557, 0.27, 0.03, 0.038, 0.02), style="bald", hairline=0.62,
        glasses="square", beard=0.45, lines=0.5, rosy=0.5,
    ),
)  # fmt: skip
