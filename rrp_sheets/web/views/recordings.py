"""Routes of runs and their files, versions, comparisons, bundles and the printed page."""

from __future__ import annotations

import re
import tempfile
import zipfile
from collections.abc import Collection
from io import BytesIO
from pathlib import Path
from typing import cast

from flask import Blueprint, Response, abort, current_app, jsonify, request, send_file

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.runs.records.export_child import PROGRAM
from rrp_sheets.runs.records.query_worker import QueryWorker
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks
from rrp_sheets.web.requests import RoomOf, workbook_or_404
from rrp_sheets.web.runs.record_pages import show
from rrp_sheets.web.runs.run_list import marbles_page, record_page, runs_page
from rrp_sheets.web.runs.run_store import RunStore, made
from rrp_sheets.web.views import comparison as kept
from rrp_sheets.web.views.comparison import compare_page, drawn_changes
from rrp_sheets.web.views.exports import WITHIN, add_keeping
from rrp_sheets.web.views.lookback import add_lookback
from rrp_sheets.web.views.printing import add_paper
from rrp_sheets.web.views.replay import add_replay
from rrp_sheets.web.workbook_repository import WorkbookRepository, printable

_WORD = re.compile("[0-9a-f]{16}")
_MOST_ROWS = 200  # that marbles are asked for


def make_records(repository: WorkbookRepository, open_workbooks: OpenWorkbooks) -> Blueprint:
    """Make the blueprint with the routes of all recorded things."""
    pages = Blueprint("records", __name__)
    queries, exporter = QueryWorker(), QueryWorker(WITHIN, PROGRAM)
    runs = RunStore(repository.folder, lambda: _names("going"), lambda: _names("writing"), _forget)
    _add_runs(pages, repository, runs, queries)
    _add_files(pages, runs, exporter)
    add_keeping(pages, repository, runs, exporter)
    add_lookback(pages, repository, runs)
    add_replay(pages, repository, open_workbooks, runs)
    _add_comparison(pages, repository, open_workbooks, runs, queries)
    add_bundles(pages, repository, runs)
    _add_versions(pages, workbook_or_404(repository, open_workbooks))
    add_paper(pages, repository, open_workbooks, runs)
    pages.after_request(_made)
    return pages


def _made(answer: Response) -> Response:
    """Set a cookie that tells the page that the file it requested has arrived."""
    word = request.args.get("made", "")
    if _WORD.fullmatch(word):
        answer.set_cookie(f"made-{word}", "1", max_age=60, samesite="Strict", path="/")
    return answer


def _have(runs: RunStore, run: str) -> str:
    if run not in runs.names():
        abort(404)
    return run


def _add_runs(pages: Blueprint, repository: WorkbookRepository, runs: RunStore, queries: QueryWorker) -> None:
    @pages.get("/runs", endpoint="runs")
    def all_runs() -> str:
        book, words, participant = (request.args.get(n, "")[:300] for n in ("book", "words", "participant"))
        first = request.args.get("first", 0, type=int)
        return show(runs_page(runs, repository, book, words, max(0, first), participant))

    @pages.get("/runs/<run>")
    def record(run: str) -> str:
        return show(record_page(runs, repository, queries, _have(runs, run), wait="read" in request.args))

    @pages.get("/runs/<run>/written")
    def written(run: str) -> Response:
        return jsonify(_have(runs, run) not in runs.writing())

    @pages.get("/runs/<run>/marbles")
    def marbles(run: str) -> str:
        rows = [int(r) for r in request.args.getlist("row") if r.isdecimal() and len(r) < 7]
        return show(marbles_page(runs, queries, _have(runs, run), request.args, rows[:_MOST_ROWS]))

    @pages.get("/runs/<run>/series.json")
    def series(run: str) -> Response:
        try:
            return jsonify(queries.course(runs.place(_have(runs, run)))["curves"])
        except SheetsError:  # the page says what is wrong with it
            return jsonify([])


def _add_files(pages: Blueprint, runs: RunStore, exporter: QueryWorker) -> None:
    @pages.get("/runs/<run>/file/<file>")
    def file(run: str, file: str) -> Response:
        return run_file(runs, _have(runs, run), file, take="take" in request.args)

    @pages.get("/runs/<run>/trace.csv")
    def csv(run: str) -> Response:
        return trace_csv(runs, exporter, _have(runs, run))

    @pages.get("/runs/<run>/everything.zip")
    def zipped(run: str) -> Response:
        return everything(runs, exporter, _have(runs, run))


def _add_comparison(
    pages: Blueprint,
    repository: WorkbookRepository,
    open_workbooks: OpenWorkbooks,
    runs: RunStore,
    queries: QueryWorker,
) -> None:
    drawer = QueryWorker()  # a process of its own: whoever looks at a run does not wait for pictures

    @pages.get("/compare")
    def compare() -> str:
        refs = (request.args.get("first", "")[:400], request.args.get("second", "")[:400])
        return show(compare_page(repository, open_workbooks, runs, queries, refs, request.args.get("book", "")))

    @pages.get("/compare/drawn", endpoint="drawn_changes")
    def drawn() -> str:
        refs = (request.args.get("first", "")[:400], request.args.get("second", "")[:400])
        return drawn_changes(repository, open_workbooks, runs, drawer, refs)

    @pages.get("/compare/changes.css")
    def changes_style() -> Response:
        return send_file(bundled("templates", "compare", "changes.css"), mimetype="text/css")


def _add_versions(pages: Blueprint, room_of: RoomOf) -> None:
    @pages.get("/book/<name>/versions")
    def versions(name: str) -> str:
        room = room_of(name)
        room.poll()
        return show(kept.versions_page(room, name))

    @pages.post("/book/<name>/versions/<any(keep, restore):action>")
    def act(name: str, action: str) -> str:
        return show((kept.keep if action == "keep" else kept.restore)(room_of(name), name))

    @pages.get("/book/<name>/versions/<int:number>/file")
    def version_file(name: str, number: int) -> Response:
        document = room_of(name).document
        found = next((v for v in document.versions() if v.id == number), None)
        content = document.version_content(number) if found else None
        if found is None or content is None:
            abort(404)
        file = kept.file_name(name, found)  # in any script: a header alone holds no Japanese letters
        return send_file(BytesIO(content), mimetype="application/octet-stream", as_attachment=True, download_name=file)


def _forget(folders: Collection[str]) -> None:
    """Clear the run panel if it shows one of these deleted runs, in a server that also runs workbooks."""
    if forget := current_app.extensions.get("forget"):
        forget(folders)


def _names(which: str) -> Collection[str]:
    """Return the folder names of this server's runs that are `going` or `writing`."""
    found = current_app.extensions.get(which)
    return cast(Collection[str], found()) if found else ()


_WITHIN = 90.0  # s; the tests of the workbook may take 20
_MOST_RUNS = 20


class Packer(QueryWorker):
    """Query worker that packs bundles; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_WITHIN, "rrp_sheets.web.records.bundling_child")

    def pack(self, path: Path, runs: list[Path], target: Path) -> None:
        """Create a bundle of a workbook and the runs in those folders.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        self._ask(path.name, "pack", str(path), [str(run) for run in runs], str(target))


def add_bundles(pages: Blueprint, repository: WorkbookRepository, runs: RunStore) -> None:
    """Add the route of a workbook's bundle; `run` names a run to include."""
    packer = Packer()

    @pages.get("/book/<name>/bundle.zip")
    def bundle(name: str) -> Response:
        wanted = request.args.getlist("run")[:_MOST_RUNS]
        if not repository.has(name) or set(wanted) - set(runs.names()):
            abort(404)
        path = repository.path(name).absolute()
        places = [runs.place(run).absolute() for run in wanted]
        file = made("bundle.zip", lambda target: packer.pack(path, places, target))
        shown = f"{printable(path.stem)}-bundle.zip"
        return send_file(file, mimetype="application/zip", as_attachment=True, download_name=shown)


_SHOWN = ("image/png", "image/gif", "audio/wav")
_MOST_ZIP = 2_000_000_000  # bytes


def run_file(runs: RunStore, run: str, name: str, *, take: bool) -> Response:
    """Send one file of a run; all but PNG, GIF and WAV are attachments, so an SVG cannot be opened as a page."""
    found = runs.files(run).get(name)
    if found is None:
        abort(404)
    path, kind = found
    attachment = take or kind not in _SHOWN
    return send_file(path, mimetype=kind, as_attachment=attachment, download_name=f"{run}-{name}" if take else name)


def trace_csv(runs: RunStore, exporter: QueryWorker, run: str) -> Response:
    """Send the events of a run as CSV."""
    place = runs.place(run)
    file = made("trace.csv", lambda target: _csv(exporter, place, target))
    return send_file(file, mimetype="text/csv", as_attachment=True, download_name=f"{run}.csv")


def _csv(exporter: QueryWorker, place: Path, target: Path) -> None:
    exporter.ask(place.name, "export", [str(place)], str(target))


def everything(runs: RunStore, exporter: QueryWorker, run: str) -> Response:
    """Send all files of a run, and its events as CSV, in a zip."""
    files = runs.files(run)
    if sum(path.stat().st_size for path, _ in files.values()) > _MOST_ZIP:
        raise SheetsError("This run is too large for a zip.", f"Copy the folder runs/{run} itself.")
    packed = tempfile.TemporaryFile()  # noqa: SIM115  # the answer closes it
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as whole:
        for name, (path, _) in files.items():
            whole.write(path, f"{run}/{name}")
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "trace.csv"
            try:
                _csv(exporter, runs.place(run), target)
                whole.write(target, f"{run}/trace.csv")
            except SheetsError:  # a record that cannot be read is taken along as it is
                whole.writestr(f"{run}/trace-could-not-be-read.txt", "trace.jsonl is no whole record of a run.\n")
    packed.seek(0)
    return send_file(packed, mimetype="application/zip", as_attachment=True, download_name=f"{run}.zip")
