"""The help page of a code: `pages/<CODE>.md`, in one fixed form that tests hold and execute.

Below its head, which is the entry of the catalogue, a page has the sections “What it means”, “Why it matters” and
“How to mend it”, and then either the examples “Wrong” and “Right”, each made of sheets (`### Name` and a table), or
“Not in a table”, where the fault is one of the file and not of what stands in its cells.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from rrp_sheets.diagnostics.catalogue import PAGES

_TEXTS = ("What it means", "Why it matters", "How to mend it")
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
    """A page; its texts are plain prose.

    Attributes:
        means: what the code says.
        why: why it matters.
        mend: what to do about it.
        wrong: sheets with the fault, as a Markdown workbook; empty when no table can show it.
        right: the same sheets, mended.
        untabled: where the fault comes from when no table can show it.
    """

    code: str
    means: str
    why: str
    mend: str
    wrong: str = ""
    right: str = ""
    untabled: str = ""


def load_page(code: str) -> CodePage:
    """Return the page of a code of the catalogue."""
    return parse_page((PAGES / f"{code}.md").read_text(encoding="utf-8"))


def parse_page(text: str) -> CodePage:
    """Parse the text of a page.

    Raises:
        ValueError: when it does not have the fixed form.
    """
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
