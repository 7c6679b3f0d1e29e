"""The words of diagrams and explanations: one catalogue per language (`en.toml`)."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Texts:
    """A language's catalogue; entries are named by their path (`row.merge`)."""

    language: str
    entries: Mapping[str, str]

    def has(self, name: str) -> bool:
        """Whether there is such an entry."""
        return name in self.entries

    def get(self, entry: str, /, **values: object) -> str:
        """An entry with its places filled; a missing entry is a KeyError."""
        text = self.entries[entry]
        return text.format(**values) if values else text

    def listed(self, things: list[str], joiner: str = "and") -> str:
        """`a, b and c`."""
        word = f" {self.entries[f'list.{joiner}']} "
        return word.join(filter(None, [", ".join(things[:-1]), *things[-1:]]))


@lru_cache(maxsize=8)
def texts(language: str = "en") -> Texts:
    """The catalogue of a language."""
    tables = tomllib.loads((Path(__file__).parent / f"{language}.toml").read_text(encoding="utf-8"))
    return Texts(language, dict(_flat(tables, "")))


def _flat(table: Mapping[str, Any], prefix: str) -> list[tuple[str, str]]:
    pairs: list[tuple[str, str]] = []
    for name, value in table.items():
        pairs += _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else [(prefix + name, str(value))]
    return pairs
