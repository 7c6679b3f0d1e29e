"""Time to compare two long workbooks, reading and checking both included.

Seconds of the processor: other programs on the machine do not count.
"""

from __future__ import annotations

import time

import pytest

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.compare import compare
from rrp_sheets.resources import bundled


def workbook(path, count, change=lambda i, row: row):
    import xlsxwriter

    book = xlsxwriter.Workbook(str(path))
    sheet = book.add_worksheet("Long")
    sheet.write_row(0, 0, ["Input streams", "Connector", "Formula", "Output stream"])
    for i in range(1, count + 1):
        first, last = i % 50 == 1, i % 50 == 0
        row = ["Red ball" if first else f"Stream {i - 1}", "subscribe" if last else "map", "", "Eye brightness"]
        if not last:
            value = "redBall.distance" if first else f"stream{i - 1}"
            row[2:] = [f"IF({value} > {i}, {value} * 2, abs({value}))", f"Stream {i}"]
        sheet.write_row(i, 0, change(i, row))
    book.close()


def few(i, row):
    return [row[0], row[1], row[2].replace("* 2", "* 3") if i % 100 == 7 else row[2], row[3]]


def every(i, row):
    return [row[0], row[1], row[2].replace("* 2", "* 3"), row[3]]


def renamed(i, row):
    return [cell.replace("Stream", "Flow").replace("stream", "flow") for cell in row]


def other(i, row):
    name = row[3].replace("Stream", "Sum")
    return [row[0].replace("Stream", "Sum"), row[1], f"MAX(value, {i}) + {i * 7}" if row[2] else "", name]


@pytest.mark.parametrize("change", [few, every, renamed, other])
@pytest.mark.parametrize(("count", "limit"), [(1_000, 1.0), (9_999, 16.0)])
def test_diff_of_many_rows(tmp_path, count, limit, change):
    paths = tmp_path / "before.xlsx", tmp_path / "after.xlsx"
    workbook(paths[0], count)
    workbook(paths[1], count, change)
    api.diff(*[bundled("workbooks", "greeter.xlsx")] * 2)  # what is loaded once is loaded
    began = time.process_time()
    first, second = (api.read(p) for p in paths)
    read = time.process_time() - began
    checked = [(r, check_workbook(r.workbook, r.report, lints=False)) for r in (first, second)]
    check = time.process_time() - began - read
    comparison = compare(*checked)
    seconds = time.process_time() - began
    print(f"\ndiff of {count} rows, {change.__name__}: {seconds:.2f} s (reading {read:.2f}, checking {check:.2f}, "
          f"limit {limit} s), {len(comparison.changes)} changes")  # fmt: skip
    assert seconds <= limit and comparison.changes
