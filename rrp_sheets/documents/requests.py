"""The requests of pages for which edits are made.

A page that got no answer sends a request again, with the same id, so its edit must not be made twice. The ids stand in
the journal beside the edits, which are made together or not at all: so this holds also when the server was killed.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock
from typing import Generic, TypeVar

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
