"""The Helpers sheet: compiled, with circles found."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field

import networkx as nx

from rrp_sheets.checks.telling import tell
from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import FormulaProblem, HelperDef, Input, compile_formula, make_scope
from rrp_sheets.formulas.functions import library
from rrp_sheets.formulas.tables import Table
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Workbook


@dataclass(frozen=True)
class Helpers:
    """The helpers of a workbook.

    Attributes:
        by_key: those that are in order.
        dropped: the keys of those that are not.
        cells: the name's and the formula's cell, by key.
    """

    by_key: Mapping[str, HelperDef] = field(default_factory=dict)
    dropped: frozenset[str] = frozenset()
    cells: Mapping[str, tuple[Cell, Cell]] = field(default_factory=dict)


def check_helpers(workbook: Workbook, tables: Mapping[str, Table], report: Report) -> Helpers:
    """Compile the helpers; what is wrong goes to the report."""
    helpers: dict[str, HelperDef] = {}
    cells: dict[str, Cell] = {}
    names: dict[str, Cell] = {}
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
        names[k] = helper.name
    for k, definition in list(helpers.items()):
        try:
            scope = make_scope([(p.shown, None) for p in definition.parameters], helpers, tables=tables)
            definition.tree = compile_formula(cells[k].text, scope).tree
        except FormulaProblem as problem:
            _propose_input(problem, definition, cells[k].text)
            tell(report, cells[k], problem)
            dropped.add(k)
    dropped |= _circles(helpers, cells, report)
    kept = {k: h for k, h in helpers.items() if k not in dropped}
    return Helpers(kept, frozenset(dropped), {k: (names[k], cells[k]) for k in kept})


def _propose_input(problem: FormulaProblem, helper: HelperDef, text: str) -> None:
    """Let an unknown name be an input that the helper's row forgets."""
    if helper.parameters or problem.column < 0:
        return
    name = text[problem.column : problem.column + problem.length]
    bare = problem.code == "FORM003" and library().get(name) is not None
    if problem.code == "FORM004" or bare:
        remedy = f"If {name} is an input of the helper, write it into the column Inputs."
        problem.details["remedy"] = f"{remedy} {problem.details['remedy']}"


def _circles(helpers: Mapping[str, HelperDef], cells: Mapping[str, Cell], report: Report) -> set[str]:
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
