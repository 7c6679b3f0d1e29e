"""Portraits of persons for their heads: drawn from traits, or cut from a picture file that the scene names."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from PIL import UnidentifiedImageError

from rrp_sheets.errors import SheetsError
from rrp_sheets.perception.faces import DetectedFace, FaceModels, Features
from rrp_sheets.perception.pinhole import Pixels
from rrp_sheets.sim.appearance import PEOPLE, RGB, Traits, outline
from rrp_sheets.texts import N_

FORMATS = ("PNG", "JPEG")
MOST_BYTES = 10_000_000
MOST_PIXELS = 24_000_000  # of a picture file; a telephone's camera has 12 to 24 million
LEAST = 64  # pixels of either side
FINE = 800  # pixels: larger pictures are made smaller before faces are looked for
PALE: RGB = (0.93, 0.93, 0.94)  # behind a head, as in the room
NEAR, FAR = 118, 62  # pixels of a head's height from about 1 m and 2 m
FADES = 0.84  # of a head's half width: from there outwards a photograph goes over into skin and hair
HAIRLINE = -0.25  # of half a portrait, downwards from its middle: above it that is hair
REMEDY = N_("Use a PNG or JPEG picture of one person who looks into the camera.")
# Eyes, nose and corners of the mouth as a portrait has them: parts of half its side from its middle, y up.
_PLACES = ((-0.33, 0.04), (0.33, 0.04), (0.0, -0.22), (-0.23, -0.53), (0.23, -0.53))
_ANYBODY = Traits((1, 1, 1), (0, 0, 0), (0, 0, 0), (1, 0, 0), width=0.80, jaw=0.63, chin=0.52)
Floats = NDArray[np.floating[Any]]
SIDE = 192  # pixels of the finished picture
EDGE = 0.012  # softness of edges, as a part of half the picture


@dataclass(frozen=True)
class Portrait:
    """Picture, outline and colours that a head is made of."""

    name: str  # of the drawing or the file
    picture: Pixels  # the face from the front, square, red first; the head's outline touches its upper and lower edge
    outline: Callable[[float], float]  # half the head's width at a height (-1 to 1), in half heights
    skin: RGB
    hair: RGB
    style: str  # of the hair, see `appearance.Traits`

    def cut_out(self, size: int) -> Pixels:
        """Return the head as seen from the front before a pale wall, its height `size` pixels."""
        heights = np.linspace(1, -1, SIDE + 2)[1:-1]
        half = np.array([self.outline(float(h)) for h in heights])
        across = np.abs(np.linspace(-1, 1, SIDE))
        inside = (across[None, :] < half[:, None])[:, :, None]
        wall = np.array([round(c * 255) for c in PALE], np.uint8)
        small = cv2.resize(np.where(inside, self.picture, wall), (size, size), interpolation=cv2.INTER_AREA)
        edge = size // 2
        around = cv2.copyMakeBorder(small, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=wall.tolist())
        return np.asarray(around, dtype=np.uint8)


def drawn(face: int) -> Portrait:
    """Return one of the drawn faces, by its place among `appearance.PEOPLE`; beyond their number they repeat."""
    place = face % len(PEOPLE)
    traits = PEOPLE[place]
    picture = draw_face(traits, place + 1)
    return Portrait(f"face {place + 1}", picture, partial(outline, traits), traits.skin, traits.hair, traits.style)


def png(picture: Pixels) -> bytes:
    """Return a picture as a PNG file."""
    _, data = cv2.imencode(".png", np.ascontiguousarray(picture[:, :, ::-1]))
    return bytes(data)


def from_file(path: Path, models: FaceModels) -> Portrait:
    """Cut the largest face of a picture file to a portrait; raises SheetsError: no face, or as `read_picture`."""
    picture = read_picture(path)
    scale = min(1.0, FINE / max(picture.shape[:2]))
    if scale < 1:
        picture = np.asarray(cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
    # A face that fills the picture is found only with some room around it.
    edge = max(picture.shape[:2]) // 4
    roomy = np.asarray(cv2.copyMakeBorder(picture, edge, edge, edge, edge, cv2.BORDER_REPLICATE), dtype=np.uint8)
    face = max(models.find(roomy), key=lambda f: f.width * f.height, default=None)
    if face is None:
        raise SheetsError(N_("No face can be found in the picture “{name}”.", name=path.name), REMEDY)
    square = _upright(roomy, face)
    skin = _colour_of(square[SIDE * 55 // 100 : SIDE * 65 // 100, SIDE // 4 : SIDE * 3 // 4])
    hair = _colour_of(square[SIDE // 50 : SIDE // 8, SIDE // 3 : SIDE * 2 // 3])
    return Portrait(path.name, _faded(square, skin, hair), partial(outline, _ANYBODY), skin, hair, "short")


def read_picture(path: Path) -> Pixels:
    """Read a PNG or JPEG file as (height, width, 3), red first, turned as its camera says.

    Raises:
        SheetsError: it is missing, broken, too large or too small.
    """
    name = path.name
    try:
        if path.stat().st_size > MOST_BYTES:
            why = N_("The picture “{name}” is larger than {n} MB.", name=name, n=MOST_BYTES // 1_000_000)
            raise SheetsError(why, N_("Make it smaller."))
        with Pillow.open(path, formats=FORMATS) as opened:
            wide, high = opened.size
            if wide * high > MOST_PIXELS:
                why = N_("The picture “{name}” has {wide} × {high} pixels, which is too large.", name=name, wide=wide,
                         high=high)  # fmt: skip
                raise SheetsError(why, N_("Make it smaller."))
            if min(wide, high) < LEAST:
                why = N_("The picture “{name}” has only {wide} × {high} pixels.", name=name, wide=wide, high=high)
                raise SheetsError(why, REMEDY)
            return _upright_as_taken(opened)
    except (OSError, ValueError, SyntaxError, Pillow.DecompressionBombError, UnidentifiedImageError) as error:
        reason = (error.strerror if isinstance(error, OSError) else "") or N_(
            "it is not a PNG or JPEG, or it is broken"
        )
        why = N_("The picture “{name}” cannot be read: {reason}.", name=name, reason=reason)
        raise SheetsError(why, REMEDY) from None


def _upright_as_taken(opened: Any) -> Pixels:
    from PIL import ImageOps

    turned = ImageOps.exif_transpose(opened)
    if turned.mode in ("RGBA", "LA", "PA") or "transparency" in turned.info:
        shown = turned.convert("RGBA")
        wall = Pillow.new("RGBA", shown.size, tuple(round(c * 255) for c in (*PALE, 1.0)))
        turned = Pillow.alpha_composite(wall, shown)
    return np.asarray(turned.convert("RGB"), dtype=np.uint8)


def _upright(picture: Pixels, face: DetectedFace) -> Pixels:
    """Turn, move and scale the face so that eyes and mouth are where a portrait has them."""
    middle, half = (SIDE - 1) / 2, SIDE / 2
    to = np.array([(middle + half * x, middle - half * y) for x, y in _PLACES])
    come = face.points.astype(np.float64)
    a, b = come - come.mean(axis=0), to - to.mean(axis=0)
    # The similarity that brings the five points nearest to their places (least squares).
    size = float((a**2).sum()) or 1.0
    cos, sin = float((a * b).sum()) / size, float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()) / size
    turn = np.array([[cos, -sin], [sin, cos]])
    move = to.mean(axis=0) - turn @ come.mean(axis=0)
    shrink = math.hypot(cos, sin)
    if shrink < 1:  # else every second pixel would be left out
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.45 / shrink), dtype=np.uint8)
    upright = cv2.warpAffine(
        picture, np.column_stack([turn, move]), (SIDE, SIDE), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(upright, dtype=np.uint8)


def _faded(picture: Pixels, skin: RGB, hair: RGB) -> Pixels:
    """Blend the picture's background into skin and hair towards the outline, as it lies on the head's sides."""
    along = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    half = np.array([max(outline(_ANYBODY, -float(y)), 1e-3) for y in along])
    across = np.abs(along)[None, :] / half[:, None]
    mask = np.clip((across - FADES) / (1 - FADES), 0, 1)[:, :, None]
    high = np.clip((HAIRLINE - along) / 0.2 + 0.5, 0, 1)[:, None, None]
    colour = 255 * (high * np.array(hair) + (1 - high) * np.array(skin) * 0.85)
    return np.asarray(picture * (1 - mask) + colour * mask, dtype=np.uint8)


def _colour_of(patch: Pixels) -> RGB:
    red, green, blue = (float(c) / 255 for c in np.median(patch.reshape(-1, 3), axis=0))
    return red, green, blue


def studied(portrait: Portrait, models: FaceModels) -> list[Features]:
    """Return a portrait's features from near and from farther away, as if the robot had been shown it."""
    pictures = [portrait.cut_out(size) for size in (NEAR, FAR)]
    return [models.features(picture, faces[0]) for picture in pictures if (faces := models.find(picture))]


class _Canvas:
    """A picture that is being painted, with the coordinates of its pixels."""

    def __init__(self, seed: int) -> None:
        along = ((np.arange(SIDE, dtype=np.float32) + 0.5) / SIDE * 2 - 1).astype(np.float32)
        self.x, self.y = np.meshgrid(along, -along)
        self.picture: Floats = np.ones((SIDE, SIDE, 3), np.float32)
        self._chance = np.random.default_rng(seed)

    def paint(self, mask: Floats, colour: RGB | Floats) -> None:
        """Cover with a colour where the mask is 1."""
        self.picture += mask[:, :, None] * (np.asarray(colour, np.float32) - self.picture)

    def shade(self, mask: Floats, strength: float) -> None:
        """Lighten (or, below 0, darken) by a part where the mask is 1; shadows are warm."""
        tint = np.array([1.0, 1.15, 1.25] if strength < 0 else [1.0, 1.0, 0.9], np.float32)
        self.picture *= 1 + strength * mask[:, :, None] * tint

    def spot(self, x: float, y: float, wide: float, high: float) -> Floats:
        """A soft round mask."""
        soft: Floats = np.exp(-(((self.x - x) / wide) ** 2) - ((self.y - y) / high) ** 2).astype(np.float32)
        return soft

    def noise(self, wide: float, high: float) -> Floats:
        """Soft random stripes or spots of that size, about -1 to 1."""
        n = len(self.x)
        small = self._chance.standard_normal((max(2, round(2 / high)), max(2, round(2 / wide)))).astype(np.float32)
        return np.asarray(cv2.resize(small, (n, n), interpolation=cv2.INTER_CUBIC), np.float32)

    def finish(self) -> NDArray[np.uint8]:
        """The picture, (SIDE, SIDE, 3), 0 to 255."""
        whole = np.clip(self.picture * 255, 0, 255)
        return np.asarray(cv2.resize(whole, (SIDE, SIDE), interpolation=cv2.INTER_AREA).astype(np.uint8))


def soft(distance: Floats, edge: float = EDGE) -> Floats:
    """Return 1 where the distance is clearly above 0, 0 where it is clearly below, and a soft edge between."""
    t = np.clip(distance / (2 * edge) + 0.5, 0, 1).astype(np.float32)
    smooth: Floats = t * t * (3 - 2 * t)
    return smooth


def _darker(colour: RGB, part: float) -> RGB:
    return colour[0] * part, colour[1] * part, colour[2] * part


def _blurred(mask: Floats, pixels: float) -> Floats:
    return np.asarray(cv2.GaussianBlur(mask, (0, 0), pixels), np.float32)


def draw_face(traits: Traits, seed: int = 1) -> NDArray[np.uint8]:
    """Draw a face as seen from the front, (192, 192, 3), 0 to 255; hair reaches to the picture's edge."""
    canvas = _Canvas(seed)
    _skin(canvas, traits)
    for side in (-1, 1):
        _eye(canvas, traits, side)
    _nose(canvas, traits)
    _mouth(canvas, traits)
    _beard(canvas, traits)
    for side in (-1, 1):
        _brow(canvas, traits, side)
    _hair(canvas, traits)
    _glasses(canvas, traits)
    return canvas.finish()


def _skin(c: _Canvas, t: Traits) -> None:
    c.paint(np.ones_like(c.x), t.skin)
    c.shade(soft(np.hypot(c.x / (t.width * 1.02), (c.y - 0.05) / 1.08) - 0.72, 0.28), -0.34)  # it is round
    c.shade(c.spot(-0.12, 0.50, 0.5, 0.26), 0.08)  # light from above, from a little aside
    _, eye_y, eye_wide, _, _ = t.eyes
    for side in (-1, 1):
        c.shade(c.spot(side * t.eyes[0], eye_y + 0.05, eye_wide * 1.3, 0.12), -0.17)  # sockets
        c.shade(c.spot(side * t.eyes[0] * 1.2, eye_y - 0.25, 0.17, 0.12), 0.07)  # cheekbones
        c.shade(c.spot(side * t.jaw * 0.85, -0.48, 0.16, 0.25), -0.12)  # hollow of the cheeks
        blush = c.spot(side * 0.42, eye_y - 0.32, 0.17, 0.13) * np.float32(0.35 * t.rosy)
        c.paint(blush, (t.skin[0] * 1.0, t.skin[1] * 0.70, t.skin[2] * 0.66))
        fold = np.abs(c.x - side * (t.nose[1] + 0.09 + (t.nose[0] - c.y) * 0.28)) < 0.016
        c.shade(_blurred(fold * c.spot(side * 0.27, t.nose[0] - 0.09, 0.2, 0.13), 3), -0.75 * t.lines)
        c.shade(c.spot(side * t.eyes[0], eye_y - 0.13, 0.13, 0.03), -0.10 - 0.28 * t.lines)  # under the eyes
    for height in (0.33, 0.42):
        c.shade(c.spot(0, height, 0.3, 0.013), -0.16 * t.lines)
    c.picture *= 1 + 0.012 * c.noise(0.02, 0.02)[:, :, None]
    if t.freckles:
        spots = soft(c.noise(0.03, 0.03) - 1.3, 0.2) * (c.spot(0.3, -0.12, 0.28, 0.2) + c.spot(-0.3, -0.12, 0.28, 0.2))
        c.shade(np.minimum(spots, 1), -0.22 * t.freckles)


def _eye(c: _Canvas, t: Traits, side: int) -> None:
    gap, height, wide, opening, slant = t.eyes
    dx, dy = (c.x - side * gap) * side, c.y - height
    dy = dy - slant * dx / wide  # outer corners higher, or lower
    along = dx / wide
    arc = np.maximum(0, 1 - along**2).astype(np.float32)
    upper, lower = opening * arc**0.65, -0.62 * opening * arc**0.8
    inside = soft(upper - dy) * soft(dy - lower) * soft(1 - np.abs(along), 0.04)
    c.paint(inside, (0.93, 0.91, 0.89))
    c.shade(inside * soft(dy - (upper - 0.45 * opening), 0.04), -0.22)  # the lid's shadow
    radius = min(wide * 0.50, opening * 1.12)
    away = np.hypot(dx, dy - 0.10 * opening)
    ring = soft(radius - away) * inside
    c.paint(ring, t.iris)
    c.shade(ring * soft(away - radius * 0.78, 0.015), -0.45)
    c.shade(ring * c.spot(side * gap, height - 0.5 * radius, radius, radius * 0.6), 0.45)
    c.paint(soft(radius * 0.46 - away) * inside, (0.04, 0.04, 0.05))
    light = soft(0.20 * radius + 0.004 - np.hypot(c.x - side * gap + 0.35 * radius, dy - 0.45 * radius), 0.008)
    c.paint(light * inside, (1.0, 1.0, 1.0))
    within = soft(1.04 - np.abs(along), 0.03)
    c.paint(soft(0.016 - np.abs(dy - upper), 0.008) * within * np.float32(0.9), _darker(t.hair, 0.35))
    c.shade(soft(0.010 - np.abs(dy - lower), 0.008) * within, -0.30)
    crease = opening * 1.55 * np.maximum(0, 1 - (along * 0.92) ** 2).astype(np.float32) ** 0.6 + 0.012
    c.shade(soft(0.010 - np.abs(dy - crease), 0.010) * soft(0.95 - np.abs(along), 0.1), -0.30)


def _brow(c: _Canvas, t: Traits, side: int) -> None:
    above, thick, arch, slant = t.brows
    dx = (c.x - side * t.eyes[0]) * side
    along = dx / (t.eyes[2] * 1.32)
    middle = t.eyes[1] + above + arch * (1 - (along - 0.15) ** 2) + slant * along
    half = thick * np.clip(1.05 - 0.45 * (along + 1) / 2 - 0.35 * np.maximum(along - 0.4, 0), 0.15, 1)
    mask = soft(half - np.abs(c.y - middle), 0.014) * soft(1 - np.abs(along), 0.12)
    hairs = 0.86 + 0.14 * c.noise(0.025, 0.05)
    c.paint(np.clip(mask * hairs, 0, 0.92).astype(np.float32), _darker(t.hair, 0.72))


def _nose(c: _Canvas, t: Traits) -> None:
    end, wide, strong = t.nose
    top = t.eyes[1]
    length = top - end
    c.shade(c.spot(0.0, end + 0.5 * length, 0.05, length * 0.55), 0.10 * strong)
    c.shade(c.spot(0.0, end + 0.055, 0.06, 0.05), 0.14 * strong)
    for side in (-1, 1):
        c.shade(c.spot(side * (wide * 0.75), end + 0.42 * length, 0.05, length * 0.42), -0.13 * strong)
        c.shade(c.spot(side * (wide + 0.01), end + 0.03, 0.035, 0.06), -0.26 * strong)
        c.shade(c.spot(side * wide * 0.50, end - 0.012, 0.042, 0.020), -0.68)
    c.shade(c.spot(0.0, end - 0.03, wide * 1.05, 0.03), -0.22)
    c.shade(c.spot(0.0, (end + t.mouth[0]) / 2 + 0.02, 0.025, 0.05), -0.07)  # the groove above the lip


def _mouth(c: _Canvas, t: Traits) -> None:
    height, wide, upper, lower, smile = t.mouth
    along = c.x / wide
    arc = np.maximum(0, 1 - along**2).astype(np.float32)
    line = height + smile * along**2 - 0.004 * np.cos(along * 6)
    above = line + upper * arc**0.7 * (1 - 0.30 * np.exp(-((along / 0.16) ** 2)))
    below = line - lower * arc**0.65
    inside = soft(1 - np.abs(along), 0.05)
    c.shade(c.spot(0, height - lower - 0.045, wide * 0.62, 0.035), -0.20)
    c.paint(soft(above - c.y) * soft(c.y - line) * inside, (t.lips[0] * 0.86, t.lips[1] * 0.80, t.lips[2] * 0.80))
    c.paint(soft(line - c.y) * soft(c.y - below) * inside, t.lips)
    c.shade(c.spot(0, height - lower * 0.55, wide * 0.42, lower * 0.35) * soft(line - c.y), 0.22)
    c.paint(soft(0.012 - np.abs(c.y - line), 0.010) * inside * np.float32(0.85), (0.25, 0.11, 0.11))
    for side in (-1, 1):
        c.shade(c.spot(side * wide * 1.03, height + smile, 0.035, 0.03), -0.28)
    c.shade(c.spot(0, -0.84, 0.16, 0.09), 0.06)  # the chin


def _beard(c: _Canvas, t: Traits) -> None:
    if not t.beard and not t.moustache:
        return
    height, wide, upper, lower, _ = t.mouth
    hairs = 0.80 + 0.25 * c.noise(0.02, 0.04)
    lips = soft(0.92 - np.hypot(c.x / wide, (c.y - height + 0.01) / (upper + lower)), 0.12)
    colour = _darker(t.hair, 0.85)
    if t.beard:
        cheeks = soft(-0.30 - 0.42 * (1 - np.abs(c.x) / t.width) - c.y, 0.10)
        low = np.maximum(cheeks, soft(1 - np.hypot(c.x / 0.34, (c.y + 0.80) / 0.24), 0.2))
        c.paint(np.clip(low * hairs * t.beard * (1 - lips), 0, 0.95).astype(np.float32), colour)
    if t.moustache:
        middle = height + upper + 0.055 - 0.10 * (c.x / wide) ** 2
        bar = soft(0.045 - np.abs(c.y - middle), 0.03) * soft(1.15 - np.abs(c.x) / wide, 0.1)
        c.paint(np.clip(bar * hairs * t.moustache, 0, 0.95).astype(np.float32), colour)


def _hair(c: _Canvas, t: Traits) -> None:
    if t.style == "bald":
        c.shade(c.spot(0.1, 0.75, 0.4, 0.16), 0.12)
        return
    ragged = t.fringe * c.noise(0.07, 2.0)
    line = t.hairline + 0.12 * (1 - (c.x / t.width) ** 2) + t.parting * c.x + ragged - 0.05
    mask = soft(c.y - line, 0.03)
    side, lowest = {
        "short": (0.0, 0.02), "curly": (0.05, -0.25), "bob": (0.12, -0.62), "long": (0.16, -1.2), "tail": (0.02, 0.05)
    }[t.style]  # fmt: skip
    inner = t.width * (1.0 - side) - 0.05 * np.cos(c.y * 2.2) + 0.02 * c.noise(2.0, 0.08)
    mask = np.maximum(mask, soft(np.abs(c.x) - inner, 0.03) * soft(c.y - lowest, 0.08))
    c.shade(_blurred(mask, 7) * (1 - mask), -0.28)  # its shadow on the skin
    c.paint(mask, t.hair)
    angle = np.arctan2(c.x - 0.1 * np.sign(t.parting), c.y + 0.2)
    if t.style == "curly":
        strands = c.noise(0.07, 0.07)
    else:
        wave = c.noise(2.0, 2.0)
        strands = (np.sin(angle * 60 + 3 * wave) + np.sin(angle * 97 + 1.3)).astype(np.float32) * 0.5
    c.shade(mask * np.clip(strands, -1, 1), 0.20)
    c.shade(mask * c.spot(-0.15, 0.82, 0.55, 0.10), 0.30)


def _glasses(c: _Canvas, t: Traits) -> None:
    if not t.glasses:
        return
    gap, height, wide, _, _ = t.eyes
    frame = np.zeros_like(c.x)
    power = 2.0 if t.glasses == "round" else 5.0
    half_x, half_y = wide * 1.32, wide * (1.15 if t.glasses == "round" else 0.92)
    for side in (-1, 1):
        dx, dy = np.abs((c.x - side * gap) / half_x), np.abs((c.y - height + 0.01) / half_y)
        away = (dx**power + dy**power) ** (1 / power)
        frame = np.maximum(frame, soft(0.10 - np.abs(away - 1), 0.04))
        c.shade(soft(1 - away, 0.05), 0.05)
        arm = soft(0.018 - np.abs(c.y - height - 0.04), 0.008) * soft(side * c.x - gap - half_x, 0.01)
        frame = np.maximum(frame, arm)
    bridge = soft(0.018 - np.abs(c.y - height - 0.035), 0.008) * soft(gap - half_x - np.abs(c.x), 0.01)
    c.paint(np.maximum(frame, bridge).astype(np.float32), (0.10, 0.09, 0.10))
