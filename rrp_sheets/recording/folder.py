"""Folder of a run: making and finishing it, its files, and the files that a workbook needs beside it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.checks import Checked
from rrp_sheets.checks.check import folder_of
from rrp_sheets.engine.file_lock import lock_folder, locked, unlock
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import CAMERA, DIAGRAM, FILM, POSES, RUNS, STRIP, TABLE, TRACE, WORKBOOK
from rrp_sheets.private import private_folder
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.render.output import draw, gif_with, png_with, svg_with, words_of
from rrp_sheets.resources import bundled
from rrp_sheets.robots.media_files import BadSoundError, check_sound
from rrp_sheets.robots.own_robot import FOLDER, files_of
from rrp_sheets.texts import N_, os_reason, sentences

if TYPE_CHECKING:
    from rrp_sheets.workbook import Reading


_WHAT: dict[str, str] = {
    TRACE: N_("every event of the run"),
    WORKBOOK: N_("the workbook that ran"),
    "robot.toml": N_("the robot's catalogue"),
    "gestures.toml": N_("the robot's gestures"),
    TABLE: N_("the run as a table, one row per event"),
    DIAGRAM: N_("the diagram of the behaviours"),
    POSES: N_("positions of the robot and the objects around it"),
    CAMERA: N_("pictures of the robot's camera"),
    FILM: N_("the robot, filmed"),
    STRIP: N_("six moments of the run, with camera pictures if they are saved"),
}


_HEARD = {
    "say": N_("what the robot said"), "person": N_("what a person said"), "sound": N_("a sound that the robot played"),
}  # fmt: skip
_RECORDED = re.compile(rf"({'|'.join(_HEARD)})-\d+\.wav")


class RunFolder:
    """A run's folder; `path` is where it will be, `make` makes it."""

    def __init__(self, reading: Reading, out: Path | None, home: Path | None = None) -> None:
        self.reading = reading
        self._home = home
        self.source = Path(reading.workbook.source)
        self.path = (out or self._default()).absolute()
        self._was_there = self.path.exists()
        self._held: int | None = None
        if (self.path / TRACE).exists():
            message = N_("There is a run in “{path}” already.", path=self.path)
            raise SheetsError(message, N_("Name another folder with --out."))

    def make(self) -> None:
        """Make the folder; raise SheetsError when that cannot be done."""
        try:
            private_folder(self.path)
            self._held = lock_folder(self.path)
        except OSError as error:
            message = N_("The folder “{path}” cannot be made ({reason}).", path=self.path, reason=os_reason(error))
            raise SheetsError(message, N_("Name another folder with --out.")) from None

    def _default(self) -> Path:
        name = re.sub(r"[^\w.-]+", "-", self.source.stem).strip("-") or "run"
        stem = f"{datetime.now():%Y-%m-%d-%H%M%S}-{name}"
        folder = (self._home or self.source.absolute().parent) / RUNS / stem
        number = 2
        while folder.exists():  # two runs in one second
            folder = folder.with_name(f"{stem}-{number}")
            number += 1
        return folder

    def drop(self) -> None:
        """Remove the folder if it is new, as the run has not begun; its content only if this object has made it."""
        if not self._was_there:
            if self._held is not None:
                shutil.rmtree(self.path, ignore_errors=True)
            with suppress(OSError):
                self.path.rmdir()
        self.let_go()

    def keep_workbook(self, checked: Checked) -> None:
        """Copy the workbook that runs, as .xlsx, the robot's catalogue, and the files that the workbook names."""
        from rrp_sheets.documents.copies import as_xlsx

        target = self.path / WORKBOOK
        try:
            if self.reading.format == "xlsx":
                shutil.copyfile(self.source, target)
            else:
                as_xlsx(self.reading, checked.robot, target)
            for name in ("robot.toml", "gestures.toml"):
                if (checked.robot.folder / name).is_file():  # a robot need not have gestures
                    shutil.copyfile(checked.robot.folder / name, self.path / name)
            needed = material(checked)[0]  # so that it can be replayed
            if checked.robot.folder != bundled("robots") / checked.robot.name:  # it came with the workbook
                needed |= {f"{FOLDER}/{checked.robot.name}/{path.name}": path for path in files_of(checked.robot)}
            for name, source in needed.items():
                if name not in _WHAT and not _RECORDED.fullmatch(name):  # what is recorded has these names
                    (self.path / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(source, self.path / name)
        except OSError as error:
            message = N_("Nothing can be written into “{path}” ({reason}).", path=self.path, reason=os_reason(error))
            raise SheetsError(message, N_("Make room, or name another folder with --out.")) from None

    def finish(self, checked: Checked) -> tuple[dict[str, str], tuple[str, ...]]:
        """Write the table and the diagram (see `finish_folder`), and release the folder."""
        try:
            return finish_folder(self.path, checked)
        finally:
            self.let_go()

    def let_go(self) -> None:
        """Release the file lock: nothing more will be written."""
        unlock(self._held)
        self._held = None


def finish_folder(path: Path, checked: Checked) -> tuple[dict[str, str], tuple[str, ...]]:
    """Write a run's table and diagram; return the folder's files with descriptions, and what could not be made.

    A diagram that cannot be drawn must not take the rest of the run with it.
    """
    problems: list[str] = []
    with locked(path):  # when its own process has been ended, nobody holds it any more
        for name in (TABLE, DIAGRAM):
            half = path / f".{name}"  # this process may be ended any time
            try:
                if name == TABLE:
                    from rrp_sheets.recording.table import write_xlsx

                    write_xlsx([path / TRACE], half)
                else:
                    draw(checked, half)  # `stamp_pictures` says of which run
                half.replace(path / name)
            except (SheetsError, OSError) as error:
                half.unlink(missing_ok=True)
                why = sentences(error.message, error.remedy) if isinstance(error, SheetsError) else str(error)
                problems.append(N_("{file} could not be made: {why}", file=name, why=why))
        try:
            stamp_pictures(path)
        except OSError as error:
            problems.append(N_("The pictures do not say which run they are of ({reason}).", reason=os_reason(error)))
    return files_in(path), tuple(problems)


def files_in(path: Path) -> dict[str, str]:
    """Return the files of a run's folder, each with its description."""
    files = {name: what for name, what in _WHAT.items() if (path / name).is_file()}
    return files | {wav.name: describe(wav.name) for wav in sorted(path.glob("*.wav"))}


def describe(name: str) -> str:
    """Return the description of a file of a run's folder; empty for an unknown one.

    >>> describe("film.gif"), describe("say-002.wav")
    ('the robot, filmed', 'what the robot said')
    """
    if recorded := _RECORDED.fullmatch(name):
        return _HEARD[recorded[1]]
    return _WHAT.get(name, N_("a sound of the workbook") if name.casefold().endswith(".wav") else "")


_PICTURES: Mapping[str, Callable[[bytes, Mapping[str, str]], bytes]] = {
    FILM: gif_with,
    STRIP: lambda data, about: png_with(data, {"Description": words_of(about)}),
    DIAGRAM: lambda data, about: svg_with(data.decode(), about).encode("utf-8", "replace"),
}


def stamp_pictures(place: Path) -> None:
    """Write the metadata of a run that was just made into its pictures; raise OSError when one cannot be written."""
    about = dict(stamp_of(place).pairs())
    for name, make in _PICTURES.items():
        path = place / name
        with suppress(FileNotFoundError):
            stamped = make(path.read_bytes(), about)
            half = path.with_name(name + ".part")
            try:
                half.write_bytes(stamped)
                os.replace(half, path)
            finally:
                half.unlink(missing_ok=True)


def _sounds(checked: Checked) -> list[str]:
    """Return the names of the sound files that the settings of devices name."""
    names: dict[str, None] = {}
    for device in checked.workbook.devices:
        found = checked.robot.find(device.device.text)
        for k, cell in device.settings.items() if found else ():
            setting = found.type.settings.get(k) if found else None
            if setting is not None and setting.kind == "sound file" and cell and cell.text.strip():
                names[cell.text.strip()] = None
    return list(names)


def material(checked: Checked) -> tuple[dict[str, Path], list[str]]:
    """Return the sounds and pictures by name, and in words what cannot be found of them."""
    files: dict[str, Path] = {}
    lacks: list[str] = []
    folder = folder_of(checked.workbook)
    for name in _sounds(checked):
        try:
            check_sound(folder, name)
            files[name] = folder / name
        except BadSoundError as problem:
            lacks.append(N_("The sound “{name}” {problem}.", name=name, problem=problem.args[0]))
    for action in checked.scene or ():
        if picture := action.values.get("picture"):
            files[Path(picture).name] = Path(picture)
    return files, lacks
