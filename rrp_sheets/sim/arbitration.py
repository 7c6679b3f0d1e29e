"""Arbitration between commands that need the same part of the robot, and the end of every command.

A larger priority interrupts; a smaller one is refused, which is reported on its row. At equal priority the voice queues
one command (a newer one takes its place); elsewhere the newer replaces the older. Repeating a running command that has
no end of its own (a tracker fed at camera rate) updates it; when such a command is outranked it waits, and resumes. A
blank ends the running and waiting commands of its stream.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rrp_sheets.model.exchange import Command, Notice, commanded
from rrp_sheets.model.values import Value

QUEUES = frozenset({"voice"})  # resources for which a command of equal priority waits for its turn
_MOST_BEGUN = 50  # jobs that are kept until the next pose is recorded; without a recording nobody asks for them
Tell = Callable[[Notice], None]


@dataclass(eq=False)
class Job:
    """A command and how it is carried out."""

    command: Command  # the latest one, when it was repeated
    uses: frozenset[str]  # the resources that it needs
    begin: Callable[[Command, int], None]  # carry it out, or go on with it; also called when it is repeated
    cease: Callable[[int], None]  # stop it at once
    over: Callable[[int], bool | None] = lambda us: None  # at every step: None while it goes on, else if completed
    joints: frozenset[str] = frozenset()  # those that it moves, when not all of its resources
    endless: bool = False  # it goes on until something stops it
    refused: str = ""  # the message when a larger priority is in its way
    began_us: int = -1

    def meets(self, other: Job) -> bool:
        """Return whether two jobs cannot be carried out at the same time."""
        if self.command.stream == other.command.stream:
            return True
        if self.joints and other.joints:
            return bool(self.joints & other.joints)
        return bool(self.uses & other.uses)


class Arbiter:
    """Starts, queues and ends commands, with exactly one done event for each job."""

    def __init__(self, dones: Mapping[str, str], tell: Tell) -> None:
        self._dones, self._tell = dones, tell  # dones: by actuator stream, the stream that gets reports of ends
        self._running: list[Job] = []
        self._waiting: list[Job] = []  # for the voice: at most one
        self._outranked: list[Job] = []  # endless ones, which resume
        self._ended: list[tuple[str, Value]] = []
        self._barred: tuple[frozenset[str], str] = (frozenset(), "")
        self._told: set[tuple[str, str]] = set()
        self._moved: dict[str, tuple[frozenset[str], frozenset[str]]] = {}
        self._begun: list[Job] = []  # since `used` was asked

    def take(self, job: Job, us: int) -> None:
        """Start, queue or refuse a new command."""
        barred, why = self._barred
        if job.uses & barred:
            if (job.command.stream, job.command.row) not in self._told:
                self._told.add((job.command.stream, job.command.row))
                self._tell(Notice("error", why, job.command.stream, job.command.row))
            self._done(job.command, False, 0.0)
            return
        if job.endless:
            ongoing = (*self._running, *self._outranked)
            mine = [j for j in ongoing if j.endless and j.command.stream == job.command.stream]
            if mine:
                self._again(mine[0], job, us)
                return
        rivals = [j for j in (*self._running, *self._waiting) if j.meets(job)]
        if any(rival.command.priority > job.command.priority for rival in rivals):
            self._refuse(job, us)
        elif job.uses & QUEUES and any(r.command.priority == job.command.priority for r in rivals):
            self._drop([j for j in self._waiting if j.meets(job)], us)
            self._waiting.append(job)
        else:
            self._start(job, us)

    def at_once(self, command: Command, completed: bool = True) -> None:
        """Report the end of a command that takes no time, or that could not be used."""
        self._done(command, completed, 0.0)

    def stop(self, stream: str | None, us: int) -> None:
        """End the commands of one actuator stream, after which outranked ones resume, or of all streams (None)."""
        those = [j for j in (*self._waiting, *self._outranked, *self._running) if stream in (None, j.command.stream)]
        self._drop(those, us)
        if stream is not None:
            self._resume(us)

    def bar(self, resources: frozenset[str], why: str, us: int) -> None:
        """Block resources from now on: commands that use them end, and new ones are refused, reported once a row."""
        self._barred = resources, why
        self._drop([j for j in (*self._waiting, *self._outranked, *self._running) if j.uses & resources], us)

    def give_way(self, streams: list[str], priority: float, us: int) -> None:
        """End the running commands of these streams, except those of a larger priority."""
        self._drop([j for j in self._running if j.command.stream in streams and j.command.priority <= priority], us)

    def go_on(self, us: int) -> None:
        """Advance to the time `us`: end commands that are over, and begin waiting ones."""
        for job in list(self._running):
            completed = job.over(us) if job in self._running else None
            if completed is not None:
                self._running.remove(job)
                self._done(job.command, completed, _seconds(job, us))
                self._resume(us)

    def ended(self) -> list[tuple[str, Value]]:
        """Return the done events since the last call, in order."""
        ended, self._ended = self._ended, []
        return ended

    def driving(self) -> dict[str, str]:
        """Return the row that uses each resource now; of several, as for two joints of an arm, the newest."""
        return {resource: job.command.row for job in self._running for resource in sorted(job.uses)}

    def moved(self, stream: str) -> tuple[frozenset[str], frozenset[str]]:
        """Return the resources that a stream's commands have used and the joints they named, and forget them."""
        return self._moved.pop(stream, (frozenset(), frozenset()))

    def used(self) -> list[Job]:
        """Return the jobs that are running, and those that ran for a shorter time since the last call."""
        begun, self._begun = self._begun, []
        return [*begun, *(job for job in self._running if job not in begun)]

    def in_use(self) -> list[tuple[frozenset[str], frozenset[str]]]:
        """Return the resources of each running command, and its joints when it names them."""
        return [(job.uses, job.joints) for job in self._running]

    def _again(self, mine: Job, job: Job, us: int) -> None:
        """Update an endless command that is repeated."""
        if mine in self._running:
            if job.command.priority < mine.command.priority:
                self._say_refused(job)
            else:
                mine.command = job.command
                mine.begin(job.command, us)
            return
        mine.command = job.command
        if all(rival.command.priority <= job.command.priority for rival in self._running if rival.meets(mine)):
            self._outranked.remove(mine)
            self._start(mine, us)

    def _refuse(self, job: Job, us: int) -> None:
        self._say_refused(job)
        if not job.endless:
            self._done(job.command, False, 0.0)
            return
        self._drop([j for j in self._outranked if j.meets(job) and j.command.priority == job.command.priority], us)
        self._outranked.append(job)

    def _say_refused(self, job: Job) -> None:
        self._tell(Notice("error", job.refused, job.command.stream, job.command.row))

    def _start(self, job: Job, us: int) -> None:
        rivals = [j for j in self._running if j.meets(job)]
        for rival in rivals:
            if rival.endless and rival.command.priority < job.command.priority:
                self._running.remove(rival)
                rival.cease(us)
                self._outranked.append(rival)
        self._drop([j for j in (*self._running, *self._waiting) if j.meets(job)], us)
        job.began_us = us if job.began_us < 0 else job.began_us
        uses, joints = self._moved.get(job.command.stream, (job.uses, job.joints))
        self._moved[job.command.stream] = uses | job.uses, joints | job.joints
        self._running.append(job)
        self._begun = [*self._begun[-_MOST_BEGUN:], job]
        job.begin(job.command, us)
        if rivals:  # they may have used more than this one does
            self._resume(us)

    def _drop(self, jobs: list[Job], us: int) -> None:
        for job in jobs:
            for place in (self._running, self._waiting, self._outranked):
                if job in place:
                    place.remove(job)
                    if place is self._running:
                        job.cease(us)
            self._done(job.command, False, _seconds(job, us))

    def _resume(self, us: int) -> None:
        """Begin commands whose resources are free: outranked ones by priority, then the newest; then waiting ones."""
        places = {id(job): place for place, job in enumerate(self._outranked)}
        for job in sorted(self._outranked, key=lambda j: (-j.command.priority, -places[id(j)])):
            if not any(rival.meets(job) for rival in self._running):
                self._outranked.remove(job)
                self._start(job, us)
        for job in list(self._waiting):
            if not any(rival.meets(job) for rival in self._running):
                self._waiting.remove(job)
                self._start(job, us)

    def _done(self, command: Command, completed: bool, seconds: float) -> None:
        stream = self._dones.get(command.stream)
        if stream is not None:
            value = command.number or commanded(command.value)
            self._ended.append((stream, {"value": value, "completed": completed, "seconds": round(seconds, 6)}))


def _seconds(job: Job, us: int) -> float:
    return 0.0 if job.began_us < 0 else (us - job.began_us) / 1e6
