"""Search for a participant's code in a folder: in names of files, texts, workbooks, and kept versions.

Packed formats (PDF, GIF, …) are not searched: a code would be found in their bytes by chance or not at all, and a file
made for it could take minutes. They are named with their dates, so that a person can look.
"""

from __future__ import annotations

import io
import json
import os
import re
import sqlite3
import struct
import time
import zipfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import BinaryIO

from rrp_sheets.model.run_files import CAMERA, RUNS
from rrp_sheets.recording.metadata import is_software
from rrp_sheets.texts import N_
from rrp_sheets.workbook.package import BROKEN_ZIP

_CHUNK = 1 << 20  # bytes that are read at once
_MOST_FILES = 50_000
_MOST_SECONDS = 20.0
_MOST_MEMBER = 200_000_000  # bytes of a file in a zip
_PICTURES = (".jpg", ".jpeg", ".wav", CAMERA)  # their bytes hold no text of ours but what was drawn
_PNG = ".png"  # an export of ours has texts beside the picture
_PACKED = (".pdf", ".gif", ".gz", ".tgz", ".bz2", ".xz", ".7z", ".rar", ".mp4", ".mov", ".avi", ".webm", ".webp",
           ".heic", ".doc", ".xls", ".ppt")  # fmt: skip
_SIGNATURE, _TEXTS = b"\x89PNG\r\n\x1a\n", (b"tEXt", b"iTXt")
_ZIP = b"PK\x03\x04"
_JOURNAL = "journal.sqlite"
_TAG, _FORMULA = re.compile(rb"<[^<>]*>"), re.compile(rb"<f[ >][^<]*</f>")
_NAME = re.compile(rb' (?:name|title|author|displayName)="([^"<>]*)"')


class ParticipantCode:
    """A participant's code as it may stand in bytes: as a word of its own, in plain text or escaped as in JSON."""

    def __init__(self, code: str) -> None:
        forms = {code.encode("utf-8", "replace"), json.dumps(code)[1:-1].encode()}
        forms |= {form.replace(b"&", b"&amp;").replace(b"<", b"&lt;").replace(b">", b"&gt;") for form in forms}
        self.longest = max(len(form) for form in forms)
        words = b"|".join(re.escape(form) for form in sorted(forms))
        self._pattern = re.compile(rb"(?<![0-9A-Za-z])(?:" + words + rb")(?![0-9A-Za-z])")

    def stands_in(self, data: bytes) -> bool:
        """Return whether the code occurs in some bytes."""
        return self._pattern.search(data) is not None


@dataclass(frozen=True)
class Unsearched:
    """A file that the search did not look into.

    Attributes:
        name: as seen from the folder; of a file in a zip, behind the zip's name.
        day: when it was changed last, None when unknown.
    """

    name: str
    day: date | None

    def __str__(self) -> str:
        return f"{self.name} ({self.day.day} {self.day:%B %Y})" if self.day else self.name


@dataclass
class TracesLeft:
    """Result of a search: the places of a code, and the files that were not looked into.

    Attributes:
        found: the places, in words.
        unsearched: packed, damaged and locked files, and those that the time did not suffice for.
        whole: False when there are more files than are named.
    """

    found: list[str] = field(default_factory=list)
    unsearched: list[Unsearched] = field(default_factory=list)
    whole: bool = True


def places_of(code: str, folder: Path, without: frozenset[Path] = frozenset()) -> TracesLeft:
    """Return the places in a folder where a code occurs, and the files that were not looked into.

    Args:
        code: the participant's.
        folder: to look through; no link is followed.
        without: folders that are left out. So is installed software: it would take all the time, and holds any code.
    """
    left = TracesLeft()
    search = _Search(ParticipantCode(code), time.monotonic() + _MOST_SECONDS)
    for number, path in enumerate(_files(folder, without)):
        if number >= _MOST_FILES:
            left.whole = False
            break
        shown = path.relative_to(folder).as_posix()
        search.skipped.clear()
        try:
            places = list(search.within(path, shown))
        except (OSError, _OutOfTime):
            places = [_named(shown)] if search.in_name(path) else []
            search.skipped.append("")
        left.found += places
        if shown in places:
            continue  # it is to be opened anyway
        day = _day_of(path)
        left.unsearched += [Unsearched(f"{shown}{inner}", day) for inner in search.skipped]
    return left


def _files(folder: Path, without: frozenset[Path]) -> Iterator[Path]:
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(n for n in folders if Path(root, n).resolve() not in without and not is_software(root, n))
        yield from (path for name in sorted(names) if not (path := Path(root, name)).is_symlink())


def _day_of(path: Path) -> date | None:
    try:
        return date.fromtimestamp(path.stat().st_mtime)
    except (OSError, OverflowError, ValueError):
        return None


class _OutOfTime(Exception):
    """Signal that the time for the whole search is over."""


class _Search:
    """Search for a code, with a deadline.

    Attributes:
        skipped: what of the file was not looked into: blank for all of it, else the name of a file in it.
    """

    def __init__(self, code: ParticipantCode, deadline: float) -> None:
        self._code, self._deadline = code, deadline
        self.skipped: list[str] = []

    def in_name(self, path: Path) -> bool:
        """Return whether the code occurs in a file's name."""
        return self._code.stands_in(os.fsencode(path.name))

    def within(self, path: Path, shown: str) -> Iterator[str]:
        """Yield the places in a file where the code occurs: its name for somewhere; raise _OutOfTime."""
        if self.in_name(path):
            yield _named(shown)
        name = path.name.casefold()
        if name.endswith(_PICTURES) or not path.is_file():
            return
        if name.endswith(_PACKED):
            if not _is_film(shown):
                self.skipped.append("")
            return
        self._require_time()
        with path.open("rb") as file:
            if name.endswith(_PNG):
                found = self._code.stands_in(_texts_of(file))
            elif file.read(len(_ZIP)) == _ZIP or name.endswith((".zip", ".xlsx", ".xlsm")):
                found = self._in_zip(file, "")
            elif path.name == _JOURNAL:
                yield from self._in_journal(path, shown)
                return
            else:
                file.seek(0)
                found = self._in_bytes(file)
        if found:
            yield shown

    def _require_time(self) -> None:
        if time.monotonic() > self._deadline:
            raise _OutOfTime

    def _in_bytes(self, file: BinaryIO) -> bool:
        before = b""
        while chunk := file.read(_CHUNK):
            self._require_time()
            if self._code.stands_in(before + chunk):
                return True
            before = (before + chunk)[-(self._code.longest + 1) :]
        return False

    def _in_zip(self, file: BinaryIO, within: str, depth: int = 2) -> bool:
        """Return whether the code occurs in a zip; parts that cannot be looked into are added to `skipped`."""
        try:
            with zipfile.ZipFile(file) as packed:
                return any(self._in_member(packed, about, within, depth) for about in packed.infolist())
        except BROKEN_ZIP:
            self.skipped.append(within)
            return False

    def _in_member(self, packed: zipfile.ZipFile, about: zipfile.ZipInfo, within: str, depth: int) -> bool:
        self._require_time()
        name, shown = about.filename.casefold(), f"{within}: {about.filename[:200]}"
        if self._code.stands_in(about.filename.encode("utf-8", "replace")):
            return True
        if name.endswith(_PICTURES) or about.is_dir():
            return False
        if name.endswith(_PACKED) or about.file_size > _MOST_MEMBER:
            if not _is_film(about.filename):
                self.skipped.append(shown)
            return False
        try:
            data = packed.read(about)
        except BROKEN_ZIP:
            self.skipped.append(shown)
            return False
        if data.startswith(_ZIP) and depth > 1:
            return self._in_zip(io.BytesIO(data), shown, depth - 1)
        if name.endswith(_PNG):
            data = _texts_of(io.BytesIO(data))
        elif name.endswith((".xml", ".rels")):
            data = _words(data)
        return self._code.stands_in(data)

    def _in_journal(self, path: Path, shown: str) -> Iterator[str]:
        """Yield the edits and kept versions of workbooks that have the code; versions are workbooks themselves."""
        try:
            with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
                for book, edits in database.execute("select book, edits from edits"):
                    if self._code.stands_in(str(edits).encode()):
                        yield N_("{file} (an edit of {book})", file=shown, book=book)
                        break
                for book, name, content in database.execute("select book, name, content from versions"):
                    self._require_time()
                    kept = content if isinstance(content, bytes) else b""
                    packed = kept.startswith(_ZIP) and self._in_zip(io.BytesIO(kept), f": {book}, version “{name}”")
                    if packed or self._code.stands_in(str(name).encode()) or self._code.stands_in(kept):
                        yield N_("{file} (the version “{name}” of {book})", file=shown, name=name, book=book)
        except sqlite3.Error:
            with path.open("rb") as file:
                if self._in_bytes(file):
                    yield shown


def _named(file: str) -> str:
    return N_("{file} (its name)", file=file)


def _is_film(name: str) -> bool:
    """Return whether a file is a film in a run's folder, which belongs to the record there and goes with that run."""
    return f"/{RUNS}/" in f"/{name}" and name.casefold().endswith(".gif")


def _texts_of(picture: BinaryIO) -> bytes:
    """Return the texts beside the picture in a PNG, as a short code could occur by chance in its other bytes."""
    found: list[bytes] = []
    if picture.read(len(_SIGNATURE)) == _SIGNATURE:
        while len(head := picture.read(8)) == 8:
            size, kind = struct.unpack(">I4s", head)
            if kind in _TEXTS:
                found.append(picture.read(min(size, _CHUNK)))
                size -= len(found[-1])
            picture.seek(size + 4, os.SEEK_CUR)  # with its checksum
    return b" ".join(found)


def _words(xml: bytes) -> bytes:
    """Return what people wrote in a part of a workbook; tags and formulas go, as P11 is a cell's name too.

    >>> _words(b'<c r="P11"><f>P11+1</f><v>2</v></c><sheet name="With P12"/>').split()
    [b'2', b'With', b'P12']
    """
    text = _TAG.sub(b" ", _FORMULA.sub(b" ", xml))
    return b" ".join([text, *_NAME.findall(xml)])
