"""Time that the tests inside a workbook take. Wall time of this machine, with reading and checking where it says so."""

from __future__ import annotations

import time

from rrp_sheets import api
from rrp_sheets.resources import bundled
from rrp_sheets.testing import run_tests

TESTS = 20
ROWS = 10_000


def test_twenty_tests(tmp_path):
    source = (bundled("workbooks") / "source" / "greeter.md").read_text(encoding="utf-8")
    head, _, test = source.partition("\n## Test\n")
    path = tmp_path / "many.md"
    path.write_text(head + "".join(f"\n## Test {n}\n{test}" for n in range(TESTS)), encoding="utf-8")
    began = time.perf_counter()
    _, report = api.test(path)
    took = time.perf_counter() - began
    assert report.passed and len(report.cases) == TESTS
    alone = sum(c.seconds for c in report.cases)
    clock = sum(c.ended_us for c in report.cases) / 1e6
    print(f"\n{TESTS} tests, {clock:.0f} s of behaviour: {took:.2f} s with reading and checking, {alone:.3f} s alone")
    assert took < 1.0


def test_ten_thousand_rows(tmp_path):
    rows = [f"| {i * 40} | Red ball | distance={i / 1e5} | |" for i in range(ROWS // 2)]
    rows += [f"| {i * 40} | Distance | | {i / 1e5} |" for i in range(ROWS // 2 - 1)]
    path = tmp_path / "rows.md"
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
    took = time.perf_counter() - began
    print(f"\n{ROWS} rows: {read:.2f} s to read and check, {took:.2f} s to run")
    assert took < 5.0
