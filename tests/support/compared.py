"""A workbook in its parts, edited and compared, for the tests of diff."""

from __future__ import annotations

from rrp_sheets import api
from rrp_sheets.compare import Comparison
from rrp_sheets.compare.as_text import say

BASE = """
## Tracking
| On | Priority | Input streams | Connector | Formula | Output stream | Notes |
|---|---|---|---|---|---|---|
| | | Red ball | map | redBall.distance | Distance | how far |
| | | Distance | sample | 1000 | Steady | |
| | | Steady | filter | steady < 20 | Close ball | |
| | 2 | Close ball | subscribe | near(closeBall) | Eyes | |
| | | Blue ball, Distance | combineLatest | blueBall.distance - distance | Both | |
| | | Both | filter | IF(both > 0.5, True, False) | | |
| | | | map | INDEX(Words, 1).Word | Word | |
| | | Word | subscribe | | Hello | |
| no | | Distance | map | distance * 2 | Twice | |
| | | Twice, Distance | merge | | Any | |
| | | Any | subscribe | | Print | |

## Looking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Blue ball | filter | blueBall.distance < 1 | Near blue |
| Near blue | subscribe | | Tracker |

## Devices
| Stream | Device | Text | Colour | Notes |
|---|---|---|---|---|
| Hello | Say parameter | Hello | | greets |
| Eyes | Eye brightness | | | |
| Spare | Say parameter | unused | | |

## Helpers
| Name | Inputs | Formula | Notes |
|---|---|---|---|
| near | x | x < limit | |
| limit | | 0.5 | |
| unused | | 3 | |

## Words
| Word | Points |
|---|---|
| apple | 1 |
| pear | 2 |

## Scene
| Time (s) | Thing | Does | Value | Notes |
|---|---|---|---|---|
| 1 | Red ball | appears | at 1, 0.2, 0.4 | |
| 2 | Red ball | moves | to 0.5, 0, 0.4 in 2 s | |
| 5 | Mia | enters | at 1, 0 | |

## Gestures
| Name | Time (s) | HeadYaw | HeadPitch |
|---|---|---|---|
| Nod | 0 | 0 | 0 |
| Nod | 1 | 0 | 10° |

## Protocol
| Field | Value |
|---|---|
| Title | A study |
| Version | 1.0 |
| Seed | 7 |

## Checks
| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | distance=1 | |
| 100 | Distance | | any |
"""


def compare(tmp_path, before: str, after: str) -> Comparison:
    paths = tmp_path / "before.md", tmp_path / "after.md"
    for path, text in zip(paths, (before, after), strict=True):
        path.write_text(text, encoding="utf-8")
    return api.diff(*paths)


def edited(*edits: tuple[str, str]) -> str:
    text = BASE
    for old, new in edits:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    return text


def told(comparison: Comparison) -> list[str]:
    """Changes as they are printed, with `~` before those without effect."""
    return [("" if c.effect else "~ ") + say(c) for c in comparison.changes]
