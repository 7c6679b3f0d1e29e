"""Replay of a recorded run with its own or another workbook: the page, the result, and the replay jobs."""

from __future__ import annotations

import tempfile
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from flask import Blueprint, abort, render_template, request, url_for
from markupsafe import Markup

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.marbles import WORKBOOK
from rrp_sheets.runs.records.metadata import TRACE
from rrp_sheets.runs.replay.apart import Stopped, replay_apart
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks
from rrp_sheets.web.runs.record_pages import Choice, RunLine
from rrp_sheets.web.runs.run_store import RunStore, line_of
from rrp_sheets.web.views.comparison import moment, path_of
from rrp_sheets.web.workbook_repository import WorkbookRepository, addressable

_LONGEST_REF = 400


@dataclass(frozen=True, slots=True)
class ReplayedRow:
    """Row that behaves differently; `address` is its link in the grid, empty when it is not there."""

    whose: str
    text: str
    address: str


@dataclass(frozen=True, slots=True)
class TimeLine:
    """Difference at a point in time; `address` looks back at that moment."""

    when: str
    text: str
    address: str


@dataclass(frozen=True, slots=True)
class ReplayPage:
    """Page for replaying a run.

    Attributes:
        line: as in the list.
        trouble: why it cannot be replayed.
        groups: the workbooks to choose from, with titles.
        chosen: the reference of the other workbook; empty for the one that ran.
    """

    template: ClassVar[str] = "replay.html"
    line: RunLine
    trouble: str
    groups: tuple[tuple[str, tuple[Choice, ...]], ...]
    chosen: str


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """Result of a replay, a fragment of its page.

    Attributes:
        going: it is not over; the fragment requests itself again.
        part: the progress, in percent.
        state: `same`, `different`, or empty when there is `trouble`.
    """

    template: ClassVar[str] = "replayed.html"
    address: str
    going: bool
    part: int
    trouble: str = ""
    state: str = ""
    verdict: str = ""
    ending: str = ""
    remarks: tuple[str, ...] = ()
    rows: tuple[ReplayedRow, ...] = ()
    robot: tuple[TimeLine, ...] = ()
    robot_left_out: int = 0
    differs: bool = False
    each: tuple[TimeLine, ...] = ()
    each_left_out: int = 0
    pictures: tuple[Markup, ...] = ()
    unknown: tuple[str, ...] = ()


def add_replay(pages: Blueprint, repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore) -> None:
    """Add the routes of the page and of the result."""
    replays = Replays()

    def asked(run: str) -> str:
        if run not in runs.names():
            abort(404)
        return request.args.get("with", "")[:_LONGEST_REF]

    @pages.get("/runs/<run>/replay")
    def replay(run: str) -> str:
        page = replay_page(repository, open_workbooks, runs, run, asked(run))
        return render_template(page.template, page=page)

    @pages.get("/runs/<run>/replay/result")
    def replayed(run: str) -> str:
        piece = replay_result(repository, open_workbooks, runs, replays, run, asked(run))
        return render_template(piece.template, page=piece)


def replay_page(
    repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore, run: str, ref: str
) -> ReplayPage:
    """Build the page, which requests the replay itself."""
    facts = runs.facts([run])[0]
    names = [n for n in repository.workbooks() if addressable(n)]
    line = line_of(facts, names)
    trouble = "" if facts.readable else f"{facts.why} {facts.remedy}".strip()
    if facts.ended == "going":
        trouble = "This run is going on; it can be replayed when it is over."
    mine = [line.book] if line.book else []
    books = [*mine, *(n for n in names if n not in mine)]
    groups: list[tuple[str, tuple[Choice, ...]]] = [
        ("Workbooks as they are now", tuple(Choice(f"book/{n}", n) for n in books))
    ]
    for book in mine:
        kept = open_workbooks.room(repository.path(book)).document.versions()
        groups.append(
            (
                f"Kept versions of {book}",
                tuple(Choice(f"version/{v.id}/{book}", f"{v.name}, {moment(v)}") for v in kept),
            )
        )
    return ReplayPage(line, trouble, tuple(g for g in groups if g[1]), ref)


def replay_result(
    repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore, replays: Replays, run: str, ref: str
) -> ReplayResult:
    """Return the result of a replay, or its progress; the first request starts it."""
    place = runs.place(run)
    named: dict[str, Any] = {"with": ref} if ref else {}
    address = url_for("records.replayed", run=run, **named)
    try:
        stamp = _stamp(place, repository, ref)

        def other(stack: ExitStack) -> Path | None:
            if not ref:
                return None
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            return path_of(repository, open_workbooks, runs, ref, folder / "other")

        job = replays.job((run, ref, stamp), place, other)
    except SheetsError as error:
        return ReplayResult(address, False, 0, f"{error.message} {error.remedy}".strip())
    if not job.over:
        return ReplayResult(address, True, round(100 * job.part))
    if job.trouble:
        return ReplayResult(address, False, 100, str(job.trouble))
    return _told(job, address, repository, open_workbooks, runs, run, ref)


def _stamp(place: Path, repository: WorkbookRepository, ref: str) -> tuple[float, ...]:
    """Return times and sizes of the record's and the workbook's files, which change when these do.

    Raises:
        SheetsError: when a file is a link, or the workbook is not in the folder.
    """
    kind, _, name = ref.partition("/")
    paths = [place / TRACE, place / WORKBOOK]
    if any(p.is_symlink() for p in paths):
        raise SheetsError("The files of this run are links to others.", "Copy its folder again.")
    if kind == "book":
        paths.append(repository.path(name))
    found = []
    for path in paths:
        about = path.stat() if path.exists() else None
        found += [about.st_mtime, float(about.st_size)] if about else [0.0]
    return tuple(found)


def _told(
    job: ReplayJob,
    address: str,
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    run: str,
    ref: str,
) -> ReplayResult:
    told: dict[str, Any] = job.account or {}
    grids = _Grids(repository, open_workbooks, runs, run, ref)
    look = url_for("records.lookback", run=run)

    def lines(name: str) -> tuple[TimeLine, ...]:
        return tuple(TimeLine(t["when"], t["text"], f"{look}#t={t['us'] / 1e6:g}") for t in told[name])

    return ReplayResult(
        address, False, 100, state="same" if told["same"] else "different", verdict=told["verdict"],
        ending=told["ending"], remarks=tuple(told["remarks"]), differs=told["differs"],
        rows=tuple(ReplayedRow(r["whose"], r["text"], grids.address(r["row"])) for r in told["rows"]),
        robot=lines("robot"), robot_left_out=told["robot_left_out"],
        each=lines("each"), each_left_out=told["each_left_out"],
        pictures=tuple(Markup(svg) for svg in told["pictures"]), unknown=tuple(told["unknown"]),
    )  # fmt: skip


class _Grids:
    """Grids of the replayed workbook, if it is in the folder unchanged, to link rows to."""

    def __init__(
        self, repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore, run: str, ref: str
    ) -> None:
        kind, _, name = ref.partition("/")
        self._book = name if kind == "book" else ""
        if not ref:
            facts = runs.facts([run])[0]
            if facts.workbook in repository.names() and addressable(facts.workbook):
                digest = repository.open(facts.workbook).reading.digest
                self._book = facts.workbook if digest == facts.digest else ""
        self._grids = open_workbooks.room(repository.path(self._book)).document.grids if self._book else {}

    def address(self, row: str) -> str:
        """Return the link to a row (`Tracking!5`) in the grid; empty when it is not there."""
        sheet, _, number = row.rpartition("!")
        grid = self._grids.get(sheet)
        place = int(number) - grid.first if grid is not None and number.isdecimal() else -1
        if grid is None or not 0 <= place < len(grid.rows):
            return ""
        return url_for("editing.book", name=self._book, sheet=sheet, _anchor=grid.rows[place])


ASKED_WITHIN = 20.0  # s: a page that waits asks every half second
_KEPT = 8  # accounts
_MOST = 4  # that wait or go on: a page more is told to come later
_Other = Callable[[ExitStack], "Path | None"]


@dataclass
class ReplayJob:
    """Replay that is going on, or is over.

    Attributes:
        part: the progress, from 0 to 1.
        account: the result, when it is over.
        trouble: why there is no account, in words.
        asked: the time of the last request of a page.
        done: set when it is over.
    """

    part: float = 0.0
    account: dict[str, Any] | None = None
    trouble: str = ""
    asked: float = field(default_factory=time.monotonic)
    done: threading.Event = field(default_factory=threading.Event)

    @property
    def over(self) -> bool:
        """True when the replay has ended, with a result or not."""
        return self.done.is_set()


class Replays:
    """Replay jobs by record and workbook; they run one at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._turn = threading.Lock()
        self._jobs: OrderedDict[Hashable, ReplayJob] = OrderedDict()

    def job(self, name: Hashable, place: Path, other: _Other) -> ReplayJob:
        """Return the replay of that name; the first request starts it.

        Args:
            name: the same for the same record and the same workbook.
            place: the run's folder.
            other: returns the workbook's file, or None for the one that ran; the stack is closed at the end.

        Raises:
            SheetsError: when too many go on already.
        """
        with self._lock:
            found = self._jobs.get(name)
            if found is not None and not isinstance(found.trouble, _GivenUp):
                found.asked = time.monotonic()
                return found
            if sum(not job.over for job in self._jobs.values()) >= _MOST:
                raise SheetsError("Other replays are going on.", "Try it again in a minute.")
            job = self._jobs[name] = ReplayJob()
            for old in [n for n, j in self._jobs.items() if j.over][: max(0, len(self._jobs) - _KEPT)]:
                del self._jobs[old]
        threading.Thread(target=self._work, args=(job, place, other), name="replay", daemon=True).start()
        return job

    def _work(self, job: ReplayJob, place: Path, other: _Other) -> None:
        def told(part: float) -> None:
            job.part = part

        def stopped() -> bool:
            return time.monotonic() - job.asked > ASKED_WITHIN

        try:
            with self._turn, ExitStack() as stack:
                account = replay_apart(place, other(stack), told, stopped)
        except Stopped as error:
            job.trouble = _GivenUp(f"{error.message} {error.remedy}")
        except SheetsError as error:
            job.trouble = f"{error.message} {error.remedy}".strip()
        except OSError as error:
            job.trouble = f"It cannot be read ({error.strerror})."
        else:
            job.account = account
        finally:
            job.done.set()


class _GivenUp(str):
    """Message of a replay that no page waited for any more; the next request starts it anew."""
