"""Account of a replay for a page: words, rows to link to, and marbles, as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rrp_sheets.diagnostics.languages import told
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.runs.replay.account_text import AccountLine
from rrp_sheets.runs.replay.replay_marbles import difference_scores
from rrp_sheets.runs.replay.report import each_line, robot_lines, row_lines, verdict
from rrp_sheets.runs.replay.result import Replayed

MOST = 300  # lines of a list
_MOST_PICTURES = 4


def account(found: Replayed) -> dict[str, Any]:
    """Return what a page shows of a replay, as JSON."""
    robot, language = robot_lines(found), found.language
    each = [] if found.other else each_line(found)
    return {
        "same": found.same, "verdict": told(verdict(found), language),
        "remarks": [told(r, language) for r in found.remarks], "ending": told(found.ending, language),
        "rows": [
            {"whose": told(line.whose, language), "text": told(line.text, language), "row": line.row}
            for line in row_lines(found)[:MOST]
        ],
        "robot": _first(robot, language), "robot_left_out": max(0, len(robot) - MOST),
        "each": _first(each, language), "each_left_out": max(0, len(each) - MOST),
        "unknown": [told(u, language) for u in found.unknown], "differs": bool(found.differences),
        "pictures": [p.svg for p in draw_marbles(difference_scores(found), strips=1)[:_MOST_PICTURES]],
    }  # fmt: skip


def _first(lines: Sequence[AccountLine], language: str) -> list[dict[str, Any]]:
    return [
        {"when": told(line.when, language), "us": line.us, "text": told(line.text, language), "row": line.row}
        for line in lines[:MOST]
    ]
