"""The kinds of files that runs are exported to, tables and plots among them; the comparison of two runs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import TABLE, TRACE, WORKBOOK, RecordedFailure, RecordedValue, Stamp
from rrp_sheets.recording.metadata import metadata_of, stamp_of
from rrp_sheets.recording.table import refuse_other_table, write_csv, write_xlsx
from rrp_sheets.recording.timeline import build_timeline
from rrp_sheets.recording.trace_reader import TraceReader, text_of
from rrp_sheets.render.output import render_picture
from rrp_sheets.render.plots import Curve, PlotNote, draw_plots
from rrp_sheets.render.texts import texts
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook.files import unwritable, write_atomically

XLSX = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"
PICTURE_TYPES = {".svg": "image/svg+xml", ".pdf": "application/pdf", ".png": "image/png"}


@dataclass(frozen=True)
class ExportKind:
    """A kind of file that recorded runs are exported to.

    Attributes:
        name: of a file that is downloaded, before its suffix.
        types: the suffixes of its formats, each with the media type; no two kinds share one. Of a kind that takes
            several runs, the first has a full label on the page Runs (runs.html), and the page of two runs links to
            “.xlsx” (runpair.html).
        write: writes traces to a file, of a picture only these streams (all when empty); returns notes for the user.
        links: the suffixes that the page of a run offers, each with the words beside its link.
        picture: whether it shows the numbers of one run; any other takes several runs, and all that they recorded.
    """

    name: str
    title: str
    types: Mapping[str, str]
    write: Callable[[Sequence[Path], Path, Sequence[str]], list[str]]
    links: Mapping[str, str]
    picture: bool = False


def export_kind(suffix: str) -> ExportKind | None:
    """Return the kind of export that has this suffix; None when there is none."""
    return next((kind for kind in EXPORTS if suffix in kind.types), None)


def export(runs: Sequence[Path], target: Path, streams: Sequence[str] = ()) -> list[str]:
    """Write recorded runs into a file, of the kind of its suffix; see `api.export`."""
    strays = [run for run in runs if run.is_file() and run.suffix != Path(TRACE).suffix]  # runs/faces.json
    runs = [run for run in runs if run not in strays] or runs
    kind = export_kind(target.suffix.casefold())
    if kind is None:
        kinds = [N_("{suffixes} for {title}", suffixes=", ".join(k.types), title=k.title) for k in EXPORTS]
        message = N_("A run cannot be exported as “{suffix}”.", suffix=target.suffix or target.name)
        raise SheetsError(message, N_("Let the file's name end with {kinds}.", kinds=listed(kinds)))
    if streams and not kind.picture:
        message = N_("Streams can be chosen for plots, not for {title}.", title=kind.title)
        raise SheetsError(message, N_("Leave out --streams."))
    if kind.picture and len(runs) > 1:
        raise SheetsError(N_("A picture is of one run."), N_("Name one run, or export a table: -o study.xlsx"))
    traces = [trace_of(run) for run in runs]
    _require_apart(traces, target)
    refuse_other_table(target)
    notes = kind.write(traces, target, streams)
    return notes if kind.picture else [*notes, *_pilots(traces)]


def trace_of(run: Path) -> Path:
    """Return the trace of a run's folder, or the one that is named; raise UnreadableFile when it is none."""
    trace = run / TRACE if run.is_dir() else run
    remedy = N_("Name a run's folder; see `rrp-sheets runs`.")
    if not trace.is_file():
        raise UnreadableFile("FILE001", N_("There is no run “{run}”.", run=run), remedy)
    if trace.suffix != Path(TRACE).suffix:
        raise UnreadableFile("FILE001", N_("“{run}” is not the recording of a run.", run=run), remedy)
    if trace.name == TRACE:
        metadata = metadata_of(trace.parent)
        if not metadata.readable:
            message = N_("“{run}” is not the recording of a run: {why}", run=run, why=metadata.why)
            raise UnreadableFile("FILE001", message, metadata.remedy)
    return trace


def _require_apart(traces: Sequence[Path], target: Path) -> None:
    """Raise SheetsError when an export would replace a part of a record, or a run is named twice."""
    seen: set[Path] = set()
    for trace in traces:
        place = trace.resolve()
        if place in seen:
            raise SheetsError(N_("The run “{run}” is named twice.", run=trace.parent.name), N_("Name every run once."))
        seen.add(place)
        if target.absolute().parent.resolve() == place.parent and target.name in (WORKBOOK, TABLE):
            message = N_("“{name}” belongs to the recording of the run.", name=target.name)
            raise SheetsError(message, N_("Give the file another name."))


def _pilots(traces: Sequence[Path]) -> list[str]:
    pilots = [t.parent.name for t in traces if stamp_of(t.parent).mode == "pilot"]
    if not pilots:
        return []
    if len(traces) == 1:
        return [N_("This was a pilot: its data never counts as a session.")]
    names = ", ".join(pilots[:5])
    if len(pilots) > 5:
        names = N_("{names} and {n} more", names=names, n=len(pilots) - 5)
    return [N_("A pilot, whose data never counts as a session: {names}. See the column mode.", names=names)]


def _write_table(traces: Sequence[Path], target: Path, streams: Sequence[str]) -> list[str]:
    try:
        (write_csv if target.suffix.casefold() == ".csv" else write_xlsx)(traces, target)
    except OSError as error:
        raise unwritable(target, error) from None
    return []


_LANES = {
    "say": "said", "person": "heard", "sound": "said", "press": "button", "button": "button", "mark": "mark",
    "error": "error", "note": "note", "clamp": "note",
}  # fmt: skip


def _write_plots(traces: Sequence[Path], target: Path, streams: Sequence[str]) -> list[str]:
    """Draw the numbers of a run over time; raise SheetsError when there are none."""
    place = traces[0].parent
    told = build_timeline(place, streams)
    curves = [_curve(curve) for curve in told["curves"]]
    if not curves:
        raise _nothing(place, streams)
    lines = (e for e in told["lines"] if e["kind"] != "command")  # the curves of the actuators tell those
    notes = [PlotNote(e["t"], e["until"], _LANES.get(e["kind"], "by_hand"), e["text"]) for e in lines]
    stamp = stamp_of(place)
    title, about, left_out = title_of(stamp), dict(stamp.pairs()), told["more_curves"]
    more = texts(stamp.language).get("plots.more", n=left_out) if left_out else ""
    svg, wide, high = draw_plots(
        title, curves, notes, float(told["seconds"]), foot=stamp.line(), more=more, about=about,
        language=stamp.language,
    )  # fmt: skip
    content, warnings = render_picture(svg, wide, high, target.suffix.casefold(), title, about)
    write_atomically(target, content)
    return warnings


EXPORTS = (
    ExportKind(
        "trace", N_("a table"), {".xlsx": XLSX, ".csv": "text/csv"}, _write_table,
        links={".csv": N_("one row per event")},
    ),
    ExportKind(
        "plots", N_("plots"), PICTURE_TYPES, _write_plots,
        links={".pdf": N_("its numbers over time"), ".svg": N_("the same, to be edited")}, picture=True,
    ),
)  # fmt: skip


def _nothing(place: Path, only: Collection[str]) -> SheetsError:
    if not only:
        message = N_("“{name}” has no numbers that change.", name=place.name)
        return SheetsError(message, N_("Export it as a table: -o run.xlsx"))
    known = [c["name"] for c in build_timeline(place)["curves"]]
    numbers = N_("Streams with numbers are: {names}.", names=", ".join(known[:20]))
    remedy = numbers if known else N_("This run has no numbers at all.")
    return SheetsError(N_("No stream called {names} has numbers.", names=", ".join(only)), remedy)


def title_of(stamp: Stamp) -> str:
    """Return the heading of a picture of a run."""
    who = ", ".join(filter(None, (stamp.participant, stamp.condition)))
    return f"{stamp.workbook or stamp.run}{f', {who}' if who else ''}, {stamp.began[:16].replace('T', ' ')}"


# ---- two runs beside each other
_MOST_STREAMS = 5_000


@dataclass
class _Seen:
    name: str
    kind: str
    count: int = 0
    first: float | None = None  # time of the first value (s)


def pair(first: Path, second: Path) -> dict[str, Any]:
    """Compare two runs, as JSON: `streams` with the counts and first times of both, and `svg`, blank without numbers.

    It raises UnreadableFile when one of them is no record of a run.
    """
    left, right = _streams_of(first), _streams_of(second)
    streams = []
    for k in dict.fromkeys([*left, *right]):
        both = left.get(k), right.get(k)
        known = both[0] or right[k]
        counts, firsts = [s.count if s else None for s in both], [s.first if s else None for s in both]
        streams.append({"name": known.name, "kind": known.kind, "counts": counts, "firsts": firsts})
    return {"streams": streams, "svg": _overlaid(first, second)}


def _streams_of(place: Path) -> dict[str, _Seen]:
    """Return the streams of a run by key, in the order of its record; errors of a row are one more, `row: error`."""
    reader = TraceReader(place)
    streams = [(text_of(stream.name), stream.kind) for stream in reader.header.streams]
    found = {key(name): _Seen(name, kind) for name, kind in streams}
    for event in reader:
        if isinstance(event, RecordedFailure):
            name, kind = f"{text_of(event.row)}: error", event.kind
        elif isinstance(event, RecordedValue):
            name, kind = text_of(event.stream), "stream"
        else:
            continue
        seen = found.get(key(name))
        if seen is None and len(found) < _MOST_STREAMS:
            seen = found[key(name)] = _Seen(name, kind)
        if seen is not None:
            seen.count += 1
            seen.first = event.t if seen.first is None else seen.first
    return found


def _overlaid(first: Path, second: Path) -> str:
    """Draw the numbers of both runs over each other; those that both have come first."""
    told = [build_timeline(first), build_timeline(second)]
    left, right = ({key(c["name"]): c for c in one["curves"]} for one in told)
    names = sorted(dict.fromkeys([*left, *right]), key=lambda name: (name not in left) + (name not in right))
    if not names:
        return ""
    drawn = [_curve(left.get(name), right.get(name)) for name in names]
    stamps = [stamp_of(first), stamp_of(second)]
    foot = "\n".join(stamp.line() for stamp in stamps)
    seconds = max(float(one["seconds"]) for one in told)
    language = stamps[0].language
    say = texts(language)
    legend = (say.get("plots.first"), say.get("plots.second"))
    return draw_plots(say.get("plots.both"), drawn, [], seconds, foot=foot, legend=legend, language=language)[0]


def _curve(left: dict[str, Any] | None, right: dict[str, Any] | None = None) -> Curve:
    known: Any = left or right
    points, others = ([(t, v) for t, v in c["points"]] if c else [] for c in (left, right))
    return Curve(known["name"], known["kind"], known["unit"], points, left["count"] if left else 0, others)
