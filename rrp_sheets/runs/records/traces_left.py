"""Where a participant's code still stands in a folder: in names of files, texts, workbooks, and kept versions."""

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
from pathlib import Path
from typing import BinaryIO

from rrp_sheets.render.stamped import gif_words
from rrp_sheets.runs.records.below import is_software
from rrp_sheets.workbook.package import BROKEN_ZIP

_CHUNK = 1 << 20  # bytes that are read at once
_MOST_FILES = 50_000
_MOST_SECONDS = 20.0
_MOST_MEMBER = 200_000_000  # bytes of a file in a zip
_PICTURES = (".jpg", ".jpeg", ".wav", "camera.zip")  # their bytes hold no text of ours but what was drawn
_PNG, _GIF = ".png", ".gif"  # an export of ours has texts beside the picture
_STAMPED = (_PNG, _GIF)
_PDF = ".pdf"
_PACKED = re.compile(rb"/Filter\b[^\r\n]{0,400}?[\r\n]*stream\r?\n.*?endstream", re.DOTALL)  # of a PDF: by chance, too
_PACKED_END = b"endstream"
_STAMP = 1 << 16  # bytes at the end of a GIF, in which its stamp is
_SIGNATURE, _TEXTS = b"\x89PNG\r\n\x1a\n", (b"tEXt", b"iTXt")
_ZIPS = (".xlsx", ".zip", ".xlsm")
_UNREAD = " (it could not be looked into: it is damaged, too large, or has a password)"
_JOURNAL = "journal.sqlite"
_TAG, _FORMULA = re.compile(rb"<[^<>]*>"), re.compile(rb"<f[ >][^<]*</f>")
_NAME = re.compile(rb' (?:name|title|author|displayName)="([^"<>]*)"')


class Code:
    """A participant's code as it may stand in bytes: as a word of its own, in plain text or escaped as in JSON."""

    def __init__(self, code: str) -> None:
        forms = {code.encode("utf-8", "replace"), json.dumps(code)[1:-1].encode()}
        forms |= {form.replace(b"&", b"&amp;").replace(b"<", b"&lt;").replace(b">", b"&gt;") for form in forms}
        self.longest = max(len(form) for form in forms)
        words = b"|".join(re.escape(form) for form in sorted(forms))
        self._pattern = re.compile(rb"(?<![0-9A-Za-z])(?:" + words + rb")(?![0-9A-Za-z])")

    def stands_in(self, data: bytes) -> bool:
        """Whether it is in there."""
        return self._pattern.search(data) is not None


def places_of(code: str, folder: Path, without: frozenset[Path] = frozenset()) -> tuple[list[str], bool]:
    """The places in a folder where a code stands, in words, and whether everything was looked at.

    Args:
        code: the participant's.
        folder: to look through; no link is followed.
        without: folders that are left out. So is installed software: it would take all the time, and holds any code.
    """
    wanted = Code(code)
    deadline = time.monotonic() + _MOST_SECONDS
    found: list[str] = []
    for number, path in enumerate(_files(folder, without)):
        if number >= _MOST_FILES or time.monotonic() > deadline:
            return found, False
        shown = path.relative_to(folder).as_posix()
        try:
            found += [f"{shown}{where}" for where in _within(wanted, path)]
        except OSError as error:
            found.append(f"{shown} could not be looked into ({error.strerror})")
    return found, True


def _files(folder: Path, without: frozenset[Path]) -> Iterator[Path]:
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(n for n in folders if Path(root, n).resolve() not in without and not is_software(root, n))
        yield from (path for name in sorted(names) if not (path := Path(root, name)).is_symlink())


def _within(code: Code, path: Path) -> Iterator[str]:
    if code.stands_in(os.fsencode(path.name)):
        yield " (its name)"
    suffix = path.suffix.casefold()
    if path.name.casefold().endswith(_PICTURES) or not path.is_file():
        return
    if suffix in _STAMPED:
        with path.open("rb") as file:
            if code.stands_in(_texts_of(file) if suffix == _PNG else _end_of(file)):
                yield ""
    elif suffix == _PDF and path.stat().st_size <= _MOST_MEMBER:
        if code.stands_in(_unpacked(path.read_bytes())):
            yield ""
    elif suffix in _ZIPS:
        if (told := _zip_says(code, path)) is not None:
            yield told
    elif path.name == _JOURNAL:
        yield from _journal(code, path)
    elif _file_has(code, path):
        yield ""


def _file_has(code: Code, path: Path) -> bool:
    before = b""
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK):
            if code.stands_in(before + chunk):
                return True
            before = (before + chunk)[-(code.longest + 1) :]
    return False


def _zip_says(code: Code, file: Path | io.BytesIO, depth: int = 2) -> str | None:
    """What is told of a zip: blank when the code stands in it, None when it does not, else why nobody knows."""
    told = None
    try:
        with zipfile.ZipFile(file) as packed:
            for about in packed.infolist():
                one = _member_says(code, packed, about, depth)
                if one == "":
                    return ""
                told = told or one
    except BROKEN_ZIP:
        return _UNREAD
    return told


def _member_says(code: Code, packed: zipfile.ZipFile, about: zipfile.ZipInfo, depth: int) -> str | None:
    name = about.filename.casefold()
    if code.stands_in(about.filename.encode("utf-8", "replace")):
        return ""
    if name.endswith(_PICTURES):
        return None
    if about.file_size > _MOST_MEMBER:
        return _UNREAD
    try:
        data = packed.read(about)
    except BROKEN_ZIP:
        return _UNREAD
    if name.endswith(_STAMPED):
        data = (_texts_of if name.endswith(_PNG) else _end_of)(io.BytesIO(data))
    elif name.endswith(_PDF):
        data = _unpacked(data)
    elif name.endswith((".xml", ".rels")):
        data = _words(data)
    if code.stands_in(data):
        return ""
    return _zip_says(code, io.BytesIO(data), depth - 1) if depth > 1 and name.endswith(_ZIPS) else None


def _texts_of(picture: BinaryIO) -> bytes:
    """The texts that a PNG has beside its picture; among its other bytes a short code would stand by chance."""
    found: list[bytes] = []
    if picture.read(len(_SIGNATURE)) == _SIGNATURE:
        while len(head := picture.read(8)) == 8:
            size, kind = struct.unpack(">I4s", head)
            if kind in _TEXTS:
                found.append(picture.read(min(size, _CHUNK)))
                size -= len(found[-1])
            picture.seek(size + 4, os.SEEK_CUR)  # with its checksum
    return b" ".join(found)


def _end_of(film: BinaryIO) -> bytes:
    """The texts at the end of a GIF."""
    size = film.seek(0, os.SEEK_END)
    film.seek(max(0, size - _STAMP))
    return gif_words(film.read())


def _unpacked(pdf: bytes) -> bytes:
    """A PDF without its packed bytes; behind the last that end there are none, and looking for their end takes long."""
    whole, last, rest = pdf.rpartition(_PACKED_END)
    return _PACKED.sub(b" ", whole + last) + rest


def _words(xml: bytes) -> bytes:
    """What people wrote in a part of a workbook: P11 is a cell's name too, and stands in tags and formulas.

    >>> _words(b'<c r="P11"><f>P11+1</f><v>2</v></c><sheet name="With P12"/>').split()
    [b'2', b'With', b'P12']
    """
    text = _TAG.sub(b" ", _FORMULA.sub(b" ", xml))
    return b" ".join([text, *_NAME.findall(xml)])


def _journal(code: Code, path: Path) -> Iterator[str]:
    """The edits and kept versions of workbooks; the versions are workbooks themselves."""
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
            for book, edits in database.execute("select book, edits from edits"):
                if code.stands_in(str(edits).encode()):
                    yield f" (an edit of {book})"
                    break
            for book, name, content in database.execute("select book, name, content from versions"):
                kept = content if isinstance(content, bytes) else b""
                if (
                    code.stands_in(str(name).encode())
                    or code.stands_in(kept)
                    or _zip_says(code, io.BytesIO(kept)) == ""
                ):
                    yield f" (the version “{name}” of {book})"
    except sqlite3.Error:
        if _file_has(code, path):
            yield ""
