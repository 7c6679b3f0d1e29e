"""The Scene sheet: what its rows mean (design: 5-robot, Scenes). Their words are in `scene_words`."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from rrp_sheets.devices.catalogue import Robot
from rrp_sheets.devices.scene_amounts import BadValueError
from rrp_sheets.devices.scene_kinds import Kind, Verb
from rrp_sheets.devices.scene_order import check_presence, in_order, scene_end_us
from rrp_sheets.devices.scene_pictures import check_pictures
from rrp_sheets.devices.scene_times import read_time
from rrp_sheets.devices.scene_values import read_value
from rrp_sheets.devices.scene_words import (
    COLOURS,
    KINDS,
    OPERATOR,
    PERSONS,
    find_verb,
    kind_of,
    known_things,
    thing_names,
    verb_names,
    verbs_of,
)  # fmt: skip
from rrp_sheets.diagnostics.phrase import Phrase, sentences
from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.durations import meant_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import SceneRow

__all__ = [
    "BALL_COLOURS", "OPERATOR", "PERSONS", "check_presses", "parse_scene", "scene_end_us", "thing_names", "verb_names",
    "verbs_of",
]  # fmt: skip
BALL_COLOURS = COLOURS
_ANY = "Write a thing such as Red ball, Blue cup, Table or Wall; Person, Child or a name; Light, Noise, or Operator."
_PROPOSES = 0.8  # how like a known thing a word must be to be taken for a typing mistake


def parse_scene(
    rows: Sequence[SceneRow], report: Report, robot: Robot, folder: Path | None = None
) -> tuple[SceneAction, ...]:
    """The actions of a Scene sheet, in the order of their times; what is not understood goes into the report.

    Rows that wait for an event come where they would if it came at once. Numbers may be ranges: a run draws them.

    Args:
        rows: as they stand in the sheet.
        report: takes the findings, each with its cell.
        robot: whose touch zones a touch may name.
        folder: of the workbook, where pictures are; None: they are not looked for.
    """
    found = [action for row in rows if (action := _action(row, report, robot)) is not None]
    cells = {row.thing.address.row: row for row in rows}
    actions = check_pictures(in_order(found), cells, folder, report)
    check_presence(actions, cells, report)
    return actions


def _action(row: SceneRow, report: Report, robot: Robot) -> SceneAction | None:
    when = read_time(row.time.text)
    if when is None:
        _tell_time(row.time, report)
    kind = _kind(row.thing, row.does, report)
    if kind is None:
        return None
    verb = _verb(kind[0], row.does, report)
    if verb is None:
        return None
    values = _values(*kind, verb, row, report)
    if values is None or (verb.action == "touch" and not _known_zone(row.value, values, row.does, report, robot)):
        return None
    if when is None:
        return None
    return SceneAction(
        when.us, row.thing.text, verb.action, values, row.thing.address.row, kind[0].name, when.cue, when.span_us
    )


def _tell_time(time: Cell, report: Report) -> None:
    meant = meant_duration(time.text, "s")
    remedy: str = Phrase("Write seconds from the start of the run, for example {value}.", value=meant or "2.5")
    if "+" in time.text:
        remedy = "Behind + write seconds: Ask done + 2."
    elif time.text and not meant:
        remedy = sentences(remedy, "Or a stream, and seconds after its event: Say done + 2.")
    report.add("SCENE001", time.address, text=time.text or "blank", remedy=remedy)


def _values(kind: Kind, colour: str, verb: Verb, row: SceneRow, report: Report) -> dict[str, Value] | None:
    try:
        return read_value(kind, verb, row.value.text, colour)
    except BadValueError as error:
        remedy = (
            Phrase("Write it like this: {example}.", example=verb.example) if verb.example else "Leave the cell blank."
        )
        report.add("SCENE004", row.value.address, text=row.value.text or "blank", does=row.does.text,
                   remedy=sentences(*error.args, remedy))  # fmt: skip
        return None


def check_presses(
    rows: Sequence[SceneRow], actions: Sequence[SceneAction], buttons: Sequence[str], report: Report
) -> None:
    """Warn of presses of buttons that the workbook does not have.

    Args:
        rows: as they stand in the sheet.
        actions: what was understood of them.
        buttons: the labels of the workbook's operator buttons.
        report: takes the findings.
    """
    cells = {row.value.address.row: row.value for row in rows}
    for action in actions:
        label = str(action.values.get("label", ""))
        if action.verb != "press" or key(label) in {key(b) for b in buttons}:
            continue
        near = nearest(label, buttons)
        remedy = (
            Phrase("Did you mean “{near}”?", near=near)
            if near
            else Phrase("The buttons are: {buttons}.", buttons=", ".join(buttons))
        )
        if not buttons:
            remedy = Phrase("Declare it in the sheet Devices: Device Operator button, Label “{label}”.", label=label)
        report.add("SCENE006", cells[action.row].address, label=label, remedy=remedy)


def _kind(thing: Cell, does: Cell, report: Report) -> tuple[Kind, str] | None:
    """The kind and colour of a thing; None when it is unknown (and told)."""
    text = thing.text.strip()
    found = kind_of(text)
    if found is not None:
        return KINDS[found[0]], found[1]
    person = KINDS["person"]
    near = _near(text)
    # Any other word is a person's name, when it does what persons do and is not a misspelt known thing.
    if near is None and text and text[0].isalpha() and not _is_thing(text) and find_verb(person, does.text) is not None:
        return person, ""
    near = near or _nearest_thing(text)
    remedy = Phrase("Did you mean “{near}”?", near=near) if near else _ANY
    report.add("SCENE002", thing.address, text=text or "blank", remedy=remedy)
    return None


def _is_thing(text: str) -> bool:
    """Whether a name ends as things do: `Left wall` is no person."""
    return "ball" in key(text) or key(text.rsplit(maxsplit=1)[-1]).rstrip("0123456789") in {*KINDS, "lamp"}


def _known_zone(value: Cell, values: dict[str, Value], does: Cell, report: Report, robot: Robot) -> bool:
    zones = {key(zone): zone for zone in robot.touch_zones}
    said = str(values["zone"])
    if key(said) in zones:
        return True
    near = nearest(said, robot.touch_zones)
    remedy = (
        Phrase("Did you mean “{near}”?", near=near)
        if near
        else Phrase("{title} feels a touch on: {names}.", title=robot.title, names=", ".join(robot.touch_zones))
    )
    report.add("SCENE004", value.address, text=value.text, does=does.text, remedy=remedy)
    return False


@lru_cache(maxsize=1024)
def _nearest_thing(text: str) -> str | None:
    return nearest(text, known_things())


def _near(text: str) -> str | None:
    close = _nearest_thing(text)
    if close is None:
        return None
    alike = difflib.SequenceMatcher(None, key(text), key(close)).ratio()
    return close if alike >= _PROPOSES else None


def _verb(kind: Kind, does: Cell, report: Report) -> Verb | None:
    verb = find_verb(kind, does.text)
    if verb is None:
        names = [verb.name for verb in kind.verbs]
        near = nearest(does.text, [n for v in kind.verbs for n in (v.name, *v.also)])
        remedy = (
            Phrase("Did you mean “{near}”?", near=near)
            if near
            else Phrase("It can do this: {names}.", names=", ".join(names))
        )
        report.add("SCENE003", does.address, text=does.text or "blank", kind=kind.name, remedy=remedy)
    return verb
