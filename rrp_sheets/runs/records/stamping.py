"""The film, the strip and the diagram in a run's folder say of which run they are, wherever they are taken.

The simulator that takes them knows nothing of the session, so they are stamped when the run is over.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

from rrp_sheets.render.image_metadata import gif_with, png_with, svg_with, words_of
from rrp_sheets.runs.records.stamp import stamp_of


def _film(data: bytes, about: Mapping[str, str]) -> bytes:
    return gif_with(data, about)


def _strip(data: bytes, about: Mapping[str, str]) -> bytes:
    return png_with(data, {"Description": words_of(about)})


def _diagram(data: bytes, about: Mapping[str, str]) -> bytes:
    return svg_with(data.decode(), about).encode("utf-8", "replace")


_PICTURES: Mapping[str, Callable[[bytes, Mapping[str, str]], bytes]] = {
    "film.gif": _film, "strip.png": _strip, "diagram.svg": _diagram,
}  # fmt: skip


def stamp_pictures(place: Path) -> None:
    """Write into the pictures of a run that was just made what its record says of it.

    Raises:
        OSError: one cannot be written; it is then as it was.
    """
    about = dict(stamp_of(place).pairs())
    for name, make in _PICTURES.items():
        path = place / name
        with suppress(FileNotFoundError):
            stamped = make(path.read_bytes(), about)
            half = path.with_name(name + ".part")
            try:
                half.write_bytes(stamped)
                os.replace(half, path)
            finally:
                half.unlink(missing_ok=True)
