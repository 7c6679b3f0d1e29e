"""Authentication of browsers on this computer: a secret for each folder's server, and links for one use."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import sys
import tempfile
import threading
from collections import deque
from pathlib import Path

_MOST_LINKS = 50  # that nobody has used yet; the oldest is no longer good then
_SECRET = re.compile(r"[\w-]{43}")


class Links:
    """Tokens of links that work for one browser each. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._unused: deque[str] = deque(maxlen=_MOST_LINKS)

    def new(self) -> str:
        """Create a token for another link."""
        token = secrets.token_urlsafe(32)
        with self._lock:
            self._unused.append(token)
        return token

    def use(self, given: str) -> bool:
        """Return whether this is the token of an unused link, and mark it as used."""
        with self._lock:
            found = [token for token in self._unused if is_same(given, token)]
            for token in found:
                self._unused.remove(token)
        return bool(found)


def is_same(given: str, secret: str) -> bool:
    """Compare two texts in constant time, so that the time tells nothing about the secret."""
    return secrets.compare_digest(given.encode("utf-8", "replace"), secret.encode())


def cookie_name(secret: str) -> str:
    """Return a cookie name that differs for each folder: browsers share cookies between the ports of a host."""
    return f"rrp-sheets-{hashlib.sha256(secret.encode()).hexdigest()[:8]}"


def folder_secret(folder: Path, *, renew: bool = False) -> tuple[str, str]:
    """Return the secret that identifies a folder's browsers, kept in a file that only this user can read.

    It stands in the user's own folder for such data and not beside the workbooks, which others may share or copy.

    Args:
        folder: whose workbooks are served.
        renew: make another one, so that every browser needs a new link.

    Returns:
        The secret, and why it could not be kept; that is empty when it was.
    """
    name = hashlib.sha256(os.fsencode(folder.resolve())).hexdigest()[:32]
    path = _state_folder() / "rrp-sheets" / "servers" / name
    if not renew and (kept := _read(path)):
        return kept, ""
    secret = secrets.token_urlsafe(32)
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle, half = tempfile.mkstemp(dir=path.parent)  # with mode 0600
        with os.fdopen(handle, "w", encoding="ascii") as file:
            file.write(secret)
        os.replace(half, path)
    except OSError as error:
        return secret, f"{path.parent} cannot be written ({error.strerror})"
    return secret, ""


def _read(path: Path) -> str:
    """Read the secret from a file; empty when there is none, or when others may have read or written it."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        with os.fdopen(handle, encoding="ascii") as file:
            about = os.fstat(handle)
            if os.name == "posix" and (about.st_mode & 0o077 or about.st_uid != os.getuid()):
                return ""
            text = file.read(100)
    except (OSError, UnicodeDecodeError):
        return ""
    return text if _SECRET.fullmatch(text) else ""


def _state_folder() -> Path:
    """Return the user's folder for application state: as XDG_STATE_HOME says, or the platform's equivalent."""
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    if sys.platform == "darwin":
        return home / "Library" / "Application Support"
    return Path(os.environ.get("XDG_STATE_HOME") or home / ".local" / "state")
