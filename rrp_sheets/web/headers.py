"""The headers that every answer bears: nothing from elsewhere, no inline script or style, no frame, nothing kept."""

from __future__ import annotations

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
