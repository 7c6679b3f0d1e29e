"""Time that a replay takes: ten minutes of a busy session, and every workbook of ours."""

from __future__ import annotations

import json
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunSettings
from rrp_sheets.runs.running import run
from rrp_sheets.workbook import read

SECONDS = 600
WITHIN = 10.0


@pytest.fixture(scope="module")
def ten_minutes():
    """Complex tracking with a ball at camera rate for ten minutes, without the simulator."""
    from math import sin

    book = bundled("workbooks", "complex-tracking.xlsx")
    reading = read(book)
    checked = check_workbook(reading.workbook, reading.report)
    kind = checked.robot.find("Red ball").type.payload
    ball = kind.example().values
    events = [
        (n * 100_000, "redball", type(kind.example())(kind, {**ball, "distance": 1 + sin(n / 30), "x": sin(n / 7) / 2}))
        for n in range(SECONDS * 10)
    ]
    events += [(n * 60_000, "headyaw", round(sin(n / 11), 3)) for n in range(SECONDS * 16)]
    with TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        settings = RunSettings(seconds=SECONDS, fast=True, out=out)
        run(reading, checked, settings, world=lambda plan, scene, seed, place: ScriptedWorld(events))
        yield out


def test_ten_minutes(ten_minutes):
    began, worked = time.perf_counter(), time.process_time()
    found = api.replay(ten_minutes)
    took, work = time.perf_counter() - began, time.process_time() - worked
    size = (ten_minutes / "trace.jsonl").stat().st_size / 1e6
    print(f"\n{SECONDS} s, {found.compared:,} events, {size:.1f} MB: {took:.2f} s ({work:.2f} s of work), "
          f"{found.compared / work:,.0f} events a second, {SECONDS / work:.0f} times real time")  # fmt: skip
    assert found.same and work < WITHIN


def test_another_workbook(ten_minutes, tmp_path):
    other = tmp_path / "other.xlsx"
    other.write_bytes(bundled("workbooks", "complex-tracking.xlsx").read_bytes())
    row = next(r for r in api.read(other).workbook.behaviours[0].rows if "0.6 <=" in r.formula.text)
    api.set_cell(other, f"Tracking!{row.formula.address.cell}", row.formula.text.replace("0.6", "0.9"))
    worked = time.process_time()
    found = api.replay(ten_minutes, other)
    work = time.process_time() - worked
    size = len(json.dumps(found.as_dict())) / 1e6
    print(
        f"\nwith another threshold: {work:.2f} s of work, {len(found.differences):,} differences ({size:.1f} MB of JSON)"
    )
    assert found.differences and work < 1.5 * WITHIN
