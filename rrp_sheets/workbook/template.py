"""The templates: a small behaviour that works with everything a protocol needs around it, and the same without rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook.files import already_there, make_workbook
from rrp_sheets.workbook.maker import Offers
from rrp_sheets.workbook.schema import (
    BEHAVIOUR,
    DEVICES,
    FIELDS,
    HELPERS,
    PROTOCOL,
    SCENE,
    SHEETS,
    TEST,
    TITLES,
    SheetKind,
)

_READ_ME = (
    "Your robot's protocol",
    "",
    "This workbook tells the robot what to do, one step a row. Try it out: nothing can harm the simulated robot.",
    "",
    "Begin with the sheet Tracking. Read its three rows from top to bottom:",
    "1.  Whenever the robot sees a red ball, its distance is worked out. The result is called Distance.",
    "2.  Only distances below half a metre go on. They are called Near.",
    "3.  Whenever there is a near ball, the head follows it.",
    "",
    "Try it: change 0.5 to 1 in the sheet Helpers, save the workbook, and look how the simulated robot changes.",
    "",
    "The sheets",
    "•  Tracking is a behaviour. A workbook may have several; the name of the sheet is the name of the behaviour.",
    "•  Devices names the robot's sensors and actuators, with their settings.",
    "•  Helpers keeps calculations and numbers that you use in several places.",
    "•  Scene is what happens in the simulator: when a ball appears, when somebody comes in.",
    "•  Check holds a test: values to send and what should come out; rrp-sheets test runs it.",
    "•  Protocol says what the session is for, who takes part and what is kept. Ethics boards ask for most fields.",
    "•  Risks is a sheet that you can add for an ethics board: what could go wrong. The program proposes rows for it.",
    "•  Lists holds the names for the drop-down lists. You may add sheets of your own, such as this one.",
    "",
    "Good to know",
    "•  Click on a cell: a note says what belongs there. A yellow cell holds a name that is not known.",
    "•  Capitals, spaces, hyphens and underscores in names make no difference: Red ball and red_ball are one name.",
    "•  Inside a formula a name is written without spaces: Red ball is redBall.",
    "•  To switch a row off, write FALSE into its column On. A row that begins with # is a comment.",
    "•  Before every session: rrp-sheets check shows what is wrong, and in which cell.",
)

_TRACKING = (
    ("Red ball", "map", "redBall.distance", "Distance", "how far the ball is from the robot, in metres"),
    ("Distance", "filter", "distance < reach", "Near", "reach is a number in the sheet Helpers"),
    ("Near", "subscribe", "", "Head tracker", "the head follows the ball"),
)
_SETTINGS = ("Mode", "Text", "Name", "Zone")  # of a tracker, of speech, of a gesture, of a touch
_DEVICES = (
    ("Red ball", "Red ball", "", "", "", "", "a red ball in the picture of the robot's camera"),
    ("Head tracker", "Tracker", "Head", "", "", "", "follows with the head only"),
)
_HELPERS = (("Reach", "", "0.5", "metres: nearer than this the head follows the ball"),)
_SCENE = (
    ("1", "Red ball", "appears", "at 1, 0, 0.4", "metres from the robot: forward, left, up"),
    ("3", "Red ball", "moves", "to 0.4, 0.1, 0.4 in 3 s", "comes near"),
    ("9", "Red ball", "disappears", "", ""),
)
_CHECK = (
    ("0", "Red ball", "distance=0.8", "", "too far away"),
    ("100", "Near", "", "nothing", ""),
    ("1000", "Red ball", "distance=0.3", "", ""),
    ("1000", "Near", "", "0.3", ""),
)
_FIRST_VALUES = {
    "Title": "My first protocol", "Version": "0.1", "Purpose": "The robot's head follows a red ball that is near.",
    "Data kept":
        "Every value with its time, pictures of the robot's camera, a film of the robot, and the sound of what it says",
    "Robot": "nao", "Engine": "frame", "Frame rate": "30", "Run": "Tracking", "Seed": "1", "Time limit": "10 min",
    "Face memory": "ends with the run", "Camera pictures": "kept", "Language": "English",
}  # fmt: skip
_HEADINGS = {
    "Investigators": "# The study", "Participants": "# The participants", "Data kept": "# Data",
    "Consent": "# Consent", "Participants are told": "# What a person does by hand", "Robot": "# How it runs",
}  # fmt: skip
"""The comments that stand above some fields of a new Protocol sheet."""


def _protocol(robot: str) -> list[tuple[str, str]]:
    """Every field in the order of the schema, with its first value, and the comments that group them."""
    rows = []
    for name in (field.name for field in FIELDS.values()):
        if name in _HEADINGS:
            rows.append((_HEADINGS[name], ""))
        rows.append((name, robot if name == "Robot" else _FIRST_VALUES.get(name, "")))
    return rows


def template_sheets(robot: str = "nao") -> dict[str, list[list[str]]]:
    """The rows of the guided template by sheet name."""
    return {
        "Read me": [[line] for line in _READ_ME], "Tracking": _filled(BEHAVIOUR, _TRACKING),
        "Devices": _filled(DEVICES, _DEVICES, _SETTINGS), "Helpers": _filled(HELPERS, _HELPERS),
        "Scene": _filled(SCENE, _SCENE), "Check": _filled(TEST, _CHECK),
        "Protocol": _filled(PROTOCOL, _protocol(robot)),
    }  # fmt: skip


def _filled(kind: SheetKind, rows: Sequence[Sequence[str]], others: Sequence[str] = ()) -> list[list[str]]:
    """Header and rows of a new sheet; what stands behind the required columns and the others is the notes."""
    header = kind.header(others)
    filled = [*(c.name for c in kind.required), *others, "Notes"]
    return [header, *([dict(zip(filled, row, strict=False)).get(h, "") for h in header] for row in rows)]


def empty_sheets(robot: str = "nao") -> dict[str, list[list[str]]]:
    """The same sheets with their columns only, for somebody who begins anew; the scene has a ball that comes and stays.

    No test: one without rows could not fail, and the check would say so.
    """
    guided = template_sheets(robot)
    mine = {"Title", "Purpose", "Data kept"}
    return {
        **{name: rows[:1] for name, rows in guided.items() if name not in ("Read me", "Check")},
        "Scene": guided["Scene"][:-1],
        "Protocol": [[field, "" if field in mine else value] for field, value in guided["Protocol"]],
    }


def new_workbook(
    path: Path | str, offers: Offers, *, robot: str = "nao", language: str = "en", empty: bool = False
) -> Path:
    """Make a new workbook from the guided template, or without rows; an existing file is never overwritten.

    Raises SheetsError when there is such a file, its name does not end in .xlsx, or it cannot be written.
    """
    path = Path(path)
    refuse_name(path)
    sheets = empty_sheets(robot) if empty else template_sheets(robot)
    for line in sheets["Protocol"]:
        if line[0] == "Title":
            line[1] = path.stem
    return make_workbook(sheets, path, offers, language=language, replace=False)


def refuse_name(path: Path) -> None:
    """Raise SheetsError when a new workbook cannot have this name: it is taken, or does not end in .xlsx."""
    if path.suffix.casefold() != ".xlsx":
        message = N_("A new workbook's name ends in .xlsx; “{name}” does not.", name=path.name)
        raise SheetsError(message, N_("Try “{name}”.", name=f"{path.stem}.xlsx"))
    if path.exists():
        raise already_there(path)


_JOINTS = (
    "HeadYaw", "HeadPitch", "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "RHand",
    "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand",
)  # fmt: skip


def beginning(kind: str, robot: str = "nao") -> list[list[str]]:
    """The rows that a new sheet of a kind has.

    >>> beginning("test")
    [['Time (ms)', 'Stream', 'Send', 'Expect', 'Notes']]
    """
    if kind == "table":
        return [["Name", "Value"]]
    others = {"devices": _SETTINGS, "gestures": _JOINTS}.get(kind, ())
    rows = empty_sheets(robot)["Protocol"][1:] if kind == "protocol" else []
    return [SHEETS[kind].header(others), *([field, "" if field == "Run" else value] for field, value in rows)]


def place_of(kind: str, sheets: Mapping[str, str]) -> str:
    """The sheet that a new one of a kind stands before; empty: at the end.

    `sheets` has all sheets in their order, with the kind of each; empty for the user's own.

    >>> place_of("behaviour", {"Read me": "", "Tracking": "behaviour", "Devices": "devices", "Lists": ""})
    'Devices'
    """
    order, names = list(TITLES), list(sheets)
    alike = [i for i, name in enumerate(names) if sheets[name] == kind]
    own = order.index(kind)
    ranks = {} if kind == "table" else {i: order.index(sheets[name]) for i, name in enumerate(names) if sheets[name]}
    before = [i for i, rank in ranks.items() if rank < own]
    if last := alike or before:
        return names[last[-1] + 1] if last[-1] + 1 < len(names) else ""
    return next((names[i] for i, rank in ranks.items() if rank > own), "")
