"""`rrp-sheets replay TRACE [--with OTHER.xlsx]`."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rrp_sheets.cli.terminal import WorkbookArgument, is_bundle, runs_of

if TYPE_CHECKING:
    from rrp_sheets.runs.replay import Replayed

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
def command(trace: Path, other: Path | None, as_json: bool, output: Path | None) -> None:
    """Do a recorded run again from what its sensors gave, without robot or simulator, and compare event by event.

    TRACE is a run's folder or its trace.jsonl; of a bundle (.zip) all runs in it are replayed. The rows get what the
    sensors gave, the ends of commands, what people sent, switched and edited, at the same times; everything else they
    work out anew.

    With another workbook it says what would have been different in that session: events that would not have come,
    that would have come, or with other values. The recorded world does not react to it.

    Exit code: 0 the same, 1 different, 2 the trace or a workbook cannot be read or run.
    """
    from rrp_sheets import api
    from rrp_sheets.runs.replay.output import SUFFIXES, write

    if output is not None and output.suffix.casefold() not in SUFFIXES:
        raise click.UsageError(f"The name of OUT ends with {', '.join(SUFFIXES)}.")
    if is_bundle(trace):
        _replay_all(runs_of(trace), other, as_json, output)
    found = api.replay(trace, other)
    notes = write(found, output) if output is not None else []
    _show(found, as_json)
    for note in notes:
        click.echo(f"Note: {note}", err=True)
    if output is not None and output.is_file():
        click.echo(f"Written: {output}", err=as_json)
    sys.exit(0 if found.same else 1)


def _replay_all(runs: Sequence[Path], other: Path | None, as_json: bool, output: Path | None) -> NoReturn:
    """Replay the runs of a bundle, one after the other."""
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
        told = [{"run": name, **found.as_dict()} for name, found in replayed]
        click.echo(json.dumps({"runs": told}, ensure_ascii=False, indent=2))
    sys.exit(0 if all(found.same for _, found in replayed) else 1)


def _show(found: Replayed, as_json: bool) -> None:
    from rrp_sheets.runs.replay.report import as_text

    if as_json:
        click.echo(json.dumps(found.as_dict(), ensure_ascii=False, indent=2))
    else:
        click.echo(as_text(found, lambda text, role: click.style(text, **_STYLES[role])))
