"""Traffic of the run panel while a run goes on in which nothing moves.

The real server in a process of its own, a real simulated run, the panel open in Chromium with its views as they are at first.
Bytes and requests are those that the browser counts, its event stream included.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from chromium import browsing
from panel import running
from test_killed_server import Served

from rrp_sheets.workbook.files import make_workbook

WINDOW = 20.0  # seconds
MOST_BYTES, MOST_REQUESTS = 30_000, 4.0  # a second


class Traffic:
    """Bytes and requests of a page from now on."""

    def __init__(self, page: Any) -> None:
        self.bytes = 0
        self.asked: Counter[str] = Counter()
        self._line = page.context.new_cdp_session(page)
        self._line.on("Network.dataReceived", self._received)
        self._line.on("Network.requestWillBeSent", self._sent)
        self._line.send("Network.enable")

    def _received(self, told: dict[str, Any]) -> None:
        self.bytes += told["encodedDataLength"] or told["dataLength"]

    def _sent(self, told: dict[str, Any]) -> None:
        self.asked[told["request"]["url"].partition("?")[0]] += 1

    def end(self) -> None:
        """Count no more."""
        self._line.detach()


HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
STILL = {
    "T": [
        HEADER, ["", "Red ball", "map", "redBall.distance", "Distance", ""], ["", "Distance", "filter", "distance < 0.8", "Near", ""],
        ["", "Near", "subscribe", "", "Head tracker", ""], ["", "Touch", "filter", "touch.pressed", "Touched", ""],
    ],
    "Scene": [["Time (s)", "Thing", "Does", "Value"], ["0", "Red ball", "appears", "at 0.5, 0.1, 0.4"]],
}  # fmt: skip


def test_a_run_in_which_nothing_moves(tmp_path: Path) -> None:
    make_workbook(STILL, tmp_path / "b.xlsx")
    with browsing() as browser, Served(tmp_path) as server:
        page = server.page(browser, "book/b.xlsx/run")
        page.wait_for_selector("body[data-ready]")
        server.post("book/b.xlsx/run/start", {"client": "c", "name": "n", "mode": "simulated", "until": "stop"})
        running(page)
        page.wait_for_selector("#eye canvas[data-drawn]")
        page.wait_for_timeout(3_000)  # the robot stands still, and everything was sent once
        traffic, drawn = Traffic(page), int(page.get_attribute("#eye canvas", "data-drawn"))
        page.wait_for_timeout(WINDOW * 1000)
        traffic.end()
        pictures = int(page.get_attribute("#eye canvas", "data-drawn")) - drawn
    requests = sum(traffic.asked.values())
    print(f"\n{traffic.bytes / WINDOW / 1000:.1f} kB/s (at most {MOST_BYTES / 1000:.0f}), {requests / WINDOW:.2f} requests/s "
          f"(at most {MOST_REQUESTS:.0f}) {dict(traffic.asked)}, {pictures / WINDOW:.2f} pictures/s")  # fmt: skip
    assert traffic.bytes / WINDOW < MOST_BYTES and requests / WINDOW < MOST_REQUESTS
