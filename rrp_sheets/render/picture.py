"""Writes one picture as .svg, .pdf or .png, which says in its metadata where it comes from."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

from rrp_sheets.render.output import target_of
from rrp_sheets.render.typeset import typeset
from rrp_sheets.workbook.atomic import write_atomically

SUFFIXES = (".svg", ".pdf", ".png")
_PPI = 144
_MOST_PIXELS = 40_000_000
_SIGNATURE, _HEAD = 8, 25  # bytes at the begin of a PNG: texts may come behind them


def picture_bytes(
    svg: str, size: tuple[float, float], suffix: str, title: str, about: Mapping[str, str]
) -> tuple[bytes, list[str]]:
    """A picture's file, and notes for the user.

    Args:
        svg: the picture.
        size: its width and height, in points.
        suffix: `.svg`, `.pdf` or `.png`.
        title: of the document.
        about: what it says of itself; the SVG has it already.

    Raises:
        SheetsError: Typst failed.
    """
    if suffix == ".svg":
        return svg.encode("utf-8", "replace"), []
    wide, high = size
    told = "; ".join(f"{name}: {value}" for name, value in about.items())
    data = {"title": title, "about": told, "width": wide, "height": high}
    if suffix == ".pdf":
        return typeset("picture.typ", data, {"picture.svg": svg}, "pdf")
    ppi = min(_PPI, int(72 * (_MOST_PIXELS / (wide * high)) ** 0.5))
    png, notes = typeset("picture.typ", data, {"picture.svg": svg}, "png", ppi=ppi)
    return with_texts(png, {"Title": title, "Description": told}), notes


def write_picture(svg: str, size: tuple[float, float], path: Path, title: str, about: Mapping[str, str]) -> list[str]:
    """Write a picture into a file whose suffix tells the format, whole or not at all; see `picture_bytes`."""
    target, suffix = target_of(path, "A picture", SUFFIXES)
    content, notes = picture_bytes(svg, size, suffix, title, about)
    write_atomically(target, content)
    return notes


def with_texts(png: bytes, texts: Mapping[str, str]) -> bytes:
    """A PNG with texts in it (as iTXt chunks), which image programs show."""
    begin = _SIGNATURE + _HEAD
    chunks = b""
    for name, text in texts.items():
        data = b"iTXt" + name.encode("latin-1", "replace")[:79] + b"\0\0\0\0\0" + text.encode("utf-8", "replace")
        chunks += struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    return png[:begin] + chunks + png[begin:]
