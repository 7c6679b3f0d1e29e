"""Traces that strangers wrote by hand: every page, export and replay says that they are none, or shows them as text."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest
from recorded import END, EVENT, HEADER, write_run

from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.run_files import RecordedNotice
from rrp_sheets.recording.metadata import metadata_of
from rrp_sheets.recording.table import write_xlsx
from rrp_sheets.recording.trace_reader import TraceReader
from rrp_sheets.replay.record import read_record

_VALUE = '{"t": 9, "stream": "Tracking!Distance", "row": "Tracking!2", "value": %s}'
HOSTILE = {
    "endless time": '{"t": Infinity, "happening": "say", "text": "x"}',
    "no time": '{"t": NaN, "happening": "say", "text": "x"}',
    "time before the run": '{"t": -5, "happening": "say", "text": "x"}',
    "time of many digits": '{"t": %s, "happening": "say", "text": "x"}' % ("9" * 4000),
    "time as text": '{"t": "soon", "happening": "say", "text": "x"}',
    "number of many digits": _VALUE % ("9" * 400),
    "more digits than can be read": _VALUE % ("9" * 5000),
    "lists in lists": _VALUE % ("[" * 700 + "]" * 700),
    "records in records": _VALUE % ('{"a": ' * 400 + "1" + "}" * 400),
    "deeper than can be read": _VALUE % ("[" * 100_000 + "]" * 100_000),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_no_run_has_is_no_trace(tmp_path: Path, name: str) -> None:
    place = write_run(tmp_path, "odd", HEADER, EVENT, HOSTILE[name], END)
    with pytest.raises(UnreadableFile):
        list(TraceReader(place))
    with pytest.raises(UnreadableFile):
        read_record(place)
    with pytest.raises(UnreadableFile):
        write_xlsx([place / "trace.jsonl"], tmp_path / "run.xlsx")
    assert not list(tmp_path.glob("run.xlsx*"))


@pytest.mark.parametrize("seconds", ["NaN", "1e999", "-1e308", "-3", "1e300"])
def test_a_length_that_is_none_is_told(tmp_path: Path, seconds: str) -> None:
    end = json.dumps(END).replace("8.0", seconds)
    place = write_run(tmp_path, "odd", HEADER, EVENT, end)
    assert seconds in (place / "trace.jsonl").read_text()
    with pytest.raises(UnreadableFile):
        read_record(place)


def test_half_a_letter_is_read_as_one_that_can_be_written(tmp_path: Path) -> None:
    text = '{"t": 1, "happening": "say", "text": "\\ud800 caf\\u00e9 \\ud83d\\ude00 C:\\\\ud800"}'
    place = write_run(tmp_path, "odd", HEADER, text, END)
    (said,) = TraceReader(place)
    assert isinstance(said, RecordedNotice) and said.text == "? café 😀 C:\\ud800"


def test_long_lines_of_ours_are_read_as_they_are(tmp_path: Path) -> None:
    line: dict[str, Any] = {**EVENT, "value": [[1, [2, 3.5]], "x" * 2000, [[n] for n in range(100)], 10**15]}
    place = write_run(tmp_path, "long", HEADER, line, END)
    assert [event.entry() for event in TraceReader(place)] == [line]


@pytest.mark.skipif(sys.platform == "win32", reason="there are no named pipes in folders")
def test_a_pipe_in_place_of_a_trace_is_not_waited_for(tmp_path: Path) -> None:
    place = tmp_path / "runs" / "odd"
    place.mkdir(parents=True)
    os.mkfifo(place / "trace.jsonl")
    facts = metadata_of(place)
    assert not facts.readable and "it is not a file" in facts.why
