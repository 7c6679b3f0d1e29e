"""Finds and lists help: on a topic, a word of the sheets, or the name of a connector, function, device or finding."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.functions import library
from rrp_sheets.help.functions import first_line
from rrp_sheets.help.layout import example, from_markdown, grids, titled
from rrp_sheets.model.names import key, nearest
from rrp_sheets.robots import load_robot
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook.schema import SHEETS, SheetKind

_WORDS = ("words", "stream", "streams", "event", "events", "field", "fields", "frame", "seed", "rad", "trace", "units")
_SYNONYMS = {
    "connector": "connectors", "operators": "connectors", "operator": "connectors",
    "formula": "formulas", "language": "formulas", "function": "functions", "helper": "helpers",
    "priorities": "priority", "framerate": "protocol", "engines": "engine",
    "device": "devices", "sensors": "devices", "sensor": "devices", "actuators": "devices", "actuator": "devices",
    "test": "tests", "testing": "tests", "scenes": "scene", "errors": "codes", "error": "codes",
    "warnings": "codes", "messages": "codes", "code": "codes", "overview": "", "help": "",
    "workbook": "sheets", "workbooks": "sheets", "sheet": "sheets", "record": "records", "recordings": "records",
    "server": "serve", "browser": "serve", "grid": "serve", "paper": "ethics", "comparing": "compare", "git": "compare",
    "bundle": "bundles", "installation": "systems", "windows": "systems", "macos": "systems",
    **dict.fromkeys(_WORDS, "glossary"),
}  # fmt: skip
TOPICS = {
    "connectors": "what a row can do with its input streams",
    "formulas": "how formulas are written",
    "functions": "the functions of formulas",
    "devices": "what the robot senses and does",
    "scene": "what happens in the simulated room",
    "tests": "test sheets: what is sent, and what must come out",
    "codes": "what a check can find",
    "helpers": "formulas with a name of their own",
    "priority": "which command wins when two want the same joints",
    "total": "the value of accumulate so far",
    "protocol": "the Protocol sheet: title, engine, seed, time limit",
    "risks": "the Risks sheet: what could go wrong for people",
    "engine": "how rows follow each other in time",
    "keys": "the keys of the grid",
    "sheets": "the sheets of a workbook, and the files it may be in",
    "robot": "what the simulated robot senses, does, and cannot do",
    "serve": "the grid in the browser: who may use it, editing together, operating a run",
    "records": "what a run leaves: look back, export, delete, replay",
    "ethics": "the protocol on paper, for the ethics board",
    "compare": "check, explain and compare workbooks; git",
    "bundles": "a workbook with all that belongs to it, in one file",
    "systems": "where the program runs, and what is measured",
    "glossary": "what the words mean: stream, event, connector, subscribe, field, frame, seed, rad",
}
"""Every topic with a line on it; those after `codes` have a page of their own (`helpers.md`, …)."""
EXAMPLES = {name: example(name) for name in ("helpers", "priority", "total", "protocol")}
"""A workbook for each word that needs one; a test holds that they are in order."""
_SMALL = frozenset((
    "how", "can", "does", "did", "the", "and", "what", "why", "when", "where", "which", "who", "that", "this", "with",
    "for", "from", "into", "make", "robot", "want", "should", "are", "has", "have", "not", "its", "there", "get", "let",
))  # fmt: skip
"""Words of questions that tell nothing of what is asked for."""


def text_on(name: str, others: Sequence[str] = ()) -> Iterator[str]:
    """The blocks of text on a topic or a name; raises SheetsError for an unknown one, which proposes `others` too."""
    topic = _SYNONYMS.get(key(name), key(name))
    if (made := _topics().get(topic)) is not None:
        return made()
    if topic in TOPICS:
        return word(topic)
    found = list(_named(name))
    if found:
        return iter(block for blocks in found for block in blocks)
    raise _unknown(name, others)


def _topics() -> dict[str, Callable[[], Iterator[str]]]:
    from rrp_sheets.help.codes import all_codes
    from rrp_sheets.help.connectors import all_connectors
    from rrp_sheets.help.devices import all_devices
    from rrp_sheets.help.functions import all_functions
    from rrp_sheets.help.scene_page import scene

    return {
        "": lambda: _file("overview"), "connectors": all_connectors, "formulas": lambda: _file("formulas"),
        "functions": all_functions, "devices": all_devices, "scene": scene, "tests": lambda: _file("tests"),
        "codes": all_codes,
    }  # fmt: skip


def _file(name: str) -> Iterator[str]:
    text = (Path(__file__).parent / f"{name}.md").read_text(encoding="utf-8")
    for kind in SHEETS.values() if name == "sheets" else ():
        text = text.replace(f"{{{kind.name}}}", _columns(kind))
    return from_markdown(text)


def _columns(kind: SheetKind) -> str:
    """Return the columns of a kind of sheet; notes, which all sheets may have, are named beside other optional ones."""
    required, optional = (", ".join(c.name for c in columns) for columns in (kind.required, kind.optional))
    return f"{required}; {optional}" if len(kind.optional) > 1 else required


def _named(name: str) -> Iterator[Iterator[str]]:
    """Yield the help pages under a name: it may be a function and a device, say."""
    from rrp_sheets.graph.device_table import done_of
    from rrp_sheets.help.codes import one_code
    from rrp_sheets.help.connectors import one_connector
    from rrp_sheets.help.devices import done_stream, one_device
    from rrp_sheets.help.functions import one_function

    if (code := CODES.get(name.upper())) is not None:
        yield one_code(code)
    if (connector := connectors().get(name)) is not None:
        yield one_connector(connector)
    if (function := library().get(name.removesuffix("()"))) is not None:
        yield one_function(function)
    if (device := load_robot().find(name)) is not None:
        yield one_device(device)
    elif (found := load_robot().find(done_of(name))) is not None and found.type.kind == "actuator":
        yield done_stream(found)


def _unknown(name: str, others: Sequence[str]) -> SheetsError:
    found = list(load_robot().names.values())
    devices = [*(f.name for f in found), *(f"{f.name} done" for f in found if f.type.kind == "actuator")]
    guess = nearest(name, [*TOPICS, *connectors().names(), *library().names(), *devices, *CODES, *others])
    topics = listed(list(filter(None, _topics())))
    remedy = N_("Did you mean {guess}?", guess=guess) if guess else N_("Try: {topics}.", topics=topics)
    return SheetsError(N_("There is no help on “{name}”.", name=name), remedy)


def word(name: str) -> Iterator[str]:
    """Yield the meaning of a word of the sheets, with an example where one helps."""
    yield from _file(name)
    if name in EXAMPLES:
        yield titled("For example", *grids(EXAMPLES[name]), between="\n\n")


@dataclass(frozen=True, slots=True)
class HelpEntry:
    """Something there is help on; `what` is topic, connector, function, sensor, actuator, error or warning."""

    name: str
    what: str
    line: str


@lru_cache(maxsize=1)
def all_names() -> tuple[HelpEntry, ...]:
    """Every name, topics first."""
    return (
        *(HelpEntry(topic, "topic", line) for topic, line in TOPICS.items()),
        *(HelpEntry(c.name, "connector", c.help) for c in dict.fromkeys(connectors())),
        *(HelpEntry(f.name, "function", first_line(f)) for f in dict.fromkeys(library())),
        *(HelpEntry(f.name, f.type.kind, f.type.help) for f in load_robot().names.values() if f.offered),
        *(HelpEntry(c.id, c.severity.value, c.title) for c in CODES.values()),
    )


def known(term: str) -> str:
    """The name that a term of a help text stands for, or an empty text.

    >>> known("CLAMP(value; low; high)"), known("Red ball"), known("whatever")
    ('CLAMP', 'Red ball', '')
    """
    return _by_key().get(key(term.partition("(")[0]), "")


@lru_cache(maxsize=1)
def _by_key() -> dict[str, str]:
    return {key(n.name): n.name for n in reversed(all_names())}


def search(text: str, most: int = 20) -> list[HelpEntry]:
    """Return the entries under some words: names that begin with them, then names and lines that hold them.

    >>> search("clam")[0].name
    'CLAMP'
    """
    wanted, words = key(text), text.casefold().split()
    if not wanted:
        return []

    def rank(name: HelpEntry) -> int:
        k = key(name.name)
        whole = f"{name.name} {name.what} {name.line}".casefold()
        if wanted in k:
            return 0 if k == wanted else 1 if k.startswith(wanted) else 2
        return 3 if all(word in whole for word in words) else 4

    found = sorted(all_names(), key=rank)
    return [n for n in found if rank(n) < 4][:most]


def near(text: str, most: int = 8) -> list[HelpEntry]:
    """Return the entries under some words of a question, when there is none under all of them.

    >>> near("How do I make the robot sleep or speak a text?")[0].name in {n.name for n in all_names()}
    True
    >>> near("how do I xyzzy")
    []
    """
    words = [w for w in re.findall(r"\w{3,}", text.casefold()) if w not in _SMALL]
    roots = list(dict.fromkeys(w.removesuffix("ing").removesuffix("s") for w in words))

    def hits(text: str) -> int:
        inside = re.findall(r"\w+", text.casefold())
        return sum(any(word.startswith(root) for word in inside) for root in roots)

    entries = (n for n in all_names() if n.what not in ("error", "warning", "info"))
    found = [(-hits(f"{n.name} {n.line}") - hits(n.name), n) for n in entries]
    found = sorted((f for f in found if f[0]), key=lambda f: (f[0], f[1].what != "topic"))
    return [n for _, n in found[:most]]
