"""Formatting of runs for lists, and of times for people."""

from __future__ import annotations

from collections.abc import Collection
from datetime import date, datetime, timedelta

from rrp_sheets.runs.records.metadata import RunMetadata
from rrp_sheets.runs.records.wording import ended, length
from rrp_sheets.web.records.record_pages import RunLine
from rrp_sheets.web.workbook_repository import addressable, printable

MODES = ("simulated", "pilot", "real")
_STATES = {"time": "good", "end run": "good", "stopped": "stopped", "going": "going", "unreadable": "unreadable"}


def when(moment: datetime | None, today: date | None = None) -> str:
    """Format a time relative to today.

    >>> when(datetime(2026, 11, 21, 9, 5), date(2026, 11, 21)), when(datetime(2026, 11, 2, 9, 5), date(2026, 11, 21))
    ('today 09:05', '2 November, 09:05')
    """
    if moment is None:
        return ""
    today = today or datetime.now().date()
    if moment.date() == today:
        return f"today {moment:%H:%M}"
    if moment.date() == today - timedelta(days=1):
        return f"yesterday {moment:%H:%M}"
    year = "" if moment.year == today.year else f" {moment.year}"
    return f"{moment.day} {moment:%B}{year}, {moment:%H:%M}"


def line_of(facts: RunMetadata, books: Collection[str]) -> RunLine:
    """Format a run for a list; `books` are the workbooks of the folder."""
    why = " ".join(filter(None, (facts.why, facts.remedy)))
    if facts.ended == "cut":
        why = "The program or the computer ended in the middle. What was recorded until then can be looked at."
    moment = when(facts.began) or ("" if facts.readable else printable(facts.run))
    return RunLine(
        run=printable(facts.run), opens=facts.readable and addressable(facts.run), when=moment or printable(facts.run),
        workbook=facts.workbook, book=facts.workbook if facts.workbook in books else "",
        who=", ".join(filter(None, (facts.participant, facts.condition))), operator=facts.operator,
        mode=facts.mode if facts.mode in MODES else "", length=length(facts.seconds) if facts.seconds else "",
        state=_STATES.get(facts.ended, "broken"), ended=ended(facts), why=why, errors=sum(facts.errors.values()),
    )  # fmt: skip
