"""Formulas and helpers of a workbook: compiled, with what is known about the records that flow."""

from __future__ import annotations

import ast
from collections.abc import Mapping

from rrp_sheets.connectors import Parameter
from rrp_sheets.connectors.combine_latest import together
from rrp_sheets.connectors.timestamp import TIMED
from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import Formula, FormulaProblem, HelperDef, Input, Scope, compile_formula, make_scope
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import Field, RecordType
from rrp_sheets.model.workbook import Workbook

MOST_TIMESTAMPS = 10


def check_formulas(workbook: Workbook, graph: Graph, report: Report) -> dict[str, Formula]:
    """Compile every helper and every row's formula; by row ref."""
    helpers, dropped = _helpers(workbook, report)
    records: dict[str, RecordType | None] = {
        s.id: s.device.type.payload for s in graph.streams.values() if s.kind in (StreamKind.SENSOR, StreamKind.DONE) and s.device
    }
    depths: dict[str, int] = {}  # how many timestamps stand within each other
    formulas: dict[str, Formula] = {}
    for behaviour in graph.behaviours:
        for step in sorted(behaviour.steps, key=lambda s: s.rank):
            formula = None
            if step.row.on and step.row.formula and _takes_formula(step) and len(set(step.inputs)) == len(step.inputs):
                formula = _compile(step, graph, helpers, dropped, records, report)
                if formula is not None:
                    formulas[step.ref] = formula
            nested = max((depths.get(i, 0) for i in step.inputs), default=0) + (step.connector.name == "timestamp")
            if nested > MOST_TIMESTAMPS:
                report.add("GRAPH015", step.row.connector.address, most=MOST_TIMESTAMPS)
                continue
            depths[step.output] = 0 if formula else nested
            records[step.output] = _record(step, graph, records, formula)
    return formulas


def _takes_formula(step: Step) -> bool:
    return step.connector.parameter in (Parameter.FORMULA, Parameter.OPTIONAL_FORMULA)


def _compile(
    step: Step,
    graph: Graph,
    helpers: Mapping[str, HelperDef],
    dropped: frozenset[str],
    records: Mapping[str, RecordType | None],
    report: Report,
) -> Formula | None:
    cell = step.row.formula
    try:
        scope = make_scope([(graph.streams[i].name, records.get(i)) for i in step.inputs], helpers)
        text = _helper_alone(cell, scope, len(step.inputs))
        return compile_formula(text, scope)
    except FormulaProblem as problem:
        if not _about_dropped(problem, dropped):
            tell(report, cell, problem)
        return None


def _helper_alone(cell: Cell, scope: Scope, count: int) -> str:
    """A cell that holds only a helper's name applies it to the row's inputs in order."""
    text = cell.text
    helper = scope.helpers.get(key(text))
    if helper is None or not helper.parameters or key(text) in scope.inputs:
        return text
    if len(helper.parameters) != count:
        wanted = len(helper.parameters)
        takes = "one input" if wanted == 1 else f"{wanted} inputs"
        raise FormulaProblem("FORM014", name=helper.shown, takes=takes, gets="one" if count == 1 else count)
    return f"{argument_name(helper.shown)}({', '.join(scope.order)})"


def _about_dropped(problem: FormulaProblem, dropped: frozenset[str]) -> bool:
    """Whether a name is missing only because its helper is wrong, which was told there."""
    return problem.code in ("FORM004", "FORM005") and key(str(problem.details.get("name", ""))) in dropped


def tell(report: Report, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem at its cell."""
    span = (problem.column, problem.column + problem.length) if problem.column >= 0 else None
    report.add(problem.code, cell.address, span=span, **problem.details)


def _record(
    step: Step, graph: Graph, records: Mapping[str, RecordType | None], formula: Formula | None
) -> RecordType | None:
    """The record type of what a row gives, where it is known."""
    name = step.connector.name
    kinds = [records.get(i) for i in step.inputs]
    if name == "timestamp":
        value = Field("value", example=kinds[0].example() if kinds[0] else None)
        return RecordType(TIMED.name, (value, *TIMED.fields[1:]), TIMED.aliases, TIMED.positions)
    if name == "combineLatest" and formula is None and not step.row.formula:
        return together(tuple(graph.streams[i].name for i in step.inputs))
    if name in ("filter", "sample", "forgetAfter"):
        return kinds[0] if kinds else None
    if name == "merge":
        return kinds[0] if kinds and all(k == kinds[0] for k in kinds) else None
    if formula is not None and isinstance(formula.tree, ast.Name) and formula.tree.id in formula.names:
        return kinds[formula.names.index(formula.tree.id)]
    return None


# ---- helpers


def _helpers(workbook: Workbook, report: Report) -> tuple[dict[str, HelperDef], frozenset[str]]:
    """The helpers that are in order, and the keys of those that are not."""
    helpers: dict[str, HelperDef] = {}
    cells: dict[str, Cell] = {}
    dropped: set[str] = set()
    places: dict[str, Address] = {}
    for helper in workbook.helpers:
        k = key(argument_name(helper.name.text))
        if not k:
            report.add("FORM016", helper.name.address)
            continue
        if k in places:
            report.add("FORM013", helper.name.address, name=helper.name.text, other=str(places[k]))
            continue
        places[k] = helper.name.address
        if not helper.formula:
            report.add("FORM015", helper.formula.address, name=helper.name.text)
            dropped.add(k)
            continue
        if library().get(helper.name.text):
            report.add("FORM012", helper.name.address, name=helper.name.text)
        inputs = tuple(Input(c.text, argument_name(c.text) or "value") for c in helper.inputs)
        helpers[k] = HelperDef(argument_name(helper.name.text), inputs)
        cells[k] = helper.formula
    for k, definition in list(helpers.items()):
        try:
            scope = make_scope([(p.shown, None) for p in definition.parameters], helpers)
            definition.tree = compile_formula(cells[k].text, scope).tree
        except FormulaProblem as problem:
            tell(report, cells[k], problem)
            dropped.add(k)
    dropped |= _circles(helpers, cells, report)
    return {k: h for k, h in helpers.items() if k not in dropped}, frozenset(dropped)


def _circles(helpers: Mapping[str, HelperDef], cells: Mapping[str, Cell], report: Report) -> set[str]:
    import networkx as nx

    graph = nx.DiGraph()
    for k, helper in helpers.items():
        for node in ast.walk(helper.tree) if helper.tree else ():
            called: HelperDef | None = getattr(node, "helper", None)
            if called is not None:
                graph.add_edge(k, key(called.shown))
    members: set[str] = set()
    for circle in nx.strongly_connected_components(graph):
        first = next((k for k in helpers if k in circle), None)
        if first is None or (len(circle) == 1 and not graph.has_edge(first, first)):
            continue
        path = [a for a, _ in nx.find_cycle(graph.subgraph(circle), first)]
        shown = [f"{helpers[k].shown} ({cells[k].address.cell})" for k in path]
        report.add("FORM011", cells[first].address, path=" → ".join([*shown, shown[0]]))
        members |= circle
    return members
