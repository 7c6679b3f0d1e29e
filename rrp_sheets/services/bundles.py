"""Layout of bundles, and unpacking: a bundle is untrusted, so everything in it is checked before it is written.

Unpacked by hand a bundle is a folder to work in: sounds, robot and runs beside the workbook.
"""

from __future__ import annotations

import hashlib
import json
import platform
import re
import shutil
import stat
import tempfile
import unicodedata
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import reduce
from importlib import metadata
from pathlib import Path
from typing import Any

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.model.run_files import RUNS, TRACE
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.robots import load_robot, robot_names
from rrp_sheets.robots.own_robot import files_of
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.raw import unreadable
from rrp_sheets.workbook.xlsx import BROKEN_ZIP

SUFFIX = ".zip"
VERSIONS_FILE = "versions.json"
README = "README.txt"
PROTOCOL_FILE = "protocol.pdf"
ROBOTS = "robots"
KIND = "rrp-sheets bundle"
SCHEMA = 1  # grows when an entry of the list changes its meaning or goes
MOST_FILES = 2_000
MOST_BYTES = 2_000_000_000
_MOST_NAME_PARTS, _LONGEST_NAME = 6, 200  # folders and file; bytes of each
_FORBIDDEN = frozenset('\\:*?"<>|')
_TAKEN = frozenset((
    "con", "prn", "aux", "nul", "conin$", "conout$",
    *(f"{port}{n}" for port in ("com", "lpt") for n in "0123456789¹²³"),
))  # fmt: skip
"""Names of devices, which Windows takes for these whatever ending stands behind them."""
_PROJECT = "rrp-sheets"
_NAME = re.compile(r"[A-Za-z0-9][\w.-]*")


def is_safe(name: str) -> bool:
    r"""Return whether a name stays in the folder where it is unpacked, and can be written on every system.

    >>> [is_safe(n) for n in ("a.xlsx", "runs/1/trace.jsonl", "赤い ボール.xlsx")]
    [True, True, True]
    >>> [is_safe(n) for n in ("NUL", "runs/CON/x", "aux .txt", "COM¹.csv", "lpt1.tar.gz", "a./b", "a /b", "a:b")]
    [False, False, False, False, False, False, False, False]
    >>> [is_safe(n) for n in ("../a", "/a", "a//b", "a\\b", "C:a", "a/./b", "", "a\nb", "nul.txt", "a. ", "\u202ea")]
    [False, False, False, False, False, False, False, False, False, False, False]
    """
    parts = name.split("/")
    return len(parts) <= _MOST_NAME_PARTS and all(map(_is_safe_part, parts))


def is_device(name: str) -> bool:
    """Return whether Windows takes a file's name for one of its devices.

    >>> is_device("nul.xlsx"), is_device("null.xlsx")
    (True, False)
    """
    return name.partition(".")[0].rstrip().casefold() in _TAKEN


def _is_safe_part(part: str) -> bool:
    if part in ("", ".", "..") or part[-1] in ". " or is_device(part):
        return False
    if any(c in _FORBIDDEN or unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp") for c in part):
        return False
    return len(part.encode("utf-8", "surrogatepass")) <= _LONGEST_NAME


def manifest(workbook: str, reading: Reading, checked: Checked, runs: Sequence[Path]) -> dict[str, Any]:
    """Return the manifest of a bundle without its files; `workbook` is its name in the bundle."""
    return {
        "kind": KIND, "schema": SCHEMA, "workbook": workbook, "workbook_sha256": reading.digest,
        "title": checked.workbook.protocol.text("Title"), "robot": checked.robot.name,
        **here(),
        "runs": [_run(folder) for folder in sorted(runs, key=lambda p: p.name)],
    }  # fmt: skip


def here() -> dict[str, Any]:
    """Return the versions of the program, of Python, of what the program is built on, and the machine."""
    system, python = f"{platform.system()} {platform.machine()}", platform.python_version()
    return {"program": __version__, "python": python, "platform": system, "dependencies": dependencies()}


def dependencies() -> dict[str, str]:
    """Return the versions of what the program is built on, as installed here."""
    found: dict[str, str] = {}
    wanted: list[str] = []
    with suppress(metadata.PackageNotFoundError):
        wanted = metadata.requires(_PROJECT) or []
    for requirement in wanted:
        name = _NAME.match(requirement)
        if name is not None and "extra ==" not in requirement:
            with suppress(metadata.PackageNotFoundError):  # for another system
                found[name[0]] = metadata.version(name[0])
    return dict(sorted(found.items()))


def _run(folder: Path) -> dict[str, str]:
    told = stamp_of(folder)
    return {"folder": f"{RUNS}/{folder.name}", "workbook_sha256": told.digest, "program": told.program,
            "mode": told.mode, "seed": told.seed, "participant": told.participant, "condition": told.condition,
            "began": told.began}  # fmt: skip


def differences(told: Mapping[str, Any]) -> list[str]:
    """Return in words the versions that differ from those in a bundle's list, which is untrusted."""
    mine = here()
    out: list[str] = []
    for part, name in (("program", "RRP Sheets"), ("python", "Python"), ("platform", N_("the system"))):
        there = _text(told.get(part))
        if there != mine[part]:
            there = there or N_("not known")
            out.append(N_("{name}: {there} there, {here} here", name=name, there=there, here=mine[part]))
    others = told.get("dependencies")
    if isinstance(others, Mapping):
        changed = [
            f"{name} {_text(others[name])} → {version}"
            for name, version in mine["dependencies"].items()
            if name in others and _text(others[name]) != version
        ]
        if changed:
            some = ", ".join(changed[:8]) + (" …" if len(changed) > 8 else "")
            out.append(N_("parts of the program: {changed}", changed=some))
    return out


def _text(value: object) -> str:
    return "".join(c for c in value if c.isprintable())[:60] if isinstance(value, str) else ""


_MOST_LIST = 2_000_000  # bytes of the list
_RATIO, _RATIO_FROM = 400, 10_000_000  # the trace of a value that never changes packs well
_WHOLE_RATIO, _WHOLE_FROM = 150, 50_000_000  # of all files together; many traces are packed to a twentieth
_PIECE = 1 << 20
_LONGEST_SHOWN = 80  # letters of a refused file's name
_ENCRYPTED = 0x1


@dataclass(frozen=True)
class Bundle:
    """An unpacked bundle: its folder, the workbook in it (a file, or a folder of CSV files) and its runs' folders.

    `notes` tell what differs from its list or from the program here.
    """

    folder: Path
    workbook: Path
    runs: tuple[Path, ...]
    notes: tuple[str, ...]


class _Refused(Exception):
    """Refusal of a file that is no bundle; the text follows the file's name."""


def has_bundle_suffix(path: Path) -> bool:
    """Return whether a file is to be taken as a bundle, by its suffix.

    >>> has_bundle_suffix(Path("study.ZIP")), has_bundle_suffix(Path("study.xlsx"))
    (True, False)
    """
    return path.suffix.casefold() == SUFFIX


@contextmanager
def unpacked(path: Path) -> Iterator[Bundle]:
    """Unpack a bundle into a private folder, which is removed at the end; see :func:`unpack`."""
    with tempfile.TemporaryDirectory(prefix="rrp-bundle-") as folder:
        yield unpack(path, Path(folder))


def unpack(path: Path, folder: Path, most_bytes: int = MOST_BYTES) -> Bundle:
    """Put the files of a bundle into an empty folder.

    Raises:
        UnreadableFile: when it is none, or is refused.
    """
    if not path.is_file():
        raise unreadable("FILE001", name=path.name, hint=N_("Check the spelling and the folder."))
    try:
        return _unpack(path, folder, most_bytes)
    except _Refused as problem:
        why = problem.args[0]
    except BROKEN_ZIP as problem:
        of_system = isinstance(problem, OSError) and problem.errno is not None
        why = str(getattr(problem, "strerror", "")) if of_system else N_("it is damaged, or cut off")
    raise unreadable("FILE020", name=path.name, why=why)


def _unpack(path: Path, folder: Path, most_bytes: int) -> Bundle:
    with zipfile.ZipFile(path) as archive:
        entries = {e.filename: e for e in _judged(archive, most_bytes)}
        told, files = _list(archive, entries)
        notes: list[str] = []
        for name, entry in entries.items():
            if name == VERSIONS_FILE:
                continue
            if name not in files:
                notes.append(N_("“{file}” is not in the bundle's list; it was left out.", file=name))
                continue
            if _put(archive, entry, folder / name) != files[name]:
                notes.append(N_("“{file}” has been changed since the bundle was made.", file=name))
        notes += [N_("“{file}” is missing in the bundle.", file=name) for name in files if name not in entries]
    workbook = told.get("workbook")
    if not isinstance(workbook, str) or not is_safe(workbook) or "/" in workbook or not (folder / workbook).exists():
        raise _Refused(N_("the workbook that its list names is not in it"))
    others = differences(told)
    if others:
        listed = reduce(lambda before, after: N_("{before}; {after}", before=before, after=after), others)
        notes.append(N_("Not the same as where the bundle was made: {listed}.", listed=listed))
    home = folder if (folder / workbook).is_file() else folder / workbook
    notes += catalogue_note(home)
    runs = tuple(sorted(p.parent for p in folder.glob(f"{RUNS}/*/{TRACE}")))
    add_catalogues(runs, home)
    return Bundle(folder, folder / workbook, runs, tuple(notes))


def _judged(archive: zipfile.ZipFile, most_bytes: int) -> list[zipfile.ZipInfo]:
    """Return the files of a zip; raise _Refused when names, number or sizes may do harm."""
    entries = archive.infolist()
    counts = Counter(e.filename.casefold() for e in entries)
    names = counts.keys()
    if "[content_types].xml" in names:
        raise _Refused(N_("it is a workbook of Excel under another name: let its name end with .xlsx"))
    if VERSIONS_FILE not in names:
        raise _Refused(N_("there is no {file} in it", file=VERSIONS_FILE))
    if len(names) != len(entries):
        first, second, *_ = (_shown(e) for e in entries if e.filename.casefold() == counts.most_common(1)[0][0])
        words = N_("“{first}” and “{second}” would be one file on some computers")
        same = N_("two of its files have the name “{first}”")
        raise _Refused(N_(same if first == second else words, first=first, second=second))
    if len(entries) > MOST_FILES:
        raise _Refused(N_("it has {n:,} files; {most:,} are possible", n=len(entries), most=MOST_FILES))
    unpacked_size, packed_size = sum(e.file_size for e in entries), sum(e.compress_size for e in entries)
    if unpacked_size > most_bytes:
        raise _Refused(N_("unpacked it would be larger than {n:,} MB", n=most_bytes // 10**6))
    if unpacked_size > _WHOLE_FROM and unpacked_size > _WHOLE_RATIO * max(packed_size, 1):
        raise _Refused(N_("its files are compressed as no files of a bundle are"))
    for e in entries:
        if not is_safe(e.filename.removesuffix("/")):
            words = N_("“{name}” has a name that cannot be used, or that leads out of the folder")
            raise _Refused(N_(words, name=_shown(e)))
        if e.flag_bits & _ENCRYPTED:
            raise _Refused(N_("“{name}” is protected by a password", name=_shown(e)))
        if stat.S_IFMT(e.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise _Refused(N_("“{name}” is a link and no file", name=_shown(e)))
        if e.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise _Refused(N_("“{name}” is compressed in an unusual way", name=_shown(e)))
        if e.file_size > _RATIO_FROM and e.file_size > _RATIO * max(e.compress_size, 1):
            raise _Refused(N_("“{name}” is compressed as no file of a bundle is", name=_shown(e)))
    return [e for e in entries if not e.is_dir()]


def _shown(entry: zipfile.ZipInfo) -> str:
    """Return a file's name as it can be shown, whatever is in it; a long one is shortened."""
    text = "".join(c if c.isprintable() else "�" for c in entry.filename)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


def _list(archive: zipfile.ZipFile, entries: Mapping[str, zipfile.ZipInfo]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the list of a bundle, and in it the hash of every file, by name."""
    if VERSIONS_FILE not in entries or entries[VERSIONS_FILE].file_size > _MOST_LIST:
        raise _Refused(N_("its {file} is not a list", file=VERSIONS_FILE))
    try:
        told = json.loads(archive.read(VERSIONS_FILE).decode())
    except (ValueError, RecursionError):
        raise _Refused(N_("its {file} is damaged", file=VERSIONS_FILE)) from None
    if not isinstance(told, dict) or told.get("kind") != KIND:
        raise _Refused(N_("its {file} is another program's", file=VERSIONS_FILE))
    if told.get("schema") != SCHEMA:
        raise _Refused(N_("it was made by a newer version of this program; update it"))
    if not isinstance(told.get("files"), dict):
        raise _Refused(N_("its {file} names no files", file=VERSIONS_FILE))
    files = [(name, about) for name, about in told["files"].items() if isinstance(about, dict) and is_safe(name)]
    return told, {name: str(about.get("sha256", "")) for name, about in files}


def _put(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path) -> str:
    """Write one file, and return its SHA-256; the size that the zip states is not trusted."""
    target.parent.mkdir(parents=True, exist_ok=True)
    total, left = hashlib.sha256(), entry.file_size
    with archive.open(entry) as source, target.open("xb") as into:
        while piece := source.read(_PIECE):
            left -= len(piece)
            if left < 0:
                raise _Refused(N_("“{name}” is larger than it says", name=entry.filename))
            total.update(piece)
            into.write(piece)
    return total.hexdigest()


def catalogue_note(home: Path) -> list[str]:
    """Return the differences of the catalogues in words; nothing when all that is read has the same bytes."""
    notes: list[str] = []
    for place in sorted(p for p in (home / ROBOTS).glob("*") if p.is_dir()):
        if place.name not in robot_names():
            notes.append(N_("The robot “{name}” of the bundle is not known here.", name=place.name))
            continue
        mine = {p.name: p.read_bytes() for p in files_of(load_robot(place.name))}
        other = {p.name: p.read_bytes() for p in place.iterdir() if p.is_file()}
        changed = sorted(name for name, data in mine.items() if other.get(name) != data)  # nothing reads other files
        if changed:
            words = N_("The robot's catalogue is another one than here ({files}); the bundle's own is used.")
            notes.append(N_(words, files=", ".join(changed[:5])))
    return notes


def add_catalogues(runs: Iterable[Path], home: Path) -> None:
    """Copy the robots' catalogues beside the workbook of every run, as they were when it was made, for its replay."""
    for run in runs:
        for place in (p for p in (home / ROBOTS).glob("*") if p.is_dir()):
            target = run / ROBOTS / place.name
            if not target.exists():
                shutil.copytree(place, target)
                for table in ("robot.toml", "gestures.toml"):
                    if (run / table).is_file():
                        shutil.copyfile(run / table, target / table)
