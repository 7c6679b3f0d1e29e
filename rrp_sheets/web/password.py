"""Secrets of a server: the password for others, kept only as a hash; the limit on wrong ones; each folder's own."""

from __future__ import annotations

import hashlib
import hmac
import ipaddress
import os
import re
import secrets
import sys
import tempfile
import threading
import time
import unicodedata
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_

SHORTEST = 8
LONGEST = 200
_WORDS = 4
_AT_ONCE = 8  # tries that are looked at or wait for it
_COST = 2**14  # about 50 ms and 16 MB for each try
_SECRET = re.compile(r"[\w-]{43}")


class Password:
    """Password that users on the network must give; only its hash is kept. Raises SheetsError if too short or long.

    >>> Password("green otter").fits("green otter"), Password("green otter").fits("green  otter")
    (True, False)
    """

    def __init__(self, text: str) -> None:
        if not SHORTEST <= len(_same_letters(text)) <= LONGEST:
            why = N_(
                "The password must have at least {least} characters and at most {most}.", least=SHORTEST, most=LONGEST
            )
            raise SheetsError(why, N_("Take a few words, or leave it empty: then one is made for you."))
        self._salt = secrets.token_bytes(16)
        self._hash = self._hashed(text)
        self._computing = threading.Semaphore(2)
        self._waiting = threading.Semaphore(_AT_ONCE)

    @contextmanager
    def place(self) -> Iterator[bool]:
        """Yield whether another attempt may be made now; the number at once is limited to keep threads free."""
        free = self._waiting.acquire(blocking=False)
        try:
            yield free
        finally:
            if free:
                self._waiting.release()

    def fits(self, given: str) -> bool:
        """Return whether this is the password; at most two hashes are computed at a time, to limit the load."""
        with self._computing:
            return hmac.compare_digest(self._hashed(given[: LONGEST + 1]), self._hash)

    def _hashed(self, text: str) -> bytes:
        return hashlib.scrypt(_same_letters(text).encode("utf-8", "replace"), salt=self._salt, n=_COST, r=8, p=1)


def invent() -> str:
    """Generate a password of a few easy words; one of four thousand million.

    >>> len(set(_EASY.split()))
    256
    """
    words = _EASY.split()
    return "-".join(secrets.choice(words) for _ in range(_WORDS))


def _same_letters(text: str) -> str:
    return unicodedata.normalize("NFKC", text)  # keyboards encode letters such as é in two ways


_EASY = """
apple apron arrow autumn baker balloon bamboo banana barrel basket beach bean bear bell bench berry bicycle bird
blanket blue boat book bottle bowl branch bread breeze brick bridge broom brown brush bucket button cabin cactus
camel candle canoe carpet carrot castle cat cello chair chalk cherry chess circle clock cloud clover coat cocoa
coffee coin comet copper coral corn cotton cousin crayon cream cricket crown cup curtain daisy dance desert desk
dinner dolphin door dragon drawer drum duck eagle early earth easy echo eight elbow elephant engine evening
family farmer feather fern fiddle field finger fire fish five flag flower flute foam forest fork four fox
friend frog fruit garden garlic gate ginger giraffe glass globe glove goat gold grape grass green guitar hammer
happy harbor harvest hat hazel heart hedge helmet hill honey horse hotel house ice ink iron island ivory jacket
jam jasmine jelly jewel juice jungle kettle key kitchen kite kitten ladder lake lamp lantern laugh leaf lemon
letter light lily lime lion lizard lunch magnet mango maple marble market meadow melon metal milk mint mirror
monkey moon morning mountain mouse muffin music needle nest night nine noodle north oak ocean olive onion orange
orchard otter owl paddle paint panda paper parrot peach peanut pear pebble pencil penguin pepper piano picnic
pillow pilot pine planet plate pocket pond pony poppy potato pumpkin purple puzzle quiet rabbit radio rain
rainbow red ribbon rice river robin rocket rose ruby sail salad salt sand silver sister six sky snow soap sofa
soup spoon spring star
"""


FREE = 5  # wrong ones without a wait
_LONGEST_WAIT = 300.0  # seconds
_FORGOTTEN = 1800.0  # seconds after which an address begins anew
_MANY = 60  # wrong ones of all addresses in _WINDOW seconds: then an address has to wait after its first already
_WINDOW = 600.0
_ADDRESSES = 5_000


@dataclass
class _Tried:
    wrong: int = 0
    last: float = 0.0
    until: float = 0.0


class LoginThrottle:
    """Limit on wrong passwords, by address; `now` is a clock, in seconds. Safe to use from several threads.

    The first attempt of an address is always checked, so no flood from elsewhere locks anybody out.

    >>> tries = LoginThrottle(lambda: 0.0)
    >>> [tries.begin("10.0.0.7") for _ in range(7)]
    [0, 0, 0, 0, 0, 2, 2]
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._lock = threading.Lock()
        self._by_address: OrderedDict[str, _Tried] = OrderedDict()
        self._all: deque[float] = deque(maxlen=_MANY)

    def begin(self, address: str) -> int:
        """Return the seconds that an address must wait; 0 if it may try, which counts as wrong until `right` is called.

        So attempts at the same moment cannot bypass the limit.
        """
        now = self._now()
        with self._lock:
            one = self._by_address.setdefault(_who(address), _Tried())
            self._by_address.move_to_end(_who(address))
            while len(self._by_address) > _ADDRESSES:
                self._by_address.popitem(last=False)
            if now < one.until:
                return max(1, round(one.until - now))
            if now - one.last > _FORGOTTEN:
                one.wrong = 0
            flooded = len(self._all) == _MANY and now - self._all[0] < _WINDOW
            free = 1 if flooded else FREE
            one.wrong, one.last = one.wrong + 1, now
            self._all.append(now)
            if one.wrong >= free:
                one.until = now + min(_LONGEST_WAIT, 2.0 ** (one.wrong - free + 1))
            return 0

    def right(self, address: str) -> None:
        """Forget the wrong attempts of an address that gave the password."""
        with self._lock:
            self._by_address.pop(_who(address), None)
            if self._all:
                self._all.pop()


def _who(address: str) -> str:
    """Return the key under which an address is counted; for IPv6 its /64 network, where one user has many addresses.

    >>> _who("10.0.0.7"), _who("2001:db8:1:2:3:4:5:6"), _who("?")
    ('10.0.0.7', '2001:db8:1:2::/64', '?')
    """
    try:
        known = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    return address if known.version == 4 else str(ipaddress.ip_network((known, 64), strict=False))


def folder_secret(folder: Path, *, renew: bool = False) -> tuple[str, str]:
    """Return the secret that identifies a folder's browsers, and why it could not be kept, if so.

    Its file, which only this user can read, stands in the user's own folder for such data and not beside the
    workbooks, which others may share or copy. With `renew` another is made, so that every browser needs a new link.
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
        return secret, N_("{folder} cannot be written ({why})", folder=str(path.parent), why=error.strerror)
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
