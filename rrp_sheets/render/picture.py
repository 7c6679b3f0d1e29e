"""Writes one picture as .svg, .pdf or .png, which says in its metadata where it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rrp_sheets.render.image_metadata import png_with, words_of
from rrp_sheets.render.output import target_of
from rrp_sheets.render.typeset import typeset
from rrp_sheets.workbook.atomic import write_atomically

SUFFIXES = (".svg", ".pdf", ".png")
_PPI = 144
_MOST_PIXELS = 40_000_000


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
    told = words_of(about)
    data = {"title": title, "about": told, "width": wide, "height": high}
    if suffix == ".pdf":
        return typeset("picture.typ", data, {"picture.svg": svg}, "pdf")
    ppi = min(_PPI, int(72 * (_MOST_PIXELS / (wide * high)) ** 0.5))
    png, notes = typeset("picture.typ", data, {"picture.svg": svg}, "png", ppi=ppi)
    return png_with(png, {"Title": title, "Description": told}), notes


def write_picture(svg: str, size: tuple[float, float], path: Path, title: str, about: Mapping[str, str]) -> list[str]:
    """Write a picture into a file whose suffix tells the format, whole or not at all; see `picture_bytes`."""
    target, suffix = target_of(path, "A picture", SUFFIXES)
    content, notes = picture_bytes(svg, size, suffix, title, about)
    write_atomically(target, content)
    return notes
