"""Printing of workbooks: the protocol for an ethics board, as a page and as a PDF with the same content."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import ClassVar

from flask import Blueprint, Response, abort, jsonify, request, send_file
from markupsafe import Markup

from rrp_sheets.documents.document import Version
from rrp_sheets.errors import SheetsError
from rrp_sheets.render.pack.model import Pack
from rrp_sheets.render.pack.participants import ParticipantSheet
from rrp_sheets.render.texts import texts
from rrp_sheets.texts import LANGUAGES, N_, language_code
from rrp_sheets.web.models import date_and_time, error_text, show
from rrp_sheets.web.protocol_printer import Wanted
from rrp_sheets.web.requests import confirm_download
from rrp_sheets.web.services import services
from rrp_sheets.web.views.comparison import Group, choices, path_of
from rrp_sheets.web.workbook_repository import printable, refuse_text

blueprint = Blueprint("printing", __name__)
blueprint.after_request(confirm_download)

PAPERS = {"a4": "A4", "letter": "Letter"}
_READERS = {"board": N_("the ethics board"), "participants": N_("participants (one page)")}
_APPROVED = re.compile(r"approved|承認", re.IGNORECASE)
_NOTHING = "none"  # chosen by hand, where an approved version would be proposed


@dataclass(frozen=True, slots=True)
class PrintPage:
    """Page for printing a workbook: the options; the protocol itself is requested separately.

    Attributes:
        own: the language that the Protocol sheet says.
        has_approved: whether a kept version is called an approved one.
    """

    template: ClassVar[str] = "print.html"
    name: str
    title: str
    own: str
    languages: tuple[tuple[str, str], ...]
    papers: tuple[tuple[str, str], ...]
    readers: tuple[tuple[str, str], ...]
    groups: tuple[Group, ...]
    choice: Mapping[str, str]
    has_approved: bool
    errors: bool


@dataclass(frozen=True, slots=True)
class ProtocolPart:
    """Protocol on the page, or its `trouble`: the texts in its language (`t`), and the diagrams by the pack's names."""

    template: ClassVar[str] = "protocol.html"
    pack: Pack | None
    t: Mapping[str, str]
    pictures: Mapping[str, Markup]
    legend: Markup
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class ParticipantPart:
    """Information sheet for participants on the page; its picture is a drawing of the program's own."""

    template: ClassVar[str] = "participants.html"
    sheet: ParticipantSheet
    picture: Markup


@blueprint.get("/book/<name>/print")
def page(name: str) -> str:
    """Show the page with the options; it requests the protocol itself when it is shown."""
    book, asked = services().repository.open(_workbook(name)), request.args
    kept = services().open_workbooks.session(services().repository.path(name)).document.file.versions()
    against = asked.get("against", "") or _approved(name, kept)
    groups = choices([name], [against])
    mine = [(title, tuple(c for c in group if c[0] != f"book/{name}")) for title, group in groups]
    choice = {"language": _one_of(asked.get("language", ""), LANGUAGES), "against": against,
              "paper": _one_of(asked.get("paper", ""), PAPERS) or "a4",
              "reader": _one_of(asked.get("reader", ""), _READERS) or "board"}  # fmt: skip
    own = language_code(book.analysis.workbook.protocol.text("Language")) or "en"
    return show(PrintPage(
        name=name, title=book.title, own=LANGUAGES[own], languages=tuple(LANGUAGES.items()),
        papers=tuple(PAPERS.items()), readers=tuple(_READERS.items()), groups=tuple(g for g in mine if g[1]),
        choice=choice, has_approved=bool(_approved(name, kept)), errors=bool(book.analysis.errors),
    ))  # fmt: skip


@blueprint.get("/book/<name>/print/protocol")
def protocol(name: str) -> str:
    """Show the protocol as a fragment of the page, or the reason why there is none."""
    name = _workbook(name)
    try:
        wanted = _wanted(name, request.args)
        if wanted.participants:
            sheet = services().printer.sheet(wanted)
            return show(ParticipantPart(sheet, Markup(sheet.picture)))
        preview = services().printer.preview(wanted)
    except SheetsError as error:
        return show(ProtocolPart(None, {}, {}, Markup(""), error_text(error)))
    words = texts(preview.pack.language).entries
    mine = {entry.removeprefix("pack."): text for entry, text in words.items() if entry.startswith("pack.")}
    drawn = {name: Markup(svg) for name, svg in preview.pictures.items()}  # our own drawing, with all texts escaped
    return show(ProtocolPart(preview.pack, mine, drawn, Markup(preview.legend)))


@blueprint.get("/book/<name>/print/ready")
def pdf_ready(name: str) -> Response:
    """Make the PDF; tell what it lacks."""
    book = _workbook(name)
    try:
        return jsonify({"notes": _pdf(book, request.args)[1]})
    except SheetsError as error:
        return jsonify({"trouble": error_text(error)})


@blueprint.get("/book/<name>/print/protocol.pdf")
def protocol_pdf(name: str) -> Response:
    """Send the PDF."""
    data, _ = _pdf(_workbook(name), request.args)
    what = "participants" if request.args.get("reader") == "participants" else "protocol"
    file = f"{printable(Path(name).stem)}-{what}.pdf"
    return send_file(BytesIO(data), mimetype="application/pdf", as_attachment=True, download_name=file)


@blueprint.get("/book/<name>/paper.css")
def paper(name: str) -> Response:
    """Send the style sheet with the footer of the printed pages."""
    style = paper_style(name, services().repository.open(_workbook(name)).reading.digest, date_and_time(datetime.now()))
    return Response(style, mimetype="text/css")


def _workbook(name: str) -> str:
    """Return the name of a workbook; answer 404 if there is no such file, and refuse one that cannot be read."""
    repository = services().repository
    if not repository.has(name):
        abort(404)
    refuse_text(repository, name)
    repository.open(name)  # one that cannot be read, or leads out of the folder, is refused as everywhere
    return name


def _pdf(name: str, asked: Mapping[str, str]) -> tuple[bytes, list[str]]:
    return services().printer.pdf(_wanted(name, asked), _one_of(asked.get("paper", ""), PAPERS) or "a4")


def _wanted(name: str, asked: Mapping[str, str]) -> Wanted:
    path, digest = services().repository.path(name).absolute(), services().repository.open(name).reading.digest
    language = _one_of(asked.get("language", ""), LANGUAGES)
    ref, participants = asked.get("against", "")[:400], asked.get("reader") == "participants"
    if not ref or ref == _NOTHING or participants:
        return Wanted(path, digest, language=language, participants=participants)
    return Wanted(path, digest, *_other(ref), language)


def _other(ref: str) -> tuple[Path, str]:
    """Return the file of the workbook to compare with, and its SHA-256."""
    with tempfile.TemporaryDirectory() as folder:
        path = path_of(services(), ref, Path(folder) / "version")
        content = b"" if path.is_dir() else path.read_bytes()
        if path.is_relative_to(folder):
            path = services().printer.store(content, path.name)
    return path, sha256(content).hexdigest()


def _approved(name: str, kept: Iterable[Version]) -> str:
    """Return the reference of the newest kept version whose name says that it was approved; empty if there is none."""
    return next((f"version/{v.id}/{name}" for v in kept if _APPROVED.search(v.name)), "")


def _one_of(text: str, known: Iterable[str]) -> str:
    return text if text in known else ""


def paper_style(name: str, digest: str, when: str) -> str:
    r"""Return the style sheet for the footer of printed pages; inline styles are forbidden.

    >>> print(paper_style("a.xlsx", "0123456789abcdef" * 4, "1 May 2026, 10:00").splitlines()[2].strip())
    @bottom-left { content: "a\2e xlsx   SHA-256 0123 4567 89ab cdef …   1 May 2026\2c  10\3a 00"; }
    """
    digits = " ".join(digest[n : n + 4] for n in range(0, 16, 4))
    foot = f"{_css(name)}   SHA-256 {_css(digits)} …   {_css(when)}"
    return (
        "@media print {\n  @page {\n"
        f'    @bottom-left {{ content: "{foot}"; }}\n'
        '    @bottom-right { content: counter(page) " / " counter(pages); }\n'
        "  }\n}\n"
    )


def _css(text: str) -> str:
    """Escape a text for a string in CSS: everything but letters and digits."""
    return re.sub(r"[^\w ]", lambda m: f"\\{ord(m[0]):x} ", " ".join(text.split())[:120])
