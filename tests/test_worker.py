"""Checking in a kept process: the same findings, and one clear finding when the check itself goes wrong."""

from __future__ import annotations

import textwrap
from concurrent.futures import ThreadPoolExecutor

import pytest
from play import rows

from rrp_sheets import api
from rrp_sheets.resources import bundled
from rrp_sheets.runs.check_worker import CheckWorker

BOOKS = [bundled("workbooks", name) for name in ("simple-tracking.xlsx", "complex-tracking.xlsx")]

LIBRARY = """
import os

def hang():
    while True:
        pass

def hoard():
    kept = []
    while True:
        kept.append(bytes(50_000_000))

def provide():
    open({begun!r}, "w").close()
    {what}
    yield from ()
"""


@pytest.fixture
def wicked(tmp_path, monkeypatch):
    """Installs a package whose connectors do something wicked when a check loads them; gives a file that is there then."""

    def install(what):
        begun = tmp_path / "begun"
        about = tmp_path / "site" / "wicked-1.0.dist-info"
        about.mkdir(parents=True)
        (tmp_path / "site" / "wicked.py").write_text(textwrap.dedent(LIBRARY.format(what=what, begun=str(begun))))
        (about / "METADATA").write_text("Metadata-Version: 2.1\nName: wicked\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text("[rrp_sheets.connectors]\nwicked = wicked:provide\n")
        monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
        return begun

    return install


def test_the_worker_finds_what_a_check_here_finds(tmp_path):
    wrong = tmp_path / "wrong.md"
    wrong.write_text(rows("| Red bal | map | redBal.x | X |\n| X | subscribe | | Say |\n| Red ball | map | (1 | Y |"))
    with CheckWorker() as worker:
        for path in (*BOOKS, wrong):
            here = list(api.check(path).report)
            assert list(worker.check(path).diagnostics) == here
            assert [d.fixes for d in worker.check(path).diagnostics] == [d.fixes for d in here]


def test_the_worker_tells_what_each_row_gives(tmp_path):
    book = tmp_path / "b.md"
    book.write_text(rows("| Red ball | map | redBall.distance * 0 + 2 | D |\n| D | subscribe | | Print |"))
    with CheckWorker() as worker:
        assert worker.check(book).examples["T!2"] == "2"


def test_a_file_that_cannot_be_read_is_a_finding(tmp_path):
    with CheckWorker() as worker:
        assert [d.code for d in worker.check(tmp_path / "gone.xlsx").diagnostics] == ["FILE001"]


@pytest.mark.slow
def test_several_threads_share_the_worker():
    with CheckWorker() as worker, ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda i: len(worker.check(BOOKS[i % 2]).diagnostics), range(12)))
    assert found[::2] == [found[0]] * 6 and found[1::2] == [found[1]] * 6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("hoard()", "memory"),
        ("os._exit(7)", "exit code 7"),
        ("raise OSError(24, 'Too many open files')", "Too many open files"),
    ],
)
def test_a_check_that_goes_wrong_is_one_clear_finding(what, words, wicked):
    begun = wicked(what)
    with CheckWorker(within=300) as worker:
        [found] = worker.check(BOOKS[0]).diagnostics
    assert begun.exists()
    assert found.code == "FILE018" and words in found.message and "simple-tracking" in found.message


def test_after_a_check_that_was_ended_the_next_one_works(wicked, monkeypatch):
    begun = wicked("hang()")
    with CheckWorker() as worker:
        for within in (1, 10, 100):  # on a busy machine a second may be over before the connector hangs
            monkeypatch.setattr(worker, "_within", within)
            [found] = worker.check(BOOKS[0]).diagnostics
            assert found.code == "FILE018" and f"within {within} s" in found.message
            if begun.exists():
                break
        assert begun.exists() and "simple-tracking" in found.message
        monkeypatch.delenv("PYTHONPATH")
        monkeypatch.setattr(worker, "_within", 300)
        assert "FILE018" not in [d.code for d in worker.check(BOOKS[0]).diagnostics]
