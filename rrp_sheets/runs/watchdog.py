"""The watchdog: whether an engine in another process still goes on, by the numbers that it leaves in shared memory."""

from __future__ import annotations

import time

from rrp_sheets.runtime.progress import INSTANT, RANK, SETTLING, Cell

STUCK_AFTER = 2.0
"""Seconds that one row may take. The budget of a formula ends within a tenth of a second, so that 2 s beyond the frame
are no slow row but one that never ends; and a robot should not be without its engine for longer."""
SILENT_AFTER = 30.0
"""Seconds without a word between the frames of a run. A simulator that does not answer breaks the run off by itself
after 10 s."""
PREPARED_AFTER = 90.0
"""Seconds without a word before the run: reading, checking, starting the simulator. Usually 2."""
FINISHED_AFTER = 900.0
"""Seconds without a word after it, when the robot rests: a table of a million rows takes minutes."""
_LONGEST_LOOK = 0.5  # s that count between two looks: when the whole machine stood still, nobody was stuck


class Watchdog:
    """Looks at an engine's cell from time to time.

    A paced wait is no stall: only an engine that is settling, at the same row of the same instant as before, is stuck.

    Attributes:
        stuck: whether it bit because a row does not come to an end, and not because nothing was heard at all.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._seen = (0, 0, 0)
        self._same = 0.0
        self._silent = 0.0
        self._looked = time.monotonic()
        self.stuck = False

    def bites(self, *, heard: bool, silent_after: float = SILENT_AFTER, now: float | None = None) -> bool:
        """Whether the process must be ended.

        Args:
            heard: whether it has said something since the last look.
            silent_after: how many seconds it may say nothing, doing what it is doing now.
            now: seconds on any clock; the machine's when None.
        """
        now = time.monotonic() if now is None else now
        passed = min(now - self._looked, _LONGEST_LOOK)
        self._looked = now
        seen = (self._cell[INSTANT], self._cell[SETTLING], self._cell[RANK])
        moved = seen != self._seen or not seen[1]
        self._seen = seen
        self._same = 0.0 if moved else self._same + passed
        self._silent = 0.0 if heard or (moved and seen[1]) else self._silent + passed
        self.stuck = self._same > STUCK_AFTER
        return self.stuck or self._silent > silent_after
