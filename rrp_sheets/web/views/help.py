"""Help: its pages, the panel beside the grid, and examples that become workbooks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, Response, abort, redirect, render_template, request, url_for
from markupsafe import Markup
from werkzeug.wrappers import Response as AnyResponse

from rrp_sheets.errors import SheetsError
from rrp_sheets.help import site
from rrp_sheets.help.as_html import as_html
from rrp_sheets.help.functions import one_helper
from rrp_sheets.help.layout import Block, rows_to_open
from rrp_sheets.help.streams import find_stream, one_stream
from rrp_sheets.help.topics import HelpEntry, all_names, near, search, text_on
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import LANGUAGES, N_
from rrp_sheets.web.models import error_text, show
from rrp_sheets.web.requests import page_language, workbook_or_404
from rrp_sheets.web.services import services
from rrp_sheets.web.views.workbook_list import new_path, numbered_path
from rrp_sheets.workbook.files import make_workbook

blueprint = Blueprint("help", __name__)
MOST = 6  # topics at once
_HELPER = "helper:"  # before the name of a helper of the workbook that `book` names
_STREAM = "stream:"  # before the name of a stream of that workbook and its sheet, as `stream:Tracking!Far`
KINDS: Mapping[str, str] = {
    "topic": N_("topic"), "connector": N_("connector"), "function": N_("function"), "sensor": N_("sensor"),
    "actuator": N_("actuator"), "stream": N_("stream"), "error": N_("error"), "warning": N_("warning"),
    "info": N_("note"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class HelpPiece:
    """Help panel: the topics, the names `found` under a query, or those to try under some of its words."""

    template: ClassVar[str] = "help.html"
    kinds: ClassVar[Mapping[str, str]] = KINDS
    topics: tuple[Markup, ...]
    query: str = ""
    found: tuple[HelpEntry, ...] = ()
    tries: tuple[HelpEntry, ...] = ()
    names: tuple[str, ...] = ()
    groups: tuple[site.TopicGroup, ...] = ()


@dataclass(frozen=True, slots=True)
class HelpSitePage:
    """Page of the help, with its list of topics (`body`); `search` loads the search, in the language of `index`."""

    template: ClassVar[str] = "helppage.html"
    title: str
    body: Markup
    search: bool
    index: str


@blueprint.get("/help")
def on() -> AnyResponse | str:
    """Show the help panel; a link of it that is opened in a tab of its own leads to the page."""
    query = request.args.get("q", "")[:100].strip()
    asked = [t[:100] for t in request.args.getlist("topic") if t.strip()][:MOST]
    if _is_navigation():
        searched = url_for("help.page", file=site.SEARCH, q=query) if query else ""
        return redirect(searched or _address(asked[0] if asked else ""))
    language = page_language()
    found = tuple(search(query, language))
    tries = () if found else tuple(near(query, language))
    if query and not asked:
        asked = [found[0].name] if len(found) == 1 else []
    book = request.args.get("book", "")
    texts = [(t, _of_workbook(book, t) or _topic(t, language)) for t in dict.fromkeys(asked)]
    topics = [(t, blocks) for t, blocks in texts if blocks]
    if not topics and not query:
        topics = [("", _topic("", language))]
    shown = tuple(as_html(blocks, language, _address, page=_file(t)) for t, blocks in topics)
    names = tuple(n.name for n in all_names())
    return show(HelpPiece(shown, query, found, tries, names, site.navigation()))


@blueprint.get("/help/<file>")
def page(file: str) -> Response | str:
    """Show a page of the help, in the reader's language or, with `lang`, in another one."""
    wanted = request.args.get("lang", "")
    language = wanted if wanted in LANGUAGES else page_language()
    if file == "search-index.js":
        return Response(site.search_index(language), mimetype="text/javascript")
    if file not in site.files():
        abort(404)
    other = site.other_language(language)
    there = {"language": other, "name": LANGUAGES[other], "href": f"{file}?lang={other}"}
    body = site.framed("page.html", file, language, opens="server", level=2, other=there)
    index = url_for("help.page", file="search-index.js", lang=language)
    return show(HelpSitePage(site.page(file, language).title, body, file == site.SEARCH, index))


@blueprint.post("/help/open")
def open_example() -> Response | str:
    """Create a workbook from an example of a page, and open it."""
    file, anchor = request.form.get("page", ""), request.form.get("example", "")
    if file not in site.files():
        abort(404)
    found = next((example for example in site.page(file, page_language()).examples if example.anchor == anchor), None)
    if found is None:
        abort(404)
    name, repository = request.form.get("name", "").strip(), services().repository
    try:
        as_proposed = name == found.head
        path = numbered_path(repository.folder / f"{name}.xlsx") if as_proposed else new_path(repository, name)
        make_workbook(rows_to_open(found), path, replace=False)
    except SheetsError as error:
        return render_template("notice.html", text=error_text(error))
    answer = Response("")
    answer.headers["HX-Redirect"] = url_for("sheet.page", name=path.name)
    return answer


def _is_navigation() -> bool:
    """Return whether a person follows a link; where the connection is not encrypted, browsers do not say so."""
    headers = request.headers
    wanted = headers.get("Sec-Fetch-Dest")
    return wanted == "document" if wanted else headers.get("Accept", "").startswith("text/html")


def _file(name: str) -> str:
    return site.place_of(name).partition("#")[0]


def _address(name: str) -> str:
    file, _, anchor = site.place_of(name).partition("#")
    return url_for("help.page", file=file, _anchor=anchor or None)


def _of_workbook(book: str, asked: str) -> list[Block]:
    """Return the help on a helper or a stream of a workbook; empty for another topic."""
    if asked.startswith(_HELPER):
        return _helper(book, asked)
    return _stream(book, asked) if asked.startswith(_STREAM) else []


def _stream(book: str, asked: str) -> list[Block]:
    """Return the help on a stream of a workbook; empty for a name that is none."""
    analysis = workbook_or_404(book).analysis()
    sheet, _, name = asked.removeprefix(_STREAM).rpartition("!")
    found = find_stream(analysis.graph, sheet, name)
    if found is None:
        return []
    return list(one_stream(analysis.workbook, analysis.graph, found, analysis.stream_examples))


def _helper(book: str, asked: str) -> list[Block]:
    """Return the help on a helper of a workbook; empty when it has been renamed or deleted."""
    wanted = key(asked.removeprefix(_HELPER))
    helpers = workbook_or_404(book).analysis().workbook.helpers
    found = next((h for h in helpers if key(argument_name(h.name.text)) == wanted), None)
    return [*one_helper(found)] if found else []


def _topic(name: str, language: str) -> list[Block]:
    try:
        return [*text_on(name, language=language)]
    except SheetsError:  # a stream of the user's own, say: there is nothing on it
        return []
