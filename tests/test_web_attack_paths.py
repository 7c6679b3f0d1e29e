"""Names that would lead elsewhere, in every part of every address and every name that is sent."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import pytest
from attack import BOOK, FORMS, JSON, OPENED, OURS, RUN, SECRET, SHEET, SOME, body, contents, enter, make_folder, ways
from browser import HOME, TOKEN
from flask import Flask

from rrp_sheets.web.app import create_app

TRICKS = [
    "..", ".", "...", "../secret.md", "..%2fsecret.md", "..%2Fsecret.md", "..%5csecret.md", "%2e%2e%2fsecret.md",
    "%2e%2e", "..%252fsecret.md", "....//secret.md", "..;/secret.md", "%2fetc%2fpasswd", "/etc/passwd",
    "//etc/passwd", "C:%5cWindows%5cwin.ini", "%00", "good.xlsx%00.md", "good.md%00", "secret.md", "%5c%5chost%5cshare",
    ".rrp-sheets", ".rrp-sheets%2fjournal.sqlite", "journal.sqlite", "archive", "runs", "a" * 300, "%ff%fe", "%ed%b2%80",
    "%f0%9f%91%bf", "%e2%80%ae", "%0d%0aSet-Cookie:x=1", "%0a", "%7b%7b7*7%7d%7d", "%3Cscript%3E", "%25s%25n", "~root",
    "con", "nul.xlsx", "good.xlsx.", "good.xlsx%20", "GOOD.XLSX", "link.md", "-rf", "*", "?", "%23", "1e9", "-1",
    "99999999999999999999", "none.wav", "trace.jsonl%2f..%2f..%2f..%2fsecret.md",
]  # fmt: skip
PLAIN = [
    "../secret.md", "..", "..\\secret.md", "/etc/passwd", "secret.md", ".rrp-sheets/journal.sqlite", "\0", "a\0b", "",
    "x" * 5_000, "link.md", "\ud800", "\u202e", "good.xlsx\n", "runs/" + RUN, "~", "C:\\x",
]  # fmt: skip


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("paths")
    folder = make_folder(place)
    if sys.platform != "win32":
        (folder / "link.md").symlink_to(place / "secret.md")
        outside = place / "elsewhere"
        outside.mkdir()
        (outside / "trace.jsonl").write_text(SECRET, encoding="utf-8")
        (folder / "runs" / "20260102-000000-link").symlink_to(outside)
        (folder / "runs" / RUN / "film.gif").symlink_to(place / "secret.md")
    return place


@pytest.fixture(scope="module")
def app(place: Path) -> Flask:
    return create_app(place / "inside", TOKEN)


@pytest.fixture(scope="module")
def client(app: Flask) -> Any:
    return enter(app)


@SOME
def test_no_part_of_an_address_leads_out_of_the_folder(app: Flask, client: Any, place: Path, every: int) -> None:
    before = contents(place)
    tried, rules = 0, set()
    for number, way in enumerate(ways(app)):
        first = way.rule not in rules  # what opens files is the same for all actions of a route
        rules.add(way.rule)
        for part in way.names:
            for trick in TRICKS if part in OPENED and first else TRICKS[number % every :: every]:
                sent = {**body(way), "method": "POST"} if way.post else {}
                answer = client.open(way.address(**{part: trick}), base_url=HOME, headers=OURS, **sent)
                place_of = (way.key, part, trick)
                if answer.status_code == 308:  # two slashes; the same place with one
                    assert answer.headers["Location"].startswith(("/", HOME)), place_of
                    assert not answer.headers["Location"].startswith("//"), place_of
                else:
                    assert answer.status_code in (400, 404, 405, 409, 422), (place_of, answer.status_code)
                assert SECRET not in answer.text and "root:" not in answer.text, place_of
                assert "<script>" not in answer.text and "x=1" not in str(answer.headers), place_of
                answer.close()
                tried += 1
    assert tried > 3000 / every
    assert contents(place) == before


def test_links_that_leave_the_folder_are_not_followed(client: Any) -> None:
    for address in ("/", "/runs", f"/runs/{RUN}", "/runs/20260102-000000-link", "/runs/20260102-000000-link/file/trace.jsonl",
                    "/runs/20260102-000000-link/trace.csv", "/runs/20260102-000000-link/everything.zip",
                    f"/runs/{RUN}/file/film.gif", "/book/link.md", "/book/link.md/file", "/book/link.md/print"):  # fmt: skip
        answer = client.get(address, base_url=HOME)
        assert answer.status_code < 500 and SECRET.encode() not in answer.data, address


@pytest.mark.slow
def test_no_name_that_is_sent_leads_out_of_the_folder(client: Any, place: Path) -> None:
    before = {n: c for n, c in contents(place).items() if not n.startswith("inside")}
    for key in FORMS:
        endpoint, _, action = key.partition(" ")
        if endpoint == "help.open_example":  # its name is one of a new workbook: tests/test_help_site.py
            continue
        address = f"/shelf/{action}" if endpoint == "workbooks.act" else f"/book/{BOOK}/versions/{action}"
        for field in ("book", "name", "template", "title", "version"):
            if field not in FORMS[key]:
                continue
            for trick in PLAIN:
                form = {**FORMS[key], field: trick.encode("utf-8", "surrogatepass")}
                answer = client.post(
                    address, base_url=HOME, headers=OURS, data=form, content_type="multipart/form-data"
                )
                assert answer.status_code in (200, 422), (key, field, trick, answer.status_code)
                assert SECRET not in answer.text, (key, field, trick)
    assert {n: c for n, c in contents(place).items() if not n.startswith("inside")} == before
    assert sorted(p.name for p in place.iterdir()) == ["elsewhere", "inside", "secret.md"]


@pytest.mark.slow
def test_an_upload_is_stored_under_its_last_name_only(client: Any, place: Path) -> None:
    content = (next((place / "inside").glob("*.xlsx"))).read_bytes()
    for name, stored in (
        ("../../up1.xlsx", "up1.xlsx"), ("/tmp/up2.xlsx", "up2.xlsx"), ("..\\..\\up3.xlsx", ""), ("C:\\up4.xlsx", ""),
        (".hidden.xlsx", ""), ("~$up.xlsx", ""), ("up\0.xlsx", ""), ("up\n5.xlsx", ""), ("x" * 300 + ".xlsx", ""),
        ("up.xlsx.exe", "up.xlsx.exe.xlsx"), ("up6.xlsm", "up6.xlsm.xlsx"), ("\u202eup.xlsx", ""), ("up.html", "up.html.xlsx"),
    ):  # fmt: skip
        before = {p.name for p in (place / "inside").iterdir()}
        form = {"file": (io.BytesIO(content), name)}
        answer = client.post(
            "/shelf/upload", base_url=HOME, headers=OURS, data=form, content_type="multipart/form-data"
        )
        assert answer.status_code == 200, name
        new = {p.name for p in (place / "inside").iterdir()} - before
        assert new == ({stored} if stored else set()), (name, new)
    assert not Path("/tmp/up2.xlsx").exists()


def test_sheets_are_only_those_of_the_workbook(client: Any, app: Flask) -> None:
    for key in JSON:
        if key.startswith("sheet.change") and "sheet" in JSON[key]:
            for sheet in ("../x", "", "Nothing", SHEET.upper() + "\0"):
                sent = {**JSON[key], "sheet": sheet}
                answer = client.post(f"/book/{BOOK}/{key.split()[1]}", base_url=HOME, headers=OURS, json=sent)
                assert answer.status_code in (200, 400, 404), (key, sheet)


QUESTIONS = [
    *PLAIN, "book/../secret.md", "book/link.md", "version/1/../secret.md", "version/x/good.xlsx", "run/../..",
    "run/20260102-000000-link", "version/99999999999999999999/good.xlsx", "/", "//", "%", "-1", "1e9", "9" * 400, "[]",
]  # fmt: skip


@SOME
def test_no_question_leads_out_of_the_folder(app: Flask, client: Any, place: Path, every: int) -> None:
    source = Path(app.root_path).joinpath("web") if Path(app.root_path).name != "web" else Path(app.root_path)
    words = re.compile(r"args\.(?:get|getlist)\(\s*\"(\w+)\"|\"(\w+)\" in request\.args")
    found = {a or b for f in source.rglob("*.py") for a, b in words.findall(f.read_text(encoding="utf-8"))}
    asked = (found | {"book", "words", "first", "second"}) - {"token"}
    assert len(asked) > 10, "where questions are read from has changed"
    before = contents(place)
    for number, way in enumerate(ways(app)):
        for trick in [] if way.post or way.key == "sheet.events" else QUESTIONS[number % every :: every]:
            text = trick.encode("utf-8", "surrogatepass")
            answer = client.get(f"{way.address()}?{urlencode(dict.fromkeys(sorted(asked), text))}", base_url=HOME)
            assert answer.status_code < 500, (way.key, trick[:40])
            assert SECRET.encode() not in answer.data, (way.key, trick[:40])
            answer.close()
    assert contents(place) == before
