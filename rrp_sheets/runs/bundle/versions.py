"""Versions recorded in a bundle, and their comparison with those of the machine where it runs."""

from __future__ import annotations

import platform
import re
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.runs.bundle import form
from rrp_sheets.runs.records.metadata import stamp_of
from rrp_sheets.workbook import Reading

_PROJECT = "rrp-sheets"
_NAME = re.compile(r"[A-Za-z0-9][\w.-]*")


def versions(workbook: str, reading: Reading, checked: Checked, runs: Sequence[Path]) -> dict[str, Any]:
    """Return everything that the list of a bundle contains, except the files.

    Args:
        workbook: its name in the bundle.
        reading: the workbook.
        checked: the same, checked.
        runs: the folders of the runs that go along.
    """
    return {
        "kind": form.KIND, "schema": form.SCHEMA, "workbook": workbook, "workbook_sha256": reading.digest,
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
    return {"folder": f"{form.RUNS}/{folder.name}", "workbook_sha256": told.digest, "program": told.program,
            "mode": told.mode, "seed": told.seed, "participant": told.participant, "condition": told.condition,
            "began": told.began}  # fmt: skip


def differences(told: Mapping[str, Any]) -> list[str]:
    """Return in words the versions that differ from those in a bundle's list, which is untrusted."""
    mine = here()
    out = []
    for part, name in (("program", "RRP Sheets"), ("python", "Python"), ("platform", "the system")):
        there = _text(told.get(part))
        if there != mine[part]:
            out.append(f"{name}: {there or 'not known'} there, {mine[part]} here")
    others = told.get("dependencies")
    if isinstance(others, Mapping):
        changed = [
            f"{name} {_text(others[name])} → {version}"
            for name, version in mine["dependencies"].items()
            if name in others and _text(others[name]) != version
        ]
        if changed:
            out.append(f"parts of the program: {', '.join(changed[:8])}{' …' if len(changed) > 8 else ''}")
    return out


def _text(value: object) -> str:
    return "".join(c for c in value if c.isprintable())[:60] if isinstance(value, str) else ""
