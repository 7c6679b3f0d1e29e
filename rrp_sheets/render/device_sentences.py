"""The devices' own sentences (`says` in robot.toml), filled with their settings.

`says` may offer several texts, each for some settings: `mode=head: follow {source} with the head | follow {source}`;
the first whose conditions hold is taken. Places are settings by key, and `{source}`: what the value comes from.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from rrp_sheets.graph import Graph, Stream
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.model.values import show
from rrp_sheets.render.formula_words import Content, FieldNames
from rrp_sheets.render.measure import clean
from rrp_sheets.render.texts import Texts
from rrp_sheets.robots import FoundDevice
from rrp_sheets.robots.catalogue import DeviceWords

_CONDITIONS = re.compile(r"\s*((?:\w+=[\w ]*)(?:,\s*\w+=[\w ]*)*):\s+(.*)", re.DOTALL)


def device_says(stream: Stream, texts: Texts, source: str = "") -> str:
    """Return the sentence of a device: what an actuator does, or what happens when a sensor gives a value."""
    name = texts.get("name.quoted", name=clean(stream.name))
    words = stream.device.type.words(texts.language) if stream.device else None
    if stream.device is None or words is None or not words.says:
        sensor = stream.kind.value == "sensor"
        ended = sensor and key(stream.name).endswith("done")
        entry = "event.ended" if ended else "event.unknown" if sensor else "does.unknown"
        if ended:
            name = texts.get("name.quoted", name=re.sub(r"\s*done$", "", clean(stream.name), flags=re.IGNORECASE))
        return texts.get(entry, name=name)
    return _template(words.says, stream, texts, source)


def device_stops(stream: Stream, texts: Texts) -> str:
    """Return the sentence for a blank sent to an actuator: what it stops, or that it stops nothing."""
    name = texts.get("name.quoted", name=clean(stream.name))
    if stream.device is None:
        return texts.get("does.stop", name=name)
    stops = stream.device.type.words(texts.language).stops
    if not stops:
        return texts.get("does.stop_nothing", name=name)
    return texts.get("does.stop_device", stops=_template(stops, stream, texts), name=name)


def stops_at_a_blank(stream: Stream) -> bool:
    """Return whether a blank stops what an actuator does."""
    return stream.device is None or bool(stream.device.type.stops)


def _template(template: str, stream: Stream, texts: Texts, source: str = "") -> str:
    """Fill a text of the catalogue with the stream's settings."""
    assert stream.device is not None
    words = stream.device.type.words(texts.language)
    settings = {**stream.device.preset, **stream.settings}
    kinds = {k: s.kind for k, s in stream.device.type.settings.items()}
    shown = {k: _shown(v, kinds.get(k, ""), words, texts) for k, v in settings.items()}
    return _filled(_chosen(template, settings), shown, source, texts.get("name.quoted", name=clean(stream.name)), texts)


def device_title(stream: Stream, texts: Texts) -> str:
    """Return the name of a stream's device in a language; empty when it has no name in it."""
    return stream.device.type.words(texts.language).title if stream.device else ""


def field_names(graph: Graph, texts: Texts) -> FieldNames:
    """Return the names of record fields in a language, by the record's name and the field's key."""
    done = {(DONE.name, key(f.name)): texts.get(f"done.{key(f.name)}") for f in DONE.fields}
    kinds = [s.device.type for s in graph.streams.values() if s.device and s.device.type.payload]
    words = [(t.payload.name, t.words(texts.language).fields) for t in kinds if t.payload]
    return done | {(record, k): name for record, fields in words for k, (name, _) in fields.items()}


def _shown(value: object, kind: str, words: DeviceWords, texts: Texts) -> object:
    """Return a setting as it is printed: words of the catalogue translated, users' texts as they are."""
    if kind == "duration" and isinstance(value, int):
        return texts.duration(value)
    return words.said(value, kind) if isinstance(value, str) else value


def source_of(content: Content, graph: Graph, texts: Texts) -> str:
    """Return the source of a value in words: the things that the sensors behind it see."""
    streams = [graph.streams[i] for i in content.sensors]
    seen = [s for s in streams if s.device and s.device.type.payload]
    names = [texts.get("name.sensor", name=device_title(s, texts) or _thing(s.device)) for s in seen if s.device]
    names = list(dict.fromkeys(names))
    if len(names) == 1:
        return names[0]
    return texts.get("does.several", list=texts.listed(names, "or")) if names else texts.get("does.nothing_seen")


def _chosen(says: str, settings: Mapping[str, object]) -> str:
    text = ""
    for choice in says.split(" | "):
        match = _CONDITIONS.fullmatch(choice)
        if match is None:
            return choice
        conditions = (c.split("=", 1) for c in match[1].split(","))
        text = text or match[2]
        if all(key(str(settings.get(key(name)) or "")) == key(value) for name, value in conditions):
            return match[2]
    return text


def _filled(template: str, settings: Mapping[str, object], source: str, name: str, texts: Texts) -> str:
    def value(match: re.Match[str]) -> str:
        if match[1] == "source":
            return source or name
        if match[1] == "name" and "name" not in settings:
            return name
        found = settings.get(key(match[1]))
        if isinstance(found, tuple):
            found = texts.in_a_row([f"“{part}”" if "," in str(part) else str(part) for part in found])
        shown = found if isinstance(found, str) else show(found)
        return clean(shown)

    return re.sub(r"\{(\w+)\}", value, template)


def _thing(device: FoundDevice) -> str:
    """Return the name of what a sensor sees: the record's (`face`), unless the device has a name of its own."""
    record = device.type.payload
    name = record.name if record and key(device.name) == key(device.type.name) else device.name
    return name if name[1:2].isupper() else name[:1].lower() + name[1:]  # NAO stays
