"""The workbooks for socially assistive robotics: in order, tested by their own sheets, and changed as therapists do."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import pytest
from play import check
from test_workbooks import FOLDER, THERAPY

from rrp_sheets import api
from rrp_sheets.checks import Checked
from rrp_sheets.testing import run_tests


@functools.cache
def checked(name: str) -> Checked:
    return api.check(FOLDER / f"{name}.xlsx")


def source(name: str) -> str:
    return (FOLDER / "source" / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", THERAPY)
def test_nothing_is_found_not_even_information(name: str) -> None:
    assert checked(name).report.flatten(["code", "cell"]) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", THERAPY)
def test_it_says_what_it_is_for_and_how_to_change_it(name: str) -> None:
    book = checked(name).workbook
    for field in ("Title", "Purpose", "Participants", "What happens", "To change it", "Data kept", "Retention"):
        assert len(book.protocol.text(field)) > 10, field
    assert "operator" in book.protocol.text("What happens")
    assert book.protocol.text("Time limit") and book.scene
    notes = [row.notes for b in book.behaviours for row in b.rows]
    assert sum(1 for note in notes if note) >= len(notes) // 8


@pytest.mark.slow
@pytest.mark.parametrize("name", THERAPY)
def test_its_own_tests_hold(name: str) -> None:
    report = run_tests(checked(name))
    assert len(report.cases) >= 3
    assert [c.case.name for c in report.cases if not c.passed] == []


# ---- changed as a therapist changes them

CHANGES = [
    ("touch-and-name", "| Left foot | left foot |", "| Right hand | right hand | And my right hand? | It is here. | Wave |\n| Left foot | left foot |"),
    ("touch-and-name", '["Yes!"; "Well done!"; "Super!"; "You found it!"]', "[„Ja!“; „Gut gemacht!“; „Prima!“]"),
    ("touch-and-name", "| Start | OperatorButton | Start |", "| Start | OperatorButton |  |"),
    ("sing-and-dance", "| Now all together, clap your hands! | Clap | magenta |\n", ""),
    ("sing-and-dance", "| yes, okay, again, no, stop |", "| yes, okay, again, no, stop, yeah |"),
    ("attention-training", "| Trials |  | 3 |", "| Trials |  | 10 |"),
    ("attention-training", "| Look over there! | Point left | 0.7 | white |\n", ""),
    ("exercise-coach", "| And four |\n", "| Four |\n| Five |\n| Six |\n"),
    ("exercise-coach", "| Arms up | Let your arms hang. Breathe. | 6 s |", "| Shrug | Let your arms hang. Breathe. | 1 min |"),
    ("follow-my-pointing", "| red | Point left | 0.6 |\n| blue | Point right | -0.6 |", "| blue | Point right | -0.5 |\n| red | Point left | 0.5 |"),
    ("story", "| Once upon a time there was a little robot who lived on a hill. |  | white |", "| Es war einmal ein kleiner Roboter. | Wave | pink |"),
    ("reception", "| toilet | The toilet is just here on the right. | Point right |", "| toilet | The toilet is upstairs. |  |"),
    ("reception", "| Nobody | 20 s without a face |", "| Nobody | half a minute |"),
    ("mixed-control", "| Where is your nose? | Touch head |", "| Do you like music? | Dance |\n| Where is your nose? | Touch head |"),
    ("greeter-with-memory", "| forgetAfter | 20 s |", "| forgetAfter | 5 min |"),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "before", "after"), CHANGES, ids=lambda t: re.sub(r"\W+", " ", t)[:30])
def test_a_change_of_a_therapist_is_in_order(name: str, before: str, after: str) -> None:
    assert before in source(name)
    assert check(source(name).replace(before, after, 1)).report.flatten(["code", "cell"]) == []


def test_a_longer_pause_is_told_by_the_tests_with_the_time_at_which_it_came() -> None:
    patient = check(source("story").replace("| timeout | 6 s |", "| timeout | 9 s |", 1))
    results = [row for case in run_tests(patient).cases for row in case.rows if not row.passed]
    assert [(r.row.row, r.row.name) for r in results] == [
        (5, "Tell"), (6, "Eyes"),
    ]  # fmt: skip


def test_a_story_in_german() -> None:
    """Another language is a column of the sheet Devices."""
    text = source("story")
    begin, end = text.index("## Devices"), text.index("## Scene")
    lines = text[begin:end].strip().split("\n")
    header, dashes, *rows = lines[1:]
    spoken = [f"{row} {'de' if '| Say' in row else ''} |" for row in rows]
    devices = "\n".join([lines[0], f"{header} Language |", f"{dashes}---|", *spoken])
    book = check(f"{text[:begin]}{devices}\n\n{text[end:]}".replace("One day he heard", "Eines Tages hörte er"))
    assert book.report.flatten(["code", "cell"]) == []
    told = {
        s.name: s.settings["language"] for s in book.graph.streams.values() if s.device and "language" in s.settings
    }
    assert told["Tell"] == told["Glad"] == "de"


# ---- in the simulator


def test_a_trial_of_attention_training_in_the_simulator(tmp_path: Path) -> None:
    """The first trial: the head turns to the picture, the operator's press is praised, the eyes are green."""
    path = FOLDER / "attention-training.xlsx"
    _, result = api.run(path, api.RunSettings(seconds=5.5, fast=True, out=tmp_path, film=False))
    assert result is not None and result.broken is None and result.summary.errors == {}
    lines = [json.loads(line) for line in (tmp_path / "trace.jsonl").read_text(encoding="utf-8").splitlines()]
    happenings = [(e["happening"], e.get("text", "")) for e in lines if "happening" in e]
    assert not [h for h in happenings if h[0] in ("error", "clamp", "refused")]
    said = [text for kind, text in happenings if kind == "say"]
    assert said[0] == "Oh, look!" and said[1] in ("Great looking!", "You saw it!", "Well done!") and len(said) == 2
    came = {e["stream"]: e["value"] for e in lines if "stream" in e and "value" in e}
    assert came["Score"] == "Trial 1: looked at step 1" and came["Ask done"]["completed"] and came["Gaze"] == 0


@pytest.mark.soak
@pytest.mark.parametrize("name", THERAPY)
def test_it_runs_to_its_end_without_error_clamp_or_fall(name: str, tmp_path: Path) -> None:
    _, result = api.run(FOLDER / f"{name}.xlsx", api.RunSettings(fast=True, out=tmp_path))
    assert result is not None and result.broken is None
    assert result.summary.errors == {}
    lines = [json.loads(line) for line in (tmp_path / "trace.jsonl").read_text(encoding="utf-8").splitlines()]
    told = [e for e in lines if e.get("happening") in ("error", "clamp", "refused")]
    assert told == []
    assert not [e for e in lines if "did not do this" in str(e.get("text"))], "a row of the scene has waited in vain"
    assert {p.name for p in tmp_path.iterdir()} >= {"strip.png", "film.gif", "say-001.wav"}
