"""Test results as lines, JSON, JUnit and marble diagrams."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import PurePath
from typing import Any
from xml.etree import ElementTree as ET

from rrp_sheets.checks import Checked
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model.values import to_json
from rrp_sheets.render.marble_diagram import MarbleDiagram, make_score, upstream
from rrp_sheets.render.style import clean
from rrp_sheets.render.texts import texts
from rrp_sheets.testing.judge import CaseResult, Fault, RowResult, seconds
from rrp_sheets.testing.run import TestReport
from rrp_sheets.texts import N_

MOST_FAILURES = 20  # shown of one test; the rest are counted


def failure_lines(result: CaseResult) -> list[str]:
    """Return the failures of a test in words, a few lines for each row."""
    name = result.case.name
    unsent: list[str] = [
        N_("{name} row {row} could not be sent: {reason}", name=name, row=row, reason=reason)
        for row, reason in result.broken.items()
    ]
    lines = unsent[:MOST_FAILURES]
    if len(unsent) > MOST_FAILURES:
        lines.append(N_("and {n} more rows that could not be sent", n=len(unsent) - MOST_FAILURES))
    for row in result.failed_rows[:MOST_FAILURES]:
        lines += [_headline(row), N_("  got: {message}", message=row.got)]
        lines += [N_("  {message}", message=hint) for hint in row.hints]
    if len(result.failed_rows) > MOST_FAILURES:
        lines.append(N_("and {n} more rows", n=len(result.failed_rows) - MOST_FAILURES))
    return lines


def _headline(row: RowResult) -> str:
    expectation = row.row.expectation
    assert expectation is not None
    return N_(
        "{address} ({ms}, {name}): expected {text}{notes}", address=row.row.address, ms=seconds(row.row.time_us),
        name=row.row.name, text=clean(expectation.text[:200]),
        notes=f" – {clean(row.row.notes[:120])}" if row.row.notes else "",
    )  # fmt: skip


def fault_lines(result: CaseResult) -> list[str]:
    """The formulas that failed in a test, each row once with how often."""
    first = {fault.row: fault for fault in reversed(result.faults)}
    counts = Counter(fault.row for fault in result.faults)
    return [_fault(first[row], count - 1) for row, count in counts.items()]


def _fault(first: Fault, more: int) -> str:
    row, ms, message = first.row, seconds(first.us), first.message
    if not more:
        return N_("{row} could not be calculated at {ms}: {message}", row=row, ms=ms, message=message)
    return N_(
        "{row} could not be calculated at {ms} and {n} more time: {message}"
        if more == 1
        else "{row} could not be calculated at {ms} and {n} more times: {message}",
        row=row, ms=ms, n=more, message=message,
    )  # fmt: skip


def counted(result: CaseResult) -> str:
    """`12 rows hold`, `2 of 14 rows do not hold`, `1 of 10 rows does not hold`, `nothing is expected`."""
    if result.idle:
        return N_("nothing is expected, so nothing is tested")
    failed, every = len(result.failed_rows) + len(result.broken), len(result.rows) + len(result.broken)
    if failed > 1:
        return N_("{failed} of {n} rows fail", failed=failed, n=every)
    if failed:
        return N_("1 of {n} row fails" if every == 1 else "1 of {n} rows fails", n=every)
    return N_("{n} row passes" if every == 1 else "{n} rows pass", n=every)


def as_dict(report: TestReport) -> dict[str, Any]:
    """As `test --json` prints it."""
    return {
        "passed": report.passed,
        "stopped": report.stopped,
        "tests": [
            {
                "sheet": c.case.name,
                "passed": c.passed,
                "seconds": round(c.seconds, 4),
                "rows": [_row(r) for r in c.rows],
                "not_sent": [{"row": n, "message": words} for n, words in c.broken.items()],
                "errors": [{"t": f.us / 1e6, "row": f.row, "message": f.message} for f in c.faults],
            }
            for c in report.cases
        ],
    }


def _row(result: RowResult) -> dict[str, Any]:
    row, event = result.row, result.event
    assert row.expectation is not None
    entry: dict[str, Any] = {
        "sheet": row.address.sheet, "cell": row.address.cell, "time_ms": row.time_us / 1000, "stream": row.name,
        "expected": row.expectation.text, "notes": row.notes, "passed": result.passed,
    }  # fmt: skip
    if event is not None:
        entry["came"] = {"t": event.us / 1e6, "row": event.row, "value": to_json(event.value)}
    if not result.passed:
        entry |= {"got": result.got, "hints": list(result.hints)}
    return entry


_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(report: TestReport) -> bytes:
    """A suite for every test sheet, a case for every row that expects something or could not send."""
    name = PurePath(report.checked.workbook.source).name or "workbook"
    suites = [_suite(case, name) for case in report.cases]
    every = ET.Element("testsuites", {
        "name": _clean(name),
        "tests": str(sum(int(s.get("tests", 0)) for s in suites)),
        "failures": str(sum(int(s.get("failures", 0)) for s in suites)),
        "errors": str(sum(int(s.get("errors", 0)) for s in suites)),
        "time": f"{sum(c.seconds for c in report.cases):.3f}",
    })  # fmt: skip
    every.extend(suites)
    ET.indent(every)
    made: bytes = ET.tostring(every, encoding="utf-8", xml_declaration=True)
    return made + b"\n"


def _suite(result: CaseResult, workbook: str) -> ET.Element:
    suite = ET.Element("testsuite", {
        "name": _clean(result.case.name),
        "tests": str(len(result.rows) + len(result.broken)),
        "failures": str(len(result.failed_rows)),
        "errors": str(len(result.broken)),
        "skipped": "0",
        "time": f"{result.seconds:.3f}",
    })  # fmt: skip
    of = _clean(f"{workbook}.{result.case.name}")
    for number, words in result.broken.items():
        case = ET.SubElement(suite, "testcase", {"classname": of, "name": f"row {number}: sends", "time": "0"})
        ET.SubElement(case, "error", {"type": "send", "message": _clean(words)}).text = _clean(words)
    for row in result.rows:
        name = f"row {row.row.row}: {row.row.name} at {seconds(row.row.time_us)}: {_expected(row)}"
        case = ET.SubElement(suite, "testcase", {"classname": of, "name": _clean(name), "time": "0"})
        if not row.passed:
            words = f"{row.row.address}: expected {_expected(row)}, got {row.got}."
            failure = ET.SubElement(case, "failure", {"type": "expectation", "message": _clean(words)})
            failure.text = _clean("\n".join(filter(None, (words, *row.hints, row.row.notes))))
    return suite


def _expected(row: RowResult) -> str:
    return row.row.expectation.text if row.row.expectation else ""


def _clean(text: str) -> str:
    return _NO_XML.sub("\ufffd", text)


_MOST_LANES = 10
_BEFORE_US, _AFTER_US = 3_000_000, 500_000
_TOGETHER_US = 5_000_000  # rows that fail so soon after the first are shown with it


def scores(checked: Checked, result: CaseResult) -> list[MarbleDiagram]:
    """Return the events of a test as a marble diagram for each behaviour in which something came."""
    every = (_score(checked, result, behaviour) for behaviour in checked.graph.behaviours)
    found = (score for score in every if any(lane.marbles for lane in score.lanes))
    return [replace(score, title=f"{result.case.name}: {score.title}") for score in found]


def _score(checked: Checked, result: CaseResult, behaviour: BehaviourGraph, language: str = "") -> MarbleDiagram:
    events = [(e.us, e.stream, e.row, e.value) for e in result.events]
    errors = [(f.us, f.row, f.message) for f in result.faults]
    score = make_score(checked.graph, behaviour, events, errors, result.ended_us, language or checked.run.language)
    words = texts(score.language)
    marks = tuple((r.row.time_us, words.get("behaviour.row", n=r.row.row)) for r in result.failed_rows)
    return replace(score, marks=marks)


def around_failures(checked: Checked, result: CaseResult, language: str = "") -> MarbleDiagram:
    """Draw the time around the first rows that do not hold: their streams and those that these come from."""
    nothing = MarbleDiagram("", (), 0, 0)
    if not result.failed_rows:
        return nothing
    first_us = result.failed_rows[0].row.time_us
    failed = [r.row for r in result.failed_rows if r.row.time_us <= first_us + _TOGETHER_US]
    behaviour = _home(checked, failed[0].stream)
    if behaviour is None:
        return nothing
    begin = max(0, first_us - _BEFORE_US)
    sent = [r.time_us for r in result.case.rows if r.sending and r.time_us <= first_us]
    begin = min(begin, max(sent, default=begin))
    last = max(row.time_us for row in failed)
    ids = upstream(behaviour, dict.fromkeys(row.stream for row in failed), _MOST_LANES)
    until = min(last + _AFTER_US, max(result.ended_us, last))
    return _score(checked, result, behaviour, language).only(ids).between(begin, until)


def _home(checked: Checked, stream: str) -> BehaviourGraph | None:
    """The behaviour whose rows give a stream, or else one whose rows use it."""
    behaviours = checked.graph.behaviours
    makers = (b for b in behaviours if any(s.output == stream for s in b.steps))
    return next(makers, next((b for b in behaviours if any(stream in s.inputs for s in b.steps)), None))
