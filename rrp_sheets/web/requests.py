"""Validation of requests: the JSON that a page sends, its author, and the workbook or run that an address names."""

from __future__ import annotations

import json
import re
from typing import Any

from flask import Response, abort, has_request_context, request
from werkzeug.exceptions import BadRequest

from rrp_sheets.documents import Document
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.web.models import SOMEBODY
from rrp_sheets.web.security import author_name, visitor
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import refuse_text
from rrp_sheets.web.workbook_session import WorkbookSession

Asked = dict[str, Any]
PAGE_LANGUAGES: tuple[str, ...] = ("en",)
"""Languages of pages; one with a catalogue stands here once rows, JSON answers, events and help are in it too."""
_MOST_ROWS = 200  # that marbles are asked for
_WORD = re.compile("[0-9a-f]{16}")
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")  # how JSON writes half a letter, which browsers do only for a lone one


def page_language() -> str:
    """Return the code of the language of the page that is asked for: the browser's choice among `PAGE_LANGUAGES`."""
    if len(PAGE_LANGUAGES) == 1 or not has_request_context():
        return "en"
    return request.accept_languages.best_match(PAGE_LANGUAGES, default="en")


def json_body() -> Asked:
    """Return the JSON object of the request; anything else is refused."""
    if not request.is_json:
        raise BadRequest
    try:
        sent = json.loads(request.get_data().decode())
    except (ValueError, RecursionError) as error:  # the latter: nested deeper than anything a page sends
        raise BadRequest from error
    if not isinstance(sent, dict):
        raise BadRequest
    if _HALF.search(request.get_data()):
        try:
            json.dumps(sent, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:  # a lone surrogate
            raise BadRequest from error
    return sent


def text_of(sent: Asked, name: str, longest: int = 200) -> str:
    """Return a text field; empty when it is missing, refused when it is no text or too long."""
    value = sent.get(name, "")
    if not isinstance(value, str) or len(value) > longest:
        raise BadRequest
    return value


def number_of(sent: Asked, name: str, low: float, high: float) -> float:
    """Return a number field; refused unless it is between two limits."""
    value = sent.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise BadRequest
    return float(value)


def truth_of(sent: Asked, name: str) -> bool:
    """Return a boolean field; anything else is refused."""
    value = sent.get(name)
    if not isinstance(value, bool):
        raise BadRequest
    return value


def sender_of(session: WorkbookSession, sent: Asked) -> tuple[str, str]:
    """Return the page that sends a request, and its author; refused when the page belongs to another login."""
    client = text_of(sent, "client")
    author = author_of(sent, client)
    if not session.is_of(client, visitor().key):  # nobody moves another's cursor, nor opens what another is editing
        abort(403)
    return client, author


def author_of(sent: Asked, unnamed: str = SOMEBODY) -> str:
    """Return the author of a request: the name given at login, else the one on the page, else `unnamed`."""
    return author_name(text_of(sent, "name"), unnamed)


def workbook_or_404(name: str) -> WorkbookSession:
    """Return a workbook's session; answer 404 if there is no such file, raise SheetsError if it is none."""
    repository, open_workbooks = services().repository, services().open_workbooks
    if session := open_workbooks.find(name):  # which may have lost its last sheet: undo brings it back
        return session
    if not repository.has(name):
        abort(404)
    refuse_text(repository, name)
    return open_workbooks.session(repository.path(name))


def sheet_or_404(document: Document, sheet: str) -> str:
    """Return the present name of a sheet that a page names; answer 404 when there is none."""
    sheet = document.current(sheet)
    if sheet not in document.grids and sheet not in document.own:
        abort(404)
    return sheet


def run_or_404(run: str) -> str:
    """Return the name of a recorded run; answer 404 if there is none of that name."""
    if run not in services().runs.names():
        abort(404)
    return run


def rows_asked() -> list[int]:
    """Return the numbers of the rows that the address names, up to a limit."""
    return [int(r) for r in request.args.getlist("row") if r.isdecimal() and len(r) < 7][:_MOST_ROWS]


def seconds_of(text: str) -> float | None:
    """Parse a time in seconds; None for a blank text."""
    if not text.strip():
        return None
    try:
        value = float(text.replace(",", ".").removesuffix("s"))
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e8:
        raise SheetsError(N_("“{text}” is no time in seconds.", text=text), N_("Write a number, such as 12.5."))
    return value


def confirm_download(answer: Response) -> Response:
    """Set a cookie that tells the page that the file it requested has arrived."""
    word = request.args.get("made", "")
    if _WORD.fullmatch(word):
        answer.set_cookie(f"made-{word}", "1", max_age=60, samesite="Strict", path="/")
    return answer
