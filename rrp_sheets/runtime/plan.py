"""What of a checked workbook runs: its active rows in order, and the devices they use."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.checks import Checked
from rrp_sheets.graph import Step, Stream, StreamKind
from rrp_sheets.model.exchange import DeviceUse


@dataclass(frozen=True)
class Plan:
    """The rows that run, by rank, and their devices in the order of the rows."""

    checked: Checked
    steps: tuple[Step, ...]
    streams: tuple[Stream, ...]
    sensors: tuple[DeviceUse, ...]
    actuators: tuple[DeviceUse, ...]
    dones: dict[str, str]  # streams that tell the end of commands, each with its actuator stream (ids)
    descent: dict[str, tuple[str, ...]]  # of each actuator row (its ref): the sensor streams it descends from


def make_plan(checked: Checked) -> Plan:
    """The plan of all behaviours that the Protocol lets run."""
    chosen = [b for b in checked.graph.behaviours if b.key in checked.run.behaviours]
    steps = sorted((s for b in chosen for s in b.steps if s.active), key=lambda s: s.rank)
    ids = dict.fromkeys(i for s in steps for i in (*s.inputs, s.output))
    streams = tuple(checked.graph.streams[i] for i in ids if checked.graph.streams[i].active)
    sensors = tuple(_use(s) for s in streams if s.kind is StreamKind.SENSOR)
    actuators = tuple(_use(s) for s in streams if s.kind is StreamKind.ACTUATOR)
    dones = {s.id: s.done_of for s in streams if s.kind is StreamKind.DONE}
    descent = _descent(steps, {*(s.stream for s in sensors), *dones})
    return Plan(checked, tuple(steps), streams, sensors, actuators, dones, descent)


def _use(stream: Stream) -> DeviceUse:
    assert stream.device is not None
    return DeviceUse(stream.id, stream.name, stream.device.type.name, stream.settings)


def _descent(steps: list[Step], sensors: set[str]) -> dict[str, tuple[str, ...]]:
    above: dict[str, dict[str, None]] = {s: {s: None} for s in sensors}  # dicts keep an order, sets do not
    found = {}
    for step in steps:
        mine: dict[str, None] = {}
        for source in step.inputs:
            mine.update(above.get(source, {}))
        if step.connector.drives:
            found[step.ref] = tuple(mine)
        else:
            above[step.output] = mine
    return found
