"""Scene rows that wait for an event: of which stream."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.graph import Graph, Stream, StreamKind
from rrp_sheets.graph.names import DONE_DEVICE
from rrp_sheets.model.names import Proposals, key
from rrp_sheets.model.scene import ROW_ABOVE, SceneAction
from rrp_sheets.model.workbook import SceneRow

_ANY = "Write a stream that a row of this workbook reads or gives, or that tells the end of its actuator: Say done."
_PLAIN = (StreamKind.SENSOR, StreamKind.DONE, StreamKind.ORDINARY)


def find_cues(
    rows: Sequence[SceneRow], scene: Sequence[SceneAction], graph: Graph, report: Report
) -> tuple[tuple[SceneAction, ...], tuple[Stream, ...]]:
    """The actions with the ids of the streams that they wait for, and those streams.

    Args:
        rows: as they stand in the sheet.
        scene: what was understood of them, with the names of streams as they are typed.
        graph: of the workbook.
        report: takes the names that are of no stream.
    """
    cells = {row.time.address.row: row.time for row in rows}
    known: dict[str, Stream] | None = None
    propose = Proposals()
    found, streams = [], dict[str, Stream]()
    for action in scene:
        if action.cue in ("", ROW_ABOVE):
            found.append(action)
            continue
        known = known if known is not None else _by_name(graph)
        stream = known.get(_name(action.cue))
        if stream is None:
            guess = propose(action.cue, [s.name for s in known.values()])
            remedy = Phrase("Did you mean {guess}?", guess=guess) if guess else _ANY
            report.add("SCENE007", cells[action.row].address, name=action.cue, remedy=remedy)
            continue
        streams[stream.id] = stream
        found.append(replace(action, cue=stream.id))
    return tuple(found), tuple(streams.values())


def _by_name(graph: Graph) -> dict[str, Stream]:
    """The streams that a row may wait for, by the key of each name that means one: the first sheet's come first."""
    named: dict[str, Stream] = {}
    for stream in graph.streams.values():
        if stream.kind in _PLAIN and stream.active:
            named.setdefault(key(stream.name), stream)
            if stream.kind is StreamKind.ORDINARY:
                named.setdefault(f"{key(stream.address.sheet)}!{key(stream.name)}", stream)
        elif stream.kind is StreamKind.ACTUATOR and stream.active:
            done = f"{stream.id}done"
            made = Stream(done, f"{stream.name} done", StreamKind.DONE, stream.address, DONE_DEVICE, done_of=stream.id)
            named.setdefault(done, graph.streams.get(done, made))
    return named


def _name(text: str) -> str:
    sheet, mark, name = text.partition("!")
    return f"{key(sheet)}!{key(name)}" if mark else key(sheet)
