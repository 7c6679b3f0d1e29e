"""Everything there is help on, by name, with a line on each: for searching."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from rrp_sheets.connectors import connectors
from rrp_sheets.devices import load_robot
from rrp_sheets.diagnostics import CODES
from rrp_sheets.formulas.functions import library
from rrp_sheets.model.names import key
from rrp_sheets.topics.functions import first_line

_TOPICS = {
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
_SMALL = frozenset((
    "how", "can", "does", "did", "the", "and", "what", "why", "when", "where", "which", "who", "that", "this", "with",
    "for", "from", "into", "make", "robot", "want", "should", "are", "has", "have", "not", "its", "there", "get", "let",
))  # fmt: skip
"""Words of questions that tell nothing of what is asked for."""


@dataclass(frozen=True, slots=True)
class HelpEntry:
    """Something there is help on; `what` is topic, connector, function, sensor, actuator, error or warning."""

    name: str
    what: str
    line: str


@lru_cache(maxsize=1)
def all_names() -> tuple[HelpEntry, ...]:
    """Every name, topics first."""
    return tuple(_all())


def _all() -> Iterator[HelpEntry]:
    yield from (HelpEntry(topic, "topic", line) for topic, line in _TOPICS.items())
    yield from (HelpEntry(c.name, "connector", c.help) for c in dict.fromkeys(connectors()))
    yield from (HelpEntry(f.name, "function", first_line(f)) for f in dict.fromkeys(library()))
    yield from (HelpEntry(f.name, f.type.kind, f.type.help) for f in load_robot().names.values() if f.offered)
    yield from (HelpEntry(c.id, c.severity.value, c.title) for c in CODES.values())


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
        return 0 if k == wanted else 1 if k.startswith(wanted) else 2 if wanted in k else 3 if _in(words, whole) else 4

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

    def hits(name: HelpEntry) -> tuple[int, int]:
        inside = re.findall(r"\w+", f"{name.name} {name.line}".casefold())
        named = re.findall(r"\w+", name.name.casefold())
        return sum(_begins(r, inside) for r in roots), sum(_begins(r, named) for r in roots)

    found = [(hits(n), n) for n in all_names() if n.what not in ("error", "warning", "info")]
    found = sorted((f for f in found if f[0][0]), key=lambda f: (-f[0][0] - f[0][1], f[1].what != "topic"))
    return [n for _, n in found[:most]]


def _begins(root: str, words: list[str]) -> bool:
    return any(word.startswith(root) for word in words)


def _in(words: list[str], whole: str) -> bool:
    return all(word in whole for word in words)
