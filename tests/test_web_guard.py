"""Who may see the pages that `serve` shows, which files they reach, and the real command."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import GOOD, HOME, TOKEN, book, get, visit
from click.testing import CliRunner

from rrp_sheets.cli.main import group
from rrp_sheets.runs.worker import CheckWorker
from rrp_sheets.web.app import create_app
from rrp_sheets.web.library import Library


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


# ---- who may look ----


def test_the_token_becomes_a_cookie_and_leaves_the_address(folder: Path) -> None:
    client = create_app(folder, TOKEN).test_client()
    answer = client.get(f"{book('good.md')}?token={TOKEN}", base_url=HOME)
    assert (answer.status_code, answer.headers["Location"]) == (302, book("good.md"))
    cookie = answer.headers["Set-Cookie"]
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert get(client, "/").status_code == 200


@pytest.mark.parametrize("address", ["/", "/book/good.md", "/book/good.md/diagram/1.svg", "/static/style.css", "/none"])
def test_nothing_is_shown_without_the_token(folder: Path, address: str) -> None:
    client = create_app(folder, TOKEN).test_client()
    for asked in (address, f"{address}?token=wrong", f"{address}?token=", f"{address}?token=%ED%B2%80"):
        answer = get(client, asked)
        assert answer.status_code == 403
        assert "Copy the address" in answer.text and "good" not in answer.text
    assert "Set-Cookie" not in answer.headers


def test_the_token_of_the_browser_that_is_opened_is_good_once(folder: Path) -> None:
    app = create_app(folder, TOKEN, once="for-once")
    first, second = app.test_client(), app.test_client()
    assert first.get("/?token=for-once", base_url=HOME).status_code == 302 and get(first, "/").status_code == 200
    assert second.get("/?token=for-once", base_url=HOME).status_code == 403
    assert second.get("/?token=", base_url=HOME).status_code == 403


def test_a_cookie_of_another_start_is_not_enough(folder: Path) -> None:
    old = create_app(folder, "an-old-token").test_client().get("/?token=an-old-token", base_url=HOME)
    client = create_app(folder, TOKEN).test_client()
    assert get(client, "/", Cookie=old.headers["Set-Cookie"].split(";")[0]).status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "localhost.", "192.168.0.7:8000", ""])
def test_other_hosts_are_refused_and_get_no_cookie(folder: Path, host: str) -> None:
    answer = visit(folder).get(f"/?token={TOKEN}", headers={"Host": host})
    assert answer.status_code == 400
    assert "Set-Cookie" not in answer.headers


def test_localhost_is_this_computer_too(folder: Path) -> None:
    client = create_app(folder, TOKEN).test_client()
    assert client.get(f"/?token={TOKEN}", base_url="http://localhost:8000").status_code == 302


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"])
def test_what_our_own_script_does_not_ask_for_is_refused(folder: Path, method: str) -> None:
    client = visit(folder)
    assert client.open("/", method=method, base_url=HOME).status_code == 403
    assert client.open("/", method=method, base_url=HOME, headers={"X-RRP": "grid"}).status_code == 403
    headers = {"X-RRP": "grid", "Origin": HOME}
    assert client.open("/", method=method, base_url=HOME, headers=headers).status_code in (200, 405)


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Origin": HOME},
        {"Origin": "http://127.0.0.1:9999", "X-RRP": "grid"},
        {"Origin": "http://evil.example", "X-RRP": "grid"},
        {"Origin": "null", "X-RRP": "grid"},
        {"X-RRP": "grid"},
        {"Origin": HOME, "X-RRP": "grid", "Sec-Fetch-Site": "cross-site"},
    ],
)
def test_an_edit_needs_our_page(folder: Path, headers: dict[str, str]) -> None:
    before = (folder / "good.md").read_bytes()
    edit = {"client": "a", "name": "A", "tag": "1", "sheet": "Tracking",
            "cells": [{"row": "w1", "column": 3, "text": "1", "was": None}]}  # fmt: skip
    answer = visit(folder).post("/book/good.md/cells", base_url=HOME, headers=headers, json=edit)
    assert answer.status_code == 403 and (folder / "good.md").read_bytes() == before


@pytest.mark.parametrize(
    "body", ["", "[]", "{", '{"cells": 3}', '{"cells": [1]}', '{"cells": [{"row": 1}]}', '{"sheet": 7, "cells": []}']
)
def test_requests_that_make_no_sense_are_refused(folder: Path, body: str) -> None:
    headers = {"X-RRP": "grid", "Origin": HOME, "Content-Type": "application/json"}
    answer = visit(folder).post("/book/good.md/cells", base_url=HOME, headers=headers, data=body)
    assert answer.status_code == 400


@pytest.mark.parametrize(
    ("headers", "code"),
    [
        ({"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"}, 403),
        ({"Sec_Fetch_Site": "same-site", "Sec_Fetch_Mode": "cors"}, 403),  # another port of this computer
        ({"Origin": "http://127.0.0.1:9999"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": HOME}, 200),
        ({"Sec_Fetch_Site": "same-origin", "Sec_Fetch_Mode": "no-cors"}, 200),
        ({"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}, 200),  # a link that is clicked
    ],
)
def test_other_sites_pages_get_nothing(folder: Path, headers: dict[str, str], code: int) -> None:
    assert get(visit(folder), "/", **headers).status_code == code


@pytest.mark.parametrize("address", ["/", "/book/good.md", "/static/style.css", "/none", "/book/good.md/diagram/1.svg"])
def test_every_answer_bears_the_protecting_headers(folder: Path, address: str) -> None:
    headers = get(visit(folder), address).headers
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'") and "unsafe" not in policy and "script-src 'self';" in policy
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"] == "same-origin"


# ---- which files ----


@pytest.mark.parametrize(
    "name", ["../secret.md", "..", ".", "%2e%2e%2fsecret.md", "..%5csecret.md", "/etc/passwd", ".hidden.md", "a\0.md"]
)
def test_no_name_leads_out_of_the_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.md").write_text(GOOD.replace("Red ball", "Secret"), encoding="utf-8")
    inside = tmp_path / "inside"
    inside.mkdir()
    (inside / ".hidden.md").write_text(GOOD, encoding="utf-8")
    client = visit(inside)
    for address in (f"/book/{name}", book(name), f"{book(name)}/diagram/1.svg", f"/static/{name}"):
        answer = get(client, address)
        assert answer.status_code in (308, 404) and "Secret" not in answer.text


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_links_that_leave_the_folder_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "secret.md").write_text(GOOD.replace("Red ball", "Secret"), encoding="utf-8")
    inside = tmp_path / "inside"
    inside.mkdir()
    (inside / "link.md").symlink_to(tmp_path / "secret.md")
    client = visit(inside)
    assert "link.md is not a file of this folder" in get(client, "/").text
    answer = get(client, book("link.md"))
    assert answer.status_code == 422 and "Secret" not in answer.text


def test_a_folder_without_workbooks_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").touch()
    (tmp_path / "README.md").write_text("# A text\n\nNo rows.\n", encoding="utf-8")
    text = get(visit(tmp_path), "/").text
    assert "No workbooks here yet" in text and "New workbook" in text
    assert "Not workbooks, as no sheet in them is a behaviour: README.md" in text


def test_unreadable_files_are_shown_kindly(folder: Path) -> None:
    (folder / "broken.xlsx").write_bytes(b"no workbook")
    (folder / "~$good.xlsx").write_bytes(b"a lock of Excel")
    client = visit(folder)
    text = get(client, "/").text
    assert "Cannot be read" in text and "broken.xlsx" in text and "~$" not in text
    answer = get(client, book("broken.xlsx"))
    assert answer.status_code == 422 and "Try again" in answer.text and "Traceback" not in answer.text


@pytest.mark.skipif(sys.platform != "linux", reason="other systems know no such names")
def test_a_file_name_that_is_no_text(folder: Path) -> None:
    (folder / os.fsdecode(b"caf\xe9.md")).write_text(GOOD, encoding="utf-8")
    text = get(visit(folder), "/").text
    assert "caf?.md" in text and "Rename the file" in text


def test_changes_of_a_file_are_seen(folder: Path) -> None:
    client = visit(folder)
    assert "Whole day" not in get(client, book("good.md")).text
    (folder / "good.md").write_text(GOOD + "| Red ball | map | redBall.x | Whole day | | |\n", encoding="utf-8")
    assert "Whole day" in get(client, book("good.md")).text
    (folder / "good.md").unlink()
    answer = get(client, book("good.md"))
    assert answer.status_code == 404 and "Go to the shelf" in answer.text


def test_what_was_read_is_kept(folder: Path) -> None:
    with CheckWorker() as worker:
        library = Library(folder, worker)
        assert library.open("good.md") is library.open("good.md")


# ---- the command ----


@pytest.fixture
def server(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The real command, and the address it prints."""
    program = [sys.executable, "-c", "from rrp_sheets.cli.main import main; main()"]
    process = subprocess.Popen(
        [*program, "serve", str(folder), "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout
    try:
        url = next((line.strip() for line in process.stdout if "token=" in line), "")
        yield process, url
    finally:
        process.kill()
        process.communicate()


def fetch(url: str, opener: urllib.request.OpenerDirector, **headers: str) -> tuple[int, str]:
    try:
        with opener.open(urllib.request.Request(url, headers=headers), timeout=10) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read().decode()


def test_the_command_serves_this_computer_only(server: tuple[subprocess.Popen[str], str]) -> None:
    process, url = server
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{43}", url)
    home = url.split("?")[0]
    direct = urllib.request.ProxyHandler({})
    stranger = urllib.request.build_opener(direct)
    assert fetch(home, stranger)[0] == 403
    assert fetch(url, stranger, Host="evil.example")[0] == 400
    browser = urllib.request.build_opener(direct, urllib.request.HTTPCookieProcessor())
    status, text = fetch(url, browser)
    assert status == 200 and "good.md" in text
    assert fetch(f"{home}book/good.md", browser)[0] == 200
    assert fetch(f"{home}static/style.css", browser)[0] == 200
    assert fetch(f"{home}book/..%2f..%2fetc%2fpasswd", browser)[0] == 404
    if sys.platform != "win32":
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=20)
        assert (process.returncode, said) == (0, "")


def test_a_missing_folder_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(group, ["serve", str(tmp_path / "none")])
    assert result.exit_code == 1 and "There is no folder" in str(result.exception)
