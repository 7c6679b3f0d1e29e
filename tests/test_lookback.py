"""Looking back at a run: what is recorded beside the trace, and that what is told of a time is what was then."""

from __future__ import annotations

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest
from PIL import Image

from rrp_sheets import api
from rrp_sheets.recording.lookback import answer
from rrp_sheets.recording.marbles import value_from_json
from rrp_sheets.recording.timeline import value_text
from rrp_sheets.workbook.files import make_workbook

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
BOOK = {
    "Look": [
        HEADER,
        ["", "Red ball", "map", "redBall.distance", "Distance", "how far"],
        ["", "Distance", "map", "1 / (distance - distance)", "Bad", "fails always"],
        ["", "Distance", "filter", "distance < 0.95", "Near", ""],
        ["", "Near", "once", "", "First", ""],
        ["", "First", "map", '"There you are"', "Words", ""],
        ["", "Words", "subscribe", "", "Say", ""],
        ["", "Red ball", "subscribe", "", "Head tracker", ""],
        ["", "Yaw", "map", "yaw * 2", "Twice", ""],
        ["", "Bad", "subscribe", "", "Print", ""],
        ["no", "Twice", "subscribe", "", "Print", "off"],
    ],
    "Devices": [["Stream", "Device", "Joint", "Rate"], ["Yaw", "JointPosition", "HeadYaw", "20"]],
    "Scene": [
        ["Time (s)", "Thing", "Does", "Value"],
        ["0.5", "Red ball", "appears", "at 1.0, 0.1, 0.45"],
        ["1", "Red ball", "moves", "to 0.7, 0.3, 0.45 in 1 s"],
        ["3", "Red ball", "disappears", ""],
    ],
    "Protocol": [["Field", "Value"], ["Robot", "nao"]],
}
SECONDS = 3.6


def go(book: Path, out: Path, **settings: Any) -> Path:
    ended = api.run_apart(
        book, api.RunSettings(**{"seconds": SECONDS, "fast": True, "film": False, **settings}, out=out)
    )
    assert ended.result is not None, ended.findings
    assert ended.result.broken is None
    return ended.result.folder


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workbook(BOOK, tmp_path_factory.mktemp("books") / "look.xlsx")


@pytest.fixture(scope="module")
def run(book: Path) -> Path:
    return go(book, book.parent / "runs" / "one")


def ask(place: Path, what: str, number: int = 0) -> Any:
    return json.loads(answer(place, what, number))


def events(place: Path) -> list[dict[str, Any]]:
    lines = (place / "trace.jsonl").read_text(encoding="utf-8").splitlines()
    return [e for e in map(json.loads, lines) if "t" in e]


def rows_told(place: Path, t: float) -> dict[str, tuple[float, str]]:
    """Values of every row at a time."""
    overview = ask(place, "overview")
    number = max(n for n, begin in enumerate(overview["pieces"]) if begin <= t)
    piece = ask(place, "piece", number)
    found: dict[str, tuple[float, str]] = {}
    for of, part in piece["series"].items():
        row, name, _ = overview["series"][int(of)]
        before = [(when, piece["words"][v]) for when, v in zip(part["t"], part["v"], strict=True) if when <= t]
        if row and name and before:
            found[row] = max(found.get(row, before[-1]), before[-1])
    return found


def rows_of_the_trace(place: Path, t: float) -> dict[str, tuple[float, Any]]:
    """The same from the trace itself: the last value of each row."""
    return {e["row"]: (e["t"], e["value"]) for e in events(place) if e.get("row") and "value" in e and e["t"] <= t}


# ---- values
@pytest.mark.slow
@pytest.mark.parametrize("t", [0.0, 0.55, 1.234, 2.0, 2.99, 3.2, SECONDS])
def test_the_values_of_a_time_are_those_of_the_trace(run: Path, t: float) -> None:
    mine, theirs = rows_told(run, t), rows_of_the_trace(run, t)
    assert mine.keys() == theirs.keys()
    assert {row: when for row, (when, _) in mine.items()} == {row: when for row, (when, _) in theirs.items()}
    units = {"Look!2": "m", "Look!4": "m", "Look!5": "m"}
    for row, (_, value) in theirs.items():
        if not isinstance(value, dict):
            assert mine[row][1] == value_text(value, units.get(row, "")), row
    if t >= 1:
        assert "distance " in mine["Look!8"][1] and mine["Look!8"][1].endswith(" m")  # a record keeps its units


def test_errors_speech_and_streams_have_their_names(run: Path) -> None:
    overview = ask(run, "overview")
    assert ["", "Yaw", "sensor"] in overview["series"] and ["Look!2", "Distance", "stream"] in overview["series"]
    bad = overview["series"].index(["Look!3", "", ""])
    piece = ask(run, "piece")
    assert {piece["words"][v] for v in piece["series"][str(bad)]["v"]} == {
        e["error"] for e in events(run) if "error" in e
    }
    said = [m for m in overview["moments"] if m["kind"] == "say"]
    assert [(m["text"], m["sound"], m["row"]) for m in said] == [("There you are", "say-001.wav", "Look!7")]
    assert [m["times"] for m in overview["moments"] if m["kind"] == "error" and m["row"] == "Look!3"] != [1]


def test_the_rows_and_the_diagram_are_those_that_ran(run: Path) -> None:
    (sheet,) = ask(run, "sheets")["sheets"]
    assert sheet["name"] == "Look" and [row[0] for row in sheet["rows"]] == list(range(2, 12))
    assert sheet["rows"][0] == [2, True, "Red ball", "map", "redBall.distance", "Distance", "how far"]
    assert not sheet["rows"][-1][1] and sheet["kinds"]["distance"] == "stream" and sheet["kinds"]["yaw"] == "sensor"
    assert 'data-row="2"' in answer(run, "diagram")


# ---- poses and pictures
def poses(place: Path) -> list[dict[str, Any]]:
    """The poses put together, line by line."""
    state: dict[str, Any] = {"joints": {}, "things": {}}
    found = []
    for number in range(len(ask(place, "overview")["poses"])):
        for line in ask(place, "poses", number):
            things = {**state["things"], **line.get("things", {})}
            state = {
                **state, **line, "joints": {**state["joints"], **line.get("joints", {})},
                "things": {n: at for n, at in things.items() if at is not None},
            }  # fmt: skip
            found.append(state)
    return found


def test_the_recorded_joints_are_those_that_the_sensor_gave(run: Path) -> None:
    yaws = {e["t"]: e["value"] for e in events(run) if e.get("stream") == "Yaw"}
    recorded = [(p["t"], p["joints"]["HeadYaw"]) for p in poses(run)]
    compared = [(angle, yaws[t]) for t, angle in recorded if t in yaws]
    assert len(compared) >= 8
    assert max(abs(a - b) for a, b in compared) < 0.02
    assert max(angle for _, angle in recorded) > 0.2  # it looked to the ball


def test_the_table_says_when_the_head_began_to_move(run: Path) -> None:
    (row,) = openpyxl.load_workbook(run / "run.xlsx")["Movements"].iter_rows(min_row=2, values_only=True)
    t, stream, place, *_, begin, end, response = row
    turned = [p["t"] for p in poses(run) if abs(p["joints"]["HeadYaw"]) > 0.02 or abs(p["joints"]["HeadPitch"]) > 0.02]
    assert (stream, place, begin) == ("Head tracker", "Look!8", turned[0])
    assert response == pytest.approx(begin - t, abs=0.001) and 0 < response < 0.5 and (end is None or end > begin)


def test_the_ball_is_where_the_scene_says_and_gone_when_it_goes(run: Path) -> None:
    def at(t: float) -> dict[str, Any]:
        return max((p for p in poses(run) if p["t"] <= t), key=lambda p: p["t"])

    assert at(0.3)["things"] == {}
    assert at(2.5)["things"]["Red ball"] == pytest.approx([0.7, 0.3, 0.45], abs=0.005)
    assert at(1.55)["things"]["Red ball"][0] == pytest.approx(0.85, abs=0.03)
    assert at(SECONDS)["things"] == {} and at(2.5)["looks"]["Red ball"]["colour"] == "red"
    assert {"There you are"} == {p["saying"] for p in poses(run) if p.get("saying")}


def test_the_camera_saw_the_ball(run: Path) -> None:
    times = ask(run, "overview")["pictures"]
    assert times[0] == 0 and 7 <= len(times) <= 9 and max(np.diff(times)) < 0.6
    red = []
    for number in range(len(times)):
        picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(answer(run, "picture", number)))), int)
        assert picture.shape == (240, 320, 3)
        red.append(int(((picture[..., 0] > 120) & (picture[..., 1:].max(axis=2) < 90)).sum()))
    seen = [t for t, pixels in zip(times, red, strict=True) if pixels > 20]
    assert seen and min(seen) >= 0.5 and max(seen) <= 3.0


@pytest.mark.slow
def test_nothing_of_a_run_depends_on_the_recording_and_pictures_can_be_left_out(
    book: Path, run: Path, tmp_path: Path
) -> None:
    place = go(book, tmp_path / "out", seconds=1.0, camera=False)
    assert not (place / "camera.zip").exists() and (place / "poses.jsonl").is_file()
    assert answer(place, "picture") == "" and ask(place, "overview")["pictures"] == []
    assert events(place) == [e for e in events(run) if e["t"] <= 1.0]


def test_a_half_written_folder_tells_what_there_is(run: Path, tmp_path: Path) -> None:
    whole = (run / "trace.jsonl").read_bytes()
    (tmp_path / "trace.jsonl").write_bytes(whole[: len(whole) // 2])
    assert ask(tmp_path, "overview")["count"] > 50
    assert ask(tmp_path, "sheets")["sheets"] == [] and "protocol.xlsx" in ask(tmp_path, "sheets")["why"]
    first = next(v for e in events(run) if (v := e.get("value")) and e.get("stream") == "Red ball")
    assert value_text(value_from_json("Red ball", first)).startswith("colour")
