"""Time that `rrp-sheets print` takes, from the command to the file: checked, tested, drawn, set, written.

Processor time of a process of its own, begun cold, as a user begins it; and the wall time, in which other programs count.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

from rrp_sheets.resources import bundled

PROGRAM = [sys.executable, "-c", "from rrp_sheets.cli.main import main; main()"]
TIMES = 5
MOST = 2.0  # s, of complex tracking


def print_once(name: str, folder: Path) -> tuple[float, float]:
    """Seconds of processor time (Graphviz included) and of wall time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.monotonic()
    path = bundled("workbooks", f"{name}.xlsx")
    subprocess.run([*PROGRAM, "print", str(path), "-o", str(folder / "p.pdf")], check=True, capture_output=True)
    wall = time.monotonic() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def test_print(tmp_path: Path) -> None:
    print()
    for name in ("simple-tracking", "complex-tracking", "mixed-control", "touch-and-name"):
        times = [print_once(name, tmp_path) for _ in range(TIMES)]
        busy, wall = (statistics.median(column) for column in zip(*times, strict=True))
        best = min(wall for _, wall in times)
        size = (tmp_path / "p.pdf").stat().st_size
        print(f"{name:18} processor {busy:5.2f} s   wall {wall:5.2f} s (best {best:.2f} s)   {size / 1024:,.0f} kB")
        if name == "complex-tracking":
            assert busy < MOST
