"""The catalogue of diagnostic codes, and their help pages: both stand in `pages/<CODE>.md`, tests check their form.

At its head a page has severity, title, message and remedy. Below are the sections “What it means”, “Why it matters”
and “How to fix it”, and then either the examples “Wrong” and “Right”, each made of sheets (`### Name` and a table),
or “Not in a table”, where the fault is one of the file and not of what stands in its cells.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from string import Formatter

from rrp_sheets.texts import N_, LazyMessage

PAGES = Path(__file__).parent / "pages"
TOPICS = {
    "FILE": N_("The file"), "SHEET": N_("What stands in the sheets"), "CONN": N_("Connectors"),
    "GRAPH": N_("Streams, and how rows are connected"), "FORM": N_("Formulas and helpers"), "DEV": N_("Devices"),
    "SCENE": N_("The scene"), "GEST": N_("Gestures"), "TEST": N_("Tests"), "LINT": N_("What is probably not meant"),
    "PROT": N_("The Protocol sheet"),
}  # fmt: skip
"""Subjects of the codes by their beginnings, in the catalogue's order. FORM101 and later are found by evaluating."""


class Severity(Enum):
    """Severity of a finding: an error keeps the workbook from running, a warning or information does not."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


@dataclass(frozen=True, slots=True)
class Code:
    """Entry of the catalogue: `message` and `remedy` are templates for `str.format`; the remedy says what to do."""

    id: str
    severity: Severity
    title: str
    message: str
    remedy: str

    @property
    def parameters(self) -> frozenset[str]:
        """The names of the details that fill the templates."""
        return _places(self.message) | _places(self.remedy)

    def text(self, part: str, details: Mapping[str, object]) -> LazyMessage:
        """Return its `title`, `message` or `remedy` with details."""
        return LazyMessage(getattr(self, part), msgctxt=f"{self.id}.{part}", **details)

    @property
    def constant_remedy(self) -> str:
        """The remedy if it is the same for all details; else an empty text."""
        return "" if _places(self.remedy) else self.text("remedy", {})


@cache
def _places(template: str) -> frozenset[str]:
    return frozenset(name for _, name, _, _ in Formatter().parse(template) if name)


def _code(page: Path) -> Code:
    head = page.read_text(encoding="utf-8").partition("\n## ")[0]
    name, severity, message, remedy = head.strip().split("\n\n")
    code, _, title = name.removeprefix("# ").partition(": ")
    return Code(code, Severity(severity), title, message, remedy.removeprefix("→ "))


def _place(page: Path) -> tuple[int, str]:
    return [*TOPICS].index(page.stem.rstrip("0123456789")), page.stem


CODES: dict[str, Code] = {page.stem: _code(page) for page in sorted(PAGES.glob("*.md"), key=_place)}

_TEXTS = ("What it means", "Why it matters", "How to fix it")
_FORMS = ([*_TEXTS, "Wrong", "Right"], [*_TEXTS, "Not in a table"])
_BYSTANDER = """
## Looking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | sample | 1 s | Now |
| Now | subscribe | | Print |
"""


@dataclass(frozen=True, slots=True)
class CodePage:
    """A page; its texts are plain prose."""

    code: str
    means: str  # what the code says
    why: str  # why it matters
    mend: str  # what to do about it
    wrong: str = ""  # sheets with the fault, as a Markdown workbook; empty when no table can show it
    right: str = ""  # the same sheets, mended
    untabled: str = ""  # where the fault comes from when no table can show it

    def text(self, part: str) -> LazyMessage:
        """Return its `means`, `why`, `mend` or `untabled` as a message for the catalogues."""
        return LazyMessage(getattr(self, part), msgctxt=f"{self.code}.{part}")


def load_page(code: str) -> CodePage:
    """Return the page of a code of the catalogue."""
    return parse_page((PAGES / f"{code}.md").read_text(encoding="utf-8"))


def parse_page(text: str) -> CodePage:
    """Parse the text of a page; raises ValueError when it does not have the fixed form."""
    head, *parts = re.split(r"^## (.+)\n", text, flags=re.MULTILINE)
    titles, bodies = parts[::2], [body.strip() for body in parts[1::2]]
    code = head.partition(":")[0].removeprefix("# ")
    if titles not in _FORMS:
        raise ValueError(f"The page {code} has the sections {titles}.")
    means, why, mend = (" ".join(body.split()) for body in bodies[:3])
    if "Wrong" not in titles:
        return CodePage(code, means, why, mend, untabled=" ".join(bodies[3].split()))
    wrong, right = (re.sub(r"^### ", "## ", body, flags=re.MULTILINE) + "\n" for body in bodies[3:])
    return CodePage(code, means, why, mend, wrong, right)


def completed(example: str) -> str:
    r"""Return an example as a whole workbook, with a behaviour added if it has none.

    >>> completed("## Devices\n| Stream | Device |\n|---|---|\n").count("## ")
    2
    """
    return example if re.search(r"^\|.*\| *(Connector|Conector) *\|", example, re.MULTILINE) else example + _BYSTANDER
