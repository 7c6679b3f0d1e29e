"""Help panel beside the grid: the texts of `rrp-sheets help` as HTML, with marble diagrams of the examples."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from flask import Blueprint, render_template, request
from markupsafe import Markup, escape

from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.render.marble_diagram import Bar, Lane, Marble, MarbleDiagram
from rrp_sheets.topics.connector_marbles import example_score, short
from rrp_sheets.topics.finding import HelpEntry, all_names, known, near, search, text_on
from rrp_sheets.topics.functions import one_helper
from rrp_sheets.topics.layout import Block, paragraph
from rrp_sheets.web.completions import of_help
from rrp_sheets.web.models import TextPiece
from rrp_sheets.web.requests import workbook_or_404

blueprint = Blueprint("help", __name__)
MOST = 6  # topics at once
_HELPER = "helper:"  # before the name of a helper of the workbook that `book` names
_PICTURED = "As marbles: time goes to the right"  # its text in the terminal has places instead
_ASKS = re.compile(r'^(?:rrp-sheets help )?"?([^"]+?)"?$')
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True)
class HelpBlock:
    """Block of a topic, ready to be shown: `kind` as of `topics.layout.Block`, `rows` of texts in their pieces."""

    kind: str
    head: tuple[TextPiece, ...] = ()
    rows: tuple[tuple[tuple[TextPiece, ...], ...], ...] = ()
    parts: tuple[HelpBlock, ...] = ()
    picture: Markup | None = None


@dataclass(frozen=True, slots=True)
class HelpPiece:
    """Content of the help panel.

    Attributes:
        topics: their blocks, one topic after the other.
        query: what was searched for; `found` are the names under it, `tries` those under some of its words.
        names: the names of all help topics.
    """

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
    texts = (_helper(book, t) if t.startswith(_HELPER) else _topic(t) for t in dict.fromkeys(asked))
    topics = tuple(blocks for blocks in texts if blocks)
    if not topics and not query:
        topics = (_topic(""),)
    names = tuple(n.name for n in all_names())
    piece = HelpPiece(topics, query, found, tries, names)
    whole = request.headers.get("Sec-Fetch-Dest") == "document"  # a link of the panel, opened in a tab of its own
    return render_template("helppage.html" if whole else piece.template, page=piece)


def _helper(book: str, asked: str) -> tuple[HelpBlock, ...]:
    """Return the help on a helper of a workbook; empty when it has been renamed or deleted."""
    wanted = key(asked.removeprefix(_HELPER))
    helpers = workbook_or_404(book).analysis().workbook.helpers
    found = next((h for h in helpers if key(argument_name(h.name.text)) == wanted), None)
    return tuple(_parts(one_helper(found))) if found else ()


def _topic(name: str) -> tuple[HelpBlock, ...]:
    try:
        return tuple(_parts(text_on(name)))
    except SheetsError:  # a stream of the user's own, say: there is nothing on it
        return ()


def _parts(blocks: Iterator[str]) -> Iterator[HelpBlock]:
    yield from (_part(block) for block in blocks)


def _part(block: str) -> HelpBlock:
    if not isinstance(block, Block):
        block = paragraph(of_help(block))
    if block.kind == "marbles" and (connector := connectors().get(block.head)) is not None:
        return HelpBlock("marbles", picture=marble_picture(example_score(connector)))
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
    end, text = 0, of_help(text)
    for match in _CODE.finditer(text):
        if match.start() > end:
            yield TextPiece(text[end : match.start()])
        asked = _ASKS.match(match[1])
        topic = known(asked[1]) if asked and match[1].startswith("rrp-sheets help ") else ""
        yield TextPiece(asked[1], topic=topic) if asked and topic else TextPiece(match[1], code=True)
        end = match.end()
    if end < len(text):
        yield TextPiece(text[end:])


_WIDE = 400  # pixels, where the marbles have room in it
_NAME, _RIGHT, _LANE, _BAR, _AXIS = 52, 40, 36, 32, 24
_RADIUS, _LETTER, _GAP = 12, 4, 4  # of a marble; half a letter's width; between two marbles
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # seconds between the marks of the time
_LEAST_STEP = 44  # pixels


def marble_picture(score: MarbleDiagram) -> Markup:
    """Draw an example (`topics.connector_marbles`) as SVG: the inputs, a bar for the connector, the output, the time.

    Args:
        score: whose last group has the connector's bar and its output.
    """
    *inputs, output = score.groups
    lanes = [group.lane for group in inputs]
    time = _Time(max(score.last_us, 1) / 1e6, (*lanes, output.lane))
    pieces, y = [], 16
    for lane in lanes:
        pieces.append(_lane(lane, y, time))
        y += _LANE
    for bar in output.bars:
        pieces.append(_bar(bar, y, time))
        y += _BAR + 6
    pieces.append(_lane(output.lane, y + 4, time, out=True))
    wide, high = time.wide, y + _LANE + _AXIS - 12
    pieces.append(_axis(time, high - 6))
    told = "; ".join(
        [*map(_told, lanes), *(f"{b.connector} {b.formula}".strip() for b in output.bars), _told(output.lane)]
    )
    return Markup(
        f'<svg class="marble-picture" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" role="img" '
        f'aria-label="{escape(told)}">{"".join(pieces)}</svg>'
    )


class _Time:
    """Horizontal time scale of an example, wide enough that marbles overlap neither each other nor the name."""

    def __init__(self, span: float, lanes: Sequence[Lane]) -> None:
        self.span = span
        self.left = _NAME + max((_half(lane.marbles[0]) for lane in lanes if lane.marbles), default=_RADIUS)
        self.scale = max((_WIDE - self.left - _RIGHT) / span, *map(_least, lanes))
        self.wide = round(self.left + span * self.scale + _RIGHT)

    def x(self, seconds: float) -> float:
        return round(self.left + seconds * self.scale, 1)


def _least(lane: Lane) -> float:
    """Return the pixels per second at which no two marbles of a stream touch."""
    pairs = zip(lane.marbles, lane.marbles[1:], strict=False)
    return max(((_half(a) + _half(b) + _GAP) / max((b.us - a.us) / 1e6, 0.05) for a, b in pairs), default=0.0)


def _lane(lane: Lane, y: int, time: _Time, *, out: bool = False) -> str:
    marbles = []
    round_by = 2 if lane.kind == "actuator" else _RADIUS  # a square, as in the diagram
    for marble in lane.marbles:
        x, half = time.x(marble.us / 1e6), _half(marble)
        marbles.append(
            f'<rect class="marble" x="{x - half:g}" y="{y - _RADIUS}" width="{2 * half}" height="{2 * _RADIUS}" '
            f'rx="{round_by}"/><text class="value" x="{x:g}" y="{y + 4}">{escape(_text(marble))}</text>'
        )
    return (
        f'<g class="lane is-{lane.kind}{" is-out" if out else ""}"><text class="name" x="0" y="{y + 4}">'
        f'{escape(lane.label)}</text><path class="line" d="M{_NAME} {y}H{time.wide - 8}m-5 -4 5 4 -5 4"/>'
        f"{''.join(marbles)}</g>"
    )


def _bar(bar: Bar, y: int, time: _Time) -> str:
    """Draw the bar of the connector, with ticks where its clock acts."""
    top = y - _BAR // 2
    ticks = "".join(f'<path class="tick" d="M{time.x(us / 1e6):g} {top}v-6"/>' for us in bar.ticks)
    formula = f' <tspan class="formula">{escape(bar.formula)}</tspan>' if bar.formula else ""
    return (
        f'<g class="bar"><rect x="{_NAME}" y="{top}" width="{time.wide - _NAME - 8}" height="{_BAR - 4}" rx="4"/>'
        f'<g class="sign" transform="translate({_NAME + 8} {top + 8})">{bar.icon}</g>'
        f'<text x="{_NAME + 28}" y="{top + 18}">{escape(bar.connector)}{formula}</text>{ticks}</g>'
    )


def _axis(time: _Time, y: int) -> str:
    step = next((s for s in _STEPS if s * time.scale >= _LEAST_STEP), _STEPS[-1])
    times = (step * n for n in range(int(time.span / step + 1e-6) + 1))
    marks = "".join(f'<text class="time" x="{time.x(t):g}" y="{y}">{t:.3g} s</text>' for t in times)
    return f'<g aria-hidden="true">{marks}</g>'


def _half(marble: Marble) -> int:
    return max(_RADIUS, len(_text(marble)) * _LETTER + 4)


def _text(marble: Marble) -> str:
    return "!" if marble.error else short(marble.value)


def _told(lane: Lane) -> str:
    found: Iterable[str] = (f"{_text(m)} at {m.us / 1e6:g} s" for m in lane.marbles)
    return f"{lane.label}: {', '.join(found) or 'nothing'}"
