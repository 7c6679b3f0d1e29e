"""Plots of a run's numbers, made of its record."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.stamp import Stamp
from rrp_sheets.render.plots import Curve, Note, draw_plots
from rrp_sheets.render.texts import texts
from rrp_sheets.runs.records.stamp import stamp_of
from rrp_sheets.runs.records.timeline import build_timeline

_LANES = {
    "say": "said", "person": "heard", "sound": "said", "press": "button", "button": "button", "mark": "mark",
    "error": "error", "note": "note", "clamp": "note",
}  # fmt: skip


def draw_run_plots(place: Path, only: Collection[str] = ()) -> tuple[str, float, float]:
    """The numbers of a run over time, as SVG with its width and height in points.

    Args:
        place: the run's folder.
        only: these streams; all when empty.

    Raises:
        UnreadableFile: when it is no trace.
        SheetsError: there are no numbers to plot.
    """
    told = build_timeline(place, only)
    curves = [Curve(c["name"], c["kind"], c["unit"], [(t, v) for t, v in c["points"]], c["count"])
              for c in told["curves"]]  # fmt: skip
    if not curves:
        raise _nothing(place, only)
    notes = [
        Note(e["t"], e["until"], _LANES.get(e["kind"], "by_hand"), e["text"])
        for e in told["lines"]
        if e["kind"] != "command"
    ]  # the curves of the actuators tell those
    stamp = stamp_of(place)
    more = ""
    if told["more_curves"]:
        more = texts(stamp.language).get("plots.more", n=told["more_curves"])
    return draw_plots(
        title_of(stamp),
        curves,
        notes,
        float(told["seconds"]),
        foot=stamp.line(),
        more=more,
        about=dict(stamp.pairs()),
        language=stamp.language,
    )


def _nothing(place: Path, only: Collection[str]) -> SheetsError:
    if not only:
        return SheetsError(f"“{place.name}” has no numbers that change.", "Export it as a table: -o run.xlsx")
    known = [c["name"] for c in build_timeline(place)["curves"]]
    remedy = f"Streams with numbers are: {', '.join(known[:20])}." if known else "This run has no numbers at all."
    return SheetsError(f"No stream called {', '.join(only)} has numbers.", remedy)


def title_of(stamp: Stamp) -> str:
    """What stands above a picture of a run."""
    who = ", ".join(filter(None, (stamp.participant, stamp.condition)))
    return f"{stamp.workbook or stamp.run}{f', {who}' if who else ''}, {stamp.began[:16].replace('T', ' ')}"
