"""A robot's catalogue that comes with a workbook, in `robots/<name>/` beside it: how a bundle brings its own along.

It may be a stranger's, and the simulator's libraries read some of its files. So it is judged before anything uses it: a
table is held against the one of the program, the robot's shape against what our own are made of, and no file can name
another one that is not of plain name in that folder.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.devices.catalogue import CATALOGUE, Robot, load_robot, robot_in, robot_names
from rrp_sheets.devices.own_limits import judge_limits
from rrp_sheets.devices.own_shape import PLAIN, CatalogueError, Shape, judge_solids, read_shape
from rrp_sheets.diagnostics.catalogue import CODES
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.errors import UnreadableFile

FOLDER = "robots"
_MOST_FILES = 40
_MOST_BYTES = 2_000_000  # of one file; ours have at most 40,000
_MOST_TEXT = 2_000  # letters of one text in a table
_LARGEST = 1e7  # of any number
_DEEPEST = 12  # tables within tables
_OPTIONAL = ("languages", "touch", "posture_leans", "posture_ways", "groups", "postures")
_NAMED = ("groups", "postures", "posture_leans", "posture_ways", "languages")  # their keys are names of their own


def own_robot(folder: Path, name: str) -> Robot | None:
    """The robot of that name whose catalogue stands beside a workbook; None when there is none.

    Args:
        folder: where the workbook's files are.
        name: as the Protocol says it.

    Raises:
        UnreadableFile: when there is one and it cannot be trusted.
    """
    if not name.replace("_", "").isalnum() or not (folder / FOLDER / name / CATALOGUE).is_file():
        return None
    place = folder / FOLDER / name
    try:
        files = _files(place)
        return _judged(place, name, tuple((p.name, p.stat().st_mtime_ns, p.stat().st_size) for p in files))
    except (CatalogueError, OSError) as problem:
        why = problem.args[0] if isinstance(problem, CatalogueError) else problem.strerror or "it cannot be read"
        entry = CODES["FILE019"]
        message = Phrase(entry.message, name=f"{FOLDER}/{name}", why=why)
        raise UnreadableFile("FILE019", message, entry.remedy) from None


def files_of(robot: Robot) -> list[Path]:
    """The files of a robot that a run needs: its tables, its shape, and the solids which that is made of."""
    folder, shape = robot.folder, robot.folder / str(robot.data["robot"]["urdf"])
    tables = [p for p in folder.glob("*.toml") if p.is_file()]
    return sorted([*tables, shape, *(folder / name for name in sorted(read_shape(shape).meshes))])


def _files(place: Path) -> list[Path]:
    """What there is in the folder."""
    found = sorted(place.iterdir())[: _MOST_FILES + 1]
    if len(found) > _MOST_FILES:
        raise CatalogueError(Phrase("it has more than {most} files", most=_MOST_FILES))
    for path in found:
        if path.is_symlink() or not path.is_file():
            if path.is_dir() and not path.is_symlink():
                continue  # examples, say: nothing reads them
            raise CatalogueError(Phrase("“{file}” is a link and no file", file=path.name))
        if path.stat().st_size > _MOST_BYTES:
            raise CatalogueError(
                Phrase("“{file}” is larger than {most} MB", file=path.name, most=_MOST_BYTES // 1_000_000)
            )
    return [p for p in found if p.is_file()]


@lru_cache(maxsize=4)
def _judged(place: Path, name: str, stamp: tuple[tuple[str, int, int], ...]) -> Robot:
    """The robot, after everything in its folder was looked at."""
    model = load_robot(name if name in robot_names() else "nao")
    tables = {path.name: _table(path) for path in sorted(place.glob("*.toml"))}
    for file, table in tables.items():
        _judge_values(table, file)
    data = tables[CATALOGUE]
    _judge_likeness(data, model.data, "")
    if [j.get("name") for j in data["joints"]] != [j.name for j in model.joints.values()]:
        raise CatalogueError(Phrase("its joints are other ones than those that can be simulated here"))
    shape = str(data["robot"]["urdf"])
    if not PLAIN.fullmatch(shape) or not (place / shape).is_file():
        raise CatalogueError(Phrase("“{file}” is no file of its folder", file=shape[:80]))
    body = read_shape(place / shape)
    judge_solids(place, body.meshes)
    try:
        robot = robot_in(place, name, data)
        judge_limits(robot, body, model, _shape_of(model.name))
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as problem:
        told = f"{type(problem).__name__}: {problem}"[:160]
        raise CatalogueError(Phrase("its tables do not fit together ({problem})", problem=told)) from None
    return robot


@lru_cache(maxsize=4)
def _shape_of(name: str) -> Shape:
    """The shape of a robot of the program."""
    model = load_robot(name)
    return read_shape(model.folder / str(model.data["robot"]["urdf"]))


def _table(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError, ValueError) as problem:
        raise CatalogueError(
            Phrase("“{file}” is no table ({problem})", file=path.name, problem=str(problem)[:100])
        ) from None


def _judge_values(value: Any, where: str, depth: int = 0) -> None:
    """Texts and numbers of sensible size, and nothing else."""
    if depth > _DEEPEST:
        raise CatalogueError(Phrase("“{file}” is nested too deeply", file=where))
    match value:
        case bool():
            return
        case int() | float():
            if not math.isfinite(value) or abs(value) > _LARGEST:
                raise CatalogueError(Phrase("“{file}” has a number that no robot has", file=where))
        case str():
            if len(value) > _MOST_TEXT or any(not c.isprintable() and c not in "\n\t" for c in value):
                raise CatalogueError(Phrase("“{file}” has a text that cannot be shown", file=where))
        case list():
            for entry in value:
                _judge_values(entry, where, depth + 1)
        case dict():
            for k, entry in value.items():
                _judge_values(k, where, depth + 1)
                _judge_values(entry, where, depth + 1)
        case _:
            raise CatalogueError(Phrase("“{file}” has a date, which no robot has", file=where))


def _judge_likeness(found: Any, model: Any, where: str) -> None:
    """Whether a table has the tables, and values of the kinds, that the one of the program has."""
    if _kind(found) is not _kind(model):
        raise CatalogueError(
            Phrase("“{file}” is not what it is in the program's own catalogue", file=where or CATALOGUE)
        )
    if isinstance(model, Mapping):
        named = where in _NAMED
        for k, part in model.items():
            at = f"{where}.{k}" if where else k
            if k in found:
                _judge_likeness(found[k], part, at)
            elif not named and not (not where and k in _OPTIONAL):
                raise CatalogueError(
                    Phrase("“{file}” is missing; it was perhaps made for another version of the program", file=at)
                )
    elif isinstance(model, Sequence) and not isinstance(model, str):
        kinds = {_kind(part) for part in model}
        if len(kinds) == 1 and {_kind(part) for part in found} - kinds:
            raise CatalogueError(Phrase("“{file}” is not what it is in the program's own catalogue", file=where))


def _kind(value: Any) -> type:
    return float if isinstance(value, (int, float)) and not isinstance(value, bool) else type(value)
