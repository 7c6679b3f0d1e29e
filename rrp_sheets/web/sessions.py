"""Who has logged in: a session of its own for each login, until it is ended or the server is."""

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
    """Someone who may see the pages.

    Attributes:
        name: as the others see it; empty for the one with the address of this computer, who says it on the page.
        key: tells one login from another; nothing can be opened with it.
        address: that it came from.
    """

    name: str = ""
    key: str = ""
    address: str = ""


class Sessions:
    """The sessions of a server. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._people: OrderedDict[str, Person] = OrderedDict()

    def open(self, name: str, address: str) -> tuple[str, Person]:
        """A new session; the secret that stands for it, and who it is: of two Annas at two computers one is `Anna (2)`.

        So nobody passes for another, nor takes back what another has done.
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
        """Whose session it is; None when it is none, or was ended."""
        with self._lock:
            return self._people.get(_key(secret))

    def is_open(self, person: Person) -> bool:
        """Whether the session was not ended."""
        with self._lock:
            return person.key in self._people

    def close(self, person: Person) -> None:
        """End a session."""
        with self._lock:
            self._people.pop(person.key, None)


def clean_name(given: str) -> str:
    r"""A name as it can be shown everywhere: no control characters, no invisible ones, one line.

    >>> clean_name("  Anna\u202e \n Lee\x1b[31m "), clean_name("\u200b")
    ('Anna Lee[31m', '')
    """
    letters = "".join(c if c.isprintable() else " " if c.isspace() else "" for c in given)
    return " ".join(letters.split())[:LONGEST_NAME].strip()


def _key(secret: str) -> str:
    """Sessions are looked up by a hash, so that the time which that takes tells nothing about the secret."""
    return hashlib.sha256(secret.encode("utf-8", "replace")).hexdigest()
