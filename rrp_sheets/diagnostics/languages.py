"""Translates findings: `catalogue/<language>/*.toml` map the English templates to those of the language."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.diagnostics.catalogue import CODES
from rrp_sheets.texts import SLOTS, Phrase

_FOLDER = Path(__file__).parent / "catalogue"
PHRASES = "phrases"
"""The table of a language's texts that belong to no code."""


def told(text: str, language: str) -> str:
    """Return a text of a finding in a language; a text without a translation stays English.

    >>> told(Phrase("Did you mean {guess}?", guess="redBall"), "ja")
    '「redBall」のことですか。'
    """
    return str(text) if language == "en" else _told(text, _templates(language))


def places_in(places: Mapping[str, Any], language: str) -> dict[str, Any]:
    """Return the values of places, those that are the program's words in a language.

    >>> places_in({"name": "Red", "guess": "Blue", "remedy": Phrase("Did you mean {guess}?", guess="Blue")}, "en")
    {'name': 'Red', 'guess': 'Blue', 'remedy': 'Did you mean Blue?'}
    """
    templates = {} if language == "en" else _templates(language)
    return {name: _place(name, value, templates) for name, value in places.items()}


def title(code: str, language: str) -> str:
    """Return the title of a code in a language."""
    entry = entries(language).get(code)
    return entry["title"] if entry else CODES[code].title


@lru_cache(maxsize=8)
def entries(language: str) -> Mapping[str, Mapping[str, str]]:
    """Return a language's texts: a table for every code (title, message, remedy), and one of phrases."""
    found: dict[str, dict[str, str]] = {PHRASES: {}}
    for file in sorted((_FOLDER / language).glob("*.toml")):
        for name, table in tomllib.loads(file.read_text(encoding="utf-8")).items():
            found.setdefault(name, {}).update(table)
    return found


@lru_cache(maxsize=8)
def _templates(language: str) -> Mapping[str, str]:
    """Return the language's templates by the English ones, also with the case of the first letter swapped."""
    found: dict[str, str] = {}
    for name, table in entries(language).items():
        if name == PHRASES:
            found |= table
        elif name in CODES:
            found |= {getattr(CODES[name], part): table[part] for part in ("message", "remedy")}
    return {english[:1].swapcase() + english[1:]: own for english, own in found.items()} | found


def _told(text: str, templates: Mapping[str, str]) -> str:
    if not isinstance(text, Phrase):
        return templates.get(text, text)
    template = templates.get(text.template, text.template)
    return template.format(**{name: _place(name, value, templates) for name, value in text.places.items()})


def _place(name: str, value: Any, templates: Mapping[str, str]) -> Any:
    """Return a place's value, translated if it is the program's own text; the user's text stays as it is."""
    if isinstance(value, Phrase) or (isinstance(value, str) and name in SLOTS):
        return _told(value, templates)
    return value
