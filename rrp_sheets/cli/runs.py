"""`rrp-sheets runs [list|delete]`."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rrp_sheets.runs.records.deleting import Deletion
    from rrp_sheets.runs.records.facts import Facts

_HEADS = ("When", "Workbook", "Participant", "Condition", "Mode", "Length", "How it ended", "Run")
_MOST_NAMED = 12
_MEGA = 1e6


class _Listing(click.Group):
    """`rrp-sheets runs FOLDER` lists, as `rrp-sheets runs list FOLDER` does."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("-h", "--help")):
            args = ["list", *args]
        return super().parse_args(ctx, args)


@click.group(name="runs", cls=_Listing)
def command() -> None:
    """List the recorded runs of a folder, or delete those of a participant.

    `rrp-sheets runs [FOLDER]` lists; its options are those of `rrp-sheets runs list --help`.
    """


@command.command(name="list", short_help="List them, the newest first.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="only those of this participant's code")
@click.option("--workbook", default="", help="only those of this workbook")
@click.option("--json", "as_json", is_flag=True, help="print them as JSON")
def list_runs(folder: Path, participant: str, workbook: str, as_json: bool) -> None:
    """List the recorded runs beside the workbooks of FOLDER, the newest first.

    A run's name is its folder's, in FOLDER/runs; other commands take that folder.

    Exit code: 0, or 2 when there is no such folder.
    """
    from rrp_sheets.runs.records.listing import as_dict, chosen, runs_in

    found = chosen(runs_in(folder), participant=participant, workbook=workbook)
    if as_json:
        told = {"schema": 1, "runs": [as_dict(facts) for facts in found]}
        click.echo(json.dumps(told, ensure_ascii=False, indent=2))
    elif not found:
        click.echo("No run is like that." if participant or workbook else "Nothing has run here yet.")
    else:
        click.echo("\n".join(_table(found)))


@command.command(name="delete", short_help="Delete all that was recorded of a participant, or in a run.")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--participant", default="", help="the code: all runs of this participant")
@click.option("--run", "names", multiple=True, help="the name of a run; may be given several times")
@click.option("--yes", is_flag=True, help="do not ask")
@click.option(
    "--json", "as_json", is_flag=True, help="print what is deleted as JSON; needs --yes, or nothing is deleted"
)
def delete(folder: Path, participant: str, names: tuple[str, ...], yes: bool, as_json: bool) -> None:
    """Delete runs beside the workbooks of FOLDER: all that was recorded, pictures, sounds, and remembered faces.

    What goes and what stays is shown first. Nothing brings it back, and copies elsewhere (a backup, an export) stay.

    Exit code: 0, 1 when it was not confirmed, 2 when there is no such run, or one goes on.
    """
    from rrp_sheets.runs.records.deleting import delete as delete_runs
    from rrp_sheets.runs.records.deleting import plan

    if bool(participant) == bool(names):
        raise click.UsageError("Say whose runs: --participant CODE; or which: --run NAME.")
    planned = plan(folder, participant, names)
    if not as_json:
        click.echo("\n".join(_words(planned)))
    if not yes and (as_json or not _confirmed(participant)):
        if as_json:
            click.echo(json.dumps({"schema": 1, "deleted": False, **planned.as_dict()}, ensure_ascii=False, indent=2))
        click.echo("Nothing was deleted.", err=True)
        sys.exit(1)
    delete_runs(planned)
    if as_json:
        click.echo(json.dumps({"schema": 1, "deleted": True, **planned.as_dict()}, ensure_ascii=False, indent=2))
    else:
        click.echo(
            f"Deleted: {_count(len(planned.runs), 'run')}, {_count(len(planned.faces_gone), 'remembered face')}."
        )


def _confirmed(participant: str) -> bool:
    if participant:
        typed = click.prompt("To delete, type the participant's code again", default="", show_default=False)
        return bool(typed.strip() == participant)
    return click.confirm("Delete them?", default=False)


def _table(found: Sequence[Facts]) -> list[str]:
    from rrp_sheets.render.measure import clean, columns
    from rrp_sheets.runs.records.wording import ended, length

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


def _words(planned: Deletion) -> list[str]:
    """What goes, and what stays."""
    whose = f" of {planned.participant}" if planned.participant else ""
    said = [
        f"To be deleted: {_count(len(planned.runs), 'run')}{whose} with {_count(planned.files, 'file')} "
        f"({planned.size / _MEGA:,.1f} MB), among them {_count(planned.pictures, 'picture and film')} "
        f"and {_count(planned.sounds, 'sound')}.",
        *_table(planned.runs[:_MOST_NAMED]),
    ]
    if len(planned.runs) > _MOST_NAMED:
        said.append(f"… and {len(planned.runs) - _MOST_NAMED} more")
    said += [f"Remembered face “{f.name}” is wiped: {f.why}." for f in planned.faces if f.goes]
    stays = [f"Remembered face “{f.name}” stays: {f.why}" for f in planned.faces if not f.goes]
    if stays:
        stays.append("Is it theirs? Then wipe it too: rrp-sheets faces --forget NAME")
    if planned.unread:
        stays.append(planned.unread)
    stays += [f"There are runs of “{code}” too, which stay." for code in planned.like]
    if planned.unknown:
        stays.append(f"Whose these runs are cannot be read; they stay: {_listed(planned.unknown)}")
    if planned.elsewhere:
        stays.append(f"“{planned.participant}” also stands in, which stays as it is: {_listed(planned.elsewhere)}")
    if not planned.whole:
        stays.append("The folder is too large to look for the code everywhere in it.")
    return [*said, *stays]


def _listed(things: Sequence[str]) -> str:
    more = f" and {len(things) - _MOST_NAMED} more" if len(things) > _MOST_NAMED else ""
    return ", ".join(things[:_MOST_NAMED]) + more


def _count(number: int, what: str) -> str:
    ending: Any = {"picture and film": "pictures and films"}.get(what, f"{what}s")
    return f"{number:,} {what if number == 1 else ending}"
