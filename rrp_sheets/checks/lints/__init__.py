"""Lints: warnings about rows that work, but probably not as they are meant.

A lint must report nothing on workbooks that are in order, so it reports only what is certain. Nor does it report rows
that an error or a warning shows to be meant otherwise, nor rows that depend on those: that may only follow. Lints that
look for what no row does need all rows, so they wait while a row is wrong.
"""

from __future__ import annotations

import ast
from dataclasses import replace

from rrp_sheets.checks.dataflow import Paths
from rrp_sheets.checks.formulas import Compiled
from rrp_sheets.checks.lints.conflicts import lint_conflicts
from rrp_sheets.checks.lints.context import LintContext, RowKey, row_key
from rrp_sheets.checks.lints.deadlock import lint_deadlock
from rrp_sheets.checks.lints.failing_formulas import lint_failing_formulas
from rrp_sheets.checks.lints.flooded import lint_flooded
from rrp_sheets.checks.lints.input_specs import lint_input_specs
from rrp_sheets.checks.lints.spoken_language import lint_spoken_language
from rrp_sheets.checks.lints.stale import lint_stale
from rrp_sheets.checks.lints.unmatched import lint_never_equal, lint_unmatched
from rrp_sheets.checks.lints.unreachable import lint_undriven, lint_unreachable
from rrp_sheets.checks.lints.unused_helpers import lint_unused_helpers
from rrp_sheets.connectors import Parameter
from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.report import is_of_rows
from rrp_sheets.graph import Graph
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.workbook.schema import SHEETS

__all__ = ["lint"]

_OF_ROWS = (
    lint_stale, lint_flooded, lint_conflicts, lint_never_equal, lint_unreachable, lint_failing_formulas,
    lint_input_specs, lint_spoken_language,
)  # fmt: skip
_OF_ALL_ROWS = (lint_undriven, lint_unused_helpers, lint_unmatched, lint_deadlock)
_FORMULAS = (Parameter.FORMULA, Parameter.OPTIONAL_FORMULA)
_ASIDE = (SHEETS[kind] for kind in ("helpers", "scene", "gestures", "protocol", "risks"))
_ASIDE_KEYS = frozenset(key(name) for kind in _ASIDE for name in (kind.title, *kind.called))
"""Sheets whose errors concern only the rows that use them: those are found by what they lack."""


def lint(
    workbook: Workbook, robot: Robot, graph: Graph, compiled: Compiled, running: frozenset[str], report: Report
) -> None:
    """Report everything that the lints find; `running`: keys of the behaviours that run, or can be switched on."""
    routes = Paths(graph, compiled.formulas, compiled.facts)
    context = LintContext(workbook, robot, graph, compiled, running, routes, Report(report))
    context = replace(context, unclear=_unclear_rows(context))
    wrong = [d for d in context.report if is_of_rows(d)]
    if any(_may_concern_all(d, workbook) for d in wrong):
        return
    for each in _OF_ROWS if wrong else (*_OF_ROWS, *_OF_ALL_ROWS):
        each(context)
    for d in context.report:
        if not (d.code.startswith("LINT") and d.address and row_key(d.address) in context.unclear):
            report.extend([d])


def _may_concern_all(error: Diagnostic, workbook: Workbook) -> bool:
    """Return whether any row may depend on what is wrong: the file, the robot, an unread sheet, a nameless device."""
    if error.address is None or error.code == "PROT001":
        return True
    rows = {*map(key, (b.name for b in workbook.behaviours)), *map(key, (t.name for t in workbook.tests)), *_ASIDE_KEYS}
    devices = {row_key(device.stream.address) for device in workbook.devices if device.stream}
    return key(error.address.sheet) not in rows and row_key(error.address) not in devices


def _unclear_rows(context: LintContext) -> frozenset[RowKey]:
    """Return the rows that are not yet what is meant, because of a finding there or at what they depend on."""
    unclear: set[RowKey] = set()
    streams = _lost_streams(context)  # whose values are not what is meant
    for d in context.report:
        if d.address is None:
            continue
        if d.code in ("CONN010", "FORM012", "GRAPH011") or is_of_rows(d):
            unclear.add(row_key(d.address))
        if d.code == "DEV007":  # of an unknown column, it stands at the first of the devices that use it
            setting = key(str(d.details["setting"]))
            known = any(setting in device.settings for device in context.robot.devices.values())
            filled = (row.stream for row in context.workbook.devices if row.settings.get(setting))
            streams.update(key(s.text) for s in filled if not known or s.address.row == d.address.row)
        elif d.code == "GRAPH014":
            off = (s for b in context.graph.behaviours if b.name == d.address.sheet for s in b.steps)
            driven = {s.output for s in off if s.connector.is_sink}
            streams.update(s.id for s in context.graph.streams.values() if s.done_of in driven)
    hiding = _calling({key(str(d.details["name"])) for d in context.report if d.code == "FORM012"}, context)
    for step in context.steps():  # in the order in which they settle
        row, formula = row_key(step.row.output.address), context.compiled.formulas.get(step.ref)
        calls = hiding and formula and hiding & _called(formula.tree)
        refused = formula is None and step.row.formula and step.connector.parameter in _FORMULAS
        if calls or refused or streams.intersection((*step.inputs, step.output)):
            unclear.add(row)
        if row in unclear and not step.connector.is_sink:
            streams.add(step.output)
    return frozenset(unclear)


def _lost_streams(context: LintContext) -> set[str]:
    """Return the ids of the outputs of rows that could not be understood, and of devices with an error."""
    understood = {step.ref for behaviour in context.graph.behaviours for step in behaviour.steps}
    lost = {
        f"{key(b.name)}!{key(row.output.text) or f'#{row.number}'}"
        for b in context.workbook.behaviours for row in b.rows if row.on and f"{b.name}!{row.number}" not in understood
    }  # fmt: skip
    wrong = {row_key(d.address) for d in context.report if d.address and is_of_rows(d)}
    return lost | {key(d.stream.text) for d in context.workbook.devices if row_key(d.stream.address) in wrong}


def _calling(helpers: set[str], context: LintContext) -> set[str]:
    """Return the keys of helpers and of all that call them, also through others."""
    callers: dict[str, list[str]] = {}
    for k, helper in context.compiled.helpers.by_key.items() if helpers else ():
        for called in _called(helper.tree) if helper.tree is not None else ():
            callers.setdefault(called, []).append(k)
    found, waiting = set[str](), list(helpers)
    while waiting:
        if (k := waiting.pop()) not in found:
            found.add(k)
            waiting += callers.get(k, ())
    return found


def _called(tree: ast.expr) -> set[str]:
    """Return the keys of the helpers that a formula calls."""
    called = (getattr(node, "helper", None) for node in ast.walk(tree))
    return {key(helper.shown) for helper in called if helper}
