"""Engines against a reference: random graphs, random events; both do what the rows mean."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import reduce

import pytest
from examples import example_count
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from play import Played, check
from play import rows as workbook

from rrp_sheets.engine.engine import EventEngine, FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.model.names import argument_name, key

SENSORS = ("Head yaw", "Head pitch", "L shoulder pitch")
END = 3_000_000
FRAMES = [n * 1_000_000 // 30 for n in range(91)]


@dataclass(frozen=True)
class Line:
    """A row: `number` is a period in µs, or a number in its formula."""

    connector: str
    inputs: tuple[str, ...]
    number: int
    output: str


class Reference:
    """Meaning of rows in plain Python, written without the engines and the connectors."""

    def __init__(self, lines):
        self.lines = [(line, defaultdict(lambda: None, latest={}, passed=set(), queue=[], total=0)) for line in lines]
        self.log = defaultdict(list)

    def due(self):
        """The next time at which something happens by itself."""
        times = [t for line, s in self.lines for t in [
            *(t for t, _ in s["queue"]), *([s["due"] or line.number] if line.connector == "sample" else []),
            *([s["due"]] if line.connector in ("timeout", "forgetAfter") and s["due"] else [])]]  # fmt: skip
        return min(times, default=END + 1)

    def instant(self, now, arrivals):
        live = defaultdict(list)
        for stream, value in arrivals:
            live[stream].append(value)
        for line, state in self.lines:
            events = [(i, v) for i, name in enumerate(line.inputs) for v in live[name]]  # by input, then arrival
            live[line.output] += self.meaning(line, state, events, now)
        for stream, values in live.items():
            self.log[stream] += [(now, v) for v in values]

    def meaning(self, line, s, events, now):  # one case per connector
        n, count, first = line.number, len(line.inputs), [v for i, v in events if i == 0]
        if line.connector in ("map", "filter", "combineLatest"):
            s["latest"].update((i, v) for i, v in events if i or line.connector == "combineLatest")
            if line.connector == "combineLatest":
                tuples = [[s["latest"][i] for i in range(count)]] if events and len(s["latest"]) == count else []
            else:
                others = [s["latest"].get(i) for i in range(1, count)]
                tuples = [[v, *others] for v in first] if len(s["latest"]) == count - 1 else []
            tuples = [t for t in tuples if None not in t]  # blank where a number is needed: an error, dropped
            sums = [reduce(lambda a, b: (a * 3 + b) % 1009, t, n) for t in tuples]
            return [t[0] for t, r in zip(tuples, sums, strict=True) if r % 2] if line.connector == "filter" else sums
        if line.connector == "accumulate":
            totals = []
            for _, v in events:
                s["total"] = s["total"] if v is None else (s["total"] * 2 + v + n) % 1009
                totals += [s["total"]] if v is not None else []
            return totals
        if line.connector == "once":
            s["passed"] = set() if len(first) < len(events) else s["passed"]
            return [v for v in first if v is not None and v % 5 not in s["passed"] and not s["passed"].add(v % 5)]
        if line.connector == "timeout":
            s["armed"], s["due"] = (None, None) if len(first) < len(events) else (s["armed"], s["due"])
            s["armed"], s["due"] = ([first[-1]], now + n) if first else (s["armed"], s["due"])
            fired = s["armed"] if s["armed"] and s["due"] <= now else []
            s["armed"], s["due"] = (None, None) if fired else (s["armed"], s["due"])
            return fired
        if line.connector == "changes":
            before, s["latest"][0] = (
                [s["latest"].get(0, "nothing"), *first],
                (first or [s["latest"].get(0, "nothing")])[-1],
            )
            return [v for was, v in zip(before, first, strict=False) if v != was]
        if line.connector == "throttle":
            passes = first[:1] if now >= (s["due"] or 0) else []
            s["due"] = now + n if passes else s["due"]
            return passes
        if line.connector == "delay":
            s["queue"] += [(now + n, v) for v in first]
            ready, s["queue"] = [v for t, v in s["queue"] if t <= now], [e for e in s["queue"] if e[0] > now]
            return ready
        if line.connector == "sample":
            s["held"] = first[-1:] or s["held"] or []
            tick = now >= (s["due"] or n)
            held, s["due"] = (s["held"], (now // n + 1) * n) if tick else ([], s["due"])
            s["held"] = [] if tick else s["held"]
            return held
        if line.connector == "forgetAfter":
            forgotten = [None] if not first and s["due"] and s["due"] <= now else []
            s["due"] = now + n if first else None if forgotten else s["due"]
            return first + forgotten
        return [v for _, v in events]  # merge, subscribe


# ---- the rows as a workbook
def spelt(line):
    names = [argument_name(name) for name in line.inputs]
    mixed = reduce(lambda a, b: f"(({a}) * 3 + {b}) % 1009", names, str(line.number))
    formula = {
        "map": mixed, "combineLatest": mixed, "filter": f"({mixed}) % 2 == 1", "once": f"{names[0]} % 5",
        "accumulate": f"(total * 2 + value + {line.number}) % 1009",
    }.get(line.connector, f"{line.number // 1000} ms" if line.connector in TIMED else "")  # fmt: skip
    output = "Print" if line.connector == "subscribe" else line.output
    return f"| {', '.join(line.inputs)} | {line.connector} | {formula} | {output} |"


TIMED = ("sample", "forgetAfter", "timeout", "throttle", "delay")
UNTIMED = ("map", "filter", "merge", "combineLatest", "accumulate", "once", "changes")
LEAST = {"merge": 2, "combineLatest": 2, "timeout": 1}
MOST = {"merge": 3, "combineLatest": 3, "map": 3, "filter": 2, "accumulate": 3, "once": 3, "timeout": 3}


@st.composite
def graphs(draw, connectors, *, apart=False):
    """Rows in an order in which each can be worked out; `apart`: no two inputs of a row come from one sensor."""
    above = {name: {name} for name in SENSORS}
    lines = []
    for number in range(draw(st.integers(1, 9))):
        connector = draw(st.sampled_from(connectors))
        least, most = LEAST.get(connector, 1), MOST.get(connector, 1)
        inputs = draw(st.lists(st.sampled_from(sorted(above)), min_size=least, max_size=most, unique=True))
        if apart and len(set().union(*(above[i] for i in inputs))) < sum(len(above[i]) for i in inputs):
            continue
        n = draw(st.integers(1, 12)) * 50_000 if connector in TIMED else draw(st.integers(0, 9))
        lines.append(Line(connector, tuple(inputs), n, f"S{number}"))
        above[f"S{number}"] = set().union(*(above[i] for i in inputs))
    assume(lines)
    last = draw(st.lists(st.sampled_from([line.output for line in lines]), min_size=1, max_size=3, unique=True))
    return [*lines, *(Line("subscribe", (stream,), 0, f"Print {i}") for i, stream in enumerate(last))]


EVENTS = st.lists(st.tuples(st.integers(0, 2900), st.sampled_from(SENSORS), st.integers(-9, 9)), max_size=25)


def watched(engine_class, lines):
    checked = check(workbook("\n".join(map(spelt, lines))))
    assert not checked.report.errors, [d.message for d in checked.report.errors]
    seen = Played(checked)
    return engine_class(make_plan(checked), seen), seen


def compare(lines, reference, seen):
    """Every stream at every time; what Print got, from all of its rows, in the order of the rows."""
    for stream in {s for line in lines for s in (*line.inputs, line.output) if not s.startswith("Print")}:
        assert seen[stream] == [(round(us / 1000, 3), v) for us, v in reference.log[stream]], stream
    sent = [(us, i, v) for i in range(3) for us, v in reference.log[f"Print {i}"]]
    assert sorted((ms, v is None, v or 0) for ms, v in seen["Print"]) == sorted(
        (round(us / 1000, 3), v is None, v or 0) for us, _, v in sent
    )


def in_frames(lines, events):
    reference = Reference(lines)
    engine, seen = watched(FrameEngine, lines)
    before = -1
    for frame in FRAMES:
        arrivals = [(stream, v) for ms, stream, v in events if before < ms * 1000 <= frame]
        reference.instant(frame, arrivals)
        engine.settle(frame, [(key(stream), v) for stream, v in arrivals])
        before = frame
    compare(lines, reference, seen)


def one_by_one(lines, events):
    reference = Reference(lines)
    engine, seen = watched(EventEngine, lines)
    for ms, stream, value in events:
        while reference.due() < ms * 1000:
            reference.instant(reference.due(), [])
        reference.instant(ms * 1000, [(stream, value)])
        engine.settle(ms * 1000, [(key(stream), value)])
    while reference.due() <= END:
        reference.instant(reference.due(), [])
    engine.settle(END, [])
    compare(lines, reference, seen)


def by_time(events):
    return sorted(events, key=lambda e: e[0])


BOUNDED = settings(max_examples=example_count(60), deadline=None, suppress_health_check=[HealthCheck.too_slow])
LONG = settings(max_examples=3_000, deadline=None, suppress_health_check=list(HealthCheck))


@pytest.mark.slow
@given(graphs(UNTIMED + TIMED), EVENTS)
@BOUNDED
def test_frames_do_what_the_rows_mean(lines, events):
    in_frames(lines, by_time(events))


@given(graphs(UNTIMED + TIMED), EVENTS)
@BOUNDED
def test_the_event_loop_does_what_the_rows_mean(lines, events):
    one_by_one(lines, by_time(events))


def both(lines, events):
    """Without timers, diamonds and simultaneous events it makes no difference which engine it is."""
    spread = [(40 * n, stream, value) for n, (_, stream, value) in enumerate(events)]
    frames, in_frame = watched(FrameEngine, lines)
    loop, in_loop = watched(EventEngine, lines)
    for n, (_, stream, value) in enumerate(spread):
        frames.settle(FRAMES[n], [(key(stream), value)])
        loop.settle(n * 40_000, [(key(stream), value)])
    for stream in in_frame.names.values():
        name = stream.split("!")[-1]
        assert in_frame.values(name) == in_loop.values(name)


@pytest.mark.slow
@given(graphs(UNTIMED, apart=True), EVENTS)
@BOUNDED
def test_the_engines_agree_where_frames_make_no_difference(lines, events):
    both(lines, events)


@pytest.mark.soak
@given(graphs(UNTIMED + TIMED), EVENTS)
@LONG
def test_both_engines_on_many_graphs(lines, events):
    in_frames(lines, by_time(events))
    one_by_one(lines, by_time(events))


@pytest.mark.soak
@given(graphs(UNTIMED, apart=True), EVENTS)
@LONG
def test_the_engines_agree_on_many_graphs(lines, events):
    both(lines, events)
