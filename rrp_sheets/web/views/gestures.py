"""Routes for gestures in the grid: play one back, and write the robot's joint angles into a row."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flask import Blueprint, Response, abort, jsonify

from rrp_sheets.checks.check import robot_of
from rrp_sheets.diagnostics import Report
from rrp_sheets.documents import CellText, Changed, Document, Refused
from rrp_sheets.documents.grid import AddRows, Grid, PutTexts
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key
from rrp_sheets.robots import Robot
from rrp_sheets.robots.trajectory import Planner
from rrp_sheets.texts import N_
from rrp_sheets.web.requests import json_body, sender_of, text_of, workbook_or_404
from rrp_sheets.web.services import services

blueprint = Blueprint("gestures", __name__)
RATE = 30  # pictures a second
BETWEEN = 1.0  # s between a pose and the one before
DIGITS = 2  # of an angle, rad
Joints = Mapping[str, float]


@blueprint.get("/book/<name>/gesture/<sheet>/<row>")
def play(name: str, sheet: str, row: str) -> Response:
    """Send the joint angles of the gesture that a row belongs to, or a message why there are none."""
    session = workbook_or_404(name)
    grid = session.document.grids.get(sheet)
    if grid is None or grid.kind != "gestures" or not grid.has(row):
        abort(404)
    workbook, wanted = session.document.reading.workbook, key(_name(grid, row))
    robot = robot_of(workbook, Report())
    gesture = robot.motions.get(wanted)
    if not wanted or gesture is None or wanted not in {key(g.name.text) for g in workbook.gestures}:
        return jsonify({"message": N_("There is no gesture in this row yet: it needs a name, a time and an angle.")})
    home = {j.name: 0.0 for j in robot.joints.values()} | _start(robot)
    plan = Planner(robot, home, home).plan(gesture.timed())
    count = math.ceil(plan.length * RATE)
    frames = [{j: round(way.at(k / RATE)[0], 4) for j, way in plan.ways.items()} for k in range(count + 1)]
    return jsonify({
        "name": gesture.name, "rate": RATE, "seconds": round(plan.length, 2), "frames": frames,
        "times": [round(t, 2) for t in plan.times],
    })  # fmt: skip


@blueprint.post("/book/<name>/pose")
def pose(name: str) -> Response:
    """Write the joint angles of the robot that runs the workbook, or of its start posture, into a row."""
    session, given = workbook_or_404(name), json_body()
    tag, sheet, row = (text_of(given, field) for field in ("tag", "sheet", "row"))
    client, author = sender_of(session, given)
    joints = services().run_manager.joints(session)
    return jsonify(session.change(client, author, tag, lambda document: _pose(document, author, sheet, row, joints)))


def _name(grid: Grid, row: str) -> str:
    """Return the gesture that a row belongs to: its own name, or the next one above."""
    column = next((c.number for c in grid.columns if c.name == "Name"), 0)
    names = [grid.text(r, column).strip() for r in grid.rows[: grid.rows.index(row) + 1]]
    return next((name for name in reversed(names) if name), "")


def _start(robot: Robot) -> dict[str, float]:
    return {j: float(a) for j, a in robot.data["postures"][robot.data["robot"]["start_posture"]].items()}


def _pose(document: Document, author: str, sheet: str, row: str, joints: Joints) -> Changed:
    """Write the joints (those of the start posture when none are given) into the row, or into a new one below it."""
    grid = document.grids.get(sheet)
    if grid is None or grid.kind != "gestures" or not grid.has(row):
        raise Refused(N_("There is no such row any more."), N_("Reload the page."))
    robot = robot_of(document.reading.workbook, Report())
    angles = {key(j): a for j, a in (joints or _start(robot)).items()}
    columns = {c.number: angles[key(c.header)] for c in grid.columns if not c.name and key(c.header) in angles}
    if not columns:
        message = N_("No column of this sheet is a joint's.")
        raise Refused(message, N_("Add one, for example RShoulderPitch, and try again."))
    texts = {column: f"{round(angle, DIGITS) + 0.0:g}" for column, angle in columns.items()}
    named = {c.name: c.number for c in grid.columns if c.name}
    texts |= {named["Name"]: _name(grid, row) or "My gesture", named["Time (s)"]: f"{_next(grid, row, named):g}"}
    place = grid.rows.index(row) + 1
    below = grid.rows[place] if place < len(grid.rows) else None
    for at in (row, below):
        if at is not None and not any(text.strip() for text in grid.texts[at].values()):
            return document.together(author, [PutTexts(sheet, tuple(CellText(at, c, t, "") for c, t in texts.items()))])
    return document.together(author, [AddRows(sheet, ((grid.new_id(), texts),), below)])


def _next(grid: Grid, row: str, named: Mapping[str, int]) -> float:
    """Return the time in seconds for a new keyframe after this row."""
    mine, latest = key(_name(grid, row)), 0.0
    for each in grid.rows[: grid.rows.index(row) + 1]:
        us = parse_duration(grid.text(each, named["Time (s)"]), bare="s")
        if us is not None and key(grid.text(each, named["Name"])) == mine:
            latest = max(latest, us / 1e6)
    return latest + BETWEEN
