"""Downloads: the files of a recording, plots, marble diagrams and tables made of recordings, and bundles."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from flask import Blueprint, Response, abort, request, send_file

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import TRACE
from rrp_sheets.recording.exporting import EXPORTS, PICTURE_TYPES, export_kind
from rrp_sheets.texts import N_, translate
from rrp_sheets.web.requests import confirm_download, rows_asked, run_or_404, seconds_of
from rrp_sheets.web.run_store import made
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import printable

blueprint = Blueprint("exports", __name__)
blueprint.after_request(confirm_download)
MOST_RUNS = 500  # in one table
_MOST_BUNDLED = 20  # runs in one bundle
_MOST_ZIP = 2_000_000_000  # bytes
_SHOWN = ("image/png", "image/gif", "audio/wav")


@blueprint.get("/runs/<run>/file/<file>")
def file(run: str, file: str) -> Response:
    """Send one file of a run; all but PNG, GIF and WAV are attachments, so an SVG cannot be opened as a page."""
    found, take = services().runs.files(run_or_404(run)).get(file), "take" in request.args
    if found is None:
        abort(404)
    path, kind = found
    attachment = take or kind not in _SHOWN
    return send_file(path, mimetype=kind, as_attachment=attachment, download_name=f"{run}-{file}" if take else file)


@blueprint.get("/runs/<run>/everything.zip")
def everything(run: str) -> Response:
    """Send all files of a run, and its events as CSV, in a zip."""
    files = services().runs.files(run_or_404(run))
    if sum(path.stat().st_size for path, _ in files.values()) > _MOST_ZIP:
        remedy = N_("Copy the folder {folder} itself.", folder=f"runs/{run}")
        raise SheetsError(N_("This run is too large for a zip."), remedy)
    packed = tempfile.TemporaryFile()  # noqa: SIM115  # the answer closes it
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as whole:
        for name, (path, _) in files.items():
            whole.write(path, f"{run}/{name}")
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder) / "trace.csv"
            try:
                _export([services().runs.place(run)], target)
                whole.write(target, f"{run}/trace.csv")
            except SheetsError:  # a record that cannot be read is taken along as it is
                language = services().runs.metadata([run])[0].language
                why = translate(N_("{file} is not a complete recording of a run.", file=TRACE), language)
                whole.writestr(f"{run}/trace-could-not-be-read.txt", f"{why}\n")
    packed.seek(0)
    return send_file(packed, mimetype="application/zip", as_attachment=True, download_name=f"{run}.zip")


@blueprint.get("/runs/<run>/<export>.<form>")
def exported(run: str, export: str, form: str) -> Response:
    """Send an export of a run; a picture is shown unless `take` asks for the file."""
    suffix, places = f".{form}", [services().runs.place(run_or_404(run))]
    kind = next((kind for kind in EXPORTS if kind.name == export and suffix in kind.types), None)
    if kind is None:
        abort(404)
    name, take = (f"{run}-{export}", "take" in request.args) if kind.picture else (run, True)
    return _send(suffix, kind.types[suffix], name, lambda target: _export(places, target), take=take)


@blueprint.get("/runs/<run>/marbles.<any(svg,png,pdf):form>")
def marbles(run: str, form: str) -> Response:
    """Send the marble diagrams of a run as a picture or PDF."""
    place = services().runs.place(run_or_404(run))
    behaviour, *window = (request.args.get(name, "")[:300] for name in ("behaviour", "from", "to"))
    asked = (str(place), behaviour, rows_asked(), [seconds_of(w) for w in window])
    suffix, export = f".{form}", partial(services().exporter.ask, run, "write_marbles", *asked)
    return _send(suffix, PICTURE_TYPES[suffix], f"{run}-marbles", lambda target: export(str(target)))


@blueprint.get("/runs/table.<form>")
def table(form: str) -> Response:
    """Send one export of some runs."""
    suffix = f".{form}"
    kind = export_kind(suffix)
    if kind is None or kind.picture:
        abort(404)
    chosen = request.args.getlist("run")[:MOST_RUNS]
    if not chosen:
        raise SheetsError(N_("No run is chosen."), N_("Tick the runs that the table shall have."))
    places = [services().runs.place(run) for run in dict.fromkeys(chosen)]
    name = places[0].name if len(places) == 1 else "runs"
    return _send(suffix, kind.types[suffix], name, lambda target: _export(places, target))


@blueprint.get("/book/<name>/bundle.zip")
def bundle(name: str) -> Response:
    """Send a bundle of a workbook; `run` names a run to include."""
    repository, runs, packer = services().repository, services().runs, services().packer
    wanted = request.args.getlist("run")[:_MOST_BUNDLED]
    if not repository.has(name) or set(wanted) - set(runs.names()):
        abort(404)
    path = repository.path(name).absolute()
    places = [runs.place(run).absolute() for run in wanted]
    name = f"{printable(path.stem)}-bundle"
    return _send(".zip", "application/zip", name, lambda target: packer.pack(path, places, target))


def _export(places: Sequence[Path], target: Path) -> None:
    services().exporter.ask(places[0].name, "export_runs", [str(place) for place in places], str(target))


def _send(suffix: str, mimetype: str, name: str, make: Callable[[Path], object], *, take: bool = True) -> Response:
    """Send a temporary file that `make` writes to the path it is given."""
    file = made(f"made{suffix}", make)
    return send_file(file, mimetype=mimetype, as_attachment=take, download_name=f"{name}{suffix}")
