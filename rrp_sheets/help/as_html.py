"""Renders help topics as HTML for the help panel of the grid, the help pages of the server, and published pages."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from rrp_sheets import page_texts
from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.help.connectors import draw_example, example_score
from rrp_sheets.help.layout import Block, checked
from rrp_sheets.help.topics import TITLES, TOPICS, english, known, topic_of
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_, translate

_SECONDS = 5.0  # in which a diagram is laid out
_AT_ONCE = 4  # processes that lay out
_ASKS = re.compile(r'^rrp-sheets help "?([^"]+?)"?$')
_CODE = re.compile(r"`([^`]+)`")
_PICTURED = N_("As marbles: time goes to the right")  # its text in a terminal has places instead
Link = Callable[[str], str]
"""Returns the address of the help on a name."""


@dataclass(frozen=True, slots=True)
class HelpText:
    """HelpText of a text: plain, code, or a link to the help on a name (`topic`)."""

    text: str
    code: bool = False
    topic: str | None = None


def as_html(
    blocks: Iterable[Block], language: str, link: Link, *, level: int = 3, opens: str = "", page: str = ""
) -> Markup:
    """Render blocks in a language.

    Args:
        blocks: of a topic.
        language: its code.
        link: returns the address of the help on a name.
        level: of headings; titles within a topic are one below.
        opens: `server` for examples that are opened as workbooks of the server, the address of a folder with their
            files, or an empty text.
        page: the file of the page that the blocks are on.
    """
    return render(
        "blocks.html", language, blocks=blocks, link=link, level=level, opens=opens, page=page,
        ids=page == "codes.html", linked=page != "glossary.html",  # the word behaviour is no device
    )  # fmt: skip


def render(template: str, language: str, **shown: object) -> Markup:
    """Render a template of `templates/help/` in a language; all texts in it are escaped."""
    return Markup(_templates().get_template(template).render(shown, language=language))


@lru_cache(maxsize=1)
def _templates() -> Environment:
    loader = FileSystemLoader(bundled("templates", "help"))
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page_texts.install(made, lambda context: str(context["language"]))
    made.globals |= {
        "pieces": pieces, "term": term, "letters": column_letters, "marbles": _marbles, "diagrams": diagrams,
        "pictured": lambda block: _PICTURED if any(p.kind == "marbles" for p in block.parts) else block.head,
    }  # fmt: skip
    return made


def pieces(text: str, language: str) -> list[HelpText]:
    """Split a text in a language: what stands between backticks is code, or a link to another topic.

    >>> [(p.text, p.code, p.topic) for p in pieces("see `rrp-sheets help sample` or `x > 1`", "en")]
    [('see ', False, None), ('sample', False, 'sample'), (' or ', False, None), ('x > 1', True, None)]
    """
    found = []
    for number, piece in enumerate(_CODE.split(translate(text, language))):
        if number % 2:
            found.append(_linked(piece, language) or HelpText(piece, code=True))
        elif piece:
            found.append(HelpText(piece))
    return found


def _linked(command: str, language: str) -> HelpText | None:
    asked = _ASKS.match(command)
    if asked is None:
        return None
    if (topic := topic_of(asked[1])) is not None:
        return HelpText(translate(TITLES[topic], language), topic=topic)
    return HelpText(asked[1], topic=name) if (name := known(asked[1])) else None


def term(text: str, language: str) -> list[HelpText]:
    """Return the term of a list, as a link if there is help on it."""
    name = known(text)
    if not name or english(text) != name:  # the field “distance”, say, is no function
        return pieces(text, language)
    return [HelpText(translate(TITLES[name], language) if name in TOPICS else text, topic=name)]


def _marbles(block: Block, language: str) -> Markup | str:
    connector = connectors().get(block.head)
    return draw_example(example_score(connector), language) if connector is not None else ""


def draw(examples: Iterable[Block], language: str) -> None:
    """Draw the diagrams of examples ahead, several at once."""
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        list(pool.map(lambda block: _drawn(block.source, language), [b for b in examples if b.drawn]))


def diagrams(block: Block, language: str) -> Iterator[Markup]:
    """Yield the diagrams of the behaviours of an example; none where they cannot be drawn."""
    for number, svg in enumerate(_drawn(block.source, language) if block.drawn else (), 1):
        yield Markup(svg.replace("b1-", f"{block.anchor}-{number}-"))


@lru_cache(maxsize=200)
def _drawn(source: str, language: str) -> tuple[str, ...]:
    from rrp_sheets.render.diagram import draw_diagram

    graph = checked(source).graph
    try:
        drawn = (draw_diagram(graph, b, whole=True, timeout=_SECONDS, language=language) for b in graph.behaviours)
        return tuple(re.sub(r"\bb\d+-", "b1-", pages[0].svg) for pages in drawn if pages)
    except SheetsError:  # no Graphviz, say: the rows are there
        return ()
