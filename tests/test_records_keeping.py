"""Runs in the browser: exported, side by side, deleted; the requests, and once by hand."""

from __future__ import annotations

import csv
import html
import io
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from browser import HOME, get, visit
from chromium import PAGES, violations
from flask.testing import FlaskClient
from playwright.sync_api import expect
from recorded import END, EVENT, HEADER, HOSTILE, write_run
from test_export import film
from werkzeug.test import TestResponse

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.recording import exporting
from rrp_sheets.recording.exporting import ExportKind
from rrp_sheets.web.run_store import made

OTHER = HEADER | {"participant": "P-02", "workbook": "1" * 64, "condition": "Warm"}
OURS = {"X-RRP": "grid", "Origin": HOME}


def numbers(first: float, count: int) -> list[dict[str, Any]]:
    return [EVENT | {"t": first + n / 10, "value": n + first} for n in range(count)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("kept")
    write_run(made, "1-a", HEADER, *numbers(0.5, 40), END)
    write_run(made, "2-b", OTHER, *numbers(1.0, 30), {"t": 2.0, "row": "T!3", "error": "No.", "inputs": []}, END)
    film(made / "runs" / "2-b", 5)
    for name in ("3-c", "4-d"):
        write_run(made, name, HEADER | {"participant": "P-03"}, EVENT, END)
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> FlaskClient:
    return visit(folder)


def send(client: FlaskClient, **form: Any) -> TestResponse:
    return client.post("/runs/delete/now", base_url=HOME, headers=OURS, data=form)


# ---- exports ----


def test_pictures_and_tables_are_made_when_they_are_asked_for(client: FlaskClient) -> None:
    for name, kind, begins in (
        ("plots.svg", "image/svg+xml", b"<svg"), ("plots.pdf", "application/pdf", b"%PDF"), ("plots.png", "image/png", b"\x89PNG"),
    ):  # fmt: skip
        answer = get(client, f"/runs/2-b/{name}?take=1")
        assert (answer.status_code, answer.mimetype) == (200, kind) and answer.data.startswith(begins)
        assert f"filename=2-b-{name}" in answer.headers["Content-Disposition"]
        assert b"1" * 64 in answer.data or name == "plots.pdf"
    answer = get(client, "/runs/table.csv?run=1-a&run=2-b&run=1-a")
    rows = list(csv.DictReader(io.StringIO(answer.data.decode("utf-8-sig"))))
    assert len(rows) == 71 and {r["run"] for r in rows} == {"1-a", "2-b"}
    assert get(client, "/runs/table.xlsx?run=1-a").data.startswith(b"PK")
    assert "No run is chosen" in get(client, "/runs/table.xlsx").text
    for address in ("/runs/none/plots.svg", "/runs/2-b/plots.doc"):
        assert get(client, address).status_code == 404
    assert "There is no run “../x” here" in get(client, "/runs/table.csv?run=../x").text
    assert get(client, "/runs/2-b/contact.png").status_code == 404


def test_a_further_kind_of_export_is_offered(client: FlaskClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def offered() -> list[tuple[str, str]]:
        pages = get(client, "/runs/1-a").text + get(client, "/runs").text
        return re.findall(r'<a data-made href="(/runs/1-a/(?!everything)[^"]*)"|formaction="(/runs/table[^"]*)"', pages)

    before = offered()
    assert ["".join(one) for one in before if "trace" in one[0] or "plots" in one[0] or one[1]][:5] == [
        "/runs/1-a/trace.csv", "/runs/1-a/plots.pdf?take=1", "/runs/1-a/plots.svg?take=1",
        "/runs/table.xlsx", "/runs/table.csv",
    ]  # fmt: skip
    names = ExportKind("names", "a list", {".lst": "text/plain"}, lambda *_: [], links={".lst": "their names"})
    monkeypatch.setattr(exporting, "EXPORTS", (*exporting.EXPORTS, names))
    assert [one for one in offered() if one not in before] == [("/runs/1-a/names.lst", ""), ("", "/runs/table.lst")]
    assert '<b>names.lst</b><span class="quiet">their names</span>' in get(client, "/runs/1-a").text


def test_what_cannot_be_made_for_an_answer_is_told_in_words_for_the_browser(folder: Path) -> None:
    def fails(target: Path) -> None:
        target.mkdir()  # as if there were no room
        api.export([folder / "runs" / "1-a"], target)

    with pytest.raises(SheetsError, match="There is no room for this file in") as caught:
        made("made.csv", fails)
    assert "Make room there" in caught.value.remedy and "made.csv" not in caught.value.message
    with pytest.raises(SheetsError, match="There is no run"):
        made("made.csv", lambda target: api.export([folder / "none"], target))


def test_the_marbles_that_are_shown_can_be_taken_along(client: FlaskClient) -> None:
    shown = get(client, "/runs/2-b/marbles?from=1&to=3").text
    [pdf, svg] = (html.unescape(a) for a in re.findall(r'href="(/runs/2-b/marbles\.[^"]*)"', shown))
    assert "from=1" in pdf and "to=3" in pdf
    for address, kind in ((pdf, b"%PDF"), (svg, b"<svg")):
        answer = get(client, address)
        assert answer.status_code == 200 and answer.data.startswith(kind) and b"1" * 64 in answer.data
    assert "There is nothing to draw" in get(client, "/runs/2-b/marbles.svg?from=900").text


def test_a_long_record_is_not_waited_for(client: FlaskClient, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = get(client, "/runs/2-b").text
    monkeypatch.setattr("rrp_sheets.web.views.recordings._LONG", 100)
    page = get(client, "/runs/2-b").text
    assert "data-reading" in page and "Reading it takes some seconds" in page and "What happened" not in page
    assert "/runs/2-b/trace.csv" in page and 'id="marbles"' not in page
    assert get(client, "/runs/2-b?read=1").text.replace('value="/runs/2-b?read=1"', 'value="/runs/2-b"') == whole


def test_a_file_that_has_come_is_told_by_a_cookie_of_its_own(client: FlaskClient) -> None:
    for address, word in (("/runs/1-a/trace.csv", "made-0123456789abcdef=1;"), ("/runs/1-a/plots.png", "made-0")):
        answer = get(client, f"{address}?made=0123456789abcdef")
        assert word in answer.headers["Set-Cookie"] and "SameSite=Strict" in answer.headers["Set-Cookie"]
    assert "made-" not in get(client, "/runs/1-a/trace.csv?made=a%3Bb%0d%0aX").headers.get("Set-Cookie", "")


def test_whose_it_is_is_told_where_a_run_can_be_taken_along(client: FlaskClient) -> None:
    assert "recordings of <b>P-02</b>" in get(client, "/runs/2-b").text


def test_the_page_of_a_run_leads_to_all_of_it(client: FlaskClient) -> None:
    text = get(client, "/runs/2-b").text
    for address in re.findall(r'(?:href|src)="(/runs/[^"#]+)"', text):
        assert get(client, address.replace("&amp;", "&")).status_code == 200, address
    assert "/runs/2-b/plots.pdf" in text and "contact" not in text and "/runs/delete?participant=P-02" in text


def test_the_list_by_participant(client: FlaskClient) -> None:
    text = get(client, "/runs?participant=P-03").text
    assert text.count('name="run"') == 2 and "Delete the runs of P-03" in text


# ---- two runs ----


def test_two_runs_side_by_side(client: FlaskClient) -> None:
    text = get(client, "/runs/pair?run=2-b&run=1-a").text
    found = [re.sub(r"<[^>]*>|\s+", " ", row).split() for row in re.findall(r"<tr.*?</tr>", text, re.DOTALL)]
    assert ["Tracking!Distance", "stream", "40", "30", "0:00.50", "0:01.00"] in found
    assert ["T!3:", "error", "error", "not", "in", "it", "1", "–", "0:02.00"] in found
    assert ["Participant", "P-01", "P-02"] in found and ["Condition", "Control", "Warm"] in found
    assert 'href="/compare?first=run/1-a&amp;second=run/2-b"' in text
    dashed = re.findall(r'<path d="M[^"]*" fill="none"[^>]*stroke-dasharray="4 2.5"', text)
    assert len(dashed) == 2  # the legend's, and that of the second run
    assert "Exactly the same workbook ran in both runs" in get(client, "/runs/pair?run=3-c&run=4-d").text


def test_hostile_runs_side_by_side_are_text(tmp_path: Path) -> None:
    header = HEADER | dict.fromkeys(("participant", "condition", "name", "operator", "program"), HOSTILE)
    values = [EVENT | {"stream": HOSTILE, "t": n / 10, "value": {HOSTILE: n}} for n in range(5)]
    for name in ("1-a", "2-b"):
        write_run(tmp_path, name, header, *values, {"t": 1.0, "row": HOSTILE, "error": HOSTILE}, END)
    text = get(visit(tmp_path), "/runs/pair?run=1-a&run=2-b").text
    assert "<script>alert" not in text and text.count("&lt;script&gt;alert(1)") > 10


def test_only_two_runs_that_there_are_can_be_compared(client: FlaskClient) -> None:
    for query, words in (("", "No runs chosen"), ("run=1-a", "1 run chosen"), ("run=1-a&run=1-a", "1 run chosen"),
                         ("run=1-a&run=2-b&run=3-c", "3 runs chosen"), ("run=1-a&run=x", "There is no run “x”")):  # fmt: skip
        answer = get(client, f"/runs/pair?{query}")
        assert answer.status_code == 422 and words in answer.text


# ---- deleting ----


def test_deleting_asks_for_the_code(tmp_path: Path) -> None:
    write_run(tmp_path, "1-a", HEADER | {"participant": HOSTILE}, EVENT, END)
    write_run(tmp_path, "2-b", HEADER, EVENT, END)
    client = visit(tmp_path)
    shown = get(client, "/runs/delete").text
    assert "There is no run" in shown
    page = client.get("/runs/delete", base_url=HOME, query_string={"participant": HOSTILE}).text
    assert "1 run of &lt;script&gt;" in page and "<script>alert" not in page
    for typed in ("", "delete", HOSTILE.lower()[:-1]):
        assert "was not typed; nothing was deleted" in send(client, participant=HOSTILE, typed=typed, shown="1-a").text
    assert "The list of runs has changed" in send(client, participant=HOSTILE, typed=HOSTILE, shown=["1-a", "0"]).text
    assert (tmp_path / "runs" / "1-a").is_dir()
    done = send(client, participant=HOSTILE, typed=HOSTILE, shown="1-a").text
    assert "1 run deleted" in done and "Deleted" in done
    assert [p.name for p in (tmp_path / "runs").iterdir()] == ["2-b"]
    assert "1 run deleted." in send(client, run="2-b", typed="delete", shown="2-b").text
    assert "No recordings yet" in get(client, "/runs").text


def test_a_run_that_was_deleted_is_no_longer_what_the_run_panel_shows(tmp_path: Path) -> None:
    for name in ("1-a", "2-b"):
        write_run(tmp_path, name, HEADER, EVENT, END)
    client = visit(tmp_path)
    run_manager = client.application.extensions["services"].run_manager
    last = run_manager.run = SimpleNamespace(folder="1-a", session=None, is_going=False)
    assert "1 run deleted" in send(client, run="2-b", typed="delete", shown="2-b").text and run_manager.run is last
    assert "1 run deleted" in send(client, run="1-a", typed="delete", shown="1-a").text and run_manager.run is None


def test_a_run_that_goes_on_is_not_deleted(tmp_path: Path) -> None:
    write_run(tmp_path, "1-a", HEADER, EVENT)
    client = visit(tmp_path)
    run_manager = client.application.extensions["services"].run_manager
    run_manager.run = SimpleNamespace(folder="1-a", session=None, is_going=True)
    answer = send(client, participant="P-01", typed="P-01", shown="1-a")
    assert answer.status_code == 200 and "1-a is still in progress" in answer.text and "To the runs" in answer.text
    assert (tmp_path / "runs" / "1-a" / "trace.jsonl").is_file()


def test_runs_in_folders_below_go_when_they_are_ticked(tmp_path: Path) -> None:
    for place, name in ((tmp_path, "1-a"), (tmp_path / "group <B>", "2-b"), (tmp_path / "other", "3-c")):
        write_run(place, name, HEADER, EVENT, END)
    client = visit(tmp_path)
    page = get(client, "/runs/delete?participant=P-01").text
    assert "<b>group &lt;B&gt;</b>" in page and "1 run of good.md, 2 November 2026" in page and " checked" not in page
    shown = re.findall(r'name="shown" value="([^"]*)"', page)
    assert shown == ["1-a", "group &lt;B&gt;/2-b", "other/3-c"]
    shown[1] = "group <B>/2-b"
    refused = send(client, participant="P-01", typed="x", shown=shown, below="other").text
    assert 'value="other" checked' in refused and 'value="group &lt;B&gt;">' in refused
    done = send(client, participant="P-01", typed="P-01", shown=shown, below="group <B>").text
    assert "2 runs deleted of P-01." in done and "The runs of P-01 in “other”." in done
    assert [p.name for p in tmp_path.glob("*/runs/*")] == ["3-c"] and not (tmp_path / "runs" / "1-a").exists()
    only = get(client, "/runs/delete?participant=P-01").text
    assert "Delete what is ticked" in only
    assert "../x" not in send(client, participant="P-01", typed="P-01", shown="other/3-c", below="../x").text


# ---- by hand ----


@pytest.mark.slow
def test_by_hand(browser: Any, url: str, folder: Path) -> None:
    page = PAGES.take(browser, url, base_url=url)
    page.goto("/runs")
    for row in page.locator("tr", has_text="P-0").all()[-2:]:
        row.get_by_role("checkbox").check()
    assert violations(page) == []
    page.get_by_role("button", name="Compare two").click()
    expect(page.get_by_role("heading", name="Values of both runs over time, in the same plots")).to_be_visible()
    assert violations(page) == []
    page.goto("/runs?participant=P-03")
    page.get_by_role("link", name="Delete the runs of P-03").click()
    assert violations(page) == []
    page.get_by_label("To delete, type").fill("P-03")
    page.get_by_role("button", name="Delete 2 runs").click()
    expect(page.get_by_role("status").first).to_have_text("2 runs deleted of P-03.")
    assert sorted(p.name for p in (folder / "runs").iterdir()) == ["1-a", "2-b"]
    assert page.problems == []
    PAGES.put_back(page)
