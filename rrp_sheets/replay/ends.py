"""Ends of commands when another workbook is played with a record: recorded ones, usual ones, and unknown ones.

A command that was made in the session as well (the same value, on the same actuator stream, at the same time) ends as
it did there. The end of one that is not made is left out. One that the session did not have ends, if the same value
was carried out at another time in that session, after the time that this usually took; else nothing is known of its
end, and it has none.
"""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import Any

from rrp_sheets.engine.builtin_devices import MIN_DELAY_US
from rrp_sheets.model.exchange import DONE, commanded
from rrp_sheets.model.run_files import RecordedEvent, RecordedValue
from rrp_sheets.model.values import Value
from rrp_sheets.replay.record import same_json


@dataclass(eq=False)
class _Command:
    made: bool = False  # in what is played now, too


class Ends:
    """Source of the ends of commands while another workbook is played with a record.

    Args:
        events: of the record.
        streams: ids of the streams of the workbook that is played, by their names in the record.
        dones: ids of its streams that tell ends, each with its actuator stream; of the world's actuators only.

    Attributes:
        dropped: ends in the record whose commands are not made now, by actuator stream.
        usual: commands that are taken to end after their usual time.
        unknown: commands of whose end nothing is known.
    """

    def __init__(self, events: Iterable[RecordedEvent], streams: Mapping[str, str], dones: Mapping[str, str]) -> None:
        self.usual: list[tuple[str, Value, float]] = []
        self.unknown: list[tuple[str, Value]] = []
        self._done = {actuator: done for done, actuator in dones.items()}
        self._commands: dict[tuple[str, str, int], deque[_Command]] = defaultdict(deque)
        self._by_end: dict[int, _Command] = {}  # by the number of the record's event
        self._times: dict[tuple[str, str], list[float]] = defaultdict(list)
        self._coming: list[tuple[int, int, str, Value]] = []
        self._number = 0
        waiting: dict[tuple[str, str], deque[_Command]] = defaultdict(deque)
        for event in events:
            stream = streams.get(event.stream, "")
            if not isinstance(event, RecordedValue) or event.by is not None:
                continue
            if event.row and stream in self._done and event.value is not None:
                mine = stream, same_json(_told(event.value))
                command = _Command()
                self._commands[*mine, event.us].append(command)
                waiting[mine].append(command)
            elif not event.row and stream in dones and isinstance(event.value, dict):
                self._ended(event, dones[stream], waiting)

    def _ended(self, event: RecordedValue, actuator: str, waiting: Mapping[tuple[str, str], deque[_Command]]) -> None:
        mine = actuator, same_json(event.value.get("value"))
        if waiting.get(mine):
            self._by_end[event.number] = waiting[mine].popleft()
        seconds = event.value.get("seconds")
        if event.value.get("completed") is True and isinstance(seconds, (int, float)):
            self._times[mine].append(float(seconds))

    @property
    def dropped(self) -> int:
        """Number of ends in the record that belong to commands that are not made now."""
        return sum(not command.made for command in self._by_end.values())

    def made(self, us: int, stream: str, value: Value, told: Any) -> None:
        """Take note of a command that a row of the workbook that is played has made."""
        if value is None or stream not in self._done:
            return
        mine = stream, same_json(_told(told))
        same = self._commands.get((*mine, us))
        if same:
            same.popleft().made = True
        elif mine in self._times:
            seconds = median(self._times[mine])
            self.usual.append((stream, value, seconds))
            self._number += 1
            end = DONE.make(value=commanded(value), completed=True, seconds=seconds)
            due = us + max(MIN_DELAY_US, round(seconds * 1_000_000))
            heapq.heappush(self._coming, (due, self._number, self._done[stream], end))
        else:
            self.unknown.append((stream, value))

    def kept(self, event: RecordedEvent) -> bool:
        """Return whether a value of the record comes now as well: ends of commands that are not made do not."""
        command = self._by_end.get(event.number)
        return command is None or command.made

    @property
    def next_us(self) -> int | None:
        """Time (µs) of the next end that the record does not have; None when there is none."""
        return self._coming[0][0] if self._coming else None

    def take(self, now_us: int) -> list[tuple[str, Value]]:
        """Remove and return the ends that have come by now."""
        found = []
        while self._coming and self._coming[0][0] <= now_us:
            _, _, stream, value = heapq.heappop(self._coming)
            found.append((stream, value))
        return found


def _told(value: Any) -> Any:
    """Return a command's value as its end has it: ends within it lose the value of the command that they ended."""
    if isinstance(value, dict):
        if set(value) == {f.name for f in DONE.fields}:
            return {**value, "value": None}
        return {n: _told(v) for n, v in value.items()}
    return [_told(v) for v in value] if isinstance(value, list) else value
