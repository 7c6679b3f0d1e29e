"""`rrp-sheets`: the commands, loaded when they are used so that help is quick."""

from __future__ import annotations

import errno
import importlib
import os
import platform
import signal
import sys
import threading
from collections.abc import Callable
from gettext import gettext
from types import FrameType
from typing import Any

import click

from rrp_sheets import __version__
from rrp_sheets.cli.language import in_readers_language, readers_words, translated
from rrp_sheets.cli.terminal import fail, plain_output, say, usage_error
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.texts import N_, LazyMessage, listed, os_reason, sentences

COMMANDS = {
    "new": ("files", "Create a workbook to start from."),
    "check": ("check", "Check a workbook: its problems, and how to fix them."),
    "diagram": ("show", "Draw a workbook's behaviours."),
    "explain": ("show", "Explain in plain words what a workbook does."),
    "print": ("show", "Print a workbook for an ethics board, as a PDF."),
    "diff": ("show", "Compare two workbooks by what they mean."),
    "formula": ("formula", "Try a formula with inputs."),
    "help": ("help", "Explain connectors, functions, devices, the scene, a code or a name."),
    "set": ("files", "Change one cell of a workbook."),
    "rename": ("files", "Rename a stream, a helper or a column in all cells."),
    "pose": ("files", "Pose the simulated robot, and save a keyframe of a gesture."),
    "convert": ("files", "Write a workbook as .xlsx, as Markdown, or as a folder of CSV files."),
    "run": ("run", "Run a workbook on the simulated robot."),
    "test": ("check", "Run the tests of a workbook."),
    "marbles": ("show", "Draw the values of a run, or of a workbook's tests, over time."),
    "replay": ("recordings", "Replay a recorded run without the robot, and show the differences."),
    "pack": ("recordings", "Create a bundle: one zip to run a workbook elsewhere."),
    "runs": ("recordings", "List the recorded runs of a folder, or delete those of a participant."),
    "export": ("recordings", "Export recorded runs as a table or plots."),
    "faces": ("recordings", "List the faces that the robot remembers, or delete them."),
    "serve": ("serve", "Edit the workbooks of a folder in the browser."),
    "tutorial": ("serve", "Learn in ten short lessons, in the browser."),
}
"""The module and the summary of each command; its function there is called `…_command`."""
_UNLIMITED = frozenset(("export", "faces", "help", "run", "runs", "serve", "tutorial"))
"""The commands that evaluate no stranger's formulas in their own process. All others have a memory limit."""
UNREADABLE, BROKEN, INTERRUPTED = 2, 3, 130


class _Lazy(click.Group):
    """A group whose commands are in modules that are imported when they are used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"rrp_sheets.cli.{COMMANDS[cmd_name][0]}")
        command: click.Command = getattr(module, f"{cmd_name}_command")
        return in_readers_language(command)

    def main(self, *args: Any, **options: Any) -> Any:
        """Run in the language of the reader, as `main` does, which also shows what is wrong."""
        if not options.get("standalone_mode", True):
            return click.Group.main(in_readers_language(self), *args, **options)
        arguments = options.get("args", args[0] if args else None)
        with readers_words(sys.argv[1:] if arguments is None else arguments):
            return click.Group.main(in_readers_language(self), *args, **options)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section(gettext("Commands")):
            formatter.write_dl([(name, translated(LazyMessage(about))) for name, (_, about) in COMMANDS.items()])

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        from rrp_sheets.model.names import nearest

        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            guess = nearest(args[0], COMMANDS)
            others = N_("The commands are: {names}.", names=listed(list(COMMANDS)))
            hint = N_("Did you mean {guess}?", guess=guess) if guess else others
            error = usage_error(sentences(N_("There is no command “{name}”.", name=args[0]), hint))
            error.ctx = ctx
            raise error
        return super().resolve_command(ctx, args)


def _say_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if not wanted or ctx.resilient_parsing:
        return
    from rrp_sheets.sim.process import about

    machine = f"{platform.system()} {platform.machine()}"
    say(N_("rrp-sheets, version {version}", version=__version__))
    say(N_("Python {version} on {machine}", version=platform.python_version(), machine=machine))
    say(N_("Simulator: {about}", about=about()))
    ctx.exit()


@click.group(cls=_Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_say_version,
    help="Show the versions of the program and of Python, and whether the simulator can run.",
)  # fmt: skip
def group() -> None:
    """Robot behaviours as rows of a spreadsheet: checked, drawn, explained, and run on a simulated NAO.

    FILE is an .xlsx workbook, a folder of CSV files, or a Markdown file; most commands also take a bundle (.zip).
    """


def main() -> None:
    """Run the command line; an error that the user can fix is printed in one or two lines, never as a traceback."""
    with readers_words(sys.argv[1:]):
        _run()


def _run() -> None:
    try:
        plain_output()
        if not _UNLIMITED.intersection(sys.argv[1:2]):
            from rrp_sheets.workers import worker_loop

            worker_loop.limit_memory()
        sys.exit(group(prog_name="rrp-sheets", standalone_mode=False))
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        sys.exit(INTERRUPTED)
    except SheetsError as error:
        fail(error, BROKEN if isinstance(error, RunBroken) else UNREADABLE)
    except BrokenPipeError:
        mute()
        sys.exit(0)
    except MemoryError:
        fail(SheetsError(N_("This needs more memory than may be used."), N_("Make the workbook smaller.")), UNREADABLE)
    except OSError as error:  # a full disk, say, under our own output
        mute()
        remedy = N_("Choose a shorter name.") if error.errno == errno.ENAMETOOLONG else N_("Is the disk full?")
        fail(SheetsError(N_("Writing failed: {reason}.", reason=os_reason(error)), remedy), UNREADABLE)


def mute() -> None:
    """Discard all further output, since its reader has gone, as with `| head`; closing it at the exit does not fail."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def handle_signals(handler: Callable[[int, FrameType | None], Any] | int | None, *names: str) -> None:
    """Handle those signals of these names that this system has; only the main thread of a process can."""
    if threading.current_thread() is threading.main_thread():
        for name in names:
            if hasattr(signal, name):
                signal.signal(getattr(signal, name), handler)
