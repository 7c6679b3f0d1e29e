"""Builds the graph from the rows: finds connectors, resolves names and blank inputs, and sorts the rows."""

from __future__ import annotations

import heapq
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from typing import TypeVar

from rrp_sheets.connectors import Connector, Parameter
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, Insert, Put, meant
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.graph.device_table import DeviceTable
from rrp_sheets.graph.names import Names
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Behaviour, Row, Workbook
from rrp_sheets.registry import Registry
from rrp_sheets.robots import FoundDevice, Robot
from rrp_sheets.texts import N_, listed

__all__ = ["StreamKind", "build_graph"]

SHORTEST_US = 50_000  # a bare number below this was surely meant in seconds
_FORMULA = re.compile(r"""["'<>=&+*/^()]|\w\.\w|^\d""")
"""Matches formulas and durations, and no connector's name."""
_IN_SIMULATION = {
    "sensor": N_("It sends no values in a simulated run."),
    "actuator": N_("In a simulated run, its actions end at once as not completed."),
}
_EXAMPLES = {"map": "redBall.distance", "filter": "distance < 0.5"}
LONGEST_CHAIN = 500
_BREAK = N_("Break the circle: give one of these rows another input.")
T = TypeVar("T")


def build_graph(workbook: Workbook, robot: Robot, connectors: Registry[Connector], report: Report) -> Graph:
    """Build the graph of all behaviours and report findings; rows that cannot be understood are left out."""
    devices = DeviceTable(workbook, robot, report)
    streams: dict[str, Stream] = {}
    behaviours = []
    rank = 0
    sheets = frozenset(key(b.name) for b in workbook.behaviours)
    for behaviour in workbook.behaviours:
        before = len(report)
        builder = _Builder(behaviour, devices, connectors, streams, report, sheets)
        found = builder.steps()
        read = None if builder.refused else builder.read
        steps = set_in_order(found, streams, report, rank, read)
        rank += len(steps)
        behaviours.append(BehaviourGraph(behaviour.name, key(behaviour.name), steps))
        if behaviour.rows and not any(s.active for s in steps) and len(report) == before and not builder.failed:
            report.add("GRAPH014", behaviour.address)
    _tell_not_simulated(behaviours, streams, report)
    return Graph(tuple(behaviours), streams)


def _tell_not_simulated(behaviours: Sequence[BehaviourGraph], streams: Mapping[str, Stream], report: Report) -> None:
    """Report each device that the simulated robot lacks once, with the streams of active rows that use it."""
    used = dict.fromkeys(i for b in behaviours for s in b.steps if s.active for i in (*s.inputs, s.output))
    lacking: dict[str, list[tuple[Stream, FoundDevice]]] = {}
    for stream in (streams[i] for i in used):
        if stream.device is not None and not stream.device.type.simulated:
            lacking.setdefault(stream.device.type.name, []).append((stream, stream.device))
    for those in lacking.values():
        first, found = those[0]
        names = ", ".join(stream.name for stream, _ in those)
        report.add("DEV009", first.address, device=found.name, streams=names, then=_IN_SIMULATION[found.type.kind])


class _Builder:
    """Builder of the steps of one behaviour.

    `failed` is True when a row could not be understood, `refused` when an input could not; `read` are the inputs of
    rows without a step.
    """

    def __init__(
        self, behaviour: Behaviour, devices: DeviceTable, connectors: Registry[Connector], streams: dict[str, Stream],
        report: Report, sheets: frozenset[str],
    ) -> None:  # fmt: skip
        self.behaviour = behaviour
        self.connectors = connectors
        self.report = report
        self.failed = self.refused = False
        self.read: set[str] = set()
        self.found = [self._connector(row) for row in behaviour.rows]
        self.names = Names(behaviour, self.found, devices, streams, report, sheets)

    def steps(self) -> list[Step]:
        rows = self.behaviour.rows
        steps: list[Step] = []
        read_below = self._read_by_next()
        above: tuple[str, ...] | None = None  # what a blank input means in this row
        above_refused = False  # whether a name among them was refused, which was told there
        for i, (row, connector) in enumerate(zip(rows, self.found, strict=True)):
            inputs, refused = self._inputs(row, above)
            refused = refused or (above_refused and not row.inputs)
            output = self.names.output(row, connector, read_below[i]) if connector else None
            if connector is not None and not refused and inputs is not None and output is not None:
                steps.append(self._step(row, connector, inputs, output))
            else:  # rows that are off count too: their inputs are not unused
                self.failed = True
                self.refused = self.refused or refused or inputs is None
                self.read.update(inputs or ())
            if row.on:  # "above" skips rows that are switched off
                drives = connector is not None and connector.is_sink
                above = inputs if drives else (self.names.output_id(row),)
                above_refused = drives and refused
        return steps

    def _connector(self, row: Row) -> Connector | None:
        cell = row.connector
        if not cell:
            if row.on:
                self.report.add("CONN001", cell.address)
            return None
        connector = self.connectors.get(cell.text)
        if connector is None and row.on:
            names = list(dict.fromkeys(c.name for c in self.connectors))
            guess = self._called(cell.text) or nearest(cell.text, self.connectors.names())
            remedy = N_("Choose one of {names}.", names=", ".join(names))
            if _FORMULA.search(cell.text):
                words = N_("This looks like a formula, which belongs in the column Formula. Choose one of {names} "
                           "here.")  # fmt: skip
                remedy = N_(words, names=", ".join(names))
            self.report.add("CONN002", cell.address, name=cell.text, **meant(guess, remedy))
        return connector

    def _called(self, word: str) -> str | None:
        """Return the connector that people call by a plain word (`count`), or None."""
        return next((c.name for c in self.connectors if key(word) in map(key, c.words)), None)

    def _inputs(self, row: Row, above: tuple[str, ...] | None) -> tuple[tuple[str, ...] | None, bool]:
        """Return the stream ids of a row's inputs, and whether a name among them was refused."""
        if not row.inputs:
            if above is None and row.on:
                self.report.add("GRAPH003", row.inputs_cell.address)
            return above, False
        ids = [self.names.input(cell, row) for cell in row.inputs]
        return tuple(i for i in ids if i is not None), None in ids

    def _read_by_next(self) -> list[bool]:
        """Return for each row whether the next one reads it by a blank input cell; rows that are off count as well."""
        taken, found = [], False
        for row in reversed(self.behaviour.rows):
            taken.append(found)
            found = not row.inputs or (found and not row.on)
        return taken[::-1]

    def _step(self, row: Row, connector: Connector, inputs: Sequence[str], output: str) -> Step:
        step = Step(row, f"{self.behaviour.name}!{row.number}", connector, tuple(inputs), output)
        if not row.on:
            return replace(step, active=False, period_us=parse_duration(row.formula.text))
        before = len(self.report)
        count, least, most = len(inputs), connector.min_inputs, connector.max_inputs
        at = row.inputs_cell.address
        if count < least:
            self.report.add("CONN003", at, connector=connector.name, least=least, count=count)
        if len(set(inputs)) < count:
            self.report.add("CONN009", at)
        elif most is not None and count > most:
            allowed = N_("one input stream") if most == 1 else N_("{most} input streams", most=most)
            needs_combining = _reads_several(row)
            remedy, fixes = _combining(row) if needs_combining else _merging(row, connector)
            self.report.add(
                "CONN004", at, fixes=fixes, connector=connector.name, most=allowed, count=count, remedy=remedy
            )
            if needs_combining:  # whose formula is not to be told as a wrong period
                connector = self.connectors.get("combineLatest") or connector
        self.refused = self.refused or len(self.report) > before
        period = self._parameter(row, connector)
        self.failed = self.failed or len(self.report) > before
        return replace(step, period_us=period)

    def _parameter(self, row: Row, connector: Connector) -> int | None:
        cell = row.formula
        if connector.parameter is Parameter.PERIOD:
            if not cell:
                self.report.add("CONN007", cell.address, connector=connector.name)
                return None
            period = parse_duration(cell.text)
            if not period:
                guess = meant_duration(cell.text)
                remedy = N_("Did you mean {meant}? ", meant=guess) if guess else ""
                self.report.add("CONN008", cell.address, text=cell.text, remedy=remedy, guess=guess)
            elif period < SHORTEST_US and cell.text.replace(".", "").isdigit():
                seconds = f"{cell.text} s"
                edit = Put(cell.address, seconds)
                fix = Fix("write-seconds", N_("Write {value}", value=seconds), (edit,), safe=True)
                self.report.add("CONN010", cell.address, text=cell.text, fixes=[fix])
            return period or None
        if connector.parameter is Parameter.FORMULA and not cell:
            example = _EXAMPLES.get(connector.name, "value")
            self.report.add("CONN005", cell.address, connector=connector.name, example=example)
        if connector.parameter is Parameter.NONE and cell:
            self.report.add("CONN006", cell.address, connector=connector.name)
        return None


def _reads_several(row: Row) -> bool:
    """Return whether the formula of a row names more than one of its inputs."""
    words = {key(word) for word in re.findall(r"\w+", row.formula.text)}
    return sum(key(name.text) in words for name in row.inputs) > 1


def _combining(row: Row) -> tuple[str, list[Fix]]:
    """Return the remedy and the fix for too many inputs of a formula that reads several of them."""
    fix = Fix("combine", N_("Write {value}", value="combineLatest"), (Put(row.connector.address, "combineLatest"),))
    return N_("Write combineLatest as the connector: its formula uses the latest value of each input."), [fix]


def _merging(row: Row, connector: Connector) -> tuple[str, list[Fix]]:
    """Return the remedy and the fixes for other rows with too many inputs: merge above; for `sample` also one alone."""
    cell, place = row.inputs_cell, row.connector.address
    above = Insert(place.sheet, place.row, ((cell.address.column, cell.text), (place.column, "merge")))
    merged = (above, Put(replace(cell.address, row=place.row + 1), ""))
    fixes = [Fix("merge", N_("Add a row with {connector} above", connector="merge"), merged)]
    if connector.name != "sample" or not row.inputs:
        return N_("Join them in a row above: merge passes on every value, combineLatest the latest of each."), fixes
    first = row.inputs[0].text
    alone = Fix("alone", N_("Write {value}", value=first), (Put(cell.address, first),))
    return N_("Write “{name}” alone, and the time between two values in Formula. To use all inputs, join them in a row "
              "above with merge.", name=first), [alone, *fixes]  # fmt: skip


def set_in_order(
    steps: list[Step], streams: dict[str, Stream], report: Report, first_rank: int, read: Collection[str] | None
) -> tuple[Step, ...]:
    """Return the steps in the order of the sheet, with their ranks and whether they are active.

    `read` are the inputs of rows without a step; None when one of them could not be understood: an output without
    readers may then be meant there, and is not reported.
    """
    maker = {s.output: i for i, s in enumerate(steps) if s.row.on and not s.connector.is_sink}
    needs: dict[int, list[int]] = {
        i: list(dict.fromkeys(maker[source] for source in s.inputs if source in maker)) if s.row.on else []
        for i, s in enumerate(steps)
    }
    in_circle: set[int] = set()
    order = after_needs(needs, lambda i: (steps[i].number, i))
    if len(order) < len(steps):
        in_circle = _tell_circles(needs, steps, streams, report)
        needs = {i: [j for j in needed if j not in in_circle] for i, needed in needs.items() if i not in in_circle}
        order = after_needs(needs, lambda i: (steps[i].number, i)) + sorted(in_circle)
    ranks = {i: first_rank + place for place, i in enumerate(order)}
    active = _active(order, steps, streams, in_circle)
    _tell_long_chains(needs, order, steps, report)
    done = tuple(replace(s, rank=ranks[i], active=active[i]) for i, s in enumerate(steps))
    fed = {s.output for s in done if s.active}
    taken = {source for s in done if s.row.on for source in s.inputs} | set(read or ())
    for i, step in enumerate(done):
        stream = streams[step.output]
        if stream.kind in (StreamKind.ORDINARY, StreamKind.ANONYMOUS) and step.output not in fed:
            streams[step.output] = replace(stream, active=False)
        unused = read is not None and step.row.on and step.output not in taken and i not in in_circle
        if unused and stream.kind is StreamKind.ORDINARY and not step.connector.is_sink:
            report.add("GRAPH011", step.row.output.address, name=stream.name)
    return done


def _tell_circles(
    needs: Mapping[int, list[int]], steps: list[Step], streams: dict[str, Stream], report: Report
) -> set[int]:
    """Report the cycles and return the indexes of the steps in them."""
    import networkx as nx  # only here: most workbooks have no circles, and it takes longer to load than they to check

    graph = nx.DiGraph((j, i) for i, needed in needs.items() for j in needed)
    circles = [sorted(c) for c in nx.strongly_connected_components(graph) if len(c) > 1 or graph.has_edge(*(*c, *c))]
    for members in sorted(circles):
        part = graph.subgraph(members)
        start = min(part, key=lambda i: steps[i].number)
        path = [start] if part.has_edge(start, start) else [edge[0] for edge in nx.find_cycle(part, start)]
        cells = [(streams[steps[i].output].name, steps[i].row.output.address) for i in path]
        words = [f"{name} ({cell})" if name else N_("unnamed ({cell})", cell=str(cell)) for name, cell in cells]
        remedy = _remedy(steps[start], streams) if path == [start] else _BREAK
        report.add("GRAPH010", steps[start].row.output.address, path=listed([*words, words[0]], "→"), remedy=remedy)
    return {i for members in circles for i in members}


def _remedy(step: Step, streams: Mapping[str, Stream]) -> str:
    """Return the remedy for a row that reads its own output; for `accumulate` it names `total`, the last value."""
    name = streams[step.output].name
    if step.connector.name != "accumulate" or not name:
        return _BREAK
    return N_("Remove {name} from the input streams. In the formula, write total for the last value of {name}.",
              name=name)  # fmt: skip


def _active(order: list[int], steps: list[Step], streams: dict[str, Stream], in_circle: set[int]) -> dict[int, bool]:
    fed = {k for k, s in streams.items() if s.kind in (StreamKind.SENSOR, StreamKind.DONE)}
    active: dict[int, bool] = {}
    for i in order:
        step, connector = steps[i], steps[i].connector
        inputs = [source in fed for source in step.inputs]
        if connector.any_input or (connector.is_sink and not step.row.formula):
            enough = any(inputs)
        else:
            enough = all(inputs[:1] if connector.first_input else inputs)
        active[i] = step.row.on and i not in in_circle and enough
        if active[i]:
            fed.add(step.output)
    return active


def _tell_long_chains(needs: Mapping[int, list[int]], order: list[int], steps: list[Step], report: Report) -> None:
    length: dict[int, int] = {}
    for i in order:
        if i not in needs:
            continue
        length[i] = 1 + max((length[j] for j in needs[i]), default=0)
        if length[i] == LONGEST_CHAIN + 1:  # told where it becomes too long, not for every row after it
            report.add("GRAPH012", steps[i].row.output.address, count=length[i])


def after_needs(needs: Mapping[T, Collection[T]], place: Callable[[T], object]) -> list[T]:
    """Sort things topologically; of those that could come next, the one with the lowest place comes first.

    Things in cycles, and those that need them, are left out. Of what a thing needs each is given once, and is a key
    of the mapping; no two things share a place.

    >>> after_needs({"a": ["b"], "b": [], "c": []}, "cba".index), after_needs({"a": ["b"], "b": ["a"]}, str)
    (['c', 'b', 'a'], [])
    """
    sorter = TopologicalSorter(needs)
    with suppress(CycleError):  # after which it still gives what is in no cycle
        sorter.prepare()
    ready: list[tuple[object, T]] = [(place(thing), thing) for thing in sorter.get_ready()]
    heapq.heapify(ready)
    order = []
    while ready:
        thing = heapq.heappop(ready)[1]
        order.append(thing)
        sorter.done(thing)
        for other in sorter.get_ready():
            heapq.heappush(ready, (place(other), other))
    return order
