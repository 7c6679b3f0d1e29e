"""Sensors in the ethics pack, and the data that is kept."""

from __future__ import annotations

from rrp_sheets.checks.protocol import FIELD, kept_kinds, names_of, unnamed
from rrp_sheets.render.device_sentences import device_says
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack.model import Labelled, Ref, Sensed
from rrp_sheets.render.pack.source import Source, capital
from rrp_sheets.texts import told


def sensed(source: Source) -> tuple[Sensed, ...]:
    """Return a line for every sensor stream that rows take in; the operator's buttons share one."""
    lines = [_line(source, stream, used) for stream, used in source.sensors.items() if not source.is_button(stream)]
    if source.buttons:
        names = [clean(source.checked.graph.streams[s].name) for s in source.buttons]
        used = merged([ref for stream in source.buttons for ref in source.sensors[stream]])
        through = source.get("channel.operator")
        lines.append(Sensed(source.listed(names), through, source.presses(), _values(source, source.buttons[0]), used))
    return tuple(lines)


def _line(source: Source, stream: str, used: tuple[Ref, ...]) -> Sensed:
    found = source.checked.graph.streams[stream]
    through = source.get(f"channel.{source.channel(found)}")
    return Sensed(clean(found.name), through, device_says(found, source.words), _values(source, stream), used)


def _values(source: Source, stream: str) -> str:
    device = source.checked.graph.streams[stream].device
    if device is None:
        return ""
    if device.type.payload is not None:
        return source.listed(source.fields(device.type))
    unit = device.type.unit
    return source.get("sensed.number", unit=unit) if unit else source.get("sensed.joint")


def merged(refs: list[Ref]) -> tuple[Ref, ...]:
    """Merge references to the same behaviour, with its rows in order."""
    rows: dict[str, set[int]] = {}
    for ref in refs:
        rows.setdefault(ref.behaviour, set()).update(ref.rows)
    return tuple(Ref(name, tuple(sorted(numbers))) for name, numbers in rows.items())


def channels(source: Source) -> set[str]:
    """Return the channels of the sensors that rows take in, such as `camera`."""
    return {source.channel(source.checked.graph.streams[s]) for s in source.sensors}


def keeps_pictures(source: Source) -> bool:
    """Return whether pictures of the robot's camera are kept."""
    return "camera" in channels(source) and source.checked.run.keeps_pictures


def sees_faces(source: Source) -> bool:
    """Return whether a sensor looks for faces."""
    return any(
        "person" in source.device_entry(source.checked.graph.streams[s]).get("shows", ()) for s in source.sensors
    )


def remembers_faces(source: Source) -> bool:
    """Return whether a row lets the robot remember a face."""
    return any(d.stream.device and "memory" in d.stream.device.type.resources for d in source.drivers)


def kept(source: Source) -> tuple[Labelled, ...]:
    """Return the data that is stored, where and for how long: the program's own list, then the authors' statements."""
    get, through = source.get, channels(source)
    pictures = "none" if "camera" not in through else "kept" if keeps_pictures(source) else "not"
    speaks = any("voice" in d.stream.device.type.resources for d in source.drivers if d.stream.device)
    sound = "heard" if "microphone" in through else "none" if speaks else "silent"
    keeps = source.checked.run.keeps_faces
    remembers = "kept" if keeps else "run"
    faces = remembers if remembers_faces(source) else "seen" if sees_faces(source) else "none"
    if sees_faces(source) and keeps:
        faces = "kept"  # those of earlier runs are known again
    kinds = kept_kinds(source.checked.robot, source.checked.graph, source.checked.run)
    lines = [
        Labelled(get("kept.program"), get("kept.all", list=capital(told(names_of(kinds), source.words.language)))),
        Labelled(get("kept.trace"), get("kept.trace_text")),
        Labelled(
            get("kept.pictures"), source.words.sentences([get(f"kept.pictures_{pictures}"), get("kept.pictures_live")])
        ),
        Labelled(get("kept.sound"), get(f"kept.sound_{sound}")),
        Labelled(get("kept.faces"), get(f"kept.faces_{faces}")),
    ]
    for entry, name in (("kept.data", FIELD), ("kept.retention", "Retention")):
        if text := source.protocol(name):
            lines.append(Labelled(get(entry), text, stated=True))
            lacking = unnamed(text, kinds) if name == FIELD else []
            if lacking:
                less = get("kept.less_text", list=told(names_of(lacking), source.words.language))
                lines.append(Labelled(get("kept.less"), less))
    return tuple(lines)
