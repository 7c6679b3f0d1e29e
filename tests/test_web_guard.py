"""Access to the pages that `serve` shows and to files, and the real command."""

from __future__ import annotations

import html
import os
import re
import select
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import forked
import pytest
from browser import GOOD, HOME, TOKEN, book, get, visit
from click.testing import CliRunner
from flask import Flask

from rrp_sheets.cli.main import group
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.web.app import create_app
from rrp_sheets.web.password import folder_secret
from rrp_sheets.web.requests import OneTimeTokens, cookie_name
from rrp_sheets.web.workbook_repository import WorkbookRepository


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


# ---- who may look ----


def opened(folder: Path) -> tuple[Flask, str]:
    """The application, and the token of a link."""
    links = OneTimeTokens()
    return create_app(folder, TOKEN, links=links), links.new()


def test_a_link_lets_one_browser_in_which_may_open_it_again(folder: Path) -> None:
    app, token = opened(folder)
    first, second = app.test_client(), app.test_client()
    for _ in range(3):  # reloaded, or clicked again
        answer = first.get(f"{book('good.md')}?token={token}", base_url=HOME)
        assert (answer.status_code, answer.headers["Location"]) == (302, book("good.md"))
    assert get(first, "/").status_code == 200
    answer = get(second, f"/?token={token}")
    assert answer.status_code == 403 and "already used" in answer.text and "press Enter" in answer.text
    assert "Set-Cookie" not in answer.headers and get(second, "/").status_code == 403


def test_the_cookie_of_a_link_is_hidden_from_scripts_and_other_sites(folder: Path) -> None:
    app, token = opened(folder)
    cookie = get(app.test_client(), f"/?token={token}").headers["Set-Cookie"]
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie and token not in cookie


def test_who_only_looks_ahead_does_not_use_a_link_up(folder: Path) -> None:
    app, token = opened(folder)
    address = f"/?token={token}"
    for headers in ({"Sec_Purpose": "prefetch;prerender"}, {"Purpose": "prefetch"}, {"X_Moz": "prefetch"}):
        answer = get(app.test_client(), address, **headers)
        assert answer.status_code == 503 and "Set-Cookie" not in answer.headers
    assert app.test_client().head(address, base_url=HOME).status_code == 403
    assert get(app.test_client(), address, Host="evil.example").status_code == 400
    assert get(app.test_client(), address).status_code == 302


def test_a_link_clicked_on_another_sites_page_is_followed_by_our_own(folder: Path) -> None:
    app, token = opened(folder)
    foreign = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
    client = app.test_client()
    answer = get(client, f"{book('good.md')}?token={token}&a=%22%3E", **foreign)
    assert answer.status_code == 200 and "Set-Cookie" not in answer.headers
    follow = html.unescape(re.search(r'url=([^"]*)"', answer.text)[1])  # type: ignore[index]
    assert follow.startswith(f"{book('good.md')}?token={token}&a=%22")
    assert get(client, follow, Sec_Fetch_Site="same-origin", Sec_Fetch_Mode="navigate").status_code == 302


@pytest.mark.parametrize("address", ["/", "/book/good.md", "/book/good.md/diagram/1.svg", "/static/style.css", "/none"])
def test_nothing_is_shown_without_a_link(folder: Path, address: str) -> None:
    app, token = opened(folder)
    client = app.test_client()
    for asked in (address, *(f"{address}?token={wrong}" for wrong in ("wrong", "", "%ED%B2%80", TOKEN, token[:-1]))):
        answer = get(client, asked)
        assert answer.status_code == 403
        assert "press Enter" in answer.text and "good" not in answer.text
    assert "Set-Cookie" not in answer.headers


def test_a_cookie_of_another_folder_is_not_enough(folder: Path) -> None:
    client = create_app(folder, TOKEN).test_client()
    assert get(client, "/", Cookie=f"{cookie_name('another')}=another").status_code == 403
    assert get(client, "/", Cookie=f"{cookie_name(TOKEN)}=another").status_code == 403


def test_links_are_used_once_also_at_the_same_moment() -> None:
    links = OneTimeTokens()
    token = links.new()
    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(links.use, [token] * 200)) == 1
    old = links.new()
    for _ in range(100):
        links.new()
    assert not links.use(old)  # nobody has used it for long


# ---- the secret that outlives a restart ----


def test_the_secret_of_a_folder_is_kept_for_its_user_alone(folder: Path, tmp_path_factory: pytest.TempPathFactory,
                                                           monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    state = tmp_path_factory.mktemp("state")
    for name in ("XDG_STATE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(name, str(state))
    secret, why_not = folder_secret(folder)
    assert why_not == "" and folder_secret(folder / ".." / folder.name)[0] == secret
    (kept,) = [path for path in state.rglob("*") if path.is_file()]
    assert not list(folder.rglob("*secret*"))  # nothing beside the workbooks
    if os.name == "posix":
        assert (kept.stat().st_mode & 0o777, kept.parent.stat().st_mode & 0o777) == (0o600, 0o700)
    (folder / "other").mkdir()
    assert folder_secret(folder / "other")[0] != secret
    renewed, _ = folder_secret(folder, renew=True)
    assert renewed != secret and folder_secret(folder)[0] == renewed
    for damaged in (b"", b"short", b"\xff" * 43, b"x" * 5_000):
        kept.write_bytes(damaged)
        fresh, _ = folder_secret(folder)
        assert len(fresh) == 43 and folder_secret(folder)[0] == fresh
    if os.name == "posix":
        kept.chmod(0o644)  # others may have read it
        assert folder_secret(folder)[0] != fresh


def test_a_secret_that_cannot_be_kept_is_told_and_the_server_works(folder: Path, tmp_path: Path,
                                                                   monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    (tmp_path / "file").write_text("in the way, also of root", encoding="utf-8")
    for name in ("XDG_STATE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / "file"))
    secret, why_not = folder_secret(folder)
    assert len(secret) == 43 and "cannot be written" in why_not


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "localhost.", "192.168.0.7:8000", ""])
def test_other_hosts_are_refused_and_get_no_cookie(folder: Path, host: str) -> None:
    app, token = opened(folder)
    answer = app.test_client().get(f"/?token={token}", headers={"Host": host})
    assert answer.status_code == 400 and visit(folder).get("/", headers={"Host": host}).status_code == 400
    assert "Set-Cookie" not in answer.headers


def test_localhost_is_this_computer_too(folder: Path) -> None:
    app, token = opened(folder)
    assert app.test_client().get(f"/?token={token}", base_url="http://localhost:8000").status_code == 302


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
    assert answer.status_code == 404 and "Go to Workbooks" in answer.text


def test_what_was_read_is_kept(folder: Path) -> None:
    with CheckWorker() as worker:
        library = WorkbookRepository(folder, worker)
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
        with opener.open(urllib.request.Request(url, headers=headers), timeout=300) as answer:
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
    assert fetch(url, stranger)[0] == 403 and fetch(url, browser)[0] == 200
    assert fetch(f"{home}book/good.md", browser)[0] == 200
    assert fetch(f"{home}static/style.css", browser)[0] == 200
    assert fetch(f"{home}book/..%2f..%2fetc%2fpasswd", browser)[0] == 404
    if sys.platform != "win32":
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=300)
        assert (process.returncode, said) == (0, "")


def test_a_missing_folder_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(group, ["serve", str(tmp_path / "none")])
    assert result.exit_code == 1 and "There is no folder" in str(result.exception)


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of Unix")
def test_enter_prints_another_link(folder: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    command = [*forked.COMMAND, "serve", str(folder), "--no-browser"]
    process = forked.Forked(command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True)
    direct = urllib.request.ProxyHandler({})

    def next_link() -> str:
        shown = ""
        while not (found := re.search(r"http://\S+(?=\s)", shown)):
            assert select.select([ours], [], [], 300)[0], shown
            shown += os.read(ours, 1000).decode()
        return found[0]

    try:
        for _ in range(3):
            browser = urllib.request.build_opener(direct, urllib.request.HTTPCookieProcessor())
            assert fetch(next_link(), browser)[0] == 200
            os.write(ours, b"\n")
        next_link()
        process.send_signal(signal.SIGINT)
        assert process.wait(300) == 0
    finally:
        process.kill()
        process.wait()
        os.close(ours)
        os.close(theirs)
