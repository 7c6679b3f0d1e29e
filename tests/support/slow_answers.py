"""A page whose answers and events are held, and released when a test says so."""

from __future__ import annotations

import random
import re
import time
from collections import deque
from contextlib import suppress
from typing import Any, Self

from playwright.sync_api import Error

EDITS = re.compile(r"/(cells|insert|delete|move|undo|redo|fix|lock|unlock)$")
_EVENTS = """() => {
  window.heldEvents = [];
  window.holdEvents = true;
  addEventListener("grid", (event) => {
    if (!window.holdEvents || event.detail?.released) return;
    event.stopImmediatePropagation();
    window.heldEvents.push([event.target, event.detail.data]);
  }, true);
  window.releaseEvents = (count) => {
    for (const [target, data] of window.heldEvents.splice(0, count)) {
      target.dispatchEvent(new CustomEvent("grid", { bubbles: true, detail: { data, released: true } }));
    }
  };
}"""


class SlowAnswers:
    """Holds what a page sends before the server has it, and what the server answers before the page has it; and events."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.asked: deque[Any] = deque()
        self.answered: deque[tuple[Any, Any]] = deque()
        page.evaluate(_EVENTS)
        page.route(EDITS, self._hold)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.page.unroute(EDITS, self._hold)
        with suppress(Error):  # the page was loaded again meanwhile: nobody waits for the answer
            while self.step():
                pass
        self.page.evaluate("() => { window.holdEvents = false; window.releaseEvents?.(1000); }")

    def _hold(self, route: Any) -> None:
        self.asked.append(route)

    def step(self) -> bool:
        """Let one request reach the server, or one answer reach the page; whether there was any."""
        if self.answered:
            route, answer = self.answered.popleft()
            route.fulfill(response=answer)
        elif self.asked:
            route = self.asked.popleft()
            self.answered.append((route, route.fetch()))
        else:
            return False
        return True

    def refuse(self, message: str) -> None:
        """Answer what was asked first as the server does when it refuses it."""
        self.asked.popleft().fulfill(json={"message": message})

    def events(self, count: int = 1000) -> None:
        """Let some events reach the page."""
        self.page.evaluate("count => releaseEvents(count)", count)

    def draw(self, drawn: random.Random) -> None:
        """Let something drawn happen: nothing, a few steps, or a few events."""
        for _ in range(drawn.choice((0, 0, 0, 1, 1, 2, 4))):
            self.step()
        if drawn.random() < 0.3:
            self.events(drawn.randint(1, 3))

    def release(self) -> None:
        """Let everything happen, until all is saved."""
        self.settle()
        self.events()

    def settle(self) -> None:
        """Let all answers come, until all is saved; but no event."""
        deadline = time.monotonic() + 300
        while self.saving:
            assert time.monotonic() < deadline, "the page does not come to rest"
            if not self.step():
                self.page.evaluate("() => new Promise((done) => setTimeout(done))")

    @property
    def saving(self) -> bool:
        """True when the page has something that is not saved."""
        return bool(self.page.evaluate("() => document.body.hasAttribute('data-saving')"))
