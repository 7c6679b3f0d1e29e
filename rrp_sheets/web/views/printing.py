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

from flask import Blueprint, Response, abort, jsonify, request, send_file
from markupsafe import Markup

from rrp_sheets.documents.journal import Version
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.languages import LANGUAGES, language_code
from rrp_sheets.render.texts import texts
from rrp_sheets.web.collab.workbook_session import OpenWorkbooks
from rrp_sheets.web.models import pieces
from rrp_sheets.web.runs.protocol_printer import ProtocolPrinter, Wanted
from rrp_sheets.web.runs.record_pages import PrintPage, ProtocolPart, show
from rrp_sheets.web.runs.run_store import RunStore
from rrp_sheets.web.views.comparison import choices, path_of
from rrp_sheets.web.workbook_repository import WorkbookRepository, printable, refuse_text

PAPERS = {"a4": "A4", "letter": "Letter"}
_APPROVED = re.compile(r"approved|承認", re.IGNORECASE)
_NOTHING = "none"  # chosen by hand, where an approved version would be proposed


@dataclass(frozen=True)
class Printer:
    """Builder of the printed pages for the workbooks of a folder."""

    repository: WorkbookRepository
    open_workbooks: OpenWorkbooks
    runs: RunStore
    printer: ProtocolPrinter

    def page(self, name: str, asked: Mapping[str, str]) -> PrintPage:
        """Build the page with the options; it requests the protocol itself when it is shown."""
        book = self.repository.open(name)
        kept = self.open_workbooks.room(self.repository.path(name)).document.versions()
        against = asked.get("against", "") or _approved(name, kept)
        groups = choices(self.repository, self.open_workbooks, self.runs, [name], [against])
        mine = [(title, tuple(c for c in group if c.ref != f"book/{name}")) for title, group in groups]
        choice = {"language": _one_of(asked.get("language", ""), LANGUAGES), "against": against,
                  "paper": _one_of(asked.get("paper", ""), PAPERS) or "a4"}  # fmt: skip
        own = language_code(book.look.workbook.protocol.text("Language")) or "en"
        return PrintPage(
            name=name, title=book.title, digest=book.reading.digest, own=LANGUAGES[own],
            languages=tuple(LANGUAGES.items()), papers=tuple(PAPERS.items()), groups=tuple(g for g in mine if g[1]),
            choice=choice, has_approved=bool(_approved(name, kept)), errors=bool(book.look.errors),
        )  # fmt: skip

    def part(self, name: str, asked: Mapping[str, str]) -> ProtocolPart:
        """Build the protocol as a fragment of the page, or with the reason why there is none."""
        try:
            proof = self.printer.proof(self._wanted(name, asked))
        except SheetsError as error:
            return ProtocolPart(None, {}, {}, Markup(""), f"{error.message} {error.remedy}".strip())
        words = texts(proof.pack.language).entries
        mine = {entry.removeprefix("pack."): text for entry, text in words.items() if entry.startswith("pack.")}
        drawn = {name: Markup(svg) for name, svg in proof.pictures.items()}  # our own drawing, with all texts escaped
        return ProtocolPart(proof.pack, mine, drawn, Markup(proof.legend), "", pieces)

    def pdf(self, name: str, asked: Mapping[str, str]) -> tuple[bytes, list[str]]:
        """Return the PDF, and notes on what it lacks.

        Raises:
            SheetsError: it cannot be made.
        """
        return self.printer.pdf(self._wanted(name, asked), _one_of(asked.get("paper", ""), PAPERS) or "a4")

    def _wanted(self, name: str, asked: Mapping[str, str]) -> Wanted:
        book = self.repository.open(name)
        language = _one_of(asked.get("language", ""), LANGUAGES)
        ref = asked.get("against", "")[:400]
        if not ref or ref == _NOTHING:
            return Wanted(self.repository.path(name).absolute(), book.reading.digest, language=language)
        other, digest = self._other(ref)
        return Wanted(self.repository.path(name).absolute(), book.reading.digest, other, digest, language)

    def _other(self, ref: str) -> tuple[Path, str]:
        """Return the file of the workbook to compare with, and its SHA-256."""
        with tempfile.TemporaryDirectory() as folder:
            path = path_of(self.repository, self.open_workbooks, self.runs, ref, Path(folder) / "version")
            content = b"" if path.is_dir() else path.read_bytes()
            if path.is_relative_to(folder):
                path = self.printer.held(content, path.name)
        return path, sha256(content).hexdigest()


def add_paper(pages: Blueprint, repository: WorkbookRepository, open_workbooks: OpenWorkbooks, runs: RunStore) -> None:
    """Add the routes of the printed page and its PDF."""
    printer = Printer(repository, open_workbooks, runs, ProtocolPrinter())

    def have(name: str) -> str:
        if not repository.has(name):
            abort(404)
        refuse_text(repository, name)
        repository.open(name)  # one that cannot be read, or leads out of the folder, is refused as everywhere
        return name

    @pages.get("/book/<name>/print", endpoint="print_page")
    def paper_page(name: str) -> str:
        return show(printer.page(have(name), request.args))

    @pages.get("/book/<name>/print/protocol")
    def protocol(name: str) -> str:
        return show(printer.part(have(name), request.args))

    @pages.get("/book/<name>/print/ready")
    def pdf_ready(name: str) -> Response:
        book = have(name)
        try:
            return jsonify({"notes": printer.pdf(book, request.args)[1]})
        except SheetsError as error:
            return jsonify({"trouble": f"{error.message} {error.remedy}".strip()})

    @pages.get("/book/<name>/print/protocol.pdf")
    def protocol_pdf(name: str) -> Response:
        data, _ = printer.pdf(have(name), request.args)
        file = f"{printable(Path(name).stem)}-protocol.pdf"
        return send_file(BytesIO(data), mimetype="application/pdf", as_attachment=True, download_name=file)

    @pages.get("/book/<name>/paper.css")
    def paper(name: str) -> Response:
        style = paper_style(name, repository.open(have(name)).reading.digest, today())
        return Response(style, mimetype="text/css")


def _approved(name: str, kept: Iterable[Version]) -> str:
    """Return the reference of the newest kept version whose name says that it was approved; empty if there is none."""
    return next((f"version/{v.id}/{name}" for v in kept if _APPROVED.search(v.name)), "")


def _one_of(text: str, known: Iterable[str]) -> str:
    return text if text in known else ""


def today() -> str:
    """Format the current date and time."""
    now = datetime.now()
    return f"{now.day} {now:%B %Y, %H:%M}"


def paper_style(name: str, digest: str, when: str) -> str:
    r"""Return the style sheet for the footer of printed pages; inline styles are forbidden.

    >>> print(paper_style("a.xlsx", "0123456789abcdef" * 4, "1 May 2026, 10:00").splitlines()[2].strip())
    @bottom-left { content: "a\2e xlsx   SHA-256 0123 4567 89ab cdef …   1 May 2026\2c  10\3a 00"; }
    """
    digits = " ".join(_pieces(digest[:16]))
    foot = f"{_css(name)}   SHA-256 {_css(digits)} …   {_css(when)}"
    return (
        "@media print {\n  @page {\n"
        f'    @bottom-left {{ content: "{foot}"; }}\n'
        '    @bottom-right { content: counter(page) " / " counter(pages); }\n'
        "  }\n}\n"
    )


def _pieces(digits: str) -> Iterable[str]:
    return (digits[n : n + 4] for n in range(0, len(digits), 4))


def _css(text: str) -> str:
    """Escape a text for a string in CSS: everything but letters and digits."""
    return re.sub(r"[^\w ]", lambda m: f"\\{ord(m[0]):x} ", " ".join(text.split())[:120])
