"""The trace: every event of a run as JSON Lines, written as it happens.

The first line is the header; then one line per event, error or notice, flushed once per frame; the last line is the
summary. After the header nothing depends on the wall clock, so the same run gives the same bytes; only what people did
meanwhile has the wall's time too, to lay films beside it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rrp_sheets.engine.file_lock import lock
from rrp_sheets.errors import RunBroken
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.model.exchange import Notice, OperatorAction
from rrp_sheets.model.run_files import RecordedAction, RecordedEvent, RecordedFailure, RecordedNotice, RecordedValue
from rrp_sheets.model.values import Failure, Value, to_json
from rrp_sheets.private import private_text
from rrp_sheets.texts import N_, os_reason

if TYPE_CHECKING:
    from rrp_sheets.engine.plan import Plan

FORMAT = 1


def stream_label(stream: Stream) -> str:
    """A stream's name in traces: a device's own, `Sheet!name` for an ordinary stream, `Sheet!#row` without one."""
    if stream.kind in (StreamKind.SENSOR, StreamKind.ACTUATOR, StreamKind.DONE):
        return stream.name
    return f"{stream.address.sheet}!{stream.name or '#' + str(stream.address.row)}"


_line = json.JSONEncoder(ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode


def notice_entry(us: int, notice: Notice, labels: Mapping[str, str]) -> dict[str, Any]:
    """Return the trace's entry of something that the world tells; `labels`: the names of streams by their ids."""
    stream = labels.get(notice.stream, notice.stream)
    return RecordedNotice(us, stream, notice.row, notice.kind, notice.text, notice.sound).entry()


class TraceWriter:
    """Writes the trace of a run, line by line."""

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
        try:
            self.flush()
        except RunBroken:
            with suppress(OSError):  # closing writes once more
                self._file.close()
            raise

    def event(self, us: int, stream: str, row: str, value: Value, sent_by: str | None = None) -> None:
        """Write a value on a stream; `sent_by` whoever sent it by hand."""
        self._add(RecordedValue(us, self._labels[stream], row, to_json(value), sent_by))

    def action(self, us: int, action: OperatorAction, wall: float) -> None:
        """Write an operator's action, `wall` seconds of the wall clock after the beginning, by which films are aligned.

        A value that is sent has its own line, when it enters; of an edit every change has one.
        """
        wall = round(wall, 3)
        if action.kind == "edit":
            for change in action.detail["changes"]:
                text = f"{change['was'] or 'blank'} → {change['now'] or 'blank'}"
                self._add(RecordedAction(us, "", change["place"], action.kind, text, action.by, wall, change))
        elif action.kind != "send":
            self._add(RecordedAction(us, "", "", action.kind, action.text, action.by, wall, action.detail))

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Write that a formula failed."""
        self._add(RecordedFailure(us, "", row, failure.message, failure.code, [to_json(v) for v in values]))

    def notice(self, us: int, notice: Notice) -> None:
        """Write what the world tells: speech, a clamped command, a note."""
        self._waiting.append(_line(notice_entry(us, notice, self._labels)))

    def _add(self, event: RecordedEvent) -> None:
        self._waiting.append(_line(event.entry()))

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
    why = N_("The recording cannot be written ({reason}).", reason=os_reason(error))
    return RunBroken(why, N_("Free some disk space, then run again."))
