"""Two runs side by side: how often each stream had a value and when first, and their numbers over one another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.engine.trace import read_trace
from rrp_sheets.model.names import key
from rrp_sheets.render.plots import Curve, draw_plots
from rrp_sheets.render.texts import texts
from rrp_sheets.runs.records.metadata import TRACE, text_of
from rrp_sheets.runs.records.stamp import stamp_of
from rrp_sheets.runs.records.tidy import unreadable
from rrp_sheets.runs.records.timeline import build_timeline

_MOST_STREAMS = 5_000


@dataclass
class Seen:
    """How often a stream had a value, and when first and last (s)."""

    name: str
    kind: str
    count: int = 0
    first: float | None = None
    last: float | None = None


def pair(first: Path, second: Path) -> dict[str, Any]:
    """Two runs compared, as JSON: `streams` with the counts and first times of both, and `svg`, blank without numbers.

    Args:
        first: the folder of a run.
        second: that of another.

    Raises:
        UnreadableFile: when one of them is no record of a run.
    """
    left, right = streams_of(first), streams_of(second)
    names = list(dict.fromkeys([*left, *right]))
    return {
        "streams": [_both(left.get(n), right.get(n)) for n in names],
        "svg": _overlaid(first, second),
    }


def streams_of(place: Path) -> dict[str, Seen]:
    """The streams of a run by key, in the order of its record; errors of rows are told apart as `row: error`."""
    found: dict[str, Seen] = {}
    trace = place / TRACE
    try:
        for entry in read_trace(trace):
            if entry.get("type") == "header":
                for told in entry.get("streams") or ():
                    name = text_of(told["stream"])
                    found[key(name)] = Seen(name, text_of(told["kind"]))
            elif "t" in entry:
                _note(found, entry)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise unreadable(trace) from None
    return found


def _note(found: dict[str, Seen], entry: dict[str, Any]) -> None:
    if "error" in entry:
        name, kind = f"{text_of(entry.get('row'))}: error", "error"
    elif "value" in entry:
        name, kind = text_of(entry.get("stream")), "stream"
    else:
        return
    seen = found.get(key(name))
    if seen is None:
        if len(found) >= _MOST_STREAMS:
            return
        seen = found[key(name)] = Seen(name, kind)
    t = float(entry["t"])
    seen.count += 1
    seen.last = t
    if seen.first is None:
        seen.first = t


def _both(left: Seen | None, right: Seen | None) -> dict[str, Any]:
    known = left or right
    assert known is not None
    return {
        "name": known.name, "kind": known.kind,
        "counts": [s.count if s else None for s in (left, right)],
        "firsts": [s.first if s else None for s in (left, right)],
    }  # fmt: skip


def _overlaid(first: Path, second: Path) -> str:
    """The numbers of both runs; those that both have come first."""
    told = [build_timeline(first), build_timeline(second)]
    curves = [{key(c["name"]): c for c in one["curves"]} for one in told]
    names = sorted(dict.fromkeys([*curves[0], *curves[1]]), key=lambda n: (n not in curves[0]) + (n not in curves[1]))
    if not names:
        return ""
    drawn = [_curve(curves[0].get(name), curves[1].get(name)) for name in names]
    stamps = [stamp_of(first), stamp_of(second)]
    foot = "\n".join(stamp.line() for stamp in stamps)
    seconds = max(float(one["seconds"]) for one in told)
    language = stamps[0].language
    say = texts(language)
    legend = (say.get("plots.first"), say.get("plots.second"))
    return draw_plots(say.get("plots.both"), drawn, [], seconds, foot=foot, legend=legend, language=language)[0]


def _curve(left: dict[str, Any] | None, right: dict[str, Any] | None) -> Curve:
    known: Any = left or right
    return Curve(
        known["name"], known["kind"], known["unit"], _points(left), left["count"] if left else 0, _points(right)
    )


def _points(curve: dict[str, Any] | None) -> Sequence[tuple[float, float]]:
    return [(t, v) for t, v in curve["points"]] if curve else []
