"""Whether a proposed spelling is the only one that may be meant: then it can be corrected without asking."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from rrp_sheets.checks.formulas import Compiled
from rrp_sheets.connectors import connectors
from rrp_sheets.devices import Robot
from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.fix import Fix, Replace
from rrp_sheets.diagnostics.proposals import slips
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph import Graph
from rrp_sheets.model.names import argument_name, key

MOST_JUDGED = 300
"""A workbook with more mistakes is corrected step by step, each with a check of its own."""
MOST_COMPARED = 300_000  # pairs of names, for the same reason


def judge_proposals(graph: Graph, robot: Robot, compiled: Compiled, report: Report) -> None:
    """Leave to the user what may mean two names."""
    if not any(d.fixes for d in report):
        return
    streams = {s.name for s in graph.streams.values() if s.name}
    devices = {f.name for f in robot.names.values() if f.offered}
    helpers = {h.shown for h in compiled.helpers.by_key.values()}
    names: dict[str, Collection[str]] = {
        "CONN002": {c.name for c in connectors()},
        "GRAPH001": streams | devices,
        "GRAPH006": streams | devices,
        "DEV001": devices,
        "FORM004": {argument_name(n) for n in streams} | helpers,
        "FORM005": {f.name for f in library()} | helpers,
    }
    judged, compared = MOST_JUDGED, MOST_COMPARED

    def judge(finding: Diagnostic, fix: Fix) -> Fix:
        edit = fix.edits[0] if len(fix.edits) == 1 else None
        if not fix.safe or not isinstance(edit, Replace) or finding.code not in names:
            return fix
        nonlocal judged, compared
        judged, compared = judged - 1, compared - len(names[finding.code])
        if judged < 0 or compared < 0:
            return replace(fix, safe=False)
        best = slips(edit.old, edit.new)
        near = {key(n) for n in names[finding.code] if slips(edit.old, n, best) <= best}
        return replace(fix, safe=not near - {key(edit.new)})

    report.judge_fixes(judge)
