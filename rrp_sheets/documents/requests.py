"""The requests of pages for which edits are made, and refusals of edits in words.

A page that got no answer sends a request again, with the same id, so its edit must not be made twice. The ids stand in
the journal beside the edits, which are made together or not at all: so this holds also when the server was killed.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from typing import Generic, TypeVar

from rrp_sheets.documents.grid import Grid
from rrp_sheets.documents.row_changes import Clash, Refused

_ANSWERS = 500  # that are kept for pages that ask again
_NOW: ContextVar[tuple[str, ...]] = ContextVar("requests", default=())

Answer = TypeVar("Answer")


@contextmanager
def made_for(*requests: str) -> Iterator[None]:
    """Within, the edits of this thread are made for these requests."""
    before = _NOW.set(tuple(request for request in requests if request))
    try:
        yield
    finally:
        _NOW.reset(before)


def requests_now() -> tuple[str, ...]:
    """The ids of the requests for which this thread makes edits now."""
    return _NOW.get()


class Answers(Generic[Answer]):
    """The newest answers by their requests' ids. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._kept: OrderedDict[str, Future[Answer]] = OrderedDict()

    def once(self, request: str, make: Callable[[], Answer]) -> Answer:
        """The answer to a request, which is made the first time; who asks meanwhile waits for the same.

        Args:
            request: its id; empty for one that is never sent again.
            make: makes the answer.
        """
        if not request:
            return make()
        with self._lock:
            earlier, mine = self._kept.get(request), Future[Answer]()
            if earlier is None:
                self._kept[request] = mine
                while len(self._kept) > _ANSWERS:
                    self._kept.popitem(last=False)
        if earlier is not None:
            return earlier.result()
        try:
            answer = make()
        except BaseException as error:
            with self._lock:
                self._kept.pop(request, None)
            mine.set_exception(error)
            raise
        mine.set_result(answer)
        return answer


_AGAIN = "Look at it, and change it again if you still want to."


def must_have(grid: Grid, rows: Iterable[str]) -> None:
    """Refuse when one of the rows is gone."""
    if not all(grid.has(row) for row in rows):
        raise Refused("A row that this changes was deleted meanwhile.", _AGAIN)


def clash(grid: Grid, clashes: list[Clash]) -> Refused:
    """Return the refusal for cells that somebody has changed meanwhile."""
    first = clashes[0]
    by = first.by or "Someone"
    where = f"{grid.name}, row {grid.number(first.row)}"
    return Refused(
        f"{by} has changed this cell meanwhile ({where}): it is “{first.theirs}” now; yours was “{first.mine}”.",
        _AGAIN, tuple(clashes),
    )  # fmt: skip
