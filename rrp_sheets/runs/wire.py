"""Messages between a worker process and the program that started it, encoded as lines of JSON, which can do no harm.

The engine and the simulator, both parts of this program, exchange pickled messages instead (`sim/messages.py`).

A value keeps its type: a record its kind and its fields, a list its items.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, get_args

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.fix import Fix, FixEdit
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.errors import MissingPart, RunBroken, SheetsError, UnreadableFile
from rrp_sheets.model.cells import Address
from rrp_sheets.model.values import Record, Value, record_from_mapping
from rrp_sheets.processes import line

MOST_WAITING = 4_000_000  # bytes of events that a watcher may be behind; what is more is not shown, but in the trace
LIGHT = 200_000  # bytes: less than that is little
_EDITS: dict[str, Any] = {kind.__name__: kind for kind in get_args(FixEdit)}
_ERRORS = {e.__name__: e for e in (SheetsError, MissingPart, RunBroken)}


class NonBlockingWriter:
    """Writer that never waits before `finish`: a watcher that is slow, or gone, does not slow the run."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._waiting = bytearray()
        self._missed, self._missed_us = 0, 0  # events that were left out, and when the last of them came
        self.gone = False

    def post(self, message: list[Any]) -> None:
        """Append a message to the buffer."""
        if not self.gone:
            self._waiting += line(message)

    def post_event(self, message: list[Any]) -> None:
        """Append an event, whose second part is its time in µs, to the buffer, unless too much waits already."""
        if len(self._waiting) > MOST_WAITING:
            self._missed, self._missed_us = self._missed + 1, message[1]
        else:
            self.post(message)

    @property
    def light(self) -> bool:
        """True while little waits: a watcher that is behind would get outdated pictures."""
        return len(self._waiting) < LIGHT

    def flush(self) -> None:
        """Send what can be sent without waiting."""
        if len(self._waiting) < MOST_WAITING // 2:
            self._post_missed()
        if self._waiting and not self.gone:
            try:
                del self._waiting[: self._link.send(self._waiting, socket.MSG_DONTWAIT)]
            except BlockingIOError:
                pass
            except OSError:
                self._leave()

    def _post_missed(self) -> None:
        if self._missed:
            self.post(["missed", self._missed_us, self._missed])
            self._missed = 0

    def finish(self) -> None:
        """Send everything, waiting for the watcher."""
        self._post_missed()
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
    """Encode a value as JSON that keeps its type.

    >>> unpack(pack(["a", record_from_mapping("Red ball", {"x": 1})]))
    ['a', Red ball(x=1)]
    """
    if isinstance(value, Record):
        return {"record": value.type.name, "fields": {n: pack(v) for n, v in value.as_dict().items()}}
    if isinstance(value, (list, tuple)):
        return [pack(v) for v in value]
    return value


def unpack(packed: Any) -> Value:
    """Decode a value that was packed."""
    if isinstance(packed, dict):
        return record_from_mapping(packed["record"], {n: unpack(v) for n, v in packed["fields"].items()})
    if isinstance(packed, list):
        return [unpack(v) for v in packed]
    return packed


def pack_finding(d: Diagnostic) -> list[Any]:
    """Encode a finding, with its fixes."""
    return [d.code, _place(d.address), _pack_places(d.details), d.span, [_pack_fix(f) for f in d.fixes]]


def unpack_finding(packed: list[Any]) -> Diagnostic:
    """Decode a finding that was packed."""
    code, where, details, span, fixes = packed
    address = Address(*where) if where else None
    span = tuple(span) if span else None
    return Diagnostic(code, address, _unpack_places(details), span, tuple(map(_unpack_fix, fixes)))


def _pack_places(places: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _pack_text(value) for name, value in places.items()}


def _unpack_places(packed: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _unpack_text(value) for name, value in packed.items()}


def _pack_text(text: object) -> Any:
    """Encode a text or a detail; a phrase keeps its template, so that it can still be put into another language."""
    if isinstance(text, Phrase):
        return {"said": text.template, "places": _pack_places(text.places)}
    return text if isinstance(text, str | int | float | None) else str(text)


def _unpack_text(packed: Any) -> Any:
    if isinstance(packed, dict):
        return Phrase(packed["said"], **_unpack_places(packed["places"]))
    return packed


def _place(address: Address | None) -> list[Any] | None:
    return [address.sheet, address.row, address.column] if address else None


def _pack_fix(fix: Fix) -> list[Any]:
    edits = [[type(edit).__name__, [_pack_part(getattr(edit, f.name)) for f in fields(edit)]] for edit in fix.edits]
    return [fix.id, _pack_text(fix.title), edits, fix.safe]


def _pack_part(part: Any) -> Any:
    return {"at": _place(part)} if isinstance(part, Address) else part


def _unpack_fix(packed: list[Any]) -> Fix:
    name, title, edits, safe = packed
    return Fix(name, _unpack_text(title), tuple(_EDITS[kind](*map(_unpack_part, parts)) for kind, parts in edits), safe)


def _unpack_part(part: Any) -> Any:
    if isinstance(part, dict):
        return Address(*part["at"])
    return tuple(map(_unpack_part, part)) if isinstance(part, list) else part


def pack_error(error: SheetsError) -> list[Any]:
    """Encode an error that a user may see; one with a finding as that finding."""
    if isinstance(error, UnreadableWorkbook):
        return [type(error).__name__, pack_finding(error.finding)]
    code = error.code if isinstance(error, UnreadableFile) else ""
    return [type(error).__name__, _pack_text(error.message), _pack_text(error.remedy), code]


def unpack_error(packed: list[Any]) -> SheetsError:
    """Decode an error that was packed."""
    kind, *said = packed
    if kind == "UnreadableWorkbook":
        return UnreadableWorkbook(unpack_finding(said[0]))
    message, remedy, code = map(_unpack_text, said)
    if kind == "UnreadableFile":
        return UnreadableFile(code, message, remedy)
    return _ERRORS.get(kind, SheetsError)(message, remedy)
