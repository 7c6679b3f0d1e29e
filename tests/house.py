"""Measures of how the code reads: `make house` prints them beside what is wanted; test_house.py holds their ceilings."""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "rrp_sheets"
SHORT = 40  # lines under which a module that only one other imports belongs into it
ONE_OF_A_KIND = ("connectors", "checks", "help")  # packages whose modules are one connector, check or help topic each
COMMON_NAMES = frozenset(("__init__", "__main__", "base", "model"))  # that modules of many packages may have
QUESTION = re.compile(r"(What|Whether|How|Who|Whose|Where|When|Which|Whatever)\b")
UNREADABLE_REFERENCE = re.compile(r"\bdesign: ?\w")
FILLERS = frozenset(("the", "a", "an", "of", "is", "return", "returns", "get", "gets"))


@dataclass(frozen=True)
class Measure:
    """One measure of the code.

    Attributes:
        name: what is counted.
        wanted: the most that is wanted.
        today: how much there is.
        places: where, if it can be pointed at.
    """

    name: str
    wanted: int
    today: int
    places: Sequence[str] = ()


class CodeBase:
    """The parsed modules of the package, and which of them import which."""

    def __init__(self) -> None:
        files = sorted((ROOT / PACKAGE).rglob("*.py"))
        self.files = {
            ".".join(f.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): f
            for f in files
            if "_vendor" not in f.parts
        }
        self.texts = {module: f.read_text(encoding="utf-8") for module, f in self.files.items()}
        self.trees = {module: ast.parse(text) for module, text in self.texts.items()}

    @cached_property
    def imports(self) -> grimp.ImportGraph:
        """The imports between modules, those for types alone included."""
        return grimp.build_graph(PACKAGE, cache_dir=None)

    def lines(self, module: str) -> int:
        """Count the lines of a module."""
        return self.texts[module].count("\n")

    def small(self) -> list[str]:
        """Return the short modules that only one other imports."""
        return [
            module
            for module, file in self.files.items()
            if self.lines(module) < SHORT
            and file.stem != "__init__"
            and not set(ONE_OF_A_KIND) & set(file.parts)
            and len(self.imports.find_modules_that_directly_import(module)) == 1
        ]

    def circles(self) -> list[str]:
        """Return circles of imports, those for types alone left out; each is broken before the next is looked for."""
        graph = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
        needs = {module: set(graph.find_modules_directly_imported_by(module)) for module in sorted(graph.modules)}
        found = []
        while True:
            try:
                TopologicalSorter(needs).prepare()
            except CycleError as error:
                circle = error.args[1]
                found.append(" → ".join(circle))
                needs[circle[1]].discard(circle[0])
            else:
                return found

    def shared_class_names(self) -> list[str]:
        """Return the public names of classes that several modules define."""
        names = Counter(n.name for tree in self.trees.values() for n in tree.body if isinstance(n, ast.ClassDef))
        return sorted(name for name, count in names.items() if count > 1 and name[0] != "_")

    def shared_module_names(self) -> list[str]:
        """Return the names of modules that stand in more than two packages."""
        names = Counter(file.stem for file in self.files.values())
        return sorted(name for name, count in names.items() if count > 2 and name not in COMMON_NAMES)

    @cached_property
    def docstrings(self) -> list[tuple[str, str, str]]:
        """The place of each docstring, the name that it describes, and its text."""
        return [entry for module, tree in self.trees.items() for entry in _docstrings(module, tree)]

    def questions(self) -> list[str]:
        """Return the places of docstrings that begin as a question."""
        return [place for place, _, text in self.docstrings if QUESTION.match(text)]

    def restatements(self) -> list[str]:
        """Return the places of docstrings whose first sentence says no more than the name."""
        return [place for place, name, text in self.docstrings if _restates(name, text)]

    def unreadable_references(self) -> list[str]:
        """Return the places that name a page which readers of the repository do not have."""
        return [
            f"{self.files[module].relative_to(ROOT)}:{text.count(chr(10), 0, found.start()) + 1}"
            for module, text in self.texts.items()
            for found in UNREADABLE_REFERENCE.finditer(text)
        ]


def _docstrings(module: str, tree: ast.Module) -> Iterator[tuple[str, str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            text = ast.get_docstring(node)
            if text:
                name = "" if isinstance(node, ast.Module) else node.name
                yield f"{module}:{name}", name or module.rpartition(".")[2], text


def _restates(name: str, text: str) -> bool:
    said = _words(re.split(r"\n\n|\. ", text, maxsplit=1)[0])
    return bool(said) and said <= _words(re.sub(r"([A-Z])", r" \1", name).replace("_", " "))


def _words(text: str) -> set[str]:
    """Return the words of a text, without plural and fillers."""
    return {word.rstrip("s") for word in re.findall(r"[a-z]+", text.lower()) if word not in FILLERS}


def measures() -> list[Measure]:
    """Take all measures."""
    code = CodeBase()
    questions = code.questions()
    counted = {
        f"modules under {SHORT} lines that only one other imports": code.small(),
        "class names that two modules define": code.shared_class_names(),
        "module names in more than two packages": code.shared_module_names(),
        "import circles": code.circles(),
        "docstrings that restate the name": code.restatements(),
        "references that no reader can open": code.unreadable_references(),
    }
    return [
        Measure("lines of Python", 56_000, sum(map(code.lines, code.files))),
        Measure("modules", 300, len(code.files)),
        Measure("docstrings that begin as a question", len(code.docstrings) // 50, len(questions), questions),
        Measure("lines of README", 130, (ROOT / "README.md").read_text(encoding="utf-8").count("\n")),
        *(Measure(name, 0, len(places), places) for name, places in counted.items()),
    ]


def main() -> None:
    """Print each measure beside what is wanted; with -v all places."""
    for measure in measures():
        mark = "ok" if measure.today <= measure.wanted else "--"
        print(f"{mark} {measure.name:<50}{measure.today:>8,} wanted {measure.wanted:>7,}")
        if measure.today > measure.wanted and "-v" in sys.argv:
            print(*(f"     {place}" for place in measure.places), sep="\n")


if __name__ == "__main__":
    main()
