"""Queue of commands to a run that goes on: any thread adds them, and the loop carries them out between two frames."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


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
            last = self._commands[-1] if self._commands else None
            if command.kind == "put" and last is not None and _same_thing(last, command):
                self._commands[-1] = command
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


def _same_thing(one: OperatorCommand, other: OperatorCommand) -> bool:
    return one.kind == other.kind and one.what.get("thing") == other.what.get("thing") and one.by == other.by
