"""The order in which rows settle; circles; which rows are active; what goes nowhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.graph.model import Step, Stream, StreamKind
from rrp_sheets.graph.sorting import after_needs

LONGEST_CHAIN = 500
_BREAK = "Break the circle: one of these rows must take another input."


def set_in_order(
    steps: list[Step], streams: dict[str, Stream], report: Report, first_rank: int, *, complete: bool
) -> tuple[Step, ...]:
    """The steps with their ranks and whether they are active; in the order of the sheet.

    `complete` is False when rows are missing because they could not be understood: what seems to go nowhere may
    then go into one of those, and nothing is said about it.
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
    _mark_streams(done, streams)
    if complete:
        _tell_unused(done, streams, report, in_circle)
    return done


def _tell_circles(
    needs: Mapping[int, list[int]], steps: list[Step], streams: dict[str, Stream], report: Report
) -> set[int]:
    """Report the circles, and give the steps in them."""
    import networkx as nx  # only here: most workbooks have no circles, and it takes longer to load than they to check

    graph = nx.DiGraph((j, i) for i, needed in needs.items() for j in needed)
    circles = [sorted(c) for c in nx.strongly_connected_components(graph) if len(c) > 1 or graph.has_edge(*(*c, *c))]
    for members in sorted(circles):
        part = graph.subgraph(members)
        start = min(part, key=lambda i: steps[i].number)
        path = [start] if part.has_edge(start, start) else [edge[0] for edge in nx.find_cycle(part, start)]
        words = [f"{streams[steps[i].output].name or 'unnamed'} ({steps[i].row.output.address})" for i in path]
        remedy = _remedy(steps[start], streams) if path == [start] else _BREAK
        report.add("GRAPH010", steps[start].row.output.address, path=" → ".join([*words, words[0]]), remedy=remedy)
    return {i for members in circles for i in members}


def _remedy(step: Step, streams: Mapping[str, Stream]) -> str:
    """What to do about a row that takes its own output: most want to go on from its last value."""
    name = streams[step.output].name
    if step.connector.name != "accumulate" or not name:
        return _BREAK
    return Phrase(
        "Take {name} out of the input streams: in the formula of accumulate, “total” is its last value.", name=name
    )


def _active(order: list[int], steps: list[Step], streams: dict[str, Stream], in_circle: set[int]) -> dict[int, bool]:
    fed = {k for k, s in streams.items() if s.kind in (StreamKind.SENSOR, StreamKind.DONE)}
    active: dict[int, bool] = {}
    for i in order:
        step = steps[i]
        inputs = [source in fed for source in step.inputs]
        active[i] = step.row.on and i not in in_circle and _fed(step, inputs)
        if active[i]:
            fed.add(step.output)
    return active


def _fed(step: Step, inputs: list[bool]) -> bool:
    """Whether enough of a row's inputs are fed for it to be of use."""
    if step.connector.any_input or (step.connector.is_sink and not step.row.formula):
        return any(inputs)
    return inputs[0] if step.connector.first_input else all(inputs)


def _tell_long_chains(needs: Mapping[int, list[int]], order: list[int], steps: list[Step], report: Report) -> None:
    length: dict[int, int] = {}
    for i in order:
        if i not in needs:
            continue
        length[i] = 1 + max((length[j] for j in needs[i]), default=0)
        if length[i] == LONGEST_CHAIN + 1:  # told where it becomes too long, not for every row after it
            report.add("GRAPH012", steps[i].row.output.address, count=length[i])


def _mark_streams(steps: tuple[Step, ...], streams: dict[str, Stream]) -> None:
    fed = {s.output for s in steps if s.active}
    for step in steps:
        stream = streams[step.output]
        if stream.kind in (StreamKind.ORDINARY, StreamKind.ANONYMOUS) and step.output not in fed:
            streams[step.output] = replace(stream, active=False)


def _tell_unused(steps: tuple[Step, ...], streams: dict[str, Stream], report: Report, in_circle: set[int]) -> None:
    read = {source for s in steps if s.row.on for source in s.inputs}
    for i, step in enumerate(steps):
        if step.row.on and not step.connector.is_sink and step.output not in read and i not in in_circle:
            stream = streams[step.output]
            if stream.kind is StreamKind.ORDINARY:
                report.add("GRAPH011", step.row.output.address, name=stream.name)
