"""Validation of requests: the JSON that a page sends, and the workbook that an address names."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any

from flask import abort, request
from werkzeug.exceptions import BadRequest

from rrp_sheets.web.collab.workbook_session import OpenWorkbooks, WorkbookSession
from rrp_sheets.web.workbook_repository import WorkbookRepository, refuse_text

Asked = dict[str, Any]
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")  # how JSON writes half a letter, which browsers do only for a lone one


def json_body() -> Asked:
    """Return the JSON object of the request; anything else is refused."""
    if not request.is_json:
        raise BadRequest
    try:
        sent = json.loads(request.get_data().decode())
    except (ValueError, RecursionError) as error:  # the latter: nested deeper than anything a page sends
        raise BadRequest from error
    if not isinstance(sent, dict) or (_HALF.search(request.get_data()) and not _is_text(sent)):
        raise BadRequest
    return sent


def _is_text(sent: Asked) -> bool:
    """Return whether all texts can be encoded as UTF-8, which lone surrogates cannot."""
    try:
        json.dumps(sent, ensure_ascii=False).encode()
    except UnicodeEncodeError:
        return False
    return True


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


RoomOf = Callable[[str], WorkbookSession]


def workbook_or_404(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> RoomOf:
    """Make the function that returns a workbook's session by name, or answers 404 if there is no such file.

    A Markdown file that is no workbook is refused with SheetsError.
    """

    def room_of(name: str) -> WorkbookSession:
        if not repository.has(name):
            abort(404)
        if not open_workbooks.has(name):  # one that is open may have lost its last sheet, which undo brings back
            refuse_text(repository, name)
        return open_workbooks.room(repository.path(name))

    return room_of
