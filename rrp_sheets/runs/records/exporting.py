"""Exports of runs: a table, plots, a contact sheet; what is made follows from the file's suffix unless it is said."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.render.picture import SUFFIXES as PICTURES
from rrp_sheets.render.picture import write_picture
from rrp_sheets.runs.records.facts import TRACE, facts_of
from rrp_sheets.runs.records.pictures import draw_run_contact, draw_run_plots, title_of
from rrp_sheets.runs.records.replacing import refuse_other_table
from rrp_sheets.runs.records.stamp import stamp_of
from rrp_sheets.runs.records.table import write_csv, write_xlsx

TABLES = (".xlsx", ".csv")
KINDS = ("table", "plots", "contact")
_USUAL = {".xlsx": "table", ".csv": "table", ".svg": "plots", ".pdf": "plots", ".png": "contact"}


def export(runs: Sequence[Path], target: Path, what: str = "", streams: Sequence[str] = ()) -> list[str]:
    """Write what was recorded into a file.

    Args:
        runs: folders of runs, or their trace.jsonl; several only for a table. What else `runs/*` names is left out.
        target: the file; its suffix tells the format.
        what: `table`, `plots`, `contact` (pictures of moments); blank: what is usual for the suffix.
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
    what = what or _USUAL.get(suffix, "")
    _require(what, suffix, target, len(runs), streams)
    traces = [trace_of(run) for run in runs]
    _require_apart(traces, target)
    refuse_other_table(target)
    if what == "table":
        try:
            (write_csv if suffix == ".csv" else write_xlsx)(traces, target)
        except OSError as error:
            raise SheetsError(f"“{target}” cannot be written ({error.strerror}).", "Name another file.") from None
        return _pilots(traces)
    place = traces[0].parent
    svg, wide, high = draw_run_contact(place) if what == "contact" else draw_run_plots(place, streams)
    stamp = stamp_of(place)
    return write_picture(svg, (wide, high), target, title_of(stamp), dict(stamp.pairs()))


def _require(what: str, suffix: str, target: Path, runs: int, streams: Sequence[str]) -> None:
    if not what or suffix not in (*TABLES, *PICTURES):
        raise SheetsError(
            f"A run cannot be exported as “{target.suffix or target.name}”.",
            f"Let the file's name end with {', '.join(TABLES)} for a table, {', '.join(PICTURES)} for a picture.",
        )
    if (what == "table") != (suffix in TABLES):
        fitting = ", ".join(TABLES if what == "table" else PICTURES)
        raise SheetsError(f"“{target.name}” cannot hold a {what}.", f"Let its name end with one of: {fitting}.")
    if streams and what != "plots":
        raise SheetsError(f"Streams can be chosen for plots, not for a {what}.", "Leave out --streams.")
    if what != "table" and runs > 1:
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
