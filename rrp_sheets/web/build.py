"""Which program serves the pages: a page that another one has made loads itself again."""

from __future__ import annotations

import hashlib
from functools import lru_cache

from rrp_sheets import __version__
from rrp_sheets.resources import bundled


@lru_cache(maxsize=1)
def build_id() -> str:
    """What tells this program's pages from those of another version."""
    total = hashlib.sha256(__version__.encode())
    static = bundled("templates", "web")
    for path in sorted(p for p in static.rglob("*") if p.suffix in (".js", ".css", ".html", ".svg")):
        total.update(path.read_bytes())
    return total.hexdigest()[:16]
