"""`help connectors`: the list; `help sample`: one of them, with its example run as marbles.

The marbles are a small picture or plain text, made by running the example in virtual time. The picture is for a narrow
panel whose style sheet gives the colours and fonts. `render.marble_drawing` draws for paper: whole behaviours, in
points, with colours of its own.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce

from markupsafe import Markup, escape

from rrp_sheets.connectors import Connector, Parameter, connectors
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.help.layout import FOR_EXAMPLE, Block, checked, entries, example, heading, paragraph, remark, titled
from rrp_sheets.help.layout import workbook as example_block
from rrp_sheets.model.exchange import Arrivals, Command, SceneAction, WorldSnapshot, WorldState
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Failure, Record, Value
from rrp_sheets.render.marble_diagram import Bar, Lane, Marble, MarbleDiagram, make_score, short
from rrp_sheets.texts import N_, listed, translate
from rrp_sheets.workbook.schema import BEHAVIOUR

_INPUTS, _CONNECTOR, _FORMULA, _OUTPUT = (column.name for column in BEHAVIOUR.required)
_CELLS = {
    Parameter.FORMULA: N_("a formula, or the name of a helper"),
    Parameter.OPTIONAL_FORMULA: N_("a formula or the name of a helper; may be blank"),
    Parameter.PERIOD: N_("a time: 500 ms, 2 s, 1 min; a number alone means milliseconds"),
    Parameter.NONE: N_("blank"),
}
IN_USE = {
    "once": (N_("To count each visitor once: the formula says what makes a visitor another one"), example("once")),
}
"""A workbook that shows what a connector is good for, with its title."""


def all_connectors() -> Iterator[Block]:
    """Yield the connectors, the small set first."""
    found = {c.name: c for c in connectors()}.values()
    yield paragraph(N_("A connector says what a row does with its input streams. For one with an example: "
                       "`rrp-sheets help sample`. You can spell a name in several ways: combineLatest, combine "
                       "latest and COMBINE_LATEST are the same."))  # fmt: skip
    for title, group in (
        (N_("To begin with"), [c for c in found if not c.advanced]),
        (N_("Advanced"), [c for c in found if c.advanced]),
    ):
        if group:
            yield heading(title)
            yield entries((c.name, c.help_message()) for c in group)


def one_connector(connector: Connector, language: str = "en") -> Iterator[Block]:
    """Yield a connector: what it does, what it takes, its sentence and its example."""
    title = N_("{name} (connector, advanced)" if connector.advanced else "{name} (connector)", name=connector.name)
    yield heading(title, connector.name)
    yield paragraph(connector.help_message())
    facts = [(N_("Inputs"), _count(connector)), (N_("Formula"), _CELLS[connector.parameter])]
    facts.append((N_("Output"), N_("an actuator") if connector.is_sink else N_("a new name")))
    synonyms = [s for s in connector.synonyms if key(s) != key(connector.name)]
    if synonyms:
        facts.append((N_("Also called"), ", ".join(synonyms)))
    yield entries(facts)
    if 1 <= len(parts(connector)[0]) <= len(_NAMES) and not checked(workbook(connector)).report.errors:
        yield from _example(connector, language)
    if connector.name in IN_USE:
        title, book = IN_USE[connector.name]
        yield titled(title, example_block(f"{connector.name} in use", book, language))


def _example(connector: Connector, language: str) -> Iterator[Block]:
    from rrp_sheets.render.sentences import Rows
    from rrp_sheets.render.texts import texts

    rows, parameter = parts(connector)
    names = ", ".join(input_names(len(rows)))
    cells = ((_INPUTS, names), (_CONNECTOR, connector.name), (_FORMULA, parameter), (_OUTPUT, output_name(connector)))
    yield titled(FOR_EXAMPLE, entries(cell for cell in cells if cell[1]))
    book = checked(workbook(connector))
    step = next(s for s in reversed(book.graph.behaviours[0].steps) if s.connector.name == connector.name)
    yield titled(N_("In words"), remark(Rows(book.graph, book.workbook, texts(language)).sentence(step)))
    picture = Block("marbles", connector.name, tuple(marbles(connector)))
    yield titled(N_("As marbles: one place is {n} ms, time goes to the right", n=MARK_US // 1000), picture)


def _count(connector: Connector) -> str:
    least, most = connector.min_inputs, connector.max_inputs
    if most == least:
        return N_("{n} input", n=least) if least == 1 else N_("{n} inputs", n=least)
    if most is None:
        return N_("{n} or more", n=least)
    return N_("{n} to {most}", n=least, most=most)


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
    from rrp_sheets.engine.plan import make_plan
    from rrp_sheets.engine.runners import FrameRunner

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
    rows = {name: [places.get(at, "-") for at in range(length)] for name, places in lanes.items()}
    return [(name, "".join(mark.ljust(width, "-") for mark in row)) for name, row in rows.items()]


def _places(lane: Lane) -> dict[int, str]:
    """Return the marbles of a stream by their place in its row: `a`, or `(ab)` for several."""
    found: dict[int, list[str]] = {}
    for marble in lane.marbles:
        found.setdefault(round(marble.us / MARK_US), []).append(example_value(marble.value))
    return {at: texts[0] if len(texts) == 1 else f"({','.join(texts)})" for at, texts in found.items()}


class ScriptedWorld:
    """World that gives prepared values, for checking behaviours in virtual time."""

    def __init__(self, events: Iterable[tuple[int, str, Value]]) -> None:
        self._events = deque(sorted(events, key=lambda e: e[0]))
        self._last_us = 0
        self.received: list[tuple[int, Command]] = []  # with the time of the frame that each was given in
        self.acted: list[SceneAction] = []  # what people did to the world

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
        return WorldSnapshot(WorldState({}, (), (), "", {}))

    def stop(self) -> None:
        """Nothing to let go of."""

    def _until(self, us: int) -> list[tuple[str, Value]]:
        found = []
        while self._events and self._events[0][0] <= us:
            found.append(self._events.popleft()[1:])
        return found


# ---- the picture
_WIDE = 400  # pixels, where the marbles have room in it
_NAME, _RIGHT, _LANE, _BAR, _AXIS = 52, 40, 36, 32, 24
_RADIUS, _LETTER, _GAP = 12, 4, 4  # of a marble; half a letter's width; between two marbles
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # seconds between the marks of the time
_LEAST_STEP = 44  # pixels


def draw_example(score: MarbleDiagram, language: str = "en") -> Markup:
    """Draw the example of a connector: its inputs, a bar for the connector, the output (the last group), the time.

    The picture is described in words in a language.
    """
    *inputs, output = score.groups
    lanes = [group.lane for group in inputs]
    time = _Time(max(score.last_us, 1) / 1e6, (*lanes, output.lane))
    pieces, y = [], 16
    for lane in lanes:
        pieces.append(_lane(lane, y, time))
        y += _LANE
    for bar in output.bars:
        pieces.append(_bar(bar, y, time))
        y += _BAR + 6
    pieces.append(_lane(output.lane, y + 4, time, out=True))
    wide, high = time.wide, y + _LANE + _AXIS - 12
    pieces.append(_axis(time, high - 6))
    bars = (f"{bar.connector} {bar.formula}".strip() for bar in output.bars)
    told = translate(_chain([*map(_told, lanes), *bars, _told(output.lane)]), language)
    return Markup(
        f'<svg class="marble-picture" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" role="img" '
        f'aria-label="{escape(told)}">{"".join(pieces)}</svg>'
    )


class _Time:
    """Horizontal time scale of an example, wide enough that marbles overlap neither each other nor the name."""

    def __init__(self, span: float, lanes: Sequence[Lane]) -> None:
        self.span = span
        self.left = _NAME + max((_half(lane.marbles[0]) for lane in lanes if lane.marbles), default=_RADIUS)
        self.scale = max((_WIDE - self.left - _RIGHT) / span, *map(_least, lanes))
        self.wide = round(self.left + span * self.scale + _RIGHT)

    def x(self, seconds: float) -> float:
        return round(self.left + seconds * self.scale, 1)


def _least(lane: Lane) -> float:
    """Return the pixels per second at which no two marbles of a stream touch."""
    pairs = zip(lane.marbles, lane.marbles[1:], strict=False)
    return max(((_half(a) + _half(b) + _GAP) / max((b.us - a.us) / 1e6, 0.05) for a, b in pairs), default=0.0)


def _lane(lane: Lane, y: int, time: _Time, *, out: bool = False) -> str:
    marbles = []
    round_by = 2 if lane.kind == "actuator" else _RADIUS  # a square, as in the diagram
    for marble in lane.marbles:
        x, half = time.x(marble.us / 1e6), _half(marble)
        marbles.append(
            f'<rect class="marble" x="{x - half:g}" y="{y - _RADIUS}" width="{2 * half}" height="{2 * _RADIUS}" '
            f'rx="{round_by}"/><text class="value" x="{x:g}" y="{y + 4}">{escape(_text(marble))}</text>'
        )
    return (
        f'<g class="lane is-{lane.kind}{" is-out" if out else ""}"><text class="name" x="0" y="{y + 4}">'
        f'{escape(lane.label)}</text><path class="line" d="M{_NAME} {y}H{time.wide - 8}m-5 -4 5 4 -5 4"/>'
        f"{''.join(marbles)}</g>"
    )


def _bar(bar: Bar, y: int, time: _Time) -> str:
    top = y - _BAR // 2
    ticks = "".join(f'<path class="tick" d="M{time.x(us / 1e6):g} {top}v-6"/>' for us in bar.ticks)
    formula = f' <tspan class="formula">{escape(bar.formula)}</tspan>' if bar.formula else ""
    return (
        f'<g class="bar"><rect x="{_NAME}" y="{top}" width="{time.wide - _NAME - 8}" height="{_BAR - 4}" rx="4"/>'
        f'<g class="sign" transform="translate({_NAME + 8} {top + 8})">{bar.icon}</g>'
        f'<text x="{_NAME + 28}" y="{top + 18}">{escape(bar.connector)}{formula}</text>{ticks}</g>'
    )


def _axis(time: _Time, y: int) -> str:
    step = next((s for s in _STEPS if s * time.scale >= _LEAST_STEP), _STEPS[-1])
    times = (step * n for n in range(int(time.span / step + 1e-6) + 1))
    marks = "".join(f'<text class="time" x="{time.x(t):g}" y="{y}">{t:.3g} s</text>' for t in times)
    return f'<g aria-hidden="true">{marks}</g>'


def _half(marble: Marble) -> int:
    return max(_RADIUS, len(_text(marble)) * _LETTER + 4)


def _text(marble: Marble) -> str:
    return "!" if marble.error else example_value(marble.value)


def _told(lane: Lane) -> str:
    found = [N_("{value} at {n:g} s", value=_text(m), n=m.us / 1e6) for m in lane.marbles]
    return N_("{name}: {values}", name=lane.label, values=listed(found) or N_("nothing"))


def _chain(texts: Sequence[str]) -> str:
    return reduce(lambda before, after: N_("{before}; {after}", before=before, after=after), texts)


def example_value(value: Value) -> str:
    """Return a value as it stands on a marble of an example; a record as the values of its fields.

    >>> example_value(0.12345), example_value("red"), example_value(None)
    ('0.123', 'red', 'blank')
    """
    if isinstance(value, Record):
        return f"({'; '.join(example_value(v) for v in value.as_dict().values())})"
    return short(value)
