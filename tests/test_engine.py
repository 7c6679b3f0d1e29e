"""The frame engine: no glitches, a fixed order, nothing that overflows."""

from __future__ import annotations

import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from play import check, findings, play, rows

from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.runners import FrameRunner
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.model.names import key

YAW, PITCH = "Head yaw", "Head pitch"


def test_a_diamond_emits_once_and_consistently():
    book = rows(
        """
        | Head yaw | map | headYaw * 10 | B |
        | Head yaw | map | headYaw * 100 | C |
        | B, C | combineLatest | b + c | D |
        | D | subscribe | | Print |
        """
    )
    p = play(book, [(0, YAW, 1), (100, YAW, 2), (200, YAW, 3)])
    assert p["D"] == [(0, 110), (100, 220), (200, 330)]


def test_a_stream_may_carry_several_events_in_a_frame():
    book = rows("| Head yaw | map | headYaw + 1 | X |\n| X | filter | x > 1 | Y |\n| Y | subscribe | | Print |")
    assert play(book, [(0, YAW, 1), (0, YAW, 0), (0, YAW, 2)])["Print"] == [(0, 2), (0, 3)]


def test_events_between_frames_arrive_in_the_next_one():
    p = play(rows("| Head yaw | subscribe | | Print |"), [(10, YAW, 1), (34, YAW, 2)])
    assert p["Print"] == [(33.333, 1), (66.666, 2)]


def test_the_frame_rate_is_the_protocols():
    protocol = "## Protocol\n| Field | Value |\n|---|---|\n| Frame rate | 60 |\n"
    assert play(rows("| Head yaw | subscribe | | Print |", protocol), [(10, YAW, 1)])["Print"] == [(16.666, 1)]


def test_a_chain_of_500_rows_runs_and_one_of_501_is_refused():
    def chain(n):
        lines = ["| Head yaw | map | headYaw + 1 | |"] + ["| | map | value + 1 | |"] * (n - 2)
        return rows("\n".join([*lines, "| | subscribe | | Print |"]))

    limit = sys.getrecursionlimit()
    try:
        assert play(chain(500), [(0, YAW, 0)])["Print"] == [(0, 499)]
    finally:
        sys.setrecursionlimit(limit)
    assert [code for code, _ in findings(chain(501))] == ["GRAPH012"]


def test_only_the_behaviours_that_the_protocol_names_run():
    other = "## Other\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"
    book = rows("| Head yaw | subscribe | | Print |", other + "| Head pitch | subscribe | | Print |\n",
                "## Protocol\n| Field | Value |\n|---|---|\n| Run | Other |\n")  # fmt: skip
    assert play(book, [(0, YAW, 1), (0, PITCH, 2)])["Print"] == [(0, 2)]


def test_several_formulas_with_helpers_that_call_helpers():
    helpers = """
        ## Helpers
        | Name | Inputs | Formula |
        |---|---|---|
        | Twice | x | 2 * x |
        | Four times | x | twice(twice(x)) |
        | Offset | | 0.5 |
        """
    book = rows(
        "| Head yaw | map | Four times | X |\n| X | map | x + offset | Y |\n| Y | subscribe | | Print |", helpers
    )
    assert play(book, [(0, YAW, 3)]).values("Y") == [12.5]


EVENTS = st.lists(st.tuples(st.integers(0, 2000), st.sampled_from([YAW, PITCH]), st.integers(-5, 5)), max_size=30)


@pytest.mark.slow
@given(EVENTS)
@settings(max_examples=40, deadline=None)
def test_watching_a_run_does_not_change_it(events):
    checked = check(rows(
        """
        | Head yaw, Head pitch | merge | | M |
        | M | filter | m > 0 | P |
        | P | forgetAfter | 300 ms | F |
        | M, P | combineLatest | m * 100 + p | C |
        | C | sample | 200 ms | S |
        | S, F | subscribe | | Print |
        """
    ))  # fmt: skip
    events = sorted(events, key=lambda e: e[0])
    watched = play(checked, events, 3000)
    engine = FrameEngine(make_plan(checked))
    world = ScriptedWorld((ms * 1000, key(stream), value) for ms, stream, value in events)
    FrameRunner(world, lambda: engine).go(3_000_000, RunObserver())
    assert {i: s.arrived for i, s in engine.streams.items()} == {
        i: len(watched[name]) for i, name in ((s, watched.names[s].split("!")[-1]) for s in engine.streams)
    }
    assert engine.streams["t!c"].latest == (watched.values("C") or [None])[-1]
    assert play(checked, events, 3000).log == watched.log
