"""Cost of the frame engine beside asteval's own `run(node)` on the same formulas and values.

Measured in one process, one thread, without a simulator and without a display. The ratios hold for this machine's
moment; the absolute figures do not travel. Not measured: reading and checking, several behaviours at once.
"""

from __future__ import annotations

import ast
import statistics
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from asteval import Interpreter
from play import example, rows
from recorded import recorded_engine

from rrp_sheets import api
from rrp_sheets.engine.engine import FrameEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.trace import TraceWriter
from rrp_sheets.formulas import read_formula
from rrp_sheets.formulas.formula import Formula
from rrp_sheets.model.values import Record
from rrp_sheets.resources import bundled

CHAIN = rows("| Red ball | map | redBall.distance | Distance |\n| Distance | filter | distance < 20 | Close |\n"
             "| Close | subscribe | | Print |")  # fmt: skip
ROUNDS = 5


def checked(source):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "b.md"
        path.write_text(source, encoding="utf-8")
        result = api.check(path)
    assert not result.report.errors
    return result


def events(seconds):
    """A ball at 10 Hz that comes and goes, and a head's yaw at 30 Hz, by frames."""
    balls = [example("Red ball", x=0.01 * (i % 20), distance=0.3 + 0.05 * (i % 40)) for i in range(40)]
    for frame in range(int(seconds * 30)):
        now = [("headyaw", 0.001 * (frame % 300))]
        if frame % 3 == 0:
            now.insert(0, ("redball", balls[frame // 3 % 40]))
        yield frame * 1_000_000 // 30, now


class Fields:
    """A record as plain asteval would see it: attributes."""

    def __init__(self, record):
        for name, key in record.type.keys.items():
            setattr(self, name, plain(record.values[key]))


def plain(value):
    return Fields(value) if isinstance(value, Record) else value


def calls_of(plan, frames, monkeypatch):
    """Every evaluation of a run: its tree, its symbol table."""
    log = []
    prepare = Formula.prepare

    def spy(self, interpreter, picker=None):
        inner = prepare(self, interpreter, picker)
        node = read_formula(self.text)
        for part in ast.walk(node):  # plain asteval knows fields by their exact spelling only
            if isinstance(part, ast.Attribute):
                part.attr = part.attr.casefold()

        def call(*values):
            log.append((node, dict(zip(self.names, map(plain, values), strict=True))))
            return inner(*values)

        return call

    with monkeypatch.context() as patch:
        patch.setattr(Formula, "prepare", spy)
        engine = FrameEngine(plan)
        for now, arrivals in frames:
            engine.settle(now, arrivals)
    return log


def time_asteval(log):
    interpreter = Interpreter(minimal=True, use_numpy=False)
    began = time.perf_counter()
    for node, symbols in log:
        interpreter.symtable = symbols
        interpreter.error = []
        interpreter.run(node)
    assert not interpreter.error
    return time.perf_counter() - began


def time_engine(plan, frames, trace=None):
    engine = FrameEngine(plan, None) if trace is None else recorded_engine(plan, trace)
    began = time.perf_counter()
    for now, arrivals in frames:
        engine.settle(now, arrivals)
        if trace is not None:
            trace.flush()
    return time.perf_counter() - began


def compare(name, source, frames, monkeypatch, limit):
    result = checked(source) if isinstance(source, str) else api.check(source)
    plan = make_plan(result)
    log = calls_of(plan, frames, monkeypatch)
    count = sum(len(a) for _, a in frames)
    measured = []
    for _ in range(ROUNDS):
        with TemporaryDirectory() as folder:
            trace = TraceWriter(Path(folder) / "trace.jsonl", plan, {})
            measured.append((time_asteval(log), time_engine(plan, frames), time_engine(plan, frames, trace)))
            trace.close({})
    bare, engine, traced = (statistics.median(m) for m in zip(*measured, strict=True))
    us = 1e6 / count
    print(f"\n{name}: per sensor event asteval alone {bare * us:.2f} µs, engine {engine * us:.2f} µs "
          f"({engine / bare:.2f}×, limit {limit}×), with the trace {traced * us:.2f} µs ({traced / bare:.2f}×)")  # fmt: skip
    assert engine / bare <= limit


def test_chain(monkeypatch):
    balls = [example("Red ball", distance=float(i % 40)) for i in range(40)]
    frames = [(i * 33_333, [("redball", balls[i % 40])]) for i in range(20_000)]
    compare("chain (map, filter, subscribe)", CHAIN, frames, monkeypatch, 1.8)


def test_complex_tracking(monkeypatch):
    book = bundled("workbooks", "complex-tracking-fixed.xlsx")
    compare("complex tracking", book, list(events(300)), monkeypatch, 1.8)


def test_ten_minutes_of_complex_tracking():
    plan = make_plan(api.check(bundled("workbooks", "complex-tracking.xlsx")))
    frames = list(events(600))
    seconds = statistics.median(time_engine(plan, frames) for _ in range(3))
    print(f"\n600 s of complex tracking in virtual time: {seconds:.2f} s (limit 1.5 s)")
    assert seconds <= 1.5
