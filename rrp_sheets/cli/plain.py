"""Texts of workbooks in the terminal: what could steer it is shown as a sign instead."""

from __future__ import annotations

import io
import re
import sys

_OURS = r"\x1b(?!\[(?:0|1|2|3[0-7]|9[0-7])m)"  # the colours of click.style pass
_STEERING = re.compile(_OURS + "|[\x00-\x08\x0b\x0c\x0e-\x1a\x1c-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]|\r(?!\n)")


def plain_text(text: str) -> str:
    r"""A text for the terminal: what could steer it is shown as a sign instead (colours of ours excepted).

    >>> plain_text("\x1b[31mred\x1b[0m, \x1b]0;title\x07") == "\x1b[31mred\x1b[0m, \ufffd]0;title\ufffd"
    True
    """
    return _STEERING.sub("\ufffd", text)


class _PlainWriter(io.TextIOWrapper):
    """A stream on which nothing steers the terminal, and a letter that it cannot show is a question mark."""

    def write(self, text: str) -> int:
        super().write(plain_text(text))
        return len(text)


def plain_output() -> None:
    """Let everything that this process prints be plain; JSON that a program reads stays as it is."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if not isinstance(stream, io.TextIOWrapper):
            continue  # closed, or somebody else's
        if name == "stdout" and "--json" in sys.argv and not stream.isatty():
            stream.reconfigure(errors="replace")
            continue
        buffered = stream.line_buffering
        encoding = stream.encoding
        setattr(sys, name, _PlainWriter(stream.detach(), encoding, "replace", line_buffering=buffered))
