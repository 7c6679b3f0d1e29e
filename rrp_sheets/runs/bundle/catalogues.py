"""Comparison of the robot's catalogue in a bundle with the one of the program here, and its copies for replays."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from rrp_sheets.devices import load_robot, robot_names
from rrp_sheets.devices.own_robot import files_of
from rrp_sheets.runs.bundle import form


def catalogue_note(home: Path) -> list[str]:
    """Return the differences of the catalogues in words; nothing when both have the same bytes."""
    notes = []
    for place in sorted(p for p in (home / form.ROBOTS).glob("*") if p.is_dir()):
        if place.name not in robot_names():
            notes.append(f"The robot “{place.name}” of the bundle is not known here.")
            continue
        mine = {p.name: p.read_bytes() for p in files_of(load_robot(place.name))}
        other = {p.name: p.read_bytes() for p in place.iterdir() if p.is_file()}
        changed = sorted(n for n in mine.keys() | other.keys() if mine.get(n) != other.get(n))
        if changed:
            named = ", ".join(changed[:5])
            notes.append(f"The robot's catalogue is another one than here ({named}); the bundle's own is used.")
    return notes


def dress(runs: Iterable[Path], home: Path) -> None:
    """Copy the catalogue, as it was when a run was made, beside the workbook of every run, for its replay."""
    for run in runs:
        for place in (p for p in (home / form.ROBOTS).glob("*") if p.is_dir()):
            target = run / form.ROBOTS / place.name
            if not target.exists():
                shutil.copytree(place, target)
                for table in ("robot.toml", "gestures.toml"):
                    if (run / table).is_file():
                        shutil.copyfile(run / table, target / table)
