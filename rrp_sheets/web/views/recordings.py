"""Recordings: their list, the page of one, its marble diagrams and plots, and the comparison of two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from flask import Blueprint, Response, jsonify, request
from markupsafe import Markup

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import DIAGRAM, FILM, STRIP, TABLE, TRACE, WORKBOOK
from rrp_sheets.recording import exporting
from rrp_sheets.recording.folder import describe
from rrp_sheets.recording.metadata import EXACT, RunMetadata, clock, length, newest_first, who
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.web.models import both, error_text, show
from rrp_sheets.web.requests import page_language, rows_asked, run_or_404, seconds_of
from rrp_sheets.web.run_store import PICTURES, RunLine, line_of, when
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import WorkbookRepository

blueprint = Blueprint("recordings", __name__)
A_PAGE = 100  # runs
_BESIDE = 30  # further runs of the same workbook
_LOG = 500
_EDITS = 4  # rows that are named as changed
_WHOLE = 40.0  # s: a run that is longer shows its first half minute
_FIRST = 30.0
_LONG = 12_000_000  # bytes of a record that takes more than a second to be read
_KINDS = {
    "say": (N_("said"), "say"), "command": (N_("command"), "gesture"), "person": (N_("a person"), "say"),
    "sound": (N_("played"), "sound"),
    "error": (N_("error"), "error"), "clamp": (N_("cut to its limit"), "warning"),
    "note": (N_("note"), "mark"), "mark": (N_("mark"), "flag"),
    "edit": (N_("edited"), "sheet"), "button": (N_("button"), "button"),
    "press": (N_("button"), "button"),
    "send": (N_("sent by hand"), "send"), "scene": (N_("scene, by hand"), "ball"),
    "put": (N_("moved by hand"), "ball"),
    "switch": (N_("switched"), "subscribe"), "speed": (N_("speed"), "run"), "pause": (N_("paused"), "pause"),
    "resume": (N_("went on"), "run"), "step": (N_("one frame on"), "step"),
}  # fmt: skip
_ENGINES = {"frame": N_("frame engine"), "event loop": N_("event loop engine")}


@dataclass(frozen=True, slots=True)
class RunsPage:
    """List of the recorded runs of the folder, only those of a `book` and a `participant` and with some `words`.

    Attributes:
        total: how many runs there are; `older` the offset of the next page, 0 on the last one.
        found: how many of them match; `lines_from` the number of the first that is shown.
    """

    template: ClassVar[str] = "runs.html"
    lines: tuple[RunLine, ...]
    book: str
    words: str
    books: tuple[str, ...]
    total: int
    older: int
    here: bool = False
    participant: str = ""
    participants: tuple[str, ...] = ()
    found: int = 0
    lines_from: int = 1

    @property
    def tables(self) -> list[str]:
        """Formats that take several runs."""
        return [suffix[1:] for kind in exporting.EXPORTS if not kind.picture for suffix in kind.types]


@dataclass(frozen=True, slots=True)
class LogLine:
    """Entry of a run's log; `at` is in seconds, `when` in words."""

    at: float
    when: str
    kind: str
    word: str
    icon: str
    text: str
    row: str
    by: str
    sound: str


@dataclass(frozen=True, slots=True)
class RecordPage:
    """Page of one recorded run; `trouble` says why its events cannot be read.

    Attributes:
        others: further runs of the same workbook.
        facts: the name and the value of each property, and whether it is code.
        same: whether the workbook in the folder is the one that ran: `same`, `changed`, `gone`, `unknown`.
        downloads: the name of each file, what it is, and its size.
        edits: the rows that were changed first, when, and their line in the log, or 0; `more_edits` counts the others.
        writing: its last files are still being written.
        window: the seconds that the marbles show at first.
        reading: the size of the record, when it is still to be read; empty when its content is shown.
    """

    template: ClassVar[str] = "record.html"
    line: RunLine
    others: tuple[RunLine, ...]
    facts: tuple[tuple[str, str, bool], ...]
    same: str
    pictures: frozenset[str]
    exports: tuple[exporting.ExportKind, ...]
    downloads: tuple[tuple[str, str, str], ...]
    log: tuple[LogLine, ...]
    left_out: int
    sounds: tuple[str, ...]
    errors: Mapping[str, int]
    edits: tuple[tuple[str, str, int], ...]
    more_edits: int
    trouble: str
    writing: bool
    events: str
    window: tuple[str, str]
    curves: int
    compared_with: tuple[RunLine, ...]
    participant: str = ""
    reading: str = ""


@dataclass(frozen=True, slots=True)
class MarblesPage:
    """Marble diagrams of a run, a fragment of its page.

    Attributes:
        rows: number, connector and formula, whether it is shown.
        spread: whether a busy time is drawn in several strips.
    """

    template: ClassVar[str] = "marbles.html"
    run: str
    behaviours: tuple[str, ...]
    behaviour: str
    rows: tuple[tuple[int, str, bool], ...]
    all_rows: bool
    first: str
    last: str
    seconds: str
    spread: bool
    pictures: tuple[Markup, ...]
    left_out: int
    trouble: str

    @property
    def ticked(self) -> list[int]:
        """Numbers of the rows that were asked for; empty for all."""
        return [] if self.all_rows else [number for number, _, shown in self.rows if shown]


@dataclass(frozen=True, slots=True)
class PairPage:
    """Comparison of two runs side by side.

    Attributes:
        facts: the name of each property, and its value in both runs.
        streams: the name and kind of each, and its cells: the number of values and the time of the first in both runs,
            each with whether it differs.
        drawing: the plots of both runs in one picture.
    """

    template: ClassVar[str] = "runpair.html"
    lines: tuple[RunLine, RunLine]
    facts: tuple[tuple[str, str, str], ...]
    same_book: bool
    streams: tuple[tuple[str, str, tuple[tuple[str, bool], ...]], ...]
    drawing: Markup
    trouble: str


@blueprint.get("/runs")
def runs() -> str:
    """Show the list of recordings."""
    book, words, participant = (request.args.get(n, "")[:300] for n in ("book", "words", "participant"))
    first = max(0, request.args.get("first", 0, type=int))
    runs, books = services().runs, set(services().repository.names())
    every = newest_first(runs.metadata(runs.names()))
    found = [
        f for f in every
        if (not book or f.workbook == book) and (not participant or f.participant == participant) and _has(f, words)
    ]  # fmt: skip
    shown = found[first : first + A_PAGE]
    return show(RunsPage(
        tuple(line_of(f, books) for f in shown), book, words, _choices({f.workbook for f in every}, book), len(every),
        first + A_PAGE if len(found) > first + A_PAGE else 0, book in books, participant,
        _choices({f.participant for f in every}, participant), len(found), first + 1,
    ))  # fmt: skip


@blueprint.get("/runs/pair")
def pair() -> str:
    """Show two recordings side by side, the earlier one first."""
    names = list(dict.fromkeys(request.args.getlist("run")))
    if len(names) != 2:
        message = N_("{n} run chosen." if len(names) == 1 else "{n} runs chosen.", n=len(names))
        remedy = N_("Tick two runs in the list of runs, and compare them.")
        raise SheetsError(message if names else N_("No runs chosen."), remedy)
    runs = services().runs
    places = {name: str(runs.place(name)) for name in names}
    metadata = sorted(runs.metadata(names), key=lambda f: (f.began.timestamp() if f.began else 0.0, f.run))
    books = set(services().repository.names())
    lines = (line_of(metadata[0], books), line_of(metadata[1], books))
    answer: dict[str, Any] = {"streams": [], "svg": ""}
    trouble = ""
    try:
        answer = services().exporter.ask(both(names), "pair_table", *(places[f.run] for f in metadata))
    except SheetsError as error:
        trouble = error_text(error)
    same = bool(metadata[0].digest) and metadata[0].digest == metadata[1].digest
    streams = tuple(_stream(stream) for stream in answer["streams"])
    return show(PairPage(lines, tuple(_beside(metadata, lines)), same, streams, Markup(answer["svg"]), trouble))


@blueprint.get("/runs/<run>")
def record(run: str) -> str:
    """Show a recording; one that takes long to be read only on its own request, for which the address says `read`."""
    runs, repository = services().runs, services().repository
    place = runs.place(run_or_404(run))
    metadata = runs.metadata([run])[0]
    books = set(repository.names())
    others = [f for f in runs.metadata(runs.names()[:300]) if f.workbook == metadata.workbook and f.readable]
    writing = run in runs.writing()  # before one looks which files there are: what comes meanwhile is not missed
    files = runs.files(run)
    answer: Mapping[str, Any] = {}
    trouble = "" if metadata.readable else sentences(metadata.why, metadata.remedy)
    size = files[TRACE][0].stat().st_size if TRACE in files else 0
    reading = "" if "read" in request.args or not metadata.readable or size < _LONG else f"{size / 1e6:,.0f} MB"
    if metadata.readable and not reading:
        try:
            answer = services().queries.course(place, page_language())
        except SheetsError as error:
            trouble = error_text(error)
    entries = answer.get("lines", ())
    log = tuple(_log_line(entry) for entry in entries[:_LOG])
    seconds = max(metadata.seconds, float(answer.get("seconds", 0.0)))
    left_out = int(answer.get("left_out", 0)) + max(0, len(entries) - _LOG)
    edits = _edits(entries)
    spoken = {line.sound for line in log}
    curves = len(answer.get("curves", ()))
    line = line_of(metadata, books)
    return show(RecordPage(
        line=line if line.length or not seconds else replace(line, length=length(seconds)),
        others=tuple(line_of(f, books) for f in others[:_BESIDE]),
        facts=_facts(metadata), same=_same(metadata, repository), pictures=frozenset(PICTURES.keys() & files.keys()),
        exports=tuple(kind for kind in exporting.EXPORTS if (curves if kind.picture else not trouble)),
        downloads=_downloads(files), log=log, left_out=left_out,
        sounds=() if reading else tuple(n for n in files if n.endswith(".wav") and n not in spoken),
        errors=metadata.errors,
        edits=edits[:_EDITS], more_edits=max(0, len(edits) - _EDITS),
        trouble=trouble, writing=writing, events=f"{answer.get('count', 0):,}",
        window=("0", f"{_FIRST:g}") if seconds > _WHOLE else ("", ""), curves=curves,
        compared_with=tuple(line_of(f, books) for f in others if f.run != run)[:_BESIDE],
        participant=metadata.participant, reading=reading,
    ))  # fmt: skip


@blueprint.get("/runs/<run>/written")
def written(run: str) -> Response:
    """Tell whether all files of a recording are written."""
    return jsonify(run_or_404(run) not in services().runs.writing())


@blueprint.get("/runs/<run>/marbles")
def marbles(run: str) -> str:
    """Show marble diagrams of a recording."""
    place, rows, spread = services().runs.place(run_or_404(run)), rows_asked(), "spread" in request.args
    behaviour, first, last = (request.args.get(name, "")[:200] for name in ("behaviour", "from", "to"))
    trouble = ""
    answer: dict[str, Any] = {
        "behaviours": [], "behaviour": "", "rows": [], "seconds": 0, "pictures": [], "left_out": 0,
    }  # fmt: skip
    try:
        window = seconds_of(first), seconds_of(last)
        answer = services().queries.marbles(place, behaviour, rows, window, spread, page_language())
    except SheetsError as error:
        trouble = error_text(error)
    if not trouble and not answer["pictures"]:
        trouble = N_("Nothing came on any stream then.")
    return show(MarblesPage(
        run=run, behaviours=tuple(answer["behaviours"]), behaviour=str(answer["behaviour"]),
        rows=tuple((n, f"{name} {formula}".strip(), not rows or n in rows) for n, name, formula in answer["rows"]),
        all_rows=not rows, first=first, last=last, spread=spread,
        seconds=f"{float(str(answer['seconds'])):.1f}".removesuffix(".0"),
        pictures=tuple(Markup(svg) for svg in answer["pictures"]), left_out=int(str(answer["left_out"])),
        trouble=trouble,
    ))  # fmt: skip


@blueprint.get("/runs/<run>/series.json")
def series(run: str) -> Response:
    """Send the numbers of a recording over time, for its plots."""
    try:
        return jsonify(services().queries.course(services().runs.place(run_or_404(run)), "en")["curves"])
    except SheetsError:  # the page says what is wrong with it
        return jsonify([])


def _beside(metadata: Sequence[RunMetadata], lines: Sequence[RunLine]) -> list[tuple[str, str, str]]:
    names = (
        N_("Workbook"), N_("Participant"), N_("Condition"), N_("Operator"), N_("Mode"), N_("Length"),
        N_("How it ended"), N_("Errors"), N_("Seed"), N_("Robot"), N_("Program"), N_("Workbook SHA-256"),
    )  # fmt: skip
    first, second = (
        (f.workbook, f.participant, f.condition, f.operator, f.mode, line.length,
         line.ended, f"{line.errors:,}", f.seed, f.robot, f.program, f.digest[:12])
        for f, line in zip(metadata, lines, strict=True)
    )  # fmt: skip
    return [(name, a, b) for name, a, b in zip(names, first, second, strict=True) if a or b]


def _stream(answer: dict[str, Any]) -> tuple[str, str, tuple[tuple[str, bool], ...]]:
    counts = [N_("not in it") if count is None else f"{count:,}" for count in answer["counts"]]
    firsts = ["" if first is None else clock(first, EXACT) for first in answer["firsts"]]
    cells = tuple((words, one != other) for one, other in (counts, firsts) for words in (one, other))
    return str(answer["name"]), str(answer["kind"]), cells


def _choices(known: set[str], chosen: str) -> tuple[str, ...]:
    return tuple(sorted((known | {chosen}) - {""}, key=str.casefold))


def _has(run: RunMetadata, words: str) -> bool:
    place = " ".join((run.run, run.workbook, run.participant, run.condition, run.operator, run.mode))
    return all(word in place.casefold() for word in words.casefold().split())


def _facts(metadata: RunMetadata) -> tuple[tuple[str, str, bool], ...]:
    engine = _ENGINES.get(metadata.engine, metadata.engine)
    rate = metadata.frame_rate and f"{metadata.frame_rate} Hz"
    found = (
        (N_("Began"), when(metadata.began), False),
        (N_("Length"), length(metadata.seconds) if metadata.seconds else "", False),
        (N_("Participant"), metadata.participant, False), (N_("Condition"), metadata.condition, False),
        (N_("Operator"), metadata.operator, False),
        (N_("Robot"), listed([part for part in (metadata.robot, engine, rate) if part]), False),
        (N_("Seed"), metadata.seed, True),
        (N_("Robot commands"), listed([f"{n}: {c:,}" for n, c in list(metadata.commands.items())[:20]]), False),
        (N_("Program"), metadata.program and N_("RRP Sheets {version}", version=metadata.program), False),
        (N_("Folder"), f"runs/{metadata.run}", True),
    )  # fmt: skip
    return tuple(fact for fact in found if fact[1])


def _same(metadata: RunMetadata, repository: WorkbookRepository) -> str:
    """Return whether the workbook in the folder is still the one that ran: same, changed, gone or unknown."""
    if not metadata.digest:
        return "unknown"
    if metadata.workbook not in repository.names():
        return "gone"
    try:
        return "same" if repository.open(metadata.workbook).reading.digest == metadata.digest else "changed"
    except SheetsError:
        return "unknown"


def _downloads(files: Mapping[str, tuple[Path, str]]) -> tuple[tuple[str, str, str], ...]:
    order = (TABLE, WORKBOOK, DIAGRAM, STRIP, FILM, TRACE, "robot.toml", "gestures.toml")
    names = sorted(files, key=lambda name: (order.index(name) if name in order else len(order), name))
    return tuple((name, describe(name), _size(files[name][0])) for name in names)


def _size(path: Path) -> str:
    size = path.stat().st_size
    if size < 1_000_000:
        return f"{max(1, round(size / 1000)):,} kB"
    return f"{size / 1e6:,.1f} MB"


def _log_line(entry: Mapping[str, Any]) -> LogLine:
    kind, t, times = str(entry["kind"]), float(entry["t"]), int(entry["times"])
    word, icon = _KINDS.get(kind, (kind, "mark"))
    text = str(entry["text"])
    until = clock(float(entry["until"]), EXACT)
    if times > 1:
        text = N_("{text} ({n:,} times, until {time})", text=text, n=times, time=until)
    elif float(entry["until"]) > t:
        text = N_("{text} (until {time})", text=text.rstrip(".。"), time=until)
    return LogLine(
        t, clock(t, EXACT), kind, word, icon, text, str(entry["row"]), who(str(entry["by"])), str(entry["sound"])
    )


def _edits(entries: Sequence[Mapping[str, Any]]) -> tuple[tuple[str, str, int], ...]:
    found: dict[str, tuple[str, str, int]] = {}
    for number, entry in enumerate(entries, 1):
        sheet, _, row = str(entry["row"]).rpartition("!")
        if entry["kind"] == "edit" and row.isdigit():  # helpers and tables are not in the diagram
            named = N_("row {row} of {sheet}", row=row, sheet=sheet)
            found[named] = named, clock(float(entry["t"]), EXACT), number if number <= _LOG else 0
    return tuple(found.values())
