"""A process of ours that answers: in time, whatever becomes of it; it is started again, and ended at once."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator

import pytest

from rrp_sheets.errors import SheetsError
from rrp_sheets.workers.worker_process import RestartingWorker, WorkerError

COURSE = "rrp_sheets.services.query_worker.course"
GONE = [COURSE, "/nowhere", "en"]


@pytest.fixture
def office() -> Iterator[RestartingWorker]:
    made = RestartingWorker()
    yield made
    made.close()


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def hang(office: RestartingWorker) -> int:
    """Its process, which has answered once and does nothing any more."""
    with pytest.raises(SheetsError, match="cannot be read"):
        office.ask(GONE, 300)
    hung = office.pid
    assert hung is not None
    os.kill(hung, signal.SIGSTOP)
    return hung


def test_one_that_does_not_take_what_is_sent_is_ended_in_time(office: RestartingWorker) -> None:
    hung = hang(office)
    with pytest.raises(WorkerError, match=r"did not end within 0\.3 s") as told:
        office.ask([COURSE, "x" * 5_000_000, "en"], 0.3)  # more than a connection holds
    assert not told.value.gone and office.pid is None and not alive(hung)
    with pytest.raises(SheetsError, match="cannot be read"):
        office.ask(GONE, 300)
    assert office.pid not in (None, hung)


def test_closing_does_not_wait_for_an_answer_and_who_asks_is_told(office: RestartingWorker) -> None:
    hung = hang(office)
    heard: list[str] = []

    def ask() -> None:
        try:
            office.ask(GONE, 300)
        except SheetsError as error:
            heard.append(error.message)

    threads = [threading.Thread(target=ask) for _ in range(3)]  # one asks, the others wait for it
    for thread in threads:
        thread.start()
    office.close()
    for thread in threads:
        thread.join(300)
    assert heard == ["The program is being ended."] * 3 and not alive(hung)
