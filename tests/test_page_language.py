"""Language of pages: each reader's own, in what a page is made of and in what it is sent; kept when it is chosen."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from browser import GOOD, HEADER, HOME, TOKEN, book, checked, get, let_in
from flask.testing import FlaskClient
from playwright.sync_api import Browser, expect
from recorded import END, EVENT, write_run
from recorded import HEADER as RECORDED
from werkzeug.test import TestResponse

from rrp_sheets.model.run_files import RecordedAction, RecordedNotice
from rrp_sheets.recording.messages import as_message
from rrp_sheets.recording.timeline import build_timeline
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.texts import LazyMessage, translate
from rrp_sheets.web.app import create_app
from rrp_sheets.web.workbook_session import OpenWorkbooks
from rrp_sheets.workbook.files import make_workbook

JAPANESE = re.compile("[\u3040-\u30ff\u4e00-\u9fff]")
WRONG = "## Tracking\n" + HEADER + "| Nothing | map | x | Y | | |\n"


@pytest.fixture
def client(tmp_path: Path) -> FlaskClient:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    (tmp_path / "wrong.md").write_text(WRONG, encoding="utf-8")
    return let_in(create_app(tmp_path, TOKEN))


def in_japanese(client: FlaskClient, address: str) -> str:
    return get(client, address, Accept_Language="ja").text


def choose(client: FlaskClient, form: dict[str, str]) -> TestResponse:
    """Send a form as a browser does without a script."""
    return client.post("/language", data=form, base_url=HOME, headers={"Origin": HOME})


# ---- the choice
def test_a_choice_is_kept_and_leads_back_to_the_page(client: FlaskClient) -> None:
    page = get(client, book("good.md")).text
    assert '<html lang="en">' in page and '<button class="button small plain" name="language" value="ja"' in page
    answer = choose(client, {"language": "ja", "next": book("good.md")})  # fmt: skip
    assert answer.status_code == 303 and answer.headers["Location"] == book("good.md")
    page = get(client, book("good.md")).text
    assert '<html lang="ja">' in page and 'name="language" value="en" lang="en">English<' in page
    assert '<html lang="ja">' in get(client, "/", Accept_Language="en").text, "the choice stands above the browser's"


@pytest.mark.parametrize(
    "place", ["//evil.example/", "https://evil.example/", "/\\evil.example", "javascript:alert(1)"]
)
def test_a_choice_leads_to_no_other_site(client: FlaskClient, place: str) -> None:
    answer = choose(client, {"language": "ja", "next": place})
    assert answer.status_code == 303 and answer.headers["Location"] == "/"


def test_a_language_that_there_is_not_changes_nothing(client: FlaskClient) -> None:
    answer = choose(client, {"language": "../xx", "next": "/"})
    assert answer.status_code == 303 and "Set-Cookie" not in answer.headers
    assert '<html lang="en">' in get(client, "/").text


# ---- what a page is made of
def test_rows_panels_and_diagrams_are_in_the_language_of_the_page(client: FlaskClient) -> None:
    checked(client, book("wrong.md"))
    page = in_japanese(client, book("wrong.md"))
    (finding,) = re.findall(r'<div class="mend is-error"[^>]*>(.*?)</div>', page)[:1]
    assert "エラー" in finding and "Error" not in finding and JAPANESE.search(finding)
    checked(client, book("good.md"))
    good = in_japanese(client, book("good.md"))
    assert translate(LazyMessage("Row {row} is on", row=2), "ja") in good
    sentences = re.findall(r'<ol class="row-words"[^>]*>(.*?)</ol>', good, re.DOTALL)
    assert sentences and all(JAPANESE.search(sentence) for sentence in sentences)
    assert all(JAPANESE.search(words) for words in re.findall(r"<desc[^>]*>(.*?)</desc>", good))


def test_answers_are_in_the_language_of_the_page(client: FlaskClient) -> None:
    def answer(language: str) -> str:
        found = client.post("/book/good.md/run/pause", json={}, base_url=HOME,
                            headers={"X-RRP": "grid", "Origin": HOME, "Accept-Language": language})  # fmt: skip
        return str(found.get_json()["message"])

    assert answer("en") == "No run of this workbook is in progress." and JAPANESE.search(answer("ja"))


def test_pages_for_errors_are_in_the_language_of_the_reader(client: FlaskClient) -> None:
    assert "ワークブック" in in_japanese(client, "/nothing")
    assert JAPANESE.search(in_japanese(client, "/runs/pair"))


def test_words_that_are_suggested_are_in_the_language_of_the_page(client: FlaskClient) -> None:
    checked(client, book("good.md"))
    words = json.loads(in_japanese(client, book("good.md") + "/vocabulary"))
    assert any(JAPANESE.search(word["help"]) for word in words["expects"])
    fields = [field for record in words["records"].values() for field in record["fields"] if field["help"]]
    assert fields and all(JAPANESE.search(field["help"]) for field in fields)
    other = json.loads(get(client, book("good.md") + "/vocabulary").text)
    assert [word["text"] for word in other["expects"]] == [word["text"] for word in words["expects"]]
    assert not any(JAPANESE.search(word["help"]) for word in other["expects"])


# ---- what a page is sent
def test_each_page_is_told_in_its_own_language(tmp_path: Path) -> None:
    rows = [
        ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"],
        ["Red ball", "map", "redBall.x", "X"],
    ]
    make_workbook({"T": rows}, tmp_path / "b.xlsx")
    session = OpenWorkbooks(tmp_path, CheckWorker()).session(tmp_path / "b.xlsx")
    session.languages |= {"ja"}
    english, japanese = session.join("a.1", "Aya"), session.join("b.1", "Ben", language="ja")
    assert not session.lock("c.1", "Cem", ("T", session.document.grids["T"].rows[0], 5))
    told = ["".join(page.messages) for page in (english, japanese)]
    assert "Cem is editing" in told[0] and not JAPANESE.search(told[0])
    assert "Cem" in told[1] and "is editing" not in told[1] and JAPANESE.search(told[1])
    session.tell_live([("log", {"lines": [{"text": LazyMessage("Paused.")}, {"text": "Paused."}]})])
    shown = [json.loads(page.lives[-1].partition("data: ")[2])["lines"] for page in (english, japanese)]
    assert [line["text"] for line in shown[0]] == ["Paused.", "Paused."]
    assert [line["text"] for line in shown[1]] == [translate(LazyMessage("Paused."), "ja"), "Paused."], (
        "a user's text stays"
    )


# ---- recordings, which have their messages in English
@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("Scene row 3 never happened: its event never came.", {"row": "3"}),
        ("Red ball is placed at 0.50, 0.10, 0.42 m.", {"thing": "Red ball", "place": "0.50, 0.10, 0.42"}),
        ("Paused.", {}),
    ],
)
def test_a_recorded_message_is_known_again(text: str, places: dict[str, str]) -> None:
    found = as_message(text)
    assert isinstance(found, LazyMessage) and found == text and dict(found.places) == places
    assert JAPANESE.search(translate(found, "ja"))


@pytest.mark.parametrize("text", ["Kai laughs", "", "{thing}", "x" * 10_000, "}{", "Yes"])
def test_texts_of_users_stay_as_they_are(text: str) -> None:
    assert as_message(text) is text


def test_what_people_wrote_is_never_translated(tmp_path: Path) -> None:
    mark = RecordedAction(0, "", "", "mark", "Paused.", "Aya", 0.0).entry()
    place = write_run(tmp_path, "one", RECORDED, mark, END)
    assert [type(line["text"]) for line in build_timeline(place)["lines"]] == [str]


def test_the_page_of_a_recording_is_in_the_language_of_its_reader(client: FlaskClient, tmp_path: Path) -> None:
    text = "Scene row 3 never happened: its event never came."
    write_run(tmp_path, "one", RECORDED, EVENT, RecordedNotice(0, "", "Scene!3", "note", text, "").entry(), END)
    english, japanese = get(client, "/runs/one").text, in_japanese(client, "/runs/one")
    assert "row 3 never happened" in english and "never happened" not in japanese


# ---- in a browser
BOOKS = {
    "a.xlsx": {
        "T": [
            ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"],
            ["Red ball", "map", "redBall.x", "X"],
        ]
    }
}


def test_the_language_is_changed_by_a_button_and_other_tabs_follow(browser: Browser, url: str) -> None:
    from chromium import let_in as let_browser_in

    context = browser.new_context(base_url=url, locale="en")
    let_browser_in(context, url)
    first, other = context.new_page(), context.new_page()
    for page in (first, other):
        page.goto("/book/a.xlsx")
        expect(page.locator("html")).to_have_attribute("lang", "en")
    first.click("text=日本語")
    expect(first.locator("html")).to_have_attribute("lang", "ja")
    expect(first.locator("#run-phase")).to_have_text(translate(LazyMessage("No run"), "ja"))
    other.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    expect(other.locator("html")).to_have_attribute("lang", "ja")
    first.click("text=English")
    expect(first.locator("html")).to_have_attribute("lang", "en")
    context.close()
