"""Flask application: its blueprints, and the pages for errors."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flask import Flask
from flask.json.provider import DefaultJSONProvider
from jinja2 import StrictUndefined
from markupsafe import Markup
from werkzeug.exceptions import HTTPException

from rrp_sheets import page_texts
from rrp_sheets.errors import SheetsError
from rrp_sheets.page_texts import in_language
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_, listed
from rrp_sheets.web import requests, statics
from rrp_sheets.web.completions import in_browser
from rrp_sheets.web.models import MessagePage, RefusedPage, pieces, script_json, show
from rrp_sheets.web.requests import Access, Lan, OneTimeTokens, UsedLink, other_languages, page_language
from rrp_sheets.web.services import make_services, services
from rrp_sheets.web.views import (
    comparison,
    exports,
    gestures,
    help,
    lessons,
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
    comparison.blueprint, printing.blueprint, help.blueprint, lessons.blueprint,
)  # fmt: skip
"""Those of the views; with `--lan` that of `login` too."""
_NEW_LINK = N_("Go to the window where rrp-sheets serve runs and press Enter. Open the new link that it prints. If "
               "there is no such window, restart the server.")  # fmt: skip
_NOT_NOW = N_("This cannot be done now")
_REFUSALS = {
    400: (N_("This address does not lead here"),
          N_("The page was asked for under a name that is not this computer’s own."),
          N_("Use the link shown in the window of rrp-sheets serve.")),
    403: (N_("This browser needs a link first"),
          N_("Only a browser that was opened with a link can see these workbooks."), _NEW_LINK),
    405: (N_("This cannot be done here"), N_("This address does not take what was sent to it."), N_("Go back.")),
}  # fmt: skip
_USED = (
    N_("This link was already used"), N_("A link opens one browser, and it ends with a restart of the server."),
    _NEW_LINK,
)  # fmt: skip
_MESSAGES = {
    404: (N_("There is nothing here"), N_("What was here was renamed, moved or deleted, or the address is mistyped."),
          N_("Go to Workbooks and open it from there.")),
    413: (N_("That is too much at once"),
          N_("The server takes up to 8 MB, and workbooks up to 5 MB. Nothing was changed."),
          N_("Make it smaller: pictures in a workbook take most of the room.")),
    500: (N_("A fault of this program"),
          N_("The page could not be made, and the fault is not yours. Nothing was changed."),
          N_("The terminal where the server runs shows more. Please report it with the last lines there.")),
}  # fmt: skip


def create_app(
    folder: Path,
    secret: str,
    lan: Lan | None = None,
    *,
    links: OneTimeTokens | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Flask:
    """Create the application that shows the workbooks of a folder; the other arguments are those of `Access`."""
    app = Flask("rrp_sheets.web", template_folder=str(bundled("templates", "web")), static_folder=None)
    app.config["MAX_CONTENT_LENGTH"] = 8_000_000
    app.config["MAX_FORM_MEMORY_SIZE"] = 8_000_000
    app.jinja_env.undefined = StrictUndefined
    app.jinja_env.trim_blocks = app.jinja_env.lstrip_blocks = True
    app.jinja_env.globals["program"] = statics.build_id
    app.jinja_env.filters |= {"in_browser": in_browser, "listed": listed, "pieces": pieces}
    page_texts.install(app.jinja_env, lambda _: page_language())
    app.jinja_env.globals |= {
        "language": page_language, "other_languages": other_languages, "script_texts": _script_texts,
    }  # fmt: skip
    app.json = _Json(app)
    app.extensions["services"] = make_services(folder)
    statics.init_app(app)
    requests.init_app(app, Access(secret, lan, links or OneTimeTokens(), tell))
    for blueprint in BLUEPRINTS if lan is None else (*BLUEPRINTS, login.blueprint):
        app.register_blueprint(blueprint)
    app.register_error_handler(SheetsError, _show_refusal)
    app.register_error_handler(OSError, _show_system_error)
    app.register_error_handler(HTTPException, _show_http_error)
    return app


class _Json(DefaultJSONProvider):
    """JSON of answers and of the data in pages, in the language of the page."""

    def dumps(self, obj: Any, **kwargs: Any) -> str:
        """Format data as JSON, with its messages in the language of the page."""
        return super().dumps(in_language(obj, page_language()), **kwargs)


def _script_texts() -> Markup | None:
    """Return the translations that the scripts of a page take from it; None when it is English."""
    found = page_texts.script_texts(page_language())
    return script_json(found, "en") if found else None


def _show_refusal(error: SheetsError) -> tuple[str, int]:
    return show(MessagePage(N_("This cannot be shown"), error.message, error.remedy, reload=True)), 422


def _show_system_error(error: OSError) -> tuple[str, int]:
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS):
        why = N_("The computer where the server runs cannot write: {why}.", why=error.strerror)
        remedy = N_(
            "Let it be written there, and try it again."
            if error.errno == errno.EROFS
            else "Make room there, and try it again."
        )
        return show(MessagePage(_NOT_NOW, why, remedy, reload=True)), 507
    path = Path(error.filename) if isinstance(error.filename, str) else None
    if path is None or not path.is_relative_to(services().repository.folder):
        raise error
    # a workbook or a run that another program has replaced or locked meanwhile
    why = N_("“{name}” cannot be used as it is now: {why}.", name=printable(path.name), why=error.strerror)
    return show(MessagePage(_NOT_NOW, why, N_("Look at the folder, and try it again."), reload=True)), 422


def _show_http_error(error: HTTPException) -> tuple[str, int]:
    code = error.code or 500
    if isinstance(error, UsedLink):
        return show(RefusedPage(*_USED)), code
    if code in _REFUSALS:
        return show(RefusedPage(*_REFUSALS[code])), code
    return show(MessagePage(*_MESSAGES.get(code, _MESSAGES[404 if code < 500 else 500]))), code
