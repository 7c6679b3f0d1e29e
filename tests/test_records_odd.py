"""Records of runs that are odd, broken or hostile: all of them are shown for what they are, and nothing else is."""

from __future__ import annotations

import csv
import errno
import io
import os
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import get, visit
from flask.testing import FlaskClient
from processes import killed
from recorded import END, EVENT, HEADER, HOSTILE, write_run

from rrp_sheets.errors import SheetsError
from rrp_sheets.recording.metadata import metadata_of
from rrp_sheets.services import query_worker
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.workers import worker_process
from rrp_sheets.workers.transport import ready


@pytest.fixture
def queries() -> Iterator[QueryWorker]:
    made = QueryWorker()
    yield made
    made.close()


ODD = {
    "no trace": (None, "There is no trace.jsonl in it", False),
    "empty": ([""], "does not start like the recording", False),
    "no json": (["PK garbage"], "does not start like the recording", False),
    "other json": (["[1, 2]", "{}"], "does not start like the recording", False),
    "deep": (["[" * 100_000], "does not start like the recording", False),
    "only a header": ([HEADER], "the recording has no end", True),
    "cut": ([HEADER, EVENT, '{"t": 1.0, "stre'], "the recording has no end", True),
    "broken": ([HEADER, EVENT, END | {"ended": "broken", "by": "Tracking!4", "why": "It was stuck.", "remedy": "Mend it."}],
               "stopped unexpectedly at row Tracking!4", True),
    "why": ([HEADER, EVENT, END | {"ended": "broken", "why": "It was stuck.", "remedy": "Mend it."}],
            "It was stuck. Mend it.", True),
    "stopped": ([HEADER, EVENT, END | {"ended": "stopped", "stopped_by": "Ken"}], "stopped by Ken", True),
    "by a row": ([HEADER, EVENT, END | {"ended": "end run", "by": "Tracking!9"}], "ended by the row Tracking!9", True),
    "wrong types": ([HEADER | {"name": [1], "began": 7, "mode": {}, "streams": 3}, END | {"events": 3, "errors": [1],
                     "simulated_seconds": "x"}], "ended as planned", True),
    "no streams": ([{"type": "header", "version": 1}, {"t": 0.1, "row": None, "happening": "note", "text": "Hm"}, END],
                   "ended as planned", True),
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
    assert metadata_of(place).ended == "cut"
    assert metadata_of(place, {"now"}).ended == "going"
    os.utime(place / "trace.jsonl")
    client = visit(tmp_path)
    assert "in progress" in get(client, "/runs").text
    assert "This run is still in progress" in get(client, "/runs/now").text


def test_what_takes_too_long_is_ended_and_the_next_is_answered(tmp_path: Path, queries: QueryWorker) -> None:
    place = write_run(tmp_path, "x", HEADER, EVENT, END)
    with pytest.raises(SheetsError, match="did not end"):
        QueryWorker(within=0.0).course(place, "en")
    assert queries.course(place, "en")["count"] == 1
    (place / "trace.jsonl").write_bytes(b"\xff\xfe")
    with pytest.raises(SheetsError, match="not the recording"):
        queries.course(place, "en")
    assert queries.pid is not None
    killed(queries.pid)
    write_run(tmp_path, "y", HEADER, EVENT, END)
    assert queries.course(tmp_path / "runs" / "y", "en")["count"] == 1


def test_who_comes_when_many_wait_is_told_and_waits_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(query_worker, "MOST", 1)
    place = write_run(tmp_path, "good", HEADER, EVENT, END)
    queries, refused = QueryWorker(), list[SheetsError]()

    def one_more_meanwhile(*link: object) -> bool:
        with pytest.raises(SheetsError, match="at once") as told:
            queries.course(place, "en")
        refused.append(told.value)
        return ready(*link)  # type: ignore[arg-type]

    monkeypatch.setattr(worker_process, "ready", one_more_meanwhile)
    assert queries.course(place, "en")["count"] == 1 and refused
    monkeypatch.setattr(worker_process, "ready", ready)
    assert queries.course(place, "en")["count"] == 1
    queries.close()


def test_what_the_process_keeps_for_a_moment_goes_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch = tmp_path / "tmp"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    queries = QueryWorker()
    queries.course(write_run(tmp_path, "good", HEADER, END), "en")
    (place,) = scratch.iterdir()
    (place / "half a table").write_text("x", encoding="utf-8")
    queries.close()
    assert not list(scratch.iterdir())


def test_a_full_disk_is_told_as_such(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    write_run(tmp_path, "good", HEADER, END)
    client = visit(tmp_path)
    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    answer = get(client, "/runs/good/everything.zip")
    assert answer.status_code == 507 and "Make room" in answer.text and "fault" not in answer.text


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
