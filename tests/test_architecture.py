"""The files that .github/ARCHITECTURE.md names exist, define the names, and are reached from one another."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / ".github" / "ARCHITECTURE.md"
ENTRY = re.compile(r"\d+\. (?P<begins>\*[^*]+\* )?`(?P<path>[^`]+)` (?P<names>.*?): ")
MOST = {"Key press": 16, "Formula": 38, "Ball": 16, "Value": 14, "Stop": 15, "Rows at Stop": 7}
"""The files of each journey; who makes one shorter lowers it here."""


@dataclass(frozen=True)
class JourneyFile:
    """A file of a journey.

    Attributes:
        path: of the file, from the root.
        names: what is entered there, `Class.method` or `function`.
        begins: whether a process or another kind of code begins here, which nothing before it imports.
    """

    path: str
    names: tuple[str, ...]
    begins: bool


def journeys() -> dict[str, list[JourneyFile]]:
    """Read the journeys of the page, by their names."""
    text = PAGE.read_text(encoding="utf-8").partition("## Five journeys")[2].partition("\n## ")[0]
    found: dict[str, list[JourneyFile]] = {}
    for part in text.split("\n### ")[1:]:
        title = part.partition(":")[0]
        found[title] = [
            JourneyFile(match["path"], tuple(_names(match["names"])), match["begins"] is not None)
            for line in part.splitlines()
            if (match := ENTRY.match(line))
        ]
    return found


def _names(text: str) -> Iterator[str]:
    """Give the names of an entry; `.method` belongs to the class before it."""
    owner = ""
    for name in re.findall(r"`([^`]+)`", text):
        if name.startswith("."):
            yield owner + name
        else:
            owner = name.partition(".")[0]
            yield name


def defined(tree: ast.Module) -> set[str]:
    """Collect what a module defines: functions at any depth, classes, and what they have as `Class.name`."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{part.name}" for part in node.body if isinstance(part, ast.FunctionDef)}
    return names


def module(path: str) -> str:
    """Return the dotted name of a Python file."""
    return ".".join(Path(path).with_suffix("").parts).removesuffix(".__init__")


JOURNEYS = journeys()
ENTRIES = sorted({(entry.path, entry.names) for entries in JOURNEYS.values() for entry in entries})


@pytest.fixture(scope="module")
def imports() -> grimp.ImportGraph:
    return grimp.build_graph("rrp_sheets", cache_dir=None)


@pytest.mark.parametrize("journey", MOST)
def test_journey_is_no_longer_than_it_was(journey: str) -> None:
    assert len(JOURNEYS[journey]) <= MOST[journey]
    paths = [entry.path for entry in JOURNEYS[journey]]
    assert len(paths) == len(set(paths)), "each file once"


def test_files_have_the_names() -> None:
    for path, names in ENTRIES:
        text = (ROOT / path).read_text(encoding="utf-8")
        if path.endswith(".py"):
            assert set(names) <= defined(ast.parse(text)), path
        for name in names:
            assert re.search(rf"\b{name.rpartition('.')[2]}\b", text), (path, name)


NAMED = re.compile(r"`([\w.-]+/[\w./-]*)`")
NOT_THERE = {"node_modules/", "rrp_sheets/connectors/yours.py"}  # made by npm; an example


@pytest.mark.parametrize("name", ["ARCHITECTURE.md", "CONTRIBUTING.md"])
def test_paths_that_a_document_names_exist(name: str) -> None:
    text = (ROOT / ".github" / name).read_text(encoding="utf-8")
    paths = [p for p in NAMED.findall(text) if p not in NOT_THERE]
    assert len(paths) > 40
    assert [p for p in paths if not (ROOT / p).exists() and not (ROOT / "rrp_sheets" / p).exists()] == []


@pytest.mark.parametrize("journey", MOST)
def test_file_is_near_another_of_its_journey(imports: grimp.ImportGraph, journey: str) -> None:
    """One imports the other, directly or through one module; a process and a route are reached by a message instead."""
    files = {module(entry.path): entry for entry in JOURNEYS[journey] if entry.path.endswith(".py")}
    for name, entry in files.items():
        text = (ROOT / entry.path).read_text(encoding="utf-8")
        by_message = entry.begins or '__name__ == "__main__"' in text or "Blueprint(" in text
        others = [other for other in files if other != name]  # what is called gives back: the way may lead up too
        chains = [imports.find_shortest_chain(*pair) for o in others for pair in ((o, name), (name, o))]
        assert by_message or any(chain and len(chain) <= 3 for chain in chains), entry.path


def test_named_files_exist() -> None:
    named = set(re.findall(r"`((?:rrp_sheets|templates)/[\w/.]+)`", PAGE.read_text("utf-8")))
    assert named and [path for path in sorted(named) if not (ROOT / path).exists()] == []
