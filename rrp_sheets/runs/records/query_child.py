"""Query process: `python -m rrp_sheets.runs.records.query_child LINK`, started by `query_worker` only.

It ends when the connection closes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.runs.trace_reader import TRACE
from rrp_sheets.runs.worker_loop import serve


def _course(place: str) -> dict[str, Any]:
    about = (Path(place) / TRACE).stat()
    return _known_course(place, (about.st_mtime_ns, about.st_size))


@lru_cache(maxsize=2)
def _known_course(place: str, stamp: tuple[int, int]) -> dict[str, Any]:
    """Return the timeline of a run; kept, as a page asks twice: for the log and for the curves."""
    from rrp_sheets.runs.records.timeline import build_timeline

    return build_timeline(Path(place))


def _marbles(place: str, behaviour: str, rows: list[int], window: list[float | None], spread: bool) -> dict[str, Any]:
    from rrp_sheets.runs.marbles import marbles

    return marbles(Path(place), behaviour, rows, (window[0], window[1]), spread)


def _compare(first: str, second: str) -> dict[str, Any]:
    from rrp_sheets.compare import compare
    from rrp_sheets.compare.as_json import as_dict
    from rrp_sheets.compare.side import open_checked

    return as_dict(compare(open_checked(Path(first)), open_checked(Path(second))))


def _lookback(place: str, what: str, number: int) -> str:
    from rrp_sheets.runs.lookback import answer

    return answer(Path(place), what, number)


def _drawn(first: str, second: str) -> str:
    from rrp_sheets.runs.changes_drawn import compared

    return compared(Path(first), Path(second)).html()


_DO: dict[str, Callable[..., Any]] = {
    "drawn": _drawn,
    "lookback": _lookback,
    "course": _course,
    "marbles": _marbles,
    "compare": _compare,
}


if __name__ == "__main__":
    serve(_DO)
