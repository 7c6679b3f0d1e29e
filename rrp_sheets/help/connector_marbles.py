"""A connector's example as marbles, in a picture or in plain text, made by running it in virtual time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from rrp_sheets.connectors import Connector
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.help.workbooks import checked
from rrp_sheets.model.exchange import Arrivals, Command, SceneAction, State, WorldSnapshot
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.render.example_drawing import example_value
from rrp_sheets.render.marble_diagram import Lane, MarbleDiagram, make_score

MARK_US = 100_000
"""Time, in µs, that one place in a row of marbles represents."""
_AFTER_US = 1_000_000  # what may still come after the last marble
_MARBLES = re.compile(r"[-\w]*-[-\w]*")
_NAMES = ("First", "Second", "Third", "Fourth")
_JOINTS = ("HeadYaw", "HeadPitch", "LHand", "RHand")


def parts(connector: Connector) -> tuple[list[str], str]:
    """The example's rows of marbles, and its formula or period (empty when there is none)."""
    rows = [text for text in connector.example if _MARBLES.fullmatch(text)]
    rest = [text for text in connector.example if not _MARBLES.fullmatch(text)]
    return rows, rest[0] if rest else ""


def can_be_run(connector: Connector) -> bool:
    """Return whether the connector has an example that makes a workbook without errors."""
    return 1 <= len(parts(connector)[0]) <= len(_NAMES) and not checked(workbook(connector)).report.errors


def input_names(count: int) -> list[str]:
    """Return the names of that many inputs; a single one is `Input`."""
    return ["Input"] if count == 1 else list(_NAMES[:count])


def workbook(connector: Connector) -> str:
    """The example as a workbook: sensors whose values the rows of marbles give, and one row with the connector."""
    rows, parameter = parts(connector)
    names = input_names(len(rows))
    body = [f'| {name} sensor | map | IF(TRUE; value; "") | {name} |' for name in names]  # so it loses the joint's unit
    body.append(f"| {', '.join(names)} | {connector.name} | {parameter} | {output_name(connector)} |")
    if not connector.is_sink:
        body.append("| Output | subscribe | | Print |")
    joints = [f"| {name} sensor | JointPosition | {joint} |" for name, joint in zip(names, _JOINTS, strict=False)]
    return "\n".join([
        "## Example", "| Input streams | Connector | Formula | Output stream |", "|---|---|---|---|", *body, "",
        "## Devices", "| Stream | Device | Joint |", "|---|---|---|", *joints,
    ])  # fmt: skip


def example_score(connector: Connector) -> MarbleDiagram:
    """Run a connector's example, and return what goes in and what comes out as a marble diagram."""
    from rrp_sheets.engine.engine import FrameEngine
    from rrp_sheets.engine.frame_runner import FrameRunner
    from rrp_sheets.engine.plan import make_plan

    rows, _ = parts(connector)
    names = input_names(len(rows))
    sent = [
        (at * MARK_US, key(f"{name} sensor"), int(c) if c.isdigit() else c)
        for name, row in zip(names, rows, strict=True)
        for at, c in enumerate(row)
        if c != "-"
    ]
    book, log = checked(workbook(connector)), _Log()
    world, last_us = ScriptedWorld(sent), max((us for us, _, _ in sent), default=0)
    FrameRunner(world, lambda: FrameEngine(make_plan(book), log)).go(last_us + _AFTER_US, RunObserver())
    whole = make_score(book.graph, book.graph.behaviours[0], log.events, log.errors)
    groups = {group.lane.label: group for group in whole.groups}
    output = groups[output_name(connector)]
    bars = tuple(replace(bar, row=0) for bar in output.bars)
    shown = (*(replace(groups[name], bars=()) for name in names), replace(output, bars=bars))
    return MarbleDiagram(connector.name, shown, 0, whole.last_us)


def output_name(connector: Connector) -> str:
    """Return the name of the example's output stream."""
    return "Print" if connector.is_sink else "Output"


class _Log(RunObserver):
    """Log of an engine: its events and errors, as marble diagrams take them."""

    def __init__(self) -> None:
        self.events: list[tuple[int, str, str, Value]] = []
        self.errors: list[tuple[int, str, str]] = []

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        self.events.append((us, stream, row, value))

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        self.errors.append((us, row, failure.message))


def marbles(connector: Connector) -> list[tuple[str, str]]:
    """The lines of the picture: a name and a row of marbles each; the last one is what came out of a run."""
    lanes = {lane.label: _places(lane) for lane in example_score(connector).lanes}
    length = max(max((*map(len, parts(connector)[0]), *(at + 1 for at in places))) for places in lanes.values())
    width = max(len(mark) for places in lanes.values() for mark in ("-", *places.values()))
    return [
        (name, "".join(places.get(at, "-").ljust(width, "-") for at in range(length))) for name, places in lanes.items()
    ]


def _places(lane: Lane) -> dict[int, str]:
    """Return the marbles of a stream by their place in its row: `a`, or `(ab)` for several."""
    found: dict[int, list[str]] = {}
    for marble in lane.marbles:
        found.setdefault(round(marble.us / MARK_US), []).append(example_value(marble.value))
    return {at: texts[0] if len(texts) == 1 else f"({','.join(texts)})" for at, texts in found.items()}


class ScriptedWorld:
    """World that gives prepared values, for checking behaviours in virtual time.

    Attributes:
        received: the commands that came, with the time of the frame they were given in.
        acted: what people did to the world.
    """

    def __init__(self, events: Iterable[tuple[int, str, Value]]) -> None:
        self._events = sorted(events, key=lambda e: e[0])
        self._next = 0
        self._last_us = 0
        self.received: list[tuple[int, Command]] = []
        self.acted: list[SceneAction] = []

    def start(self) -> Arrivals:
        """The values of time 0."""
        return Arrivals(self._until(0))

    def advance(self, now_us: int, commands: Sequence[Command]) -> Arrivals:
        """The values since the frame before."""
        self.received.extend((self._last_us, c) for c in commands)
        self._last_us = now_us
        return Arrivals(self._until(now_us))

    def act(self, actions: Sequence[SceneAction]) -> None:
        """Nothing is there that could be moved: it is only collected."""
        self.acted.extend(actions)

    def show(self, picture: bool) -> WorldSnapshot:
        """There is nothing to see."""
        return WorldSnapshot(State({}, (), (), "", {}))

    def stop(self) -> None:
        """Nothing to let go of."""

    def _until(self, us: int) -> list[tuple[str, Value]]:
        first = self._next
        while self._next < len(self._events) and self._events[self._next][0] <= us:
            self._next += 1
        return [(stream, value) for _, stream, value in self._events[first : self._next]]
