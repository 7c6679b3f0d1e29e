"""The trace: written once per frame, readable after a crash, its last line the summary."""

from __future__ import annotations

import json

import pytest
from play import check, rows
from recorded import recorded_engine

from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.runners import FrameRunner
from rrp_sheets.engine.trace import TraceWriter
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.model.exchange import Notice
from rrp_sheets.model.run_files import RecordedFailure, RecordedNotice, RecordedValue
from rrp_sheets.recording.table import tidy_table
from rrp_sheets.recording.trace_reader import TraceReader

BOOK = rows(
    """
    | Head yaw | map | 1 / headYaw | X |
    | X | map | value | |
    | | subscribe | | Print |
    """
)


@pytest.fixture
def trace(tmp_path):
    """A trace of three frames: a value, an error, a notice."""
    plan = make_plan(check(BOOK))
    path = tmp_path / "trace.jsonl"
    writer = TraceWriter(path, plan, {"seed": 7})
    engine = recorded_engine(plan, writer)
    world = ScriptedWorld([(0, "headyaw", 2), (33_333, "headyaw", 0)])
    FrameRunner(world, lambda: engine).go(66_666, RunObserver())
    writer.notice(66_666, Notice("say", "Hello", "print", "T!4"))
    writer.close({"ended": "time"})
    return path


def test_every_event_of_every_stream_is_there_in_order(trace):
    lines = [json.loads(line) for line in trace.read_text(encoding="utf-8").splitlines()]
    assert lines[0]["type"] == "header" and lines[0]["seed"] == 7
    assert lines[0]["streams"] == [
        {"stream": "Head yaw", "kind": "sensor", "device": "JointPosition"},
        {"stream": "T!X", "kind": "stream", "device": None},
        {"stream": "T!#3", "kind": "anonymous", "device": None},
        {"stream": "Print", "kind": "actuator", "device": "Print"},
    ]
    assert lines[1:] == [
        {"t": 0.0, "stream": "Head yaw", "row": "", "value": 2},
        {"t": 0.0, "stream": "T!X", "row": "T!2", "value": 0.5},
        {"t": 0.0, "stream": "T!#3", "row": "T!3", "value": 0.5},
        {"t": 0.0, "stream": "Print", "row": "T!4", "value": 0.5},
        {"t": 0.033333, "stream": "Head yaw", "row": "", "value": 0},
        {"t": 0.033333, "row": "T!2", "error": "This formula divides by zero.", "code": "FORM101", "inputs": [0]},
        {"t": 0.066666, "happening": "say", "text": "Hello", "stream": "Print", "row": "T!4"},
        {"type": "summary", "ended": "time"},
    ]


def test_events_are_read_as_they_were_written(trace):
    reader = TraceReader(trace.parent)
    assert [(s.name, s.kind, s.device) for s in reader.header.streams][1:] == [
        ("T!X", "stream", ""), ("T!#3", "anonymous", ""), ("Print", "actuator", "Print"),
    ]  # fmt: skip
    assert list(reader)[3:] == [
        RecordedValue(0, "Print", "T!4", 0.5),
        RecordedValue(33_333, "Head yaw", "", 0),
        RecordedFailure(33_333, "", "T!2", "This formula divides by zero.", "FORM101", [0]),
        RecordedNotice(66_666, "Print", "T!4", "say", "Hello"),
    ]
    assert reader.summary is not None and (reader.summary.text("ended"), reader.summary.seconds) == ("time", 0.0)
    assert list(reader) == list(reader)


def test_events_found_by_their_bytes_and_places_are_the_same(trace):
    reader = TraceReader(trace)
    events = list(reader)
    assert list(reader.containing(b'"T!2"', b"Hello")) == [events[1], *events[5:]]
    skimmed = list(reader.skim())
    assert [value for _, _, value in skimmed[:2]] == [(0.0, b"Head yaw", b""), (0.0, b"T!X", b"T!2")]
    assert [reader.event(line) for _, line, _ in skimmed] == [*events, None]
    assert list(reader.events_at(place for place, _, _ in skimmed[:-1])) == events


def test_a_line_that_a_crash_cut_off_is_left_out(trace):
    whole = trace.read_bytes()
    trace.write_bytes(whole[:-10])
    reader = TraceReader(trace)
    assert len(list(reader)) == whole.count(b"\n") - 2 and reader.summary is None
    assert len(list(reader.skim())) == whole.count(b"\n") - 2


def test_the_table_has_a_row_per_event(trace):
    table = tidy_table([trace])
    header, lines = table.header, table.rows
    table = [dict(zip(header, line, strict=True)) for line in lines]
    assert len(table) == 7
    assert [row["kind"] for row in table] == ["sensor", "stream", "anonymous", "actuator", "sensor", "error", "say"]
    assert table[5]["message"] == "This formula divides by zero." and table[6]["message"] == "Hello"


def test_what_is_no_trace_is_refused(tmp_path):
    (tmp_path / "x.jsonl").write_text("hello\n")
    with pytest.raises(UnreadableFile):
        list(TraceReader(tmp_path / "x.jsonl"))
    with pytest.raises(UnreadableFile):
        list(TraceReader(tmp_path / "gone.jsonl"))


def test_nothing_that_json_does_not_know_gets_into_a_trace(trace):
    for line in trace.read_text(encoding="utf-8").splitlines():
        json.loads(line, parse_constant=pytest.fail)


def test_a_search_goes_on_behind_a_line_that_is_no_event(trace):
    lines = trace.read_text(encoding="utf-8").splitlines(keepends=True)
    wrong = '{"t": 0.0, "happening": "say", "text": "Hello", "row": 5}\n'
    trace.write_text("".join([*lines[:3], wrong, "{Hello\n", *lines[3:]]), encoding="utf-8")
    assert [event.us for event in TraceReader(trace).containing(b"Hello")] == [66_666]
    with pytest.raises(UnreadableFile):
        list(TraceReader(trace))
