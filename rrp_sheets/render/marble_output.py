"""Writes marble diagrams as .svg, .pdf, .png or .txt."""

from __future__ import annotations

import os
from collections.abc import Sequence

from rrp_sheets.errors import SheetsError
from rrp_sheets.render.marble_diagram import MarbleDiagram
from rrp_sheets.render.marble_text import marble_text
from rrp_sheets.render.marbles import draw_marbles
from rrp_sheets.render.measure import clean
from rrp_sheets.render.output import render_diagram, target_of
from rrp_sheets.workbook.atomic import write_atomically

SUFFIXES = (".svg", ".pdf", ".png", ".txt")


def write_marbles(scores: Sequence[MarbleDiagram], path: str | os.PathLike[str]) -> list[str]:
    """Write marble diagrams into a file whose suffix tells the format; returns warnings for the user.

    An .svg or .png stacks all into one picture, a .pdf has A4 pages. What the diagrams are about stands in the file's
    metadata, and as their foot in the picture.

    Raises:
        SheetsError: an unknown suffix, nothing to draw, a folder that cannot be written, or Typst failed.
    """
    target, suffix = target_of(path, "Marble diagrams", SUFFIXES)
    if suffix == ".txt":
        write_atomically(target, text_of(scores).encode())
        return []
    pages = draw_marbles(scores)
    if not pages:
        raise SheetsError("There is nothing to draw: no value came on any stream.")
    content, warnings = render_diagram(pages, suffix, legend=False, about=dict(scores[0].about))
    write_atomically(target, content)
    return warnings


def text_of(scores: Sequence[MarbleDiagram], width: int = 110) -> str:
    """All diagrams as plain text, each under its title."""
    return "\n".join(
        "\n".join([score.title, *marble_text(score, width), *filter(None, [clean(score.foot)]), ""]) for score in scores
    )
