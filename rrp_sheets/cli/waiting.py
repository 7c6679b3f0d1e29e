"""Message on the error channel while something takes long."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import click

AFTER = 2.0  # s: what is quicker needs no word


@contextmanager
def told(words: str, after: float = AFTER) -> Iterator[None]:
    """Say on the error channel what is being done, when it takes longer than a moment."""
    timer = threading.Timer(after, click.echo, (words,), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
