"""Time until a long run can be looked back at, and to go to another time of it.

Measured: what the clerk's process computes, in processor time: reading the workbook, looking through the trace, a piece of
values, a piece of poses. Not measured: the start of that process (some 0.5 s, once for a server), the browser.
"""

from __future__ import annotations

import json
import shutil
import time
from pathlib import Path

import pytest

from rrp_sheets.recording.lookback import answer
from rrp_sheets.resources import bundled

OPENED = 2.0  # s, of 100,000 events
SCRUBBED = 0.2  # s, of a piece
ROWS = {"Tracking!Distance": 2, "Tracking!Far ball": 3, "Head tracker": 4, "Tracking!Close ball": 5, "Tracking!Near": 6}
STREAMS = [{"stream": "Red ball", "kind": "sensor"}, *({"stream": s, "kind": "stream"} for s in ROWS)]


def make(place: Path, events: int, seconds: float) -> Path:
    """A run as simple tracking gives it, so long."""
    place.mkdir()
    shutil.copy(bundled("workbooks", "simple-tracking.xlsx"), place / "protocol.xlsx")
    with (place / "trace.jsonl").open("w", encoding="utf-8") as trace:
        trace.write(json.dumps({"type": "header", "streams": STREAMS}, separators=(",", ":")) + "\n")
        count = events // 6
        for k in range(count):
            t, far = round(k * seconds / count, 6), k % 1000 / 1000
            ball = {"x": 0.0, "y": -0.053, "width": 0.05, "height": 0.05, "distance": far, "colour": "red"}
            lines = [{"t": t, "stream": "Red ball", "row": "", "value": ball}]
            lines += [{"t": t, "stream": s, "row": f"Tracking!{r}", "value": far} for s, r in ROWS.items()]
            trace.writelines(json.dumps(line, separators=(",", ":")) + "\n" for line in lines)
    joints = {f"Joint{n}": 0.1 for n in range(26)}
    with (place / "poses.jsonl").open("w", encoding="utf-8") as poses:
        for k in range(int(seconds * 10)):
            part = {"full": True, "joints": joints} if k % 100 == 0 else {"joints": {"Joint1": k % 7 / 10}}
            poses.write(json.dumps({"t": k / 10, **part}, separators=(",", ":")) + "\n")
    return place


@pytest.mark.parametrize(("events", "seconds"), [(100_000, 600.0), (1_000_000, 3600.0)])
def test_a_long_run_is_opened_and_scrubbed(tmp_path: Path, events: int, seconds: float) -> None:
    place = make(tmp_path / "run", events, seconds)

    def took(what: str, number: int = 0) -> float:
        began = time.process_time()
        answer(place, what, number)
        return time.process_time() - began

    sheets, overview, first = took("sheets"), took("overview"), took("piece")
    pieces = len(json.loads(answer(place, "overview"))["pieces"])
    others = [took("piece", number) for number in range(1, pieces, max(1, pieces // 20))]
    poses = max(took("poses", number) for number in range(5))
    opened = sheets + overview + first + poses
    print(
        f"\n{events:,} events in {seconds / 60:g} min: {opened:.2f} s until its begin is shown (workbook {sheets:.2f}, trace "
        f"{overview:.2f}); another time {max(others):.3f} s (limit {SCRUBBED:g} s), poses {poses:.3f} s"
    )
    assert opened < OPENED * events / 100_000
    assert max(others) < SCRUBBED
