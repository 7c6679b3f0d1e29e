"""Graph of a workbook's rows: streams, steps (rows with their inputs resolved), and the order of the steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from rrp_sheets.connectors.spec import Connector
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Address, Row
from rrp_sheets.robots import FoundDevice

__all__ = ["BehaviourGraph", "Graph", "Step", "Stream", "StreamKind"]


class StreamKind(Enum):
    """Role of a stream: sensor, named or anonymous output of a row, actuator, or ends of an actuator's commands."""

    SENSOR = "sensor"
    ORDINARY = "stream"
    ACTUATOR = "actuator"
    ANONYMOUS = "anonymous"
    DONE = "done"


@dataclass(frozen=True)
class Stream:
    """A named sequence of values that rows read and write."""

    # unique in the workbook: the name's key for devices, `sheetkey!key` for ordinary streams, `sheetkey!#row` for
    # anonymous ones
    id: str
    name: str  # as first spelt; empty for anonymous streams
    kind: StreamKind
    address: Address  # the cell where it is first named (for a device that of its Devices row, if any)
    device: FoundDevice | None = None
    # the device's settings by key, presets and defaults filled in
    settings: Mapping[str, Value] = field(default_factory=dict)
    active: bool = True  # False when only switched-off rows feed it
    # of a done stream (`Say done`), the id of the actuator stream. It is not an edge from that stream, so the graph
    # stays acyclic.
    done_of: str = ""


@dataclass(frozen=True)
class Step:
    """A row with its connector found and its inputs and output resolved to stream ids."""

    row: Row
    ref: str  # the row as shown, `Tracking!4`
    connector: Connector
    inputs: tuple[str, ...]  # stream ids, in order (a blank input cell is resolved to the row above)
    output: str  # a stream id; for `subscribe` that of the actuator stream; an anonymous stream's for a blank cell
    period_us: int | None = None
    # the row is on and all its inputs are fed (of `once` and `timeout`: the first; of a merge: any)
    active: bool = True
    rank: int = 0  # the place in the topological order of the behaviour; ties by row number

    @property
    def number(self) -> int:
        """Number of the row in its sheet."""
        return self.row.number


@dataclass(frozen=True)
class BehaviourGraph:
    """One behaviour: its steps in the order of the sheet (switched-off rows included, inactive)."""

    name: str
    key: str
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class Graph:
    """All behaviours of a workbook and all their streams by id."""

    behaviours: tuple[BehaviourGraph, ...]
    streams: Mapping[str, Stream]
