"""What the heads of persons look like: drawn faces by number, or a picture file that the scene names."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import UnidentifiedImageError

from rrp_sheets.errors import SheetsError
from rrp_sheets.sim.camera import Image
from rrp_sheets.sim.colours import RGB
from rrp_sheets.sim.face_drawing import SIDE, draw_face
from rrp_sheets.sim.face_models import FaceModels, Features, Found
from rrp_sheets.sim.face_people import PEOPLE
from rrp_sheets.sim.face_traits import Traits, outline

FORMATS = ("PNG", "JPEG")
MOST_BYTES = 10_000_000
MOST_PIXELS = 24_000_000  # of a picture file; a telephone's camera has 12 to 24 million
LEAST = 64  # pixels of either side
FINE = 800  # pixels: larger pictures are made smaller before faces are looked for
PALE: RGB = (0.93, 0.93, 0.94)  # behind a head, as in the room
NEAR, FAR = 118, 62  # pixels of a head's height from about 1 m and 2 m
FADES = 0.84  # of a head's half width: from there outwards a photograph goes over into skin and hair
HAIRLINE = -0.25  # of half a portrait, downwards from its middle: above it that is hair
REMEDY = "Use a PNG or JPEG picture of one person who looks into the camera."
# Eyes, nose and corners of the mouth as a portrait has them: parts of half its side from its middle, y up.
_PLACES = ((-0.33, 0.04), (0.33, 0.04), (0.0, -0.22), (-0.23, -0.53), (0.23, -0.53))
_ANYBODY = Traits((1, 1, 1), (0, 0, 0), (0, 0, 0), (1, 0, 0), width=0.80, jaw=0.63, chin=0.52)


@dataclass(frozen=True)
class Portrait:
    """What a head is made of.

    Attributes:
        name: of the drawing or the file.
        picture: the face from the front, square, red first; the head's outline touches its upper and lower edge.
        outline: half the head's width at a height (-1 to 1), in half heights.
        skin, hair: colours, 0 to 1.
        style: of the hair, see `face_traits.Traits`.
    """

    name: str
    picture: Image
    outline: Callable[[float], float]
    skin: RGB
    hair: RGB
    style: str

    def cut_out(self, size: int) -> Image:
        """The head as seen from the front before a pale wall, its height `size` pixels."""
        heights = np.linspace(1, -1, SIDE + 2)[1:-1]
        half = np.array([self.outline(float(h)) for h in heights])
        across = np.abs(np.linspace(-1, 1, SIDE))
        inside = (across[None, :] < half[:, None])[:, :, None]
        wall = np.array([round(c * 255) for c in PALE], np.uint8)
        small = cv2.resize(np.where(inside, self.picture, wall), (size, size), interpolation=cv2.INTER_AREA)
        edge = size // 2
        return np.asarray(
            cv2.copyMakeBorder(small, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=wall.tolist()), dtype=np.uint8
        )


def drawn(face: int) -> Portrait:
    """One of the drawn faces, by its place among `face_people.PEOPLE`; beyond their number they come again."""
    place = face % len(PEOPLE)
    traits = PEOPLE[place]
    return Portrait(
        f"face {place + 1}", draw_face(traits, place + 1), lambda h: outline(traits, h), traits.skin, traits.hair,
        traits.style,
    )  # fmt: skip


def png(picture: Image) -> bytes:
    """A picture as a PNG file."""
    _, data = cv2.imencode(".png", np.ascontiguousarray(picture[:, :, ::-1]))
    return bytes(data)


def from_file(path: Path, models: FaceModels) -> Portrait:
    """The largest face of a picture file, turned upright and cut to a portrait.

    Raises:
        SheetsError: it cannot be read, is no picture, or shows no face.
    """
    picture = read_picture(path)
    scale = min(1.0, FINE / max(picture.shape[:2]))
    if scale < 1:
        picture = np.asarray(
            cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8
        )
    # A face that fills the picture is found only with some room around it.
    edge = max(picture.shape[:2]) // 4
    roomy = np.asarray(cv2.copyMakeBorder(picture, edge, edge, edge, edge, cv2.BORDER_REPLICATE), dtype=np.uint8)
    face = max(models.find(roomy), key=lambda f: f.width * f.height, default=None)
    if face is None:
        raise SheetsError(f"No face can be found in the picture “{path.name}”.", REMEDY)
    square = _upright(roomy, face)
    skin = _colour_of(square[SIDE * 55 // 100 : SIDE * 65 // 100, SIDE // 4 : SIDE * 3 // 4])
    hair = _colour_of(square[SIDE // 50 : SIDE // 8, SIDE // 3 : SIDE * 2 // 3])
    return Portrait(path.name, _faded(square, skin, hair), lambda h: outline(_ANYBODY, h), skin, hair, "short")


def read_picture(path: Path) -> Image:
    """A PNG or JPEG file as (height, width, 3), red first, turned as its camera says.

    Raises:
        SheetsError: it is missing, too large, too small, no such file, or broken.
    """
    name = path.name
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SheetsError(f"The picture “{name}” is larger than {MOST_BYTES // 1_000_000} MB.", "Make it smaller.")
        with Pillow.open(path, formats=FORMATS) as opened:
            wide, high = opened.size
            if wide * high > MOST_PIXELS:
                raise SheetsError(
                    f"The picture “{name}” has {wide} × {high} pixels, which is too large.", "Make it smaller."
                )
            if min(wide, high) < LEAST:
                raise SheetsError(f"The picture “{name}” has only {wide} × {high} pixels.", REMEDY)
            return _upright_as_taken(opened)
    except (OSError, ValueError, SyntaxError, Pillow.DecompressionBombError, UnidentifiedImageError) as error:
        why = (
            error.strerror if isinstance(error, OSError) and error.strerror else "it is no PNG or JPEG, or it is broken"
        )
        raise SheetsError(f"The picture “{name}” cannot be read: {why}.", REMEDY) from None


def _upright_as_taken(opened: Any) -> Image:
    from PIL import ImageOps

    turned = ImageOps.exif_transpose(opened)
    if turned.mode in ("RGBA", "LA", "PA") or "transparency" in turned.info:
        shown = turned.convert("RGBA")
        wall = Pillow.new("RGBA", shown.size, tuple(round(c * 255) for c in (*PALE, 1.0)))
        turned = Pillow.alpha_composite(wall, shown)
    return np.asarray(turned.convert("RGB"), dtype=np.uint8)


def _upright(picture: Image, face: Found) -> Image:
    """The face turned, moved and scaled so that eyes and mouth are where a portrait has them."""
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
    matrix = np.column_stack([turn, move])
    return np.asarray(
        cv2.warpAffine(picture, matrix, (SIDE, SIDE), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE),
        dtype=np.uint8,
    )


def _faded(picture: Image, skin: RGB, hair: RGB) -> Image:
    """What was behind the person goes over into skin and hair towards the outline: it lies on the head's sides."""
    along = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    half = np.array([max(outline(_ANYBODY, -float(y)), 1e-3) for y in along])
    across = np.abs(along)[None, :] / half[:, None]
    mask = np.clip((across - FADES) / (1 - FADES), 0, 1)[:, :, None]
    high = np.clip((HAIRLINE - along) / 0.2 + 0.5, 0, 1)[:, None, None]
    colour = 255 * (high * np.array(hair) + (1 - high) * np.array(skin) * 0.85)
    return np.asarray(picture * (1 - mask) + colour * mask, dtype=np.uint8)


def _colour_of(patch: Image) -> RGB:
    red, green, blue = (float(c) / 255 for c in np.median(patch.reshape(-1, 3), axis=0))
    return red, green, blue


def studied(portrait: Portrait, models: FaceModels) -> list[Features]:
    """What a portrait looks like in numbers, from near and from farther away: as if the robot had been shown it."""
    numbers = []
    for size in (NEAR, FAR):
        picture = portrait.cut_out(size)
        faces = models.find(picture)
        if faces:
            numbers.append(models.features(picture, faces[0]))
    return numbers
