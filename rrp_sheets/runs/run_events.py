"""Messages from a run's process to the program that watches it: packing, sending and unpacking."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Notice, OperatorAction, State
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.runs.view import RunResult, RunSettings, RunStart, RunView, Summary
from rrp_sheets.runs.wire import NonBlockingWriter, pack, pack_error, pack_finding, unpack, unpack_error, unpack_finding

_PATHS = ("out", "home")  # of RunSettings
_LISTS = ("behaviours", "sensors", "buttons", "things")  # of a RunStart


def pack_settings(settings: RunSettings) -> dict[str, Any]:
    """Pack the settings of a run as JSON."""
    return {**vars(settings), **{n: str(p.absolute()) if (p := getattr(settings, n)) else None for n in _PATHS}}


def unpack_settings(packed: dict[str, Any]) -> RunSettings:
    """Unpack the settings of a run."""
    return RunSettings(**{**packed, **{name: Path(packed[name]) if packed[name] else None for name in _PATHS}})


def pack_result(result: RunResult) -> dict[str, Any]:
    """Pack the result of a run as JSON."""
    broken = pack_error(result.broken) if result.broken else None
    return {"folder": str(result.folder), "files": result.files, "summary": vars(result.summary), "broken": broken,
            "problems": result.problems}  # fmt: skip


def unpack_result(packed: dict[str, Any]) -> RunResult:
    """Unpack the result of a run."""
    broken = _broken(packed["broken"])
    return RunResult(
        Path(packed["folder"]), packed["files"], Summary(**packed["summary"]), broken, tuple(packed["problems"])
    )


def _broken(packed: Any) -> RunBroken | None:
    broken = unpack_error(packed) if packed else None
    assert broken is None or isinstance(broken, RunBroken)
    return broken


class RunEventSender(RunView):
    """View in the run's process that sends everything to the program that watches it."""

    def __init__(self, box: NonBlockingWriter) -> None:
        self._box = box

    def started(self, start: RunStart) -> None:
        """Send the description of the run that begins."""
        packed = {**vars(start), "folder": str(start.folder), "findings": [pack_finding(d) for d in start.findings],
                  "rows": list(start.rows.items())}  # fmt: skip
        self._box.post(["started", packed])
        self._box.flush()

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """Send a value on a stream."""
        self._box.post_event(["event", us, stream, row, pack(value)])

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Send the failure of a formula."""
        failed = [failure.code, failure.message, failure.column]
        self._box.post_event(["error", us, row, failed, [pack(v) for v in values]])

    def happening(self, us: int, happening: Notice) -> None:
        """Send a notice."""
        self._box.post_event(["happening", us, *(getattr(happening, f.name) for f in fields(happening))])

    def frame(self, us: int) -> None:
        """Send that a frame is over, and flush what waits."""
        self._box.post_event(["frame", us])
        self._box.flush()

    def acted(self, us: int, act: OperatorAction) -> None:
        """Send what an operator did."""
        self._box.post(["acted", us, act.kind, act.text, act.by, dict(act.detail)])
        self._box.flush()

    def refused(self, kind: str, message: str, remedy: str) -> None:
        """Send that a command of the operator cannot be carried out."""
        self._box.post(["refused", kind, message, remedy])
        self._box.flush()

    def paused(self, us: int, is_paused: bool) -> None:
        """Send that the run is paused, or goes on."""
        self._box.post(["paused", us, is_paused])

    def standing(self, us: int) -> None:
        """Send a sign of life while the run is paused or very slow."""
        self._box.post_event(["standing", us])
        self._box.flush()

    def state(self, us: int, state: State) -> None:
        """Send the state of the world, unless much is waiting."""
        if self._box.light:
            self._box.post(["state", us, *(getattr(state, f.name) for f in fields(state))])
            self._box.flush()

    def picture(self, us: int, jpeg: bytes) -> None:
        """Send a picture of the robot's camera, unless much is waiting."""
        if self._box.light:
            self._box.post(["picture", us, b64encode(jpeg).decode()])
            self._box.flush()

    def finishing(self) -> None:
        """Send that the robot is brought to rest."""
        self._box.post(["finishing"])
        self._box.flush()

    def rested(self, summary: Summary, broken: RunBroken | None) -> None:
        """Send that the robot is at rest, with the summary."""
        self._box.post(["rested", vars(summary), pack_error(broken) if broken else None])
        self._box.flush()


def dispatch(message: list[Any], view: RunView) -> None:
    """Call the method of a view that a message is for."""
    kind, *rest = message
    if kind == "event":
        us, stream, row, value = rest
        view.event(us, stream, row, unpack(value))
    elif kind == "error":
        us, row, failed, values = rest
        view.error(us, row, Failure(*failed), tuple(unpack(v) for v in values))
    elif kind == "happening":
        us, *words = rest
        view.happening(us, Notice(*words))
    elif kind == "frame":
        view.frame(rest[0])
    elif kind == "finishing":
        view.finishing()
    elif kind in _SHOWN:
        _SHOWN[kind](view, *rest)


def _show_state(
    view: RunView, us: int, joints: Any, base: Any, eyes: Any, saying: str, things: Any, by: Any, *room: Any
) -> None:
    places = {name: tuple(place) for name, place in things.items()}
    view.state(us, State(joints, tuple(base), tuple(eyes), saying, places, by, *room))


def _show_missed(view: RunView, us: int, count: int) -> None:
    view.happening(us, Notice("note", f"{count:,} values came faster than they can be shown. The record has them all."))


_SHOWN: dict[str, Callable[..., None]] = {
    "missed": _show_missed,
    "acted": lambda view, us, *act: view.acted(us, OperatorAction(*act)),
    "refused": lambda view, *words: view.refused(*words),
    "rested": lambda view, summary, broken: view.rested(Summary(**summary), _broken(broken)),
    "paused": lambda view, us, is_paused: view.paused(us, is_paused),
    "standing": lambda view, us: view.standing(us),
    "state": _show_state,
    "picture": lambda view, us, jpeg: view.picture(us, b64decode(jpeg)),
}


def _tuples(packed: Any) -> Any:
    return tuple(map(_tuples, packed)) if isinstance(packed, list) else packed


def unpack_start(packed: dict[str, Any]) -> RunStart:
    """Unpack the description of a run that was sent at its beginning."""
    return RunStart(**{
        **packed, "folder": Path(packed["folder"]), "findings": tuple(map(unpack_finding, packed["findings"])),
        "rows": dict(packed["rows"]), **{name: _tuples(packed[name]) for name in _LISTS},
        "resources": {stream: tuple(words) for stream, words in packed["resources"].items()},
    })  # fmt: skip
