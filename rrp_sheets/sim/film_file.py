"""Writes film and strip while the run goes on: a simulator that is killed loses the last moment only.

All of it happens on a thread, so that the robot need not wait for pictures to be packed.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import SimpleQueue

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from rrp_sheets.sim.camera import Shot
from rrp_sheets.sim.strip import film_frame, palette_of, write_strip

FRAME_MS = 333  # ms, of a film picture
SAME = 255  # the palette's place for what stays as it was; palettes have fewer colours
OFF, MOST_OFF = 40, 0.0005  # a colour is wrong by so much (of 255); of so many pixels, the film needs other colours
MOST_SAMPLES = 6  # pictures that a palette is made from
STRIP_EVERY = 5.0  # s (wall clock) between two strips at least; the last one is written when the robot rests
STRIP_SHARE = 20  # and so many times as long as the last one took, so that strips cost little on a busy machine
_END = b";"


@dataclass(frozen=True, eq=False)
class _Picture:
    pixels: NDArray[np.uint8]  # places in the palette
    palette: bytes


class FilmFile:
    """An animated GIF that is whole after each picture: three a second, with clock, what the robot sees and says.

    A palette serves until a picture has other colours: the background then stays the same to the pixel and costs
    nothing.

    Args:
        path: of the file, which is made with the first picture.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._pictures: dict[int, _Picture] = {}  # by the shot's time
        self._size = (0, 0)
        self._palette = Image.new("P", (1, 1))
        self._samples: list[NDArray[np.uint8]] = []
        self._last: _Picture | None = None

    def add(self, shot: Shot) -> None:
        """Append a picture. Raises OSError when it cannot be written."""
        frame = film_frame(shot)
        self._size = frame.size
        packed = self._packed(frame) if self._samples else None
        if packed is None or _is_off(frame, packed):
            self._samples = [*self._samples[-MOST_SAMPLES + 1 :], np.asarray(frame)]
            self._palette = palette_of(self._samples)
            packed = self._packed(frame)
        picture = _Picture(np.asarray(packed), bytes(packed.getpalette("RGB") or ()))
        self._pictures[shot.us] = picture
        if self._last is None:
            self._path.write_bytes(self._header() + _encoded(picture, None) + _END)
        else:
            with self._path.open("r+b") as file:
                file.seek(-len(_END), 2)
                file.write(_encoded(picture, self._last) + _END)
        self._last = picture

    def keep(self, shots: Sequence[Shot]) -> None:
        """Drop all other pictures. Raises OSError when it cannot be written."""
        self._pictures = {shot.us: self._pictures[shot.us] for shot in shots if shot.us in self._pictures}
        half = self._path.with_suffix(".part")
        before = None
        try:
            with half.open("wb") as file:
                file.write(self._header())
                for picture in self._pictures.values():
                    file.write(_encoded(picture, before))
                    before = picture
                file.write(_END)
            half.replace(self._path)
        finally:
            half.unlink(missing_ok=True)
        self._last = before

    def _packed(self, frame: Image.Image) -> Image.Image:
        return frame.quantize(palette=self._palette, dither=Image.Dither.NONE)

    def _header(self) -> bytes:
        """No palette of its own, and it begins again at its end."""
        width, height = (side.to_bytes(2, "little") for side in self._size)
        return b"GIF89a" + width + height + b"\x70\0\0!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"


def _is_off(frame: Image.Image, packed: Image.Image) -> bool:
    """Whether a picture has colours that its palette does not have."""
    wrong = cv2.absdiff(np.asarray(frame), np.asarray(packed.convert("RGB"))) > OFF
    return bool((wrong[..., 0] | wrong[..., 1] | wrong[..., 2]).mean() > MOST_OFF)


def _encoded(picture: _Picture, before: _Picture | None) -> bytes:
    """A picture as a block of a GIF; what stays as it was is left out."""
    pixels, (left, top) = picture.pixels, (0, 0)
    if before is not None and before.palette == picture.palette:
        changed = pixels != before.pixels
        rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
        top, bottom = (int(rows[0]), int(rows[-1]) + 1) if len(rows) else (0, 1)
        left, right = (int(columns[0]), int(columns[-1]) + 1) if len(columns) else (0, 1)
        part = np.s_[top:bottom, left:right]
        pixels = np.where(changed[part], pixels[part], np.uint8(SAME))
    image = Image.fromarray(pixels)
    image.putpalette(picture.palette)
    return b"".join(
        GifImagePlugin.getdata(
            image, (left, top), include_color_table=True, duration=FRAME_MS, disposal=1, transparency=SAME
        )
    )


class FilmWriter:
    """Writes `film.gif` and `strip.png` into a run's folder, shot by shot, on a thread.

    Args:
        folder: of the run.
        title: shown on the strip.
    """

    def __init__(self, folder: Path, title: str) -> None:
        self._film, self._strip = folder / "film.gif", folder / "strip.png"
        self._title = title
        self._file = FilmFile(self._film)
        self._work: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._error: Exception | None = None
        self._strip_at = time.monotonic() + STRIP_EVERY
        self._strip_waits = False
        self._thread = threading.Thread(target=self._write, name="film", daemon=True)
        self._thread.start()

    def add(self, shots: Sequence[Shot], *, thinned: bool) -> None:
        """Write the last of these shots; when they were thinned, the film keeps only these.

        Args:
            shots: all so far.
            thinned: whether there were more before.
        """
        now = list(shots)
        if thinned:
            self._work.put(partial(self._file.keep, now))
        else:
            self._work.put(partial(self._file.add, now[-1]))
        if time.monotonic() >= self._strip_at and not self._strip_waits:
            self._strip_waits = True
            self._work.put(partial(self._write_strip, now))

    def finish(self, shots: Sequence[Shot]) -> None:
        """Write what is left, and wait for it. Raises OSError: then no half film stays."""
        self._work.put(partial(self._write_strip, list(shots)))
        self._work.put(None)
        self._thread.join()
        if self._error is not None:
            self._film.unlink(missing_ok=True)
            self._strip.unlink(missing_ok=True)
            raise self._error

    def _write_strip(self, shots: Sequence[Shot]) -> None:
        half, began = self._strip.with_suffix(".part.png"), time.monotonic()
        try:
            write_strip(half, shots, self._title)
            half.replace(self._strip)
        finally:
            half.unlink(missing_ok=True)
            self._strip_at = time.monotonic() + max(STRIP_EVERY, STRIP_SHARE * (time.monotonic() - began))
            self._strip_waits = False

    def _write(self) -> None:
        while (work := self._work.get()) is not None:
            if self._error is None:
                try:
                    work()
                except Exception as error:  # a full disk, say: the run goes on, and at its end this is raised
                    self._error = error
