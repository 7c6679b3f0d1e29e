"""Files that a workbook needs beside it: sounds, pictures of persons, a robot catalogue of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rrp_sheets.checks import Checked
from rrp_sheets.checks.check import folder_of
from rrp_sheets.devices.own_robot import FOLDER, files_of
from rrp_sheets.devices.sound_files import BadSoundError, look_at
from rrp_sheets.resources import bundled


def sounds(checked: Checked) -> list[str]:
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
    lacks = []
    folder = folder_of(checked.workbook)
    for name in sounds(checked):
        try:
            look_at(folder, name)
            files[name] = folder / name
        except BadSoundError as problem:
            lacks.append(f"The sound “{name}” {problem}.")
    for action in checked.scene or ():
        if picture := action.values.get("picture"):
            files[Path(picture).name] = Path(picture)
    return files, lacks


def own_catalogue(checked: Checked) -> Iterator[tuple[str, Path]]:
    """Yield the files of a catalogue that came with the workbook, with their names beside it; none of a bundled one."""
    robot = checked.robot
    if robot.folder != bundled("robots") / robot.name:
        for path in files_of(robot):
            yield f"{FOLDER}/{robot.name}/{path.name}", path
