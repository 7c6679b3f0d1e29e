"""The pack on people: statements of the authors on consent and withdrawal, and what the operator controls."""

from __future__ import annotations

from rrp_sheets.graph import StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack import senses
from rrp_sheets.render.pack.model import Hand, Labelled, Stopping
from rrp_sheets.render.pack.source import Source, driver_refs

TOLD = "Participants are told"


def hand(source: Source) -> tuple[Hand, ...]:
    """Return a line for every button of the operator that rows take in."""
    return tuple(
        Hand(source.label(stream), source.sensors[stream], _leads_to(source, stream)) for stream in source.buttons
    )


def _leads_to(source: Source, stream: str) -> str:
    """Return the actuators that a value can reach, not counting what follows when one of them has ended."""
    reached, acts = {stream}, dict[str, None]()
    for behaviour in source.checked.graph.behaviours:
        for step in sorted(behaviour.steps, key=lambda s: s.rank):
            if not step.active or reached.isdisjoint(step.inputs):
                continue
            found = source.checked.graph.streams[step.output]
            if found.kind is StreamKind.ACTUATOR:
                acts[clean(found.name)] = None
            else:
                reached.add(step.output)
    return source.quoted(acts) if acts else source.get("hand.leads_to_nothing")


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
    chest = [ref for s, used in source.sensors.items() if _is_chest(source, s) for ref in used]
    lines.append(Stopping(get("stop.chest"), get("stop.chest_how" if chest else "stop.chest_none"), tuple(chest)))
    lines.append(Stopping(get("stop.failure"), get("stop.failure_how")))
    return tuple(lines)


def _is_chest(source: Source, stream: str) -> bool:
    shows = source.device_entry(source.checked.graph.streams[stream]).get("shows", ())
    zone = str(source.checked.graph.streams[stream].settings.get("zone") or "").casefold()
    return "touch chest" in shows or zone == "chest"


HAPPENS = "What happens"
_WANTED = ("Version", "Purpose", "Participants", "Contact", "Ethics reference", "Data kept", "Retention")
_ELSEWHERE = (
    "Title", "Authors", *_WANTED, HAPPENS, TOLD, "Consent", "Withdrawal", "Deletion", "Time limit", "Robot", "Language",
    "Face memory", "Camera pictures",
)  # fmt: skip


def consent(source: Source) -> tuple[Labelled, ...]:
    """Return consent, withdrawal and deletion: the authors' statements, and what the program does."""
    get = source.get
    lines = []
    for entry in ("consent", "withdrawal", "deletion"):
        label, field = get(f"consent.{entry}"), entry.capitalize()
        if text := source.protocol(field):
            lines.append(Labelled(label, text, stated=True))
        elif entry == "consent":
            lines.append(Labelled(label, get("consent.not_stated", field=field)))
        if entry != "consent":
            lines.append(Labelled(label, get(f"consent.{entry}_text")))
    if senses.remembers_faces(source) and source.checked.run.keeps_faces:
        lines.append(Labelled(get("consent.deletion"), get("consent.deletion_faces")))
    return tuple(lines)


def statements(source: Source) -> tuple[Labelled, ...]:
    """Return the fields of the Protocol sheet that stand nowhere else in the pack."""
    protocol = source.checked.workbook.protocol
    elsewhere = {key(name) for name in _ELSEWHERE}
    return tuple(
        Labelled(clean(protocol.names.get(name, name)), cell.text)
        for name, cell in protocol.fields.items()
        if cell.text and name not in elsewhere
    )


def unstated(source: Source) -> list[str]:
    """Return the fields that a board asks for and the Protocol sheet lacks."""
    wanted = [*_WANTED, "Consent", *([TOLD] if source.buttons else [])]
    return [name for name in wanted if not source.protocol(name)]


def missing(source: Source) -> str:
    """Return the lacking fields in words; empty when there are none."""
    lacks = unstated(source)
    return source.get("consent.missing", list=source.listed(lacks)) if lacks else ""
