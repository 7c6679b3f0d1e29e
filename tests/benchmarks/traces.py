"""Compares the traces of all bundled workbooks between Pythons: `python traces.py PYTHON PYTHON …`.

Each PYTHON is an interpreter that has RRP Sheets installed, for example `.venv/bin/python`. Every workbook runs in
each of them until its scene is over, or for `--seconds`, without film. `--only NAME` takes one workbook. The traces
must be equal from the second line on: the first is the header, which has the time of the run. Exits with 1 when a
trace differs.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path


def run(workbook: Path, folder: Path, most: float) -> None:
    """Run a workbook in this interpreter until its scene is over, at most for some seconds."""
    from rrp_sheets import api
    from rrp_sheets.scene.scene_sheet import scene_end_us

    seconds = min(scene_end_us(api.check(workbook).scene or ()) / 1e6 + 1.5, most)
    _, result = api.run(workbook, api.RunSettings(seconds=seconds, fast=True, out=folder, film=False, camera=False))
    assert result is not None, f"{workbook.name} has errors"
    assert result.broken is None, result.broken


def traces(pythons: list[str], workbook: Path, base: Path, most: float) -> list[list[str]]:
    """The lines of its traces in all Pythons, which run at the same time; without the headers."""
    folders = [base / str(number) for number in range(len(pythons))]
    started = [
        subprocess.Popen([python, __file__, "--run", str(workbook), str(folder), str(most)])
        for python, folder in zip(pythons, folders, strict=True)
    ]
    ended = [process.wait() for process in started]
    assert not any(ended), f"{workbook.name} did not run: exit codes {ended}"
    return [(folder / "trace.jsonl").read_text(encoding="utf-8").splitlines()[1:] for folder in folders]


def difference(name: str, first: list[str], other: list[str]) -> str:
    """First difference of two traces, in one line; empty when they are equal."""
    if first == other:
        return ""
    pairs = enumerate(zip(first, other, strict=False), start=2)
    line = next((number for number, (one, two) in pairs if one != two), min(len(first), len(other)) + 2)
    return f"{name} has {len(other)} records and differs from line {line} on"


def main(pythons: list[str], only: str, most: float) -> int:
    """Run all workbooks in all interpreters; the number of traces that differ."""
    from rrp_sheets.resources import bundled

    failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        for workbook in sorted(bundled("workbooks").glob(f"{only}.xlsx")):
            lines = traces(pythons, workbook, Path(scratch, workbook.stem), most)
            told = [difference(python, lines[0], other) for python, other in zip(pythons, lines, strict=True)]
            print(
                f"{workbook.stem}: {len(lines[0])} records, {'; '.join(filter(None, told)) or 'all equal'}", flush=True
            )
            failed += sum(map(bool, told))
    return failed


if __name__ == "__main__":
    if sys.argv[1:2] == ["--run"]:
        run(Path(sys.argv[2]), Path(sys.argv[3]), float(sys.argv[4]))
        sys.exit()
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("pythons", nargs="+", metavar="PYTHON")
    options.add_argument("--only", default="*", metavar="NAME", help="the name of one workbook, or a pattern of names")
    options.add_argument("--seconds", type=float, default=math.inf, help="of each workbook, at most")
    given = options.parse_args()
    sys.exit(min(main(given.pythons, given.only, given.seconds), 1))
