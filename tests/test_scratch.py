"""Temporary files of a server do not outlive it for long, even when it is killed."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import forked
import pytest

from rrp_sheets.web.serving import own_temp_folder
from rrp_sheets.workers.worker_process import WorkerProcess

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="nobody can tell there which folder is in use")
KILLED = """
import os, pathlib, signal
from rrp_sheets.web.serving import own_temp_folder
with own_temp_folder() as folder:
    (folder / "table.csv").write_text("P-01")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_next_server_removes_what_a_killed_one_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    forked.run([sys.executable, "-c", KILLED], env={**os.environ, "TMPDIR": str(tmp_path)}, timeout=300)
    (left,) = tmp_path.iterdir()
    assert (left / "table.csv").is_file()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    link = tmp_path / "rrp-sheets-server-link"
    (tmp_path / "other").mkdir()
    link.symlink_to(tmp_path / "other")
    for path in (left, tmp_path / "other"):
        os.utime(path, (1, 1))
    with own_temp_folder() as mine:
        assert not left.exists() and link.exists() and (tmp_path / "other").exists()
        os.utime(mine, (1, 1))
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        with own_temp_folder():  # a second server leaves the first one's alone
            assert mine.is_dir()
    assert not mine.exists() and tempfile.gettempdir() == str(tmp_path)


def test_processes_keep_it_there_too() -> None:
    with own_temp_folder() as folder:
        child = WorkerProcess()
        assert child.ask(["tempfile.gettempdir"], 60) == str(folder)
        child.close(5)
