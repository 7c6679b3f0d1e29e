"""What a run's process and the program that watches it tell each other: lines of JSON, which can do no harm.

A value keeps what it is: a record its kind and its fields, a list its places.
"""

from __future__ import annotations

import json
import socket
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.diagnostics.fix import Fix, FixEdit
from rrp_sheets.errors import MissingPart, RunBroken, SheetsError, UnreadableFile
from rrp_sheets.model.cells import Address
from rrp_sheets.model.exchange import Act, Happening, State
from rrp_sheets.model.values import Failure, Record, Value, record_from_mapping
from rrp_sheets.runs.view import RunResult, RunSettings, RunStart, RunView, Summary

MOST_WAITING = 4_000_000  # bytes of events that a watcher may be behind; what is more is not shown, but in the trace
LIGHT = 200_000  # bytes: so much may wait when a picture is put into the box
_EDITS: dict[str, Any] = {kind.__name__: kind for kind in get_args(FixEdit)}
_ERRORS = {e.__name__: e for e in (SheetsError, MissingPart, RunBroken)}


def line(message: list[Any]) -> bytes:
    """A message as a line; letters beyond ASCII are escaped, those of undecodable file names too."""
    return json.dumps(message, separators=(",", ":")).encode("ascii") + b"\n"


class Lines:
    """Puts what arrives on a socket together into messages."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._rest = b""

    def receive(self) -> list[list[Any]] | None:
        """The messages of the next chunk, waiting for it; None when the other side has gone."""
        try:
            chunk = self._link.recv(1 << 18)
        except OSError:
            return None
        if not chunk:
            return None
        *whole, self._rest = (self._rest + chunk).split(b"\n")
        return [json.loads(w) for w in whole]

    def __iter__(self) -> Iterator[list[Any]]:
        """Message by message, to the end."""
        while (found := self.receive()) is not None:
            yield from found


class Outbox:
    """Sends without ever waiting: a watcher that is slow, or gone, does not slow the run."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._waiting = bytearray()
        self.missed = 0
        self.gone = False

    def post(self, message: list[Any]) -> None:
        """Put a message into the box."""
        if not self.gone:
            self._waiting += line(message)

    def post_event(self, message: list[Any]) -> None:
        """Put an event into the box, unless too much waits already."""
        if len(self._waiting) > MOST_WAITING:
            self.missed += 1
        else:
            self.post(message)

    @property
    def light(self) -> bool:
        """Whether little waits: pictures for somebody who is behind would be old ones."""
        return len(self._waiting) < LIGHT

    def flush(self) -> None:
        """Send what can be sent without waiting."""
        if self.missed and len(self._waiting) < MOST_WAITING // 2:
            self.post(["missed", self.missed])
            self.missed = 0
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


# ---- values
def pack(value: Value) -> Any:
    """A value as JSON that keeps what it is.

    >>> unpack(pack(["a", record_from_mapping("Red ball", {"x": 1})]))
    ['a', Red ball(x=1)]
    """
    if isinstance(value, Record):
        return {"record": value.type.name, "fields": {n: pack(v) for n, v in value.as_dict().items()}}
    if isinstance(value, (list, tuple)):
        return [pack(v) for v in value]
    return value


def unpack(packed: Any) -> Value:
    """The value that was packed."""
    if isinstance(packed, dict):
        return record_from_mapping(packed["record"], {n: unpack(v) for n, v in packed["fields"].items()})
    if isinstance(packed, list):
        return [unpack(v) for v in packed]
    return packed


def pack_finding(d: Diagnostic) -> list[Any]:
    """A finding, with its fixes."""
    return [d.code, d.severity.value, _place(d.address), d.message, d.remedy, d.span, [_pack_fix(f) for f in d.fixes]]


def unpack_finding(packed: list[Any]) -> Diagnostic:
    """The finding that was packed."""
    code, severity, where, message, remedy, span, fixes = packed
    address = Address(*where) if where else None
    span = tuple(span) if span else None
    return Diagnostic(code, Severity(severity), address, message, remedy, span, tuple(map(_unpack_fix, fixes)))


def _place(address: Address | None) -> list[Any] | None:
    return [address.sheet, address.row, address.column] if address else None


def _pack_fix(fix: Fix) -> list[Any]:
    edits = [[type(edit).__name__, [_pack_part(getattr(edit, f.name)) for f in fields(edit)]] for edit in fix.edits]
    return [fix.title, edits, fix.safe]


def _pack_part(part: Any) -> Any:
    return {"at": _place(part)} if isinstance(part, Address) else part


def _unpack_fix(packed: list[Any]) -> Fix:
    title, edits, safe = packed
    return Fix(title, tuple(_EDITS[kind](*map(_unpack_part, parts)) for kind, parts in edits), safe)


def _unpack_part(part: Any) -> Any:
    if isinstance(part, dict):
        return Address(*part["at"])
    return tuple(map(_unpack_part, part)) if isinstance(part, list) else part


def pack_error(error: SheetsError) -> list[Any]:
    """An error that a user may see."""
    code = error.code if isinstance(error, UnreadableFile) else ""
    return [type(error).__name__, error.message, error.remedy, code]


def unpack_error(packed: list[Any]) -> SheetsError:
    """The error that was packed."""
    kind, message, remedy, code = packed
    if kind == "UnreadableFile":
        return UnreadableFile(code, message, remedy)
    return _ERRORS.get(kind, SheetsError)(message, remedy)


# ---- a run
def pack_settings(settings: RunSettings) -> dict[str, Any]:
    """The settings of a run."""
    return {**vars(settings), "out": str(settings.out.absolute()) if settings.out else None}


def unpack_settings(packed: dict[str, Any]) -> RunSettings:
    """The settings that were packed."""
    return RunSettings(**{**packed, "out": Path(packed["out"]) if packed["out"] else None})


def pack_result(result: RunResult) -> dict[str, Any]:
    """What a run left."""
    broken = pack_error(result.broken) if result.broken else None
    return {"folder": str(result.folder), "files": result.files, "summary": vars(result.summary), "broken": broken,
            "problems": result.problems}  # fmt: skip


def unpack_result(packed: dict[str, Any]) -> RunResult:
    """The result that was packed."""
    broken = unpack_error(packed["broken"]) if packed["broken"] else None
    assert broken is None or isinstance(broken, RunBroken)
    return RunResult(
        Path(packed["folder"]), packed["files"], Summary(**packed["summary"]), broken, tuple(packed["problems"])
    )


class Reporter(RunView):
    """The view in the run's process: tells everything to whoever watches from another."""

    def __init__(self, box: Outbox) -> None:
        self._box = box

    def started(self, start: RunStart) -> None:
        """The run begins."""
        packed = {**vars(start), "folder": str(start.folder), "findings": [pack_finding(d) for d in start.findings],
                  "rows": list(start.rows.items())}  # fmt: skip
        self._box.post(["started", packed])
        self._box.flush()

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream."""
        self._box.post_event(["event", us, stream, row, pack(value)])

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""
        failed = [failure.code, failure.message, failure.column]
        self._box.post_event(["error", us, row, failed, [pack(v) for v in values]])

    def happening(self, us: int, happening: Happening) -> None:
        """Something to tell."""
        self._box.post_event(["happening", us, *(getattr(happening, f.name) for f in fields(happening))])

    def frame(self, us: int) -> None:
        """A frame is over."""
        self._box.post_event(["frame", us])
        self._box.flush()

    def acted(self, us: int, act: Act) -> None:
        """Somebody did something."""
        self._box.post(["acted", us, act.kind, act.text, act.by, dict(act.detail)])
        self._box.flush()

    def refused(self, kind: str, message: str, remedy: str) -> None:
        """What cannot be done."""
        self._box.post(["refused", kind, message, remedy])
        self._box.flush()

    def paused(self, us: int, is_paused: bool) -> None:
        """The run stands still, or goes on."""
        self._box.post(["paused", us, is_paused])

    def standing(self, us: int) -> None:
        """A sign of life."""
        self._box.post_event(["standing", us])
        self._box.flush()

    def state(self, us: int, state: State) -> None:
        """The world."""
        if self._box.light:
            self._box.post(["state", us, *(getattr(state, f.name) for f in fields(state))])
            self._box.flush()

    def picture(self, us: int, jpeg: bytes) -> None:
        """What the robot sees."""
        if self._box.light:
            self._box.post(["picture", us, b64encode(jpeg).decode()])
            self._box.flush()

    def finishing(self) -> None:
        """The robot is brought to rest."""
        self._box.post(["finishing"])
        self._box.flush()


def show(message: list[Any], view: RunView) -> None:
    """Tell a view what a message tells."""
    kind, *rest = message
    if kind == "event":
        us, stream, row, value = rest
        view.event(us, stream, row, unpack(value))
    elif kind == "error":
        us, row, failed, values = rest
        view.error(us, row, Failure(*failed), tuple(unpack(v) for v in values))
    elif kind == "happening":
        us, *words = rest
        view.happening(us, Happening(*words))
    elif kind == "frame":
        view.frame(rest[0])
    elif kind == "finishing":
        view.finishing()
    elif kind in _SHOWN:
        _SHOWN[kind](view, *rest)


def _show_state(view: RunView, us: int, joints: Any, base: Any, eyes: Any, saying: str, things: Any, by: Any) -> None:
    places = {name: tuple(place) for name, place in things.items()}
    view.state(us, State(joints, tuple(base), tuple(eyes), saying, places, by))


_SHOWN: dict[str, Callable[..., None]] = {
    "acted": lambda view, us, *act: view.acted(us, Act(*act)),
    "refused": lambda view, *words: view.refused(*words),
    "paused": lambda view, us, is_paused: view.paused(us, is_paused),
    "standing": lambda view, us: view.standing(us),
    "state": _show_state,
    "picture": lambda view, us, jpeg: view.picture(us, b64decode(jpeg)),
}


_LISTS = ("behaviours", "sensors", "buttons", "things")


def _tuples(packed: Any) -> Any:
    return tuple(map(_tuples, packed)) if isinstance(packed, list) else packed


def unpack_start(packed: dict[str, Any]) -> RunStart:
    """What was told when the run began."""
    return RunStart(**{
        **packed, "folder": Path(packed["folder"]), "findings": tuple(map(unpack_finding, packed["findings"])),
        "rows": dict(packed["rows"]), **{name: _tuples(packed[name]) for name in _LISTS},
        "resources": {stream: tuple(words) for stream, words in packed["resources"].items()},
    })  # fmt: skip
