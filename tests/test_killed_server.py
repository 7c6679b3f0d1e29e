"""A server that is killed at any moment of editing: what it had acknowledged is there when it comes back."""

from __future__ import annotations

import http.client
import json
import random
import re
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rrp_sheets.workbook.editing import read_sheets
from rrp_sheets.workbook.maker import make_workbook

ROWS = 30
HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
NOTES = 6


class Served:
    """A server in a process of its own, and a client of it."""

    def __init__(self, folder: Path) -> None:
        command = [str(Path(sys.executable).with_name("rrp-sheets")), "serve", str(folder), "--no-browser"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout
        line = next(line for line in self.process.stdout if "http://" in line).strip()
        self.home = line.split("/?")[0]
        jar = urllib.request.HTTPCookieProcessor()
        self._opener = urllib.request.build_opener(jar)
        self._opener.open(line, timeout=30).read()
        page = self._opener.open(f"{self.home}/book/b.xlsx", timeout=30).read().decode()
        self.rows = re.findall(r'<tr role="row" id="([^"]+)"', page)

    def put(self, row: int, text: str) -> bool:
        """Change a note; whether the server has acknowledged it."""
        cells = [{"row": self.rows[row], "column": NOTES, "text": text, "was": None}]
        body = json.dumps({"sheet": "T", "client": "c", "name": "n", "tag": "t", "cells": cells}).encode()
        headers = {"X-RRP": "grid", "Origin": self.home, "Content-Type": "application/json"}
        request = urllib.request.Request(f"{self.home}/book/b.xlsx/cells", body, headers)
        answer = json.loads(self._opener.open(request, timeout=30).read())
        return "rows" in answer


@contextmanager
def served(folder: Path) -> Iterator[Served]:
    server = Served(folder)
    try:
        yield server
    finally:
        server.process.kill()
        server.process.wait()
        assert server.process.stdout
        server.process.stdout.close()


def kill_at_random(folder: Path, chance: random.Random, expected: dict[int, list[str]], round_: int) -> None:
    """Two people edit until the server is killed; `expected`: by row, what may stand there."""
    with served(folder) as server:

        def edit(first: int) -> None:
            for count in range(10_000):
                row = first + 2 * (count % (ROWS // 2))
                text = f"{round_} {count}"
                expected[row].append(text)  # asked for: it may be there
                try:
                    if server.put(row, text):
                        del expected[row][:-1]  # acknowledged: it must be there
                except (OSError, http.client.HTTPException):
                    return

        people = [threading.Thread(target=edit, args=(n,)) for n in (0, 1)]
        for one in people:
            one.start()
        threading.Event().wait(chance.uniform(0.05, 1.2))
        server.process.kill()
        for one in people:
            one.join()


def check_killing(folder: Path, times: int, seed: int) -> None:
    path = make_workbook({"T": [HEADER, *[["", "", "", "", "", "start"]] * ROWS]}, folder / "b.xlsx")
    expected = {row: ["start"] for row in range(ROWS)}
    chance = random.Random(seed)
    for round_ in range(times):
        kill_at_random(folder, chance, expected, round_)
        with served(folder):  # comes back, and stores what it had acknowledged
            sheet = read_sheets(path)[0]
            for row, allowed in expected.items():
                text = sheet.cells[row + 2, NOTES].typed
                assert text in allowed, (round_, row, text, allowed)
                expected[row] = [text]
            assert sorted(p.name for p in folder.iterdir()) == [".rrp-sheets", "b.xlsx"]
    assert any(texts != ["start"] for texts in expected.values())


def test_a_server_killed_five_times_loses_nothing(tmp_path: Path) -> None:
    check_killing(tmp_path, 5, seed=1)


@pytest.mark.soak
def test_a_server_killed_fifty_times_loses_nothing(tmp_path: Path) -> None:
    check_killing(tmp_path, 50, seed=2)
