"""Replays of recorded runs that pages wait for; they run one at a time."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.replay.replaying import Stopped, replay_apart
from rrp_sheets.texts import N_
from rrp_sheets.web.models import error_text

ASKED_WITHIN = 20.0  # s: a page that waits asks every half second
_KEPT = 8  # accounts
_MOST = 4  # that wait or go on: a page more is told to come later
_Other = Callable[[ExitStack], "Path | None"]


@dataclass
class ReplayJob:
    """Replay that is going on, or is over; a page has `asked` for it last at that time.

    Attributes:
        part: the progress, from 0 to 1.
        trouble: why there is no account, in words.
        given_up: no page waited for it any more; the next request starts it anew.
    """

    part: float = 0.0
    account: dict[str, Any] | None = None
    trouble: str = ""
    given_up: bool = False
    asked: float = field(default_factory=time.monotonic)
    done: threading.Event = field(default_factory=threading.Event)

    @property
    def over(self) -> bool:
        """True when the replay has ended, with a result or not."""
        return self.done.is_set()


class Replays:
    """Replay jobs by record and workbook; they run one at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._turn = threading.Lock()
        self._closed = False
        self._jobs: OrderedDict[Hashable, ReplayJob] = OrderedDict()

    def job(self, name: Hashable, place: Path, other: _Other, language: str) -> ReplayJob:
        """Return the replay of a name, one for each record, workbook and language; the first request starts it.

        `place` is the run's folder; `other` returns the workbook's file, or None for the one that ran, and its stack is
        closed at the end. Raises SheetsError when too many go on already.
        """
        with self._lock:
            found = self._jobs.get(name)
            if found is not None and not found.given_up:
                found.asked = time.monotonic()
                return found
            if sum(not job.over for job in self._jobs.values()) >= _MOST:
                raise SheetsError(N_("Other replays are in progress."), N_("Try it again in a minute."))
            job = self._jobs[name] = ReplayJob()
            for old in [n for n, j in self._jobs.items() if j.over][: max(0, len(self._jobs) - _KEPT)]:
                del self._jobs[old]
        threading.Thread(target=self._work, args=(job, place, other, language), name="replay", daemon=True).start()
        return job

    def close(self) -> None:
        """Stop the replays that go on or wait."""
        self._closed = True

    def _work(self, job: ReplayJob, place: Path, other: _Other, language: str) -> None:
        def progress(part: float) -> None:
            job.part = part

        def stopped() -> bool:
            return self._closed or time.monotonic() - job.asked > ASKED_WITHIN

        try:
            with self._turn, ExitStack() as stack:
                account = replay_apart(place, other(stack), language, progress, stopped)
        except Stopped as error:
            job.trouble, job.given_up = str(error), True
        except SheetsError as error:
            job.trouble = error_text(error)
        except OSError as error:
            job.trouble = N_("It cannot be read ({why}).", why=error.strerror)
        else:
            job.account = account
        finally:
            job.done.set()
