"""`rrp-sheets serve` and `tutorial`: the grid in the browser, links to it, and the password."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
import webbrowser
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

import click

from rrp_sheets.cli.language import readers_language, translated
from rrp_sheets.cli.main import handle_signals
from rrp_sheets.cli.terminal import say
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, sentences

if TYPE_CHECKING:
    from rrp_sheets.web.password import Password
    from rrp_sheets.web.requests import Lan

_HOST = "127.0.0.1"
_EVERYWHERE = ("0.0.0.0", "::")
_BACKGROUND_S = 1.0  # until it is looked again whether the keyboard can be read
_PASSWORD_FILE = "RRP_SHEETS_PASSWORD_FILE"


@click.command(name="serve")
@click.argument("folder", type=click.Path(path_type=Path), default=".")
@click.option("--port", type=click.IntRange(1, 65535), help="the port; without it a free one is taken")
@click.option("--lan", is_flag=True, help="let others of this network in, with a password")
@click.option("--no-browser", is_flag=True, help="only print the link, do not open a browser")
@click.option("--sign-out", is_flag=True, help="sign out every browser that has opened this folder before")
def serve_command(folder: Path, port: int | None, lan: bool, no_browser: bool, sign_out: bool) -> None:
    """Edit the workbooks of FOLDER (by default this one) in the browser.

    Every edit is saved in the workbook's own file at once, and Excel or LibreOffice may change the file too. You can
    open a workbook in several browser windows. If FOLDER is a workbook, it is opened at once.

    The link works only on this computer, and opens one browser. Press Enter for another link. A browser stays signed in
    when the server restarts, until it is closed or you use --sign-out. Ctrl-C ends the server.

    With --lan, others in the same network can join with a name and the password. You are asked for the password here
    (press Enter to get one), or it is the first line of the file that RRP_SHEETS_PASSWORD_FILE names.
    """
    from rrp_sheets.web.app import create_app
    from rrp_sheets.web.password import folder_secret
    from rrp_sheets.web.requests import OneTimeTokens
    from rrp_sheets.web.services import WORKER_MODULES
    from rrp_sheets.web.serving import bind, make_server, own_temp_folder, run
    from rrp_sheets.workers.worker_process import fork_workers

    folder, page = _place(folder)
    door = _ask_password() if lan else None
    links = OneTimeTokens()
    tell = partial(say, err=True)
    secret, why_not = folder_secret(folder, renew=sign_out)
    if why_not:
        tell(N_("After a restart of the server, open a new link: {reason}.", reason=why_not))
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # a short wait is no news
    handle_signals(signal.default_int_handler, "SIGTERM", "SIGHUP")  # they end the server as Ctrl-C does
    with own_temp_folder():
        sockets = bind(_EVERYWHERE if door else (_HOST,), port)
        used = int(sockets[0].getsockname()[1])

        def link() -> str:
            return f"http://{_HOST}:{used}{page}?token={links.new()}"

        if door is None:
            server = make_server(create_app(folder, secret, links=links), sockets)
            say(N_("The workbooks of {folder} are shown at", folder=folder.resolve()))
            click.echo(f"\n  {link()}\n")
        else:
            password, made = door
            reached = _reached(password, both=len(sockets) > 1)
            server = make_server(create_app(folder, secret, reached, links=links, tell=tell), sockets)
            _print_lan(folder, link(), used, page, reached, made)
        enter = N_("Press Enter for another link.") if _offer_links(link) else ""
        say(sentences(N_("The link opens one browser on this computer."), enter, N_("Ctrl-C ends it.")))
        sys.stdout.flush()
        fork_workers(WORKER_MODULES)
        if not no_browser and _has_screen():
            # a link of its own: others on this computer can see which address a program was started with
            threading.Thread(target=webbrowser.open, args=(link(),), daemon=True).start()
        run(server)
    click.echo()


def _offer_links(link: Callable[[], str]) -> bool:
    """Print a new link whenever Enter is pressed; False where there is no terminal."""
    try:
        keyboard = sys.stdin.fileno()
        if not os.isatty(keyboard):
            return False
    except (AttributeError, OSError, ValueError):  # closed, or not there at all
        return False
    handle_signals(signal.SIG_IGN, "SIGTTIN")  # else the server would stand still in the background of a shell

    def listen() -> None:
        while True:
            try:
                if not os.read(keyboard, 1_000):  # not through sys.stdin, whose lock an exit of the program wants
                    return
            except OSError:  # in the background
                time.sleep(_BACKGROUND_S)
                continue
            click.echo(f"  {link()}\n")

    threading.Thread(target=listen, daemon=True).start()
    return True


def _place(folder: Path) -> tuple[Path, str]:
    if folder.is_dir():
        return folder, "/"
    if folder.is_file():
        return folder.parent, f"/book/{quote(folder.name, safe='', errors='replace')}"
    remedy = N_("Give a folder with workbooks, or one workbook.")
    raise SheetsError(N_("There is no folder {folder}.", folder=folder), remedy)


def _ask_password() -> tuple[Password, str]:
    """The password for everyone, and its text if the program has made it; never from the command line."""
    from rrp_sheets.web.password import Password, invent

    text = _from_file()
    if not text and sys.stdin.isatty():
        words = translated(N_("A password for everyone (Enter alone: one is made for you)"))
        again = translated(N_("The password again"))
        while text := click.prompt(words, default="", show_default=False, hide_input=True, err=True):
            try:
                password = Password(text)
            except SheetsError as error:
                say(sentences(error.message, error.remedy), err=True)
                continue
            if password.fits(click.prompt(again, default="", show_default=False, hide_input=True, err=True)):
                return password, ""
            say(N_("The passwords are different. Try again."), err=True)
    if text:
        return Password(text), ""
    text = invent()
    return Password(text), text


def _from_file() -> str:
    name = os.environ.get(_PASSWORD_FILE, "")
    if not name:
        return ""
    path = Path(name)
    try:
        text = path.read_text(encoding="utf-8").partition("\n")[0].strip()
        if os.name == "posix" and path.stat().st_mode & 0o077:
            say(
                N_("Other users of this computer can read {path}. Only you should: chmod 600 {path}", path=path),
                err=True,
            )
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or N_("it is no text")
        message = N_("The password cannot be read from {name}: {why}.", name=name, why=why)
        raise SheetsError(message, N_("Look at {variable}, or unset it.", variable=_PASSWORD_FILE)) from error
    if not text:
        raise SheetsError(N_("The first line of {name} is empty.", name=name), N_("Write the password there."))
    return text


def _reached(password: Password, *, both: bool) -> Lan:
    from rrp_sheets.web.requests import Lan
    from rrp_sheets.web.serving import own_addresses, own_name

    addresses = [address for address in own_addresses() if both or ":" not in address]
    return Lan(password, tuple(name for name in (*addresses, own_name()) if name))


def _print_lan(folder: Path, url: str, port: int, page: str, lan: Lan, made: str) -> None:
    from rrp_sheets.web.serving import address_of

    def block(text: str, *lines: str) -> None:
        say(text)
        click.echo("".join(["\n", *(f"  {line}\n" for line in lines), "\n" if lines else ""]), nl=False)

    block(N_("The workbooks of {folder} are open to others of this network.", folder=folder.resolve()))
    block(N_("On this computer, without a password:"), url)
    if lan.hosts:
        there = [f"{address_of(host, port)}{page.removeprefix('/')}" for host in lan.hosts]
        block(N_("On others of the same network, type one of these into the browser:"), *there)
    else:
        block(N_("This computer is not in a network, so nobody else can join. Connect to one, and start again."))
    shown = N_("The password for everyone, shown only now: {password}", password=made)
    said = shown if made else N_("Everyone needs your password.")
    say(sentences(said, N_("Each person also enters a name, which the others see.")))
    block(N_(
        "The connection is not encrypted: whoever can listen in this network can read along and take over. Use only a "
        "network whose people you trust, never an open one such as a guest or café network. When the server ends, "
        "everyone has to log in again."
    ))  # fmt: skip


def _has_screen() -> bool:
    """Return whether a browser can open a window; without one Linux would start a text browser in this terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@click.command(name="tutorial")
@click.argument("folder", type=click.Path(path_type=Path), default=".")
@click.option("--anew", is_flag=True, help="start over with a new copy; the existing one is not changed")
@click.option("--port", type=click.IntRange(1, 65535), help="the port; without it a free one is taken")
@click.option("--no-browser", is_flag=True, help="only print the link, do not open a browser")
@click.pass_context
def tutorial_command(ctx: click.Context, folder: Path, anew: bool, port: int | None, no_browser: bool) -> None:
    """Learn in ten short lessons how the rows of a table control a robot.

    This creates tutorial.xlsx in FOLDER (by default this one) and opens it in the browser, as `rrp-sheets serve` does.
    Each lesson has a test that turns green when it is done. If there is a tutorial in FOLDER already, you continue with
    it.

    Ctrl-C ends the server. Your work is saved in the file.
    """
    from rrp_sheets.documents.copies import begin_tutorial, latest_tutorial

    if not folder.is_dir():
        raise SheetsError(N_("There is no folder {folder}.", folder=folder), N_("Make it first, or name another."))
    there = None if anew else latest_tutorial(folder)
    path = there or begin_tutorial(folder, readers_language() or "en")
    again = N_("Continuing with {path}. To start over with a new copy: --anew", path=path)
    say(again if there else N_("Created {path}.", path=path))
    ctx.invoke(serve_command, folder=path, port=port, lan=False, no_browser=no_browser)
