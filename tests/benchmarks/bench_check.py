"""Time to read and check workbooks, and to start the commands.

Checks: seconds of the processor (other programs do not count), reading the .xlsx from disk included, and the memory
at its peak. Commands: wall time. Not measured: a cold disk cache.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest

from rrp_sheets.resources import bundled

HEADER = ["Input streams", "Connector", "Formula", "Output stream"]


def chains(count):
    rows = []
    for i in range(1, count):
        first = i % 50 == 1
        value = "redBall.distance" if first else f"stream{i - 1}"
        formula = value if first else f"IF({value} > {i}, {value} * 2, abs({value}))"
        source = "Red ball" if first else f"Stream {i - 1}"
        last = [source, "subscribe", "", "Eye brightness"]
        rows.append(last if i % 50 == 0 else [source, "map", formula, f"Stream {i}"])
    return rows


def mixed(count):
    rows = []
    for k in range(1, count // 10 + 1):
        rows += [
            ["Red ball", "map", "redBall.distance", f"Far {k}"],
            [f"Far {k}", "filter", f"far{k} < {1 + k % 7}", f"Near {k}"],
            [f"Near {k}", "throttle", "200 ms", f"Slow {k}"],
            ["Green ball", "map", "greenBall.x", f"Side {k}"],
            [f"Slow {k}, Side {k}", "combineLatest", f"slow{k} + side{k} * {k}", f"Both {k}"],
            [f"Both {k}", "accumulate", "MAX(total; value)", f"Most {k}"],
            [f"Most {k}, Near {k}", "merge", "", f"Any {k}"],
            [f"Any {k}", "changes", "", f"New {k}"],
            [f"New {k}", "map", f"IF(new{k} > {k}; CLAMP(new{k} / 10; 0; 1); 0.5)", f"Out {k}"],
            [f"Out {k}", "subscribe", "", "Eye brightness"],
        ]
    return rows[: count - 1]


def diamonds(count):
    rows = [["Red ball", "map", "redBall.distance", "S 0"]]
    for i in range(count // 3):
        rows.append([f"S {i}", "map", f"s{i} + 1", f"Left {i}"])
        rows.append([f"S {i}", "filter", f"s{i} > {i}", f"Right {i}"])
        rows.append([f"Left {i}, Right {i}", "combineLatest", f"left{i} + right{i}", f"S {i + 1}"])
    return rows


def faulty(count):
    kinds = [
        lambda i: [f"Sensorr {i}", "map", f"sensorr{i} * 2", f"Val {i}"],
        lambda i: ["Red ball", "map", f"redBal{i}.distanse + unknownName{i}", f"Vall {i}"],
        lambda i: ["Red ball", f"mapp{i}", "1", f"Vbl {i}"],
        lambda i: ["Red ball", "subscribe", "", f"Eye brightnes{i}"],
        lambda i: ["Red ball", "filter", f"redBall.distanse{i} < 2", f"Vcl {i}"],
    ]
    return [kinds[i % 5](i) for i in range(count)]


def unknown(count):
    return [[f"Streem {i}", "map", f"streem{i} + other{i}", f"Stream {i}"] for i in range(count)]


def same(count):
    return [["Red ball", "subscribe", "redBall.distance", "Eye brightness"]] * count


def write(path, sheets, helpers=()):
    import xlsxwriter

    book = xlsxwriter.Workbook(str(path))
    for name, rows in sheets.items():
        sheet = book.add_worksheet(name)
        for i, row in enumerate([HEADER, *rows]):
            sheet.write_row(i, 0, row)
    if helpers:
        sheet = book.add_worksheet("Helpers")
        for i, row in enumerate([["Name", "Inputs", "Formula"], *helpers]):
            sheet.write_row(i, 0, row)
    book.close()


def measured(path, limit, megabytes=250):
    """Check in a process of its own, so that its peak of memory is seen, and its limit kept."""
    command = [sys.executable, "-c", _MEASURE, str(path)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    seconds, memory, findings, errors = json.loads(printed)
    print(f"\ncheck of {path.stem}: {seconds:.2f} s of the processor (limit {limit} s), {memory} MB, "
          f"{findings} findings, {errors} errors")  # fmt: skip
    assert seconds <= limit and memory <= megabytes
    return errors


_MEASURE = """
import json, resource, sys, time
from rrp_sheets import api
from rrp_sheets.resources import bundled
api.check(bundled("workbooks", "greeter.xlsx"))  # what is loaded once is loaded
began = time.process_time()
report = api.check(sys.argv[1]).report
seconds = time.process_time() - began
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
print(json.dumps([seconds, memory, len(report), len(report.errors)]))
"""


@pytest.mark.parametrize(
    ("rows", "count", "limit"),
    [(chains, 1_000, 0.5), (mixed, 1_000, 0.5), (diamonds, 1_000, 0.8), (chains, 10_000, 5.0), (mixed, 10_000, 5.0),
     (same, 4_000, 2.0)],
)  # fmt: skip
def test_check_of_many_rows(tmp_path, rows, count, limit):
    path = tmp_path / f"{rows.__name__}-{count}.xlsx"
    write(path, {"Long": rows(count)})
    errors = measured(path, limit)
    assert not errors or rows is diamonds  # their chain is longer than is allowed, which is told


@pytest.mark.parametrize(("rows", "count", "limit"), [(faulty, 5_000, 3.0), (unknown, 5_000, 3.0)])
def test_check_of_many_mistakes(tmp_path, rows, count, limit):
    path = tmp_path / f"{rows.__name__}-{count}.xlsx"
    write(path, {"Long": rows(count)})
    assert measured(path, limit) >= count


def test_check_of_many_helpers(tmp_path):
    path = tmp_path / "helpers-300.xlsx"
    called = [[f"h{i}", "x", f"h{i + 1}(x) + h{i + 1}(x)" if i < 299 else "x"] for i in range(300)]
    write(path, {"Long": [["Red ball", "map", "h0(redBall.distance)", "Value"]]}, called)
    assert measured(path, 0.5) == 1


def test_check_of_many_sheets(tmp_path):
    path = tmp_path / "sheets-60.xlsx"
    write(path, {f"Sheet {i}": mixed(51) for i in range(60)})
    assert not measured(path, 1.5)


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
