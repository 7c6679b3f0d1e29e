"""Looking back at a recorded run: its page, and the parts that the page requests one after the other."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from flask import Blueprint, Response, abort
from markupsafe import Markup

from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key, names_in
from rrp_sheets.texts import sentences
from rrp_sheets.web.models import STREAM_KINDS, KindText, error_text, script_json, show
from rrp_sheets.web.requests import page_language, run_or_404
from rrp_sheets.web.run_store import RunLine, line_of
from rrp_sheets.web.services import services

blueprint = Blueprint("lookback", __name__)


@dataclass(frozen=True, slots=True)
class RanRow:
    """Row of the workbook that ran; `ident` is its id on the page."""

    ident: str
    number: int
    on: bool
    inputs: tuple[KindText, ...]
    connector: str
    icon: str
    formula: str
    output: KindText | None
    notes: str


@dataclass(frozen=True, slots=True)
class RanSheet:
    """Behaviour that ran; `number` is its place, `left_out` how many of its rows are not shown."""

    number: int
    name: str
    rows: tuple[RanRow, ...]
    left_out: int


@dataclass(frozen=True, slots=True)
class LookbackPage:
    """Page for looking back at a run, or its `trouble`; `why` says why the rows are missing, `ids` has them by refs."""

    template: ClassVar[str] = "lookback.html"
    kinds: ClassVar[Mapping[str, str]] = STREAM_KINDS
    line: RunLine
    seconds: float
    sheets: tuple[RanSheet, ...]
    ids: Markup
    trouble: str
    why: str


@dataclass(frozen=True, slots=True)
class DrawnSheet:
    """Diagram of a behaviour, a fragment of the page; `why` says why there is none."""

    template: ClassVar[str] = "lookback_diagram.html"
    drawing: Markup
    why: str


@blueprint.get("/runs/<run>/lookback")
def page(run: str) -> str:
    """Show the page; its parts are requested one after the other."""
    metadata = services().runs.metadata([run_or_404(run)])[0]
    answer: Mapping[str, Any] = {"sheets": [], "why": ""}
    trouble = "" if metadata.readable else sentences(metadata.why, metadata.remedy)
    if not trouble:
        try:
            answer = json.loads(
                services().lookback_queries.lookback(services().runs.place(run), "sheets", 0, page_language())
            )
        except SheetsError as error:
            answer = {"sheets": [], "why": error_text(error)}
    sheets = []
    for number, sheet in enumerate(answer["sheets"]):
        rows = tuple(_row(f"r{number}-{row[0]}", row, sheet["kinds"]) for row in sheet["rows"])
        sheets.append(RanSheet(number, str(sheet["name"]), rows, int(sheet["left_out"])))
    ids = {f"{sheet.name}!{row.number}": row.ident for sheet in sheets for row in sheet.rows}
    line = line_of(metadata, set(services().repository.names()))
    return show(LookbackPage(line, metadata.seconds, tuple(sheets), script_json(ids, "en"), trouble, answer["why"]))


@blueprint.get("/runs/<run>/lookback/overview.json")
def overview(run: str) -> Response:
    """Send the overview of the run."""
    return part(run, "overview", 0)


@blueprint.get("/runs/<run>/lookback/<any(piece, poses):what>/<int:number>.json")
def part(run: str, what: str, number: int) -> Response:
    """Send a piece of the recorded values or poses."""
    place = services().runs.place(run_or_404(run))
    try:
        return Response(
            services().lookback_queries.lookback(place, what, number, page_language()), mimetype="application/json"
        )
    except SheetsError as error:
        return Response(json.dumps({"trouble": error_text(error)}), status=422, mimetype="application/json")


@blueprint.get("/runs/<run>/lookback/picture/<int:number>.jpg")
def picture(run: str, number: int) -> Response:
    """Send a recorded camera picture."""
    place = services().runs.place(run_or_404(run))
    data = base64.b64decode(services().lookback_queries.lookback(place, "picture", number, "en"))
    if not data:
        abort(404)
    return Response(data, mimetype="image/jpeg")


@blueprint.get("/runs/<run>/lookback/diagram/<int:number>")
def diagram(run: str, number: int) -> str:
    """Show the diagram of a behaviour, or why there is none."""
    place = services().runs.place(run_or_404(run))
    try:
        return show(
            DrawnSheet(Markup(services().lookback_queries.lookback(place, "diagram", number, page_language())), "")
        )
    except SheetsError as error:
        return show(DrawnSheet(Markup(), error_text(error)))


def _row(ident: str, row: list[Any], kinds: Mapping[str, str]) -> RanRow:
    number, on, inputs, connector, formula, output, notes = row
    known = connectors().get(connector)
    icon = known.name if known else ""
    given = tuple(_name(n, kinds) for n in names_in(inputs))
    return RanRow(ident, number, on, given, connector, icon, formula, _name(output, kinds) if output else None, notes)


def _name(text: str, kinds: Mapping[str, str]) -> KindText:
    return KindText(kinds.get(key(text), ""), text.strip())
