"""Records of people and edited files can be read by this user only, from the moment that they exist."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from test_killed_server import HEADER

from rrp_sheets import api
from rrp_sheets.documents.document import Journal
from rrp_sheets.errors import SheetsError
from rrp_sheets.perception.face_memory import FaceMemory, kept, read_memory, write_memory
from rrp_sheets.workbook.files import make_workbook

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="modes of Unix")


@pytest.fixture(autouse=True)
def _usual_umask() -> Iterator[None]:
    """Set the umask of most systems, which lets others read."""
    before = os.umask(0o022)
    yield
    os.umask(before)


def open_to_others(folder: Path) -> dict[str, str]:
    """Files that others may read, write or execute."""
    found = {}
    for path in [folder, *folder.rglob("*")]:
        try:
            mode = path.stat().st_mode & 0o777
        except FileNotFoundError:  # written in parts, and renamed meanwhile
            continue
        if mode & 0o077:
            found[path.name] = f"{mode:o}"
    return found


class Watched:
    """Looks at a folder again and again meanwhile."""

    def __init__(self, folder: Path) -> None:
        self.seen: dict[str, str] = {}
        self._folder = folder
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look)

    def _look(self) -> None:
        while not self._over.wait(0.001):
            if self._folder.exists():
                self.seen |= open_to_others(self._folder)

    def __enter__(self) -> Watched:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()


@pytest.mark.slow
@pytest.mark.parametrize("there", [False, True], ids=["new", "there already, and open"])
def test_a_run_is_for_its_user_only(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "books"
    folder.mkdir()
    book = make_workbook({"T": [HEADER, ["", "Red ball", "map", "redBall.x", "X", ""], ["", "X", "subscribe", "", "Say", ""]]},
                         folder / "b.xlsx")  # fmt: skip
    out = folder / "runs" / "one"
    if there:
        out.mkdir(parents=True)
    with Watched(out) as watched:
        ended = api.run_apart(book, api.RunSettings(seconds=0.3, fast=True, out=out))
    assert ended.result is not None and len(list(out.iterdir())) > 6
    for found in (open_to_others(out), watched.seen):
        assert set(found) <= ({"one"} if there else set()), found
    assert (folder / "runs").stat().st_mode & 0o777 == 0o755  # the runs of others may stand beside it


def test_the_journal_is_for_its_user_only_also_one_of_an_earlier_version(tmp_path: Path) -> None:
    with Watched(tmp_path / ".rrp-sheets") as watched:
        journal = Journal(tmp_path)
        journal.keep_version("b.xlsx", "first", "Aya", "digest", b"content")
    assert len(list((tmp_path / ".rrp-sheets").iterdir())) > 1
    assert not open_to_others(tmp_path / ".rrp-sheets") and not watched.seen
    journal.close()
    for path in (tmp_path / ".rrp-sheets", *(tmp_path / ".rrp-sheets").iterdir()):
        path.chmod(0o755 if path.is_dir() else 0o644)
    journal = Journal(tmp_path)
    assert journal.versions("b.xlsx")[0].name == "first" and not open_to_others(tmp_path / ".rrp-sheets")


def test_faces_are_never_readable_by_others_not_for_a_moment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    memory = FaceMemory()
    memory.add(1, "Kim", [[0.0] * 127 + [1.0]])  # type: ignore[list-item]
    path = tmp_path / "runs" / "faces.json"
    path.parent.mkdir()
    path.with_suffix(".new").write_text("what a killed run left", encoding="utf-8")
    seen = []
    replace = Path.replace
    monkeypatch.setattr(Path, "chmod", lambda *_: pytest.fail("it was readable before"))
    monkeypatch.setattr(Path, "replace", lambda half, to: (seen.append(half.stat().st_mode & 0o777), replace(half, to)))
    write_memory(path, memory)
    assert seen == [0o600] and path.stat().st_mode & 0o777 == 0o600
    assert [person.name for person in read_memory(path).persons] == ["Kim"]


def test_faces_of_an_earlier_version_are_closed_to_others_when_they_are_read(tmp_path: Path) -> None:
    memory = FaceMemory()
    memory.add(1, "Kim", [[0.0] * 127 + [1.0]])  # type: ignore[list-item]
    path = tmp_path / "runs" / "faces.json"
    write_memory(path, memory)
    path.chmod(0o644)
    assert kept(tmp_path) == ["Kim"] and path.stat().st_mode & 0o777 == 0o600
    path.chmod(0o644)
    path.write_text("broken", encoding="utf-8")
    with pytest.raises(SheetsError):
        kept(tmp_path)
    assert path.stat().st_mode & 0o777 == 0o600
