"""Every workbook of the thesis: it checks, it runs for its scene, and the robot is told what its rows say."""

from __future__ import annotations

import functools
import json
import re
import wave
from pathlib import Path

import pytest

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.resources import bundled
from rrp_sheets.runs import running
from rrp_sheets.scene.scene_sheet import scene_end_us
from rrp_sheets.workbook import read

FOLDER = bundled("workbooks")
NAMES = [
    "complex-tracking", "complex-tracking-fixed", "debugging-exercise", "distance-to-brightness", "greeter",
    "reflect-ball-colour", "say-ball-colour", "say-ball-colour-ja", "say-ball-colour-merge", "simple-tracking",
]  # fmt: skip
THERAPY = [
    "attention-training", "exercise-coach", "follow-my-pointing", "greeter-with-memory", "mixed-control", "reception",
    "sing-and-dance", "story", "touch-and-name",
]  # fmt: skip
"""Of these test_sar_workbooks.py tells more."""
EXPECTED_WARNINGS: dict[str, list[tuple[str]]] = {"complex-tracking": [("LINT001",)]}

COVERED = {
    "complex-tracking-fixed", "debugging-exercise", "distance-to-brightness", "greeter", "reflect-ball-colour",
    "say-ball-colour-ja", "say-ball-colour-merge", "simple-tracking",
}  # fmt: skip
"""Workbooks whose runs are nearly those of another, or are looked at by another test here."""
FILMED = "complex-tracking"
FASTER = {
    "complex-tracking": 3, "complex-tracking-fixed": 3, "debugging-exercise": 5, "distance-to-brightness": 5, "greeter": 5,
    "reflect-ball-colour": 5, "say-ball-colour": 3, "say-ball-colour-ja": 3, "say-ball-colour-merge": 3,
    "simple-tracking": 2,
}  # fmt: skip
"""Workbooks whose times are divided by a number in CI, as their runs are long; `make soak` runs them as they are."""
SHORTER = {
    "complex-tracking-fixed": ("[1] < 1 ", "[1] < 1/3 "), "debugging-exercise": ("500 ms", "100 ms"),
    "distance-to-brightness": ("500 ms", "100 ms"), "greeter": ("10 s", "2 s"), "say-ball-colour": ("3 s", "1 s"),
    "say-ball-colour-ja": ("3 s", "1 s"), "say-ball-colour-merge": ("3 s", "1 s"),
}  # fmt: skip
"""The duration in the rows of such a workbook that is replaced, and by which one."""
ENDS = {
    "complex-tracking": 14, "complex-tracking-fixed": 13, "debugging-exercise": 13, "greeter": 41,
    "reflect-ball-colour": 13, "say-ball-colour": 14.5, "say-ball-colour-ja": 15, "say-ball-colour-merge": 16,
}  # fmt: skip
"""Seconds of the workbook after which its scene has nothing new: a ball goes on circling or goes away, somebody leaves."""

check = functools.cache(api.check)


def sped_up(name: str) -> str:
    """The source of a workbook, with the times of its scene and one duration of its rows made shorter."""
    pace, (long, short) = FASTER[name], SHORTER.get(name, ("", ""))
    text = (FOLDER / "source" / f"{name}.md").read_text(encoding="utf-8")
    rows, head, rest = re.split("(## (?:Scene|シーン)\n)", text, maxsplit=1)
    scene, *tests = rest.split("\n## ", 1)
    assert head and long in rows
    scene = re.sub(r"(?m)(^\| | in | period )([\d.]+)", lambda m: f"{m[1]}{round(float(m[2]) / pace, 3)}", scene)
    return "\n## ".join([rows.replace(long, short) + head + scene, *tests])


class Ran:
    """A finished run: its folder, and what its trace says of a stream, as pairs of (seconds of the workbook, value)."""

    def __init__(self, path: Path, folder: Path, result, pace: int) -> None:
        self.path, self.folder, self.result, self.pace = path, folder, result, pace
        self.lines = [json.loads(line) for line in (folder / "trace.jsonl").read_text(encoding="utf-8").splitlines()]

    def __getitem__(self, stream: str):
        return [(e["t"] * self.pace, e["value"]) for e in self.lines if e.get("stream") == stream and "value" in e]

    def said(self):
        return [(e["t"] * self.pace, e["text"]) for e in self.lines if e.get("happening") == "say"]


@pytest.fixture(scope="module", params=["sped up", pytest.param("as it is", marks=pytest.mark.soak)])
def ran(request, tmp_path_factory):
    """Runs a workbook once, whatever number of tests look at it."""
    base = tmp_path_factory.mktemp("runs of 日本")

    @functools.cache
    def run(name: str) -> Ran:
        path, folder, look = FOLDER / f"{name}.xlsx", base / name, name == FILMED
        pace = FASTER.get(name, 1) if request.param == "sped up" else 1
        end = scene_end(path)
        if pace > 1:
            (base / f"{name}.md").write_text(sped_up(name), encoding="utf-8")
            path, end = api.convert(base / f"{name}.md", base / f"{name}.xlsx"), ENDS.get(name, end) / pace
        settings = api.RunSettings(seconds=end, fast=True, out=folder, film=look, camera=look)
        _, result = api.run(path, settings)
        assert result is not None and result.broken is None
        assert (result.summary.ended, result.summary.errors) == ("time", {})
        return Ran(path, folder, result, pace)

    return run


def scene_end(path: Path) -> float:
    """Seconds, and a little more."""
    return scene_end_us(check(path).scene or ()) / 1e6 + 1.5


def test_scenes_that_are_left_early_are_longer_than_that():
    ends = {name: scene_end(FOLDER / f"{name}.xlsx") for name in ENDS}
    assert {name: seconds for name, seconds in ENDS.items() if seconds >= ends[name]} == {}


def test_the_workbooks_of_the_thesis_and_those_for_therapy_are_there():
    assert sorted([*NAMES, *THERAPY]) == sorted(p.stem for p in FOLDER.glob("*.xlsx"))


@pytest.mark.parametrize("name", NAMES)
def test_it_checks_with_the_expected_warnings_only(name):
    assert check(FOLDER / f"{name}.xlsx").report.flatten(["code"]) == EXPECTED_WARNINGS.get(name, [])


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in COVERED)) for name in [*NAMES, *THERAPY]]
)
def test_it_is_what_make_py_makes_of_its_source(name, tmp_path):
    made = api.convert(FOLDER / "source" / f"{name}.md", tmp_path / "made.xlsx")
    assert made.read_bytes() == (FOLDER / f"{name}.xlsx").read_bytes(), "run `python workbooks/make.py`"


@pytest.mark.parametrize("name", NAMES)
def test_its_markdown_twin_says_the_same(name):
    book, twin = check(FOLDER / f"{name}.xlsx"), check(FOLDER / "source" / f"{name}.md")
    for graph in (book, twin):
        assert not graph.report.errors
    assert meaning(book) == meaning(twin)
    assert book.scene is not None and twin.scene is not None
    assert [(a.time_us, a.thing, a.verb, a.values) for a in book.scene] == [
        (a.time_us, a.thing, a.verb, a.values) for a in twin.scene
    ]


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in COVERED)) for name in NAMES])
def test_it_runs_for_its_scene_without_errors(ran, name):
    run = ran(name)
    assert [e for e in run.lines if e.get("happening") == "error"] == []
    assert sum(run.result.summary.commands.values()) > 0


def meaning(checked):
    """Content of a workbook, without places."""
    book = checked.workbook
    return {
        "rows": [[(s.number, s.connector.name, s.inputs, s.row.formula.text, s.output, s.active) for s in b.steps]
                 for b in checked.graph.behaviours],
        "devices": [(s.id, s.kind, s.device and s.device.name, dict(s.settings)) for s in checked.graph.streams.values()],
        "helpers": [(h.name.text, [i.text for i in h.inputs], h.formula.text) for h in book.helpers],
        "protocol": {k: c.text for k, c in book.protocol.fields.items()},
    }  # fmt: skip


def seconds(events, first=0.0, last=1e9):
    return [value for t, value in events if first <= t <= last]


@pytest.mark.slow
def test_reflect_ball_colour(ran):
    eyes = ran("reflect-ball-colour")["Eye LED color"]
    assert set(map(tuple, seconds(eyes, 1.5, 5))) == {(1, 0, 0)}
    assert set(map(tuple, seconds(eyes, 6.5, 10))) == {(0, 1, 0)}
    assert set(map(tuple, seconds(eyes, 11.5, 15))) == {(0, 0, 1)}


def test_say_ball_colour(ran):
    said = [text for _, text in ran("say-ball-colour").said()]
    assert list(dict.fromkeys(said)) == ["Red", "Green", "Blue"]


@pytest.mark.slow
def test_say_ball_colour_with_merge(ran):
    said = [text for _, text in ran("say-ball-colour-merge").said()]
    assert list(dict.fromkeys(said)) == ["I see a red ball", "I see a green ball", "I see a blue ball"]


@pytest.mark.slow
def test_say_ball_colour_in_japanese(ran):
    said = [text for _, text in ran("say-ball-colour-ja").said()]
    assert list(dict.fromkeys(said)) == ["赤いボールです", "緑のボールです", "青いボールです"]


def test_speech_is_audio_with_its_duration(ran):
    folder = ran("say-ball-colour").folder
    wavs = sorted(folder.glob("*.wav"))
    assert len(wavs) == len(ran("say-ball-colour").said())
    for path in wavs:
        with wave.open(str(path)) as sound:
            assert 0.2 < sound.getnframes() / sound.getframerate() < 3


def test_distance_to_brightness(ran):
    run = ran("distance-to-brightness")
    brightness = run["Eye brightness"]
    assert max(seconds(brightness, 0, 3)) <= 0.1  # far: dark
    assert min(seconds(brightness, 7.6, 9)) >= 0.9  # near: bright
    assert max(seconds(brightness, 14, 18)) <= 0.1
    pairs = list(zip(seconds(run["Brightness!Distance"]), seconds(brightness), strict=True))
    assert len(pairs) > 20
    assert all(b1 >= b2 for d1, b1 in pairs for d2, b2 in pairs if d1 < d2)


@pytest.mark.slow
def test_the_debugging_exercise_has_its_mistake(ran):
    run = ran("debugging-exercise")
    pairs = list(zip(seconds(run["Brightness!Distance"]), seconds(run["Eye brightness"]), strict=True))
    assert len(pairs) > 20
    assert all(b1 <= b2 for d1, b1 in pairs for d2, b2 in pairs if d1 < d2)
    assert min(seconds(run["Eye brightness"], 7.6, 9)) <= 0.1


@pytest.mark.slow
def test_simple_tracking(ran):
    run = ran("simple-tracking")
    assert seconds(run["Head tracker"], 0.5, 5) and not seconds(run["Head and body tracker"], 0.5, 5)
    assert seconds(run["Head and body tracker"], 7.5, 11.9) and not seconds(run["Head tracker"], 7.5, 11.9)
    assert seconds(run["Head tracker"], 15, 18)
    assert all(d >= 0.8 for d in seconds(run["Head tracker"]))
    # the ball is kept near the middle of the picture: that is what tracking means
    late = [b["x"] for t, b in run["Red ball"] if 4.5 <= t <= 5 or 11.5 <= t <= 12]
    assert late and max(map(abs, late)) < 0.15


@pytest.mark.slow
def test_greeter(ran):
    run = ran("greeter")
    said = run.said()
    assert [text for _, text in said] == ["Hello", "Hello again", "Hello"]
    assert [round(t) for t, _ in said] == [10, 30, 40]
    assert [round(t) for t, _ in run["Remember face"]] == [10, 40]


def far_intervals(run):
    """Times of arm commands, and for each how long ago the ball was last seen close."""
    close = [t for t, _ in run["Tracking!Close ball"]]
    return [(t, t - max((c for c in close if c <= t), default=-1e9)) for t, _ in run["Arm tracker"]]


def test_complex_tracking_drives_the_arm_while_the_ball_is_far(ran):
    run = ran("complex-tracking")
    assert seconds(run["Head tracker"]) and seconds(run["Head and body tracker"])
    assert max(age for _, age in far_intervals(run)) > 3
    far = [t for t, d in run["Tracking!Distance"] if d >= 1.5 and t > 11.5]
    assert any(far[0] <= t <= far[-1] for t, _ in run["Arm tracker"])


@pytest.mark.slow
def test_with_timestamps_the_arm_is_never_driven_later_than_a_second_after_close(ran):
    run = ran("complex-tracking-fixed")
    intervals = far_intervals(run)
    assert len(intervals) > 10 and max(age for _, age in intervals) <= 1.0
    assert any(t > 11 for t, _ in run["Head tracker"])  # the ball went away again, and the head followed


def test_a_run_leaves_everything_in_its_folder(ran):
    folder = ran(FILMED).folder
    names = {p.name for p in folder.iterdir()}
    kept = {"trace.jsonl", "protocol.xlsx", "robot.toml", "gestures.toml", "run.xlsx", "diagram.svg"}
    assert names == kept | {"film.gif", "strip.png", "poses.jsonl", "camera.zip"}
    assert (folder / "protocol.xlsx").read_bytes() == ran(FILMED).path.read_bytes()


def test_the_trace_has_header_events_and_summary(ran):
    run = ran(FILMED)
    header, summary = run.lines[0], run.lines[-1]
    assert header["type"] == "header" and header["robot"] == "nao" and header["engine"] == "frame"
    assert header["mode"] == "simulated" and header["seed"] == 7 and len(header["workbook"]) == 64
    assert summary["type"] == "summary" and summary["simulated_seconds"] == pytest.approx(
        ENDS[FILMED] / run.pace, abs=1 / 30
    )
    assert summary["events"]["Red ball"] == len(run["Red ball"])


def test_a_run_lasts_five_seconds_longer_than_its_scene_by_itself(tmp_path):
    reading = read(FOLDER / "simple-tracking.xlsx")
    checked = check_workbook(reading.workbook, reading.report)
    settings = api.RunSettings(fast=True, out=tmp_path)
    summary = running.run(reading, checked, settings, world=lambda *_: ScriptedWorld([])).summary
    assert (summary.ended, summary.simulated) == ("time", 19)


def test_the_table_of_the_run_is_tidy(ran):
    import openpyxl

    run = ran(FILMED)
    sheet = openpyxl.load_workbook(run.folder / "run.xlsx", read_only=True).active
    header, *lines = list(sheet.iter_rows(values_only=True))
    assert header[:6] == ("time_s", "kind", "stream", "row", "value", "message")
    assert len(lines) == len(run.lines) - 2
    distances = [dict(zip(header, line, strict=False)) for line in lines]
    first = next(d for d in distances if d["stream"] == "Tracking!Distance")
    assert first["row"] == "Tracking!2" and 1 < first["value"] < 2 and first["kind"] == "stream"


def test_film_and_strip_show_something(ran):
    from PIL import Image

    folder = ran(FILMED).folder
    with Image.open(folder / "film.gif") as film:
        assert film.n_frames > 20
        first = film.convert("RGB").tobytes()
        film.seek(film.n_frames // 2)
        assert film.convert("RGB").tobytes() != first
    with Image.open(folder / "strip.png") as strip:
        assert strip.width > 3 * strip.height
        reds = sum(1 for r, g, b in strip.convert("RGB").get_flattened_data() if r > 150 and g < 60 and b < 60)
        assert reds > 200  # the ball is in it


def test_json_lines_are_plain_json(ran):
    for line in (ran(FILMED).folder / "trace.jsonl").read_text(encoding="utf-8").splitlines():
        json.loads(line)
