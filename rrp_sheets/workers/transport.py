"""Transport between a process and its starter: messages on a socket, and a heartbeat in memory that both see.

A message is a line of JSON. Its binary parts, such as pictures, follow the line, which then begins with their lengths:
`7,5 ["two pictures", {"bytes":0}, {"bytes":1}]`. JSON cannot run code in its reader.

A heartbeat is judged by the processor time of the process, not by the clock on the wall: on a busy machine a healthy
process may be late.
"""

from __future__ import annotations

import datetime
import json
import mmap
import os
import selectors
import socket
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import pairwise
from typing import Any

_PLAIN = json.JSONEncoder(separators=(",", ":"))
MOST_REQUEST = 1 << 17  # bytes, to a fork server
_BYTES = "bytes"  # the only key of an object that stands for a binary part; the value is its index among them


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
        if isinstance(value, datetime.date | datetime.time):  # in a robot's TOML
            return value.isoformat()
        if not hasattr(value, "tolist"):  # of NumPy
            raise TypeError(f"{type(value).__name__} cannot be sent")
        return value.tolist()

    text = json.dumps(_escaped(message), separators=(",", ":"), default=other).encode("ascii") + b"\n"
    lengths = ",".join(str(len(each)) for each in following)
    return b"".join([f"{lengths} ".encode(), text, *following]) if following else text


def _escaped(value: Any) -> Any:
    """Return a value with the index of a mapping that only looks like a binary part in a list, to tell it apart."""
    if isinstance(value, dict):
        parts = {key: _escaped(part) for key, part in value.items()}
        return {_BYTES: [parts[_BYTES]]} if parts.keys() == {_BYTES} else parts
    return [_escaped(part) for part in value] if isinstance(value, list | tuple) else value


class MessageReader:
    """Reads whole messages from a socket, with their binary parts."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._buffer = bytearray()
        self._searched = 0  # bytes of the buffer without the end of a line
        self._needed = 0  # size of the first message, when its line is there and its binary parts are not

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


_NUMBER_BYTES = 8
LONGEST_LOOK = 0.5
"""Seconds (wall clock) that count between two looks at a process: when the whole machine stood still, nothing died."""


class SharedCounters:
    """Whole numbers in shared memory, which a process and its starter both see.

    Args:
        places: how many numbers; all are 0 at first.
        fd: of the memory that the starter has made; None makes one.

    Attributes:
        fd: of the memory, to be inherited.
        numbers: by place.
    """

    def __init__(self, places: int, fd: int | None = None) -> None:
        if fd is None:
            if hasattr(os, "memfd_create"):
                fd = os.memfd_create("rrp-sheets")
            else:
                with tempfile.TemporaryFile() as file:
                    fd = os.dup(file.fileno())
            os.ftruncate(fd, places * _NUMBER_BYTES)
        self.fd = fd
        self._map = mmap.mmap(fd, places * _NUMBER_BYTES)
        self.numbers = memoryview(self._map).cast("q")

    def close(self) -> None:
        """Let the memory go."""
        self.numbers.release()
        self._map.close()
        os.close(self.fd)


def cpu_clock(pid: int) -> Callable[[], float]:
    """Return a clock of the processor time (s) that a process has used; it stands still when the process has ended."""
    import psutil

    used = 0.0
    process: psutil.Process | None = None
    with suppress(psutil.Error):
        process = psutil.Process(pid)

    def read() -> float:
        nonlocal used
        if process is not None:
            with suppress(psutil.Error):
                times = process.cpu_times()
                used = times.user + times.system
        return used

    return read


class Liveness:
    """Measures for how long a process has made no progress, by its processor time (`cpu_clock`) and the wall clock, s.

    Attributes:
        computing: seconds of processor time since its last progress.
        still: seconds of the wall clock in which it had work, made no progress and used no processor time.
    """

    def __init__(self, cpu: Callable[[], float], now: Callable[[], float] = time.monotonic) -> None:
        self._cpu, self._now = cpu, now
        self._used, self._looked = cpu(), now()
        self._progress: object = None
        self.computing = self.still = 0.0

    def look(self, progress: object, *, has_work: bool) -> tuple[float, float]:
        """Look at it, some ten times a second; return the processor and wall time (s) that count since the last look.

        Args:
            progress: anything that differs when it has made progress.
            has_work: whether it is its turn: one that waits for somebody else may stand still.
        """
        used, now = self._cpu(), self._now()
        computed, passed = max(used - self._used, 0.0), min(now - self._looked, LONGEST_LOOK)
        self._used, self._looked = used, now
        went_on = progress != self._progress
        self._progress = progress
        self.computing = 0.0 if went_on else self.computing + computed
        self.still = 0.0 if went_on or computed or not has_work else self.still + passed
        return computed, passed
