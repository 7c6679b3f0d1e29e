"""Filter for the actuator commands that a display shows: a continuing stream of commands is thinned out."""

from __future__ import annotations

from rrp_sheets.model.values import Record, Value

QUIET_US = 2_000_000  # a row that keeps driving its actuator is told again only after such a pause
CHANGE_US = 1_000_000  # and changes of what it sends at most so often


class Commands:
    """The commands of a run so far, by the row that gave them."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}
        self._told: dict[str, tuple[int, Value]] = {}
        self._given: dict[str, Value] = {}  # what each actuator stream was sent last

    def tell(self, us: int, row: str, value: Value, stream: str = "") -> bool:
        """Return whether a command is worth showing: no mere repetition, and no blank for a stream that does nothing.

        >>> commands = Commands()
        >>> sent = ((0.0, 1.0), (0.1, 5.0), (1.1, 5.0), (1.2, 1.0), (4.0, 1.0))
        >>> [commands.tell(round(seconds * 1e6), "T!2", value) for seconds, value in sent]
        [True, False, True, False, True]
        """
        idle = value is None and self._given.get(stream) is None
        self._given[stream] = value
        if idle:
            return False
        last = self._last.get(row)
        self._last[row] = us
        told, shown = self._told.get(row, (0, None))
        if last is None or us - last > QUIET_US or (us - told >= CHANGE_US and differs(value, shown)):
            self._told[row] = (us, value)
            return True
        return False


def differs(value: Value, shown: Value) -> bool:
    """Return whether a value clearly differs from the one shown: a number by a quarter, anything else at all.

    >>> differs(1.0, 1.1), differs(1, 2), differs("red", "blue")
    (False, True, True)
    """
    if isinstance(value, Record):
        return not isinstance(shown, Record)
    if isinstance(value, float) and isinstance(shown, (int, float)):
        return abs(value - shown) > 0.25 * max(abs(value), abs(shown), 0.4)
    return bool(value != shown)
