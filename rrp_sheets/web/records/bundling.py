"""A bundle as a download: packed in a process of its own, since a printed protocol has its tests run."""

from __future__ import annotations

from pathlib import Path

from flask import Blueprint, Response, abort, request, send_file

from rrp_sheets.runs.records.query_worker import QueryWorker
from rrp_sheets.web.records.making import made
from rrp_sheets.web.records.run_store import RunStore
from rrp_sheets.web.workbook_repository import WorkbookRepository, printable

_WITHIN = 90.0  # s; the tests of the workbook may take 20
_MOST_RUNS = 20


class Packer(QueryWorker):
    """Packs bundles; from any thread, one at a time."""

    def __init__(self) -> None:
        super().__init__(_WITHIN, "rrp_sheets.web.records.bundling_child")

    def pack(self, path: Path, runs: list[Path], target: Path) -> None:
        """Make a bundle of a workbook and the runs in those folders.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        self._ask(path.name, "pack", str(path), [str(run) for run in runs], str(target))


def add_bundles(pages: Blueprint, repository: WorkbookRepository, runs: RunStore) -> None:
    """The address of a workbook's bundle; `run` names a run that goes along."""
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
