"""The connectors' meaning, in virtual time."""

from __future__ import annotations

from string import Formatter

import pytest
from play import example, findings, play, rows

from rrp_sheets.connectors import connectors
from rrp_sheets.model.values import Record

YAW, PITCH = "Head yaw", "Head pitch"


def test_map_works_out_each_value_of_its_input():
    p = play(rows("| Head yaw | map | headYaw * 10 | X |\n| X | subscribe | | Print |"), [(0, YAW, 1), (100, YAW, 2)])
    assert p["X"] == [(0, 10), (100, 20)]


def test_map_takes_the_latest_of_further_inputs_this_frames_included():
    book = rows("| Head yaw, Head pitch | map | headYaw + headPitch | X |\n| X | subscribe | | Print |")
    p = play(book, [(0, YAW, 1), (100, PITCH, 10), (200, YAW, 2), (300, YAW, 3), (300, PITCH, 20), (400, PITCH, 30)])
    assert p["X"] == [(200, 12), (300, 23)]  # nothing before both; a further input alone gives nothing


def test_filter_passes_the_value_not_the_formulas_result():
    p = play(rows("| Head yaw | filter | headYaw > 1 | X |\n| X | subscribe | | Print |"), [(0, YAW, 1), (100, YAW, 2)])
    assert p["X"] == [(100, 2)]


def test_filter_with_further_inputs():
    book = rows("| Head yaw, Head pitch | filter | headYaw > headPitch | X |\n| X | subscribe | | Print |")
    p = play(book, [(0, YAW, 5), (100, PITCH, 3), (200, YAW, 4), (300, YAW, 2)])
    assert p["X"] == [(200, 4)]


@pytest.mark.parametrize(("gives", "passes"), [("TRUE", 1), ("2", 1), ("0", 0), ("FALSE", 0), ("BLANK", 0)])
def test_what_passes_a_filter(gives, passes):
    p = play(rows(f"| Head yaw | filter | {gives} | X |\n| X | subscribe | | Print |"), [(0, YAW, 5)])
    assert len(p["X"]) == passes and not p.errors


def test_a_filter_that_gives_a_text_is_an_error_and_drops_the_event():
    p = play(rows('| Head yaw | filter | "yes" | X |\n| X | subscribe | | Print |'), [(0, YAW, 5)])
    assert p["X"] == [] and p.errors == [(0, "T!2", "FORM108")]


def test_timestamp_counts_seconds_from_the_start():
    book = rows(
        """
        | Head yaw | timestamp | | S |
        | S | map | (s.value, s.v, s.timestamp, s.t, s[0], s[1]) | X |
        | X | subscribe | | Print |
        """
    )
    assert play(book, [(500, YAW, 7)]).values("X") == [(7, 7, 0.5, 0.5, 0.5, 7)]


def test_sample_gives_the_latest_once_per_period_and_then_forgets():
    book = rows("| Head yaw | sample | 1 s | X |\n| X | subscribe | | Print |")
    p = play(book, [(100, YAW, 1), (200, YAW, 2), (2500, YAW, 3)], 5000)
    assert p["X"] == [(1000, 2), (3000, 3)]


def test_sample_does_not_drift_and_its_tick_takes_a_value_of_its_own_instant():
    book = rows("| Head yaw | sample | 100 ms | X |\n| X | subscribe | | Print |")
    p = play(book, [(i * 100, YAW, i) for i in range(1, 301)], 30_000)
    assert p.values("X") == list(range(1, 301))
    assert [t for t, _ in p["X"]] == [i * 100 for i in range(1, 301)]


def test_combine_latest_waits_for_all_and_then_follows_each():
    book = rows("| Head yaw, Head pitch | combineLatest | headYaw + headPitch | X |\n| X | subscribe | | Print |")
    p = play(book, [(0, YAW, 1), (100, YAW, 2), (200, PITCH, 10), (300, YAW, 3)])
    assert p["X"] == [(200, 12), (300, 13)]


def test_combine_latest_without_formula_gives_a_record_of_all_inputs():
    book = rows(
        """
        | Head yaw, Head pitch | combine latest | | Both |
        | Both | map | both.headYaw - both.headPitch | X |
        | X | subscribe | | Print |
        """
    )
    p = play(book, [(0, YAW, 5), (0, PITCH, 3)])
    assert p.values("X") == [2]
    both = p.values("Both")[0]
    assert isinstance(both, Record) and both.as_dict() == {"Head yaw": 5, "Head pitch": 3}


def test_merge_passes_every_value_in_input_order():
    book = rows("| Head yaw, Head pitch | merge | | X |\n| X | subscribe | | Print |")
    p = play(book, [(0, PITCH, 10), (0, YAW, 1), (0, YAW, 2), (100, PITCH, 20)])
    assert p["X"] == [(0, 1), (0, 2), (0, 10), (100, 20)]


def test_subscribe_without_formula_passes_every_value_of_every_input():
    p = play(rows("| Head yaw, Head pitch | subscribe | | Print |"), [(0, PITCH, 10), (0, YAW, 1), (100, PITCH, 20)])
    assert p["Print"] == [(0, 1), (0, 10), (100, 20)]


def test_commands_of_one_frame_come_in_the_order_of_the_rows():
    book = rows(
        """
        | Head yaw, Head pitch | combineLatest | "first" | X |
        | X | subscribe | | Print |
        | Head yaw | map | "second" | Y |
        | Y | subscribe | | Print |
        """
    )
    assert play(book, [(0, YAW, 1), (0, PITCH, 2)])["Print"] == [(0, "first"), (0, "second")]


def test_subscribe_with_formula_sends_its_result():
    p = play(rows("| Head yaw, Head pitch | subscribe | headYaw + headPitch | Print |"),
             [(0, PITCH, 10), (100, YAW, 1), (200, PITCH, 20)])  # fmt: skip
    assert p["Print"] == [(100, 11)]


def test_forget_after_passes_on_and_forgets_once_armed_again_by_the_next_value():
    book = rows("| Head yaw | forgetAfter | 1 s | X |\n| X | subscribe | | Print |")
    p = play(book, [(500, YAW, 1), (1000, YAW, 2), (4000, YAW, 3)], 10_000)
    assert p["X"] == [(500, 1), (1000, 2), (2000, None), (4000, 3), (5000, None)]


def test_a_value_at_the_very_instant_of_forgetting_keeps_it():
    book = rows("| Head yaw | forgetAfter | 1 s | X |\n| X | subscribe | | Print |")
    assert play(book, [(0, YAW, 1), (1000, YAW, 2)], 1900).values("X") == [1, 2]


def test_a_blank_reaches_the_actuator():
    book = rows("| Head yaw | forgetAfter | 1 s | X |\n| X | subscribe | | Head tracker |")
    assert play(book, [(0, YAW, 1)], 3000)["Head tracker"] == [(0, 1), (1000, None)]


def test_one_stream_drives_several_actuators():
    p = play(rows("| Head yaw | subscribe | | Print |\n| | subscribe | | Eye brightness |"), [(0, YAW, 0.5)])
    assert p.values("Print") == p.values("Eye brightness") == [0.5]


def test_anonymous_streams_chain_rows():
    book = rows("| Head yaw | map | headYaw + 1 | |\n| | filter | value > 1 | |\n| | subscribe | | Print |")
    assert play(book, [(0, YAW, 0), (100, YAW, 1)])["Print"] == [(100, 2)]


def test_rows_that_are_off_are_skipped_and_merge_ignores_them():
    header = "| On | Input streams | Connector | Formula | Output stream |\n|---|---|---|---|---|\n"
    book = rows(
        """
        | | Head yaw | map | headYaw | A |
        | no | Head pitch | map | headPitch | B |
        | | A, B | merge | | C |
        | | C | subscribe | | Print |
        """,
        header=header,
    )
    assert findings(book) == []
    assert play(book, [(0, YAW, 1), (0, PITCH, 2)]).values("Print") == [1]


@pytest.mark.parametrize("name", ["combineLatest", "combine latest", "COMBINE_LATEST", "Combine-Latest"])
def test_connectors_in_any_spelling(name):
    assert connectors().get(name) is connectors().get("combineLatest")


def test_every_connector_describes_itself():
    for connector in connectors():
        assert connector.help and connector.sentence and connector.icon.startswith("<") and connector.example


def test_sentences_of_connectors_name_only_places_that_rows_fill():
    places = {"event", "input", "one", "inputs", "inputs_or", "each_or", "others", "others_or", "formula", "period",
              "pace", "output", "rows"}  # fmt: skip
    of_some = {"map": {"value"}, "filter": {"condition"}, "combineLatest": {"value"}, "subscribe": {"value", "does"}}
    for connector in connectors():
        for template in (connector.sentence, *connector.variants.values()):
            used = {name for _, name, _, _ in Formatter().parse(template) if name}
            assert {name[:1].lower() + name[1:] for name in used} <= places | of_some.get(connector.name, set()), (
                template
            )


def test_formula_errors_name_the_row_and_the_run_goes_on():
    p = play(rows("| Head yaw | map | 1 / headYaw | X |\n| X | subscribe | | Print |"), [(0, YAW, 0), (100, YAW, 2)])
    assert p.errors == [(0, "T!2", "FORM101")] and p["X"] == [(100, 0.5)]


def test_a_sensor_record_passes_whole():
    ball = example("Red ball", distance=0.3)
    p = play(rows("| Red ball | filter | redBall.distance < 1 | Near |\n| Near | subscribe | | Print |"),
             [(0, "Red ball", ball)])  # fmt: skip
    assert p.values("Print") == [ball]
