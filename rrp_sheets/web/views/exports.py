"""Exports of recorded runs (plots, marble diagrams, tables), and the comparison of two runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from flask import Blueprint, Response, abort, render_template, request, send_file
from markupsafe import Markup

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.records.listing import clock
from rrp_sheets.runs.records.metadata import RunMetadata
from rrp_sheets.runs.records.query_worker import QueryWorker
from rrp_sheets.web.runs.record_pages import RunLine
from rrp_sheets.web.runs.run_list import seconds_of
from rrp_sheets.web.runs.run_store import RunStore, line_of, made
from rrp_sheets.web.views.run_deletion import add_deleting
from rrp_sheets.web.workbook_repository import WorkbookRepository

WITHIN = 150.0  # s: a table of a long run takes its time
MOST_RUNS = 500  # in one table
_PICTURES = {".svg": "image/svg+xml", ".png": "image/png", ".pdf": "application/pdf"}
_TABLES = {
    ".csv": "text/csv", ".xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Beside:
    """Property of two runs; `same` when it is the same in both."""

    name: str
    values: tuple[str, str]
    same: bool


@dataclass(frozen=True, slots=True)
class StreamPair:
    """Stream in two runs: the number of values and the time of the first in words, each with whether it differs."""

    name: str
    kind: str
    cells: tuple[tuple[str, bool], ...]


@dataclass(frozen=True, slots=True)
class PairPage:
    """Comparison of two runs side by side.

    Attributes:
        lines: the two, as lists show them.
        same_book: whether the same workbook ran, by its SHA-256.
        drawing: the plots of both runs in one picture, as trusted SVG.
        trouble: why there is nothing to show.
    """

    template: ClassVar[str] = "runpair.html"
    lines: tuple[RunLine, RunLine]
    facts: tuple[Beside, ...]
    same_book: bool
    streams: tuple[StreamPair, ...]
    drawing: Markup
    trouble: str


def add_keeping(pages: Blueprint, repository: WorkbookRepository, runs: RunStore, exporter: QueryWorker) -> None:
    """Add the routes for exports, for the comparison of two runs, and for deleting."""
    _add_exports(pages, runs, exporter)

    @pages.get("/runs/pair", endpoint="pair")
    def two() -> str:
        page = pair_page(runs, repository, exporter, request.args.getlist("run"))
        return render_template(page.template, page=page)

    add_deleting(pages, repository, runs, exporter)


def _add_exports(pages: Blueprint, runs: RunStore, exporter: QueryWorker) -> None:
    @pages.get("/runs/<run>/plots.<any(svg,png,pdf):form>", endpoint="plots")
    def drawn(run: str, form: str) -> Response:
        if run not in runs.names():
            abort(404)
        return _made(exporter, [runs.place(run)], f".{form}", f"{run}-plots", take="take" in request.args)

    @pages.get("/runs/<run>/marbles.<any(svg,png,pdf):form>", endpoint="marbles_file")
    def marbles(run: str, form: str) -> Response:
        if run not in runs.names():
            abort(404)
        rows = [int(r) for r in request.args.getlist("row") if r.isdecimal() and len(r) < 7][:MOST_RUNS]
        behaviour, *window = (request.args.get(name, "")[:300] for name in ("behaviour", "from", "to"))
        asked = (str(runs.place(run)), behaviour, rows, [seconds_of(w) for w in window])
        return _answered(f".{form}", f"{run}-marbles", True, lambda to: exporter.ask(run, "marbles", *asked, str(to)))

    @pages.get("/runs/table.<any(csv,xlsx):kind>", endpoint="table")
    def table(kind: str) -> Response:
        chosen = request.args.getlist("run")[:MOST_RUNS]
        if not chosen:
            raise SheetsError("No run is chosen.", "Tick the runs that the table shall have.")
        places = [runs.place(run) for run in dict.fromkeys(chosen)]
        return _made(exporter, places, f".{kind}", places[0].name if len(places) == 1 else "runs", take=True)


def _made(exporter: QueryWorker, places: Sequence[Path], suffix: str, name: str, *, take: bool) -> Response:
    """Create an export, and send it."""
    asked = [str(place) for place in places]
    return _answered(suffix, name, take, lambda to: exporter.ask(places[0].name, "export", asked, str(to)))


def _answered(suffix: str, name: str, take: bool, make: Callable[[Path], object]) -> Response:
    """Send a temporary file that `make` writes to the path it is given."""
    file = made(f"made{suffix}", make)
    kind = {**_PICTURES, **_TABLES}[suffix]
    return send_file(file, mimetype=kind, as_attachment=take, download_name=f"{name}{suffix}")


# ---- two runs


def pair_page(runs: RunStore, repository: WorkbookRepository, exporter: QueryWorker, chosen: Sequence[str]) -> PairPage:
    """Compare two runs.

    Raises:
        SheetsError: they are not two, or there is no such run.
    """
    names = list(dict.fromkeys(chosen))
    if len(names) != 2:
        raise SheetsError(f"{len(names) or 'No'} run{'' if len(names) == 1 else 's'} chosen.",
                          "Tick two runs in the list of runs, and compare them.")  # fmt: skip
    places = [runs.place(name) for name in names]
    facts = sorted(runs.facts(names), key=lambda f: (f.began.timestamp() if f.began else 0.0, f.run))
    places.sort(key=lambda p: [f.run for f in facts].index(p.name))
    books = set(repository.names())
    lines = (line_of(facts[0], books), line_of(facts[1], books))
    told: dict[str, Any] = {"streams": [], "svg": ""}
    trouble = ""
    try:
        told = exporter.ask(f"{names[0]} and {names[1]}", "pair", str(places[0]), str(places[1]))
    except SheetsError as error:
        trouble = f"{error.message} {error.remedy}"
    same = bool(facts[0].digest) and facts[0].digest == facts[1].digest
    return PairPage(
        lines, tuple(_beside(facts, lines)), same, tuple(_stream(s) for s in told["streams"]), Markup(told["svg"]),
        trouble,
    )  # fmt: skip


def _beside(facts: Sequence[RunMetadata], lines: Sequence[RunLine]) -> list[Beside]:
    rows = [
        ("Workbook", *(f.workbook for f in facts)), ("Participant", *(f.participant for f in facts)),
        ("Condition", *(f.condition for f in facts)), ("Operator", *(f.operator for f in facts)),
        ("Mode", *(f.mode for f in facts)), ("Length", *(line.length for line in lines)),
        ("How it ended", *(line.ended for line in lines)),
        ("Errors", *(f"{line.errors:,}" for line in lines)), ("Seed", *(f.seed for f in facts)),
        ("Robot", *(f.robot for f in facts)), ("Program", *(f.program for f in facts)),
        ("Workbook SHA-256", *(f.digest[:12] for f in facts)),
    ]  # fmt: skip
    return [Beside(name, (a, b), a == b) for name, a, b in rows if a or b]


def _stream(told: dict[str, Any]) -> StreamPair:
    counts, firsts = told["counts"], told["firsts"]
    pairs = ([_many(c) for c in counts], [_at(t) for t in firsts])
    cells = [(words, told_both[0] != told_both[1]) for told_both in pairs for words in told_both]
    return StreamPair(str(told["name"]), str(told["kind"]), tuple(cells))


def _many(count: int | None) -> str:
    return "not in it" if count is None else f"{count:,}"


def _at(seconds: float | None) -> str:
    return "" if seconds is None else clock(seconds)
