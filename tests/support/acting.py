"""Runs without a robot that people act upon: values at given times, wishes at given frames, everything taken down."""

from __future__ import annotations

import json
import textwrap
import time
from pathlib import Path

from rrp_sheets.checks import check_workbook
from rrp_sheets.engine.run_events import CommandQueue, OperatorCommand, RunObserver
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.model.exchange import WorldSnapshot, WorldState
from rrp_sheets.runs import RunSettings
from rrp_sheets.runs.running import run
from rrp_sheets.workbook import read


def wish(kind: str, by: str = "Anna", **what: object) -> OperatorCommand:
    """Something that somebody wants."""
    return OperatorCommand(kind, by, what)


class Things(ScriptedWorld):
    """A world with a ball in it."""

    def show(self, picture):
        return WorldSnapshot(WorldState({}, (), (), "", {"Red ball": (1.0, 0.0, 0.4)}), b"jpeg" if picture else b"")


class Script(RunObserver):
    """Does what a test says at some frames (by their numbers), and as often as the run stands still; keeps all it is told."""

    def __init__(self, frames=None, standing=()):
        self.control = CommandQueue()
        self.frames = dict(frames or {})
        self.waiting = list(standing)
        self.acts, self.refusals, self.pauses, self.events, self.states, self.pictures = [], [], [], [], [], []
        self.number = -1
        self.times = []

    def _do(self, what):
        for one in what if isinstance(what, (list, tuple)) else [what]:
            self.control.ask(one) if isinstance(one, OperatorCommand) else one(self.control)

    def started(self, start):
        self.start = start

    def frame(self, us):
        self.number += 1
        self.times.append(us)
        self._do(self.frames.pop(self.number, ()))

    def kept_alive(self, us):
        self._do(self.waiting.pop(0) if self.waiting else wish("resume"))

    def finishing(self):
        self.finished = time.monotonic()

    def event(self, us, stream, row, value):
        self.events.append((us, stream, row, value))

    def acted(self, us, action):
        self.acts.append((us, action))

    def refused(self, kind, message, remedy):
        self.refusals.append((kind, message, remedy))

    def paused(self, us, is_paused):
        self.pauses.append((us, is_paused))

    def state(self, us, state):
        self.states.append(us)

    def picture(self, us, jpeg):
        self.pictures.append(jpeg)

    def values(self, stream):
        return [value for _, name, _, value in self.events if self.start.streams[name] == stream]


class Run:
    """A run of a workbook, which is a Markdown text or a file, from its beginning to its folder."""

    def __init__(
        self,
        folder: Path,
        book: str | Path,
        script: Script,
        events=(),
        seconds=1.0,
        name="run",
        paced=False,
        everything=False,
    ):
        self.path = book if isinstance(book, Path) else folder / "book.md"
        if not self.path.exists():
            self.path.write_text(textwrap.dedent(book))
        self.script, self.worlds = script, []
        reading = read(self.path)
        checked = check_workbook(reading.workbook, reading.report)
        assert not checked.report.errors, [d.as_dict() for d in checked.report.errors]

        def world(plan, scene, seed, out):
            self.worlds.append(Things((round(ms * 1000), stream, value) for ms, stream, value in events))
            return self.worlds[-1]

        settings = RunSettings(seconds=seconds, fast=not paced, out=folder / name, everything=everything)
        self.result = run(reading, checked, settings, script, world, control=script.control)
        self.text = (folder / name / "trace.jsonl").read_text()
        lines = self.text.split("\n")  # not splitlines: what people write may hold other breaks, such as U+0085
        self.lines = [json.loads(line) for line in lines if line]

    def happened(self, *kinds):
        """The lines of what people did."""
        return [line for line in self.lines if line.get("happening") in kinds]

    @property
    def plain(self):
        """The trace without its header and without what people did."""
        return [line for line in self.lines[1:] if "by" not in line or "type" in line]
