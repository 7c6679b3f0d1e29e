"""Test results as JUnit XML, for programs that collect them."""

from __future__ import annotations

import re
from pathlib import PurePath
from xml.etree import ElementTree as ET

from rrp_sheets.testing.judge import seconds
from rrp_sheets.testing.results import CaseResult, RowResult
from rrp_sheets.testing.run import TestReport

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
        case = ET.SubElement(suite, "testcase", {"classname": of, "name": _clean(_name(row)), "time": "0"})
        if not row.passed:
            words = f"{row.row.address}: expected {_expected(row)}, got {row.got}."
            failure = ET.SubElement(case, "failure", {"type": "expectation", "message": _clean(words)})
            failure.text = _clean("\n".join(filter(None, (words, *row.hints, row.row.notes))))
    return suite


def _name(row: RowResult) -> str:
    return f"row {row.row.row}: {row.row.name} at {seconds(row.row.time_us)}: {_expected(row)}"


def _expected(row: RowResult) -> str:
    return row.row.expectation.text if row.row.expectation else ""


def _clean(text: str) -> str:
    """Without the characters that XML cannot hold."""
    return _NO_XML.sub("\ufffd", text)
