"""`rrp-sheets serve [FOLDER]`."""

from __future__ import annotations

import logging
import os
import secrets
import sys
import threading
import webbrowser
from pathlib import Path
from urllib.parse import quote

import click

from rrp_sheets.errors import SheetsError

_HOST = "127.0.0.1"
_THREADS = 34  # each open page keeps one (web/desk.py counts them), and the others are for requests


@click.command(name="serve")
@click.argument("folder", type=click.Path(path_type=Path), default=".")
@click.option("--port", type=click.IntRange(1, 65535), help="the port; without it a free one is taken")
@click.option("--no-browser", is_flag=True, help="only print the address, do not open a browser")
def command(folder: Path, port: int | None, no_browser: bool) -> None:
    """Edit the workbooks of FOLDER (by default this one) in the browser: a grid, its problems, the diagram, the words.

    Every edit is stored in the workbook's own file at once; Excel or LibreOffice may change it meanwhile. Several
    browser windows may be open on one workbook. FOLDER may also be a workbook, which is then opened at once.

    The address works only on this computer and only with the token in it; every start makes a new one.
    Ctrl-C ends the server.
    """
    from waitress import create_server

    from rrp_sheets.web.app import create_app

    folder, page = _place(folder)
    token = secrets.token_urlsafe(32)
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # a short wait is no news
    try:
        server = create_server(create_app(folder, token), host=_HOST, port=port or 0, threads=_THREADS, ident="")
    except OSError as error:
        why = error.strerror or "the system refuses it"
        raise SheetsError(f"The port {port} cannot be used: {why}.", "Choose another, or leave --port out.") from error
    url = f"http://{_HOST}:{server.effective_port}{page}?token={token}"
    click.echo(f"The workbooks of {folder.resolve()} are shown at\n\n  {url}\n\nCtrl-C ends it.")
    sys.stdout.flush()
    if not no_browser and _has_screen():
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()
    server.run()  # until Ctrl-C, which it takes quietly
    click.echo()


def _place(folder: Path) -> tuple[Path, str]:
    """The folder to serve, and the page to open first."""
    if folder.is_dir():
        return folder, "/"
    if folder.is_file():
        return folder.parent, f"/book/{quote(folder.name, safe='', errors='replace')}"
    raise SheetsError(f"There is no folder {folder}.", "Give a folder with workbooks, or one workbook.")


def _has_screen() -> bool:
    """Whether a browser can open a window; without one Linux would start a text browser in this terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
