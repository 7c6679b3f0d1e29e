"""Devices that the engine itself carries out: Wait, Timer, the switch of a behaviour, the end of the run.

They need no robot, only the run's clock, and are the same in a simulation, a test and a replay.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from rrp_sheets.connectors.spec import Clock
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.exchange import DONE, Command, DeviceUse, Notice, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, RecordType, Value, show
from rrp_sheets.texts import N_

FIRST = -1  # the rank of what the engine's own devices give: before all rows
MIN_DELAY_US = 1_000
"""The shortest time between a command and its end: less than any frame, and enough that rows which command each other
in a circle through `X done` leave an engine without frames its time."""


class Host(Protocol):
    """Operations of an engine that its own devices call."""

    @property
    def clock(self) -> Clock:
        """Clock of the run."""
        ...

    def feed(self, stream: str, value: Value) -> None:
        """Let a value enter a stream, if some row reads it."""
        ...

    def tell(self, happening: Notice) -> None:
        """Report a notice to the observers of the run."""
        ...

    def switch(self, behaviour: str, state: str) -> None:
        """Switch a behaviour (its key) `on`, `off`, or the other way (`toggle`)."""
        ...

    def end(self, row: str) -> None:
        """End the run, as Ctrl-C does."""
        ...


@dataclass(slots=True)
class _Waiting:
    command: Command
    began: int
    over: bool = False


class BuiltinDevices:
    """Carries out the commands for the engine's own actuators, and lets its own sensors tick.

    Args:
        uses: of these devices only.
        dones: the id of the stream that tells the end of commands, by actuator stream.
        records: what sensors give, by their stream.
    """

    def __init__(
        self, host: Host, uses: Iterable[DeviceUse], dones: Mapping[str, str], records: Mapping[str, RecordType]
    ) -> None:
        self._host = host
        self._dones = dones
        self._waiting: dict[str, _Waiting] = {}
        self._uses = {use.stream: use for use in uses}
        self._acts: dict[str, Callable[[DeviceUse, Command], None]] = {
            "wait": self._wait, "behaviour": self._switch, "endrun": self._end,
        }  # fmt: skip
        for use in self._uses.values():
            if key(use.device) == "timer":
                _Ticks(host, use, records[use.stream])

    def take(self, command: Command) -> None:
        """Carry out a command; between frames, so that what it does begins with the next one."""
        use = self._uses[command.stream]
        act = self._acts.get(key(use.device))
        if act is not None:
            act(use, command)

    def end(self) -> None:
        """End every wait, since the run is over."""
        waiting, self._waiting = self._waiting, {}
        for what in waiting.values():
            what.over = True
            self._feed_done(what, completed=False)

    def _wait(self, use: DeviceUse, command: Command) -> None:
        older = self._waiting.pop(use.stream, None)
        if older is not None:
            older.over = True
            self._tell_done(older, completed=False)
        if command.value is None:
            return
        now = self._host.clock.us
        mine = _Waiting(command, now)
        us = duration_of(command.value, use.settings.get("time"))
        if us is None:
            words = N_(
                "{name} is not told how long: {value} is no time, and its Time cell is blank.",
                name=use.name, value=show(command.value),
            )  # fmt: skip
            self._host.tell(Notice("error", words, use.stream, command.row))
            self._tell_done(mine, completed=False)
            return
        self._waiting[use.stream] = mine

        def over() -> None:
            if not mine.over:
                del self._waiting[use.stream]
                self._feed_done(mine, completed=True)

        self._host.clock.push(now + max(us, MIN_DELAY_US), FIRST, over)

    def _switch(self, use: DeviceUse, command: Command) -> None:
        if command.value is None:
            return
        self._host.switch(key(str(use.settings.get("name") or "")), key(str(use.settings.get("state") or "on")))
        self._tell_done(_Waiting(command, self._host.clock.us), completed=True)

    def _end(self, use: DeviceUse, command: Command) -> None:
        if command.value is not None:
            self._host.end(command.row)

    def _tell_done(self, what: _Waiting, *, completed: bool) -> None:
        """Report the end of a command in the next frame: never in the command's own."""
        ended = self._host.clock.us
        self._host.clock.push(
            ended + MIN_DELAY_US, FIRST, lambda: self._feed_done(what, completed=completed, ended=ended)
        )

    def _feed_done(self, what: _Waiting, *, completed: bool, ended: int | None = None) -> None:
        stream = self._dones.get(what.command.stream)
        if stream is not None:
            now = self._host.clock.us if ended is None else ended
            self._host.feed(stream, done(what.command.value, completed, what.began, now))


class _Ticks:
    """A Timer: ticks with absolute due times; one that is late is not made up for."""

    def __init__(self, host: Host, use: DeviceUse, kind: RecordType) -> None:
        period = max(duration_of(None, use.settings.get("every")) or 1_000_000, MIN_DELAY_US)
        clock, count, due = host.clock, 0, period

        def tick() -> None:
            nonlocal count, due
            count += 1
            due += max(1, (clock.us - due) // period + 1) * period
            clock.push(due, FIRST, tick)
            host.feed(use.stream, kind.make(count=count, seconds=clock.us / 1_000_000))

        clock.push(due, FIRST, tick)


def done(value: Value, completed: bool, began_us: int, ended_us: int) -> Record:
    """Return the record that the stream `X done` gives at the end of a command."""
    return DONE.make(value=commanded(value), completed=completed, seconds=(ended_us - began_us) / 1_000_000)


def duration_of(value: Any, setting: Value) -> int | None:
    """Return how long to wait (µs): the time that a text says, else that of the setting, else a number of seconds.

    A number beside a setting is any event: a distance, say, that starts a wait. A setting is in whole microseconds, as
    it is understood from its cell, or a text from the catalogue.

    >>> duration_of("8 s", 5), duration_of("hello", 5), duration_of(0.5, None), duration_of(0.5, "2 s")
    (8000000, 5, 500000, 2000000)
    """
    found = parse_duration(value, bare="s") if isinstance(value, str) else None
    if found is None and isinstance(setting, str):
        found = parse_duration(setting, bare="s")
    elif found is None and setting is not None:
        found = round(setting)
    if found is None and isinstance(value, (int, float)) and not isinstance(value, bool) and value >= 0:
        found = round(value * 1_000_000)
    return found
