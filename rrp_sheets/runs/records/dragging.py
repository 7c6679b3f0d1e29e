"""Detection of drags: a thing that is put to many places one after the other is reported once."""

from __future__ import annotations

_GAP = 3.0  # seconds between two places, at most


class Drag:
    """State that decides whether a thing that is put somewhere is still being dragged.

    >>> drag = Drag()
    >>> [drag.goes_on(t, "Red ball", "Mika") for t in (1.0, 1.1, 5.0)]
    [False, True, False]
    """

    def __init__(self) -> None:
        self._what: tuple[str, str] | None = None
        self._last = 0.0

    def goes_on(self, t: float, thing: str, by: str) -> bool:
        """Return whether this placement, at `t` seconds of the run, continues the one before."""
        what, last = (thing.casefold(), by), self._last
        goes_on = what == self._what and t - last < _GAP
        self._what, self._last = what, t
        return goes_on

    def over(self) -> None:
        """End the drag, as something else was done."""
        self._what = None


def dragged(thing: str, text: str) -> str:
    """Return the text for a thing that was put to its last place, when there were others before.

    >>> dragged("Red ball", "Red ball is put to 0.50, 0.10, 0.42 m.")
    'Red ball is dragged to 0.50, 0.10, 0.42 m.'
    """
    put = f"{thing} is put to "
    return f"{thing} is dragged to {text[len(put) :]}" if text.startswith(put) else text
