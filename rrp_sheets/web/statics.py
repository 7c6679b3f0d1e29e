"""Static files, under addresses with the version, so that a browser requests each once; and security headers."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from html import escape
from io import BytesIO
from typing import Any

from flask import Flask, Response, send_file, send_from_directory

from rrp_sheets import __version__
from rrp_sheets.connectors import connectors
from rrp_sheets.render.svg import icon_elements
from rrp_sheets.resources import bundled, vendored

_A_YEAR = 365 * 86_400  # seconds


def init_app(app: Flask) -> None:
    """Add the route `/static/…`; `url_for("static", filename=…)` adds the version."""
    app.add_url_rule("/static/<path:filename>", "static", static)
    app.url_defaults(_add_version)


def static(filename: str) -> Response:
    """Send a static file of our own, or below `vendor/` one that the build has fetched."""
    name = plain_name(filename)
    max_age = _A_YEAR if name != filename else 0
    if name == "icons.svg":
        answer = send_file(BytesIO(icons()), "image/svg+xml", max_age=max_age, etag=build_id())
    else:
        folder = vendored() if name.startswith("vendor/") else bundled("templates", "web", "static")
        answer = send_from_directory(folder, name.removeprefix("vendor/"), max_age=max_age)
    answer.cache_control.immutable = name != filename
    return answer


@lru_cache(maxsize=1)
def icons() -> bytes:
    """Return the sheet of icons, with a symbol for each connector, those of other distributions too."""
    symbols = "".join(
        f'  <symbol id="i-{escape(name)}" viewBox="0 0 12 12" fill="none" stroke="currentColor" stroke-width=".95" '
        f'stroke-linecap="round" stroke-linejoin="round">{icon_elements(icon, "currentColor")}</symbol>\n'
        for name, icon in {c.name: c.icon for c in connectors()}.items()
    )
    sheet = bundled("templates", "web", "static", "icons.svg").read_text(encoding="utf-8")
    return (sheet.removesuffix("</svg>\n") + symbols + "</svg>\n").encode()


def _add_version(endpoint: str, values: dict[str, Any]) -> None:
    if endpoint == "static":
        values["filename"] = f"{build_id()}/{values['filename']}"


def plain_name(filename: str) -> str:
    """Return the name of a file without the version before it.

    >>> plain_name(f"{build_id()}/grid/main.js"), plain_name("grid/main.js")
    ('grid/main.js', 'grid/main.js')
    """
    return filename.removeprefix(f"{build_id()}/")


@lru_cache(maxsize=1)
def build_id() -> str:
    """Return a hash that differs between versions of the program, its templates and the scripts that it has fetched."""
    total = hashlib.sha256(__version__.encode() + icons())
    for folder in (bundled("templates", "web"), vendored("js")):
        for path in sorted(p for p in folder.rglob("*") if p.suffix in (".js", ".css", ".html", ".svg")):
            total.update(path.read_bytes())
    return total.hexdigest()[:16]


HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "media-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "same-origin",  # with less, browsers hide who sends a form
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
