"""Devices that the engine itself carries out: Wait, Timer, the switch of a behaviour, the end of the run.

They need no robot, only the run's clock, and are the same in a simulation, a test and a replay.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.exchange import DONE, Command, DeviceUse, Notice, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import RecordType, Value, show
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.engine.engine import Engine

FIRST = -1  # the rank of what the engine's own devices give: before all rows
MIN_DELAY_US = 1_000
"""The shortest time between a command and its end: less than any frame, and enough that rows which command each other
in a circle through `X done` leave an engine without frames its time."""


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
        self, engine: Engine, uses: Iterable[DeviceUse], dones: Mapping[str, str], records: Mapping[str, RecordType]
    ) -> None:
        self._engine = engine
        self._dones = dones
        self._waiting: dict[str, _Waiting] = {}
        self._uses = {use.stream: use for use in uses}
        for use in self._uses.values():
            if key(use.device) == "timer":
                self._let_tick(use, records[use.stream])

    def take(self, command: Command) -> None:
        """Carry out a command; between frames, so that what it does begins with the next one."""
        use = self._uses[command.stream]
        device = key(use.device)
        if device == "wait":
            self._wait(use, command)
        elif device == "behaviour" and command.value is not None:
            name, state = use.settings.get("name") or "", use.settings.get("state") or "on"
            self._engine.switch(key(str(name)), key(str(state)))
            self._tell_done(_Waiting(command, self._engine.clock.us), completed=True)
        elif device == "endrun" and command.value is not None:
            self._engine.ended_by = command.row

    def end(self) -> None:
        """End every wait, since the run is over."""
        waiting, self._waiting = self._waiting, {}
        for what in waiting.values():
            what.over = True
            self._feed_done(what, completed=False, ended=self._engine.clock.us)

    def _wait(self, use: DeviceUse, command: Command) -> None:
        older = self._waiting.pop(use.stream, None)
        if older is not None:
            older.over = True
            self._tell_done(older, completed=False)
        if command.value is None:
            return
        clock = self._engine.clock
        mine = _Waiting(command, clock.us)
        us = duration_of(command.value, use.settings.get("time"))
        if us is None:
            words = N_(
                "{name} does not know how long to wait: {value} is not a time, and its Time cell is blank.",
                name=use.name, value=show(command.value),
            )  # fmt: skip
            self._engine.tell(Notice("error", words, use.stream, command.row))
            self._tell_done(mine, completed=False)
            return
        self._waiting[use.stream] = mine

        def over() -> None:
            if not mine.over:
                del self._waiting[use.stream]
                self._feed_done(mine, completed=True, ended=clock.us)

        clock.push(clock.us + max(us, MIN_DELAY_US), FIRST, over)

    def _tell_done(self, what: _Waiting, *, completed: bool) -> None:
        """Report the end of a command in the next frame: never in the command's own."""
        clock, ended = self._engine.clock, self._engine.clock.us
        clock.push(ended + MIN_DELAY_US, FIRST, lambda: self._feed_done(what, completed=completed, ended=ended))

    def _feed_done(self, what: _Waiting, *, completed: bool, ended: int) -> None:
        stream = self._dones.get(what.command.stream)
        if stream is not None:
            value, seconds = commanded(what.command.value), (ended - what.began) / 1_000_000
            self._engine.feed(stream, DONE.make(value=value, completed=completed, seconds=seconds))

    def _let_tick(self, use: DeviceUse, kind: RecordType) -> None:
        """Start a Timer: it ticks at absolute due times; one tick that is late is not made up for."""
        period = max(duration_of(None, use.settings.get("every")) or 1_000_000, MIN_DELAY_US)
        clock, count, due = self._engine.clock, 0, period

        def tick() -> None:
            nonlocal count, due
            count += 1
            due += max(1, (clock.us - due) // period + 1) * period
            clock.push(due, FIRST, tick)
            self._engine.feed(use.stream, kind.make(count=count, seconds=clock.us / 1_000_000))

        clock.push(due, FIRST, tick)


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
