"""Deletion of runs: a plan of what goes and what stays, carrying it out, and the fate of remembered faces.

When a participant withdraws, everything that was recorded under the code goes: the folders of the runs with all that is
in them, and faces that were remembered there. What people wrote elsewhere, in a workbook say, is searched, reported and
left. Packed formats (PDF, GIF, …) are not searched: a code would be found in their bytes by chance or not at all, and a
file made for it could take minutes. They are named with their dates, so that a person can look.
"""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import sqlite3
import struct
import time
import zipfile
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path
from typing import Any, BinaryIO

from rrp_sheets.engine.file_lock import is_locked
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import CAMERA, RUNS, TRACE, RecordedNotice, RecordedValue
from rrp_sheets.perception import face_memory
from rrp_sheets.recording.metadata import RunMetadata, as_dict, chosen, metadata_of, runs_in, runs_place
from rrp_sheets.recording.trace_reader import TraceReader, text_of
from rrp_sheets.texts import N_, listed, os_reason, sentences
from rrp_sheets.workbook.xlsx import BROKEN_ZIP

_CHUNK = 1 << 20  # bytes that are read at once
_MOST_FILES = 50_000
_MOST_SECONDS = 20.0
_MOST_FOLDERS = 50_000  # that are looked through for runs
_MOST_SECONDS_BELOW = 10.0
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


@dataclass(frozen=True)
class Unsearched:
    """A file that the search did not look into; of one in a zip, the name stands behind the zip's."""

    name: str
    day: date | None  # when it was changed last

    def __str__(self) -> str:
        return f"{self.name} ({self.day.day} {self.day:%B %Y})" if self.day else self.name


@dataclass
class CodeSearch:
    """Result of a search: the places of a code, in words, and the files that were not looked into."""

    found: list[str] = field(default_factory=list)
    unsearched: list[Unsearched] = field(default_factory=list)  # packed, damaged, locked, and when the time was over
    whole: bool = True  # False when there are more files than are named


def search_code(code: str, folder: Path, without: frozenset[Path] = frozenset()) -> CodeSearch:
    """Return the places in a folder where a participant's code occurs, and the files that were not looked into.

    No link is followed. Besides the folders `without`, installed software is left out: it would take all the time, and
    holds any code.
    """
    result = CodeSearch()
    search = _Searcher(code, time.monotonic() + _MOST_SECONDS)
    for number, path in enumerate(_searched_files(folder, without)):
        if number >= _MOST_FILES:
            result.whole = False
            break
        shown = path.relative_to(folder).as_posix()
        search.skipped.clear()
        try:
            places = list(search.within(path, shown))
        except (OSError, _OutOfTime):
            places = [_name_found(shown)] if search.in_name(path) else []
            search.skipped.append("")
        result.found += places
        if shown not in places:  # else it is to be opened anyway
            result.unsearched += [Unsearched(f"{shown}{inner}", _day_of(path)) for inner in search.skipped]
    return result


def _searched_files(folder: Path, without: frozenset[Path]) -> Iterator[Path]:
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(n for n in folders if Path(root, n).resolve() not in without and not _is_software(root, n))
        yield from (path for name in sorted(names) if not (path := Path(root, name)).is_symlink())


def _day_of(path: Path) -> date | None:
    try:
        return date.fromtimestamp(path.stat().st_mtime)
    except (OSError, OverflowError, ValueError):
        return None


class _OutOfTime(Exception):
    """Signal that the time for the whole search is over."""


class _Searcher:
    """Search for a code: as a word of its own, in plain text or escaped as in JSON and XML; with a deadline.

    Attributes:
        skipped: what of the file was not looked into: blank for all of it, else the name of a file in it.
    """

    def __init__(self, code: str, deadline: float) -> None:
        forms = {code.encode("utf-8", "replace"), json.dumps(code)[1:-1].encode()}
        forms |= {form.replace(b"&", b"&amp;").replace(b"<", b"&lt;").replace(b">", b"&gt;") for form in forms}
        self._longest = max(len(form) for form in forms)
        words = b"|".join(re.escape(form) for form in sorted(forms))
        self._pattern = re.compile(rb"(?<![0-9A-Za-z])(?:" + words + rb")(?![0-9A-Za-z])")
        self._deadline = deadline
        self.skipped: list[str] = []

    def _stands_in(self, data: bytes) -> bool:
        return self._pattern.search(data) is not None

    def in_name(self, path: Path) -> bool:
        return self._stands_in(os.fsencode(path.name))

    def within(self, path: Path, shown: str) -> Iterator[str]:
        """Yield the places in a file where the code occurs: its name for somewhere; raise _OutOfTime."""
        if self.in_name(path):
            yield _name_found(shown)
        name = path.name.casefold()
        if name.endswith(_PICTURES) or _is_film(shown) or not path.is_file():
            return
        if name.endswith(_PACKED):
            self.skipped.append("")
            return
        self._require_time()
        with path.open("rb") as file:
            if name.endswith(_PNG):
                found = self._stands_in(_texts_of(file))
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
            if self._stands_in(before + chunk):
                return True
            before = (before + chunk)[-(self._longest + 1) :]
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
        if self._stands_in(about.filename.encode("utf-8", "replace")):
            return True
        is_folder = name.endswith("/")  # `is_dir` fails for a blank name
        if is_folder or name.endswith(_PICTURES) or _is_film(about.filename):
            return False
        if name.endswith(_PACKED) or about.file_size > _MOST_MEMBER:
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
        return self._stands_in(data)

    def _in_journal(self, path: Path, shown: str) -> Iterator[str]:
        """Yield the edits and kept versions of workbooks that have the code; versions are workbooks themselves."""
        try:
            with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
                for book, edits in database.execute("select book, edits from edits"):
                    if self._stands_in(str(edits).encode()):
                        yield N_("{file} (an edit of {book})", file=shown, book=book)
                        break
                for book, name, content in database.execute("select book, name, content from versions"):
                    self._require_time()
                    kept = content if isinstance(content, bytes) else b""
                    packed = kept.startswith(_ZIP) and self._in_zip(io.BytesIO(kept), f": {book}, version “{name}”")
                    if packed or self._stands_in(str(name).encode()) or self._stands_in(kept):
                        yield N_("{file} (the version “{name}” of {book})", file=shown, name=name, book=book)
        except sqlite3.Error:
            with path.open("rb") as file:
                if self._in_bytes(file):
                    yield shown


def _name_found(file: str) -> str:
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


_BEFORE_NAME, _AFTER_NAME = face_memory.FACE_REMEMBERED.split("{name}")
_NOTED, _KNOWN = _BEFORE_NAME.encode(), b'"recognised":true'  # in the lines that tell of faces


@dataclass(frozen=True)
class Deletion:
    """Plan of a deletion: what goes, and what stays.

    Attributes:
        folder: of the workbooks.
        participant: whose runs they are; blank when runs were named.
        runs: the newest first.
        files: how many files they are; `size` their bytes, `pictures` and `sounds` how many of them.
        faces: what becomes of the kept faces; when they cannot be read, `unread` says why.
        like: codes that are spelled nearly the same; they stay.
        unknown: runs whose record does not say whose they are.
        elsewhere: where the code still stands; `unsearched` and `whole` are as in `CodeSearch`.
        within: the name of this folder as seen from the one that was asked for; blank for that one.
        below: what there is of the code in folders below, which goes only when it is asked for.
    """

    folder: Path
    participant: str
    runs: tuple[RunMetadata, ...]
    files: int
    size: int
    pictures: int
    sounds: int
    faces: tuple[FaceFate, ...]
    unread: str
    like: tuple[str, ...]
    unknown: tuple[str, ...]
    elsewhere: tuple[str, ...]
    whole: bool
    unsearched: tuple[Unsearched, ...] = ()
    within: str = ""
    below: tuple[Deletion, ...] = ()

    @property
    def faces_gone(self) -> list[str]:
        """Names of the faces that are wiped."""
        return [f.name for f in self.faces if f.goes]

    def as_dict(self) -> dict[str, Any]:
        """Return the plan as JSON."""
        return {
            "participant": self.participant or None, "runs": [as_dict(f) for f in self.runs], "files": self.files,
            "bytes": self.size, "pictures": self.pictures, "sounds": self.sounds, "faces_wiped": self.faces_gone,
            "faces_kept": [{"name": f.name, "why": f.why} for f in self.faces if not f.goes],
            "faces_unreadable": self.unread or None, "similar_codes": list(self.like),
            "unreadable_runs": list(self.unknown), "code_still_in": list(self.elsewhere),
            "not_searched": [{"file": u.name, "date": u.day and u.day.isoformat()} for u in self.unsearched],
            "looked_through_everything": self.whole and not self.unsearched,
            **({"folder": self.within} if self.within else {"below": [d.as_dict() for d in self.below]}),
        }  # fmt: skip

    def shown(self) -> list[str]:
        """Return the names of all runs in the plan, those in folders below with their folder."""
        return [f.run for f in self.runs] + [f"{d.within}/{f.run}" for d in self.below for f in d.runs]


def plan(folder: Path, participant: str = "", names: Sequence[str] = (), going: Collection[str] = ()) -> Deletion:
    """Plan the deletion of the runs of a participant, or of those of some names. Nothing is changed.

    Args:
        folder: of the workbooks; a participant's runs in folders below are part of the plan.
        participant: the code, as it was typed when the runs began.
        names: of the runs' folders.
        going: the names of runs that are known to go on, or to be written still.

    Raises:
        SheetsError: there are none, one of them goes on, or somebody else is deleting them.
    """
    try:
        root, places = _root(folder), runs_in(folder)
        every = {f.run: f for f in chosen(places, going=going)}
        if not participant:
            wanted = _named(names, every)
            _require_ended(root, wanted, going)
            return _planned(root, places, every, wanted, participant)
        below, seen = _below(root, participant)
        wanted = _of(participant, every, bool(below))
        _require_ended(root, wanted, going)
        _require_told(places)
        planned = _planned(root, places, every, wanted, participant)
        doomed = [runs_place(d.folder) / f.run for d in (planned, *below) for f in d.runs]
        result = search_code(participant, root, frozenset(p.resolve() for p in doomed))
    except FileNotFoundError:
        raise SheetsError(N_("Somebody else just deleted something here."), N_("Check again.")) from None
    told = {f"{d.within}/runs/faces.json".lstrip("/") for d in (planned, *below) if d.faces}  # face by face
    elsewhere, unsearched = tuple(place for place in result.found if place not in told), tuple(result.unsearched)
    return replace(planned, below=below, elsewhere=elsewhere, unsearched=unsearched, whole=result.whole and seen)


def delete(planned: Deletion, going: Collection[str] = (), below: Collection[str] = ()) -> tuple[str, ...]:
    """Delete what was planned: faces, then run by run, its record last, so that a broken deletion can be resumed.

    The runs in folders below go if these are named in `below`, as in the plan. `going` is as for `plan`.

    Returns:
        The runs that have begun meanwhile, of that participant or not known yet of whom: they stay.

    Raises:
        SheetsError: a run goes on by now, or something cannot be deleted; the rest is as it was.
    """
    parts = [planned, *(d for d in planned.below if d.within in below)]
    for part in parts:
        _require_possible(part, going if part is planned else ())
    for part in parts:
        for name in part.faces_gone:
            if name in face_memory.kept(part.folder):  # else somebody has wiped it meanwhile
                face_memory.forget(part.folder, name)
        for metadata in part.runs:
            place = runs_place(part.folder) / metadata.run
            if place.is_dir():
                _delete_folder(place)
    return tuple(name for part in parts for name in _begun(part)) if planned.participant else ()


def _below(root: Path, participant: str) -> tuple[tuple[Deletion, ...], bool]:
    """Plan the deletion of a participant's runs in the folders below; return also whether all were looked at."""
    folders, whole = _folders_below(root)
    found = []
    for folder in folders:
        places = runs_in(folder)
        every = {f.run: f for f in chosen(places)}
        wanted = [f for f in every.values() if f.participant == participant]
        if wanted:
            within = folder.relative_to(root).as_posix()
            found.append(replace(_planned(folder, places, every, wanted, participant), within=within))
    return tuple(found), whole


def _is_software(root: str, name: str) -> bool:
    """Return whether a folder holds installed software, which would take long to search and has nothing of ours."""
    return name == "node_modules" or Path(root, name, "pyvenv.cfg").is_file()


def _folders_below(folder: Path) -> tuple[list[Path], bool]:
    """Return the folders below a folder that have a `runs`, by name, and whether everything was looked at.

    No link is followed, and the folders of runs are not searched.
    """
    deadline = time.monotonic() + _MOST_SECONDS_BELOW
    found: list[Path] = []
    for number, (root, folders, _) in enumerate(os.walk(folder)):
        if number >= _MOST_FOLDERS or time.monotonic() > deadline:
            return found, False
        runs = Path(root, RUNS)
        if RUNS in folders and not runs.is_symlink():
            folders.remove(RUNS)
            if number:
                found.append(Path(root))
        folders[:] = sorted(n for n in folders if not _is_software(root, n))
    return found, True


def _planned(
    root: Path, places: Sequence[Path], every: dict[str, RunMetadata], wanted: Sequence[RunMetadata], participant: str
) -> Deletion:
    """Plan the deletion of some runs of one folder."""
    gone = {f.run for f in wanted}
    files = [p for place in places if place.name in gone for p in _files(place)]
    try:
        kept, unread = face_memory.kept(root), ""
    except SheetsError as error:
        kept, unread = [], sentences(error.message, error.remedy)
    codes = {f.participant for f in every.values()} - {participant}
    suffixes = Counter(p.suffix.casefold() for p in files)
    return Deletion(
        folder=root, participant=participant, runs=tuple(wanted), files=len(files),
        size=sum(p.lstat().st_size for p in files), sounds=suffixes[".wav"],
        pictures=sum(suffixes[kind] for kind in (".gif", ".png", ".svg", ".jpg", ".zip")),
        faces=tuple(_plan_faces(kept, every, places, gone, participant) if kept else ()),
        unread=unread, like=tuple(sorted(c for c in codes if participant and _squeezed(c) == _squeezed(participant))),
        unknown=tuple(f.run for f in every.values() if not f.readable and f.run not in gone),
        elsewhere=(), whole=True,
    )  # fmt: skip


def _require_possible(part: Deletion, going: Collection[str]) -> None:
    """Raise SheetsError when a run to delete is still written, or one that goes on could store a wiped face again."""
    places = {p.name: p for p in runs_in(part.folder)}
    _require_ended(part.folder, chosen([places[f.run] for f in part.runs if f.run in places], going=going), going)
    if part.participant:
        _require_told(list(places.values()))
    if part.faces_gone:
        busy = [f.run for f in chosen(list(places.values()), going=going) if f.ended == "going"]
        if busy:
            message = N_("The run {run} is still in progress, and would write the remembered faces again.", run=busy[0])
            raise SheetsError(message, N_("Wait until it has ended."))


def _begun(part: Deletion) -> list[str]:
    """Return the participant's runs that have begun since the plan, and those that do not say yet whose they are."""
    head = f"{part.within}/" if part.within else ""
    return [
        head + f.run for place in runs_in(part.folder)
        if (f := metadata_of(place)).participant == part.participant or (not f.readable and is_locked(place))
    ]  # fmt: skip


def _of(participant: str, every: dict[str, RunMetadata], below: bool) -> list[RunMetadata]:
    found = [f for f in every.values() if f.participant == participant]
    if not found and not below:
        codes = sorted({f.participant for f in every.values()} - {""})
        near = [c for c in codes if _squeezed(c) == _squeezed(participant)]
        hint = N_("Look at the list of runs.")
        if near:
            hint = N_("Did you mean {guess}?", guess=listed(near, "or"))
        elif codes:
            hint = N_("Codes here: {codes}.", codes=", ".join(codes[:20]))
        raise SheetsError(N_("No run here has the participant “{participant}”.", participant=participant), hint)
    return found


def _named(names: Sequence[str], every: dict[str, RunMetadata]) -> list[RunMetadata]:
    missing = [n for n in names if n not in every]
    if missing or not names:
        nameless = N_("There is no run without a name here.")
        words = N_("There is no run “{run}” here.", run=missing[0]) if missing else nameless
        raise SheetsError(words, N_("Look at the list of runs."))
    return [every[n] for n in dict.fromkeys(names)]


def _require_ended(folder: Path, wanted: Sequence[RunMetadata], going: Collection[str]) -> None:
    for metadata in wanted:
        if metadata.ended == "going" or metadata.run in going or is_locked(runs_place(folder) / metadata.run):
            message = N_("The run {run} is still in progress, or is still being written.", run=metadata.run)
            raise SheetsError(message, N_("Stop it, and delete when it has ended."))


def _require_told(places: Sequence[Path]) -> None:
    """Raise SheetsError for a run that is just beginning: it has no record yet, and may be anybody's."""
    for place in places:
        if is_locked(place) and not metadata_of(place).readable:
            message = N_("The run {run} has just started, so its participant is not known yet.", run=place.name)
            raise SheetsError(message, N_("Delete again in a few seconds."))


def _root(folder: Path) -> Path:
    """Return the folder of the workbooks, also when its `runs` was named; raise SheetsError for a run itself."""
    if (folder / TRACE).is_file():
        remedy = N_("Name the folder with the workbooks, and the run with --run.")
        raise SheetsError(N_("“{folder}” is a run itself.", folder=folder), remedy)
    return folder.absolute().parent if runs_place(folder) == folder else folder


def _squeezed(code: str) -> str:
    """Return a code with letters and digits only, whatever their case.

    >>> _squeezed("P-07") == _squeezed("p 07")
    True
    """
    return "".join(c for c in key(code) if c.isalnum())


def _files(place: Path) -> list[Path]:
    return [Path(root, name) for root, _, names in os.walk(place) for name in names]


def _delete_folder(place: Path) -> None:
    try:
        for path in sorted(place.iterdir(), key=lambda p: p.name == TRACE):
            with suppress(FileNotFoundError):
                if path.is_dir() and not path.is_symlink():
                    shutil.rmtree(path)
                else:
                    path.unlink()
        place.rmdir()
    except FileNotFoundError:  # somebody else deletes it as well
        return
    except OSError as error:
        message = N_("“{path}” cannot be deleted ({reason}).", path=error.filename or place, reason=os_reason(error))
        remedy = N_("See that you may write there, and that no other program has it open; then delete again.")
        raise SheetsError(message, remedy) from None


@dataclass(frozen=True)
class FaceFate:
    """Decision whether a kept face goes; `why` in words."""

    name: str
    goes: bool
    why: str


def _plan_faces(
    kept: Sequence[str], runs: Mapping[str, RunMetadata], places: Collection[Path], gone: Collection[str], code: str
) -> list[FaceFate]:
    """Decide which of the kept faces go when the runs named in `gone` are deleted.

    `code` is that of the participant whose runs these are, blank when they were chosen one by one.
    """
    began = {run: metadata.began.timestamp() for run, metadata in runs.items() if metadata.began is not None}
    newest: dict[str, str] = {}  # the run that has a name, by the name's key
    seen: set[str] = set()
    for place in sorted(places, key=lambda p: began.get(p.name, 0.0)):
        for name, new in _faces(place):
            if new:
                newest[key(name)] = place.name
            elif place.name in gone:
                seen.add(key(name))
    fates = []
    for name in kept:
        run = newest.get(key(name), "")
        if code and key(name) == key(code):
            fates.append(FaceFate(name, True, N_("it has that code as its name")))
        elif run in gone:
            fates.append(FaceFate(name, True, N_("it was remembered in the run {run}", run=run)))
        else:
            why = N_("it was remembered in the run {run}.", run=run) if run else N_("no run here has its participant.")
            if run in runs and runs[run].participant:
                why = N_("it was remembered in the run {run} of {whose}.", run=run, whose=runs[run].participant)
            recognised = N_("It was recognised in a run that is deleted.") if key(name) in seen else ""
            fates.append(FaceFate(name, False, sentences(why, recognised)))
    return fates


def _faces(place: Path) -> Iterator[tuple[str, bool]]:
    """Yield the names of faces that a run remembered (True) or recognised (False)."""
    try:
        reader = TraceReader(place)
        devices = {stream.name: stream.device for stream in reader.header.streams}
        kept = reader.header.text("faces") != "forgotten"
        for event in reader.containing(_NOTED, _KNOWN):
            device = devices.get(event.stream)
            if isinstance(event, RecordedNotice) and device == "RememberFace" and kept:
                text = text_of(event.text)
                if text.startswith(_BEFORE_NAME) and text.endswith(_AFTER_NAME):
                    yield text.removeprefix(_BEFORE_NAME).removesuffix(_AFTER_NAME), True
            elif isinstance(event, RecordedValue) and device == "FaceDetection":
                face = event.value if isinstance(event.value, dict) else {}
                if face.get("recognised") and face.get("name"):
                    yield text_of(face["name"]), False
    except UnreadableFile:
        return  # a damaged record says nothing
