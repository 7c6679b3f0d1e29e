"""Times, lengths and ends of runs in words."""

from __future__ import annotations

from collections.abc import Collection
from datetime import date, datetime, timedelta

from rrp_sheets.runs.records.facts import Facts
from rrp_sheets.web.library import addressable, printable
from rrp_sheets.web.records.pages import RunLine

MODES = ("simulated", "pilot", "real")
_STATES = {"time": "good", "end run": "good", "stopped": "stopped", "going": "going", "unreadable": "unreadable"}


def when(moment: datetime | None, today: date | None = None) -> str:
    """A time for people.

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


def length(seconds: float) -> str:
    """A length of time.

    >>> length(8.24), length(222), length(4000)
    ('8.2 s', '3:42 min', '1:06:40 h')
    """
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02}:{whole % 60:02} h"


def clock(seconds: float) -> str:
    """A moment of a run.

    >>> clock(3.0333), clock(83.5)
    ('0:03.0', '1:23.5')
    """
    tenths = round(seconds * 10)
    return f"{tenths // 600}:{tenths % 600 // 10:02}.{tenths % 10}"


def ended(facts: Facts) -> str:
    """How a run ended."""
    by = facts.ended_by
    match facts.ended:
        case "time":
            return "its time was over"
        case "end run":
            return f"ended by the row {by}" if by else "ended by a row"
        case "stopped":
            return f"stopped by {by}" if by else "stopped by hand"
        case "broken":
            return f"broke off at the row {by}" if by else "broke off"
        case "going":
            return "is going"
        case "unreadable":
            return "cannot be read"
    return "broke off: the record has no end"


def line_of(facts: Facts, books: Collection[str]) -> RunLine:
    """A run as the lists show it; `books`: the workbooks of the folder."""
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
