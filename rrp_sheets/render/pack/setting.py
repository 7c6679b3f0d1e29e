"""Typesets the pack: its data and the words of the template go to Typst."""

from __future__ import annotations

from dataclasses import asdict
from typing import Literal

from rrp_sheets.render.legend import draw_legend
from rrp_sheets.render.pack.behaviours import Pictures
from rrp_sheets.render.pack.model import Pack
from rrp_sheets.render.texts import texts
from rrp_sheets.render.typeset import typeset

Paper = Literal["a4", "letter"]


def set_pack(pack: Pack, pictures: Pictures, paper: Paper = "a4") -> tuple[bytes, list[str]]:
    """Return the pack as a PDF, and warnings in words, of a missing font for example.

    Raises:
        SheetsError: Typst could not set it.
    """
    words = texts(pack.language)
    legend, wide, _ = draw_legend(pack.language)
    own = {name.removeprefix("pack."): text for name, text in words.entries.items() if name.startswith("pack.")}
    data = {
        "paper": {"a4": "a4", "letter": "us-letter"}[paper],
        "t": own,
        "quoted": own["says.quoted"],
        "page_n_of_m": words.get("page.n_of_m"),
        "legend": {"title": words.get("legend.title"), "alt": words.get("legend.alt"), "width": wide},
        "pack": asdict(pack),
    }
    return typeset("pack.typ", data, {**pictures, "legend.svg": legend}, "pdf")
