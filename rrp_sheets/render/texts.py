"""Texts of diagrams and explanations: the English ones in `texts.toml`, the others in the catalogues."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.durations import show_duration
from rrp_sheets.texts import LANGUAGES, N_, LazyMessage, listed, sentences, translate


@dataclass(frozen=True)
class Texts:
    """A language's catalogue; entries are named by their path (`name.it`)."""

    language: str
    entries: Mapping[str, str]

    def has(self, name: str) -> bool:
        """Return whether there is an entry of that name."""
        return name in self.entries

    def get(self, entry: str, /, **values: object) -> str:
        """Return an entry with its places filled; a missing entry is a KeyError."""
        text = self.entries[entry]
        return text.format(**values) if values else text

    def listed(self, things: Sequence[str], joiner: str = "and") -> str:
        """Return `a, b and c`; `joiner` is `and` or `or` for nouns, `all` or `any` for conditions."""
        start = self.entries["list.comma"].join(things[:-1])
        return self.entries[f"list.{joiner}"].join(filter(None, [start, *things[-1:]]))

    def in_a_row(self, things: Sequence[str]) -> str:
        """Return `a, b, c`."""
        return self.entries["list.comma"].join(things)

    def sentences(self, parts: Sequence[str]) -> str:
        """Join sentences to a paragraph."""
        return translate(sentences(*parts), self.language)

    def duration(self, us: int) -> str:
        """Return a duration (µs) in words: `10 s`."""
        number, unit = show_duration(us).split(" ")
        return self.get(f"duration.{unit}", n=number)


@lru_cache(maxsize=8)
def texts(language: str = "en") -> Texts:
    """Return the catalogue of a language; raise SheetsError when there is none."""
    if language not in LANGUAGES:
        raise SheetsError(
            N_("There are no texts in the language “{language}”.", language=language),
            N_("There are: {names}.", names=listed(list(LANGUAGES))),
        )
    tables = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return Texts(
        language, {name: translate(LazyMessage(text, msgctxt=name), language) for name, text in _flat(tables, "")}
    )


def _flat(table: Mapping[str, Any], prefix: str) -> list[tuple[str, str]]:
    pairs: list[tuple[str, str]] = []
    for name, value in table.items():
        pairs += _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else [(prefix + name, str(value))]
    return pairs
