"""Services of an application, which its views share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from flask import current_app

from rrp_sheets.runs.check_worker import CheckWorker
from rrp_sheets.services.bundle_packing import Packer
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.web.protocol_printer import ProtocolPrinter
from rrp_sheets.web.replay_jobs import Replays
from rrp_sheets.web.run_session import RunManager
from rrp_sheets.web.run_store import RunStore
from rrp_sheets.web.workbook_repository import WorkbookRepository
from rrp_sheets.web.workbook_session import OpenWorkbooks

EXPORT_SECONDS = 150.0  # a table of a long run takes its time
WORKER_MODULES = (
    "rrp_sheets.sim.world", "rrp_sheets.sim.film", "rrp_sheets.sim.server", "cv2", "psutil",
    "rrp_sheets.runs.engine_process", "rrp_sheets.runs.running", "rrp_sheets.drivers.simulated", "reactivex.operators",
    "rrp_sheets.engine.runners", "rrp_sheets.recording.table", "rrp_sheets.workbook.maker",
    "rrp_sheets.documents.copies", "rrp_sheets.render.marble_drawing", "rrp_sheets.web.workbook_tests",
)  # fmt: skip
"""Modules that worker processes of a server import: its fork server has them, so that a run begins a second earlier."""


@dataclass(frozen=True)
class Services:
    """Services of one application; `app.extensions["services"]`, in a view `services()`.

    Attributes:
        queries: reads recordings for their pages.
        lookback_queries: does so for looking back, where the slider must not wait for other drawings.
        drawer: draws comparisons, for which no other page waits.
        exporter: makes tables and pictures of recordings, and deletes recordings.
    """

    repository: WorkbookRepository
    open_workbooks: OpenWorkbooks
    run_manager: RunManager
    runs: RunStore
    queries: QueryWorker
    lookback_queries: QueryWorker
    drawer: QueryWorker
    exporter: QueryWorker
    printer: ProtocolPrinter
    packer: Packer
    replays: Replays

    def close(self) -> None:
        """End the processes of the services, and start no others; a run goes on until its own end."""
        for service in (
            self.open_workbooks, self.queries, self.lookback_queries, self.drawer, self.exporter, self.printer,
            self.packer, self.replays, self.repository.worker,
        ):  # fmt: skip
            service.close()


def make_services(folder: Path) -> Services:
    """Make the services for the workbooks of a folder."""
    worker = CheckWorker()
    open_workbooks = OpenWorkbooks(folder, worker)
    run_manager = RunManager(open_workbooks)
    runs = RunStore(folder, run_manager.going, run_manager.writing, run_manager.forget)
    return Services(
        repository=WorkbookRepository(folder, worker), open_workbooks=open_workbooks, run_manager=run_manager,
        runs=runs, queries=QueryWorker(), lookback_queries=QueryWorker(), drawer=QueryWorker(),
        exporter=QueryWorker(EXPORT_SECONDS), printer=ProtocolPrinter(), packer=Packer(), replays=Replays(),
    )  # fmt: skip


def services() -> Services:
    """Return the services of the application that answers the request."""
    found: Services = current_app.extensions["services"]
    return found
