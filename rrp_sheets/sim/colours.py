"""Colours as users write them: a name, `#rrggbb`, or (r, g, b) from 0 to 1."""

from __future__ import annotations

import re

from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, Value

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
