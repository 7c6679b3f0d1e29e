"""Closing a trace whose engine was ended: the cut line goes, and a summary of what is there is added."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

from rrp_sheets.errors import RunBroken
from rrp_sheets.runs.view import RunStart, Summary


def close_trace(start: RunStart, row: str, error: RunBroken) -> Summary:
    """Make a trace readable to its end.

    Args:
        start: of the run.
        row: that was being worked out.
        error: why the run broke off.
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
    summary = Summary(dict(events), dict(errors), commands, last, 0.0, "broken", row, "", error.message, error.remedy)
    with path.open("r+b") as file:
        file.truncate(whole)
        file.seek(whole)
        file.write(json.dumps({"type": "summary", **summary.as_dict(wall=False)}, ensure_ascii=False).encode() + b"\n")
    return summary


def _told(entry: dict[str, Any], last: float) -> Summary:
    """The summary that the run's process had written before it ended."""
    told = {name: entry.get(name, "") for name in ("stopped_by", "why", "remedy")}
    return Summary(
        entry["events"], entry["errors"], entry["actuator_commands"], last, 0.0, entry["ended"], entry.get("by", ""),
        **told,
    )  # fmt: skip
