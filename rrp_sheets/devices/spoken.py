"""A robot's words in other languages: `robots/<name>/ja.toml` beside its catalogue; what is missing there is English.

`[values]` translates what the catalogue's settings may say (colours, zones), `[settings]` the names of the settings,
`[names]` the postures and gestures, `[fields.<name>]` the fields of all records,
`[device.<Name>]` a device: its title, help, `says`, `stops`, `takes`, and fields of its own that mean something else.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.model.languages import LANGUAGES
from rrp_sheets.model.names import key

Table = Mapping[str, Any]
_OURS = ("choice", "colour", "zone", "truth")  # kinds of settings whose words are the catalogue's own
_NAMED = ("posture", "gesture")


@dataclass(frozen=True)
class DeviceWords:
    """Texts that are printed about a device, in one language.

    Attributes:
        title: the device's name for people; empty when it has none but that of the catalogue.
        fields: name and help of its record's fields, by their keys.
        values: what its settings may say, by the key of the English word.
        names: what the postures and gestures of the robot are called, by the key of their names.
        settings: what the settings are called, by their keys.
    """

    title: str = ""
    help: str = ""
    says: str = ""
    takes: str = ""
    fields: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    values: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)
    stops: str = ""

    def name(self, text: str) -> str:
        """Return the name of a posture or a gesture in this language; any other text as it is."""
        return self.names.get(key(text), text)

    def said(self, text: str, kind: str) -> str:
        """Return a setting's text by its kind (`choice`, `text`, …): only the catalogue's words are translated."""
        return self.name(text) if kind in _NAMED else self.value(text) if kind in _OURS else text

    def setting(self, name: str) -> str:
        """Return the name of a setting in this language."""
        return self.settings.get(key(name), name)

    def value(self, text: str) -> str:
        """A word of the catalogue in this language; any other text as it is."""
        return self.values.get(key(text), text)


def words_of(folder: Path, device: str) -> dict[str, DeviceWords]:
    """Return the texts about a device in a robot's folder, by language."""
    stamp = tuple((p.name, p.stat().st_mtime_ns) for p in (folder / f"{c}.toml" for c in LANGUAGES) if p.is_file())
    return {code: _words(table, device) for code, table in _tables(folder, stamp).items()}


def _words(table: Table, device: str) -> DeviceWords:
    mine = _table(_table(table, "device"), device)
    shared, own = _table(table, "fields"), _table(mine, "fields")
    fields = {
        key(name): (_text({**_table(shared, name), **_table(own, name)}, "name"),
                    _text({**_table(shared, name), **_table(own, name)}, "help"))
        for name in dict.fromkeys([*shared, *own])
    }  # fmt: skip
    values, names, settings = (
        {key(name): text for name, text in _table(table, part).items() if isinstance(text, str)}
        for part in ("values", "names", "settings")
    )
    title, about, says, takes, stops = (_text(mine, name) for name in ("title", "help", "says", "takes", "stops"))
    return DeviceWords(title, about, says, takes, fields, values, names, settings, stops)


@lru_cache(maxsize=8)
def _tables(folder: Path, stamp: tuple[tuple[str, int], ...]) -> Mapping[str, Table]:
    """The tables of the languages that a robot's folder has besides English; read anew when a file has changed."""
    names = {code: f"{code}.toml" for code in LANGUAGES}
    had = {name for name, _ in stamp}
    return {c: tomllib.loads((folder / n).read_text(encoding="utf-8")) for c, n in names.items() if n in had}


def _table(table: Table, name: str) -> Table:
    inner = table.get(name)
    return inner if isinstance(inner, dict) else {}


def _text(table: Table, name: str) -> str:
    text = table.get(name)
    return text if isinstance(text, str) else ""
