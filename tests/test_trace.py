"""The trace: written once per frame, readable after a crash, its last line the summary (design: 4-streams, Trace)."""

from __future__ import annotations

import json

import pytest
from play import check, rows

from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.frame_runner import run_loop
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.trace import TraceWriter, read_trace
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.exchange import Notice
from rrp_sheets.runs.records.tidy import tidy
from rrp_sheets.topics.connector_marbles import ScriptedWorld

BOOK = rows(
    """
    | Head yaw | map | 1 / headYaw | X |
    | X | map | value | |
    | | subscribe | | Print |
    """
)


@pytest.fixture
def trace(tmp_path):
    """A trace of three frames: a value, an error, a happening."""
    plan = make_plan(check(BOOK))
    path = tmp_path / "trace.jsonl"
    writer = TraceWriter(path, plan, {"seed": 7})
    engine = FrameEngine(plan, writer)
    world = ScriptedWorld([(0, "headyaw", 2), (33_333, "headyaw", 0)])
    run_loop(engine, world, world.start(), 66_666)
    writer.happening(66_666, Notice("say", "Hello", "print", "T!4"))
    writer.close({"ended": "time"})
    return path


def test_every_event_of_every_stream_is_there_in_order(trace):
    lines = list(read_trace(trace))
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
        {"t": 0.033333, "row": "T!2", "error": "This divides by zero.", "code": "FORM101", "inputs": [0]},
        {"t": 0.066666, "happening": "say", "text": "Hello", "stream": "Print", "row": "T!4"},
        {"type": "summary", "ended": "time"},
    ]


def test_a_line_that_a_crash_cut_off_is_left_out(trace):
    whole = trace.read_bytes()
    trace.write_bytes(whole[:-10])
    assert [line.get("type") for line in read_trace(trace)][-1] is None
    assert len(list(read_trace(trace))) == whole.count(b"\n") - 1


def test_the_table_has_a_row_per_event(trace):
    header, lines, _ = tidy(trace)
    table = [dict(zip(header, line, strict=True)) for line in lines]
    assert len(table) == 7
    assert [row["kind"] for row in table] == ["sensor", "stream", "anonymous", "actuator", "sensor", "error", "say"]
    assert table[5]["message"] == "This divides by zero." and table[6]["message"] == "Hello"


def test_what_is_no_trace_is_refused(tmp_path):
    (tmp_path / "x.jsonl").write_text("hello\n")
    with pytest.raises(UnreadableFile):
        list(read_trace(tmp_path / "x.jsonl"))
    with pytest.raises(UnreadableFile):
        list(read_trace(tmp_path / "gone.jsonl"))


def test_nothing_that_json_does_not_know_gets_into_a_trace(trace):
    for line in trace.read_text(encoding="utf-8").splitlines():
        json.loads(line, parse_constant=pytest.fail)
