"""Help panel beside the grid: the texts of `rrp-sheets help` as HTML, with marble diagrams of the examples."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, render_template, request
from markupsafe import Markup

from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.help.connectors import draw_example, example_score
from rrp_sheets.help.functions import one_helper
from rrp_sheets.help.layout import Block, paragraph
from rrp_sheets.help.streams import find_stream, one_stream
from rrp_sheets.help.topics import HelpEntry, all_names, known, near, search, text_on
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import N_
from rrp_sheets.web.completions import of_help
from rrp_sheets.web.models import TextPiece
from rrp_sheets.web.requests import workbook_or_404

blueprint = Blueprint("help", __name__)
MOST = 6  # topics at once
_HELPER = "helper:"  # before the name of a helper of the workbook that `book` names
_STREAM = "stream:"  # before the name of a stream of that workbook and its sheet, as `stream:Tracking!Far`
_PICTURED = N_("As marbles: time goes to the right")  # its text in the terminal has places instead
_ASKS = re.compile(r'^(?:rrp-sheets help )?"?([^"]+?)"?$')
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True)
class HelpBlock:
    """Block of a topic, ready to be shown: `kind` as of `help.layout.Block`, `rows` of texts in their pieces."""

    kind: str
    head: tuple[TextPiece, ...] = ()
    rows: tuple[tuple[tuple[TextPiece, ...], ...], ...] = ()
    parts: tuple[HelpBlock, ...] = ()
    picture: Markup | None = None


@dataclass(frozen=True, slots=True)
class HelpPiece:
    """Help panel: the blocks of topics, the names `found` under a query, or those to try under some of its words."""

    template: ClassVar[str] = "help.html"
    topics: tuple[tuple[HelpBlock, ...], ...]
    query: str = ""
    found: tuple[HelpEntry, ...] = ()
    tries: tuple[HelpEntry, ...] = ()
    names: tuple[str, ...] = ()


@blueprint.get("/help")
def on() -> str:
    """Show help topics, those that were searched for included."""
    query = request.args.get("q", "")[:100].strip()
    asked = [t[:100] for t in request.args.getlist("topic") if t.strip()][:MOST]
    found = tuple(search(query))
    tries = () if found else tuple(near(query))
    if query and not asked:
        asked = [found[0].name] if len(found) == 1 else []
    book = request.args.get("book", "")
    texts = (_of_workbook(book, t) or _topic(t) for t in dict.fromkeys(asked))
    topics = tuple(blocks for blocks in texts if blocks)
    if not topics and not query:
        topics = (_topic(""),)
    names = tuple(n.name for n in all_names())
    piece = HelpPiece(topics, query, found, tries, names)
    whole = request.headers.get("Sec-Fetch-Dest") == "document"  # a link of the panel, opened in a tab of its own
    return render_template("helppage.html" if whole else piece.template, page=piece)


def _of_workbook(book: str, asked: str) -> tuple[HelpBlock, ...]:
    """Return the help on a helper or a stream of a workbook; empty for another topic."""
    if asked.startswith(_HELPER):
        return _helper(book, asked)
    return _stream(book, asked) if asked.startswith(_STREAM) else ()


def _stream(book: str, asked: str) -> tuple[HelpBlock, ...]:
    """Return the help on a stream of a workbook; empty for a name that is none."""
    analysis = workbook_or_404(book).analysis()
    sheet, _, name = asked.removeprefix(_STREAM).rpartition("!")
    found = find_stream(analysis.graph, sheet, name)
    if found is None:
        return ()
    return tuple(map(_part, one_stream(analysis.workbook, analysis.graph, found, analysis.stream_examples)))


def _helper(book: str, asked: str) -> tuple[HelpBlock, ...]:
    """Return the help on a helper of a workbook; empty when it has been renamed or deleted."""
    wanted = key(asked.removeprefix(_HELPER))
    helpers = workbook_or_404(book).analysis().workbook.helpers
    found = next((h for h in helpers if key(argument_name(h.name.text)) == wanted), None)
    return tuple(map(_part, one_helper(found))) if found else ()


def _topic(name: str) -> tuple[HelpBlock, ...]:
    try:
        return tuple(map(_part, text_on(name)))
    except SheetsError:  # a stream of the user's own, say: there is nothing on it
        return ()


def _part(block: str) -> HelpBlock:
    if not isinstance(block, Block):
        block = paragraph(of_help(block))
    if block.kind == "marbles" and (connector := connectors().get(block.head)) is not None:
        return HelpBlock("marbles", picture=draw_example(example_score(connector)))
    linked = block.kind in ("entries", "columns")
    rows = tuple(
        tuple(_term(cell) if linked and i == 0 else tuple(bits(cell)) for i, cell in enumerate(row))
        for row in block.rows
    )
    parts = tuple(_part(p) for p in block.parts)
    head = _PICTURED if any(part.picture for part in parts) else block.head
    return HelpBlock(block.kind, tuple(bits(head)), rows, parts)


def _term(text: str) -> tuple[TextPiece, ...]:
    """Return the term of a list, as a link if there is help on it."""
    asked = _ASKS.match(text)
    name = known(asked[1]) if asked else ""
    shown = asked[1] if asked and text.startswith("rrp-sheets help ") else text
    return (TextPiece(shown, topic=name),) if name else tuple(bits(text))


def bits(text: str) -> Iterator[TextPiece]:
    """Split a text into pieces: what stands between backticks is a formula or a link to another topic.

    >>> [(b.text, b.code, b.topic) for b in bits("see `rrp-sheets help sample` or `x > 1`")]
    [('see ', False, ''), ('sample', False, 'sample'), (' or ', False, ''), ('x > 1', True, '')]
    """
    for number, piece in enumerate(_CODE.split(of_help(text))):
        is_code = number % 2 == 1
        asked = _ASKS.match(piece) if is_code and piece.startswith("rrp-sheets help ") else None
        if asked and (topic := known(asked[1])):
            yield TextPiece(asked[1], topic=topic)
        elif piece:
            yield TextPiece(piece, code=is_code)
