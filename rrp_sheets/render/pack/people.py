"""The pack on people: sensors, data that is kept, statements of the authors on consent, what the operator controls."""

from __future__ import annotations

from rrp_sheets.checks.ethics import touches_chest
from rrp_sheets.checks.protocol import FIELD, kept_kinds, names_of, unnamed
from rrp_sheets.render.pack.model import Hand, Labelled, Ref, Sensed, Stopping
from rrp_sheets.render.pack.source import Source, driver_refs
from rrp_sheets.render.pack.study import CONSENT, DATA, OPERATOR, elsewhere, stated
from rrp_sheets.render.sentences import device_says
from rrp_sheets.render.style import clean
from rrp_sheets.texts import capital, translate


def hand(source: Source) -> tuple[Hand, ...]:
    """Return a line for every button of the operator that rows take in; what follows an action's end is left out."""
    lines = []
    for button in source.buttons:
        reached = [d for d in source.drivers if source.ways(d.step.ref, button)]
        names = [[clean(d.stream.name) for d in reached if d.stops is stops] for stops in (False, True)]
        does = (source.quoted(dict.fromkeys(part)) if part else source.get("nothing") for part in names)
        lines.append(Hand(source.label(button), source.sensors[button], *does))
    return tuple(lines)


def always(source: Source) -> tuple[str, ...]:
    """Return the actions that the operator has in every run, whatever the rows are."""
    entries = ["sends", "types", "switches", "pauses", "edits", "scene"]
    if not any(source.channel(source.checked.graph.streams[s]) == "microphone" for s in source.sensors):
        entries.remove("types")
    return tuple(source.get(f"hand.{entry}") for entry in entries)


def stops(source: Source) -> tuple[Stopping, ...]:
    """Return the ways in which a run ends."""
    get, limit = source.get, source.checked.run.time_limit_us
    lines = [Stopping(get("stop.button"), get("stop.button_how"))]
    how = get("stop.limit_how", limit=source.words.duration(limit)) if limit else get("stop.limit_none")
    lines.append(Stopping(get("stop.limit"), how))
    ends = [d for d in source.drivers if "all" in (d.stream.device.type.resources if d.stream.device else ())]
    if ends:
        lines.append(Stopping(get("stop.row"), get("stop.row_how"), driver_refs(ends)))
    touched = [used for s, used in source.sensors.items() if touches_chest(source.checked.graph.streams[s])]
    chest = [ref for used in touched for ref in used]
    lines.append(Stopping(get("stop.chest"), get("stop.chest_how" if chest else "stop.chest_none"), merged(chest)))
    lines += [Stopping(get(f"stop.{entry}"), get(f"stop.{entry}_how")) for entry in ("failure", "computer")]
    return tuple(lines)


HAPPENS = "What happens"


def consent(source: Source) -> tuple[Labelled, ...]:
    """Return consent, withdrawal and deletion: the authors' statements, and what the program does."""
    get = source.get
    lines = list(stated(source, CONSENT))
    lines += [Labelled(get(f"consent.{entry}"), get(f"consent.{entry}_text")) for entry in ("page", "withdrawal")]
    lines.append(Labelled(get("consent.deletion"), get("consent.deletion_text")))
    if "faces" in commands(source):
        lines.append(Labelled(get("consent.deletion"), get("consent.deletion_faces")))
    return tuple(lines)


def commands(source: Source) -> dict[str, str]:
    """Return the commands of the program that consent and deletion need, by what they are for."""
    found = {
        "page": "rrp-sheets print WORKBOOK --for participants", "deletion": "rrp-sheets runs delete --participant CODE",
    }  # fmt: skip
    if remembers_faces(source) and source.checked.run.keeps_faces:
        found["faces"] = "rrp-sheets faces --forget NAME"
    return found


def statements(source: Source) -> tuple[Labelled, ...]:
    """Return the fields of the Protocol sheet that stand nowhere else in the pack."""
    protocol, known = source.checked.workbook.protocol, elsewhere()
    return tuple(
        Labelled(clean(protocol.names.get(name, name)), cell.text)
        for name, cell in protocol.fields.items()
        if cell.text and name not in known
    )


def operator(source: Source) -> tuple[Labelled, ...]:
    """Return what participants learn about what a person drives by hand; empty when nobody does."""
    return stated(source, OPERATOR, marked=False) if source.buttons else ()


def sensed(source: Source) -> tuple[Sensed, ...]:
    """Return a line for every sensor stream that rows take in; the operator's buttons share one."""
    lines = []
    streams = source.checked.graph.streams
    for stream, used in source.sensors.items():
        if not source.is_button(stream):
            name, through = clean(streams[stream].name), source.get(f"channel.{source.channel(streams[stream])}")
            notices = device_says(streams[stream], source.words)
            lines.append(Sensed(name, through, notices, _values(source, stream), used))
    if source.buttons:
        names = source.words.listed([source.label(s) for s in source.buttons])
        used = merged([ref for stream in source.buttons for ref in source.sensors[stream]])
        through, values = source.get("channel.operator"), _values(source, source.buttons[0])
        lines.append(Sensed(names, through, source.presses(source.buttons), values, used))
    return tuple(lines)


def _values(source: Source, stream: str) -> str:
    device = source.checked.graph.streams[stream].device
    if device is None:
        return ""
    if device.type.payload is not None:
        return source.words.listed(source.fields(device.type))
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
    return any(source.shows(stream, "person") for stream in source.sensors)


def remembers_faces(source: Source) -> bool:
    """Return whether a row lets the robot remember a face."""
    return any(d.stream.device and "memory" in d.stream.device.type.resources for d in source.drivers)


def kept(source: Source) -> tuple[Labelled, ...]:
    """Return the data that is stored, where and for how long: the program's own list, then the authors' statements."""
    get, through = source.get, channels(source)
    pictures = "none" if "camera" not in through else "kept" if keeps_pictures(source) else "not"
    speaks = any("voice" in d.stream.device.type.resources for d in source.drivers if d.stream.device)
    sound = "heard" if "microphone" in through else "none" if speaks else "silent"
    sees, remembers = sees_faces(source), remembers_faces(source)
    if source.checked.run.keeps_faces and (sees or remembers):
        faces = "kept"  # those of earlier runs are known again
    else:
        faces = "run" if remembers else "seen" if sees else "none"
    kinds = kept_kinds(source.checked.robot, source.checked.graph, source.checked.run)
    shown = (f"pictures_{pictures}", "pictures_live", "film")
    lines = [
        Labelled(get("kept.program"), get("kept.all", list=capital(translate(names_of(kinds), source.words.language)))),
        Labelled(get("kept.trace"), get("kept.trace_text")),
        Labelled(get("kept.pictures"), source.words.sentences([get(f"kept.{entry}") for entry in shown])),
        Labelled(get("kept.sound"), get(f"kept.sound_{sound}")),
        Labelled(get("kept.faces"), get(f"kept.faces_{faces}")),
    ]
    said = stated(source, DATA)
    lacking = unnamed(text, kinds) if (text := source.protocol(FIELD)) else []
    if lacking:
        less = get("kept.less_text", list=translate(names_of(lacking), source.words.language))
        said = (said[0], Labelled(get("kept.less"), less), *said[1:])
    return (*lines, *said)
