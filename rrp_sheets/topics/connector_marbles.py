"""A connector's example as marbles in plain text, made by running it in virtual time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from rrp_sheets.connectors import Connector
from rrp_sheets.engine.ports import Arrivals
from rrp_sheets.model.exchange import Command, State, WorldSnapshot
from rrp_sheets.model.names import key
from rrp_sheets.model.scene_actions import SceneAction
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.topics.workbooks import checked

MARK_MS = 100
"""Time, in ms, that one place in a row of marbles represents."""
_AFTER_MS = 1_000  # what may still come after the last marble
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
    if connector.is_sink:
        body.append(f"| {', '.join(names)} | {connector.name} | {parameter} | Print |")
    else:
        body += [
            f"| {', '.join(names)} | {connector.name} | {parameter} | Output |",
            "| Output | subscribe | | Print |",
        ]
    joints = [f"| {name} sensor | JointPosition | {joint} |" for name, joint in zip(names, _JOINTS, strict=False)]
    return "\n".join([
        "## Example", "| Input streams | Connector | Formula | Output stream |", "|---|---|---|---|", *body, "",
        "## Devices", "| Stream | Device | Joint |", "|---|---|---|", *joints,
    ])  # fmt: skip


def marbles(connector: Connector) -> list[tuple[str, str]]:
    """The lines of the picture: a name and a row of marbles each; the last one is what came out of a run."""
    rows, _ = parts(connector)
    events = {name: _events(row) for name, row in zip(input_names(len(rows)), rows, strict=True)}
    came = _played(connector, events)
    length = max([len(row) for row in rows] + [at + 1 for at, _ in came])
    shown = {**events, "Print" if connector.is_sink else "Output": came}
    width = max(len(_mark(group)) for group in _grouped(shown.values()))
    return [(name, _line(found, length, width)) for name, found in shown.items()]


def _events(row: str) -> list[tuple[int, Value]]:
    return [(at, int(c) if c.isdigit() else c) for at, c in enumerate(row) if c != "-"]


def _played(connector: Connector, events: Mapping[str, Sequence[tuple[int, Value]]]) -> list[tuple[int, Value]]:
    from rrp_sheets.engine.engine import FrameEngine
    from rrp_sheets.engine.frame_runner import run_loop
    from rrp_sheets.engine.plan import make_plan

    pass

    book = checked(workbook(connector))
    names = {i: s.name for i, s in book.graph.streams.items()}
    log = _Log(names, "Print" if connector.is_sink else "Output")
    engine = FrameEngine(make_plan(book), log)
    sent = [(at * MARK_MS * 1000, key(f"{n} sensor"), value) for n, found in events.items() for at, value in found]
    world = ScriptedWorld(sent)
    last = max((us for us, _, _ in sent), default=0)
    run_loop(engine, world, world.start(), last + _AFTER_MS * 1000)
    return log.came


class _Log:
    """Keeps what came on one stream, with its place among the marbles."""

    def __init__(self, names: Mapping[str, str], stream: str) -> None:
        self.names, self.stream = names, stream
        self.came: list[tuple[int, Value]] = []
        self.failures: list[Failure] = []

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        if self.names.get(stream) == self.stream:
            self.came.append((round(us / 1000 / MARK_MS), value))

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """An example that fails shows nothing at that place; a test holds that none of ours does."""
        self.failures.append(failure)


def _grouped(lines: object) -> list[list[Value]]:
    groups: list[list[Value]] = [[]]
    for line in lines:  # type: ignore[attr-defined]
        places: dict[int, list[Value]] = {}
        for at, value in line:
            places.setdefault(at, []).append(value)
        groups += places.values()
    return groups


def _line(found: Sequence[tuple[int, Value]], length: int, width: int) -> str:
    places: dict[int, list[Value]] = {}
    for at, value in found:
        places.setdefault(at, []).append(value)
    return "".join(_mark(places.get(at, [])).ljust(width, "-") for at in range(length))


def _mark(values: Sequence[Value]) -> str:
    """The values of one place: `-` for none, `(ab)` for several."""
    texts = [short(v) for v in values]
    return "-" if not texts else texts[0] if len(texts) == 1 else f"({','.join(texts)})"


def short(value: Value) -> str:
    """A value as it stands on a marble.

    >>> short(0.12345), short("red"), short(None), short(True)
    ('0.123', 'red', 'blank', 'TRUE')
    """
    if value is None:
        return "blank"
    if isinstance(value, Record):
        return f"({'; '.join(short(v) for v in value.as_dict().values())})"
    return show(value).strip("“”")


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
