"""The file whose cells are set: open elsewhere, changed meanwhile, odd or swollen; and it is never half-written."""

from __future__ import annotations

import io
import os
import stat
import subprocess
import sys
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from lossless import SHEET, cell, make, parts, refused, repack

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.workbook import files, read
from rrp_sheets.workbook.edits import InsertRows, SetCell
from rrp_sheets.workbook.files import FileChanged, clean_up, edit, read_sheets, write_atomically

PART = "xl/worksheets/sheet1.xml"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return make(tmp_path / "a b プロトコル.xlsx")


def test_a_change_meanwhile_is_a_conflict(path):
    digest = read(path).digest
    changed = edit(path, [SetCell(SHEET, 3, 3, "theirs")])
    assert changed.changed and changed.digest == read(path).digest != digest
    with pytest.raises(FileChanged) as told:
        edit(path, [SetCell(SHEET, 3, 3, "mine")], expected_digest=digest)
    assert "changed by somebody else" in told.value.message
    assert cell(path, 3, 3) == "theirs"
    edit(path, [SetCell(SHEET, 3, 3, "mine")], expected_digest=changed.digest)


@pytest.mark.parametrize(("lock", "program"), [("~${}", "Excel"), (".~lock.{}#", "LibreOffice")])
def test_a_file_that_is_open_elsewhere(path, lock, program):
    beside = path.with_name(lock.format(path.name))
    beside.write_text("")
    assert f"open in {program}" in refused(path, SetCell(SHEET, 3, 3, "x")).message
    beside.unlink()
    edit(path, [SetCell(SHEET, 3, 3, "x")])


def test_a_change_in_the_last_moment(path, monkeypatch):
    """The file is replaced by another program after it was read and before it is written."""
    real = files.os.fsync

    def slow(handle):
        path.write_bytes(path.read_bytes() + b"")
        os.utime(path, ns=(1, 1))
        real(handle)

    monkeypatch.setattr(files.os, "fsync", slow)
    assert "at this moment" in refused(path, SetCell(SHEET, 3, 3, "x")).message
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_permissions_and_links_stay(path):
    os.chmod(path, 0o640)
    link = path.parent / "link.xlsx"
    link.symlink_to(path)
    edit(link, [SetCell(SHEET, 3, 3, "through the link")])
    assert link.is_symlink() and cell(path, 3, 3) == "through the link"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    os.chmod(path, 0o440)
    assert "write-protected" in refused(path, SetCell(SHEET, 3, 3, "x")).message


def test_owner_and_group_stay(path, monkeypatch):
    """Colleagues may go on writing the file in a shared folder; where that is not allowed, it is written all the same."""
    about, asked = path.stat(), []

    def chown(file, owner, group):
        asked.append((owner, group))
        if owner != -1:
            raise PermissionError

    monkeypatch.setattr(files.os, "chown", chown)
    os.chmod(path, 0o664)
    edit(path, [SetCell(SHEET, 3, 3, "x")])
    assert asked == [(about.st_uid, about.st_gid), (-1, about.st_gid)]
    assert cell(path, 3, 3) == "x" and stat.S_IMODE(path.stat().st_mode) == 0o664


def test_owner_and_group_stay_on_the_disk(path):
    groups = [os.getgid(), *os.getgroups()]
    mine = (1234, 1234) if os.geteuid() == 0 else (-1, groups[-1])  # only root gives a file to another user
    os.chown(path, *mine)
    about = path.stat()
    edit(path, [SetCell(SHEET, 3, 3, "x")])
    assert (path.stat().st_uid, path.stat().st_gid) == (about.st_uid, about.st_gid)


def test_a_group_that_cannot_be_kept_gives_its_rights_to_no_other(path, monkeypatch):
    def chown(*_):
        raise PermissionError

    monkeypatch.setattr(files.os, "chown", chown)
    os.chmod(path, 0o664)
    edit(path, [SetCell(SHEET, 3, 3, "x")])
    assert stat.S_IMODE(path.stat().st_mode) == 0o604


def test_what_the_system_refuses_is_told(path, monkeypatch):
    def refused_by_system(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(files, "file_bytes", refused_by_system)
    assert "Permission denied" in refused(path, SetCell(SHEET, 3, 3, "x")).message


def test_a_link_is_followed_but_not_when_its_name_must_be_free(tmp_path):
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "real.txt", tmp_path / "link.txt"
    link.symlink_to(Path("far") / "real.txt")
    with pytest.raises(SheetsError, match="already a file"):
        write_atomically(link, b"new", replace=False)
    assert not target.exists()
    target.write_bytes(b"old")
    write_atomically(link, b"new")
    assert link.is_symlink() and target.read_bytes() == b"new"
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["far", "link.txt", "real.txt"]


def test_what_is_being_written_is_not_swept_away(path, monkeypatch):
    """A workbook that somebody begins to look at may be one that another is making."""
    real = files.os.fsync

    def slow(handle):
        left = path.parent / f".{path.name}.0123abcd.part"
        left.write_bytes(b"left by a killed program")
        for half in path.parent.glob(".*.part"):
            os.utime(half, (time.time() - 10,) * 2)
        clean_up(path)
        assert not left.exists()
        real(handle)

    monkeypatch.setattr(files.os, "fsync", slow)
    files.make_workbook({"T": [["made"]]}, path)
    assert read_sheets(path)[0].cells[1, 1].text == "made"
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_a_full_disk_leaves_the_file(path, monkeypatch):
    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    assert "No space left" in refused(path, SetCell(SHEET, 3, 3, "x")).message
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_killed_in_mid_writing(path):
    """The file is as it was, and what was left beside it is swept away some time later."""
    before = path.read_bytes()
    code = (
        "import os, sys\nfrom rrp_sheets.workbook.files import *\nfrom rrp_sheets.workbook.edits import SetCell\n"
        "os.fsync = lambda handle: os._exit(9)\n"
        f"edit(sys.argv[1], [SetCell({SHEET!r}, 3, 3, 'x')])"
    )
    assert subprocess.run([sys.executable, "-c", code, str(path)]).returncode == 9
    assert path.read_bytes() == before
    (left,) = (p for p in path.parent.iterdir() if p != path)
    assert left.name.startswith(".") and left.suffix == ".part"
    edit(path, [SetCell(SHEET, 3, 3, "y")])
    assert left.exists()  # somebody may still be writing
    os.utime(left, (1, 1))
    edit(path, [SetCell(SHEET, 3, 3, "z")])
    assert not left.exists() and cell(path, 3, 3) == "z"


def test_missing_and_refused_files(tmp_path):
    with pytest.raises(UnreadableFile):
        edit(tmp_path / "none.xlsx", [])
    (tmp_path / "x.xlsx").write_bytes(b"PK nothing")
    with pytest.raises(UnreadableFile):
        edit(tmp_path / "x.xlsx", [SetCell(SHEET, 1, 1, "x")])


@pytest.mark.parametrize("way", ["stored", "descriptors", "comment", "extra"])
def test_odd_zips(path, way):
    """Uncompressed entries, data descriptors, a comment, extra fields: the other entries keep their contents."""
    old = parts(path)
    out = io.BytesIO()

    class Stream:  # no seeking: sizes are written behind the data
        def write(self, data):
            return out.write(data)

        def flush(self):
            pass

    kind = zipfile.ZIP_STORED if way == "stored" else zipfile.ZIP_DEFLATED
    with zipfile.ZipFile(Stream() if way == "descriptors" else out, "w", kind) as package:
        for name, data in old.items():
            entry = zipfile.ZipInfo(name, (1999, 12, 31, 23, 59, 58))
            entry.compress_type = kind
            entry.extra = b"\x99\x99\x02\x00ab" if way == "extra" else b""
            package.writestr(entry, data)
        package.comment = b"hello" if way == "comment" else b""
    path.write_bytes(out.getvalue())
    edit(path, [SetCell(SHEET, 3, 3, "x")])
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        assert [e.filename for e in package.infolist()] == list(old)
        assert {e.date_time for e in package.infolist()} == {(1999, 12, 31, 23, 59, 58)}
        assert {e.compress_type for e in package.infolist()} == {kind}
        assert package.comment == (b"hello" if way == "comment" else b"")
        assert all(e.extra == (b"\x99\x99\x02\x00ab" if way == "extra" else b"") for e in package.infolist())
    assert cell(path, 3, 3) == "x"


def test_utf_16_and_cells_with_cdata(path):
    def wide(data: bytes) -> bytes:
        text = data.decode().replace('encoding="UTF-8"', 'encoding="UTF-16"')
        return text.replace("<v>1.5</v>", "<v><![CDATA[1.5]]></v><!-- </c></row> -->").encode("utf-16")

    repack(path, {PART: wide})
    before = {at: c.text for at, c in read_sheets(path)[0].cells.items()}
    edit(path, [SetCell(SHEET, 2, 1, "new"), InsertRows(SHEET, 2)])
    moved = {(r + (r > 1), c): text for (r, c), text in (before | {(2, 1): "new"}).items()}
    assert {at: c.text for at, c in read_sheets(path)[0].cells.items()} == moved


def test_swollen_sheets_are_refused(path):
    """Elements beside the table that would fill the memory."""
    many = b"<x/>" * 1_600_000 + b"</worksheet>"
    repack(path, {PART: lambda data: data.replace(b"</worksheet>", many)})
    assert path.stat().st_size < 100_000
    with pytest.raises(SheetsError):
        edit(path, [SetCell(SHEET, 3, 3, "x")])


def test_special_files(tmp_path):
    os.mkfifo(tmp_path / "x.xlsx")
    with pytest.raises(UnreadableFile):
        edit(tmp_path / "x.xlsx", [SetCell(SHEET, 3, 3, "x")])


def test_editors_at_the_same_time(path):
    """Ten threads, each its own cell: every edit is in the file at the end."""
    with ThreadPoolExecutor(10) as pool:
        list(pool.map(lambda n: edit(path, [SetCell(SHEET, 20 + n, 1, f"by {n}")]), range(10)))
    assert [cell(path, 20 + n, 1) for n in range(10)] == [f"by {n}" for n in range(10)]
    assert [p.name for p in path.parent.iterdir()] == [path.name]
