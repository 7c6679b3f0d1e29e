"""Time that a practised person needs for work in a browser: the keystroke-level model of its keys and clicks.

What counts is what the page received, not what a test meant to send. As in the measurement of the original software:
a key 0.28 s, pointing at something 1.1 s, a press or release of the button 0.1 s, the hand from keyboard to mouse or
back 0.4 s, and 1.35 s of thinking for each choice or typed value: a cell or field that is filled, an option, button or
link that is taken. Moving the cursor from cell to cell takes keys but no thought.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

KEY, POINT, BUTTON, HOME, THINK = 0.28, 1.1, 0.1, 0.4, 1.35
_SHIFTED = frozenset('ABCDEFGHIJKLMNOPQRSTUVWXYZ~!@#$%^&*()_+{}|:"<>?')
_MODIFIERS = frozenset({"Shift", "Control", "Alt", "Meta", "AltGraph"})
_LISTEN = """() => {
    const where = (target) => {
        const at = target.closest?.("[role=gridcell], [role=option], textarea, input, select, button, a, summary, [role=menuitem]");
        if (!at) return ["page", ""];
        if (at.matches("[role=gridcell]")) return ["cell", at.parentElement.id + at.cellIndex];
        if (at.matches("textarea, input:not([type=checkbox], [type=radio], [type=button], [type=submit]), select")) {
            return ["field", at.getAttribute("aria-label") || at.name || at.id];
        }
        return ["choice", at.textContent.trim().slice(0, 30)];
    };
    let down = null;
    const tell = (kind, event, key = "") => window.tellEffort([kind, key, ...where(event.target), event.clientX ?? 0, event.clientY ?? 0]);
    addEventListener("keydown", (event) => event.repeat || tell("key", event, event.key), true);
    addEventListener("pointerdown", (event) => tell("down", event), true);
    addEventListener("pointerup", (event) => tell("up", event), true);
}"""


@dataclass
class Effort:
    """The operators of the model, counted."""

    keys: int = 0
    points: int = 0
    buttons: int = 0
    homings: int = 0
    thoughts: int = 0

    @property
    def seconds(self) -> float:
        return (
            self.keys * KEY + self.points * POINT + self.buttons * BUTTON + self.homings * HOME + self.thoughts * THINK
        )

    def __str__(self) -> str:
        return (
            f"{self.seconds:.0f} s ({self.keys} keys, {self.points} pointings, {self.buttons // 2} clicks, "
            f"{self.homings} changes of hand, {self.thoughts} choices)"
        )


@dataclass
class Recorder:
    """Input that the pages of a context received, in order. `watch` before the pages are opened."""

    events: list[tuple[str, str, str, str, float, float]] = field(default_factory=list)

    def watch(self, context: Any) -> None:
        """Listen in every page of a browser context, those that are opened later too."""
        context.expose_binding("tellEffort", lambda _, event: self.events.append(tuple(event)))
        context.add_init_script(f"({_LISTEN})()")

    def begin(self) -> None:
        """Forget what has been done so far."""
        self.events.clear()

    def effort(self) -> Effort:
        """Effort since the beginning; the hand begins at the keyboard."""
        return count(self.events)


def count(events: list[tuple[str, str, str, str, float, float]]) -> Effort:
    """The operators of a list of events: (key, down or up; the key; what kind of thing; which; x; y).

    >>> str(count([("key", "a", "cell", "B2", 0, 0), ("key", "B", "field", "Input, row 2", 0, 0)]))
    '2 s (3 keys, 0 pointings, 0 clicks, 0 changes of hand, 1 choices)'
    """
    effort = Effort()
    hand, shifted, at = "keyboard", False, (-1e9, -1e9)
    value = ""  # the field that is being filled; "cell" while its editor is about to open
    for kind, key, place, name, x, y in events:
        if (using := "keyboard" if kind == "key" else "mouse") != hand:
            effort.homings, hand = effort.homings + 1, using
        if kind == "key":
            effort.keys += 1
            if key in _MODIFIERS:
                continue
            capital = key in _SHIFTED
            effort.keys += capital and not shifted
            shifted = capital
        else:
            if abs(x - at[0]) + abs(y - at[1]) > 10:
                effort.points, at = effort.points + 1, (x, y)
            effort.buttons += 1
            if kind == "up":
                continue
        new = _value(kind, key, place, name, value)
        effort.thoughts += bool(new) and value not in (new, "cell")
        effort.thoughts += _taken(kind, key, place, value)
        value = new
    return effort


def _value(kind: str, key: str, place: str, name: str, value: str) -> str:
    """The field that is being filled after an event."""
    typed = kind == "key" and (len(key) == 1 or key in ("F2", "Delete", "ArrowDown"))
    if place == "field" and (typed or value in (name, "cell")):
        return name
    if place == "cell" and typed and key != "ArrowDown":
        return "cell"
    return value if place == "choice" and value else ""


def _taken(kind: str, key: str, place: str, value: str) -> bool:
    """True when an event takes an option, button or link (one that helps to fill a field belongs to that value)."""
    return place == "choice" and not value and (kind == "down" or key in ("Enter", " "))
