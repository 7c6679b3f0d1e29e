"""Recorded runs in the browser: the list, one run, its marbles and files; whatever is in their folders."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shutil
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import GOOD, get, visit
from flask.testing import FlaskClient

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.runs.records.clerk import Clerk
from rrp_sheets.runs.records.facts import facts_of

HOSTILE = "<script>alert(1)</script>\"'"
HEADER: dict[str, Any] = {
    "type": "header", "format": 1, "program": "0.2.0", "workbook": "0" * 64, "name": "good.md", "robot": "nao",
    "engine": "frame", "frame_rate": 30, "mode": "simulated", "seed": 7, "participant": "P-01", "condition": "Control",
    "operator": "Aya", "began": "2026-11-02T09:05:00+00:00",
    "streams": [{"stream": "Red ball", "kind": "sensor", "device": "RedBall"},
                {"stream": "Tracking!Distance", "kind": "stream", "device": None}],
}  # fmt: skip
EVENT = {"t": 0.5, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 1.5}
END = {
    "type": "summary",
    "ended": "time",
    "simulated_seconds": 8.0,
    "events": {},
    "errors": {},
    "actuator_commands": {},
}


def write_run(folder: Path, name: str, *lines: dict[str, Any] | str) -> Path:
    """A run's folder with that trace; an old one, so that it is over."""
    place = folder / "runs" / name
    place.mkdir(parents=True)
    texts = [line if isinstance(line, str) else json.dumps(line) for line in lines]
    trace = place / "trace.jsonl"
    whole = not texts or texts[-1].endswith("}") or len(texts) < 3  # else its last line was cut off
    trace.write_text("\n".join(texts) + "\n" * whole, encoding="utf-8")
    os.utime(trace, (1_700_000_000, 1_700_000_000))
    return place


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


@pytest.fixture
def clerk() -> Iterator[Clerk]:
    made = Clerk()
    yield made
    made.close()


# ---- the list ----


def test_the_list_says_what_a_run_was(client: FlaskClient, run: str) -> None:
    text = get(client, "/runs").text
    for expected in ("say-ball-colour-ja.xlsx", "P-07", "Aya", "Pilot: never data", "4.0 s", "its time was over"):
        assert expected in text
    assert f'href="/runs/{run}"' in text


def test_no_run_yet_says_how_to_make_one(tmp_path: Path) -> None:
    assert "Nothing has run yet" in get(visit(tmp_path), "/runs").text


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
    assert "No run is like that" in get(client, "/runs?words=nobody").text


ODD = {
    "no trace": (None, "There is no trace.jsonl in it", False),
    "empty": ([""], "does not begin as a record", False),
    "no json": (["PK garbage"], "does not begin as a record", False),
    "other json": (["[1, 2]", "{}"], "does not begin as a record", False),
    "deep": (["[" * 100_000], "does not begin as a record", False),
    "only a header": ([HEADER], "the record has no end", True),
    "cut": ([HEADER, EVENT, '{"t": 1.0, "stre'], "the record has no end", True),
    "broken": ([HEADER, EVENT, END | {"ended": "broken", "by": "Tracking!4", "why": "It was stuck.", "remedy": "Mend it."}],
               "broke off at the row Tracking!4", True),
    "why": ([HEADER, EVENT, END | {"ended": "broken", "why": "It was stuck.", "remedy": "Mend it."}],
            "It was stuck. Mend it.", True),
    "stopped": ([HEADER, EVENT, END | {"ended": "stopped", "stopped_by": "Ken"}], "stopped by Ken", True),
    "by a row": ([HEADER, EVENT, END | {"ended": "end run", "by": "Tracking!9"}], "ended by the row Tracking!9", True),
    "wrong types": ([HEADER | {"name": [1], "began": 7, "mode": {}, "streams": 3}, END | {"events": 3, "errors": [1],
                     "simulated_seconds": "x"}], "its time was over", True),
    "failures": ([HEADER, END | {"errors": {"Tracking!3": 1200, "Tracking!4": 1}}], "1,201 errors", True),
}  # fmt: skip


@pytest.fixture(scope="module")
def odd(tmp_path_factory: pytest.TempPathFactory) -> FlaskClient:
    """A folder with all the odd runs, and one that is as it should be."""
    folder = tmp_path_factory.mktemp("odd")
    for name, (lines, _, _) in ODD.items():
        place = write_run(folder, name, *(lines or ()))
        if lines is None:
            (place / "trace.jsonl").unlink()
    write_run(folder, "good", HEADER, END)
    return visit(folder)


def test_good_runs_are_listed_beside_odd_ones(odd: FlaskClient) -> None:
    assert 'href="/runs/good"' in get(odd, "/runs").text


@pytest.mark.parametrize("name", ODD)
def test_whatever_lies_there_is_listed_with_what_is_wrong(odd: FlaskClient, name: str) -> None:
    _, words, opens = ODD[name]
    address = f"/runs/{name.replace(' ', '%20')}"
    listed = get(odd, f"/runs?words={name.replace(' ', '+')}")
    assert listed.status_code == 200 and words in listed.text
    assert (f'href="{address}"' in listed.text) is opens
    for part in ("", "/marbles", "/series.json", "/everything.zip"):
        assert get(odd, f"{address}{part}").status_code == 200, part
    fine = (200, 422) if name == "wrong types" else (200,) if opens else (422,)
    assert get(odd, f"{address}/trace.csv").status_code in fine


def test_a_run_that_goes_on_is_shown_as_such(tmp_path: Path) -> None:
    place = write_run(tmp_path, "now", HEADER, EVENT)
    assert facts_of(place).ended == "cut"
    assert facts_of(place, {"now"}).ended == "going"
    os.utime(place / "trace.jsonl")
    client = visit(tmp_path)
    assert "is going" in get(client, "/runs").text
    assert "This run is going on" in get(client, "/runs/now").text


# ---- one run ----


def test_a_run_shows_its_record_and_what_was_said(client: FlaskClient, run: str) -> None:
    text = get(client, f"/runs/{run}").text
    for expected in (
        'data-mode="pilot"', "P-07", "nao, frame engine, 30 Hz", "the same as in the folder now", "赤いボールです",
        f'src="/runs/{run}/file/say-001.wav"', f'src="/runs/{run}/file/strip.png"', f"/runs/{run}/file/film.gif",
        f"/runs/{run}/file/diagram.svg", f"/runs/{run}/file/run.xlsx?take=1", f"/runs/{run}/trace.csv",
        'data-at="3.03',
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
            "detail": "from 9 s on",
        },
        {"t": 12.0, "stream": "Red ball", "row": "", "value": {"x": 0.25}, "stimulated": True, "by": "Mia"},
        {"t": 75.25, "happening": "say", "text": "Hello", "row": "Tracking!6"},
    ]
    write_run(tmp_path, "x", HEADER, *lines, END)
    client = visit(tmp_path)
    text = get(client, "/runs/x").text
    for expected in ("Kai comes closer", "by Aya", "There is no distance. (200 times, until 0:07.6)", "C5: 20 → 15 from 9 s",
                     "by Ken", "Red ball (x 0.25)", "by Mia", ">1:15.2<"):  # fmt: skip
        assert expected in text
    assert text.count("There is no distance.") == 1 and "<audio" not in text


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
        ("from=soon", "no time"),
        ("to=-1", "no time"),
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


@pytest.mark.alone
def test_a_hundred_thousand_events_open_in_a_bounded_time(tmp_path: Path) -> None:
    events = [
        {"t": n / 100, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 99.0 if n == 70_001 else n % 7}
        for n in range(100_000)
    ]
    place = write_run(tmp_path, "long", HEADER, *events, END)
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    client = visit(tmp_path)
    began = time.monotonic()
    assert "100,000 values and events" in get(client, "/runs/long").text
    [curve] = get(client, "/runs/long/series.json").json  # type: ignore[misc]
    shown = get(client, "/runs/long/marbles").data
    assert time.monotonic() - began < 20
    assert len(curve["points"]) <= 1_200 and max(v for _, v in curve["points"]) == 99.0
    assert len(shown) < 300_000
    began = time.monotonic()
    assert facts_of(place).seconds == 8.0 and time.monotonic() - began < 0.1


def test_what_takes_too_long_is_ended_and_the_next_is_answered(tmp_path: Path, clerk: Clerk) -> None:
    place = write_run(tmp_path, "x", HEADER, EVENT, END)
    with pytest.raises(SheetsError, match="did not come to an end"):
        Clerk(within=0.0).course(place)
    assert clerk.course(place)["count"] == 1
    (place / "trace.jsonl").write_bytes(b"\xff\xfe")
    with pytest.raises(SheetsError, match="not a record"):
        clerk.course(place)
    assert clerk._child is not None
    clerk._child.kill()
    with pytest.raises(SheetsError, match="ended unexpectedly"):
        clerk.course(place)
    write_run(tmp_path, "y", HEADER, EVENT, END)
    assert clerk.course(tmp_path / "runs" / "y")["count"] == 1


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


def test_nothing_but_a_runs_own_files(tmp_path: Path) -> None:
    place = write_run(tmp_path, "x", HEADER, END)
    secret = tmp_path / "secret.wav"
    secret.write_text("secret")
    (place / "evil.html").write_text(HOSTILE)
    (place / "evil.js").write_text("1")
    (place / "link.wav").symlink_to(secret)
    (place / "folder.wav").mkdir()
    (tmp_path / "runs" / "linked").symlink_to(tmp_path)
    client = visit(tmp_path)
    for run in ("x", "linked", "..", ".", "%2e%2e", "..%2f..", "nothing", "x%2f..%2fx"):
        for name in (
            "evil.html",
            "evil.js",
            "link.wav",
            "folder.wav",
            "..%2f..%2fsecret.wav",
            "../../secret.wav",
            "secret.wav",
        ):
            assert get(client, f"/runs/{run}/file/{name}").status_code == 404, (run, name)
    assert "linked" not in get(client, "/runs").text
    with zipfile.ZipFile(io.BytesIO(get(client, "/runs/x/everything.zip").data)) as packed:
        assert sorted(packed.namelist()) == ["x/trace.csv", "x/trace.jsonl"]


def test_the_events_as_csv_and_everything_as_zip(client: FlaskClient, run: str) -> None:
    answer = get(client, f"/runs/{run}/trace.csv")
    assert answer.mimetype == "text/csv"
    rows = list(csv.reader(io.StringIO(answer.data.decode("utf-8-sig"))))
    assert rows[0][:6] == ["Time (s)", "Kind", "Stream", "Row", "Value", "Message"]
    assert ["話す", "色を言う!5", "", "赤いボールです"] in [r[2:6] for r in rows] and len(rows) > 50
    with zipfile.ZipFile(io.BytesIO(get(client, f"/runs/{run}/everything.zip").data)) as packed:
        names = {n.removeprefix(f"{run}/") for n in packed.namelist()}
        assert {"trace.csv", "trace.jsonl", "protocol.xlsx", "run.xlsx", "film.gif", "say-001.wav"} <= names
        assert packed.testzip() is None


def test_a_text_in_the_csv_is_never_a_formula(tmp_path: Path) -> None:
    write_run(tmp_path, "x", HEADER, EVENT | {"value": '=HYPERLINK("x")'}, EVENT | {"value": -2.5}, END)
    rows = list(csv.reader(io.StringIO(get(visit(tmp_path), "/runs/x/trace.csv").data.decode("utf-8-sig"))))
    assert [r[4] for r in rows[1:]] == ['\'=HYPERLINK("x")', "-2.5"]


def test_hostile_texts_are_shown_as_text(tmp_path: Path) -> None:
    fields = dict.fromkeys(("name", "participant", "condition", "operator", "robot", "engine", "program"), HOSTILE)
    streams = [{"stream": f"A!{HOSTILE}", "kind": HOSTILE, "device": None}]
    lines = [
        {"t": 0.0, "stream": f"A!{HOSTILE}", "row": HOSTILE, "value": HOSTILE},
        {"t": 0.1, "stream": f"A!{HOSTILE}", "row": HOSTILE, "value": 1}, {"t": 0.2, "stream": f"A!{HOSTILE}", "row": "", "value": 2},
        {"t": 0.5, "happening": HOSTILE, "text": HOSTILE, "by": HOSTILE, "row": HOSTILE, "detail": HOSTILE},
        {"t": 0.6, "happening": "say", "text": HOSTILE, "sound": "../../../etc/passwd"},
        {"t": 0.7, "row": HOSTILE, "error": HOSTILE},
    ]  # fmt: skip
    end = END | {
        "ended": "broken",
        "why": HOSTILE,
        "by": HOSTILE,
        "errors": {HOSTILE: 1},
        "actuator_commands": {HOSTILE: 1},
    }
    write_run(tmp_path, "a <b> {{7*7}} '\"&", HEADER | fields | {"streams": streams}, *lines, end)
    client = visit(tmp_path)
    name = "a%20%3Cb%3E%20%7B%7B7*7%7D%7D%20'%22&"
    for address in ("/runs", f"/runs?words={HOSTILE}&book={HOSTILE}", f"/runs/{name}", f"/runs/{name}/marbles?behaviour={HOSTILE}",
                    f"/compare?first={HOSTILE}&second=run/x&book={HOSTILE}"):  # fmt: skip
        answer = get(client, address)
        assert answer.status_code == 200, address
        assert "<script>" not in answer.text and "<b> {{" not in answer.text and " 49 " not in answer.text
        assert "&lt;script&gt;" in answer.text or "marbles" in address or "compare" in address, address
        assert "passwd" not in answer.text
