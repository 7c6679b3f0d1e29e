"""Events of a run and commands to it: what passes between an engine and those who watch.

There is a class for each kind of event, on its way to the trace, the terminal and the pages of a server. An observer
that wants to know of a kind has a method for it, which gets the event's fields. Commands wait in a queue: any thread
adds them, and the loop carries them out between two frames.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import get_annotations
from operator import attrgetter
from typing import Any, ClassVar

from rrp_sheets.model.exchange import Notice, OperatorAction, WorldState
from rrp_sheets.model.values import Failure, Value


class RunEvent:
    """Something that happens in a run; subclasses are dataclasses.

    Attributes:
        method: name of the method of an observer that takes it.
        at_once: whether it is sent to another process at once, with all that waits before it.
        while_light: whether it is of use only to a watcher that is not behind.
        may_miss: whether a watcher that is far behind does not get it; it has a time, `us`.
        parts: gets the fields of an event, for that method.
        kinds: all kinds, by the name of the class.
    """

    __slots__ = ()
    method: ClassVar[str]
    at_once: ClassVar[bool] = True
    while_light: ClassVar[bool] = False
    may_miss: ClassVar[bool] = False
    parts: ClassVar[Callable[[RunEvent], Sequence[Any]]]
    kinds: ClassVar[dict[str, type[RunEvent]]] = {}

    def __init_subclass__(cls) -> None:
        """Know the kind by its name, and its fields."""
        names = tuple(get_annotations(cls))
        # C code, where it can be: a run has thousands of events in a second
        cls.parts = attrgetter(*names) if len(names) > 1 else staticmethod(lambda e: [getattr(e, n) for n in names])
        RunEvent.kinds[cls.__name__] = cls


class RunObserver:
    """Observer of a run, which is also asked whether to stop; subclass it. No method may take long."""

    def handle(self, event: RunEvent) -> None:
        """Call the method for the kind of an event with its fields; a kind without one is not observed."""
        method = getattr(self, event.method, None)
        if method is not None:
            method(*type(event).parts(event))

    def stopped(self) -> bool:
        """Return whether the run should stop now; asked after each frame."""
        return False


@dataclass(slots=True)
class StreamEvent(RunEvent):
    """A value on a stream (its id); `row` is the row that gave it, empty for sensor streams."""

    method = "event"
    at_once = False
    may_miss = True
    us: int
    stream: str
    row: str
    value: Value


@dataclass(slots=True)
class FormulaFailure(RunEvent):
    """A formula failed for some values; the event was dropped."""

    method = "error"
    at_once = False
    may_miss = True
    us: int
    row: str
    failure: Failure
    values: tuple[Value, ...]


@dataclass(slots=True)
class NoticeEvent(RunEvent):
    """Something besides the values, such as speech or a clamped command."""

    method = "notice"
    at_once = False
    may_miss = True
    us: int
    notice: Notice


@dataclass(slots=True)
class FrameEnd(RunEvent):
    """The end of a frame, or of some 30 ms of an event loop."""

    method = "frame"
    may_miss = True
    us: int


@dataclass(slots=True)
class OperatorEvent(RunEvent):
    """An action of somebody, after the frame of `us`."""

    method = "acted"
    us: int
    action: OperatorAction


@dataclass(slots=True)
class RefusalEvent(RunEvent):
    """A command (`send`, `apply`, …) that cannot be carried out."""

    method = "refused"
    command: str
    message: str
    remedy: str


@dataclass(slots=True)
class PauseEvent(RunEvent):
    """The beginning of a pause, or its end."""

    method = "paused"
    at_once = False
    us: int
    is_paused: bool


@dataclass(slots=True)
class KeepAliveEvent(RunEvent):
    """Sent now and then while the run is paused or very slow, so that its receiver knows it goes on."""

    method = "kept_alive"
    may_miss = True
    us: int


@dataclass(slots=True)
class StateEvent(RunEvent):
    """The state of the robot and the things around it, for a display, about 12 times a second of wall time."""

    method = "state"
    while_light = True
    us: int
    state: WorldState


@dataclass(slots=True)
class PictureEvent(RunEvent):
    """A picture of the robot's camera, about 8 times a second, when that is wanted."""

    method = "picture"
    while_light = True
    us: int
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class OperatorCommand:
    """One command of somebody to a run: `kind` is a name that `CommandHandler` knows, `what` plain data by name."""

    kind: str
    by: str = ""
    what: Mapping[str, Any] = field(default_factory=dict)


class CommandQueue:
    """Commands on their way to the loop. Stop overtakes all; of two places for one thing only the newer counts."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._commands: list[OperatorCommand] = []
        self.stopped = False
        self.stopped_by = ""

    def stop(self, by: str = "") -> None:
        """Let the run stop, whatever it is doing."""
        with self._changed:
            if not self.stopped:
                self.stopped, self.stopped_by = True, by
            self._changed.notify_all()

    def ask(self, command: OperatorCommand) -> None:
        """Add a command, to be carried out between this frame and the next."""
        with self._changed:
            last = self._commands[-1] if self._commands else command
            same = last.by == command.by and last.what.get("thing") == command.what.get("thing")
            if last is not command and last.kind == command.kind == "put" and same:
                self._commands[-1] = command  # in one step: `take` looks without the lock
            else:
                self._commands.append(command)
            self._changed.notify_all()

    def take(self) -> list[OperatorCommand]:
        """Return the commands that have come, in their order; each is given out once."""
        if not self._commands:  # asked in every frame
            return []
        with self._changed:
            commands, self._commands = self._commands, []
            return commands

    def wait(self, seconds: float) -> None:
        """Wait until a command or a stop comes, at most so long."""
        with self._changed:
            if not self._commands and not self.stopped:
                self._changed.wait(seconds)
