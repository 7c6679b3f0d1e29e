"""Flask application: its blueprints, and the pages for errors."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

from flask import Flask
from jinja2 import StrictUndefined
from werkzeug.exceptions import HTTPException

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.web import security, statics
from rrp_sheets.web.models import MessagePage, RefusedPage, show
from rrp_sheets.web.security import Access, Lan, OneTimeTokens, UsedLink
from rrp_sheets.web.services import make_services, services
from rrp_sheets.web.views import (
    comparison,
    exports,
    gestures,
    help,
    login,
    lookback,
    printing,
    recordings,
    replay,
    run_deletion,
    run_panel,
    sheet,
    tabs,
    workbook_list,
)
from rrp_sheets.web.workbook_repository import printable

BLUEPRINTS = (
    workbook_list.blueprint, sheet.blueprint, tabs.blueprint, gestures.blueprint, run_panel.blueprint,
    recordings.blueprint, exports.blueprint, run_deletion.blueprint, lookback.blueprint, replay.blueprint,
    comparison.blueprint, printing.blueprint, help.blueprint,
)  # fmt: skip
"""Those of the views; with `--lan` that of `login` too."""
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
    app = Flask("rrp_sheets.web", template_folder=str(bundled("templates", "web")), static_folder=None)
    app.config["MAX_CONTENT_LENGTH"] = 8_000_000
    app.config["MAX_FORM_MEMORY_SIZE"] = 8_000_000
    app.jinja_env.undefined = StrictUndefined
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.jinja_env.globals["program"] = statics.build_id
    app.extensions["services"] = make_services(folder, CheckWorker())
    statics.init_app(app)
    security.init_app(app, Access(secret, lan, links or OneTimeTokens(), tell))
    for blueprint in BLUEPRINTS if lan is None else (*BLUEPRINTS, login.blueprint):
        app.register_blueprint(blueprint)
    app.register_error_handler(SheetsError, _show_refusal)
    app.register_error_handler(OSError, _show_system_error)
    app.register_error_handler(HTTPException, _show_http_error)
    return app


def _show_refusal(error: SheetsError) -> tuple[str, int]:
    return show(MessagePage("This cannot be shown", error.message, error.remedy, reload=True)), 422


def _show_system_error(error: OSError) -> tuple[str, int]:
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):
        why = f"The computer where the server runs cannot write: {error.strerror}."
        room = "Let it be written there" if error.errno == errno.EROFS else "Make room there"
        return show(MessagePage("This cannot be done now", why, f"{room}, and try it again.", reload=True)), 507
    path = Path(error.filename) if isinstance(error.filename, str) else None
    if path is None or not path.is_relative_to(services().repository.folder):
        raise error
    # a workbook or a run that another program has replaced or locked meanwhile
    why = f"“{printable(path.name)}” cannot be used as it is now: {error.strerror}."
    return show(MessagePage("This cannot be done now", why, "Look at the folder, and try it again.", reload=True)), 422


def _show_http_error(error: HTTPException) -> tuple[str, int]:
    code = error.code or 500
    if isinstance(error, UsedLink):
        return show(RefusedPage(*_USED)), code
    if code in _REFUSALS:
        return show(RefusedPage(*_REFUSALS[code])), code
    return show(MessagePage(*_MESSAGES.get(code, _MESSAGES[404 if code < 500 else 500]))), code
