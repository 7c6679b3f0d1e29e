"""Test results as people and programs read them."""

from __future__ import annotations

from typing import Any

from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.model.values import to_json
from rrp_sheets.render.measure import clean
from rrp_sheets.testing.judge import seconds
from rrp_sheets.testing.results import CaseResult, RowResult
from rrp_sheets.testing.run import TestReport

MOST_FAILURES = 20  # shown of one test; the rest are counted


def failure_lines(result: CaseResult) -> list[str]:
    """Return the failures of a test in words, a few lines for each row."""
    name = result.case.name
    unsent: list[str] = [
        Phrase("{name} row {row}: this could not be sent: {reason}", name=name, row=row, reason=reason)
        for row, reason in result.broken.items()
    ]
    lines = unsent[:MOST_FAILURES]
    if len(unsent) > MOST_FAILURES:
        lines.append(Phrase("and {n} more rows that could not be sent", n=len(unsent) - MOST_FAILURES))
    for row in result.failed_rows[:MOST_FAILURES]:
        lines += [
            _headline(row),
            Phrase("  got: {message}", message=row.got),
            *(Phrase("  {message}", message=h) for h in row.hints),
        ]
    if len(result.failed_rows) > MOST_FAILURES:
        lines.append(Phrase("and {n} more rows", n=len(result.failed_rows) - MOST_FAILURES))
    return lines


def _headline(row: RowResult) -> str:
    expectation = row.row.expectation
    assert expectation is not None
    return Phrase(
        "{address} ({ms}, {name}): expected {text}{notes}", address=row.row.address, ms=seconds(row.row.time_us),
        name=row.row.name, text=clean(expectation.text[:200]),
        notes=f" – {clean(row.row.notes[:120])}" if row.row.notes else "",
    )  # fmt: skip


def fault_lines(result: CaseResult) -> list[str]:
    """The formulas that failed in a test, each row once with how often."""
    first: dict[str, tuple[str, int]] = {}
    counts: dict[str, int] = {}
    for fault in result.faults:
        first.setdefault(fault.row, (fault.message, fault.us))
        counts[fault.row] = counts.get(fault.row, 0) + 1
    return [
        f"{row} could not be worked out at {seconds(us)}{_more(counts[row] - 1)}: {message}"
        for row, (message, us) in first.items()
    ]


def _more(count: int) -> str:
    return f" and {count} more {'time' if count == 1 else 'times'}" if count else ""


def counted(result: CaseResult) -> str:
    """`12 rows hold`, `2 of 14 rows do not hold`, `1 of 10 rows does not hold`, `nothing is expected`."""
    if result.idle:
        return "nothing is expected, so nothing is tested"
    failed, every = len(result.failed_rows) + len(result.broken), len(result.rows) + len(result.broken)
    if failed:
        return f"{failed} of {every} {'row' if every == 1 else 'rows'} {'does' if failed == 1 else 'do'} not hold"
    return f"{every} {'row holds' if every == 1 else 'rows hold'}"


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
