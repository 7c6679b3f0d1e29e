"""`rrp-sheets check FILE`."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.terminal import opened, say, speak, translated
from rrp_sheets.texts import LANGUAGES, N_, counted

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.checks.fixing import CellChange
    from rrp_sheets.diagnostics import Diagnostic

_COLOURS = {"error": "red", "warning": "yellow", "info": "blue"}
_SEVERITIES = {"error": N_("error"), "warning": N_("warning"), "info": N_("info")}
_FIX = re.compile(r"(?P<code>[A-Za-z]+\d{3})(:(?P<fix>[\w-]+))?")


class _Choice(click.ParamType):  # type: ignore[type-arg]  # generic for its stubs only, not when it runs
    """`LINT002:throttle`: that fix of the findings LINT002; without it, the fix of findings that have only one."""

    name = "CODE:FIX"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, str]:
        """The code and the fix's id."""
        match = _FIX.fullmatch(str(value))
        if not match:
            self.fail(f"“{value}” names no fix. Write a code and a fix, for example LINT002:throttle.", param, ctx)
        return match["code"].upper(), (match["fix"] or "").casefold()


@click.command(name="check")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="print findings and example values as JSON")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None, help="instead of the Protocol's Language")
@click.option("--report", "out", type=click.Path(path_type=Path), help="write a copy (.xlsx) with the findings in it")
@click.option("--fix", "mended", type=click.Path(path_type=Path), help="write a corrected copy, and say what changed")
@click.option("--apply", "chosen", type=_Choice(), multiple=True,
              help="with --fix: also a fix that needs your choice, such as LINT002:throttle")  # fmt: skip
def check_command(
    file: Path, as_json: bool, language: str | None, out: Path | None, mended: Path | None,
    chosen: tuple[tuple[str, str], ...],
) -> None:  # fmt: skip
    """Say what is wrong with FILE, each with its cell and what to do about it.

    With --fix a copy is written in which everything is corrected that leaves no doubt; findings and exit code are then
    those of the copy.

    Exit code: 0 fine or only warnings, 1 errors, 2 the file cannot be read.
    """
    from rrp_sheets import api
    from rrp_sheets.diagnostics.report import UnreadableWorkbook

    if chosen and mended is None:
        raise click.UsageError("--apply goes with --fix OUT: the corrected copy.")
    if len(dict(chosen)) < len(chosen):
        raise click.UsageError("--apply takes one fix for a code; apply the other one to the copy afterwards.")
    changes: list[CellChange] = []
    speak(language or "en")
    try:
        file = opened(file)
        if mended is None:
            checked = api.check(file)
        else:
            changes, checked = api.fix(file, mended, dict(chosen))
    except UnreadableWorkbook as error:
        if not as_json:
            raise
        entry = error.finding.as_dict(language or "en")
        click.echo(json.dumps({"findings": [entry], "examples": {}}, ensure_ascii=False, indent=2))
        sys.exit(2)
    report = checked.report
    language = language or checked.run.language
    speak(language)
    if out is not None:
        api.mark(mended or file, out, report, language)
    if as_json:
        found = {"findings": [d.as_dict(language) for d in report], "examples": _examples(checked)}
        if mended is not None:
            found["changes"] = [asdict(c) for c in changes]
        click.echo(json.dumps(found, ensure_ascii=False, indent=2))
    else:
        if mended is not None:
            print_changes(changes, mended)
        print_findings(report)
        say(verdict(report))
        if out is not None:
            say(N_("Made {path}: the findings stand beside their rows, and all of them on its last sheet.", path=out))
    sys.exit(1 if report.errors else 0)


def _examples(checked: Checked) -> dict[str, Any]:
    """Return the value that each row gives for the examples of its inputs, by sheet and row."""
    from rrp_sheets.checks.check import row_examples
    from rrp_sheets.model.values import show, to_json

    return {
        ref: {"value": to_json(fact.example), "shown": show(fact.example), "kind": fact.known.kind,
              "unit": fact.known.unit, "sure": fact.sure}
        for ref, fact in row_examples(checked).items()
    }  # fmt: skip


def print_changes(changes: Sequence[CellChange], mended: Path) -> None:
    """Print what was changed, cell by cell."""
    changed = click.style(translated(N_("changed")), fg="green", bold=True)
    for c in changes:
        what = translated(N_("inserted: {text}", text=c.new)) if c.old is None else f"“{c.old}” → “{c.new}”"
        click.echo(f"{changed} {c.code} {c.place} {what}")
    made = N_("Made {path}.", path=mended)
    say(made if changes else N_("Nothing to change; {path} is a copy.", path=mended))


def print_findings(findings: Iterable[Diagnostic], err: bool = False) -> None:
    """Print findings as people read them."""
    for d in findings:
        place = f"{d.address}: " if d.address else ""
        kind = click.style(translated(_SEVERITIES[d.severity.value]), fg=_COLOURS[d.severity.value], bold=True)
        click.echo(f"{kind} {d.code} {place}{translated(d.message)}", err=err)
        click.echo(f"  → {translated(d.remedy)}", err=err)
        for fix in d.fixes if len(d.fixes) > 1 else (f for f in d.fixes if not f.safe):
            click.echo(f"    --apply {d.code}:{fix.id}  {translated(fix.title)}", err=err)


def verdict(findings: Iterable[Diagnostic]) -> str:
    """The findings counted, in words: `2 errors, 1 warning`."""
    kinds = [d.severity.value for d in findings]
    counts = {kind: kinds.count(kind) for kind in ("error", "warning")}
    return N_("{before}.", before=counted(counts)) if any(counts.values()) else counted(counts)
