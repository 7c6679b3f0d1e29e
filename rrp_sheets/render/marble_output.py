"""Writes marble diagrams as .svg, .pdf, .png or .txt."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.render.diagram import Page
from rrp_sheets.render.marble_text import marble_text
from rrp_sheets.render.marbles import draw_marbles
from rrp_sheets.render.output import render_diagram
from rrp_sheets.render.score import Score
from rrp_sheets.render.texts import texts
from rrp_sheets.render.typeset import typeset
from rrp_sheets.workbook.atomic import write_atomically

SUFFIXES = (".svg", ".pdf", ".png", ".txt")


def write_marbles(scores: Sequence[Score], path: str | os.PathLike[str]) -> list[str]:
    """Write marble diagrams into a file whose suffix tells the format; returns warnings for the user.

    An .svg or .png stacks all into one picture, a .pdf has A4 pages.

    Raises:
        SheetsError: an unknown suffix, nothing to draw, a folder that cannot be written, or Typst failed.
    """
    target = Path(path)
    suffix = target.suffix.casefold()
    if suffix not in SUFFIXES:
        raise SheetsError(
            f"Marble diagrams cannot be written as “{target.suffix or target.name}”.",
            f"Let the file's name end with one of: {', '.join(SUFFIXES)}.",
        )
    if suffix == ".txt":
        write_atomically(target, text_of(scores).encode())
        return []
    pages = draw_marbles(scores)
    if not pages:
        raise SheetsError("There is nothing to draw: no value came on any stream.")
    content, warnings = _pdf(pages) if suffix == ".pdf" else render_diagram(pages, suffix)
    write_atomically(target, content)
    return warnings


def text_of(scores: Sequence[Score], width: int = 110) -> str:
    """All diagrams as plain text, each under its title."""
    return "\n".join("\n".join([score.title, *marble_text(score, width), ""]) for score in scores)


def _pdf(pages: Sequence[Page]) -> tuple[bytes, list[str]]:
    words = texts()
    data = {
        "title": ", ".join(dict.fromkeys(page.title for page in pages)),
        "lang": words.language,
        "page_n_of_m": words.get("page.n_of_m"),
        "legend": {"width": 0, "alt": ""},
        "pages": [
            {
                "title": page.title, "caption": page.caption, "part": page.part, "alt": page.alt,
                "landscape": page.landscape, "width": page.width * page.scale, "legend": False,
            }
            for page in pages
        ],
    }  # fmt: skip
    pictures = {f"page-{n}.svg": page.svg for n, page in enumerate(pages)}
    return typeset("diagram.typ", data, pictures, "pdf")
