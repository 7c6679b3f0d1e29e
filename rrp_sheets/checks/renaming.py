"""Names within the text of a formula, replaced by others; what stands between quotes is left alone."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rrp_sheets.model.names import key

_PIECE = re.compile(r"""(?P<text>"(?:[^"]|"")*"|'(?:[^']|'')*')|(?P<name>[^\W\d]\w*)|(?P<other>.)""", re.DOTALL)


def renamed(text: str, new: Mapping[str, str]) -> str | None:
    """The formula with names replaced; None for texts with values in them (`f"…{x}…"`), where that is not safe.

    >>> renamed('ballX & "ballX" & ball.ballX', {"ballX": "newX"})
    'newX & "ballX" & ball.ballX'
    """
    by_key = {key(old): name for old, name in new.items()}
    parts: list[str] = []
    before = ""
    for match in _PIECE.finditer(text):
        piece = match.group()
        if match["text"] and before.casefold() == "f":
            return None
        if match["name"] and not (parts and parts[-1] == "."):
            parts.append(by_key.get(key(piece), piece))
        else:
            parts.append(piece)
        before = piece
    return "".join(parts)
