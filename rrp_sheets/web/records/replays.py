"""The replays that pages wait for: one at a time, in a process of its own, given up when nobody asks any more."""

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
from rrp_sheets.runs.replay.apart import Stopped, replay_apart

ASKED_WITHIN = 20.0  # s: a page that waits asks every half second
_KEPT = 8  # accounts
_MOST = 4  # that wait or go on: a page more is told to come later
_Other = Callable[[ExitStack], "Path | None"]


@dataclass
class Job:
    """A replay that goes on, or is over.

    Attributes:
        part: how far it is, from 0 to 1.
        account: what was found, when it is over.
        trouble: why there is no account, in words.
        asked: when a page has last asked for it.
        done: set when it is over.
    """

    part: float = 0.0
    account: dict[str, Any] | None = None
    trouble: str = ""
    asked: float = field(default_factory=time.monotonic)
    done: threading.Event = field(default_factory=threading.Event)

    @property
    def over(self) -> bool:
        """Whether there is nothing more to wait for."""
        return self.done.is_set()


class Replays:
    """Replays by what is replayed with what."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._turn = threading.Lock()
        self._jobs: OrderedDict[Hashable, Job] = OrderedDict()

    def job(self, name: Hashable, place: Path, other: _Other) -> Job:
        """The replay of that name; it begins when it is asked for the first time.

        Args:
            name: the same for the same record and the same workbook.
            place: the run's folder.
            other: gives the workbook's file; None for the one that ran. What it opens is closed at the end.

        Raises:
            SheetsError: when too many go on already.
        """
        with self._lock:
            found = self._jobs.get(name)
            if found is not None and not isinstance(found.trouble, _GivenUp):
                found.asked = time.monotonic()
                return found
            if sum(not job.over for job in self._jobs.values()) >= _MOST:
                raise SheetsError("Other replays are going on.", "Try it again in a minute.")
            job = self._jobs[name] = Job()
            for old in [n for n, j in self._jobs.items() if j.over][: max(0, len(self._jobs) - _KEPT)]:
                del self._jobs[old]
        threading.Thread(target=self._work, args=(job, place, other), name="replay", daemon=True).start()
        return job

    def _work(self, job: Job, place: Path, other: _Other) -> None:
        def told(part: float) -> None:
            job.part = part

        def stopped() -> bool:
            return time.monotonic() - job.asked > ASKED_WITHIN

        try:
            with self._turn, ExitStack() as stack:
                account = replay_apart(place, other(stack), told, stopped)
        except Stopped as error:
            job.trouble = _GivenUp(f"{error.message} {error.remedy}")
        except SheetsError as error:
            job.trouble = f"{error.message} {error.remedy}".strip()
        except OSError as error:
            job.trouble = f"It cannot be read ({error.strerror})."
        else:
            job.account = account
        finally:
            job.done.set()


class _GivenUp(str):
    """Why a replay was given up: it begins anew when somebody asks again."""
