"""Help on a stream of a workbook: the rows that give it and those that use it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rrp_sheets.graph import Graph, Step, Stream
from rrp_sheets.help.layout import Block, columns, heading, paragraph, titled
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.texts import N_

_MOST_ROWS = 20  # that are listed


def find_stream(graph: Graph, sheet: str, name: str) -> Stream | None:
    """Return the stream that a name means on a sheet: one of its rows', or one of the sheet Devices."""
    return graph.streams.get(f"{key(sheet)}!{key(name)}") or graph.streams.get(key(name))


def one_stream(workbook: Workbook, graph: Graph, stream: Stream, examples: Mapping[str, str]) -> Iterator[Block]:
    """A stream: its device with the settings, where it is made, who uses it, and an example value."""
    yield heading(stream.name)
    device = next((d for d in workbook.devices if key(d.stream.text) == key(stream.name)), None)
    if stream.device is None:
        yield paragraph(N_("A stream of this workbook."))
    elif device is None:
        yield paragraph(N_("The device “{device}”, with its usual settings.", device=stream.device.name))
    else:
        place = device.stream.address
        yield paragraph(N_("The device “{device}”, as {place} says.", device=stream.device.name, place=place))
        if rows := [(device.headers.get(name, name), cell.text) for name, cell in device.settings.items() if cell]:
            yield titled(N_("Settings"), columns(rows))
    steps = [step for behaviour in graph.behaviours for step in behaviour.steps]
    made = [step for step in steps if step.output == stream.id and not step.connector.is_sink]
    ends = {s.id for s in graph.streams.values() if s.done_of == stream.id}
    uses = [s for s in steps if {stream.id, *ends} & set(s.inputs) or (s.output == stream.id and s.connector.is_sink)]
    if made:
        yield titled(N_("Made by"), columns(_rows(made)))
    if uses:
        yield titled(N_("Used by"), columns(_rows(uses)))
    else:
        yield paragraph(N_("No row uses it."))
    if example := examples.get(stream.id, ""):
        yield titled(N_("For example"), paragraph(example))


def _rows(steps: list[Step]) -> list[tuple[str, str, str]]:
    rows = [(s.ref, s.connector.name, s.row.formula.text if s.row.formula else "") for s in steps[:_MOST_ROWS]]
    return [*rows, *([("…", "", "")] if len(steps) > _MOST_ROWS else [])]
