"""Keeps what the physics library writes to the C standard output off the program's own."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet() -> Iterator[None]:
    """Within it, what C code writes to the standard output is dropped (Python's own must not be used there)."""
    flush = ctypes.CDLL(None).fflush  # the library's lines are buffered, and would come out at the program's end
    sys.stdout.flush()
    flush(None)
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
