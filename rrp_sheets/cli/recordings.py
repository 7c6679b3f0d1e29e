"""Commands on recorded runs and bundles: `runs`, `export`, `faces`, `replay`, `pack`."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rrp_sheets.cli.terminal import (
    WorkbookArgument,
    counted,
    is_bundle,
    print_notes,
    runs_of,
    said_when_slow,
    say,
    speak,
    speak_as_run,
)
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, listed

if TYPE_CHECKING:
    from rrp_sheets.recording.deleting import Deletion
    from rrp_sheets.recording.metadata import RunMetadata
    from rrp_sheets.replay import Replayed

_HEADS = ("When", "Workbook", "Participant", "Condition", "Mode", "Length", "How it ended", "Run")
_MOST_NAMED = 12


class _Listing(click.Group):
    """`rrp-sheets runs FOLDER` lists, as `rrp-sheets runs list FOLDER` does."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("-h", "--help")):
            args = ["list", *args]
        return super().parse_args(ctx, args)


@click.group(name="runs", cls=_Listing)
def runs_command() -> None:
    """List the recorded runs of a folder, or delete those of a participant.

    `rrp-sheets runs [FOLDER]` lists; its options are those of `rrp-sheets runs list --help`.
    """


@runs_command.command(name="list", short_help="List them, the newest first.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="only those of this participant's code")
@click.option("--workbook", default="", help="only those of this workbook")
@click.option("--json", "as_json", is_flag=True, help="print them as JSON")
def list_runs(folder: Path, participant: str, workbook: str, as_json: bool) -> None:
    """List the recorded runs beside the workbooks of FOLDER, the newest first.

    A run's name is its folder's, in FOLDER/runs; other commands take that folder.

    Exit code: 0, or 2 when there is no such folder.
    """
    from rrp_sheets.recording.metadata import as_dict, chosen, runs_in

    found = chosen(runs_in(folder), participant=participant, workbook=workbook)
    if as_json:
        entry = {"schema": 1, "runs": [as_dict(metadata) for metadata in found]}
        click.echo(json.dumps(entry, ensure_ascii=False, indent=2))
    elif not found:
        click.echo("No run is like that." if participant or workbook else "Nothing has run here yet.")
    else:
        click.echo("\n".join(_table(found)))


@runs_command.command(name="delete", short_help="Delete all that was recorded of a participant, or in a run.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="the code: all runs of this participant")
@click.option("--run", "names", multiple=True, help="the name of a run; may be given several times")
@click.option("--below", is_flag=True, help="with --participant: the runs in all folders below FOLDER too")
@click.option("--yes", is_flag=True, help="do not ask")
@click.option(
    "--json", "as_json", is_flag=True, help="print what is deleted as JSON; needs --yes, or nothing is deleted"
)
def delete(
    folder: Path, participant: str, names: tuple[str, ...], below: bool, yes: bool, as_json: bool
) -> None:  # fmt: skip
    """Delete runs beside the workbooks of FOLDER: all that was recorded, pictures, sounds, and remembered faces.

    What goes and what stays is shown first. Nothing brings it back, and copies elsewhere (a backup, an export) stay.

    Runs of the code in folders below FOLDER are shown too. They go with --below; without it they stay, since another
    study may have given the same code to somebody else.

    Exit code: 0, 1 when it was not confirmed or a run has begun meanwhile, 2 when there is no such run, or one goes on.
    """
    from rrp_sheets.recording.deleting import delete as delete_runs
    from rrp_sheets.recording.deleting import plan

    if bool(participant) == bool(names):
        raise click.UsageError("Say whose runs: --participant CODE; or which: --run NAME.")
    if below and not participant:
        raise click.UsageError("--below goes with --participant; a run is named in its own folder.")
    with said_when_slow("Looking for everything that goes and everything that stays …"):
        planned = plan(folder, participant, names)
    _require_here(planned, below)
    parts = [planned, *(planned.below if below else ())]
    if not as_json:
        click.echo("\n".join(_words(planned, parts)))
    if not yes and (as_json or not _confirmed(participant)):
        if as_json:
            _print_json(planned, below, deleted=False)
        click.echo("Nothing was deleted.", err=True)
        sys.exit(1)
    with said_when_slow("Deleting …"):
        begun = delete_runs(planned, below=[d.within for d in parts[1:]])
    if as_json:
        _print_json(planned, below, deleted=True, begun=begun)
    else:
        count, wiped = sum(len(d.runs) for d in parts), sum(len(d.faces_gone) for d in parts)
        click.echo(f"Deleted: {counted(count, 'run')}, {counted(wiped, 'remembered face')}.")
    if begun:
        told = f"A new run has begun and was not deleted: {_listed(begun)}. Delete it when it has ended."
        click.echo(told, err=True)
        sys.exit(1)


def _require_here(planned: Deletion, below: bool) -> None:
    if not planned.runs and not below:
        who, folders = planned.participant, _listed([d.within for d in planned.below])
        message = N_("The runs of “{participant}” are in folders below: {folders}.", participant=who, folders=folders)
        raise SheetsError(message, N_("Delete them with --below, or name one of those folders."))


def _print_json(planned: Deletion, below: bool, *, deleted: bool, begun: Sequence[str] = ()) -> None:
    more = {"below_deleted": deleted and below, "begun_meanwhile": list(begun)}
    entry = {"schema": 1, "deleted": deleted, **planned.as_dict(), **more}
    click.echo(json.dumps(entry, ensure_ascii=False, indent=2))


def _confirmed(participant: str) -> bool:
    if participant:
        typed = click.prompt("To delete, type the participant's code again", default="", show_default=False)
        return bool(typed.strip() == participant)
    return click.confirm("Delete them?", default=False)


def _table(found: Sequence[RunMetadata]) -> list[str]:
    from rrp_sheets.recording.metadata import ended, length
    from rrp_sheets.render.style import clean, columns

    rows = [_HEADS]
    for f in found:
        began = f"{f.began:%Y-%m-%d %H:%M}" if f.began else ""
        mode = "pilot: never data" if f.mode == "pilot" else f.mode
        seconds = length(f.seconds) if f.seconds else ""
        rows.append((began, f.workbook, f.participant, f.condition, mode, seconds, ended(f), f.run))
    clear = [[clean(cell) for cell in row] for row in rows]
    used = [n for n in range(len(_HEADS)) if any(row[n] for row in clear[1:])]
    wide = {n: max(columns(row[n]) for row in clear) for n in used}
    return ["  ".join(row[n] + " " * (wide[n] - columns(row[n])) for n in used).rstrip() for row in clear]


def _words(planned: Deletion, parts: Sequence[Deletion]) -> list[str]:
    """Return the lines that tell which recordings are deleted, those of these parts, and which stay."""
    goes = [line for d in parts if d.runs for line in _goes(d)]
    stays = [line for d in parts if d.runs for line in _stays(d)]
    if planned.below and len(parts) == 1:
        stays.append(f"Runs of {planned.participant} in folders below stay too. Are they of the same person?")
        stays += [f"  {counted(len(d.runs), 'run')} in {d.within}: {_command(d)}" for d in planned.below[:_MOST_NAMED]]
        if len(planned.below) > 1:
            stays.append("  All of them go with --below.")
    if planned.elsewhere:
        stays.append(f"“{planned.participant}” also appears in these files, which were not changed:")
        stays += _indented(planned.elsewhere)
    if planned.unsearched:
        stays.append(f"These files were not searched for “{planned.participant}”. Open them and look yourself:")
        stays += [f"  {unsearched}" for unsearched in planned.unsearched]
    if not planned.whole:
        stays.append("The folder has too many files to search all of them. Search the folders below one by one.")
    return [*goes, *stays]


def _goes(planned: Deletion) -> list[str]:
    whose = f" of {planned.participant}" if planned.participant else ""
    where = f" in {planned.within}" if planned.within else ""
    said = [
        f"To be deleted{where}: {counted(len(planned.runs), 'run')}{whose} with {counted(planned.files, 'file')} "
        f"({planned.size / 1e6:,.1f} MB), among them {counted(planned.pictures, 'picture and film')} "
        f"and {counted(planned.sounds, 'sound')}.",
        *_table(planned.runs[:_MOST_NAMED]),
    ]
    if len(planned.runs) > _MOST_NAMED:
        said.append(f"… and {len(planned.runs) - _MOST_NAMED} more")
    return said + [f"Remembered face “{f.name}” is wiped: {f.why}." for f in planned.faces if f.goes]


def _stays(planned: Deletion) -> list[str]:
    stays = [f"Remembered face “{f.name}” stays: {f.why}" for f in planned.faces if not f.goes]
    if stays:
        stays.append("Is it theirs? Then wipe it too: rrp-sheets faces --forget NAME")
    if planned.unread:
        stays.append(planned.unread)
    stays += [f"There are runs of “{code}” too, which stay." for code in planned.like]
    if planned.unknown:
        stays += ["Whose these runs are cannot be read; they stay:", *_indented(planned.unknown)]
    return stays


def _command(planned: Deletion) -> str:
    return shlex.join(["rrp-sheets", "runs", "delete", str(planned.folder), "--participant", planned.participant])


def _listed(things: Sequence[str]) -> str:
    more = f" and {len(things) - _MOST_NAMED} more" if len(things) > _MOST_NAMED else ""
    return ", ".join(things[:_MOST_NAMED]) + more


def _indented(things: Sequence[str]) -> list[str]:
    more = [f"  … and {len(things) - _MOST_NAMED} more"] if len(things) > _MOST_NAMED else []
    return [*(f"  {thing}" for thing in things[:_MOST_NAMED]), *more]


class _ExportOption(click.Option):
    """The file to write; its kinds are named when the help is asked for, as they take long to load."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        from rrp_sheets.recording.exporting import EXPORTS

        self.help = "; ".join(f"{listed([*kind.types], 'or')}: {kind.title}" for kind in EXPORTS)
        return super().get_help_record(ctx)


@click.command(name="export")
@click.argument("runs", metavar="TRACE…", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--output", cls=_ExportOption, required=True, type=click.Path(path_type=Path))
@click.option("--streams", default="", help="of plots: only these streams, with commas between them")
def export_command(runs: tuple[Path, ...], output: Path, streams: str) -> None:
    """Write what was recorded as a table, or as plots of its numbers.

    TRACE is a run's folder or its trace.jsonl. Several runs become one table, with run, participant and condition in
    its first columns: `rrp-sheets export runs/* -o study.csv`. Times are seconds since the run began. The column
    `blank` names the columns in which a blank came; `ended` and `complete` say how the run ended.

    Every export says which workbook ran (its SHA-256), program, mode, seed, participant, condition and operator: a CSV
    in its columns, an .xlsx on the sheet “About this run”, a picture at its foot and in its metadata.

    Exit code: 0, or 2 when a run cannot be read or the file not be written.
    """
    from rrp_sheets import api

    names = [n.strip() for n in streams.split(",") if n.strip()]
    speak_as_run(runs[0])
    with said_when_slow(f"Writing {output.name} …"):
        notes = api.export(runs, output, streams=names)
    print_notes(notes)
    say(N_("Written: {path}", path=output))


@click.command(name="faces")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--forget", metavar="NAME", help="Wipe this person's face.")
@click.option("--forget-all", is_flag=True, help="Wipe all of them.")
def faces_command(folder: Path, forget: str | None, forget_all: bool) -> None:
    """List the faces that the robot remembers beyond a run, for the workbooks of FOLDER, or wipe them.

    They are kept only by workbooks whose Protocol says so (Face memory: kept), as numbers in runs/faces.json. Wipe when
    no run is going: it would write them again.
    """
    from rrp_sheets.perception import face_memory

    if forget_all:
        click.echo(face_memory.forget_all(folder))
    elif forget is not None:
        click.echo(f"{face_memory.forget(folder, forget)} is wiped.")
    else:
        names = face_memory.kept(folder)
        click.echo("\n".join(names) if names else "No faces are remembered here.")


_STYLES: dict[str, dict[str, Any]] = {
    "same": {"fg": "green", "bold": True}, "different": {"fg": "yellow", "bold": True}, "head": {"bold": True},
    "quiet": {"dim": True},
}  # fmt: skip


@click.command(name="replay")
@click.argument("trace", metavar="TRACE", type=click.Path(path_type=Path))
@click.option("--with", "other", metavar="FILE", type=WorkbookArgument(),
              help="play another workbook with what this session's sensors gave")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="print everything as JSON")
@click.option("-o", "--output", metavar="OUT", type=click.Path(path_type=Path),
              help="the differences as a table (.xlsx, .csv) or as marbles (.svg, .pdf, .png)")  # fmt: skip
def replay_command(trace: Path, other: Path | None, as_json: bool, output: Path | None) -> None:
    """Do a recorded run again from what its sensors gave, without robot or simulator, and compare event by event.

    TRACE is a run's folder or its trace.jsonl; of a bundle (.zip) all runs in it are replayed. The rows get what the
    sensors gave, the ends of commands, what people sent, switched and edited, at the same times; everything else they
    work out anew.

    With another workbook it says what would have been different in that session: events that would not have come,
    that would have come, or with other values. The recorded world does not react to it.

    Exit code: 0 the same, 1 different, 2 the trace or a workbook cannot be read or run.
    """
    from rrp_sheets import api
    from rrp_sheets.replay.output import SUFFIXES, write

    if output is not None and output.suffix.casefold() not in SUFFIXES:
        raise click.UsageError(f"The name of OUT ends with {', '.join(SUFFIXES)}.")
    if is_bundle(trace):
        _replay_all(runs_of(trace), other, as_json, output)
    speak_as_run(trace)
    found = api.replay(trace, other)
    notes = write(found, output) if output is not None else []
    _show(found, as_json)
    print_notes(notes)
    if output is not None and output.is_file():
        say(N_("Written: {path}", path=output), err=as_json)
    sys.exit(0 if found.same else 1)


def _replay_all(runs: Sequence[Path], other: Path | None, as_json: bool, output: Path | None) -> NoReturn:
    from rrp_sheets import api

    if output is not None:
        raise click.UsageError("-o goes with one run: unpack the bundle, and name a run's folder.")
    replayed = []
    for run in runs:
        found = api.replay(run, other)
        replayed.append((run.name, found))
        if not as_json:
            click.echo(click.style(f"{run.name}:", bold=True))
            _show(found, as_json)
    if as_json:
        entries = [{"run": name, **found.as_dict()} for name, found in replayed]
        click.echo(json.dumps({"runs": entries}, ensure_ascii=False, indent=2))
    sys.exit(0 if all(found.same for _, found in replayed) else 1)


def _show(found: Replayed, as_json: bool) -> None:
    from rrp_sheets.replay.report import as_text

    if as_json:
        click.echo(json.dumps(found.as_dict(), ensure_ascii=False, indent=2))
    else:
        click.echo(as_text(found, lambda text, role: click.style(text, **_STYLES[role])))


@click.command(name="pack")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the bundle's file (.zip)")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="put a recorded run in: its folder, or its name in runs beside FILE; may come again")  # fmt: skip
@click.option("--against", type=WorkbookArgument(), help="the approved version, for the printed list of changes")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def pack_command(
    file: Path, output: Path | None, runs: tuple[str, ...], against: Path | None, day: datetime | None
) -> None:
    """Make one zip of FILE and all that is needed to run it elsewhere: a bundle.

    In it: the workbook as it is, the printed protocol, the robot's catalogue, the sounds and pictures that the workbook
    names, the chosen runs, and the versions of everything. The same files give the same bytes on the same day.

    \b
    Then, on any machine with the program:  rrp-sheets run BUNDLE.zip
                                            rrp-sheets replay BUNDLE.zip

    check, diagram, explain, test, print and diff take a bundle as well.

    Exit code: 0, or 2 when the workbook cannot be read or the bundle cannot be written.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    from rrp_sheets import api

    with said_when_slow(f"Packing {file.name} and printing its protocol …"):
        packed = api.pack(file, output, runs=runs, against=against, today=day.date() if day else None)
    speak(packed.language)
    notes = [*packed.notes]
    if runs:
        notes.append(N_(
            "A run contains recordings of its participant, including pictures and speech. Check it before "
            "you share the bundle."
        ))  # fmt: skip
    print_notes(notes)
    size = packed.path.stat().st_size
    say(N_("Packed: {path} ({n} files, {size:.1f} MB)", path=packed.path, n=len(packed.files), size=size / 1e6))
