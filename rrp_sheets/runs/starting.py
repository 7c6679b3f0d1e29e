"""What is told when a run begins: all that a panel needs to know of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rrp_sheets.checks.facts import sensor_fact
from rrp_sheets.devices.catalogue import Robot
from rrp_sheets.engine.command_handler import buttons, label_of
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.engine.value_injector import OPEN_KINDS
from rrp_sheets.model.names import key
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Record, Value, show
from rrp_sheets.runs.view import RunStart

_STANDS = ("appear", "seen")  # verbs that bring a thing into the scene
Thing = tuple[str, str, tuple[float, float, float] | None]


def start_of(plan: Plan, scene: Sequence[SceneAction], until_us: int, folder: Path) -> RunStart:
    """What runs.

    Args:
        plan: the rows and devices.
        scene: what will happen in the world by itself.
        until_us: when the run ends by itself.
        folder: that it will leave.
    """
    checked = plan.checked
    workbook, robot = checked.workbook, checked.robot
    names = {b.key: b.name for b in checked.graph.behaviours}
    streams = {s.id: s for s in plan.streams}
    uses = {
        a.stream: tuple(sorted(d.type.resources_for(a.settings)))
        for a in plan.actuators
        if (d := streams[a.stream].device)
    }
    hfov, vfov = _camera(robot)
    return RunStart(
        title=workbook.protocol.text("Title") or Path(workbook.source).stem, until_us=until_us, folder=folder,
        findings=tuple(checked.report), streams={s.id: stream_label(s) for s in plan.streams},
        actuators={a.stream: a.name for a in plan.actuators}, rows=plan.rows_by_rank(),
        behaviours=tuple((names[b], b in plan.on) for b in plan.behaviours),
        sensors=tuple(
            (s.name, s.device.type.name if s.device else "", example_text(sensor_fact(s, robot).example))
            for s in plan.streams if s.kind in OPEN_KINDS
        ),
        buttons=tuple((use.name, label_of(use)) for use in buttons(plan.sensors)),
        things=_things(scene), hfov=hfov, vfov=vfov, resources=uses,
    )  # fmt: skip


def example_text(value: Value) -> str:
    """A value as one would write it to send it.

    >>> from rrp_sheets.model.values import record_from_mapping
    >>> example_text(record_from_mapping("Touch", {"pressed": True, "zone": "Head", "force": None})), example_text(0.5)
    ('pressed=TRUE; zone="Head"', '0.5')
    """
    if isinstance(value, Record):
        told = ((name, v) for name, v in value.as_dict().items() if v is not None)
        return "; ".join(f"{name}={example_text(v)}" for name, v in told)
    return '"' + value.replace('"', '""') + '"' if isinstance(value, str) else show(value)


def _camera(robot: Robot) -> tuple[float, float]:
    camera: Mapping[str, float] = robot.data.get("camera", {}).get("top", {})
    return float(camera.get("hfov", 0.0)), float(camera.get("vfov", 0.0))


def _things(scene: Sequence[SceneAction]) -> tuple[Thing, ...]:
    """The things that will be in the scene, each with where it is at the beginning if it is there by then."""
    found: dict[str, Thing] = {}
    for action in scene:
        if action.verb in _STANDS and key(action.thing) not in found:
            kind = action.what
            there = action.time_us == 0 and not action.cue and "at" in action.values
            found[key(action.thing)] = (action.thing, kind, _place(action.values["at"]) if there else None)
    return tuple(found.values())


def _place(at: Value) -> tuple[float, float, float]:
    x, y, *z = (float(c) for c in at)
    return x, y, z[0] if z else 0.0
