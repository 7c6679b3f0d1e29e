"""What the cells of the other sheets may hold: settings of devices, what happens in a scene, fields of the Protocol."""

from __future__ import annotations

import math
from typing import Any

from rrp_sheets.checks.protocol import FORGETS, KEEPS, NOT_KEPT
from rrp_sheets.devices import Joint, Robot, Setting, robot_names
from rrp_sheets.devices.scene import BALL_COLOURS
from rrp_sheets.devices.scene_words import KINDS
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.topics.devices import described

Word = dict[str, str]
_EXPECTS = (
    ("any", "any value"), ("nothing", "no value since the row before"),
    ("nothing or blank", "no value but blanks, which stop an actuator"), ("≈0.5", "about this number, as it rounds"),
    (">0.5", "a condition; also <, <>, AND(value > 1; value < 2)"), ("blank", "a blank"),
)  # fmt: skip


def cell_words(workbook: Workbook, robot: Robot) -> dict[str, Any]:
    """The words for the cells of one workbook, as the grid's script wants them."""
    behaviours = [{"text": b.name} for b in workbook.behaviours]
    return {
        "takes": _takes(robot, workbook),
        "instead": _instead(robot),
        "joints": {key(j.name): _about(j) for j in robot.joints.values()},
        "gestures": [{"text": g.name, "help": g.help} for g in robot.motions.values()],
        "acts": _acts(robot, [d.settings["label"].text for d in workbook.devices if "label" in d.settings]),
        "expects": [{"text": text, "help": line} for text, line in _EXPECTS],
        "values": {
            "robot": [{"text": n} for n in robot_names()], "run": behaviours,
            "engine": [{"text": "frame", "help": "every frame takes all that has come: the same run every time"},
                       {"text": "event loop", "help": "each value at once, as it comes"}],
            "framerate": [{"text": n, "help": "frames a second"} for n in ("30", "60", "20", "15")],
            "seed": [{"text": "0", "help": "a whole number that PICK and the simulator draw by"}],
            "facememory": [{"text": FORGETS, "help": "what blank means"},
                           {"text": KEEPS, "help": "for the next runs too, in runs/faces.json"}],
            "camerapictures": [{"text": KEEPS, "help": "with the record of a run; what blank means"},
                               {"text": NOT_KEPT, "help": "no picture of the robot's camera is stored"}],
            "language": [{"text": "English", "help": "of explanations, diagrams and the printed protocol"},
                         {"text": "日本語", "help": "the same in Japanese"}],
            "timelimit": [{"text": t} for t in ("30 s", "90 s", "5 min", "10 min")],
        },
    }  # fmt: skip


def _takes(robot: Robot, workbook: Workbook) -> dict[str, dict[str, Any]]:
    """What each device takes, by the keys of the device's and the setting's names."""
    found = {}
    for name in robot.device_names("sensor") + robot.device_names("actuator"):
        device = robot.find(name)
        if device is not None:
            settings = {k: s for k, s in device.type.settings.items() if k not in device.preset}
            found[key(name)] = {
                k: {"name": s.name, "help": described(s), "choices": _choices(s, robot, workbook)}
                for k, s in settings.items()
            }
    return found


def _instead(robot: Robot) -> dict[str, dict[str, list[str]]]:
    """Which devices to use instead of one, by its key and that of a setting it has not."""
    known = {k for device in robot.devices.values() for k in device.settings}
    devices = [d for kind in ("sensor", "actuator") for n in robot.device_names(kind) if (d := robot.find(n))]
    by_type = {
        d.type.name: {k: [o.name for o in others] for k in known - set(d.type.settings)
                      if (others := robot.others_with(d, k))}
        for d in {d.type.name: d for d in devices}.values()  # what to use instead does not depend on its name
    }  # fmt: skip
    return {key(d.name): settings for d in devices if (settings := by_type[d.type.name])}


def _choices(setting: Setting, robot: Robot, workbook: Workbook) -> list[Word]:
    listed = {
        "joint": [*(j.name for j in robot.joints.values()), *robot.groups], "zone": robot.touch_zones,
        "posture": robot.postures, "gesture": robot.gestures, "colour": setting.choices or BALL_COLOURS,
        "language": robot.languages, "behaviour": [b.name for b in workbook.behaviours],
    }.get(setting.kind, setting.choices)  # fmt: skip
    return [{"text": c} for c in listed]


def _about(joint: Joint) -> Word:
    """What an angle of a joint may be, in a Gestures sheet."""
    if not joint.unit:
        limits = f"{joint.lower:g} (closed) to {joint.upper:g} (open)"
    else:
        low, high = (f"{a:.2f} ({math.degrees(a):.0f}°)" for a in (joint.lower, joint.upper))
        limits = f"{low} to {high} rad; 30° is fine"
    return {"name": joint.name, "help": f"{limits}. Blank: it is on its way to the next keyframe that has it."}


def _acts(robot: Robot, labels: list[str]) -> dict[str, list[Any]]:
    """What things can do, by their kind: each verb, with examples of its value and a line of help."""
    found: dict[str, list[Any]] = {
        kind.name: [
            [verb.name, [{"text": text, "help": line} for text, line in verb.examples if text]] for verb in kind.verbs
        ]
        for kind in KINDS.values()
    }
    own = {
        ("person", "touches"): [{"text": zone} for zone in robot.touch_zones],
        ("operator", "presses"): [{"text": label} for label in labels if label],
    }
    for (kind, verb), words in own.items():
        for entry in found[kind] if words else ():
            if entry[0] == verb:
                entry[1] = words
    return found
