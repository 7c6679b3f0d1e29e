"""Replay of a recorded run with its own or another workbook: the page and the result."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from flask import Blueprint, request, url_for
from markupsafe import Markup

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import TRACE, WORKBOOK
from rrp_sheets.texts import N_, sentences
from rrp_sheets.web.models import error_text, show
from rrp_sheets.web.replay_jobs import ReplayJob
from rrp_sheets.web.requests import page_language, run_or_404
from rrp_sheets.web.run_store import RunLine, line_of
from rrp_sheets.web.services import services
from rrp_sheets.web.views.comparison import Group, current_and_kept, path_of
from rrp_sheets.web.workbook_repository import WorkbookRepository, addressable

blueprint = Blueprint("replay", __name__)


LinkedLine = tuple[str, str, str]
"""Difference: the row or the time, a text, and its link to the grid or the time; empty when there is none."""


@dataclass(frozen=True, slots=True)
class ReplayPage:
    """Page for replaying a run, or its `trouble`; what is `chosen` is empty for the workbook that ran."""

    template: ClassVar[str] = "replay.html"
    line: RunLine
    trouble: str
    groups: tuple[Group, ...]
    chosen: str


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """Result of a replay, a fragment of its page, which requests itself again while the replay is `going`.

    Attributes:
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
    rows: tuple[LinkedLine, ...] = ()
    robot: tuple[LinkedLine, ...] = ()
    robot_left_out: int = 0
    differs: bool = False
    each: tuple[LinkedLine, ...] = ()
    each_left_out: int = 0
    pictures: tuple[Markup, ...] = ()
    unknown: tuple[str, ...] = ()


@blueprint.get("/runs/<run>/replay")
def page(run: str) -> str:
    """Show the page, which requests the replay itself."""
    metadata = services().runs.metadata([run_or_404(run)])[0]
    names = services().repository.workbooks()
    line = line_of(metadata, names)
    trouble = "" if metadata.readable else sentences(metadata.why, metadata.remedy)
    if metadata.ended == "going":
        trouble = N_("This run is still in progress; it can be replayed when it is over.")
    mine = [line.book] if line.book else []
    groups = current_and_kept(list(dict.fromkeys([*mine, *names])), mine)
    return show(ReplayPage(line, trouble, tuple(groups), _asked()))


@blueprint.get("/runs/<run>/replay/result")
def result(run: str) -> str:
    """Show the result of a replay, or its progress; the first request starts it."""
    return show(_result(run_or_404(run), _asked()))


def _asked() -> str:
    return request.args.get("with", "")[:400]


def _result(run: str, ref: str) -> ReplayResult:
    """Return the result of a replay with the workbook of a reference; it is empty for the one that ran."""
    shared = services()
    place = shared.runs.place(run)
    named: dict[str, Any] = {"with": ref} if ref else {}
    address = url_for("replay.result", run=run, **named)
    try:
        stamp = _stamp(place, shared.repository, ref)

        def other(stack: ExitStack) -> Path | None:
            if not ref:
                return None
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            return path_of(shared, ref, folder / "other")

        job = shared.replays.job((run, ref, stamp, page_language()), place, other, page_language())
    except SheetsError as error:
        return ReplayResult(address, False, 0, error_text(error))
    if not job.over:
        return ReplayResult(address, True, round(100 * job.part))
    if job.trouble:
        return ReplayResult(address, False, 100, job.trouble)
    return _finished(job, address, run, ref)


def _stamp(place: Path, repository: WorkbookRepository, ref: str) -> tuple[float, ...]:
    """Return times and sizes of the files; raises SheetsError when one is a link, or the workbook is not there."""
    kind, _, name = ref.partition("/")
    paths = [place / TRACE, place / WORKBOOK]
    if any(p.is_symlink() for p in paths):
        raise SheetsError(N_("The files of this run are links to others."), N_("Copy its folder again."))
    if kind == "book":
        paths.append(repository.path(name))
    found = []
    for path in paths:
        about = path.stat() if path.exists() else None
        found += [about.st_mtime, float(about.st_size)] if about else [0.0]
    return tuple(found)


def _finished(job: ReplayJob, address: str, run: str, ref: str) -> ReplayResult:
    answer: dict[str, Any] = job.account or {}
    row_address = _row_addresses(run, ref)
    look = url_for("lookback.page", run=run)

    def lines(name: str) -> tuple[LinkedLine, ...]:
        return tuple((t["when"], t["text"], f"{look}#t={t['us'] / 1e6:g}") for t in answer[name])

    return ReplayResult(
        address, False, 100, state="same" if answer["same"] else "different", verdict=answer["verdict"],
        ending=answer["ending"], remarks=tuple(answer["remarks"]), differs=answer["differs"],
        rows=tuple((r["whose"], r["text"], row_address(r["row"])) for r in answer["rows"]),
        robot=lines("robot"), robot_left_out=answer["robot_left_out"],
        each=lines("each"), each_left_out=answer["each_left_out"],
        pictures=tuple(Markup(svg) for svg in answer["pictures"]), unknown=tuple(answer["unknown"]),
    )  # fmt: skip


def _row_addresses(run: str, ref: str) -> Callable[[str], str]:
    """Return a function that links a row (`Tracking!5`) to the grid; its answer is empty where it is not there."""
    repository, open_workbooks = services().repository, services().open_workbooks
    kind, _, name = ref.partition("/")
    book = name if kind == "book" else ""
    if not ref:
        metadata = services().runs.metadata([run])[0]
        if metadata.workbook in repository.names() and addressable(metadata.workbook):
            book = metadata.workbook if repository.open(metadata.workbook).reading.digest == metadata.digest else ""
    grids = open_workbooks.session(repository.path(book)).document.grids if book else {}

    def address(row: str) -> str:
        sheet, _, number = row.rpartition("!")
        grid = grids.get(sheet)
        place = int(number) - grid.first if grid is not None and number.isdecimal() else -1
        if grid is None or not 0 <= place < len(grid.rows):
            return ""
        return url_for("sheet.page", name=book, sheet=sheet, _anchor=grid.rows[place])

    return address
