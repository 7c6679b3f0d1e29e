"""Who may see the pages: only a browser of this computer that was given the address with its token."""

from __future__ import annotations

import hashlib
import secrets

from flask import Flask, Response, abort, redirect, request, url_for
from werkzeug.wrappers import Response as AnyResponse

HOSTS = ["127.0.0.1", "localhost"]
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "media-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


def protect(app: Flask, token: str) -> None:
    """Let the app answer only whom it should, and never with more than it must."""
    cookie = cookie_name(token)
    app.config["TRUSTED_HOSTS"] = HOSTS

    @app.before_request
    def check() -> AnyResponse | None:
        _ = (
            request.host
        )  # raises SecurityError for a host that is not trusted: a foreign name that leads to this computer
        if _is_foreign() or (request.method not in ("GET", "HEAD") and not _is_ours()):
            abort(403)
        given = request.args.get("token")
        if given is not None and _same(given, token):
            place = url_for(request.endpoint, **(request.view_args or {})) if request.endpoint else url_for("shelf")
            response = redirect(place)
            response.set_cookie(cookie, token, httponly=True, samesite="Strict")
            return response
        if not _same(request.cookies.get(cookie, ""), token):
            abort(403)
        return None

    @app.after_request
    def add_headers(response: Response) -> Response:
        response.headers.update(HEADERS)
        if request.endpoint != "static" or response.status_code >= 400:
            response.headers["Cache-Control"] = "no-store"
        return response


def cookie_name(token: str) -> str:
    """A name of its own for every server: browsers share cookies between the ports of a host."""
    return f"rrp-sheets-{hashlib.sha256(token.encode()).hexdigest()[:8]}"


def _same(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode("utf-8", "replace"), token.encode())


def _is_ours() -> bool:
    """Whether a change is asked for by our own script: no form and no other site can send this header."""
    return request.headers.get("X-RRP") == "grid" and request.headers.get("Origin") == request.host_url.rstrip("/")


def _is_foreign() -> bool:
    """Whether another site's page asks, or that of another port of this computer; links may lead here."""
    origin = request.headers.get("Origin")
    if origin is not None and origin != request.host_url.rstrip("/"):
        return True
    headers = request.headers
    return headers.get("Sec-Fetch-Site") in {"cross-site", "same-site"} and headers.get("Sec-Fetch-Mode") != "navigate"
