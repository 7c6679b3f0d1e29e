"""Figures of records: opening, plotting and exporting runs of many events, and looking for a code before deleting.

Seconds of the processor, those of the processes that the server starts included: other programs do not count.
"""

from __future__ import annotations

import json
import math
import os
import time
from contextlib import suppress
from pathlib import Path

import pytest
from browser import get, visit
from recorded import END, HEADER

from rrp_sheets import api
from rrp_sheets.recording.deleting import plan

KINDS = ("Red ball", "Tracking!Distance", "Tracking!Far ball", "Head tracker")


def long_run(folder: Path, events: int) -> Path:
    """A run as a camera at 30 Hz gives it, through three rows, with errors, speech and marks."""
    place = folder / "runs" / f"r{events}"
    place.mkdir(parents=True)
    streams = [
        {"stream": name, "kind": kind, "device": device}
        for name, kind, device in zip(
            KINDS, ("sensor", "stream", "stream", "actuator"), ("RedBall", None, None, "Tracker"), strict=True
        )
    ]
    with (place / "trace.jsonl").open("w", encoding="utf-8") as file:
        file.write(json.dumps(HEADER | {"streams": streams}) + "\n")
        for number in range(events):
            far = 1 + math.sin(number / 2400)
            ball = {"x": 0.1 * far, "y": -0.2, "width": 0.14, "height": 0.17, "distance": far, "colour": "red"}
            entry = {"t": round(number / 120, 6), "row": "Tracking!2"}
            if number % 997 == 5:
                entry |= {"happening": "say", "text": "Hello there"}
            elif number % 501 == 7:
                entry |= {"error": "This formula divides by zero.", "code": "FORM101", "inputs": [0]}
            else:
                entry |= {"stream": KINDS[number % 4], "value": far if number % 4 == 1 else ball}
            file.write(json.dumps(entry, separators=(",", ":")) + "\n")
        file.write(json.dumps(END | {"simulated_seconds": events / 120}) + "\n")
    return place


def processor() -> float:
    """Seconds that this process and its children have used the processor for (on Linux)."""
    used = 0.0
    for place in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = place.read_text().rpartition(")")[2].split()
            if int(fields[1]) == os.getpid():
                used += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return time.process_time() + used


def timed(what: str, began: float) -> float:
    took = processor() - began
    print(f"{what}: {took:.2f} s")
    return took


@pytest.mark.parametrize("events", [100_000, 1_000_000])
def test_opening_a_long_run(tmp_path: Path, events: int) -> None:
    """Until the page with the log is there, the process that reads the record included."""
    place = long_run(tmp_path, events)
    client = visit(tmp_path)
    began = processor()
    assert get(client, f"/runs/{place.name}").status_code == 200
    assert timed(f"what comes at once of {events:,} events", began) < 2
    began = processor()
    page = get(client, f"/runs/{place.name}?read=1")
    took = timed(f"page of {events:,} events", began)
    assert f"{events:,} values and events" in page.text
    began = processor()
    assert get(client, f"/runs/{place.name}/series.json").json
    timed("its curves", began)
    assert took < 2.0 * events / 100_000


def test_exporting_a_long_run(tmp_path: Path) -> None:
    place = long_run(tmp_path, 100_000)
    for name in ("run.csv", "run.xlsx", "plots.svg", "plots.pdf"):
        began = processor()
        api.export([place], tmp_path / name)
        timed(f"{name} of 100,000 events", began)
    began = processor()
    assert set(plan(tmp_path, "P-01").elsewhere) >= {"run.csv", "run.xlsx", "plots.svg"}  # no PDF is searched
    timed("looking for the code in these", began)
