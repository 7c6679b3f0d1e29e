"""Plan of a run: the active rows of a checked workbook in order, and the devices they use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rrp_sheets.checks import Checked
from rrp_sheets.graph import BehaviourGraph, Step, Stream, StreamKind
from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.model.names import key


@dataclass(frozen=True)
class Plan:
    """The rows that run, by rank, and their devices in the order of the rows.

    Attributes:
        dones: streams that tell the end of commands, each with its actuator stream (ids).
        descent: of each actuator row (its ref): the sensor streams it descends from.
        behaviours: by key, with the rows of each by rank; those that a row can switch on are among them.
        on: keys of the behaviours that are on at the start: those that the Protocol lets run.
        own: ids of the sensor and actuator streams whose devices the engine itself carries out.
        everything: whether the behaviours that no row can switch on are loaded too: somebody watches who can.
    """

    checked: Checked
    steps: tuple[Step, ...]
    streams: tuple[Stream, ...]
    sensors: tuple[DeviceUse, ...]
    actuators: tuple[DeviceUse, ...]
    dones: dict[str, str]
    descent: dict[str, tuple[str, ...]]
    behaviours: Mapping[str, tuple[Step, ...]]
    on: frozenset[str]
    own: frozenset[str]
    everything: bool = False

    @property
    def outer_sensors(self) -> tuple[DeviceUse, ...]:
        """Sensors that a world must provide."""
        return tuple(s for s in self.sensors if s.stream not in self.own)

    @property
    def outer_actuators(self) -> tuple[DeviceUse, ...]:
        """Actuators that a world must provide."""
        return tuple(a for a in self.actuators if a.stream not in self.own)

    def rows_by_rank(self) -> dict[int, str]:
        """Return the row (as shown) at each place of the order."""
        return {s.rank: s.ref for s in self.steps}


def make_plan(checked: Checked, *, everything: bool = False) -> Plan:
    """Return the plan of the behaviours that the Protocol lets run or that their rows can switch on, or of all."""
    graph = checked.graph
    chosen = list(graph.behaviours) if everything else _loaded(checked)
    steps = sorted((s for b in chosen for s in b.steps if s.active), key=lambda s: s.rank)
    ids = dict.fromkeys(i for s in steps for i in (*s.inputs, s.output))
    waited = (s for s in checked.cues if s.id not in ids and s.done_of in ids)  # of the scene, which no row reads
    streams = (*(graph.streams[i] for i in ids if graph.streams[i].active), *waited)
    sensors = tuple(_use(s) for s in streams if s.kind is StreamKind.SENSOR)
    actuators = tuple(_use(s) for s in streams if s.kind is StreamKind.ACTUATOR)
    dones = {s.id: s.done_of for s in streams if s.kind is StreamKind.DONE}
    return Plan(
        checked=checked, steps=tuple(steps), streams=streams, sensors=sensors, actuators=actuators, dones=dones,
        descent=_descent(steps, {*(s.stream for s in sensors), *dones}),
        behaviours={b.key: tuple(sorted((s for s in b.steps if s.active), key=lambda s: s.rank)) for b in chosen},
        on=frozenset(b.key for b in chosen if b.key in checked.run.behaviours),
        own=frozenset(s.id for s in streams if s.device is not None and s.device.type.engine),
        everything=everything,
    )  # fmt: skip


def _loaded(checked: Checked) -> list[BehaviourGraph]:
    """Return the behaviours that run or can be switched on, in the order of their sheets: others need no cameras."""
    graph = checked.graph
    loaded: set[str] = set()
    waiting = set(checked.run.behaviours)
    while waiting:
        loaded |= waiting
        outputs = {s.output for b in graph.behaviours if b.key in waiting for s in b.steps if s.active}
        devices = [(graph.streams[o].device, graph.streams[o].settings) for o in outputs]
        named = {key(str(settings.get("name") or "")) for device, settings in devices
                 if device is not None and device.type.engine and device.type.name == "Behaviour"}  # fmt: skip
        waiting = named - loaded
    return [b for b in graph.behaviours if b.key in loaded]


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
        if step.connector.is_sink:
            found[step.ref] = tuple(mine)
        else:
            above[step.output] = mine
    return found
