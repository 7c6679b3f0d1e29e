"""Recordings: their list, the page of one, its marble diagrams and plots, and the comparison of two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from flask import Blueprint, Response, jsonify, request
from markupsafe import Markup

from rrp_sheets.errors import SheetsError
from rrp_sheets.recording.listing import clock
from rrp_sheets.recording.metadata import RunMetadata
from rrp_sheets.texts import N_
from rrp_sheets.web.models import both, said, show
from rrp_sheets.web.requests import rows_asked, run_or_404
from rrp_sheets.web.runs.run_list import marbles_page, record_page, runs_page
from rrp_sheets.web.runs.run_store import RunLine, line_of
from rrp_sheets.web.services import services

blueprint = Blueprint("recordings", __name__)


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


@blueprint.get("/runs")
def runs() -> str:
    """Show the list of recordings."""
    book, words, participant = (request.args.get(n, "")[:300] for n in ("book", "words", "participant"))
    first = request.args.get("first", 0, type=int)
    return show(runs_page(book, words, max(0, first), participant))


@blueprint.get("/runs/pair")
def pair() -> str:
    """Show two recordings side by side."""
    return show(pair_page(request.args.getlist("run")))


@blueprint.get("/runs/<run>")
def record(run: str) -> str:
    """Show a recording."""
    return show(record_page(run_or_404(run), wait="read" in request.args))


@blueprint.get("/runs/<run>/written")
def written(run: str) -> Response:
    """Tell whether all files of a recording are written."""
    return jsonify(run_or_404(run) not in services().runs.writing())


@blueprint.get("/runs/<run>/marbles")
def marbles(run: str) -> str:
    """Show marble diagrams of a recording."""
    return show(marbles_page(run_or_404(run), request.args, rows_asked()))


@blueprint.get("/runs/<run>/series.json")
def series(run: str) -> Response:
    """Send the numbers of a recording over time, for its plots."""
    try:
        return jsonify(services().queries.course(services().runs.place(run_or_404(run)))["curves"])
    except SheetsError:  # the page says what is wrong with it
        return jsonify([])


def pair_page(chosen: Sequence[str]) -> PairPage:
    """Compare two runs.

    Raises:
        SheetsError: they are not two, or there is no such run.
    """
    names = list(dict.fromkeys(chosen))
    if len(names) != 2:
        message = N_("{n} run chosen." if len(names) == 1 else "{n} runs chosen.", n=len(names))
        raise SheetsError(
            message if names else N_("No runs chosen."), N_("Tick two runs in the list of runs, and compare them.")
        )
    runs = services().runs
    places = [runs.place(name) for name in names]
    facts = sorted(runs.facts(names), key=lambda f: (f.began.timestamp() if f.began else 0.0, f.run))
    places.sort(key=lambda p: [f.run for f in facts].index(p.name))
    books = set(services().repository.names())
    lines = (line_of(facts[0], books), line_of(facts[1], books))
    answer: dict[str, Any] = {"streams": [], "svg": ""}
    trouble = ""
    try:
        answer = services().exporter.ask(both(names), "pair_table", str(places[0]), str(places[1]))
    except SheetsError as error:
        trouble = said(error)
    same = bool(facts[0].digest) and facts[0].digest == facts[1].digest
    return PairPage(
        lines, tuple(_beside(facts, lines)), same, tuple(_stream(s) for s in answer["streams"]), Markup(answer["svg"]),
        trouble,
    )  # fmt: skip


def _beside(facts: Sequence[RunMetadata], lines: Sequence[RunLine]) -> list[Beside]:
    rows = [
        (N_("Workbook"), *(f.workbook for f in facts)), (N_("Participant"), *(f.participant for f in facts)),
        (N_("Condition"), *(f.condition for f in facts)), (N_("Operator"), *(f.operator for f in facts)),
        (N_("Mode"), *(f.mode for f in facts)), (N_("Length"), *(line.length for line in lines)),
        (N_("How it ended"), *(line.ended for line in lines)),
        (N_("Errors"), *(f"{line.errors:,}" for line in lines)), (N_("Seed"), *(f.seed for f in facts)),
        (N_("Robot"), *(f.robot for f in facts)), (N_("Program"), *(f.program for f in facts)),
        (N_("Workbook SHA-256"), *(f.digest[:12] for f in facts)),
    ]  # fmt: skip
    return [Beside(name, (a, b), a == b) for name, a, b in rows if a or b]


def _stream(answer: dict[str, Any]) -> StreamPair:
    counts, firsts = answer["counts"], answer["firsts"]
    pairs = ([_many(c) for c in counts], [_at(t) for t in firsts])
    cells = [(words, both[0] != both[1]) for both in pairs for words in both]
    return StreamPair(str(answer["name"]), str(answer["kind"]), tuple(cells))


def _many(count: int | None) -> str:
    return N_("not in it") if count is None else f"{count:,}"


def _at(seconds: float | None) -> str:
    return "" if seconds is None else clock(seconds)
