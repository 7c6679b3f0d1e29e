"""The advanced connectors, in virtual time, and against short references."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from play import check, example, findings, play, rows

from rrp_sheets.connectors import Parameter, connectors
from rrp_sheets.render.sentences import explain

FRAME_MS = 1000 / 30
DEVICES = """
## Devices
| Stream | Device | Joint |
|---|---|---|
| A | JointPosition | HeadYaw |
| B | JointPosition | HeadPitch |
| C | JointPosition | LHand |
"""


def run(row: str, events: list[tuple[float, str, object]], until_ms: float = 10_000):
    """One row from the streams A, B and C to X; what X gave, as (ms, value), and the errors."""
    played = play(rows(f"| {row} | X |\n| X | subscribe | | Print |", DEVICES), events, until_ms)
    return played["X"], played.errors


# ---- accumulate


def test_accumulate_counts_without_formula_and_blanks_count_too():
    assert run("A | accumulate | ", [(0, "A", 5), (100, "A", None), (200, "A", 5)])[0] == [(0, 1), (100, 2), (200, 3)]


def test_accumulate_adds_up():
    assert run("A | accumulate | total + value", [(0, "A", 5), (100, "A", 2)])[0] == [(0, 5), (100, 7)]


def test_accumulate_has_the_events_own_input_and_blanks_for_the_others():
    row = "A, B | accumulate | IF(ISBLANK(a), IF(value == b, total + b, -1), 0)"
    assert run(row, [(0, "B", 2), (100, "B", 3), (200, "A", 9), (300, "B", 4)])[0] == [
        (0, 2), (100, 5), (200, 0), (300, 4),
    ]  # fmt: skip


def test_accumulate_takes_events_of_one_instant_in_the_order_of_the_inputs():
    row = "A, B | accumulate | IF(ISBLANK(a), total * 10, total + a)"
    assert run(row, [(0, "B", 1), (0, "A", 3), (0, "A", 4)])[0] == [(0, 3), (0, 7), (0, 70)]


def test_accumulate_keeps_the_total_at_an_error():
    got, errors = run("A | accumulate | total + 10 / value", [(0, "A", 5), (100, "A", 0), (200, "A", 10)])
    assert got == [(0, 2), (200, 3)] and errors == [(100, "T!2", "FORM101")]


def test_accumulate_goes_on_when_the_rows_of_an_input_are_off():
    header = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"
    book = rows("| no | B | map | b | Off |\n| | Off, A | accumulate | IF(ISBLANK(a), 0, total + a) | X |\n"
                "| | X | subscribe | | Print |", DEVICES, header=header)  # fmt: skip
    assert play(book, [(0, "A", 2), (100, "A", 3)]).values("X") == [2, 5]


# ---- once


def test_once_without_formula_passes_one_value_until_another_input_gives_one():
    events = [(0, "A", 1), (100, "A", 2), (200, "B", 0), (300, "A", 3), (400, "A", 4)]
    assert run("A, B | once | ", events)[0] == [(0, 1), (300, 3)]


def test_once_for_each_key():
    assert run("A | once | ", [(0, "A", 1), (100, "A", 2)])[0] == [(0, 1)]
    events = [(0, "A", 1), (100, "A", 2), (200, "A", 1), (300, "A", 1.0), (400, "A", True), (500, "A", None)]
    assert run("A | once | a", events)[0] == [(0, 1), (100, 2), (400, True), (500, None)]


def test_what_makes_once_begin_anew_comes_before_the_values_of_its_instant():
    events = [(0, "A", 1), (100, "A", 2), (100, "B", 0), (200, "A", 3)]
    assert run("A, B | once | ", events)[0] == [(0, 1), (100, 2)]


def test_the_key_of_once_may_use_the_latest_of_the_others():
    events = [(0, "A", 1), (100, "B", 1), (200, "A", 1), (300, "A", 2), (400, "A", 3)]
    assert run("A, B | once | IF(ISBLANK(b), 0, a % 2)", events)[0] == [(0, 1), (200, 1), (300, 2)]


# ---- timeout


def test_timeout_gives_the_armed_value_when_nothing_disarms_it():
    events = [(0, "A", 1), (500, "B", 0), (1000, "A", 2)]
    assert run("A, B | timeout | 1 s", events)[0] == [(2000, 2)]


def test_a_newer_value_arms_timeout_anew():
    assert run("A | timeout | 1 s", [(0, "A", 1), (700, "A", 2)])[0] == [(1700, 2)]


@pytest.mark.parametrize(
    ("stream", "gives"), [("B", []), ("A", [(2000, 7)]), ("C", [(1000, 1)])], ids=["disarm", "arm", "fire"]
)
def test_at_the_last_moment_timeout_disarms_arms_and_fires_in_this_order(stream, gives):
    assert run("A, B | timeout | 1 s", [(0, "A", 1), (1000, stream, 7)])[0] == gives


def test_disarmed_and_armed_in_one_instant_is_armed():
    assert run("A, B | timeout | 1 s", [(0, "A", 1), (500, "A", 2), (500, "B", 0)])[0] == [(1500, 2)]


def test_timeout_is_due_at_an_absolute_time_and_fires_once():
    assert run("A | timeout | 50 ms", [(0, "A", 1)])[0] == [(66.666, 1)]  # the first frame at or after 50 ms


# ---- changes, throttle, delay


def test_changes_drops_what_is_equal_to_the_one_before():
    events = [(0, "A", 1), (100, "A", 1.0), (200, "A", True), (300, "A", None), (400, "A", None), (500, "A", 1)]
    assert run("A | changes | ", events)[0] == [(0, 1), (200, True), (300, None), (500, 1)]
    assert run("A | distinct until changed | ", [(0, "A", 1), (100, "A", 1)])[0] == [(0, 1)]


def test_throttle_passes_the_first_of_each_period():
    events = [(0, "A", 1), (500, "A", 2), (1000, "A", 3), (1900, "A", 4), (2500, "A", None), (2600, "A", 6)]
    assert run("A | throttle | 1 s", events)[0] == [(0, 1), (1000, 3), (2500, None)]


def test_delay_keeps_order_and_distances():
    events = [(0, "A", 1), (0, "A", 2), (100, "A", None), (200, "A", 3)]
    assert run("A | delay | 1 s", events)[0] == [(1000, 1), (1000, 2), (1100, None), (1200, 3)]


def test_records_are_told_apart_by_their_fields():
    book = rows("| Touch | changes | | X |\n| X | subscribe | | Print |")
    hands = [example("Touch", zone=z) for z in ("Head", "Head", "Left hand")]
    assert len(play(book, [(i * 100, "Touch", h) for i, h in enumerate(hands)])["X"]) == 2


# ---- what the sheet may say


@pytest.mark.parametrize(
    ("row", "code"),
    [
        ("A | timeout | ", "CONN007"), ("A | delay | soon", "CONN008"), ("A, B | delay | 1 s", "CONN004"),
        ("A, B | changes | ", "CONN004"), ("A | changes | a", "CONN006"), ("A | throttle | 2", "CONN010"),
    ],
)  # fmt: skip
def test_misuse_is_told(row, code):
    assert [c for c, _ in findings(rows(f"| {row} | X |\n| X | subscribe | | Print |", DEVICES))] == [code]


def test_timeout_and_once_need_only_their_first_input_fed():
    header = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"
    book = rows("| no | B | map | b | Off |\n| | A, Off | timeout | 1 s | X |\n| | X, Off | once | | Y |\n"
                "| | Y | subscribe | | Print |", DEVICES, header=header)  # fmt: skip
    assert findings(book) == []
    assert play(book, [(0, "A", 2)])["Print"] == [(1000, 2)]


@pytest.mark.parametrize("connector", [c for c in connectors() if c.advanced], ids=lambda c: c.name)
def test_the_examples_of_the_advanced_connectors_run(connector):
    """The marbles in help: inputs named first and second, a character every 100 ms."""
    lines = list(connector.example)
    formula = lines.pop() if connector.parameter is not Parameter.NONE else ""
    names = ["first", "second"][: len(lines)]
    book = rows(f"| {', '.join(names)} | {connector.name} | {formula} | X |\n| X | subscribe | | Print |",
                DEVICES.replace("| A |", "| first |").replace("| B |", "| second |"))  # fmt: skip
    events = [(i * 100, n, c) for n, line in zip(names, lines, strict=True) for i, c in enumerate(line) if c != "-"]
    shown = play(book, events, 1_200)["X"]
    assert shown and not play(book, events, 1_200).errors
    went_in = [(round(ms), value) for ms, _, value in sorted(events)]
    assert [(round(ms), value) for ms, value in shown] != went_in  # something is to be seen


# ---- against references, over random events


VALUES = st.sampled_from([None, 0, 1, 2, 1.0, True, "a"])
EVENTS = st.lists(st.tuples(st.integers(0, 60), st.sampled_from("ABC"), VALUES), max_size=25)


def by_frame(events):
    """(frame, [(stream, value)…]) in the order of time, arrivals in theirs."""
    frames: dict[int, list[tuple[str, object]]] = {}
    for frame, stream, value in sorted(events, key=lambda e: e[0]):
        frames.setdefault(frame, []).append((stream, value))
    return sorted(frames.items())


def same(a, b) -> bool:
    return (a == b) and isinstance(a, bool) == isinstance(b, bool)


def ref_accumulate(events):
    total, out = 0, []
    for frame, batch in by_frame(events):
        for stream, _ in sorted((e for e in batch if e[0] in "AB"), key=lambda e: "AB".index(e[0])):
            total = total + 1 if stream == "A" else total * 2
            out.append((frame, total))
    return out


def ref_once(events):
    passed, out = [], []
    for frame, batch in by_frame(events):
        if any(s != "A" for s, _ in batch):
            passed = []
        for stream, value in batch:
            if stream == "A" and not any(same(value, p) for p in passed):
                passed.append(value)
                out.append((frame, value))
    return out


def ref_timeout(events, period=5):
    frames, armed, out = dict(by_frame(events)), None, []
    for frame in range(80):
        batch = frames.get(frame, [])
        if any(s != "A" for s, _ in batch):
            armed = None
        for stream, value in batch:
            if stream == "A":
                armed = (frame + period, value)
        if armed and armed[0] <= frame:
            out.append((frame, armed[1]))
            armed = None
    return out


def ref_changes(events):
    mine = [(f, v) for f, batch in by_frame(events) for s, v in batch if s == "A"]
    return [e for i, e in enumerate(mine) if i == 0 or not same(e[1], mine[i - 1][1])]


def ref_throttle(events, period=5):
    out = []
    for frame, value in ((f, v) for f, batch in by_frame(events) for s, v in batch if s == "A"):
        if not out or frame >= out[-1][0] + period:
            out.append((frame, value))
    return out


def ref_delay(events, period=5):
    return [(f + period, v) for f, batch in by_frame(events) for s, v in batch if s == "A"]


PERIOD = "500 ms"
REFERENCES = [
    ("A, B, C | once | a", ref_once),
    (f"A, B, C | timeout | {PERIOD}", ref_timeout),
    ("A | changes | ", ref_changes),
    (f"A | throttle | {PERIOD}", ref_throttle),
    (f"A | delay | {PERIOD}", ref_delay),
]


@pytest.mark.slow
@pytest.mark.parametrize(("row", "reference"), REFERENCES, ids=lambda r: getattr(r, "__name__", ""))
@settings(max_examples=40, deadline=None)
@given(events=EVENTS)
def test_connectors_do_as_their_references(row, reference, events):
    """Ten frames a second, so that a frame is 100 ms and no due time falls between two frames."""
    got, errors = run_at_ten(row, events)
    assert not errors
    want = reference(events)
    assert [f for f, _ in got] == [f for f, _ in want]
    assert all(same(a, b) for (_, a), (_, b) in zip(got, want, strict=True))


@settings(max_examples=40, deadline=None)
@given(events=st.lists(st.tuples(st.integers(0, 60), st.sampled_from("ABC"), st.just(1)), max_size=25))
def test_accumulate_does_as_its_reference(events):
    got, errors = run_at_ten("A, B | accumulate | IF(ISBLANK(b), total + 1, total * 2)", events)
    assert not errors and got == ref_accumulate(events)


def run_at_ten(row, events):
    protocol = "\n## Protocol\n| Field | Value |\n|---|---|\n| Frame rate | 10 |\n"
    book = rows(f"| {row} | X |\n| X | subscribe | | Print |\n| C | subscribe | | Print |", DEVICES, protocol)
    played = play(book, [(f * 100, s, v) for f, s, v in events], 8_000)
    return [(round(ms / 100), v) for ms, v in played["X"]], played.errors


def test_random_long_streams_do_not_lose_a_value():
    rng = random.Random(7)
    events = sorted((rng.uniform(0, 9_000), "A", i) for i in range(2_000))
    got, _ = run("A | delay | 300 ms", events, 10_000)
    assert [v for _, v in got] == [v for _, _, v in events]
    assert all(at - FRAME_MS * 2 <= ms + 300 <= at + FRAME_MS for (at, _), (ms, _, _) in zip(got, events, strict=True))


def test_the_sentences_of_the_advanced_connectors():
    book = rows(
        """
        | A, B | accumulate | IF(ISBLANK(b), total + 1, 0) | N |
        | A | accumulate | | M |
        | N, B | once | | O |
        | N | once | n | P |
        | O, P | timeout | 8 s | Q |
        | Q | changes | | R |
        | R | throttle | 4 s | S |
        | S | delay | 2 s | U |
        | U | subscribe | | Print |
        """,
        DEVICES,
    )
    checked = check(book)
    (said,) = explain(checked.graph, checked.workbook)
    assert [r.text for r in said.rows][:8] == [
        "“A” adds 1 to “N”. “B” sets “N” to 0.",
        "Each “A” adds 1 to “M”.",
        "Only the first “N” becomes “O”, and again the first one after each “B”.",
        "The first “N” with a new value of `n` becomes “P”. Later ones with the same value do nothing.",
        "8 s after the last “O”, send “Q”, unless “P” arrives first.",
        "Each “Q” that differs from the one before becomes “R”.",
        "When “R” arrives, send “S”, then ignore new ones for 4 s.",
        "2 s after each “S”, send “U”.",
    ]


def test_a_blank_that_stops_an_actuator_is_told_as_such():
    book = rows(
        "| A | map | BLANK | |\n| | subscribe | | Say |\n| A | map | blank | Hush |\n| Hush | subscribe | | Head tracker |",
        DEVICES,
    )
    checked = check(book)
    (said,) = explain(checked.graph, checked.workbook)
    assert [r.text for r in said.rows][1::2] == [
        "When row 2 gives a value, stop what “Say” is saying.",
        "When “Hush” arrives, stop the tracking “Head tracker”.",
    ]
