"""Help beside the grid: the texts of `rrp-sheets help`, as a piece of a page."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, render_template, request
from markupsafe import Markup

from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.testing.example import example_score
from rrp_sheets.topics.finding import text_on
from rrp_sheets.topics.functions import one_helper
from rrp_sheets.topics.layout import Block, paragraph
from rrp_sheets.topics.names import Name, all_names, known, near, search
from rrp_sheets.web.addressed import RoomOf
from rrp_sheets.web.browserwords import of_help
from rrp_sheets.web.marblepicture import marble_picture

MOST = 6  # topics at once
_HELPER = "helper:"  # before the name of a helper of the workbook that `book` names
_PICTURED = "As marbles: time goes to the right"  # its text in the terminal has places instead
_ASKS = re.compile(r'^(?:rrp-sheets help )?"?([^"]+?)"?$')
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True)
class Bit:
    """A piece of a text: plain, a formula (`code`), or a link to another topic."""

    text: str
    code: bool = False
    topic: str = ""


@dataclass(frozen=True, slots=True)
class Part:
    """A block of a topic, ready to be shown: `kind` as of `topics.layout.Block`, `rows` of texts in their pieces."""

    kind: str
    head: tuple[Bit, ...] = ()
    rows: tuple[tuple[tuple[Bit, ...], ...], ...] = ()
    parts: tuple[Part, ...] = ()
    picture: Markup | None = None


@dataclass(frozen=True, slots=True)
class HelpPiece:
    """What the help panel shows.

    Attributes:
        topics: their blocks, one topic after the other.
        query: what was searched for; `found` are the names under it, `tries` those under some of its words.
        names: all that can be asked for.
    """

    template: ClassVar[str] = "help.html"
    topics: tuple[tuple[Part, ...], ...]
    query: str = ""
    found: tuple[Name, ...] = ()
    tries: tuple[Name, ...] = ()
    names: tuple[str, ...] = ()


def make_helping(room_of: RoomOf) -> Blueprint:
    """The routes of the help panel."""
    pages = Blueprint("help", __name__)

    @pages.get("/help")
    def on() -> str:
        query = request.args.get("q", "")[:100].strip()
        asked = [t[:100] for t in request.args.getlist("topic") if t.strip()][:MOST]
        found = tuple(search(query))
        tries = () if found else tuple(near(query))
        if query and not asked:
            asked = [found[0].name] if len(found) == 1 else []
        book = request.args.get("book", "")
        texts = (_helper(room_of, book, t) if t.startswith(_HELPER) else _topic(t) for t in dict.fromkeys(asked))
        topics = tuple(blocks for blocks in texts if blocks)
        if not topics and not query:
            topics = (_topic(""),)
        names = tuple(n.name for n in all_names())
        piece = HelpPiece(topics, query, found, tries, names)
        whole = request.headers.get("Sec-Fetch-Dest") == "document"  # a link of the panel, opened in a tab of its own
        return render_template("helppage.html" if whole else piece.template, page=piece)

    return pages


def _helper(room_of: RoomOf, book: str, asked: str) -> tuple[Part, ...]:
    """The help on a helper of a workbook, or nothing when it has been renamed or deleted."""
    wanted = key(asked.removeprefix(_HELPER))
    helpers = room_of(book).analysis().workbook.helpers
    found = next((h for h in helpers if key(argument_name(h.name.text)) == wanted), None)
    return tuple(_parts(one_helper(found))) if found else ()


def _topic(name: str) -> tuple[Part, ...]:
    try:
        return tuple(_parts(text_on(name)))
    except SheetsError:  # a stream of the user's own, say: there is nothing on it
        return ()


def _parts(blocks: Iterator[str]) -> Iterator[Part]:
    yield from (_part(block) for block in blocks)


def _part(block: str) -> Part:
    if not isinstance(block, Block):
        block = paragraph(of_help(block))
    if block.kind == "marbles" and (connector := connectors().get(block.head)) is not None:
        return Part("marbles", picture=marble_picture(example_score(connector)))
    linked = block.kind in ("entries", "columns")
    rows = tuple(
        tuple(_term(cell) if linked and i == 0 else tuple(bits(cell)) for i, cell in enumerate(row))
        for row in block.rows
    )
    parts = tuple(_part(p) for p in block.parts)
    head = _PICTURED if any(part.picture for part in parts) else block.head
    return Part(block.kind, tuple(bits(head)), rows, parts)


def _term(text: str) -> tuple[Bit, ...]:
    """The term of a list: a link where there is help on it."""
    asked = _ASKS.match(text)
    name = known(asked[1]) if asked else ""
    shown = asked[1] if asked and text.startswith("rrp-sheets help ") else text
    return (Bit(shown, topic=name),) if name else tuple(bits(text))


def bits(text: str) -> Iterator[Bit]:
    """A text in its pieces: what stands between backticks is a formula, or leads to another topic.

    >>> [(b.text, b.code, b.topic) for b in bits("see `rrp-sheets help sample` or `x > 1`")]
    [('see ', False, ''), ('sample', False, 'sample'), (' or ', False, ''), ('x > 1', True, '')]
    """
    end, text = 0, of_help(text)
    for match in _CODE.finditer(text):
        if match.start() > end:
            yield Bit(text[end : match.start()])
        asked = _ASKS.match(match[1])
        topic = known(asked[1]) if asked and match[1].startswith("rrp-sheets help ") else ""
        yield Bit(asked[1], topic=topic) if asked and topic else Bit(match[1], code=True)
        end = match.end()
    if end < len(text):
        yield Bit(text[end:])
