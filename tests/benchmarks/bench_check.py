"""How long reading and checking take, and how quickly the commands start.

Wall time of this machine, including reading the .xlsx from disk. Not measured: a cold disk cache.
"""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from rrp_sheets import api
from rrp_sheets.resources import bundled


def workbook(path, count):
    import xlsxwriter

    book = xlsxwriter.Workbook(str(path))
    sheet = book.add_worksheet("Long")
    sheet.write_row(0, 0, ["Input streams", "Connector", "Formula", "Output stream"])
    for i in range(1, count):
        source = "Red ball" if i % 50 == 1 else f"Stream {i - 1}"
        formula = (
            "redBall.distance" if i % 50 == 1 else f"IF(stream{i - 1} > {i}, stream{i - 1} * 2, abs(stream{i - 1}))"
        )
        output = f"Stream {i}"
        if i % 50 == 0:
            sheet.write_row(i, 0, [source, "subscribe", "", "Eye brightness"])
        else:
            sheet.write_row(i, 0, [source, "map", formula, output])
    book.close()


@pytest.mark.parametrize(("count", "limit"), [(1_000, 1.0), (10_000, 10.0)])
def test_check_of_many_rows(tmp_path, count, limit):
    path = tmp_path / "long.xlsx"
    workbook(path, count)
    began = time.perf_counter()
    report = api.check(path).report
    seconds = time.perf_counter() - began
    print(f"\ncheck of {count} rows: {seconds:.2f} s (limit {limit} s), {len(report.errors)} errors")
    assert seconds <= limit and not report.errors


@pytest.mark.parametrize(
    ("arguments", "limit"),
    [(["--help"], 0.3), (["check", str(bundled("workbooks", "simple-tracking.xlsx"))], 1.0)],
)
def test_commands_start_quickly(arguments, limit):
    command = [sys.executable, "-c", "from rrp_sheets.cli.main import main; main()", *arguments]
    times = []
    for _ in range(5):
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - began)
    best = sorted(times)[2]
    print(f"\nrrp-sheets {arguments[0]}: {best:.2f} s (limit {limit} s)")
    assert best <= limit
