"""Paths of the bundled folders `templates`, `robots` and `workbooks`, and of what the build fetched.

In a wheel they lie under `rrp_sheets/_bundled/`; in a clone they are at the top of the repository.
"""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parent


def bundled(*parts: str) -> Path:
    """Return the path of a bundled file or folder.

    >>> bundled("robots", "nao").name
    'nao'
    """
    inside = _PACKAGE / "_bundled"
    root = inside if inside.is_dir() else _PACKAGE.parent
    return root.joinpath(*parts)


def vendored(*parts: str) -> Path:
    """Return the path of what the build hook fetches (fonts, scripts); a build without network lacks it.

    >>> vendored("fonts").parent.name
    '_vendor'
    """
    return _PACKAGE.joinpath("_vendor", *parts)
