"""Deleting runs: first what would go and what would stay is told, then it is done.

A participant who withdraws takes everything along that was recorded under the code: the folders of the runs with all
that is in them, and faces that were remembered there. What people wrote elsewhere, in a workbook say, is told and left.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.runs import faces
from rrp_sheets.runs.records.facts import TRACE, Facts
from rrp_sheets.runs.records.listing import as_dict, chosen, runs_in, runs_place
from rrp_sheets.runs.records.remembered import FaceFate, fates
from rrp_sheets.runs.records.traces_left import places_of


@dataclass(frozen=True)
class Deletion:
    """What is deleted, and what is not.

    Attributes:
        folder: of the workbooks.
        participant: whose runs they are; blank when runs were named.
        runs: the runs, the newest first.
        files: how many files they are; `size` their bytes, `pictures` and `sounds` how many of them.
        faces: what becomes of the kept faces; when they cannot be read, `unread` says why.
        like: codes that are spelled nearly the same; they stay.
        unknown: runs whose record does not say whose they are.
        elsewhere: where the code still stands; `whole`: whether everything was looked through.
    """

    folder: Path
    participant: str
    runs: tuple[Facts, ...]
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

    @property
    def faces_gone(self) -> list[str]:
        """The names of the faces that are wiped."""
        return [f.name for f in self.faces if f.goes]

    def as_dict(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "participant": self.participant or None, "runs": [as_dict(f) for f in self.runs], "files": self.files,
            "bytes": self.size, "pictures": self.pictures, "sounds": self.sounds, "faces_wiped": self.faces_gone,
            "faces_kept": [{"name": f.name, "why": f.why} for f in self.faces if not f.goes],
            "faces_unreadable": self.unread or None, "similar_codes": list(self.like),
            "unreadable_runs": list(self.unknown), "code_still_in": list(self.elsewhere),
            "looked_through_everything": self.whole,
        }  # fmt: skip


def plan(folder: Path, participant: str = "", names: Sequence[str] = (), going: Collection[str] = ()) -> Deletion:
    """What would be deleted: the runs of a participant, or those of some names. Nothing is changed.

    Args:
        folder: of the workbooks.
        participant: the code, as it was typed when the runs began.
        names: of the runs' folders.
        going: the names of runs that are known to go on, or to be written still.

    Raises:
        SheetsError: there are none, or one of them goes on.
    """
    root = _root(folder)
    places = runs_in(folder)
    every = {f.run: f for f in chosen(places, going=going)}
    wanted = _of(participant, every) if participant else _named(names, every)
    _require_ended(wanted, going)
    gone = {f.run for f in wanted}
    doomed = [p for p in places if p.name in gone]
    files = [p for place in doomed for p in _files(place)]
    kept, unread = _kept(root)
    found, whole = list[str](), True
    if participant:
        found, whole = places_of(participant, root, frozenset(p.resolve() for p in doomed))
    codes = {f.participant for f in every.values()} - {participant}
    return Deletion(
        folder=folder, participant=participant, runs=tuple(wanted), files=len(files),
        size=sum(p.lstat().st_size for p in files), pictures=_count(files, (".gif", ".png", ".svg", ".jpg", ".zip")),
        sounds=_count(files, (".wav",)), faces=tuple(fates(kept, every, places, gone, participant) if kept else ()),
        unread=unread, like=tuple(sorted(c for c in codes if participant and _squeezed(c) == _squeezed(participant))),
        unknown=tuple(f.run for f in every.values() if not f.readable and f.run not in gone),
        elsewhere=tuple(_without_faces(found, kept)), whole=whole,
    )  # fmt: skip


def delete(planned: Deletion, going: Collection[str] = ()) -> None:
    """Delete what was planned: faces first, then run by run, the record of each last, so that it can be gone on with.

    Raises:
        SheetsError: a run goes on by now, or something cannot be deleted; the rest is as it was.
    """
    places = {p.name: p for p in runs_in(planned.folder)}
    now = chosen([places[f.run] for f in planned.runs if f.run in places], going=going)
    _require_ended(now, going)
    if planned.faces_gone:
        busy = [f.run for f in chosen(list(places.values()), going=going) if f.ended == "going"]
        if busy:
            raise SheetsError(
                f"The run {busy[0]} goes on, and would write the remembered faces again.", "Wait until it has ended."
            )
        for name in planned.faces_gone:
            faces.forget(_root(planned.folder), name)
    for facts in now:
        _delete_folder(places[facts.run])


def _of(participant: str, every: dict[str, Facts]) -> list[Facts]:
    found = [f for f in every.values() if f.participant == participant]
    if not found:
        codes = sorted({f.participant for f in every.values()} - {""})
        near = [c for c in codes if _squeezed(c) == _squeezed(participant)]
        hint = (
            f"Did you mean {' or '.join(near)}?" if near else f"Codes here: {', '.join(codes[:20])}." if codes else ""
        )
        raise SheetsError(f"No run here has the participant “{participant}”.", hint or "See `rrp-sheets runs`.")
    return found


def _named(names: Sequence[str], every: dict[str, Facts]) -> list[Facts]:
    missing = [n for n in names if n not in every]
    if missing or not names:
        which = f"“{missing[0]}”" if missing else "without a name"
        raise SheetsError(f"There is no run {which} here.", "See the names with `rrp-sheets runs`.")
    return [every[n] for n in dict.fromkeys(names)]


def _require_ended(wanted: Sequence[Facts], going: Collection[str]) -> None:
    for facts in wanted:
        if facts.ended == "going" or facts.run in going:
            raise SheetsError(
                f"The run {facts.run} goes on, or is still being written.", "Stop it, and delete when it has ended."
            )


def _root(folder: Path) -> Path:
    """The folder of the workbooks, also when its `runs` was named.

    Raises:
        SheetsError: it is a run itself.
    """
    if (folder / TRACE).is_file():
        raise SheetsError(f"“{folder}” is a run itself.", "Name the folder with the workbooks, and the run with --run.")
    return folder.absolute().parent if runs_place(folder) == folder else folder


def _kept(root: Path) -> tuple[list[str], str]:
    try:
        return faces.kept(root), ""
    except SheetsError as error:
        return [], f"{error.message} {error.remedy}"


def _without_faces(found: Sequence[str], kept: Sequence[str]) -> list[str]:
    """Without the file of faces, which is told face by face."""
    return [place for place in found if not (kept and place == "runs/faces.json")]


def _squeezed(code: str) -> str:
    """A code without what people spell differently.

    >>> _squeezed("P-07") == _squeezed("p 07")
    True
    """
    return "".join(c for c in key(code) if c.isalnum())


def _count(files: Sequence[Path], suffixes: Collection[str]) -> int:
    return sum(p.suffix.casefold() in suffixes for p in files)


def _files(place: Path) -> list[Path]:
    return [Path(root, name) for root, _, names in os.walk(place) for name in names]


def _delete_folder(place: Path) -> None:
    try:
        for path in sorted(place.iterdir(), key=lambda p: p.name == TRACE):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()
        place.rmdir()
    except OSError as error:
        raise SheetsError(
            f"“{error.filename or place}” cannot be deleted ({error.strerror}).",
            "See that you may write there, and that no other program has it open; then delete again.",
        ) from None
