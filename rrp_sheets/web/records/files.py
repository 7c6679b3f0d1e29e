"""Files of runs as answers: pictures and sounds are shown, everything else is taken along; all of it as one zip."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

from flask import Response, abort, send_file

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.records.query_worker import QueryWorker
from rrp_sheets.web.records.making import made
from rrp_sheets.web.records.run_store import RunStore

_SHOWN = ("image/png", "image/gif", "audio/wav")
_MOST_ZIP = 2_000_000_000  # bytes


def run_file(runs: RunStore, run: str, name: str, *, take: bool) -> Response:
    """One file; a diagram can be shown in a page as a picture, but is never opened as a page of its own."""
    found = runs.files(run).get(name)
    if found is None:
        abort(404)
    path, kind = found
    attachment = take or kind not in _SHOWN
    return send_file(path, mimetype=kind, as_attachment=attachment, download_name=f"{run}-{name}" if take else name)


def trace_csv(runs: RunStore, exporter: QueryWorker, run: str) -> Response:
    """The events as CSV."""
    place = runs.place(run)
    file = made("trace.csv", lambda target: _csv(exporter, place, target))
    return send_file(file, mimetype="text/csv", as_attachment=True, download_name=f"{run}.csv")


def _csv(exporter: QueryWorker, place: Path, target: Path) -> None:
    exporter.ask(place.name, "export", [str(place)], str(target))


def everything(runs: RunStore, exporter: QueryWorker, run: str) -> Response:
    """All files of a run, and its events as CSV, in a zip."""
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
