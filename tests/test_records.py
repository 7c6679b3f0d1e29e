"""Recorded runs in the browser: the list, one run, its marbles and files; whatever is in their folders."""

from __future__ import annotations

import csv
import io
import re
import shutil
import zipfile
from pathlib import Path

import pytest
from browser import GOOD, get, visit
from busy import Span
from flask.testing import FlaskClient
from recorded import END, HEADER, write_run

from rrp_sheets import api
from rrp_sheets.recording.lookback import Index
from rrp_sheets.recording.metadata import metadata_of
from rrp_sheets.recording.timeline import build_timeline
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a workbook and a real run of it."""
    folder = tmp_path_factory.mktemp("real")
    book = shutil.copy(bundled("workbooks", "say-ball-colour-ja.xlsx"), folder)
    settings = api.RunSettings(seconds=4.0, fast=True, mode="pilot", participant="P-07", operator="Aya")
    ended = api.run_apart(book, settings)
    assert ended.result is not None and ended.result.broken is None
    return folder


@pytest.fixture(scope="module")
def client(real: Path) -> FlaskClient:
    return visit(real)


@pytest.fixture(scope="module")
def run(real: Path) -> str:
    return next((real / "runs").iterdir()).name


# ---- the list ----


@pytest.mark.slow
def test_the_list_says_what_a_run_was(client: FlaskClient, run: str) -> None:
    text = get(client, "/runs").text
    for expected in ("say-ball-colour-ja.xlsx", "P-07", "Aya", "Pilot: never data", "4.0 s", "ended as planned"):
        assert expected in text
    assert f'href="/runs/{run}"' in text


def test_no_run_yet_says_how_to_make_one(tmp_path: Path) -> None:
    assert "No recordings yet" in get(visit(tmp_path), "/runs").text


def test_runs_are_found_by_workbook_and_words(tmp_path: Path) -> None:
    write_run(tmp_path, "1-a", HEADER, END)
    write_run(tmp_path, "2-b", HEADER | {"name": "other.xlsx", "participant": "P-02"}, END)
    client = visit(tmp_path)
    assert get(client, "/runs").text.count('data-head="Workbook"') == 2
    for query, there in (
        ("book=other.xlsx", "P-02"),
        ("words=p-01+control", "P-01"),
        ("words=aya&book=good.md", "P-01"),
    ):
        text = get(client, f"/runs?{query}").text
        assert text.count('data-head="Workbook"') == 1 and f"{there}, Control" in text
    assert "No run matches this" in get(client, "/runs?words=nobody").text


# ---- one run ----


@pytest.mark.parametrize(
    ("language", "texts"),
    [("en", ("frame engine", "</svg>note</span>")), ("ja", ("フレームエンジン", "</svg>情報</span>"))],
)
def test_engine_and_notes_of_a_run_are_in_the_language_of_the_page(language, texts, tmp_path: Path) -> None:
    note = {"t": 0.5, "kind": "note", "text": "The recording is saved."}
    write_run(tmp_path, "1-a", HEADER, note, END)
    page = get(visit(tmp_path), "/runs/1-a", Accept_Language=language).text
    assert [text for text in texts if text not in page] == []


def test_a_run_shows_its_record_and_what_was_said(client: FlaskClient, run: str) -> None:
    text = get(client, f"/runs/{run}").text
    for expected in (
        'data-mode="pilot"', "P-07", "nao, frame engine, 30 Hz", "the same as in the folder now", "赤いボールです",
        f'src="/runs/{run}/file/say-001.wav"', f'src="/runs/{run}/file/strip.png"', f"/runs/{run}/file/film.gif",
        f"/runs/{run}/file/diagram.svg", f"/runs/{run}/file/run.xlsx?take=1", f"/runs/{run}/trace.csv",
        'data-at="3.03', '/help/recordings.html#Columns-of-the-tables"',
    ):  # fmt: skip
        assert expected in text
    assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:", text)


def test_a_workbook_that_was_changed_since_leads_to_the_comparison(real: Path, run: str, tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(real, folder)
    api.set_cell(folder / "say-ball-colour-ja.xlsx", "C3", "5 s", "色を言う")
    client = visit(folder)
    text = get(client, f"/runs/{run}").text
    assert "changed since" in text
    address = re.search(r'href="(/compare\?[^"]*)">What has changed', text)
    assert address
    compared = get(client, address[1].replace("&amp;", "&")).text
    assert "Different behaviour: 1 change." in compared and "<del>3</del>" in compared and "<ins>5</ins>" in compared
    (folder / "say-ball-colour-ja.xlsx").unlink()
    assert "no longer in this folder" in get(client, f"/runs/{run}").text


def test_errors_marks_and_edits_are_one_log(tmp_path: Path) -> None:
    failed = {"row": "Tracking!3", "error": "There is no distance.", "code": "FORM007", "inputs": []}
    lines = [
        {"t": 0.1, "happening": "mark", "text": "Kai comes closer", "by": "Aya"},
        *({"t": 1 + n / 30, **failed} for n in range(200)),
        {
            "t": 9.0,
            "happening": "edit",
            "text": "C5: 20 → 15",
            "row": "Tracking!5",
            "by": "Ken",
            "detail": {"place": "Tracking!5", "was": "20", "now": "15"},
        },
        {"t": 12.0, "stream": "Red ball", "row": "", "value": {"x": 0.25}, "stimulated": True, "by": "Mia"},
        {"t": 75.25, "happening": "say", "text": "Hello", "row": "Tracking!6"},
    ]
    write_run(tmp_path, "x", HEADER, *lines, END)
    client = visit(tmp_path)
    text = get(client, "/runs/x").text
    for expected in ("Kai comes closer", "by Aya", "There is no distance. (200 times, until 0:07.63)", "C5: 20 → 15",
                     "by Ken", "Red ball (x 0.25)", "by Mia", ">1:15.25<"):  # fmt: skip
        assert expected in text
    assert text.count("There is no distance.") == 1 and "<audio" not in text


def test_a_drag_is_one_line_and_the_diagram_says_what_was_changed_since(tmp_path: Path) -> None:
    def put(t: float, x: float, **more: object) -> dict[str, object]:
        detail = {"thing": "Red ball", "put": [x, 0, 0], **more}
        return {
            "t": t,
            "happening": "scene",
            "text": f"Red ball is placed at {x:.2f} m.",
            "by": "Mia",
            "detail": detail,
        }

    edit = {"happening": "edit", "by": "Ken", "text": "0.5 → 0.7"}
    lines = [
        {**put(1.0, 0, appears=True), "text": "Red ball appears at 0.00 m."},
        *(put(2 + n / 10, n) for n in range(60)),
        {"t": 5.0, "row": "Tracking!3", "error": "There is no distance."},
        put(8.0, 61),
        {"t": 8.5, "happening": "mark", "text": "Kai laughs", "by": "Aya"},
        put(9.0, 62),
        put(13.0, 63),
        {"t": 20.0, "row": "Tracking!3", **edit},
        {"t": 127.8, "row": "Tracking!3", **edit},
        *({"t": 130.0 + n, "row": f"Tracking!{n}", **edit} for n in range(4, 9)),
    ]
    place = write_run(tmp_path, "x", HEADER, *lines, END)
    (place / "diagram.svg").write_text("<svg/>")
    text = get(visit(tmp_path), "/runs/x").text
    shown = re.findall(r'class="of-scene".*?class="what">([^<]*?) <', text)
    assert shown == ["Red ball appears at 0.00 m.", "Red ball is dragged to 61.00 m (until 0:08.00)",
                     "Red ball is placed at 62.00 m.", "Red ball is placed at 63.00 m."]  # fmt: skip
    told = re.search(r'class="as-began">(.*?)</p>', text)
    assert told and "As it was at the start; <a" in told[1] and 'and <a href="#log">2 more</a>.' in told[1]
    [line] = re.findall(r'<a href="#([^"]*)">row 3 of Tracking was changed at 2:07.80</a>', told[1])
    assert re.search(f'<li class="of-edit" id="{line}"><button[^>]*data-at="127.8"', text)


# ---- marbles and curves ----


def test_marbles_of_some_rows_and_some_time(client: FlaskClient, run: str) -> None:
    def streams(query: str) -> set[str]:
        text = get(client, f"/runs/{run}/marbles?{query}").text
        assert " style=" not in text and "<svg" in text
        return set(re.findall(r'class="lane \w+" data-stream="([^"]*)"', text))

    assert {"ボール", "今のボール", "ことば", "話す", "赤いボール"} <= streams("")
    assert streams("row=4") == {"今のボール", "ことば"}
    assert streams("row=2") == {"赤いボール", "緑のボール", "青いボール", "ボール"}
    late = get(client, f"/runs/{run}/marbles?from=3&to=4").text
    assert "<title>3.1 s: " in late and "<title>2.9 s: " not in late
    for wrong, words in (
        ("from=soon", "not a time"),
        ("to=-1", "not a time"),
        ("from=3&to=1", "Nothing came"),
        ("from=99", "Nothing came"),
    ):
        text = get(client, f"/runs/{run}/marbles?{wrong}").text
        assert (
            re.search(f'notice is-error" role="status">[^<]*{words}', text) and "marble diagram" not in text.casefold()
        )


def test_the_curves_of_numbers(client: FlaskClient, run: str) -> None:
    curves = get(client, f"/runs/{run}/series.json").json
    assert isinstance(curves, list)
    distance = next(c for c in curves if c["name"] == "赤いボール.distance")
    assert distance["kind"] == "sensor" and all(0.3 < v < 1.5 for _, v in distance["points"])


def test_a_hundred_thousand_events_open_in_a_bounded_time(tmp_path: Path) -> None:
    events = [
        {"t": n / 100, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 99.0 if n == 70_001 else n % 7}
        for n in range(100_000)
    ]
    place = write_run(tmp_path, "long", HEADER, *events, END)
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    client = visit(tmp_path)
    span = Span()
    assert "100,000 values and events" in get(client, "/runs/long").text
    [curve] = get(client, "/runs/long/series.json").json  # type: ignore[misc]
    shown = get(client, "/runs/long/marbles").data
    whole = span.seconds()
    assert whole < 40 * span.crowded()  # 5 s on a machine that does nothing else
    assert len(curve["points"]) <= 1_200 and max(v for _, v in curve["points"]) == 99.0
    assert len(shown) < 300_000
    took = []
    for _ in range(3):
        span = Span()
        assert metadata_of(place).seconds == 8.0
        took.append(span.seconds())
    assert min(took) < whole / 10, "only its beginning and its end are read"


# ---- files ----


def test_files_come_with_safe_types(client: FlaskClient, run: str) -> None:
    kinds = {
        "strip.png": "image/png",
        "film.gif": "image/gif",
        "say-001.wav": "audio/wav",
        "diagram.svg": "image/svg+xml",
    }
    for name, kind in kinds.items():
        answer = get(client, f"/runs/{run}/file/{name}")
        assert answer.mimetype == kind and answer.headers["X-Content-Type-Options"] == "nosniff"
        assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'")
        opened = answer.headers.get("Content-Disposition", "inline").startswith("inline")
        assert opened is (name != "diagram.svg")  # a picture that could hold a script is never a page of its own
        taken = get(client, f"/runs/{run}/file/{name}?take=1").headers["Content-Disposition"]
        assert taken.startswith("attachment") and run in taken
    for name in ("run.xlsx", "protocol.xlsx", "trace.jsonl", "robot.toml"):
        assert get(client, f"/runs/{run}/file/{name}").headers["Content-Disposition"].startswith("attachment")


def test_the_events_as_csv_and_everything_as_zip(client: FlaskClient, run: str) -> None:
    answer = get(client, f"/runs/{run}/trace.csv")
    assert answer.mimetype == "text/csv"
    rows = list(csv.reader(io.StringIO(answer.data.decode("utf-8-sig"))))
    assert rows[0][:6] == ["time_s", "kind", "stream", "row", "value", "message"]
    assert ["話す", "色を言う!5", "", "赤いボールです"] in [r[2:6] for r in rows] and len(rows) > 50
    with zipfile.ZipFile(io.BytesIO(get(client, f"/runs/{run}/everything.zip").data)) as packed:
        names = {n.removeprefix(f"{run}/") for n in packed.namelist()}
        assert {"trace.csv", "trace.jsonl", "protocol.xlsx", "run.xlsx", "film.gif", "say-001.wav"} <= names
        assert packed.testzip() is None


def _stream(name: str, device: str) -> dict[str, object]:
    return {"stream": name, "kind": "actuator", "device": device}


def _given(t: float, stream: str, value: object) -> dict[str, object]:
    return {"t": t, "stream": stream, "row": f"T!{stream}", "value": value}


def test_gestures_and_every_other_actuator_are_in_what_happened(tmp_path: Path) -> None:
    """But those that tell themselves what they do: what is said, played, printed, remembered or switched."""
    devices = [d.name for d in load_robot().devices.values() if d.kind == "actuator"]
    header = {**HEADER, "streams": [_stream(f"My {name}", name) for name in devices]}
    place = write_run(tmp_path, "one", header, *(_given(n, f"My {name}", True) for n, name in enumerate(devices)), END)
    told = {line["text"] for line in build_timeline(place)["lines"]}
    others = {"SayInput", "SayParameter", "PlaySound", "Print", "RememberFace", "Behaviour"}
    assert told == {f"My {name}" for name in devices if name not in others} and "My Gesture" in told
    page = get(visit(tmp_path), "/runs/one").text
    assert page.count(">command</span>") == len(told) and "My Gesture" in page


def test_a_command_that_goes_on_is_one_line_and_another_gesture_is_the_next(tmp_path: Path) -> None:
    header = {**HEADER, "streams": [_stream(n, n) for n in ("Gesture", "EyeBrightness", "SayInput")]}
    events = [
        *(_given(t, "Gesture", name) for t, name in ((0, "Nod"), (0.5, "Wave"), (1, "Wave"), (1.5, None), (2, "Wave"), (9, "Wave"))),
        *(_given(10 + n / 30, "EyeBrightness", n / 3000) for n in range(3000)),
        _given(120, "SayInput", "Hello"), _given(121, "SayInput", None),
        {**_given(122, "Gesture", "Bow"), "stimulated": True, "by": "Aya"},
    ]  # fmt: skip
    place = write_run(tmp_path, "one", header, *events, END)
    told = build_timeline(place)["lines"]
    assert [(line["t"], line["text"], line["times"]) for line in told] == [
        (0, "Gesture: “Nod”", 1), (0.5, "Gesture: “Wave”", 2), (1.5, "Gesture: stops", 1), (2, "Gesture: “Wave”", 1),
        (9, "Gesture: “Wave”", 1), (10, "EyeBrightness: 0", 3000), (121, "SayInput: stops", 1), (122, "Gesture: “Bow”", 1),
    ]  # fmt: skip
    assert told[-1]["kind"] == "send" and told[-1]["by"] == "Aya"
    assert [vars(line) for line in Index(place).log] == told  # looking back has the same moments


def test_many_commands_leave_room_for_what_people_did(tmp_path: Path) -> None:
    header = {**HEADER, "streams": [_stream("Gesture", "Gesture")]}
    many = [_given(n, "Gesture", ("Nod", "Wave")[n % 2]) for n in range(2500)]
    place = write_run(tmp_path, "one", header, *many, {"t": 2500.0, "happening": "mark", "text": "Kai laughs"}, END)
    told = build_timeline(place)
    assert told["lines"][-1]["text"] == "Kai laughs" and told["left_out"] == 1500
