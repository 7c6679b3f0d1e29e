"""Finds balls and spots of a colour in a picture. Pure image processing: it knows nothing of the simulated world."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2

from rrp_sheets.perception.pinhole import Lens, Pixels

Band = tuple[int, int]
HUES: Mapping[str, tuple[Band, ...]] = {"red": ((0, 8), (172, 180)), "green": ((40, 85),), "blue": ((100, 130),)}
"""Bands of hue of each ball's colour, on OpenCV's scale (0 to 180)."""
SATURATION, VALUE = 150, 50  # least saturation and brightness of a ball's pixels (0 to 255): pale and black are none
SPOT_SATURATION = 90  # a spot may be paler
FEWEST = 4  # pixels of the smallest spot
BALL_RADIUS = 0.03  # m: a ball is taken for one of 6 cm
PIXEL_OFFSET = (0.0, 1.0)  # measured: where the drawing program's pixel centres are off
ROUNDER = 0.995  # measured: balls are drawn with flat faces and look so much smaller


@dataclass(frozen=True)
class Spot:
    """Ball or spot in a picture: middle (rad, x left, y down), apparent size (rad), distance (m; 0 for a spot), area.

    The area is its share of the picture, 0 to 1.
    """

    x: float
    y: float
    width: float
    height: float
    distance: float
    area: float


class Detector:
    """Looks for colours in one picture; the picture is converted once for all of them."""

    def __init__(self, picture: Pixels, lens: Lens) -> None:
        self._hsv = cv2.cvtColor(picture, cv2.COLOR_RGB2HSV)
        self._lens = lens
        self._balls: dict[str, Spot | None] = {}

    def ball(self, colour: str) -> Spot | None:
        """The largest ball of that colour (`red`, `green`, `blue`)."""
        if colour not in self._balls:
            mask = self._mask(HUES[colour], SATURATION)
            found = [spot for contour in _contours(mask) if (spot := self._as_ball(contour, mask))]
            self._balls[colour] = max(found, key=lambda s: s.width, default=None)
        return self._balls[colour]

    def any_ball(self) -> tuple[str, Spot] | None:
        """The largest ball of any colour, with its colour."""
        found = [(colour, spot) for colour in HUES if (spot := self.ball(colour))]
        return max(found, key=lambda f: f[1].width, default=None)

    def spot(self, colour: tuple[float, float, float], threshold: float) -> Spot | None:
        """The largest spot whose hue is within `threshold` degrees of the colour's."""
        hue = round(colorsys.rgb_to_hsv(*colour)[0] * 180)
        off = max(1, round(threshold / 2))
        low, high = hue - off, hue + off
        bands = [(max(low, 0), min(high, 180))]
        bands += [(low + 180, 180)] if low < 0 else []
        bands += [(0, high - 180)] if high > 180 else []
        mask = self._mask(bands, SPOT_SATURATION)
        contours = [(cv2.contourArea(c) + 0.5 * len(c) + 1, i, c) for i, c in enumerate(_contours(mask))]
        area, _, largest = max(contours, key=lambda c: c[:2], default=(0.0, 0, None))
        if largest is None or area < FEWEST:
            return None
        left, top, width, height = cv2.boundingRect(largest)
        x, y = self._direction(*_middle(mask, left, top, width, height))
        fx, fy = self._lens.focal
        share = area / (self._lens.width * self._lens.height)
        return Spot(x, y, 2 * math.atan(width / 2 / fx), 2 * math.atan(height / 2 / fy), 0.0, share)

    def _mask(self, bands: Sequence[Band], saturation: int) -> Any:
        mask = None
        for low, high in bands:
            part = cv2.inRange(self._hsv, (low, saturation, VALUE), (high, 255, 255))
            mask = part if mask is None else cv2.bitwise_or(mask, part)
        return mask

    def _as_ball(self, contour: Any, mask: Any) -> Spot | None:
        """Return the contour as a ball, or None when it is not round; at the picture's edge it may be less round."""
        lens = self._lens
        left, top, width, height = cv2.boundingRect(contour)
        area = cv2.contourArea(contour) + 0.5 * len(contour) + 1  # the pixels inside, about
        if area < FEWEST:
            return None
        cut = left == 0 or top == 0 or left + width >= lens.width or top + height >= lens.height
        (u, v), radius = cv2.minEnclosingCircle(contour)
        radius += 0.5
        fill = area / (math.pi * radius * radius)
        if cut:
            round_enough = fill >= 0.3
        elif area >= 60:
            round_enough = fill >= (0.80 if area > 150 else 0.68)
        else:
            round_enough = min(width, height) >= 0.6 * max(width, height)
        if not round_enough:
            return None
        if not cut:
            radius = math.sqrt(area / math.pi)
            u, v = _middle(mask, left, top, width, height)
        x, y = self._direction(u, v)
        fx, fy = lens.focal
        # Away from the middle a pinhole camera stretches things.
        oblique = (1 + math.tan(x) ** 2 + math.tan(y) ** 2) ** 0.75
        apparent = math.atan(radius / math.sqrt(fx * fy) / oblique)
        distance = ROUNDER * BALL_RADIUS / math.sin(apparent)
        return Spot(x, y, 2 * apparent, 2 * apparent, distance, area / (lens.width * lens.height))

    def _direction(self, u: float, v: float) -> tuple[float, float]:
        """The angles to the left of and below the picture's middle, rad."""
        fx, fy = self._lens.focal
        across = (u + PIXEL_OFFSET[0] - self._lens.width / 2) / fx
        down = (v + PIXEL_OFFSET[1] - self._lens.height / 2) / fy
        return -math.atan(across), math.atan(down)


def _contours(mask: Any) -> Sequence[Any]:
    return list(cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[-2])


def _middle(mask: Any, left: int, top: int, width: int, height: int) -> tuple[float, float]:
    """The centre of gravity of the pixels in a box, in pixels."""
    m = cv2.moments(mask[top : top + height, left : left + width], True)
    return left + m["m10"] / m["m00"], top + m["m01"] / m["m00"]
