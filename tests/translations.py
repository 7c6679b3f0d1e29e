"""Brings the catalogues of `rrp_sheets/locale/` up to date with the texts of the program (`make texts`)."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.pofile import read_po, write_po

from rrp_sheets.diagnostics import CODES
from rrp_sheets.graph.device_table import COLOURS
from rrp_sheets.render.texts import texts
from rrp_sheets.robots.catalogue import Robot, load_robot, robot_names
from rrp_sheets.texts import LANGUAGES

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
from hatch_build import CATALOGUES, compile_texts  # noqa: E402

MARKS = ("N_", "BadSoundError", "BadValueError", "CatalogueError")
"""Names of the function and the classes whose first argument is a text of the program."""
_CREATED = datetime(2026, 1, 1, tzinfo=UTC)  # no date that would change every file


def extract() -> Catalog:
    """Return a catalogue of all texts of the program, without translations."""
    found = _catalogue(None)
    for path in sorted((ROOT / "rrp_sheets").rglob("*.py")):
        for text in _marked(path):
            found.add(text)
    for code in CODES.values():
        for part in ("title", "message", "remedy"):
            if getattr(code, part) != "{remedy}":  # which the finding brings
                found.add(getattr(code, part), context=f"{code.id}.{part}")
    for name, text in texts("en").entries.items():
        if text:
            found.add(text, context=name)
    for name in robot_names():
        for text, context in _robot_texts(load_robot(name)):
            if text:
                found.add(text, context=context)
    return found


def _robot_texts(robot: Robot) -> Iterator[tuple[str, str | None]]:
    for device in robot.devices.values():
        for part in ("title", "help", "says", "takes", "stops"):
            yield getattr(device, part), f"{device.name}.{part}"
        for field in device.payload.fields if device.payload else ():
            yield field.name.replace("_", " "), f"{device.name}.{field.name}"
            yield field.help, f"{device.name}.{field.name}"
        for setting in device.settings.values():
            yield setting.name, "setting"
            yield from ((choice, "value") for choice in setting.choices)
            yield setting.unit if " " in setting.unit else "", "value"  # the others are symbols
    yield from ((resource, None) for device in robot.devices.values() for resource in device.resources)
    yield from ((word, "value") for word in (*robot.touch_zones, *robot.languages.values(), *COLOURS, "TRUE", "FALSE"))
    yield from ((name, "posture") for name in (*robot.postures, *robot.gestures))


def _catalogue(language: str | None) -> Catalog:
    return Catalog(
        language, project="RRP Sheets", version="1", header_comment="# Texts of RRP Sheets.", fuzzy=False,
        msgid_bugs_address="the issues of the repository", last_translator="The RRP Sheets authors",
        language_team="The RRP Sheets authors", creation_date=_CREATED, revision_date=_CREATED,
    )  # fmt: skip


def _marked(path: Path) -> Iterator[str]:
    for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in MARKS and call.args:
            yield from _texts(call.args[0])


def _texts(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.IfExp):
        yield from _texts(node.body)
        yield from _texts(node.orelse)
    elif isinstance(node, ast.Constant):
        yield node.value
    elif isinstance(node, ast.JoinedStr):
        raise ValueError(f"A marked text must be no f-string: {ast.unparse(node)}")


def update(path: Path, language: str) -> None:
    """Renew a language's catalogue, or begin it."""
    catalogue = _catalogue(language)
    if path.exists():
        with path.open("rb") as file:
            catalogue = read_po(file, locale=language)
    catalogue.update(extract(), no_fuzzy_matching=True, update_creation_date=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        write_po(file, catalogue, width=0, no_location=True, sort_output=True, ignore_obsolete=True)


if __name__ == "__main__":
    for language in LANGUAGES:
        if language != "en":
            update(ROOT / CATALOGUES.replace("*", language), language)
    compile_texts(ROOT)
