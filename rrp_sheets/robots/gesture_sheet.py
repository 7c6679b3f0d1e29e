"""The Gestures sheet: keyframes of the user's own gestures, and what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Cell, GestureRow
from rrp_sheets.robots.catalogue import Gesture, Joint, Keyframe, Robot, parse_angle
from rrp_sheets.robots.trajectory import JointLimits, Planner
from rrp_sheets.texts import N_, listed

LONGEST = 120.0  # s, of one gesture
MOST = 200  # keyframes of a gesture
NEARLY = 0.006  # rad: an angle was rounded, nothing else is wrong with it


@dataclass(frozen=True)
class _Line:
    row: GestureRow
    frame: Keyframe
    cells: Mapping[str, Cell]


def parse_gestures(rows: Sequence[GestureRow], robot: Robot, report: Report) -> tuple[Gesture, ...]:
    """The gestures of the sheet, by the order of their first rows; what is not understood goes into the report."""
    _tell_unknown_columns(rows, robot, report)
    groups: dict[str, list[GestureRow]] = {}
    for row in rows:
        if row.name:
            groups.setdefault(key(row.name.text), []).append(row)
    return tuple(found for group in groups.values() if (found := _read_gesture(group, robot, report)) is not None)


def _read_gesture(rows: Sequence[GestureRow], robot: Robot, report: Report) -> Gesture | None:
    lines: list[_Line] = []
    for row in rows[:MOST]:
        at = _time(row, lines[-1] if lines else None, report)
        angles, cells = _angles(row, robot, report)
        if at is not None:
            lines.append(_Line(row, Keyframe(at, angles), cells))
    if len(rows) > MOST:
        report.add("GEST007", rows[MOST].name.address, name=rows[0].name.text, limit=MOST)
    frames = tuple(line.frame for line in lines)
    if not any(frame.angles for frame in frames):
        return None
    _tell_limits(lines, robot, report)
    return Gesture(rows[0].name.text, frames, help=N_("a gesture of this workbook"))


def _time(row: GestureRow, before: _Line | None, report: Report) -> float | None:
    if not row.time:
        return None  # told when the sheet was read
    us = parse_duration(row.time.text, bare="s")
    if us is None or us > LONGEST * 1e6:
        meant = meant_duration(row.time.text, "s") or "1.5"
        report.add("GEST001", row.time.address, text=row.time.text, meant=meant, longest=f"{LONGEST:g}")
        return None
    if before is not None and us / 1e6 <= before.frame.at:
        last, later = f"{before.frame.at:g}", f"{before.frame.at + 1:g}"
        report.add("GEST002", row.time.address, name=row.name.text, text=row.time.text, before=last, later=later)
        return None
    return us / 1e6


def _angles(row: GestureRow, robot: Robot, report: Report) -> tuple[dict[str, float], dict[str, Cell]]:
    angles: dict[str, float] = {}
    cells: dict[str, Cell] = {}
    for k, cell in row.joints.items():
        joint = robot.joints.get(k)
        if joint is None:
            continue  # told once for the column
        angle = parse_angle(cell.text)
        if angle is None or (not joint.unit and "°" in cell.text):
            report.add("GEST004", cell.address, text=cell.text, joint=joint.name, wants=_wants(joint))
            continue
        angles[joint.name], cells[joint.name] = angle, cell
    return angles, cells


def _wants(joint: Joint) -> str:
    middle = (joint.lower + joint.upper) / 2
    if not joint.unit:
        return N_("a number from 0 (closed) to 1 (open)")
    rad, degrees = middle + 0.3, math.degrees(middle) + 20
    return N_("an angle such as {value:.1f} (rad) or {value2:.0f}°", value=rad, value2=degrees)


def _tell_unknown_columns(rows: Sequence[GestureRow], robot: Robot, report: Report) -> None:
    """Report columns that are no joint's and have something in them, each once at its first filled cell."""
    told: set[str] = set()
    names = [j.name for j in robot.joints.values()]
    for row in rows:
        for k, cell in row.joints.items():
            if k in robot.joints or k in told:
                continue
            told.add(k)
            header = row.headers.get(k, k)
            sides = [name for name in names if key(name)[1:] == k]
            near = listed(sides, "and") if sides else nearest(header, names)
            remedy = N_("The joints are: {names}.", names=", ".join(names))
            if sides:
                remedy = N_("Write a column for each side: {near}.", near=near)
            elif near:
                remedy = N_("Did you mean {near}? Then correct the header of this column.", near=near)
            report.add("GEST003", cell.address, header=header, remedy=remedy)


def _tell_limits(lines: Sequence[_Line], robot: Robot, report: Report) -> None:
    start = {j.name: 0.0 for j in robot.joints.values()} | robot.data["postures"][robot.data["robot"]["start_posture"]]
    plan = Planner(robot, start, start).plan([line.frame for line in lines])
    yaw, limits = start.get("HeadYaw", 0.0), JointLimits(robot)
    yaws = [yaw := line.frame.angles.get("HeadYaw", yaw) for line in lines]
    for c in plan.clamped:
        cell = lines[c.frame].cells.get(c.joint)
        if cell is not None and abs(c.wanted - c.given) > NEARLY:
            low, high = limits.of(c.joint, yaws[c.frame])
            turned = c.joint == "HeadPitch" and yaws[c.frame]
            unit = "°" if "°" in cell.text else robot.joints[key(c.joint)].unit
            most, least = _within(high, True, unit), _within(low, False, unit)
            upper = c.wanted > c.given
            report.add(
                "GEST005", cell.address, text=cell.text, joint=c.joint, low=least, high=most,
                nearest=N_("{angle} at most", angle=most) if upper else N_("{angle} at least", angle=least),
                when=N_(" while HeadYaw is at {shown}", shown=f"{math.degrees(yaws[c.frame]):.0f}°") if turned else "",
            )  # fmt: skip
    late = dict(reversed(plan.slowed))  # the first joint of each frame
    for frame, joint in late.items():
        if frame:
            longer = plan.times[frame] - plan.times[frame - 1]
            needs = f"{math.ceil((lines[frame - 1].frame.at + longer) * 10 + 0.1) / 10:g}"
            cell = lines[frame].row.time
            report.add("GEST006", cell.address, joint=joint, text=cell.text, needs=needs)


def _within(limit: float, upper: bool, unit: str) -> str:
    """A limit as the last angle within it that can be written, in the unit that was typed.

    >>> _within(2.0857, True, "rad"), _within(-0.6719, False, "°"), _within(1.0, True, "")
    ('2.08 rad', '-38°', '1')
    """
    value = math.degrees(limit) if unit == "°" else limit * 100
    whole = math.floor(value + 1e-9) if upper else math.ceil(value - 1e-9)
    return f"{whole}°" if unit == "°" else f"{whole / 100:g} {unit}".rstrip()
