"""Finds and lists help: on a topic, a word of the sheets, or the name of a connector, function, device or finding."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.functions import library
from rrp_sheets.help.functions import first_line
from rrp_sheets.help.layout import FOR_EXAMPLE, Block, example, from_file, titled, workbook
from rrp_sheets.model.names import key, nearest
from rrp_sheets.robots import FoundDevice, load_robot
from rrp_sheets.texts import N_, listed, translate
from rrp_sheets.workbook.schema import SHEETS, SheetKind

_WORDS = ("words", "stream", "streams", "event", "events", "field", "fields", "frame", "seed", "rad", "trace", "units",
          "state", "states", "instant")  # fmt: skip
_SYNONYMS = {
    "connector": "connectors", "operators": "connectors", "operator": "connectors",
    "formula": "formulas", "language": "formulas", "function": "functions", "helper": "helpers",
    "priorities": "priority", "framerate": "protocol", "engines": "engine",
    "device": "devices", "sensors": "devices", "sensor": "devices", "actuators": "devices", "actuator": "devices",
    "test": "tests", "testing": "tests", "scenes": "scene", "errors": "codes", "error": "codes",
    "warnings": "codes", "messages": "codes", "code": "codes", "overview": "", "help": "", "index": "",
    "workbook": "sheets", "workbooks": "sheets", "sheet": "sheets", "record": "recordings", "records": "recordings",
    "recording": "recordings",
    "server": "serve", "browser": "serve", "grid": "serve", "paper": "ethics", "comparing": "compare", "git": "compare",
    "bundle": "bundles", "installation": "systems", "windows": "systems", "macos": "systems",
    **dict.fromkeys(_WORDS, "glossary"),
}  # fmt: skip
TITLES = {
    "": N_("Overview"), "sheets": N_("Sheets and files"), "serve": N_("The grid and runs"), "keys": N_("Keys"),
    "glossary": N_("Glossary"), "connectors": N_("Connectors"), "formulas": N_("Formulas"),
    "functions": N_("Functions"), "helpers": N_("Helpers"), "total": N_("The total"), "priority": N_("Priority"),
    "engine": N_("Engine"), "devices": N_("Devices"), "robot": N_("The robot"), "scene": N_("The scene"),
    "tests": N_("Tests"), "codes": N_("Problems that a check finds"), "compare": N_("Check and compare"),
    "protocol": N_("The Protocol sheet"), "risks": N_("The Risks sheet"), "ethics": N_("Print for the ethics board"),
    "recordings": N_("Recordings"),
    "bundles": N_("Bundles"), "systems": N_("Systems"),
}  # fmt: skip
"""The short title of each topic, by which lists and links name it."""
GROUPS = {
    N_("To begin with"): {
        "": N_("what a workbook is, and all topics"),
        "sheets": N_("the sheets of a workbook, and the files it may be in"),
        "serve": N_("the grid in the browser: who may use it, editing together, operating a run"),
        "keys": N_("the keys of the grid"),
        "glossary": N_("what the words mean: stream, event, connector, subscribe, field, frame, seed, rad"),
    },
    N_("Rows and formulas"): {
        "connectors": N_("what a row can do with its input streams"),
        "formulas": N_("how formulas are written"),
        "functions": N_("the functions of formulas"),
        "helpers": N_("formulas with a name of their own"),
        "total": N_("the value of accumulate so far"),
        "priority": N_("which command wins when two want the same joints"),
        "engine": N_("how rows follow each other in time"),
    },
    N_("Robot and room"): {
        "devices": N_("what the robot senses and does"),
        "robot": N_("what the simulated robot senses, does, and cannot do"),
        "scene": N_("what happens in the simulated room"),
    },
    N_("Checking and testing"): {
        "tests": N_("test sheets: what is sent, and what must come out"),
        "codes": N_("what a check can find, and how to fix it"),
        "compare": N_("check, explain and compare workbooks; git"),
    },
    N_("Studies"): {
        "protocol": N_("the Protocol sheet: title, engine, seed, time limit"),
        "risks": N_("the Risks sheet: what could go wrong for people"),
        "ethics": N_("the protocol on paper, for the ethics board"),
        "recordings": N_("what a run leaves: look back, export, delete, replay"),
        "bundles": N_("a workbook with all that belongs to it, in one file"),
        "systems": N_("where the program runs, and what is measured"),
    },
}  # fmt: skip
"""The topics in the order of the help's pages, each with a line on it. The overview is the topic without a name."""
TOPICS = {topic: line for topics in GROUPS.values() for topic, line in topics.items() if topic}
EXAMPLES = {name: example(name) for name in ("helpers", "priority", "total", "protocol")}
"""A workbook for each word that needs one; a test holds that they are in order."""
SMALL_WORDS = frozenset((
    "how", "can", "does", "did", "the", "and", "what", "why", "when", "where", "which", "who", "that", "this", "with",
    "for", "from", "into", "make", "robot", "want", "should", "are", "has", "have", "not", "its", "there", "get", "let",
))  # fmt: skip
"""Words of questions that tell nothing of what is asked for."""


def text_on(name: str, others: Sequence[str] = (), language: str = "en") -> Iterator[Block]:
    """Return the blocks on a topic or a name; raises SheetsError for an unknown one, which proposes `others` too."""
    topic = topic_of(name)
    if topic is not None:
        return page_of(topic, language)
    found = list(_named(name, language))
    if found:
        return iter(block for blocks in found for block in blocks)
    raise _unknown(name, others)


def topic_of(name: str) -> str | None:
    """Return the topic that a word means; None if it means none.

    >>> topic_of("Sensors"), topic_of("records"), topic_of("overview"), topic_of("Red ball")
    ('devices', 'recordings', '', None)
    """
    topic = _SYNONYMS.get(key(name), key(name))
    return topic if topic in TOPICS or not topic else None


def page_of(topic: str, language: str) -> Iterator[Block]:
    """Yield the blocks of a topic, with an example where one helps."""
    from rrp_sheets.help.codes import all_codes
    from rrp_sheets.help.connectors import all_connectors
    from rrp_sheets.help.devices import all_devices
    from rrp_sheets.help.functions import all_functions
    from rrp_sheets.help.scene_page import scene

    made = {"connectors": all_connectors, "functions": all_functions, "devices": all_devices, "codes": all_codes}
    if topic in made:
        yield from made[topic]()
    elif topic == "scene":
        yield from scene(language)
    else:
        kinds = {kind.name: _columns(kind, language) for kind in SHEETS.values()} if topic == "sheets" else {}
        yield from from_file(topic or "overview", language, **kinds)
    if topic in EXAMPLES:
        yield titled(FOR_EXAMPLE, workbook(topic, EXAMPLES[topic], language))


def _columns(kind: SheetKind, language: str) -> str:
    """Return the columns of a kind of sheet; notes, which all sheets may have, are named beside other optional ones."""
    required, optional = (
        translate(listed([c.header(language) for c in columns]), language) for columns in (kind.required, kind.optional)
    )
    return f"{required}; {optional}" if len(kind.optional) > 1 else required


def _named(name: str, language: str) -> Iterator[Iterator[Block]]:
    """Yield the help pages under a name: it may be a function and a device, say."""
    from rrp_sheets.graph.device_table import done_of
    from rrp_sheets.help.codes import one_code
    from rrp_sheets.help.connectors import one_connector
    from rrp_sheets.help.devices import done_stream, one_device
    from rrp_sheets.help.functions import one_function

    if (code := CODES.get(name.upper())) is not None:
        yield one_code(code, language)
    if (connector := connectors().get(name)) is not None:
        yield one_connector(connector, language)
    if (function := library().get(name.removesuffix("()"))) is not None:
        yield one_function(function)
    if (device := load_robot().find(name)) is not None:
        yield one_device(device, language)
    elif (found := load_robot().find(done_of(name))) is not None and found.type.kind == "actuator":
        yield done_stream(found, language)


def _unknown(name: str, others: Sequence[str]) -> SheetsError:
    found = list(load_robot().names.values())
    devices = [*(f.name for f in found), *(f"{f.name} done" for f in found if f.type.kind == "actuator")]
    guess = nearest(name, [*TOPICS, *connectors().names(), *library().names(), *devices, *CODES, *others])
    topics = listed(list(TOPICS))
    remedy = N_("Did you mean {guess}?", guess=guess) if guess else N_("Try: {topics}.", topics=topics)
    return SheetsError(N_("There is no help on “{name}”.", name=name), remedy)


@dataclass(frozen=True, slots=True)
class HelpEntry:
    """Something there is help on; `what` is topic, connector, function, sensor, actuator, error, warning or info."""

    name: str
    what: str
    line: str


@lru_cache(maxsize=1)
def all_names() -> tuple[HelpEntry, ...]:
    """Every name, topics first."""
    return (
        *(HelpEntry(topic, "topic", line) for topic, line in TOPICS.items()),
        *(HelpEntry(c.name, "connector", c.help_message()) for c in dict.fromkeys(connectors())),
        *(HelpEntry(f.name, "function", first_line(f)) for f in dict.fromkeys(library())),
        *(HelpEntry(f.name, f.type.kind, N_(f.type.help, msgctxt=f"{f.type.name}.help")) for f in _devices()),
        *(HelpEntry(c.id, c.severity.value, c.text("title", {})) for c in CODES.values()),
    )


def _devices() -> list[FoundDevice]:
    return [found for found in load_robot().names.values() if found.offered]


def known(term: str) -> str:
    """The name that a term of a help text stands for, or an empty text.

    >>> known("CLAMP(value; low; high)"), known("Red ball"), known("whatever")
    ('CLAMP', 'Red ball', '')
    """
    return _by_key().get(key(term.partition("(")[0]), "")


@lru_cache(maxsize=1)
def _by_key() -> dict[str, str]:
    return {key(n.name): n.name for n in reversed(all_names())}


def search(text: str, language: str = "en", most: int = 20) -> list[HelpEntry]:
    """Return the entries under some words: names that begin with them, then names and lines that hold them.

    >>> search("clam")[0].name, search("赤い", "ja")[0].name
    ('CLAMP', 'Red ball')
    """
    wanted, words = key(text), text.casefold().split()
    if not wanted:
        return []

    def rank(name: HelpEntry) -> int:
        k = key(name.name)
        whole = f"{name.name} {name.what} {name.line} {translate(name.line, language)}".casefold()
        if wanted in k:
            return 0 if k == wanted else 1 if k.startswith(wanted) else 2
        return 3 if all(word in whole for word in words) else 4

    found: dict[str, HelpEntry] = {}
    for name in sorted((n for n in all_names() if rank(n) < 4), key=rank):
        found.setdefault(name.name if rank(name) < 3 else name.line, name)  # the joints of a robot have one line
    return list(found.values())[:most]


_TELLING = re.compile("[一-龯々]+|[ァ-ヴー]+|[^\\W一-龯々ァ-ヴーぁ-ん]{3,}")  # Japanese has no blanks between words


def near(text: str, language: str = "en", most: int = 8) -> list[HelpEntry]:
    """Return the entries under some words of a question, when there is none under all of them.

    >>> near("How do I make the robot sleep or speak a text?")[0].name in {n.name for n in all_names()}
    True
    >>> near("how do I xyzzy"), near("ロボットの手をどうやって上げますか", "ja") != []
    ([], True)
    """
    words = [w for w in _TELLING.findall(text.casefold()) if w not in SMALL_WORDS]
    roots = list(dict.fromkeys(w.removesuffix("ing").removesuffix("s") for w in words))

    def hits(text: str) -> int:
        inside = re.findall(r"\w+", text.casefold())
        return sum(
            any(word.startswith(root) or (not root.isascii() and root in word) for word in inside) for root in roots
        )

    entries = (n for n in all_names() if n.what not in ("error", "warning", "info"))
    found = [(-hits(f"{n.name} {n.line} {translate(n.line, language)}") - hits(n.name), n) for n in entries]
    found = sorted((f for f in found if f[0]), key=lambda f: (f[0], f[1].what != "topic"))
    return [n for _, n in found[:most]]
