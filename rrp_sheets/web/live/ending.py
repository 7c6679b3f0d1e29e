"""How a run ended, as its pages are told."""

from __future__ import annotations

from typing import Any

from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.runs.formatting import clock
from rrp_sheets.runs.run_process import RunOutcome
from rrp_sheets.runs.view import Summary
from rrp_sheets.web.browserwords import in_browser

Told = dict[str, Any]


def lost() -> Told:
    """Nobody knows why."""
    return {"how": "broken", "words": "The run was lost by a fault of this program.", "broken": True,
            "remedy": "The terminal where the server runs tells more."}  # fmt: skip


def failed(error: SheetsError) -> Told:
    """It could not begin, or left no record."""
    return {"how": "broken", "words": error.message, "broken": True, "remedy": in_browser(error.remedy)}


def in_words(ended: RunOutcome, by: str) -> Told:
    """Of a run that has come to its end; `by`: who stopped it, or an empty text."""
    if ended.findings:
        count = sum(d.severity.value == "error" for d in ended.findings)
        text = f"It did not start: the workbook has {count} error{'' if count == 1 else 's'}."
        return {"how": "errors", "words": text, "broken": False, "remedy": "Mend them, and press Run again."}
    if ended.result is None:
        return {"how": "stopped", "words": f"Stopped{_by(by)} before it began.", "broken": False, "remedy": ""}
    told = at_rest(ended.result.summary, ended.result.broken, by)
    return told if told["broken"] else {**told, "remedy": " ".join(ended.result.problems)}


def at_rest(summary: Summary, broken: RunBroken | None, by: str) -> Told:
    """Of a run whose robot is at rest, and whose files are still being written.

    >>> at_rest(Summary(simulated=9.13, ended="stopped"), None, "Aya")["words"]
    'Stopped by Aya at 0:09.1.'
    """
    at = clock(round(summary.simulated * 1e6))
    told = {
        "time": f"The time was over at {at}.", "stopped": f"Stopped{_by(by)} at {at}.",
        "end run": f"Row {summary.ended_by} ended the run at {at}.",
    }  # fmt: skip
    text = f"The run broke off at {at}: {broken.message}" if broken else told.get(summary.ended, f"Ended at {at}.")
    return {"how": "broken" if broken else summary.ended, "words": text, "broken": broken is not None,
            "remedy": broken.remedy if broken else ""}  # fmt: skip


def _by(name: str) -> str:
    return f" by {name}" if name else ""
