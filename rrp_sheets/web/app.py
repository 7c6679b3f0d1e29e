"""Flask application: its routes, and the pages for errors."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

from flask import Flask, Response, abort, request
from jinja2 import StrictUndefined
from werkzeug.exceptions import HTTPException

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.runs.worker_process import CheckWorker
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks
from rrp_sheets.web.models import MessagePage, RefusedPage, show
from rrp_sheets.web.requests import workbook_or_404
from rrp_sheets.web.run.run_manager import RunManager
from rrp_sheets.web.security import Lan, OneTimeTokens, Sessions, UsedLink, cookie_name, init_app
from rrp_sheets.web.statics import build_id, serve_statics
from rrp_sheets.web.views.gestures import make_posing
from rrp_sheets.web.views.help import make_helping
from rrp_sheets.web.views.login import make_login
from rrp_sheets.web.views.recordings import make_records
from rrp_sheets.web.views.run_panel import make_live
from rrp_sheets.web.views.sheet import make_editing, picture
from rrp_sheets.web.views.tabs import make_sheeting
from rrp_sheets.web.views.workbook_list import make_shelving, shelf_page
from rrp_sheets.web.workbook_repository import WorkbookRepository, printable

_NEW_LINK = (
    "Go to the window where rrp-sheets serve runs and press Enter. Open the new link that it prints. If there is no "
    "such window, restart the server."
)
_REFUSALS = {
    400: ("This address does not lead here", "The page was asked for under a name that is not this computer’s own.",
          "Use the address that rrp-sheets serve has printed."),
    403: ("This browser needs a link first", "Only a browser that was opened with a link can see these workbooks.",
          _NEW_LINK),
    405: ("This cannot be done here", "This address does not take what was sent to it.", "Go back."),
}  # fmt: skip
_USED = (
    "This link was already used", "A link opens one browser, and it ends with a restart of the server.",
    _NEW_LINK,
)  # fmt: skip
_MESSAGES = {
    404: ("There is nothing here", "What was here was renamed, moved or deleted, or the address is mistyped.",
          "Go to the shelf and open it from there."),
    413: ("That is too much at once", "The server takes up to 8 MB, and workbooks up to 5 MB. Nothing was changed.",
          "Make it smaller: pictures in a workbook take most of the room."),
    500: ("A fault of this program", "The page could not be made, and the fault is not yours. Nothing was changed.",
          "The terminal where the server runs tells more. Please report it with the last lines there."),
}  # fmt: skip


def create_app(
    folder: Path,
    secret: str,
    lan: Lan | None = None,
    *,
    links: OneTimeTokens | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Flask:
    """Create the application that shows the workbooks of a folder.

    Args:
        folder: whose workbooks are shown.
        secret: what the cookie of a browser on this computer holds.
        lan: lets others in too, with a password.
        links: each lets one browser on this computer in.
        tell: called with one line for each login or wrong password.
    """
    templates = bundled("templates", "web")
    app = Flask("rrp_sheets.web", template_folder=str(templates), static_folder=None)
    serve_statics(app, templates / "static")
    app.config["MAX_CONTENT_LENGTH"] = 8_000_000
    app.config["MAX_FORM_MEMORY_SIZE"] = 8_000_000
    app.jinja_env.undefined = StrictUndefined
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.jinja_env.globals["known"] = lambda endpoint: endpoint in app.view_functions
    app.jinja_env.globals["program"] = build_id
    worker = CheckWorker()
    open_workbooks = OpenWorkbooks(folder, worker)
    repository = WorkbookRepository(folder, worker)
    sessions = Sessions()
    init_app(app, secret, lan, sessions, links or OneTimeTokens())
    if lan is not None:
        app.register_blueprint(make_login(lan, sessions, cookie_name(secret), tell))
    _answer_errors(app, folder)
    run_manager = RunManager(open_workbooks)
    app.extensions.update(
        going=run_manager.going, writing=run_manager.writing, forget=run_manager.forget, close=open_workbooks.close
    )
    app.register_blueprint(make_editing(repository, open_workbooks))
    app.register_blueprint(make_sheeting(repository, open_workbooks))
    app.register_blueprint(make_live(repository, open_workbooks, run_manager))
    app.register_blueprint(make_posing(repository, open_workbooks, run_manager.joints))
    app.register_blueprint(make_shelving(repository, open_workbooks))
    app.register_blueprint(make_records(repository, open_workbooks))
    app.register_blueprint(make_helping(workbook_or_404(repository, open_workbooks)))

    @app.get("/")
    def shelf() -> str:
        return show(shelf_page(repository, sort=request.args.get("sort", "")))

    @app.get("/book/<name>/diagram/<int:number>.svg")
    def diagram(name: str, number: int) -> Response:
        if not repository.has(name):
            abort(404)
        opened = repository.open(name)
        behaviours = opened.look.graph.behaviours
        if not 1 <= number <= len(behaviours):
            abort(404)
        return Response(picture(opened, behaviours[number - 1]), mimetype="image/svg+xml")

    return app


def _answer_errors(app: Flask, folder: Path) -> None:
    @app.errorhandler(SheetsError)
    def tell(error: SheetsError) -> tuple[str, int]:
        return show(MessagePage("This cannot be shown", error.message, error.remedy, reload=True)), 422

    @app.errorhandler(OSError)
    def no_room(error: OSError) -> tuple[str, int]:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):
            why = f"The computer where the server runs cannot write: {error.strerror}."
            room = "Let it be written there" if error.errno == errno.EROFS else "Make room there"
            return show(MessagePage("This cannot be done now", why, f"{room}, and try it again.", reload=True)), 507
        path = Path(error.filename) if isinstance(error.filename, str) else None
        if path is None or not path.is_relative_to(folder):
            raise error
        # a workbook or a run that another program has replaced or locked meanwhile
        why = f"“{printable(path.name)}” cannot be used as it is now: {error.strerror}."
        return show(
            MessagePage("This cannot be done now", why, "Look at the folder, and try it again.", reload=True)
        ), 422

    @app.errorhandler(HTTPException)
    def explain(error: HTTPException) -> tuple[str, int]:
        code = error.code or 500
        if isinstance(error, UsedLink):
            return show(RefusedPage(*_USED)), code
        if code in _REFUSALS:
            return show(RefusedPage(*_REFUSALS[code])), code
        return show(MessagePage(*_MESSAGES.get(code, _MESSAGES[404 if code < 500 else 500]))), code
