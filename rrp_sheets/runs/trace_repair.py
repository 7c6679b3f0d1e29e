"""Closing a trace whose engine was ended: the cut line goes, and a summary of what is there is added."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rrp_sheets.engine.trace import notice_entry
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Notice
from rrp_sheets.runs.view import RunStart, Summary


def close_trace(
    start: RunStart, row: str, error: RunBroken | None, notices: Sequence[Notice] = (), by: str = ""
) -> Summary:
    """Make a trace readable to its end.

    Args:
        start: of the run.
        row: that was being worked out.
        error: why the run broke off; None when it was stopped.
        notices: what is still to be told.
        by: who stopped it, if somebody did and it is known.
    """
    path = start.folder / "trace.jsonl"
    labels = dict.fromkeys(start.streams.values(), 0)
    events: Counter[str] = Counter(labels)
    errors: Counter[str] = Counter()
    last = 0.0
    whole = 0
    with path.open("rb") as file:
        for raw in file:
            if not raw.endswith(b"\n"):
                break  # cut off in the middle
            whole += len(raw)
            entry = json.loads(raw)
            last = max(last, entry.get("t", 0.0))
            if entry.get("type") == "summary":
                return _told(entry, last)
            if "value" in entry:
                events[entry["stream"]] += 1
            elif "error" in entry or entry.get("happening") == "error":
                errors[entry.get("row") or entry.get("stream", "")] += 1
    commands = {name: events[name] for name in start.actuators.values()}
    counts = (dict(events), dict(errors), commands, last, 0.0)
    if error is None:
        summary = Summary(*counts, "stopped", "", by)
    else:
        summary = Summary(*counts, "broken", row, by, error.message, error.remedy)
    lines = [notice_entry(round(last * 1e6), notice, start.streams) for notice in notices]
    lines.append({"type": "summary", **summary.as_dict(wall=False)})
    with path.open("r+b") as file:
        file.truncate(whole)
        file.seek(whole)
        file.write(
            "".join(json.dumps(entry, ensure_ascii=False) + "\n" for entry in lines).encode("utf-8", "backslashreplace")
        )
    return summary


def _told(entry: dict[str, Any], last: float) -> Summary:
    """The summary that the run's process had written before it ended."""
    told = {name: entry.get(name, "") for name in ("stopped_by", "why", "remedy")}
    return Summary(
        entry["events"], entry["errors"], entry["actuator_commands"], last, 0.0, entry["ended"], entry.get("by", ""),
        **told,
    )  # fmt: skip
