"""Records of runs, made by hand for the tests."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import Plan
from rrp_sheets.engine.run_events import CommandQueue, RunObserver
from rrp_sheets.engine.trace import TraceWriter
from rrp_sheets.runs.running import Recorder

HOSTILE = "<script>alert(1)</script>\"'"
HEADER: dict[str, Any] = {
    "type": "header", "format": 1, "program": "0.2.0", "workbook": "0" * 64, "name": "good.md", "robot": "nao",
    "engine": "frame", "frame_rate": 30, "mode": "simulated", "seed": 7, "participant": "P-01", "condition": "Control",
    "operator": "Aya", "began": "2026-11-02T09:05:00+00:00",
    "streams": [{"stream": "Red ball", "kind": "sensor", "device": "RedBall"},
                {"stream": "Tracking!Distance", "kind": "stream", "device": None}],
}  # fmt: skip
EVENT = {"t": 0.5, "stream": "Tracking!Distance", "row": "Tracking!2", "value": 1.5}
END = {
    "type": "summary",
    "ended": "time",
    "simulated_seconds": 8.0,
    "events": {},
    "errors": {},
    "actuator_commands": {},
}


def write_run(folder: Path, name: str, *lines: dict[str, Any] | str) -> Path:
    """A run's folder with that trace; an old one, so that it is over."""
    place = folder / "runs" / name
    place.mkdir(parents=True)
    texts = [line if isinstance(line, str) else json.dumps(line) for line in lines]
    trace = place / "trace.jsonl"
    whole = not texts or texts[-1].endswith("}") or len(texts) < 3  # else its last line was cut off
    trace.write_text("\n".join(texts) + "\n" * whole, encoding="utf-8")
    os.utime(trace, (1_700_000_000, 1_700_000_000))
    return place


def recorded_engine(plan: Plan, writer: TraceWriter) -> FrameEngine:
    """Return an engine whose events a recorder writes into a trace."""
    recorder = Recorder(RunObserver(), CommandQueue())
    engine = FrameEngine(plan, recorder)
    recorder.begin(writer, engine)
    return engine
