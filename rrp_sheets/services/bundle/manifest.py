"""Layout of a bundle: the names of its parts, its limits, the check of file names, and the versions that it lists.

Unpacked by hand it is a folder to work in: sounds, robot and runs beside the workbook.
"""

from __future__ import annotations

import platform
import re
import unicodedata
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.model.run_files import RUNS
from rrp_sheets.recording.metadata import stamp_of
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading

SUFFIX = ".zip"
LIST = "versions.json"
README = "README.txt"
PAPER = "protocol.pdf"
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


def versions(workbook: str, reading: Reading, checked: Checked, runs: Sequence[Path]) -> dict[str, Any]:
    """Return everything that the list of a bundle contains, except the files.

    Args:
        workbook: its name in the bundle.
        reading: the workbook.
        checked: the same, checked.
        runs: the folders of the runs that go along.
    """
    return {
        "kind": KIND, "schema": SCHEMA, "workbook": workbook, "workbook_sha256": reading.digest,
        "title": checked.workbook.protocol.text("Title"), "robot": checked.robot.name,
        **here(),
        "runs": [_run(folder) for folder in sorted(runs, key=lambda p: p.name)],
    }  # fmt: skip


def here() -> dict[str, Any]:
    """Return the versions of the program, of Python, of what the program is built on, and the machine."""
    return {
        "program": __version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "dependencies": dependencies(),
    }


def dependencies() -> dict[str, str]:
    """Return the versions of what the program is built on, as installed here."""
    found: dict[str, str] = {}
    try:
        wanted = metadata.requires(_PROJECT) or []
    except metadata.PackageNotFoundError:
        return found
    for requirement in wanted:
        name = _NAME.match(requirement)
        if name is None or "extra ==" in requirement:
            continue
        try:
            found[name[0]] = metadata.version(name[0])
        except metadata.PackageNotFoundError:  # for another system
            continue
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
            words = N_("{name}: {there} there, {here} here")
            out.append(N_(words, name=name, there=there or N_("not known"), here=mine[part]))
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
