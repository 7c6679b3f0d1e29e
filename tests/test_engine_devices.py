"""Devices that the engine itself carries out: Wait, Timer, End run, Behaviour."""

from __future__ import annotations

import pytest
from play import check, example, play, rows

from rrp_sheets.engine.engine import EventEngine, FrameEngine
from rrp_sheets.engine.plan import make_plan

YAW, PITCH = "Head yaw", "Head pitch"


def devices(*lines: str) -> str:
    head = "## Devices\n| Stream | Device | Time | Every | Name | State |\n|---|---|---|---|---|---|\n"
    return head + "\n".join(lines) + "\n"


PAUSE = devices("| Pause | Wait | 1 s | | | |", "| Any pause | Wait | | | | |")
WAITING = rows(
    """
    | Head yaw | subscribe | headYaw if headYaw > 0 else None | Pause |
    | Pause done | subscribe | | Print |
    """,
    PAUSE,
)


def dones(played, stream):
    return [(ms, r.get("value"), r.get("completed"), round(r.get("seconds"), 3)) for ms, r in played[stream]]


@pytest.mark.parametrize(
    ("events", "expected"),
    [
        ([(0, YAW, 7)], [(1000, 7, True, 1.0)]),  # any event waits for the setting's time
        ([(0, YAW, 7), (500, YAW, 8)], [(533.333, 7, False, 0.5), (1500, 8, True, 1.0)]),  # a newer one replaces
        ([(0, YAW, 7), (500, YAW, 0)], [(533.333, 7, False, 0.5)]),  # blank stops, and is no command itself
        ([(0, YAW, 0)], []),
        ([(0, YAW, 7), (0, YAW, 8)], [(33.333, 7, False, 0.0), (1000, 8, True, 1.0)]),  # never in its own frame
    ],
)
def test_wait_is_done_once_for_every_command(events, expected):
    assert dones(play(WAITING, events, 3000), "Pause done") == expected


@pytest.mark.parametrize(
    ("formula", "seconds"), [('"0.5 s"', 0.5), ("0.5", 0.5), ('"200 ms"', 0.2), ("headYaw / 2", 0.5)]
)
def test_wait_takes_its_time_from_the_value(formula, seconds):
    book = rows(f"| Head yaw | subscribe | {formula} | Any pause |\n| Any pause done | subscribe | | Print |", PAUSE)
    [(_, _, completed, took)] = dones(play(book, [(0, YAW, 1)], 3000), "Any pause done")
    assert completed and took == seconds


def test_wait_without_any_time_is_an_error_of_its_row():
    book = rows('| Head yaw | subscribe | "soon" | Any pause |\n| Any pause done | subscribe | | Print |', PAUSE)
    engine = FrameEngine(make_plan(check(book)))
    engine.settle(0, [("headyaw", 1)])
    [told] = engine.take_notices()
    assert told.kind == "error" and told.row == "T!2"
    assert "soon" in told.text
    engine.settle(33_333, [])
    assert engine.streams["anypausedone"].latest.get("completed") is False


def test_a_sequence_of_waits_needs_no_robot():
    book = rows(
        """
        | Head yaw | subscribe | | Pause |
        | Pause done | subscribe | | Any pause |
        """,
        devices("| Pause | Wait | 1 s | | | |", "| Any pause | Wait | 2 s | | | |"),
        "## U\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"
        "| Any pause done | subscribe | | Print |\n",
    )
    assert [ms for ms, _ in play(book, [(0, YAW, 1)], 5000)["Print"]] == [3000]


def test_a_timer_ticks_without_drift_first_after_one_period():
    book = rows("| Tick | subscribe | tick.count | Print |", devices("| Tick | Timer | | 250 ms | | |"))
    played = play(book, [], 1100)
    assert played["Print"] == [(266.666, 1), (500, 2), (766.666, 3), (1000, 4)]
    assert [r.get("seconds") for _, r in played["Tick"]] == [0.266666, 0.5, 0.766666, 1.0]


def test_end_run_ends_the_run_and_tells_the_row():
    book = rows("| Head yaw | subscribe | | Print |\n| Head yaw | filter | headYaw > 1 | Enough |\n"
                "| Enough | subscribe | | End run |")  # fmt: skip
    played = play(book, [(0, YAW, 1), (500, YAW, 2), (900, YAW, 3)], 3000)
    assert played.values("Print") == [1, 2]
    engine = FrameEngine(make_plan(check(book)))
    engine.settle(0, [("headyaw", 2)])
    assert engine.ended_by.startswith("T!")


HEADER = "| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"
SWITCHED = rows(
    """
    | Head pitch | filter | headPitch > 0 | Up |
    | Up | subscribe | | Turn on |
    | Head pitch | filter | headPitch < 0 | Down |
    | Down | subscribe | | Turn off |
    | Head pitch | filter | headPitch == 0 | Zero |
    | Zero | subscribe | | Turn |
    """,
    "## Count\n" + HEADER + "| Head yaw, Head pitch | combineLatest | headYaw * 10 + headPitch | Both |\n| Both | subscribe | | Say |\n"
    "| Head yaw | sample | 1 s | Slow |\n| Slow | subscribe | | Print |\n",
    devices("| Turn on | Behaviour | | | Count | On |", "| Turn off | Behaviour | | | Count | Off |",
            "| Turn | Behaviour | | | Count | Toggle |"),
)  # fmt: skip
ONLY_T = SWITCHED + "\n## Protocol\n| Field | Value |\n|---|---|\n| Run | T |\n"


def test_a_behaviour_that_is_not_run_can_be_switched_on_and_starts_fresh():
    played = play(ONLY_T, [(0, YAW, 1), (100, PITCH, 1), (1200, YAW, 2), (1300, PITCH, 1), (4000, YAW, 3)], 6000)
    assert played["Say"] == [(1300, 21), (4000, 31)]  # what came before it was on is not remembered
    assert played["Print"] == [(2100, 2), (4100, 3)]  # its second began at 0.1 s


def test_a_behaviour_that_is_switched_off_stops_its_actuators_and_forgets():
    events = [(0, YAW, 1), (0, PITCH, 1), (500, PITCH, -1), (600, YAW, 2), (2000, PITCH, 1), (2100, PITCH, 2)]
    played = play(SWITCHED, events, 4000)
    assert played["Say"] == [(0, 11), (500, 9), (500, None)]  # the frame settles, then its speech is stopped
    assert played["Print"] == []  # the timer of the sample is gone; the value that it held too


def test_toggle_switches_the_other_way():
    events = [(0, PITCH, 0), (100, YAW, 1), (200, PITCH, 0), (300, YAW, 2), (400, PITCH, 5), (500, PITCH, 0)]
    played = play(ONLY_T, events, 3000)
    assert played.values("Slow") == []
    told = FrameEngine(make_plan(check(ONLY_T)))
    told.settle(0, [("headpitch", 0)])
    assert [h.text for h in told.take_notices()] == ["The behaviour Count is switched on."]
    assert told.on == {"t", "count"}
    told.settle(33_333, [("headpitch", 0)])
    assert told.on == {"t"}


def test_blank_does_not_switch():
    book = rows("| Head yaw | subscribe | None | Turn off |", "## B\n" + HEADER + "| Head yaw | subscribe | | Print |\n",
                devices("| Turn off | Behaviour | | | B | Off |"))  # fmt: skip
    assert play(book, [(0, YAW, 1), (100, YAW, 2)]).values("Print") == [1, 2]


def test_in_the_event_loop_the_times_are_exact():
    engine = EventEngine(make_plan(check(WAITING)))
    engine.settle(10, [("headyaw", 7)])
    engine.settle(500_000, [("headyaw", 8)])
    engine.settle(500_999, [])
    assert engine.streams["pausedone"].arrived == 0  # never in the command's own instant
    engine.settle(501_000, [])
    assert engine.streams["pausedone"].latest.get("completed") is False
    engine.settle(3_000_000, [])
    last = engine.streams["pausedone"]
    assert (last.at_us, last.latest.get("value"), last.latest.get("seconds")) == (1_500_000, 8, 1.0)


def test_rows_that_command_each_other_in_a_circle_leave_the_event_loop_its_time():
    book = rows("| Head yaw | subscribe | 0 | Any pause |\n| Any pause done | subscribe | 0 | Any pause |", PAUSE)
    engine = EventEngine(make_plan(check(book)))
    engine.settle(0, [("headyaw", 7)])
    engine.settle(100_000, [])
    assert engine.streams["anypausedone"].arrived == 100


def test_the_clock_of_a_sample_begins_when_its_behaviour_is_switched_on():
    played = play(ONLY_T, [(200, PITCH, 1), (300, YAW, 1), (1300, YAW, 2)], 3000)
    assert played["Print"] == [(1200, 1), (2200, 2)]


def test_a_time_sent_to_wait_needs_no_quotes() -> None:
    text = """
    | Go | subscribe | {time} | Pause |
    | Pause done | subscribe | | Print |
    """
    devices = """
    ## Devices
    | Stream | Device | Label |
    |---|---|---|
    | Go | OperatorButton | Go |
    | Pause | Wait | |
    """
    for typed in ("8 s", '"8 s"', "8000 ms"):
        played = play(rows(text.format(time=typed), devices), [(0, "Go", example("OperatorButton"))], 12_000)
        assert [ms for ms, _ in played["Print"]] == pytest.approx([8000], abs=40)
