"""The password of `serve --lan`: how it is made, asked for and kept."""

from __future__ import annotations

import http.client
import os
import re
import select
import subprocess
import sys
import urllib.parse
from collections.abc import Iterator
from pathlib import Path

import forked
import pytest
from browser import GOOD
from click.testing import CliRunner

from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError
from rrp_sheets.web.password import Password, invent

WORDS = "green otter lamp"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


# ---- the password itself ----


@pytest.mark.slow
def test_a_password_is_kept_as_a_hash_only() -> None:
    password = Password(WORDS)
    assert password.fits(WORDS) and not any(password.fits(t) for t in ("", WORDS + " ", WORDS.upper(), "x" * 100_000))
    assert WORDS not in repr(vars(password)) and Password(WORDS)._hash != password._hash
    assert Password("cafe\u0301 olé").fits("caf\u00e9 olé")
    for text in ("", "1234567", "x" * 201):
        with pytest.raises(SheetsError, match="at least 8"):
            Password(text)
    made = {invent() for _ in range(50)}
    assert len(made) == 50 and all(re.fullmatch(r"[a-z]+(-[a-z]+){3}", text) for text in made)


# ---- the command ----

PROGRAM = (
    "import os\n"
    "if os.isatty(0):  # make it the terminal of this session, which is where hidden texts are asked for\n"
    "    os.close(os.open(os.ttyname(0), os.O_RDWR))\n"
    "import rrp_sheets.cli.serve as serve\n"
    "serve._EVERYWHERE = ('127.0.0.1', '::1')  # the tests open nothing to the network\n"
    "from rrp_sheets.cli.main import main\nmain()\n"
)


@pytest.fixture
def started(folder: Path) -> Iterator[object]:
    """Starts the real command; all are ended with the test."""
    running: list[subprocess.Popen[str]] = []

    def start(
        *options: str, stdin: int = subprocess.DEVNULL, terminal: bool = False, **environ: str
    ) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", PROGRAM, "serve", str(folder), "--no-browser", *options]
        both = {"stdin": stdin, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "start_new_session": terminal}
        running.append(forked.Forked(command, text=True, env={**os.environ, **environ}, **both))
        return running[-1]

    yield start
    for process in running:
        process.kill()
        process.communicate()


def said(process: subprocess.Popen[str]) -> str:
    """Text that is printed until the server runs."""
    assert process.stdout
    lines = []
    for line in process.stdout:
        lines.append(line)
        if "Ctrl-C ends it" in line:
            break
    return "".join(lines)


def test_the_command_makes_a_password_and_tells_what_to_do(started) -> None:  # type: ignore[no-untyped-def]
    text = said(started("--lan"))
    made = re.search(r"shown only now: (\S+)", text)
    port = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=", text)
    assert made and port and "not encrypted" in text and "people you trust" in text
    home = f"127.0.0.1:{port[1]}"
    for password, code in (("not this one", 403), (made[1], 303)):
        line = http.client.HTTPConnection(home, timeout=300)
        body = urllib.parse.urlencode({"name": "Anna", "password": password})
        headers = {"Origin": f"http://{home}", "Content-Type": "application/x-www-form-urlencoded"}
        line.request("POST", "/login", body, headers)
        assert line.getresponse().status == code
        line.close()


def test_the_password_may_be_in_a_file(started, tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    secret = tmp_path / "secret"
    secret.write_text(f"{WORDS}\nmore\n", encoding="utf-8")
    secret.chmod(0o644)
    process = started("--lan", RRP_SHEETS_PASSWORD_FILE=str(secret))
    text = said(process)
    assert "Everyone needs your password" in text and WORDS not in text
    process.kill()
    assert os.name != "posix" or "chmod 600" in process.communicate()[1]
    for name, content, why in (
        ("empty", "\n", "is empty"),
        ("short", "abc", "at least 8"),
        ("none", None, "cannot be"),
    ):
        if content is not None:
            (tmp_path / name).write_text(content, encoding="utf-8")
        monkeypatch.setenv("RRP_SHEETS_PASSWORD_FILE", str(tmp_path / name))
        refused = CliRunner().invoke(group, ["serve", str(tmp_path), "--lan"]).exception
        assert isinstance(refused, SheetsError) and why in refused.message


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of Unix")
def test_the_password_is_asked_for_twice_and_hidden(started) -> None:  # type: ignore[no-untyped-def]
    import pty

    ours, theirs = pty.openpty()
    process = started("--lan", stdin=theirs, terminal=True)
    shown = ""
    for typed in ("short", WORDS, "another one", WORDS, WORDS):
        asked = ""
        while not asked.endswith(": "):
            assert select.select([ours], [], [], 300)[0], shown + asked
            asked += os.read(ours, 1000).decode()
        shown += asked
        os.write(ours, f"{typed}\n".encode())
    assert "Everyone needs your password" in said(process)
    process.kill()
    told = process.communicate()[1]
    os.close(ours)
    os.close(theirs)
    assert shown.count("A password for everyone") == 3 and shown.count("The password again") == 2
    assert "at least 8 characters" in told and "passwords are different" in told and WORDS not in shown + told


def test_the_password_cannot_be_on_the_command_line(started) -> None:  # type: ignore[no-untyped-def]
    process = started("--lan", "--password", WORDS)
    assert "No such option" in process.communicate(timeout=300)[1] and process.returncode == 2
