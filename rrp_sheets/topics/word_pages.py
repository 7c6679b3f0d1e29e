"""`help helpers`, `help Priority`, …: words of the sheets that are no connector, function or device."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rrp_sheets.topics.layout import from_markdown, titled
from rrp_sheets.topics.workbooks import grids

WORDS = (
    "helpers", "priority", "total", "protocol", "engine", "keys", "glossary",
    "sheets", "robot", "serve", "records", "ethics", "compare", "bundles", "systems",
)  # fmt: skip
EXAMPLES = {
    "helpers": """
## Helpers
| Name | Inputs | Formula |
|---|---|---|
| limit | | 0.8 |
| near | distance | distance < limit |

## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | filter | near(redBall.distance) | Close ball |
| Close ball | subscribe | | Head tracker |
""",
    "priority": """
## Talk
| Input streams | Connector | Formula | Output stream | Priority |
|---|---|---|---|---|
| Start | subscribe | "Hello, I am a robot." | Say | |
| Touch | subscribe | "That is my head." | Say | 5 |

## Devices
| Stream | Device | Label |
|---|---|---|
| Start | Operator button | Start |
""",
    "total": """
## Counting
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Touch | accumulate | total + 1 | Touches |
| Touches | subscribe | | Say |
""",
    "protocol": """
## Protocol
| Field | Value |
|---|---|
| Title | Follow the ball |
| Purpose | Does a child look where the robot looks? |
| Engine | frame |
| Seed | 7 |
| Time limit | 5 min |

## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | subscribe | | Head tracker |
""",
}
"""A workbook for each word that needs one; a test holds that they are in order."""


def word(name: str) -> Iterator[str]:
    """Yield the meaning of a word of the sheets, with an example where one helps."""
    path = Path(__file__).parent / f"{name}.md"
    yield from from_markdown(path.read_text(encoding="utf-8"))
    if name in EXAMPLES:
        yield titled("For example", *grids(EXAMPLES[name]), between="\n\n")
