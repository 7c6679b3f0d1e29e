"""How long the tests inside a workbook take: `python tests/benchmarks/bench_tests.py`."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1]))

from rrp_sheets import api
from rrp_sheets.resources import bundled
from rrp_sheets.testing import run_tests

TESTS = 20
ROWS = 10_000


def many_tests(folder: Path) -> None:
    """Twenty tests of a real workbook, reading and checking included."""
    source = (bundled("workbooks") / "source" / "greeter.md").read_text(encoding="utf-8")
    head, _, test = source.partition("\n## Test\n")
    path = folder / "many.md"
    path.write_text(head + "".join(f"\n## Test {n}\n{test}" for n in range(TESTS)), encoding="utf-8")
    began = time.perf_counter()
    checked, report = api.test(path)
    took = time.perf_counter() - began
    assert report is not None and report.passed and len(report.cases) == TESTS, checked.report.errors
    tests = sum(c.seconds for c in report.cases)
    clock = sum(c.ended_us for c in report.cases) / 1e6
    print(f"{TESTS} tests, {clock:.0f} s of behaviour: {took:.2f} s with reading and checking, {tests:.3f} s alone")
    assert took < 1.0, "20 tests should take less than a second"


def many_rows(folder: Path) -> None:
    """One test of ten thousand rows."""
    rows = [f"| {i * 40} | Red ball | distance={i / 1e5} | |" for i in range(ROWS // 2)]
    rows += [f"| {i * 40} | Distance | | {i / 1e5} |" for i in range(ROWS // 2 - 1)]
    path = folder / "rows.md"
    path.write_text(
        "## T\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n"
        "| Red ball | map | redBall.distance | Distance |\n| Distance | subscribe | | Print |\n"
        "\n## Test\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n" + "\n".join(rows) + "\n",
        encoding="utf-8",
    )
    began = time.perf_counter()
    checked = api.check(path)
    read = time.perf_counter() - began
    began = time.perf_counter()
    assert run_tests(checked).passed
    print(f"{ROWS} rows: {read:.2f} s to read and check, {time.perf_counter() - began:.2f} s to run")


if __name__ == "__main__":
    with TemporaryDirectory() as name:
        many_tests(Path(name))
        many_rows(Path(name))
