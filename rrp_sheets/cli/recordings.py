"""Commands on recorded runs and bundles: `runs`, `export`, `faces`, `replay`, `pack`."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Sequence
from copy import copy
from datetime import datetime
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rrp_sheets.cli.language import readers_language, speak, translated
from rrp_sheets.cli.terminal import (
    WorkbookArgument,
    is_bundle,
    print_notes,
    runs_of,
    said_when_slow,
    say,
    speak_as_run,
    usage_error,
)
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, listed, plural

if TYPE_CHECKING:
    from rrp_sheets.recording.deleting import Deletion, Unsearched
    from rrp_sheets.recording.metadata import RunMetadata
    from rrp_sheets.replay import Replayed

_HEADS = (N_("When"), N_("Workbook"), N_("Participant"), N_("Condition"), N_("Mode"), N_("Length"),
          N_("How it ended"), N_("Run"))  # fmt: skip
_MODES = {"simulated": N_("simulated")}
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

    `rrp-sheets runs [FOLDER]` lists them; its options are those of `rrp-sheets runs list --help`.
    """


@runs_command.command(name="list", short_help="List recorded runs, the newest first.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="only those of this participant's code")
@click.option("--workbook", default="", help="only those of this workbook")
@click.option("--json", "as_json", is_flag=True, help="print them as JSON")
def list_runs(folder: Path, participant: str, workbook: str, as_json: bool) -> None:
    """List the recorded runs beside the workbooks of FOLDER, the newest first.

    The name of a run is the name of its folder in FOLDER/runs. Other commands take that folder.

    Exit code: 0 listed, 2 there is no such folder.
    """
    from rrp_sheets.recording.metadata import as_dict, chosen, runs_in

    found = chosen(runs_in(folder), participant=participant, workbook=workbook)
    if as_json:
        entry = {"schema": 1, "runs": [as_dict(metadata) for metadata in found]}
        click.echo(json.dumps(entry, ensure_ascii=False, indent=2))
    elif not found:
        say(N_("No runs found.") if participant or workbook else N_("There are no runs here yet."))
    else:
        click.echo("\n".join(_table(found)))


@runs_command.command(name="delete", short_help="Delete everything that was recorded of a participant, or in a run.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="the code: all runs of this participant")
@click.option("--run", "names", multiple=True, help="the name of a run; may be repeated")
@click.option("--below", is_flag=True, help="with --participant: the runs in all folders below FOLDER too")
@click.option("--yes", is_flag=True, help="do not ask")
@click.option("--json", "as_json", is_flag=True, help="print what is deleted as JSON; without --yes nothing is deleted")
def delete(
    folder: Path, participant: str, names: tuple[str, ...], below: bool, yes: bool, as_json: bool
) -> None:  # fmt: skip
    """Delete runs beside the workbooks of FOLDER, with all pictures, sounds and remembered faces.

    You see first what will be deleted and what stays. Deleting cannot be undone. Copies elsewhere (a backup, an export)
    stay.

    Runs with the code in folders below FOLDER are listed too, but deleted only with --below: another study may use the
    same code for somebody else.

    Exit code: 0 deleted, 1 not confirmed or a new run has begun, 2 there is no such run or it is in progress.
    """
    from rrp_sheets.recording.deleting import delete as delete_runs
    from rrp_sheets.recording.deleting import plan

    if bool(participant) == bool(names):
        raise usage_error(N_("Say whose runs: --participant CODE; or which: --run NAME."))
    if below and not participant:
        raise usage_error(N_("--below goes with --participant; a run is named in its own folder."))
    with said_when_slow(N_("Searching for everything to delete …")):
        planned = plan(folder, participant, names)
    _require_here(planned, below)
    parts = [planned, *(planned.below if below else ())]
    if not as_json:
        for line in _words(planned, parts):
            say(line)
    if not yes and (as_json or not _confirmed(participant)):
        if as_json:
            _print_json(planned, below, deleted=False)
        say(N_("Nothing was deleted."), err=True)
        sys.exit(1)
    with said_when_slow(N_("Deleting …")):
        begun = delete_runs(planned, below=[d.within for d in parts[1:]])
    if as_json:
        _print_json(planned, below, deleted=True, begun=begun)
    else:
        count, wiped = sum(len(d.runs) for d in parts), sum(len(d.faces_gone) for d in parts)
        faces = plural("{n:,} remembered face", "{n:,} remembered faces", wiped)
        say(N_("Deleted: {runs}, {faces}.", runs=_runs(count), faces=faces))
    if begun:
        told = N_("A new run has begun and was not deleted: {runs}. Delete it when it has ended.", runs=_listed(begun))
        say(told, err=True)
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
        question = translated(N_("To delete, type the participant's code again"))
        return bool(click.prompt(question, default="", show_default=False).strip() == participant)
    return click.confirm(translated(N_("Delete them?")), default=False)


def _runs(count: int) -> str:
    return N_("{n:,} run" if count == 1 else "{n:,} runs", n=count)


def _table(found: Sequence[RunMetadata]) -> list[str]:
    from rrp_sheets.recording.metadata import ended, length
    from rrp_sheets.render.style import clean, columns

    rows = [tuple(map(translated, _HEADS))]
    for f in found:
        began = f"{f.began:%Y-%m-%d %H:%M}" if f.began else ""
        mode = N_("pilot: never data") if f.mode == "pilot" else _MODES.get(f.mode, f.mode)
        seconds = length(f.seconds) if f.seconds else ""
        cells = (began, f.workbook, f.participant, f.condition, mode, seconds, ended(f), f.run)
        rows.append(tuple(map(translated, cells)))
    clear = [[clean(cell) for cell in row] for row in rows]
    used = [n for n in range(len(_HEADS)) if any(row[n] for row in clear[1:])]
    wide = {n: max(columns(row[n]) for row in clear) for n in used}
    return ["  ".join(row[n] + " " * (wide[n] - columns(row[n])) for n in used).rstrip() for row in clear]


def _words(planned: Deletion, parts: Sequence[Deletion]) -> list[str]:
    """Return the lines that tell which recordings are deleted, those of these parts, and which stay."""
    code = planned.participant
    goes = [line for d in parts if d.runs for line in _goes(d)]
    stays = [line for d in parts if d.runs for line in _stays(d)]
    if planned.below and len(parts) == 1:
        stays.append(
            N_("Runs of {participant} in folders below stay too. Are they of the same person?", participant=code)
        )
        words = N_("  {runs} in {folder}: {command}")
        stays += [
            N_(words, runs=_runs(len(d.runs)), folder=d.within, command=_command(d))
            for d in planned.below[:_MOST_NAMED]
        ]
        if len(planned.below) > 1:
            stays.append(N_("  All of them go with --below."))
    if planned.elsewhere:
        stays.append(N_("“{participant}” also appears in these files, which were not changed:", participant=code))
        stays += _indented(planned.elsewhere)
    if planned.unsearched:
        words = N_("These files were not searched for “{participant}”. Open them and look yourself:")
        stays.append(N_(words, participant=code))
        stays += [N_("  {file}", file=_dated(unsearched)) for unsearched in planned.unsearched]
    if not planned.whole:
        words = N_("The folder has too many files to search all of them. Search the folders below one by one.")
        stays.append(words)
    return [*goes, *stays]


def _dated(file: Unsearched) -> str:
    from rrp_sheets.web.models import date_in_words

    return N_("{name} ({day})", name=file.name, day=date_in_words(file.day)) if file.day else file.name


def _goes(planned: Deletion) -> list[str]:
    words = N_("To be deleted: {what} with {files} ({size:,.1f} MB), among them {pictures} and {sounds}.")
    if planned.within:
        words = N_("To be deleted in {within}: {what} with {files} ({size:,.1f} MB), among them {pictures} and "
                   "{sounds}.")  # fmt: skip
    what = _runs(len(planned.runs))
    if planned.participant:
        what = N_("{runs} of {participant}", runs=what, participant=planned.participant)
    said = [
        N_(words, within=planned.within, what=what,
           files=plural("{n:,} file", "{n:,} files", planned.files), size=planned.size / 1e6,
           pictures=plural("{n:,} picture or film", "{n:,} pictures and films", planned.pictures),
           sounds=plural("{n:,} sound", "{n:,} sounds", planned.sounds)),
        *_table(planned.runs[:_MOST_NAMED]),
    ]  # fmt: skip
    if len(planned.runs) > _MOST_NAMED:
        said.append(N_("… and {n} more", n=f"{len(planned.runs) - _MOST_NAMED:,}"))
    wiped = N_("Remembered face “{name}” will be deleted: {why}.")
    return said + [N_(wiped, name=f.name, why=f.why) for f in planned.faces if f.goes]


def _stays(planned: Deletion) -> list[str]:
    words = N_("Remembered face “{name}” stays: {why}")
    stays: list[str] = [N_(words, name=f.name, why=f.why) for f in planned.faces if not f.goes]
    if stays:
        stays.append(N_("Is it the same person? Then delete it too: rrp-sheets faces --forget NAME"))
    if planned.unread:
        stays.append(planned.unread)
    stays += [N_("There are also runs of “{participant}”. They stay.", participant=code) for code in planned.like]
    if planned.unknown:
        stays += [N_("The participant of these runs cannot be read. They stay:"), *_indented(planned.unknown)]
    return stays


def _command(planned: Deletion) -> str:
    return shlex.join(["rrp-sheets", "runs", "delete", str(planned.folder), "--participant", planned.participant])


def _listed(things: Sequence[str]) -> str:
    named = listed(things[:_MOST_NAMED])
    left = len(things) - _MOST_NAMED
    return N_("{names} and {n} more", names=named, n=f"{left:,}") if left > 0 else named


def _indented(things: Sequence[str]) -> list[str]:
    found: list[str] = [N_("  {file}", file=thing) for thing in things[:_MOST_NAMED]]
    left = len(things) - _MOST_NAMED
    return [*found, N_("  … and {n} more", n=f"{left:,}")] if left > 0 else found


class _ExportOption(click.Option):
    """The file to write; its kinds are named when the help is asked for, as they take long to load."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        from rrp_sheets.recording.exporting import EXPORTS

        kinds = [N_("{suffixes}: {title}", suffixes=listed([*kind.types], "or"), title=kind.title) for kind in EXPORTS]
        own = copy(self)
        own.help = translated(reduce(lambda before, after: N_("{before}; {after}", before=before, after=after), kinds))
        return click.Option.get_help_record(own, ctx)


@click.command(name="export")
@click.argument("runs", metavar="TRACE…", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--output", cls=_ExportOption, required=True, type=click.Path(path_type=Path))
@click.option("--streams", default="", help="for plots: only these streams, separated by commas")
def export_command(runs: tuple[Path, ...], output: Path, streams: str) -> None:
    """Export recorded runs as a table, or as plots of their numbers.

    TRACE is a run's folder or its trace.jsonl. Several runs become one table, with run, participant and condition in
    its first columns: `rrp-sheets export runs/* -o study.csv`. Times are in seconds from the start of the run. The
    column `blank` names the columns in which a blank came; `ended` and `complete` say how the run ended.

    Every export says which workbook ran (its SHA-256), program, mode, seed, participant, condition and operator: a CSV
    in its columns, an .xlsx on the sheet “About this run”, a picture at its foot and in its metadata.

    Exit code: 0 exported, 2 a run cannot be read or the file cannot be written.
    """
    from rrp_sheets import api

    names = [n.strip() for n in streams.split(",") if n.strip()]
    speak_as_run(runs[0])
    with said_when_slow(N_("Writing {name} …", name=output.name)):
        notes = api.export(runs, output, streams=names)
    print_notes(notes)
    say(N_("Written: {path}", path=output))


@click.command(name="faces")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--forget", metavar="NAME", help="delete this person's face")
@click.option("--forget-all", is_flag=True, help="delete all faces")
def faces_command(folder: Path, forget: str | None, forget_all: bool) -> None:
    """List the faces that the robot remembers after a run, for the workbooks of FOLDER, or delete them.

    Faces are saved only when the Protocol says so (Face memory: kept), as numbers in runs/faces.json. Delete them while
    no run is in progress: a run would save them again.
    """
    from rrp_sheets.perception import face_memory

    if forget_all:
        say(face_memory.forget_all(folder))
    elif forget is not None:
        say(N_("The face of {name} was deleted.", name=face_memory.forget(folder, forget)))
    elif names := face_memory.kept(folder):
        click.echo("\n".join(names))
    else:
        say(N_("No faces are remembered here."))


_STYLES: dict[str, dict[str, Any]] = {
    "same": {"fg": "green", "bold": True}, "different": {"fg": "yellow", "bold": True}, "head": {"bold": True},
    "quiet": {"dim": True},
}  # fmt: skip


@click.command(name="replay")
@click.argument("trace", metavar="TRACE", type=click.Path(path_type=Path))
@click.option("--with", "other", metavar="FILE", type=WorkbookArgument(),
              help="use another workbook with the sensor values of this run")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="print everything as JSON")
@click.option("-o", "--output", metavar="OUT", type=click.Path(path_type=Path),
              help="the differences as a table (.xlsx, .csv) or as marbles (.svg, .pdf, .png)")  # fmt: skip
def replay_command(trace: Path, other: Path | None, as_json: bool, output: Path | None) -> None:
    """Replay a recorded run from its sensor values, without robot or simulator, and compare it event by event.

    TRACE is a run's folder or its trace.jsonl; of a bundle (.zip) all runs are replayed. The rows get the same sensor
    values, ends of commands and actions of people, at the same times. They calculate everything else again.

    With another workbook you see what would have been different in that session: events that are missing, additional,
    or have other values. The recorded world does not react to it.

    Exit code: 0 the same, 1 different, 2 the trace or a workbook cannot be read or run.
    """
    from rrp_sheets import api
    from rrp_sheets.replay.output import SUFFIXES, write

    if output is not None and output.suffix.casefold() not in SUFFIXES:
        raise usage_error(N_("The name of OUT ends with {suffixes}.", suffixes=listed(SUFFIXES, "or")))
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
        raise usage_error(N_("-o goes with one run: unpack the bundle, and name a run's folder."))
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
        said = as_text(found, lambda text, role: click.style(text, **_STYLES[role]), readers_language())
        click.echo(said)


@click.command(name="pack")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the bundle's file (.zip)")
@click.option("--run", "runs", multiple=True, metavar="RUN",
              help="add a recorded run: its folder, or its name in runs beside FILE; may be repeated")  # fmt: skip
@click.option("--against", type=WorkbookArgument(), help="the approved version, for the printed list of changes")
@click.option("--date", "day", type=click.DateTime(["%Y-%m-%d"]), help="the day that is printed; by default today")
def pack_command(
    file: Path, output: Path | None, runs: tuple[str, ...], against: Path | None, day: datetime | None
) -> None:
    """Create a bundle: one zip of FILE and everything that is needed to run it elsewhere.

    It contains the workbook, the printed protocol, the robot's catalogue, the sounds and pictures that the workbook
    uses, the chosen runs, and all versions. The same files give the same bytes on the same day.

    Then, on any computer with the program:

    \b
      rrp-sheets run BUNDLE.zip
      rrp-sheets replay BUNDLE.zip

    check, diagram, explain, test, print and diff take a bundle too.

    Exit code: 0 packed, 2 the workbook cannot be read or the bundle cannot be written.
    """  # noqa: D301 – click takes the backspace for "leave these lines as they are"
    from rrp_sheets import api

    with said_when_slow(N_("Packing {name} and printing its protocol …", name=file.name)):
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
