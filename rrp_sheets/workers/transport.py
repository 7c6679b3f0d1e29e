"""Messages on a socket: lines of JSON, each with the bytes that belong to it, such as pictures, right behind.

A line with bytes begins with their lengths: `7,5 ["two pictures", …]`. JSON cannot run code in its reader.
"""

from __future__ import annotations

import json
import selectors
import socket
from collections.abc import Iterator, Sequence
from datetime import date, time
from functools import partial
from itertools import pairwise
from typing import Any

_PLAIN = json.JSONEncoder(separators=(",", ":"))
MOST_REQUEST = 1 << 17  # bytes, to a fork server
_BYTES = "bytes"  # the only key of an object that has the place of bytes among those that follow


def encode(message: Sequence[Any]) -> bytes:
    r"""Return a message as it is sent; letters beyond ASCII are escaped, those of undecodable file names too.

    >>> encode(["picture", b"JPEG"])
    b'4 ["picture",{"bytes":0}]\nJPEG'
    """
    try:
        return _PLAIN.encode(message).encode("ascii") + b"\n"
    except TypeError:
        return _encode_others(message)


def _encode_others(message: Sequence[Any]) -> bytes:
    following: list[bytes | bytearray] = []

    def other(value: Any) -> Any:
        if isinstance(value, bytes | bytearray):
            following.append(value)
            return {_BYTES: len(following) - 1}
        if isinstance(value, date | time):  # in a robot's TOML
            return value.isoformat()
        if not hasattr(value, "tolist"):  # of NumPy
            raise TypeError(f"{type(value).__name__} cannot be sent")
        return value.tolist()

    text = json.dumps(_escaped(message), separators=(",", ":"), default=other).encode("ascii") + b"\n"
    lengths = ",".join(str(len(each)) for each in following)
    return b"".join([f"{lengths} ".encode(), text, *following]) if following else text


def _escaped(value: Any) -> Any:
    """Put the value of a mapping that looks like the place of bytes into a list."""
    if isinstance(value, dict):
        parts = {key: _escaped(part) for key, part in value.items()}
        return {_BYTES: [parts[_BYTES]]} if parts.keys() == {_BYTES} else parts
    return [_escaped(part) for part in value] if isinstance(value, list | tuple) else value


class MessageReader:
    """Assembles messages from the bytes of a socket."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._buffer = bytearray()
        self._searched = 0  # bytes of the buffer without the end of a line
        self._needed = 0  # size in bytes of the first message, when its line is there and its bytes are not

    def receive(self) -> list[list[Any]] | None:
        """Return the messages that the next chunk completes, waiting for it; None when the other side has gone."""
        try:
            chunk = self._link.recv(1 << 18)
        except OSError:
            return None
        if not chunk:
            return None
        self._buffer += chunk
        return list(self._whole()) if len(self._buffer) >= self._needed else []

    def __iter__(self) -> Iterator[list[Any]]:
        """Message by message, to the end."""
        while (found := self.receive()) is not None:
            yield from found

    def _whole(self) -> Iterator[list[Any]]:
        """Take the messages that are complete out of the buffer."""
        buffer = self._buffer
        begin = self._needed = 0
        while (end := buffer.find(b"\n", max(begin, self._searched)) + 1) > 0:
            head, brace, text = buffer[begin:end].partition(b"[")
            ends = [end]
            for length in head.split(b",") if head else ():
                ends.append(ends[-1] + int(length))
            if ends[-1] > len(buffer):
                self._needed = ends[-1] - begin
                break
            if head:
                following = [buffer[a:b] for a, b in pairwise(ends)]
                yield json.loads(brace + text, object_hook=partial(_with_bytes, following))
            else:
                yield json.loads(brace + text)
            begin = ends[-1]
        self._searched = 0 if self._needed else len(buffer) - begin
        del buffer[:begin]


def _with_bytes(following: Sequence[bytearray], found: dict[str, Any]) -> Any:
    if found.keys() != {_BYTES}:
        return found
    place = found[_BYTES]
    return {_BYTES: place[0]} if isinstance(place, list) else following[place]


class NonBlockingWriter:
    """Writer that never waits before `finish`: a watcher that is slow, or gone, does not slow the run."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._waiting = bytearray()
        self.gone = False

    def post(self, message: Sequence[Any]) -> None:
        """Append a message to the buffer."""
        if not self.gone:
            self._waiting += encode(message)

    @property
    def waiting(self) -> int:
        """Bytes that have not been sent."""
        return len(self._waiting)

    def flush(self) -> None:
        """Send what can be sent without waiting."""
        if self._waiting and not self.gone:
            try:
                del self._waiting[: self._link.send(self._waiting, socket.MSG_DONTWAIT)]
            except BlockingIOError:
                pass
            except OSError:
                self._leave()

    def finish(self) -> None:
        """Send everything, waiting for the watcher."""
        try:
            self._link.sendall(self._waiting)
            self._waiting.clear()
        except OSError:
            self._leave()

    def _leave(self) -> None:
        self.gone = True
        self._waiting.clear()


def ready(fd: int, within: float | None, event: int = selectors.EVENT_READ) -> bool:
    """Return whether something can be read, or written; `select` would fail for a busy server's file numbers."""
    with selectors.DefaultSelector() as selector:
        selector.register(fd, event)
        return bool(selector.select(within))
