"""Playing rows in virtual time: a Markdown workbook, values injected into sensor streams, what came out."""

from __future__ import annotations

import textwrap
from pathlib import Path
from tempfile import TemporaryDirectory

from rrp_sheets import api
from rrp_sheets.checks import Checked
from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.runners import FrameRunner
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record
from rrp_sheets.robots import load_robot

HEADER = "| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"


def rows(text: str, *more: str, sheet: str = "T", header: str = HEADER) -> str:
    """A workbook of one behaviour from its rows as a Markdown table; `more` are further sheets."""
    body = textwrap.dedent(text).strip("\n")
    return "\n".join([f"## {sheet}\n{header}{body}\n", *(textwrap.dedent(m) for m in more)])


def check(markdown: str) -> Checked:
    """Read and check a Markdown workbook given as text."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "workbook.md"
        path.write_text(markdown, encoding="utf-8")
        return api.check(path)


def findings(markdown: str) -> list[tuple[str, str]]:
    """Code and cell of everything that is wrong."""
    return check(markdown).report.flatten(["code", "cell"])


def example(device: str, **fields: object) -> Record:
    """The example record of a device with some fields changed."""
    found = load_robot().find(device)
    assert found is not None and found.type.payload is not None
    values = {**found.type.payload.example().values, **{key(k): v for k, v in fields.items()}}
    return Record(found.type.payload, values)


class Played(RunObserver):
    """Result of a play: by stream, pairs of (ms, value); errors as (ms, row, code)."""

    def __init__(self, checked: Checked) -> None:
        self.names = {s.id: stream_label(s) for s in make_plan(checked).streams}
        self.log: list[tuple[float, str, object]] = []
        self.errors: list[tuple[float, str, str]] = []

    def event(self, us, stream, row, value):
        self.log.append((round(us / 1000, 3), self.names[stream].split("!")[-1], value))

    def error(self, us, row, failure, values):
        self.errors.append((round(us / 1000, 3), row, failure.code))

    def __getitem__(self, name: str) -> list[tuple[float, object]]:
        return [(ms, value) for ms, stream, value in self.log if key(stream) == key(name)]

    def values(self, name: str) -> list[object]:
        return [value for _, value in self[name]]


def play(markdown: str, events: list[tuple[float, str, object]], until_ms: float = 10_000) -> Played:
    """Run a workbook in virtual time; `events` are (ms, sensor stream, value)."""
    checked = check(markdown) if isinstance(markdown, str) else markdown
    assert not checked.report.errors, [d.as_dict() for d in checked.report.errors]
    played = Played(checked)
    engine = FrameEngine(make_plan(checked), played)
    world = ScriptedWorld((round(ms * 1000), key(stream), value) for ms, stream, value in events)
    FrameRunner(world, lambda: engine).go(round(until_ms * 1000), RunObserver())
    return played
