"""The way to the tutorial: by the command, and from the shelf; a second time one goes on, or begins anew."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import forked
import pytest
from browser import get, post, visit
from click.testing import CliRunner

from rrp_sheets.cli.main import group
from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled

FRESH = bundled("templates", "workbooks", "tutorial.xlsx").read_bytes()
BEGIN = "Start the tutorial"


@pytest.mark.slow
def test_the_shelf_leads_to_it(tmp_path: Path) -> None:
    client = visit(tmp_path)
    assert BEGIN in get(client, "/").text
    made = post(client, "/shelf/tutorial")
    assert made.headers["HX-Redirect"] == "/book/tutorial.xlsx" and "Continue tutorial.xlsx" in made.text
    path = tmp_path / "tutorial.xlsx"
    assert path.read_bytes() == FRESH
    path.write_bytes(bundled("workbooks", "greeter.xlsx").read_bytes())
    anew = post(client, "/shelf/tutorial")
    assert anew.headers["HX-Redirect"] == "/book/tutorial%20(2).xlsx" and "Continue tutorial (2).xlsx" in anew.text
    assert path.read_bytes() != FRESH and (tmp_path / "tutorial (2).xlsx").read_bytes() == FRESH
    os.utime(path)
    assert "Continue tutorial.xlsx" in post(client, "/shelf/copy", book="tutorial (2).xlsx").text


def test_a_folder_in_which_nothing_can_be_written_is_told(tmp_path: Path) -> None:
    client = visit(tmp_path)
    was = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000, was[1]))  # no file may become longer, as on a full disk
    try:
        told = post(client, "/shelf/tutorial").text
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, was)
    assert "is-error" in told and not list(tmp_path.glob("*.xlsx"))


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    refused = CliRunner().invoke(group, ["tutorial", str(tmp_path / "no")]).exception
    assert isinstance(refused, SheetsError) and "There is no folder" in refused.message


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent as a signal")
def test_the_command_makes_it_and_serves_it(tmp_path: Path) -> None:
    folder = tmp_path / "<日本 語>"
    folder.mkdir()
    command = [*forked.COMMAND, "tutorial", str(folder), "--no-browser"]
    process = forked.Forked(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("Created ")
        address = next(found[0] for line in process.stdout if (found := re.search(r"http://\S+", line)))
        assert "/book/tutorial.xlsx?token=" in address
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        with opener.open(address, timeout=300) as answer:
            assert "Lesson 1: Say hello" in answer.read().decode()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
    assert process.returncode == 0 and (folder / "tutorial.xlsx").read_bytes() == FRESH
