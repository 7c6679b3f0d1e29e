"""`rrp-sheets run FILE`: runs a workbook on the simulated robot, and prints the run as it goes on."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from types import FrameType

import click

from rrp_sheets.cli.check import print_findings
from rrp_sheets.cli.language import speak, translated
from rrp_sheets.cli.main import BROKEN, INTERRUPTED, handle_signals, mute
from rrp_sheets.cli.terminal import WorkbookArgument, home_of, plain_text, say, seconds_of
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.model.exchange import DONE, Notice
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.runs import RunResult, RunStart
from rrp_sheets.runs.run_data import Commands, name_warning
from rrp_sheets.texts import N_, plural


@click.command(name="run")
@click.argument("file", type=WorkbookArgument())
@click.option(
    "--for", "duration", default="",
    help="how long, for example 20s or 2 min  [default: the end of the scene and 5 s more; 30 s without]",
)  # fmt: skip
@click.option("--fast", is_flag=True, help="as fast as the machine can, instead of in real time")
@click.option("--out", type=click.Path(path_type=Path), help="the folder for the files of the run")
@click.option("--json", "as_json", is_flag=True, help="print a summary as JSON on the last line")
@click.option("--seed", type=int, help="for everything random  [default: as the Protocol says]")
@click.option("--mode", type=click.Choice(["simulated", "pilot"]), default="simulated", show_default=True,
              help="pilot: a rehearsal whose data never counts as a session")  # fmt: skip
@click.option(
    "--no-camera", is_flag=True, help="save no pictures of the robot's camera  [default: as the Protocol says]"
)
@click.option("--participant", default="", help="the participant's code")
@click.option("--condition", default="", help="the experimental condition")
@click.option("--operator", default="", help="who operates the session")
def run_command(
    file: Path, duration: str, fast: bool, out: Path | None, as_json: bool, seed: int | None, mode: str,
    no_camera: bool, participant: str, condition: str, operator: str,
) -> None:  # fmt: skip
    """Run FILE on the simulated robot, and save everything about the run in a folder.

    You see what the robot says and does while it happens, and what goes wrong. Ctrl-C stops the run safely.

    Exit code: 0 the run ended normally, 1 the workbook has errors, 2 it cannot be read, 3 the run broke off, 130
    stopped with Ctrl-C.
    """
    from rrp_sheets import api

    settings = api.RunSettings(
        home=home_of(click.get_current_context()),
        seconds=seconds_of(duration, "--for"), fast=fast, out=out, seed=seed, mode=mode, participant=participant,
        condition=condition, operator=operator, camera=not no_camera,
    )  # fmt: skip
    watch = Watch(name_warning(participant))
    handle_signals(watch.interrupt, "SIGINT", "SIGTERM", "SIGHUP")  # the last: the terminal was closed
    ended = api.run_apart(file, settings, watch)
    result = ended.result
    if result is None and watch.interrupted:
        sys.exit(INTERRUPTED)
    if result is None:
        speak(ended.language)
        print_findings(ended.findings, err=True)
        say(N_("The workbook has errors, so the run does not start."), err=True)
        if as_json:
            click.echo(json.dumps({"findings": [d.as_dict() for d in ended.findings]}, ensure_ascii=False))
        sys.exit(1)
    watch.ended(result)
    if as_json:
        summary = {"folder": str(result.folder), **result.summary.as_dict(wall=True)}
        if result.broken is not None:
            summary["broken"] = result.broken.message
        click.echo(json.dumps(summary, ensure_ascii=False))
    if result.broken is not None:
        sys.exit(BROKEN)
    sys.exit(INTERRUPTED if watch.interrupted else 0)


_TICK_US = 5_000_000  # progress at least this often
_TELLING = ("name", "new", "colour", "distance", "value")
_MOST_ERRORS = 3  # of one row are shown in full; the end counts them all


class Watch(RunObserver):
    """Prints a run, and at its beginning a `warning` about what was typed.

    Attributes:
        interrupted: set by Ctrl-C.
    """

    def __init__(self, warning: str = "") -> None:
        self.interrupted = False
        self._warning = warning
        self._names: dict[str, str] = {}
        self._commands = Commands()
        self._began = time.monotonic()
        self._failures: dict[str, int] = {}
        self._until = 0
        self._told = 0
        self._hidden = 0  # commands that were not shown

    def _echo(self, text: str, colour: str | None = None, *, err: bool = False, before: str = "") -> None:
        """Print in the language of the run; when that fails, the run goes on without it: its files are what counts."""
        try:
            text = translated(text)
            click.echo(plain_text(before + (click.style(text, fg=colour) if colour else text)), err=err)
        except OSError:  # the reader has gone, or the disk is full
            mute()

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Stop the run, as the handler of a signal: the robot halts at once, and everything is written."""
        self.interrupted = True

    def stopped(self) -> bool:
        """Return whether Ctrl-C was pressed."""
        return self.interrupted

    def started(self, start: RunStart) -> None:
        """Say what runs and for how long."""
        self._names = dict(start.actuators)
        self._until = start.until_us
        speak(start.language)
        print_findings(start.findings, err=True)
        if self._warning:
            self._echo(self._warning, "yellow", err=True)
        count = len(start.rows)
        rows = N_("{n:,} row" if count == 1 else "{n:,} rows", n=count)
        words = N_("{title}: {rows} for {seconds:g} s. Ctrl-C stops.")
        self._echo(N_(words, title=start.title, rows=rows, seconds=start.until_us / 1e6))

    def _line(self, us: int, text: str, colour: str | None = None) -> None:
        self._told = us
        self._echo(text, colour, before=f"{us / 1e6:7.2f} s  ")

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A command for an actuator, when it is not the same stream of commands going on."""
        name = self._names.get(stream)
        if name is None:
            return
        if self._commands.tell(us, row, value, stream):
            what = N_("{name} stops", name=name) if value is None else f"{name} ← {translated(_short(value))}"
            self._line(us, f"{translated(what)}  ({row})")
        else:
            self._hidden += 1

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""
        count = self._failures[row] = self._failures.get(row, 0) + 1
        if count <= _MOST_ERRORS:
            given = ", ".join(show(v) for v in values)
            words = N_("error in {row}: {message} (it got {values})", row=row, message=failure.message, values=given)
            self._line(us, words, "red")

    def notice(self, us: int, notice: Notice) -> None:
        """Print speech, clamped commands and notes."""
        words = {"say": N_("says “{text}”"), "sound": N_("plays “{text}”")}.get(notice.kind)
        colour = {"say": "green", "sound": "green", "person": "cyan", "error": "red", "clamp": "yellow"}
        text = translated(N_(words, text=notice.text) if words else notice.text)
        self._line(us, f"{text}{f'  ({notice.row})' if notice.row else ''}", colour.get(notice.kind))

    def frame(self, us: int) -> None:
        """Print the progress when nothing else was printed for a while."""
        if us - self._told >= _TICK_US:
            self._line(us, N_("… of {seconds:g} s", seconds=self._until / 1e6))

    def finishing(self) -> None:
        """Say that the run is over."""
        over = N_("Stopped: the robot goes to rest, the files are written …")
        self._echo(over if self.interrupted else N_("The run is over: the robot goes to rest, the files are written …"))

    def ended(self, result: RunResult) -> None:
        """Say what was left where."""
        summary = result.summary
        if result.broken is not None:
            self._echo(N_("The run stopped unexpectedly: {why}", why=result.broken.message), "red", err=True)
            self._echo(f"  → {translated(result.broken.remedy)}", err=True)
        if summary.ended == "end run":
            self._echo(N_("The row {row} ended the run.", row=summary.ended_by))
        for problem in result.problems:
            self._echo(problem, "red", err=True)
        errors = sum(summary.errors.values())
        speed = summary.simulated / summary.wall if summary.wall else 0
        commands: str = plural("{n:,} command", "{n:,} commands", sum(summary.commands.values()))
        if self._hidden:
            commands = N_("{commands} (repeats are not shown)", commands=commands)
        words = N_("{seconds:g} s in {wall:.1f} s ({speed:.1f} times real time), {commands}, {errors}.")
        self._echo(N_(words, seconds=round(summary.simulated, 1), wall=summary.wall, speed=speed, commands=commands,
                      errors=N_("{n:,} error" if errors == 1 else "{n:,} errors", n=errors)))  # fmt: skip
        self._echo(N_("With start, rest and files it took {seconds:.1f} s.", seconds=time.monotonic() - self._began))
        self._echo(N_("In {folder}:", folder=str(result.folder)))
        width = max((len(n) for n in result.files), default=0)
        for name, what in result.files.items():
            self._echo(f"  {name:<{width}}  {translated(what)}")


def _short(value: Value) -> str:
    """A value on one line of the terminal: of a record what it is and its one or two telling fields.

    >>> _short(DONE.make(value="Hello", completed=True, seconds=2.21)), _short(DONE.make(completed=False, seconds=0.04))
    ('completed after 2.2 s', 'broken off after 0.04 s')
    """
    if not isinstance(value, Record):
        return show(value)
    if value.type == DONE:
        completed, seconds = value.values["completed"], value.values["seconds"]
        if not isinstance(seconds, (int, float)):
            return N_("completed") if completed else N_("broken off")
        words = N_("completed after {seconds:g} s") if completed else N_("broken off after {seconds:g} s")
        return N_(words, seconds=round(seconds, 1 if seconds >= 0.1 else 2))
    told = [f"{n} {show(v)}" for n, v in value.as_dict().items() if n in _TELLING and v not in (None, "")]
    return f"{value.type.name} ({', '.join(told[:2])})" if told else value.type.name
