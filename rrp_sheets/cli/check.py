"""`rrp-sheets check FILE`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rrp_sheets.errors import UnreadableFile

if TYPE_CHECKING:
    from rrp_sheets.diagnostics import Diagnostic

_COLOURS = {"error": "red", "warning": "yellow", "info": "blue"}


@click.command(name="check")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="print a list of findings as JSON")
@click.option("--report", "out", type=click.Path(path_type=Path), help="write a copy (.xlsx) with the findings in it")
def command(file: Path, as_json: bool, out: Path | None) -> None:
    """Say what is wrong with FILE, each with its cell and what to do about it.

    Exit code: 0 fine or only warnings, 1 errors, 2 the file cannot be read.
    """
    from rrp_sheets import api

    try:
        report = api.check(file).report
    except UnreadableFile as error:
        if not as_json:
            raise
        entry = {"code": error.code, "severity": "error", "sheet": "", "cell": "",
                 "message": error.message, "remedy": error.remedy}  # fmt: skip
        click.echo(json.dumps([entry], ensure_ascii=False, indent=2))
        sys.exit(2)
    if out is not None:
        api.mark(file, out, report)
    if as_json:
        click.echo(json.dumps([d.as_dict() for d in report], ensure_ascii=False, indent=2))
    else:
        print_findings(report)
        click.echo(verdict(report))
        if out is not None:
            click.echo(f"Made {out}: the findings stand beside their rows, and all of them on its last sheet.")
    sys.exit(1 if report.errors else 0)


def print_findings(findings: Iterable[Diagnostic], err: bool = False) -> None:
    """Print findings as people read them."""
    for d in findings:
        place = f"{d.address}: " if d.address else ""
        kind = click.style(d.severity.value, fg=_COLOURS[d.severity.value], bold=True)
        click.echo(f"{kind} {d.code} {place}{d.message}", err=err)
        click.echo(f"  → {d.remedy}", err=err)


def verdict(findings: Iterable[Diagnostic]) -> str:
    """The findings counted, in words: `2 errors, 1 warning`."""
    counts = {"error": 0, "warning": 0}
    for d in findings:
        if d.severity.value in counts:
            counts[d.severity.value] += 1
    parts = [f"{n} {kind}{'s' if n != 1 else ''}" for kind, n in counts.items() if n]
    return ", ".join(parts) + "." if parts else "Everything is in order."
