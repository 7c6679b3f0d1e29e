"""A workbook that is something else meanwhile, told as such, and no fault of this program."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from attack import BOOK, OURS, body, enter, make_folder, ways
from browser import HOME, TOKEN

from rrp_sheets.web.app import create_app


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes in folders there")
@pytest.mark.parametrize("now", ["a folder", "a pipe"])
def test_a_workbook_that_is_something_else_meanwhile_is_told(tmp_path: Path, now: str) -> None:
    folder = make_folder(tmp_path)
    app = create_app(folder, TOKEN)
    client = enter(app)
    assert client.get(f"/book/{BOOK}", base_url=HOME).status_code == 200
    for way in ways(app):
        if not way.post or way.key.startswith("live."):
            continue
        _replace(folder, now)
        answer = client.post(way.address(), base_url=HOME, headers=OURS, **body(way))
        assert answer.status_code < 500, (way.key, answer.text)
        assert "Errno" not in answer.text, way.key


def _replace(folder: Path, now: str) -> None:
    path = folder / BOOK
    if path.is_dir():
        path.rmdir()
    path.unlink(missing_ok=True)
    if now == "a folder":
        path.mkdir()
    else:
        os.mkfifo(path)
