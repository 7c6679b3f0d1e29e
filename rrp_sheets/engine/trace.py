"""The trace: every event of a run as JSON Lines, written as it happens.

The first line is the header; then one line per event, error or happening, flushed once per frame; the last line is the
summary. After the header nothing depends on the wall clock, so the same run gives the same bytes; only what people did
meanwhile has the wall's time too, to lay films beside it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rrp_sheets.engine.file_lock import lock
from rrp_sheets.errors import RunBroken, UnreadableFile
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import Notice, OperatorAction
from rrp_sheets.model.values import Failure, Value, to_json
from rrp_sheets.private import private_text

if TYPE_CHECKING:
    from rrp_sheets.engine.plan import Plan

FORMAT = 1
LONGEST_SECONDS = 366 * 24 * 3600.0  # a year: longer is no run
_LONGEST_NUMBER = 300  # digits: numbers of formulas have 16
_DEEPEST = 60  # lists in lists


def stream_label(stream: Stream) -> str:
    """A stream's name in traces: a device's own, `Sheet!name` for an ordinary stream, `Sheet!#row` without one."""
    if stream.kind in (StreamKind.SENSOR, StreamKind.ACTUATOR, StreamKind.DONE):
        return stream.name
    return f"{stream.address.sheet}!{stream.name or '#' + str(stream.address.row)}"


def _seconds(us: int) -> float:
    return us / 1_000_000


def _line(entry: Mapping[str, Any]) -> str:
    return json.dumps(entry, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def notice_entry(us: int, notice: Notice, labels: Mapping[str, str]) -> dict[str, Any]:
    """Return the trace's entry of something that the world tells; `labels`: the names of streams by their ids."""
    entry = {"t": _seconds(us), "happening": notice.kind, "text": notice.text}
    if notice.stream:
        entry["stream"] = labels.get(notice.stream, notice.stream)
    if notice.row:
        entry["row"] = notice.row
    if notice.sound:
        entry["sound"] = notice.sound
    return entry


class TraceWriter:
    """Writes a trace; an engine's observer."""

    def __init__(self, path: Path, plan: Plan, header: Mapping[str, Any]) -> None:
        # a name that is no proper text (a file name in another encoding) is written as an escape, which JSON can read
        try:
            self._file: TextIO = private_text(path)
        except OSError as error:
            raise _unwritten(error) from None
        lock(self._file)
        self._labels = {s.id: stream_label(s) for s in plan.streams}
        streams = [
            {"stream": self._labels[s.id], "kind": s.kind.value, "device": s.device.type.name if s.device else None}
            for s in plan.streams
        ]
        self._waiting = [_line({"type": "header", "format": FORMAT, **header, "streams": streams})]
        self.flush()

    def event(self, us: int, stream: str, row: str, value: Value, sent_by: str | None = None) -> None:
        """A value on a stream; `sent_by` whoever sent it by hand."""
        entry = {"t": _seconds(us), "stream": self._labels[stream], "row": row, "value": to_json(value)}
        if sent_by is not None:
            entry |= {"stimulated": True, "by": sent_by}
        self._waiting.append(_line(entry))

    def act(self, us: int, act: OperatorAction, wall: float) -> None:
        """Write an operator's action, `wall` seconds of the wall clock after the beginning, by which films are aligned.

        A value that is sent has its own line, when it enters; of an edit every change has one.
        """
        entry = {"t": _seconds(us), "happening": act.kind, "text": act.text, "by": act.by, "wall": round(wall, 3)}
        if act.kind == "edit":
            for change in act.detail["changes"]:
                text = f"{change['was'] or 'blank'} → {change['now'] or 'blank'}"
                self._waiting.append(_line({**entry, "text": text, "row": change["place"], "detail": dict(change)}))
        elif act.kind != "send":
            self._waiting.append(_line({**entry, **({"detail": dict(act.detail)} if act.detail else {})}))

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""
        entry = {"t": _seconds(us), "row": row, "error": failure.message, "code": failure.code,
                 "inputs": [to_json(v) for v in values]}  # fmt: skip
        self._waiting.append(_line(entry))

    def happening(self, us: int, happening: Notice) -> None:
        """Something that the world tells: speech, a clamped command, a note."""
        self._waiting.append(_line(notice_entry(us, happening, self._labels)))

    def flush(self) -> None:
        """Write what the frame gave; a crash loses at most a frame."""
        if self._waiting:
            lines = "\n".join(self._waiting) + "\n"
            self._waiting.clear()
            try:
                self._file.write(lines)
                self._file.flush()
            except OSError as error:
                raise _unwritten(error) from None

    def close(self, summary: Mapping[str, Any]) -> None:
        """Write the summary and close; does nothing the second time."""
        if self._file.closed:
            return
        self._waiting.append(_line({"type": "summary", **summary}))
        try:
            self.flush()
        finally:
            with suppress(OSError):  # what could not be written has been told
                self._file.close()


def _unwritten(error: OSError) -> RunBroken:
    return RunBroken(f"The trace cannot be written ({error.strerror}).", "Make room, and run again.")


def read_trace(path: Path) -> Iterator[dict[str, Any]]:
    """The lines of a trace; a last line that a crash cut off is left out.

    Raises:
        UnreadableFile: when it is no trace.
    """
    if not path.is_file():
        raise UnreadableFile("FILE001", f"There is no trace “{path}”.", "Name a run's folder.")
    with path.open(encoding="utf-8") as file:
        for line in file:
            if not line.endswith("\n"):
                return
            try:
                entry = _parsed(line)
            except (ValueError, RecursionError):
                raise UnreadableFile("FILE001", f"“{path}” is not a trace.", "Name a run's folder.") from None
            yield entry


def _parsed(line: str) -> Any:
    """Parse a line of a trace, which may come from anyone.

    Raises:
        ValueError: it is no JSON, or has what no run has: a time that is none, a huge number, lists in lists in lists.
        RecursionError: the same.
    """
    entry = _careful(line) if len(line) > _LONGEST_NUMBER else json.loads(line)
    if "\\ud" in line or "\\uD" in line:  # perhaps half of a letter, which could not be written again
        entry = json.loads(json.dumps(entry, ensure_ascii=False).encode("utf-8", "replace"))
    if line.count("[") + line.count("{") > _DEEPEST and _is_deep(entry):
        raise ValueError("too deep")
    if isinstance(entry, dict) and "t" in entry and not 0 <= float(_plain(entry["t"])) <= LONGEST_SECONDS:
        raise ValueError(entry["t"])
    return entry


def _whole(digits: str) -> int:
    if len(digits) > _LONGEST_NUMBER:
        raise ValueError("too large")
    return int(digits)


_careful = json.JSONDecoder(parse_int=_whole).decode


def _plain(value: Any) -> float:
    if not isinstance(value, (int, float)):
        raise ValueError(value)
    return value


def _is_deep(value: Any) -> bool:
    level = [value]
    for _ in range(_DEEPEST):
        level = [p for v in level if isinstance(v, (dict, list)) for p in (v.values() if isinstance(v, dict) else v)]
        if not level:
            return False
    return True
