"""A comparison as data: what `diff --json` prints, and what worker processes exchange."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from rrp_sheets.compare.as_text import say
from rrp_sheets.compare.changes import Change, ComparedWorkbook, Comparison
from rrp_sheets.compare.tokens import FormulaPiece

SCHEMA = 1  # grows when an entry changes its meaning or goes


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """Return the data that `diff --json` prints."""
    changes = []
    for c in comparison.changes:
        entry = {**asdict(c), "row_before": c.rows[0] or None, "row_after": c.rows[1] or None, "text": say(c)}
        del entry["rows"]
        entry["pieces"] = [{"kind": p.kind, "text": p.text} for p in c.pieces]
        changes.append(entry)
    return {
        "schema": SCHEMA,
        "same_behaviour": comparison.same,
        "first": asdict(comparison.first),
        "second": asdict(comparison.second),
        "changes": changes,
    }


def from_dict(data: Mapping[str, Any]) -> Comparison:
    """Restore a comparison from the data of `as_dict`."""
    derived = ("row_before", "row_after", "text")
    changes = [
        Change(**{
            **{name: value for name, value in entry.items() if name not in derived},
            "rows": (entry["row_before"] or 0, entry["row_after"] or 0),
            "pieces": tuple(FormulaPiece(p["kind"], p["text"]) for p in entry["pieces"]),
        })
        for entry in data["changes"]
    ]  # fmt: skip
    return Comparison(ComparedWorkbook(**data["first"]), ComparedWorkbook(**data["second"]), tuple(changes))
