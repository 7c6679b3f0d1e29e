"""Login with `--lan` by a name and the password; works without JavaScript."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, abort, g, redirect, request, url_for
from werkzeug.wrappers import Response as AnyResponse

from rrp_sheets.texts import N_, sentences
from rrp_sheets.web.models import show
from rrp_sheets.web.password import LONGEST
from rrp_sheets.web.requests import LONGEST_NAME, access, clean_name, inside

blueprint = Blueprint("login", __name__)
Answer = AnyResponse | tuple[str, int] | tuple[str, int, dict[str, str]]


@dataclass(frozen=True, slots=True)
class LoginPage:
    """Login form for who asked for the page `next`; `trouble` says why the last attempt failed."""

    template: ClassVar[str] = "login.html"
    longest: ClassVar[int] = LONGEST_NAME
    trouble: str = ""
    next: str = "/"
    name: str = ""


@blueprint.get("/login")
def page() -> AnyResponse | str:
    """Show the form, or go on to the page that was asked for."""
    if g.person is not None:
        return redirect(inside(request.args.get("next", "/")), 303)
    return show(LoginPage(next=inside(request.args.get("next", "/"))))


@blueprint.post("/login")
def enter() -> Answer:
    """Check the submitted name and password; open a session, or show the form again with the reason."""
    settings = access()
    assert settings.lan is not None, "without a password nobody logs in"
    name, given = clean_name(request.form.get("name", "")), request.form.get("password", "")
    place = inside(request.form.get("next", "/"))
    if not name:
        return show(
            LoginPage(
                N_("Type your name: other people in the same workbook see it at the cell that you work in."), place
            )
        ), 400
    address = request.remote_addr or ""
    with settings.lan.password.place() as free:
        wait = settings.throttle.begin(address) if free else 2
        fits = not wait and len(given) <= LONGEST and settings.lan.password.fits(given)
    if wait:
        why = N_("Too many wrong passwords came from here." if free else "Many log in at this moment.")
        words = sentences(why, N_("Wait {time}, then try again.", time=_waiting_time(wait)))
        return show(LoginPage(words, place, name)), 429, {"Retry-After": str(wait)}
    if not fits:
        settings.tell(N_("A wrong password came from {address}.", address=address))
        words = N_("This is not the password. Whoever started the server knows it.")
        return show(LoginPage(words, place, name)), 403
    settings.throttle.right(address)
    if g.person is not None:
        settings.sessions.close(g.person)
    secret, person = settings.sessions.open(name, address)
    settings.tell(N_("{name} has logged in from {address}.", name=person.name, address=address))
    response = redirect(place, 303)
    response.set_cookie(settings.cookie, secret, httponly=True, samesite="Strict")
    return response


@blueprint.post("/logout")
def leave() -> AnyResponse:
    """End the session."""
    if g.person is None:
        abort(403)
    access().sessions.close(g.person)
    response = redirect(url_for("login.page"), 303)
    response.delete_cookie(access().cookie, httponly=True, samesite="Strict")
    return response


def _waiting_time(seconds: int) -> str:
    """Format a waiting time.

    >>> _waiting_time(1), _waiting_time(8), _waiting_time(300)
    ('1 second', '8 seconds', '5 minutes')
    """
    if seconds >= 120:
        return N_("{n} minutes", n=-(-seconds // 60))
    return N_("{n} second" if seconds == 1 else "{n} seconds", n=seconds)
