"""Help as pages of a site, which the server shows and `rrp-sheets help --html` writes: all links in it are relative.

Topics have a page each, and so has each code of a finding. Connectors, functions and devices are sections of the pages
of these names. The search looks through an index of all sections in the browser.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from markupsafe import Markup

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph.device_table import done_of
from rrp_sheets.help.as_html import as_html, draw, render
from rrp_sheets.help.codes import one_code
from rrp_sheets.help.connectors import one_connector
from rrp_sheets.help.devices import done_stream, names_of, one_device
from rrp_sheets.help.functions import one_function
from rrp_sheets.help.layout import Block, slug
from rrp_sheets.help.topics import GROUPS, SMALL_WORDS, TITLES, all_names, page_of, topic_of
from rrp_sheets.robots import load_robot
from rrp_sheets.texts import LANGUAGES, N_, listed, translate

SEARCH = "search.html"
_LISTS = ("connectors", "functions", "devices", "codes")  # topics that have no heading of their own


@dataclass(frozen=True, slots=True)
class Section:
    """Section of a page.

    Attributes:
        anchor: of its heading; empty for what is above the first heading.
        title: its heading.
        blocks: below the heading.
        named: whether it explains a connector, a function or a device.
        others: anchors of further names of that.
    """

    anchor: str
    title: str
    blocks: tuple[Block, ...]
    named: bool = False
    others: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class HelpPage:
    """Contents of one address of the site.

    Attributes:
        file: its name: `formulas.html`.
        title: its first heading, of which `anchor` is the anchor.
        sections: the first one has no heading.
        above: the file of the page that lists it, and that page's title; empty for a topic.
    """

    file: str
    title: str
    anchor: str
    sections: tuple[Section, ...]
    above: str = ""
    above_title: str = ""

    @property
    def headings(self) -> tuple[Section, ...]:
        """The sections that have a heading."""
        return tuple(section for section in self.sections if section.anchor)

    @property
    def examples(self) -> Iterator[Block]:
        """The examples in it."""
        blocks = [block for section in self.sections for block in section.blocks]
        while blocks:
            block = blocks.pop(0)
            if block.kind == "example":
                yield block
            blocks = [*block.parts, *blocks] if block.kind == "titled" else blocks


def place_of(name: str) -> str:
    """Return the relative address of the help on a name; that of the overview for one that is unknown.

    >>> place_of(""), place_of("records"), place_of("CLAMP"), place_of("Red ball"), place_of("FORM003")
    ('index.html', 'recordings.html', 'functions.html#CLAMP', 'devices.html#Red-ball', 'FORM003.html')
    """
    if (topic := topic_of(name)) is not None:
        return f"{topic or 'index'}.html"
    if name.upper() in CODES:
        return f"{name.upper()}.html"
    if (connector := connectors().get(name)) is not None:
        return f"connectors.html#{slug(connector.name)}"
    if (function := library().get(name)) is not None:
        return f"functions.html#{slug(function.name)}"
    if (device := load_robot().find(name)) is not None:
        return f"devices.html#{slug(device.name)}"
    return "devices.html#Say-done" if load_robot().find(done_of(name)) else "index.html"


def files() -> tuple[str, ...]:
    """Return the names of all pages."""
    topics = [topic for group in GROUPS.values() for topic in group]
    return (*(f"{topic or 'index'}.html" for topic in topics), *(f"{code}.html" for code in CODES), SEARCH)


@lru_cache(maxsize=500)
def page(file: str, language: str) -> HelpPage:
    """Return a page; raises KeyError when there is none of that name."""
    name = file.removesuffix(".html")
    if file == SEARCH:
        return HelpPage(SEARCH, translate(N_("Search the help"), language), "search", ())
    if name in CODES and file.endswith(".html"):
        above = page("codes.html", language)
        return _page(file, [*one_code(CODES[name], language)], language, above)
    if file not in files():
        raise KeyError(file)
    topic = "" if name == "index" else name
    blocks = [*page_of(topic, language)]
    if topic in _LISTS:
        blocks = [Block("heading", TITLES[topic], anchor=topic), *blocks]
    return _page(file, blocks, language)


def _page(file: str, blocks: Sequence[Block], language: str, above: HelpPage | None = None) -> HelpPage:
    first, *rest = blocks
    sections: list[Section] = []
    anchor, title = "", ""
    below: list[Block] = []
    for block in rest:
        if block.kind == "heading":
            sections.append(Section(anchor, title, tuple(below)))
            anchor, title, below = block.anchor, translate(block.head, language), []
        else:
            below.append(block)
    sections = [*sections, Section(anchor, title, tuple(below)), *_named(file, language)]
    title = translate(first.head, language)
    return HelpPage(file, title, first.anchor, tuple(sections), *(() if above is None else (above.file, above.title)))


def _named(file: str, language: str) -> Iterator[Section]:
    """Yield the sections of the names that a page lists."""
    if file == "connectors.html":
        yield from (_section([*one_connector(c, language)], language) for c in dict.fromkeys(connectors()))
    elif file == "functions.html":
        yield from (_section([*one_function(f)], language) for f in dict.fromkeys(library()))
    elif file == "devices.html":
        robot = load_robot()
        for device in robot.devices.values():
            names = names_of(robot, device)
            if names:
                found = robot.find(names[0])
                assert found is not None
                yield _section([*one_device(found, language)], language, names[1:])
        if (say := robot.find("Say")) is not None:
            dones = [f"{f.name} done" for f in robot.names.values() if f.offered and f.type.kind == "actuator"]
            yield _section([*done_stream(say, language)], language, [name for name in dones if name != "Say done"])


def _section(blocks: Sequence[Block], language: str, others: Sequence[str] = ()) -> Section:
    head, *rest = blocks
    return Section(head.anchor, translate(head.head, language), tuple(rest), True, tuple(map(slug, others)))


@lru_cache(maxsize=100)
def body(file: str, language: str, opens: str, level: int) -> Markup:
    """Return the HTML of a page's sections; see `as_html` for `opens` and `level`."""
    shown = []
    draw(page(file, language).examples, language)
    for section in page(file, language).sections:
        if section.anchor:
            shown.append(render("heading.html", language, section=section, level=level + 1))
        below = level + 1 if section.anchor else level
        shown.append(as_html(section.blocks, language, place_of, level=below, opens=opens, page=file))
    return Markup("").join(shown)


@dataclass(frozen=True, slots=True)
class Topic:
    """Entry of the list of topics."""

    file: str
    title: str


@dataclass(frozen=True, slots=True)
class TopicGroup:
    """Group of the list of topics."""

    title: str
    topics: tuple[Topic, ...]


@lru_cache(maxsize=1)
def navigation() -> tuple[TopicGroup, ...]:
    """Return the list of topics."""
    return tuple(
        TopicGroup(title, tuple(Topic(f"{topic or 'index'}.html", TITLES[topic]) for topic in topics))
        for title, topics in GROUPS.items()
    )


def framed(template: str, file: str, language: str, *, opens: str, level: int, **shown: object) -> Markup:
    """Render a page with the list of topics; `shown` is what the template takes besides."""
    topics = [topic for group in navigation() for topic in group.topics]
    places = [topic.file for topic in topics]
    at = places.index(file) if file in places else None
    found = page(file, language)
    neighbours = {
        "before": topics[at - 1] if at else None,
        "after": topics[at + 1] if at is not None and at + 1 < len(topics) else None,
    }
    names = ("file", "title", "anchor", "above", "above_title", "headings")
    shown_page = {name: getattr(found, name) for name in names}
    return render(
        template, language, page={**shown_page, **neighbours}, groups=navigation(), level=level,
        body=body(file, language, opens, level), **shown,
    )  # fmt: skip


def other_language(language: str) -> str:
    """Return the code of the language that a page has a link to."""
    return next(code for code in LANGUAGES if code != language)


@lru_cache(maxsize=len(LANGUAGES))
def search_index(language: str) -> str:
    """Return a script that gives all sections of the help to the search, as an array of objects."""
    words: dict[str, list[str]] = {}
    for entry in all_names():
        if entry.words:
            words.setdefault(place_of(entry.name), []).extend(entry.words)
    found = []
    for file in files():
        shown = page(file, language)
        lists = file.removesuffix(".html") in _LISTS
        for section in shown.sections:
            if lists and section.anchor and not section.named:
                continue  # a list of what has sections or pages of its own
            lines = (" ".join(translate(line, language).replace("`", "").split()) for line in _lines(section.blocks))
            found.append({
                "page": file, "anchor": section.anchor, "title": shown.title, "part": section.title,
                "text": "\n".join(lines), "words": _words_of(section, file, words), "others": section.others,
            })  # fmt: skip
    texts = json.dumps(found, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    small = json.dumps(sorted(SMALL_WORDS))
    return f"globalThis.helpSmallWords = {small};\nglobalThis.helpSections = {texts};\n"


def _words_of(section: Section, file: str, words: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the plain words of a section, from those of all addresses; a topic's are those of its beginning."""
    places = [f"{file}#{anchor}" for anchor in (section.anchor, *section.others)] if section.anchor else [file]
    return list(dict.fromkeys(word for place in places for word in words.get(place, ())))


def _lines(blocks: Sequence[Block]) -> Iterator[str]:
    """Yield the texts of blocks."""
    for block in blocks:
        if block.kind == "marbles":
            continue
        if block.head and block.kind != "example":
            yield block.head
        for row in block.rows:
            cells = [cell for cell in row if cell]
            yield listed(cells) if block.kind != "entries" else N_("{term}: {meaning}", term=row[0], meaning=row[-1])
        yield from _lines(block.parts)
