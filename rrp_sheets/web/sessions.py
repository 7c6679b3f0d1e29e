"""Login sessions: one for each login, until it is ended or the server is."""

from __future__ import annotations

import hashlib
import secrets
import threading
from collections import OrderedDict
from dataclasses import dataclass

LONGEST_NAME = 40
_MOST = 500


@dataclass(frozen=True, slots=True)
class Person:
    """User who may see the pages.

    Attributes:
        name: as the others see it; empty for a browser on this computer, whose user types it on the page.
        key: identifies the login; it is not the secret, and grants no access.
        address: from which the login came.
    """

    name: str = ""
    key: str = ""
    address: str = ""


class Sessions:
    """Login sessions of a server, by the hash of their secret. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._people: OrderedDict[str, Person] = OrderedDict()

    def open(self, name: str, address: str) -> tuple[str, Person]:
        """Open a session; return its secret and its user. A name in use at another address becomes `Anna (2)`.

        So nobody can impersonate another user, or undo another user's edits.
        """
        secret = secrets.token_urlsafe(32)
        with self._lock:
            taken = {p.name.casefold() for p in self._people.values() if p.address != address}
            count, wanted = 1, name
            while wanted.casefold() in taken:
                count += 1
                wanted = f"{name} ({count})"
            person = Person(wanted, _key(secret), address)
            self._people[person.key] = person
            while len(self._people) > _MOST:
                self._people.popitem(last=False)
        return secret, person

    def find(self, secret: str) -> Person | None:
        """Return the user of a session; None if there is none, or it was ended."""
        with self._lock:
            return self._people.get(_key(secret))

    def is_open(self, person: Person) -> bool:
        """Return whether a user's session has not been ended."""
        with self._lock:
            return person.key in self._people

    def close(self, person: Person) -> None:
        """End a session."""
        with self._lock:
            self._people.pop(person.key, None)


def clean_name(given: str) -> str:
    r"""Clean a name for display: one line, without control or invisible characters.

    >>> clean_name("  Anna\u202e \n Lee\x1b[31m "), clean_name("\u200b")
    ('Anna Lee[31m', '')
    """
    letters = "".join(c if c.isprintable() else " " if c.isspace() else "" for c in given)
    return " ".join(letters.split())[:LONGEST_NAME].strip()


def _key(secret: str) -> str:
    """Hash a secret: lookups by hash take a time that tells nothing about the secret."""
    return hashlib.sha256(secret.encode("utf-8", "replace")).hexdigest()
