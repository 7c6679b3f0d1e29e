"""A browser for the tests of the pages."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from urllib.parse import quote

from flask import Flask
from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from rrp_sheets.web.app import create_app
from rrp_sheets.web.requests import cookie_name

TOKEN = "a-token-of-the-tests"
COOKIE = f"{cookie_name(TOKEN)}={TOKEN}"
"""What a browser on this computer has that was let in."""
HOME = "http://127.0.0.1:8000"
HEADER = "| Input streams | Connector | Formula | Output stream | On | Notes |\n|---|---|---|---|---|---|\n"
GOOD = "## Tracking\n" + HEADER + "| Red ball | subscribe | | Head tracker | | |\n"


def visit(folder: Path) -> FlaskClient:
    """A browser that was let in by a link."""
    return let_in(create_app(folder, TOKEN))


def let_in(app: Flask) -> FlaskClient:
    """A browser that was let in by a link of an application that was made with `TOKEN`."""
    client = app.test_client()
    for host in ("127.0.0.1", "localhost"):
        client.set_cookie(*COOKIE.split("="), domain=host)
    return client


def get(client: FlaskClient, address: str, **headers: str) -> TestResponse:
    return client.get(address, base_url=HOME, headers={k.replace("_", "-"): v for k, v in headers.items()})


def checked(client: FlaskClient, address: str) -> str:
    """A workbook's page when its first check has ended."""
    deadline = time.monotonic() + 300
    while "checking …" in (text := get(client, address).text):
        assert time.monotonic() < deadline, "the check does not end"
        threading.Event().wait(0.05)
    return text


def post(client: FlaskClient, address: str, **form: object) -> TestResponse:
    """Send a form as our own script does."""
    headers = {"X-RRP": "grid", "Origin": HOME}
    return client.post(address, base_url=HOME, headers=headers, data=form, content_type="multipart/form-data")


def book(name: str) -> str:
    return f"/book/{quote(name, safe='')}"
