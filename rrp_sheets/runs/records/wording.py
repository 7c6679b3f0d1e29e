"""Lengths and ends of runs in words, for lists and pages."""

from __future__ import annotations

from rrp_sheets.runs.records.metadata import RunMetadata


def length(seconds: float) -> str:
    """Format a length of time.

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
    """Format a moment of a run.

    >>> clock(3.0333), clock(83.5)
    ('0:03.0', '1:23.5')
    """
    tenths = round(seconds * 10)
    return f"{tenths // 600}:{tenths % 600 // 10:02}.{tenths % 10}"


def ended(facts: RunMetadata) -> str:
    """Describe the end of a run in words."""
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
