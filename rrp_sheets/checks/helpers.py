"""The Helpers sheet: compiled, with circles found."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rrp_sheets.checks.telling import tell
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase, sentences, str_of
from rrp_sheets.formulas import FormulaProblem, HelperDef, Input, compile_formula, make_scope
from rrp_sheets.formulas.functions import library
from rrp_sheets.formulas.limits import DEEPEST_HELPERS
from rrp_sheets.formulas import Table
from rrp_sheets.graph.sorting import after_needs
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import Proposals, argument_name, is_reserved, key
from rrp_sheets.model.workbook import Workbook


@dataclass(frozen=True)
class Helpers:
    """The helpers of a workbook.

    Attributes:
        by_key: those that are in order.
        dropped: the keys of those that are not.
        cells: the name's and the formula's cell, by key.
        propose: finds what may be meant by a name, for all formulas of the check together.
    """

    by_key: Mapping[str, HelperDef] = field(default_factory=dict)
    dropped: frozenset[str] = frozenset()
    cells: Mapping[str, tuple[Cell, Cell]] = field(default_factory=dict)
    propose: Proposals = field(default_factory=Proposals)


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
        for cell in (helper.name, *helper.inputs):
            if is_reserved(cell.text):
                report.add("GRAPH018", cell.address, name=cell.text)
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
    propose = Proposals()
    for k, definition in list(helpers.items()):
        try:
            scope = make_scope(
                [(p.shown, None) for p in definition.parameters], helpers, tables=tables, propose=propose
            )
            definition.tree = compile_formula(cells[k].text, scope).tree
        except FormulaProblem as problem:
            for one in problem.every:
                _propose_input(one, definition, cells[k].text)
            if not any(is_reserved(p.shown) for p in definition.parameters):
                tell(report, cells[k], problem)
            dropped.add(k)
    dropped |= _Calls(helpers, cells, report).refused()
    kept = {k: h for k, h in helpers.items() if k not in dropped}
    return Helpers(kept, frozenset(dropped), {k: (names[k], cells[k]) for k in kept}, propose)


def _propose_input(problem: FormulaProblem, helper: HelperDef, text: str) -> None:
    """Let an unknown name be an input that the helper's row forgets."""
    if helper.parameters or problem.column < 0:
        return
    name = text[problem.column : problem.column + problem.length]
    bare = problem.code == "FORM003" and library().get(name) is not None
    if problem.code == "FORM004" or bare:
        remedy = Phrase("If {name} is an input of the helper, write it into the column Inputs.", name=name)
        problem.details["remedy"] = sentences(remedy, str_of(problem.details["remedy"]))


class _Calls:
    """How helpers call each other."""

    def __init__(self, helpers: Mapping[str, HelperDef], cells: Mapping[str, Cell], report: Report) -> None:
        self.helpers, self.cells, self.report = helpers, cells, report
        self.needs: dict[str, list[str]] = {}
        for k, helper in helpers.items():
            called = (getattr(node, "helper", None) for node in (ast.walk(helper.tree) if helper.tree else ()))
            self.needs[k] = list(dict.fromkeys(key(other.shown) for other in called if other is not None))

    def refused(self) -> set[str]:
        """Report helpers in circles and chains that are too long; the helpers that cannot be used therefore."""
        places = {k: i for i, k in enumerate(self.helpers)}
        order = after_needs(self.needs, places.__getitem__)
        circles = self._circles() if len(order) < len(places) else set()
        if circles:
            needs = {k: [n for n in called if n not in circles] for k, called in self.needs.items() if k not in circles}
            order = after_needs(needs, places.__getitem__)
        return circles | self._too_deep(order)

    def _circles(self) -> set[str]:
        import networkx as nx  # few workbooks have circles, and loading it takes longer than checking them

        graph = nx.DiGraph((k, other) for k, called in self.needs.items() for other in called)
        members: set[str] = set()
        for circle in nx.strongly_connected_components(graph):
            first = next(k for k in self.helpers if k in circle)
            if len(circle) == 1 and not graph.has_edge(first, first):
                continue
            path = [a for a, _ in nx.find_cycle(graph.subgraph(circle), first)]
            shown = [self._shown(k) for k in path]
            self.report.add("FORM011", self.cells[first].address, path=" → ".join([*shown, shown[0]]))
            members |= circle
        return members

    def _too_deep(self, order: Iterable[str]) -> set[str]:
        deep: dict[str, int] = {}
        for k in order:
            deep[k] = 1 + max((deep[other] for other in self.needs[k] if other in deep), default=0)
            if deep[k] == DEEPEST_HELPERS + 1:  # told where it becomes too deep, not for all that call it
                path = self._path(k, deep)
                self.report.add("FORM025", self.cells[k].address, path=path, most=DEEPEST_HELPERS)
        return {k for k, count in deep.items() if count > DEEPEST_HELPERS}

    def _path(self, k: str, deep: Mapping[str, int]) -> str:
        """The helpers that call each other from here down, without those in the middle."""
        path = [k]
        while calls := [other for other in self.needs[path[-1]] if other in deep]:
            path.append(max(calls, key=deep.__getitem__))
        shown = [self._shown(h) for h in path]
        return " → ".join([*shown[:3], "…", shown[-1]])

    def _shown(self, k: str) -> str:
        return f"{self.helpers[k].shown} ({self.cells[k].address.cell})"
