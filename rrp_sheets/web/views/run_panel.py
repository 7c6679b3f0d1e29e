"""Routes of the run panel: start and stop a run, act on it, and get its sounds."""

from __future__ import annotations

import re
from collections.abc import Callable

from flask import Blueprint, Response, abort, jsonify, request, send_file, url_for
from werkzeug.exceptions import BadRequest

from rrp_sheets.errors import SheetsError
from rrp_sheets.recording.metadata import UNNAMED
from rrp_sheets.robots import robot_names
from rrp_sheets.runs.run_data import name_warning
from rrp_sheets.texts import N_, sentences
from rrp_sheets.web.models import error_text, show
from rrp_sheets.web.requests import (
    Asked,
    author_name,
    author_of,
    json_body,
    number_of,
    page_language,
    text_of,
    truth_of,
    visitor,
    workbook_or_404,
)
from rrp_sheets.web.robotmodel import face_picture, robot_json
from rrp_sheets.web.run_session import FOREVER, LONGEST_TEXTS, RobotBusy, RunOptions, RunSession
from rrp_sheets.web.services import services
from rrp_sheets.web.views.sheet import grid_page

blueprint = Blueprint("run_panel", __name__)

SPEEDS = (0.0, 0.5, 1.0, 2.0, 4.0)
REACH = 10.0  # m: how far a thing may be put from the robot
STARTED_MODES = ("simulated", "pilot")
_SOUND = re.compile(r"(say|sound|person)-\d{3,6}\.wav")


@blueprint.post("/run/stop")
def stop() -> tuple[Response, int]:
    """Stop the run, of whichever workbook it is; no workbook is opened, and no body read that could be refused."""
    run = services().run_manager.run
    if run is None:
        return jsonify({"message": N_("No run is in progress.")}), 409
    if run.is_going:  # else it has ended while Stop was pressed: nothing is wrong
        run.stop(author_name(request.args.get("name", "")))
    return jsonify({}), 200


@blueprint.get("/book/<name>/run")
@blueprint.get("/book/<name>/run/<sheet>")
def panel(name: str, sheet: str = "") -> str:
    """Show a sheet in the run panel; without a sheet, the first behaviour."""
    session = workbook_or_404(name)
    session.poll()
    sheet = session.document.current(sheet)
    if sheet and sheet not in session.document.grids:
        abort(404)
    return show(grid_page(session, name, sheet, live=True))


@blueprint.post("/book/<name>/run/start")
def start(name: str) -> tuple[Response, int]:
    """Start a run; with a participant's code that looks like a name only when it is sent as `sure` too."""
    session = workbook_or_404(name)
    sent = json_body()
    options = _options(sent)
    doubt = name_warning(options.participant)
    if doubt and text_of(sent, "sure") != options.participant:
        again = sentences(doubt, N_("Press Run again to use it all the same."))
        return jsonify({"message": again, "sure": options.participant}), 409
    try:
        services().run_manager.start(session, name, options)
    except RobotBusy as taken:
        where = url_for("run_panel.panel", name=taken.book)
        return jsonify({"message": error_text(taken), "book": taken.book, "where": where}), 409
    except SheetsError as error:
        return jsonify({"message": error_text(error)}), 409
    return jsonify({"where": url_for("run_panel.panel", name=name)}), 200


@blueprint.post("/book/<name>/run/<action>")
def act(name: str, action: str) -> tuple[Response, int]:
    """Act on the run of a workbook."""
    session, sent, run_manager = workbook_or_404(name), json_body(), services().run_manager
    if action not in (*_ACTIONS, "clear"):
        abort(404)
    if action == "clear":
        run_manager.clear(session)
        return jsonify({}), 200
    run = run_manager.going_run(session)
    if run is None:
        return jsonify({"message": N_("No run of this workbook is in progress.")}), 409
    _ACTIONS[action](run, author_of(sent), sent)
    return jsonify({}), 200


@blueprint.get("/run/now")
def now() -> Response:
    """Send the summary of the current run."""
    return jsonify(services().run_manager.now())


@blueprint.get("/run/sound/<file>")
def sound(file: str) -> Response:
    """Send a sound of the current run, or of the last one."""
    run = services().run_manager.run
    start = run.run_state.start if run is not None else None
    if start is None or not _SOUND.fullmatch(file) or not (start.folder / file).is_file():
        abort(404)
    return send_file(start.folder / file, mimetype="audio/wav", conditional=True)


@blueprint.get("/robot/model.json")
def model() -> Response:
    """Send the model of a robot, for the 3D view."""
    name = request.args.get("robot", "nao")
    text = robot_json(name if name in robot_names() else "nao", page_language())
    return Response(text, mimetype="application/json", headers={"Cache-Control": "max-age=3600", "Vary": "Cookie"})


@blueprint.get("/robot/face/<int:number>.png")
def face(number: int) -> Response:
    """Send a drawn face, for the heads of people in the 3D view."""
    picture = face_picture(number)
    if not picture:
        abort(404)
    return Response(picture, mimetype="image/png", headers={"Cache-Control": "max-age=3600"})


def _options(sent: Asked) -> RunOptions:
    mode = text_of(sent, "mode") or "simulated"
    if mode not in STARTED_MODES:
        raise BadRequest
    seconds = None if text_of(sent, "until") == "scene" else FOREVER
    labels = (text_of(sent, n, LONGEST_TEXTS["label"]).strip() for n in ("participant", "condition", "operator"))
    participant, condition, operator = labels
    speed = _speed(sent) if "speed" in sent else 1.0
    by = author_of(sent)
    return RunOptions(operator or by if by == UNNAMED else by, mode, participant, condition, operator, seconds, speed)


def _speed(sent: Asked) -> float:
    speed = number_of(sent, "speed", 0, 4)
    if speed not in SPEEDS:
        raise BadRequest
    return speed


def _press(run: RunSession, by: str, sent: Asked) -> None:
    label = text_of(sent, "label")
    start = run.run_state.start
    if start is None or label not in {button for _, button in start.buttons}:
        raise BadRequest
    run.process.command("press", by, label=label)


def _look(run: RunSession, by: str, sent: Asked) -> None:
    client = text_of(sent, "client", 40)
    if not run.session.is_of(client, visitor().key):  # a page of somebody else
        abort(403)
    run.look(client, wanted=truth_of(sent, "on"))


def _touch(run: RunSession, by: str, sent: Asked) -> None:
    step = text_of(sent, "step")
    if step not in ("once", "begin", "on", "end"):
        raise BadRequest
    run.process.command("touch", by, zone=text_of(sent, "zone", 40), step=step)


_ACTIONS: dict[str, Callable[[RunSession, str, Asked], None]] = {
    "restart": lambda run, by, sent: run.restart(by),
    "pause": lambda run, by, sent: run.process.command("pause", by),
    "resume": lambda run, by, sent: run.process.command("resume", by),
    "step": lambda run, by, sent: run.process.command("step", by),
    "speed": lambda run, by, sent: run.process.command("speed", by, factor=_speed(sent)),
    "mark": lambda run, by, sent: run.process.command("mark", by, note=text_of(sent, "note", LONGEST_TEXTS["note"])),
    "switch": lambda run, by, sent: run.process.command(
        "switch", by, behaviour=text_of(sent, "behaviour"), on=truth_of(sent, "on")
    ),
    "send": lambda run, by, sent: run.process.command(
        "send", by, stream=text_of(sent, "stream"), text=text_of(sent, "text", LONGEST_TEXTS["value"])
    ),
    "press": _press, "touch": _touch, "look": _look,
    "scene": lambda run, by, sent: run.process.command(
        "scene", by, thing=text_of(sent, "thing", 100), verb=text_of(sent, "verb", 40), value=text_of(sent, "value")
    ),
    "put": lambda run, by, sent: run.process.command(
        "put", by, at=tuple(number_of(sent, n, -REACH, REACH) for n in "xyz"), thing=text_of(sent, "thing", 100)
    ),
}  # fmt: skip
