"""Keyframes from the simulated robot: it takes a pose, and its joint angles become a row of the Gestures sheet."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.checks.check import robot_of
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Address, GestureRow
from rrp_sheets.robots import Joint, Robot
from rrp_sheets.robots.catalogue import SIDES, parse_angle
from rrp_sheets.runs.check_worker import read_and_check
from rrp_sheets.texts import N_, listed, os_reason, sentences
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.edits import AddSheet, Edit, InsertRows, SetCell, Value
from rrp_sheets.workbook.files import edit
from rrp_sheets.workbook.schema import GESTURES, language_of, recognise, title_of
from rrp_sheets.workbook.template import beginning, place_of

FIRST, BETWEEN = 1.0, 1.0  # s: the first keyframe's time, and between two, unless somebody says otherwise
PATIENCE_US = 15_000_000  # for the robot to take the pose
FRAME_US = 33_333
DIGITS = 2  # that an angle in rad is rounded to, within the joint's limits: half a degree


@dataclass(frozen=True)
class Posed:
    """A keyframe that was written.

    Attributes:
        address: of the row's first cell.
        at: s from the gesture's beginning.
        joints: the angles that stand in the row now, by the joint's name.
        added: the columns that were added for them.
        notes: what the robot could not do as asked.
    """

    address: Address
    at: float
    joints: Mapping[str, float]
    added: tuple[str, ...]
    notes: tuple[str, ...]
    report: Report
    language: str


def pose(
    path: Path, name: str, wanted: Sequence[str] = (), *, posture: str = "", at: float | None = None,
    picture: Path | None = None,
) -> Posed:  # fmt: skip
    """Let the simulated robot take a pose, and write its joints as a keyframe; see `api.pose`."""
    if not name.strip():
        raise SheetsError(N_("A gesture needs a name."), N_('Write one: --name "High five".'))
    reading = read(path)
    robot = robot_of(reading.workbook, Report())
    mine = [row for row in reading.workbook.gestures if key(row.name.text) == key(name)]
    asked = dict(_joint(text, robot) for text in wanted)
    if posture and key(posture) not in {key(p) for p in robot.postures}:
        guess = nearest(posture, robot.postures)
        known = N_("The postures are: {names}.", names=", ".join(robot.postures))
        remedy = N_("Did you mean {guess}?", guess=guess) if guess else known
        raise SheetsError(N_("There is no posture “{posture}”.", posture=posture), remedy)
    before = {} if posture else _angles_so_far(mine, robot, at)
    taken, notes = _take(robot, posture, {**before, **asked}, picture)
    joints = {j: _rounded(taken[j], robot.joints[key(j)]) for j in _written(robot, posture, before, asked)}
    if not joints:
        remedy = N_("Name joints, for example RShoulderPitch=-60°, or a posture with --posture.")
        raise SheetsError(N_("Nothing would be moved: no joint and no posture is named."), remedy)
    if at is None:
        at = max((time + BETWEEN for row in mine if (time := _seconds(row)) is not None), default=FIRST)
    edits, address, added = _edits(reading, robot, name, at, joints)
    edit(path, edits, expected_digest=reading.digest)
    _, checked = read_and_check(path)
    return Posed(address, at, joints, added, notes, checked.report, checked.run.language)


def _joint(text: str, robot: Robot) -> tuple[str, float]:
    name, found, value = text.partition("=")
    joint = robot.joints.get(key(name))
    if not found or joint is None:
        names = [j.name for j in robot.joints.values()]
        sides = [n for n in names if key(n)[1:] == key(name) and n[0] in SIDES]
        near = sides or [n for n in (nearest(name, names),) if n]
        example = f"{near[0]}=0.5" if near else "RShoulderPitch=-60°"
        guess = N_("Did you mean {guess}?", guess=listed(near, "or")) if near and joint is None else ""
        remedy = sentences(guess, N_("Write it like this: {example}", example=example))
        raise SheetsError(N_("“{text}” names no joint and its angle.", text=text), remedy)
    angle = parse_angle(value)
    if angle is None or (not joint.unit and "°" in value):
        message = N_("“{value}” is not an angle for {joint}.", value=value, joint=joint.name)
        raise SheetsError(message, N_("Write rad or degrees: {joint}=0.5", joint=joint.name))
    return joint.name, angle


def _seconds(row: GestureRow) -> float | None:
    us = parse_duration(row.time.text, bare="s")
    return None if us is None else us / 1e6


def _angles_so_far(rows: Sequence[GestureRow], robot: Robot, at: float | None) -> dict[str, float]:
    """Return a gesture's pose at its end or at a time: each joint's angle in the last keyframe that names it."""
    angles: dict[str, float] = {}
    for row in rows:
        time = _seconds(row)
        if time is not None and (at is None or time <= at):
            for k, cell in row.joints.items():
                angle = parse_angle(cell.text)
                if k in robot.joints and angle is not None:
                    angles[robot.joints[k].name] = angle
    return angles


def _written(robot: Robot, posture: str, before: Mapping[str, float], asked: Mapping[str, float]) -> list[str]:
    """Return the joints that the row contains: those of the gesture so far, those asked for, those of a posture."""
    start = robot.data["postures"][robot.data["robot"]["start_posture"]]
    named: Mapping[str, float] = next((a for p, a in robot.data["postures"].items() if key(p) == key(posture)), {})
    legs = {j for j in named if robot.data["chains"][robot.joints[key(j)].chain] == "legs"}
    stands = all(abs(named[j] - start[j]) <= 0.01 for j in legs)  # then the legs are left out
    chosen = {*before, *asked, *(named.keys() - legs if stands else named)}
    return [j.name for j in robot.joints.values() if j.name in chosen]


def _rounded(angle: float, joint: Joint) -> float:
    step = 10**-DIGITS
    low, high = math.ceil(joint.lower / step - 1e-6), math.floor(joint.upper / step + 1e-6)
    return float(min(max(round(angle / step), low), high) / round(1 / step))


def _take(
    robot: Robot, posture: str, angles: Mapping[str, float], picture: Path | None
) -> tuple[Mapping[str, float], tuple[str, ...]]:
    """Move the simulated robot into a pose; return its joint angles then, and notes on what it could not do."""
    from rrp_sheets.drivers.simulated import SimulatedWorld

    uses = [DeviceUse(f"joint {j}", j, "SetJointPosition", {"joint": j, "speed": 0.3}) for j in angles]
    orders = [Command(f"joint {j}", angle) for j, angle in angles.items()]
    if posture:
        uses.insert(0, DeviceUse("posture", "Posture", "Posture", {"name": posture}))
    world = SimulatedWorld(robot, (), uses, dones={f"{u.stream} done": u.stream for u in uses})
    notes: list[str] = []
    now = 0

    def until_done(commands: Sequence[Command]) -> None:
        nonlocal now
        left, end = len(commands), now + PATIENCE_US
        while left > 0 and now < end:
            now += FRAME_US
            arrived = world.advance(now, commands)
            commands = ()
            left -= len(arrived.events)
            notes.extend(h.text for h in arrived.notices if h.kind in ("clamp", "error"))

    try:
        world.start()
        if posture:
            until_done([Command("posture", True)])
        until_done(orders)
        if picture is not None:
            from PIL import Image

            Image.fromarray(world.watch()).save(picture)
        return world.state().joints, tuple(notes)
    except OSError as error:
        words = N_("The picture cannot be written ({reason}).", reason=os_reason(error))
        raise SheetsError(words, N_("Name another file.")) from None
    finally:
        world.stop()


def _edits(
    reading: Reading, robot: Robot, name: str, at: float, joints: Mapping[str, float]
) -> tuple[list[Edit], Address, tuple[str, ...]]:
    """Return the edits of the file, the address of the keyframe's row, and the names of the added columns."""
    found = next(((s, r) for s in reading.sheets if (r := recognise(s)).kind is GESTURES), None)
    cells: dict[str, Value] = {"name": name, "time(s)": at, **{key(j): a for j, a in joints.items()}}
    if found is None:
        known = {s.name: (s, recognise(s)) for s in reading.sheets}
        kinds = {sheet: what.kind.name if what.kind else "" for sheet, (_, what) in known.items()}
        heads = ((s, what) for s, what in known.values() if what.kind)
        language = language_of(s.cells[what.row, c].text for s, what in heads for c in what.columns.values())
        header = beginning("gestures", robot.name, language)[0]
        for own in (c.header(language) for c in GESTURES.required):
            cells[key(own)] = cells[key(GESTURES.spellings[key(own)])]
        added = tuple(j for j in joints if j not in header)
        header = [*header[:-1], *added, header[-1]]
        row = [str(cells[key(h)]) if key(h) in cells else "" for h in header]
        sheet = AddSheet(title_of("gestures", language), [header], before=place_of("gestures", kinds))
        fill = [SetCell(sheet.sheet, 2, c, cells[key(h)]) for c, h in enumerate(header, 1) if row[c - 1]]
        return [sheet, *fill], Address(sheet.sheet, 2, 1), ()
    raw, what = found
    columns = {key(n): c for n, c in what.columns.items()} | {key(h): c for c, h in what.others.items()}
    added = tuple(j for j in joints if key(j) not in columns)
    last = max(c for _, c in raw.cells)
    columns |= {key(j): last + n for n, j in enumerate(added, 1)}
    edits: list[Edit] = [SetCell(raw.name, what.row, columns[key(j)], j) for j in added]
    number, insert = _place(reading.workbook.gestures, raw.name, name, at, what.row)
    if insert:
        edits.append(InsertRows(raw.name, number))
    edits += [SetCell(raw.name, number, columns[k], value) for k, value in cells.items()]
    return edits, Address(raw.name, number, columns["name"]), added


def _place(rows: Sequence[GestureRow], sheet: str, name: str, at: float, header: int) -> tuple[int, bool]:
    """Return the number of the keyframe's row, and whether a row must be inserted there."""
    numbers = [row.name.address.row for row in rows if row.name.address.sheet == sheet]
    mine = [row for row in rows if key(row.name.text) == key(name) and row.name.address.sheet == sheet]
    for row in mine:
        time = _seconds(row)
        if time is not None and math.isclose(time, at, abs_tol=1e-6):
            return row.name.address.row, False
        if time is not None and time > at:
            return row.name.address.row, True
    after = mine[-1].name.address.row if mine else max(numbers, default=header)
    return after + 1, any(n > after for n in numbers)


def shown(joints: Mapping[str, float]) -> Iterator[str]:
    """Yield each joint with its angle as text, in rad and degrees; a hand has none of them."""
    for joint, angle in joints.items():
        yield f"{joint} {angle:g}" + ("" if joint.endswith("Hand") else f" ({math.degrees(angle):.0f}°)")
