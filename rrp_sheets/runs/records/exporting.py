"""Exports of runs: a table or plots, as the file's suffix says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.render.picture import SUFFIXES as PICTURES
from rrp_sheets.render.picture import write_picture
from rrp_sheets.runs.records.metadata import TRACE, facts_of
from rrp_sheets.runs.records.pictures import draw_run_plots, title_of
from rrp_sheets.runs.records.replacing import refuse_other_table
from rrp_sheets.runs.records.stamp import stamp_of
from rrp_sheets.runs.records.table import write_csv, write_xlsx

TABLES = (".xlsx", ".csv")


def export(runs: Sequence[Path], target: Path, streams: Sequence[str] = ()) -> list[str]:
    """Write what was recorded into a file.

    Args:
        runs: folders of runs, or their trace.jsonl; several only for a table. What else `runs/*` names is left out.
        target: the file: .xlsx or .csv for a table, .svg, .pdf or .png for plots.
        streams: of plots, only these.

    Returns:
        Notes for the user.

    Raises:
        SheetsError: that cannot be made as such a file, or it cannot be written.
        UnreadableFile: one of the runs is no record of a run.
    """
    strays = [run for run in runs if run.is_file() and run.suffix != Path(TRACE).suffix]  # runs/faces.json
    runs = [run for run in runs if run not in strays] or runs
    suffix = target.suffix.casefold()
    _require(suffix, target, len(runs), streams)
    traces = [trace_of(run) for run in runs]
    _require_apart(traces, target)
    refuse_other_table(target)
    if suffix in TABLES:
        try:
            (write_csv if suffix == ".csv" else write_xlsx)(traces, target)
        except OSError as error:
            raise SheetsError(f"“{target}” cannot be written ({error.strerror}).", "Name another file.") from None
        return _pilots(traces)
    place = traces[0].parent
    svg, wide, high = draw_run_plots(place, streams)
    stamp = stamp_of(place)
    return write_picture(svg, (wide, high), target, title_of(stamp), dict(stamp.pairs()))


def _require(suffix: str, target: Path, runs: int, streams: Sequence[str]) -> None:
    if suffix not in (*TABLES, *PICTURES):
        raise SheetsError(
            f"A run cannot be exported as “{target.suffix or target.name}”.",
            f"Let the file's name end with {', '.join(TABLES)} for a table, {', '.join(PICTURES)} for plots.",
        )
    if streams and suffix in TABLES:
        raise SheetsError("Streams can be chosen for plots, not for a table.", "Leave out --streams.")
    if suffix in PICTURES and runs > 1:
        raise SheetsError("A picture is of one run.", "Name one run, or export a table: -o study.xlsx")


def trace_of(run: Path) -> Path:
    """The trace of a run's folder, or the trace that is named.

    Raises:
        UnreadableFile: there is none, or it does not begin as one.
    """
    trace = run / TRACE if run.is_dir() else run
    if not trace.is_file():
        raise UnreadableFile("FILE001", f"There is no run “{run}”.", "Name a run's folder; see `rrp-sheets runs`.")
    if trace.suffix != Path(TRACE).suffix:
        raise UnreadableFile(
            "FILE001", f"“{run}” is not a record of a run.", "Name a run's folder; see `rrp-sheets runs`."
        )
    if trace.name == TRACE:
        facts = facts_of(trace.parent)
        if not facts.readable:
            raise UnreadableFile("FILE001", f"“{run}” is not a record of a run: {facts.why}", facts.remedy)
    return trace


def _require_apart(traces: Sequence[Path], target: Path) -> None:
    """An export must not take the place of a record, nor a run be counted twice."""
    seen: set[Path] = set()
    for trace in traces:
        place = trace.resolve()
        if place in seen:
            raise SheetsError(f"The run “{trace.parent.name}” is named twice.", "Name every run once.")
        seen.add(place)
        if target.absolute().parent.resolve() == place.parent and target.name in ("protocol.xlsx", "run.xlsx"):
            raise SheetsError(f"“{target.name}” belongs to the record of the run.", "Give the file another name.")


def _pilots(traces: Sequence[Path]) -> list[str]:
    pilots = [t.parent.name for t in traces if stamp_of(t.parent).mode == "pilot"]
    if not pilots:
        return []
    named = ", ".join(pilots[:5]) + (f" and {len(pilots) - 5} more" if len(pilots) > 5 else "")
    return [f"A pilot, whose data never counts as a session: {named}. See the column mode." if len(traces) > 1
            else "This was a pilot: its data never counts as a session."]  # fmt: skip
