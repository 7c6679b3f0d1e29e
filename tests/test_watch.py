"""Output in the terminal during a run, and at its end."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rrp_sheets.cli.run import Watch
from rrp_sheets.cli.terminal import speak
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import DONE
from rrp_sheets.runs import RunResult, RunStart, Summary
from rrp_sheets.texts import N_

FRAME = 33_333  # µs


def watched(capsys, commands, summary, language="en", **left):
    """The lines that a run with these commands (µs, value) of one row prints."""
    watch = Watch()
    actuators = {"say": "Say", "look": "Look"}
    watch.started(RunStart("Book", 10_000_000, Path("out"), actuators=actuators, rows={0: "T!2"}, language=language))
    for us, value in commands:
        watch.event(us, "say", "T!2", value)
    watch.ended(RunResult(Path("out"), {"trace.jsonl": "every event"}, summary, **left))
    speak("en")
    said = capsys.readouterr()
    return [*said.out.splitlines(), *said.err.splitlines()]


@pytest.mark.parametrize(
    ("completed", "seconds", "shown"),
    [(True, 2.2333, "completed after 2.2 s"), (False, 0.04, "broken off after 0.04 s"), (True, 123.46, "completed after 123.5 s")],
)  # fmt: skip
def test_the_end_of_a_command_is_told_in_words(capsys, completed, seconds, shown):
    end = DONE.make(value="Hello", completed=completed, seconds=seconds)
    assert f"   1.00 s  Say ← {shown}  (T!2)" in watched(capsys, [(1_000_000, end)], Summary())


def test_a_run_that_breaks_off_is_told_in_its_language(capsys):
    broken = RunBroken(N_("The simulator is not running."), N_("Start the run again."))
    end = DONE.make(value="Hello", completed=False, seconds=2.21)
    problems = (N_("The table and the diagram could not be made."),)
    lines = watched(capsys, [(1_000_000, end), (2_000_000, None)], Summary(), "ja", broken=broken, problems=problems)
    assert "   1.00 s  Say ← 2.2秒で中断  (T!2)" in lines and "   2.00 s  Say：停止  (T!2)" in lines
    told = [line for line in lines if re.search("[ぁ-ん]", line)][-3:]
    assert told[0].startswith("実行は中断しました：") and told[1].startswith("  → ") and len(told) == 3
    assert not any(text in line for line in lines for text in ("simulator", "Start", "table"))


def test_a_blank_for_what_does_nothing_stops_nothing(capsys):
    lines = watched(capsys, [(0, None), (2_000_000, "Hello"), (9_000_000, None), (18_000_000, None)], Summary())
    assert [line.partition(" s  ")[2] for line in lines if "Say" in line] == [
        "Say ← “Hello”  (T!2)",
        "Say stops  (T!2)",
    ]


def test_the_whole_time_is_told(capsys):
    lines = watched(capsys, [(0, "Hello")], Summary(simulated=2.0, wall=1.0))
    assert any(re.fullmatch(r"With start, rest and files it took \d+\.\d s\.", line) for line in lines)


def test_one_is_one_and_seconds_are_rounded(capsys):
    one = Summary(commands={"Say": 1}, errors={"T!2": 1}, simulated=32.899999, wall=2.0)
    lines = watched(capsys, [(0, "Hello")], one)
    assert "Book: 1 row for 10 s. Ctrl-C stops." in lines
    assert "32.9 s in 2.0 s (16.4 times real time), 1 command, 1 error." in lines


def test_repeats_that_are_not_shown_are_named(capsys):
    many = Summary(commands={"Say": 186}, simulated=6, wall=3)
    lines = watched(capsys, [(n * FRAME, "Hello") for n in range(186)], many)
    assert sum("Say ←" in line for line in lines) == 1
    assert "6 s in 3.0 s (2.0 times real time), 186 commands (repeats are not shown), 0 errors." in lines
    two = Summary(commands={"Say": 2}, simulated=6, wall=3)
    lines = watched(capsys, [(0, "Hello"), (5_000_000, "Bye")], two)
    assert sum("Say ←" in line for line in lines) == 2 and not any("repeats" in line for line in lines)
