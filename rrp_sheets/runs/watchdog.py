"""The watchdog: whether an engine in another process still goes on, by the numbers that it leaves in shared memory."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from rrp_sheets.engine.heartbeat import INSTANT, NO_ROW, RANK, SETTLING, Heartbeat
from rrp_sheets.processes import Liveness

ROW_WITHIN = 2.0
"""Seconds of processor time that one row may take. The budget of a formula ends within a tenth of a second, so that 2 s
are no slow row but one that never ends; and a robot should not be without its engine for longer."""
INSTANT_WITHIN = 5.0
"""Seconds of processor time that all rows together may take for one instant: a frame, or an event of the event loop."""
STILL_WITHIN = 5.0
"""Seconds (wall clock) that an engine may use no processor time while rows are worked out."""
SILENT_AFTER = 30.0
"""Seconds without a word between the frames of a run: of processor time, or of the wall clock without any."""
PREPARED_AFTER = 90.0
"""As many before the run: reading, checking, starting the simulator. Usually 2."""
FINISHED_AFTER = 900.0
"""As many after it, when the robot rests: a table of a million rows takes minutes."""
_MOST_NAMED = 3  # rows


class Watchdog:
    """Looks at an engine's cell from time to time.

    A paced wait is no stall: only an engine that is settling, at the same instant as before, is slow or stuck.

    Args:
        cell: where the engine is.
        cpu: its processor time in seconds.
        now: the wall clock in seconds.
    """

    def __init__(self, cell: Heartbeat, cpu: Callable[[], float], now: Callable[[], float] = time.monotonic) -> None:
        self._cell = cell
        self._row = Liveness(cpu, now)
        self._process = Liveness(cpu, now)
        self._words = 0  # how often something was heard
        self._instant = -1
        self._rank = NO_ROW
        self._costs: dict[int, float] = {}  # s of processor time at the present instant, by rank

    def failure(
        self, *, heard: bool, silent_after: float = SILENT_AFTER, waits: bool = False, rows: Mapping[int, str]
    ) -> str:
        """Why the process must be ended, as the beginning of a sentence; empty when it goes on.

        Args:
            heard: whether it has said something since the last look.
            silent_after: how many seconds it may say nothing, doing what it is doing now.
            waits: whether it waits for the simulator, which is at work.
            rows: the rows' names by rank.
        """
        instant, settling, rank = self._cell[INSTANT], bool(self._cell[SETTLING]), self._cell[RANK]
        self._words += heard
        self._process.look((self._words, instant if settling else 0), has_work=not waits)
        at = (instant, rank) if settling else (instant, self._words, "between")
        computed, _ = self._row.look(at, has_work=settling)
        if not settling or instant != self._instant:
            self._costs.clear()
        else:  # what passed since the last look is shared between the row of then and that of now
            for place in (self._rank, rank):
                self._costs[place] = self._costs.get(place, 0.0) + computed / 2
        self._instant, self._rank = instant, rank
        if not settling:
            if max(self._process.computing, self._process.still) > silent_after:
                return f"The run has not gone on for {silent_after:g} s"
            return ""
        where = f" while the row {rows[rank]} was being worked out" if rank in rows else ""
        if self._row.computing > ROW_WITHIN:
            return f"The run has not gone on for {ROW_WITHIN:g} s{where}"
        if self._row.still > STILL_WITHIN:
            return f"The run has stood still for {STILL_WITHIN:g} s{where}"
        if sum(self._costs.values()) > INSTANT_WITHIN:
            costly = sorted((r for r in self._costs if r in rows), key=lambda r: -self._costs[r])[:_MOST_NAMED]
            named = ", ".join(f"{rows[r]} ({self._costs[r]:.1f} s)" for r in costly)
            return f"The rows of one instant took more than {INSTANT_WITHIN:g} s; the costliest are {named}"
        return ""
