"""Formulas of a workbook's rows: compiled, with what is known about the records that flow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.checks.helpers import check_helpers
from rrp_sheets.checks.records import record_of
from rrp_sheets.checks.telling import tell
from rrp_sheets.connectors import Parameter
from rrp_sheets.diagnostics import Report
from rrp_sheets.formulas import (
    Formula,
    FormulaProblem,
    HelperDef,
    Scope,
    Table,
    compile_formula,
    make_scope,
    make_table,
)
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import RecordType
from rrp_sheets.model.workbook import Workbook

MOST_TIMESTAMPS = 10


def check_formulas(workbook: Workbook, graph: Graph, report: Report) -> Compiler:
    """Compile every helper and every row's formula; what is known of them then."""
    names = {key(n): n for n in workbook.sheets}
    tables = {k: make_table(names.get(k, k), rows) for k, rows in workbook.tables.items()}
    helpers, dropped = check_helpers(workbook, tables, report)
    compiler = Compiler(graph, helpers, tables, dropped, report)
    for behaviour in graph.behaviours:
        for step in sorted(behaviour.steps, key=lambda s: s.rank):
            compiler.add(step)
    return compiler


class Compiler:
    """Compiles rows in their order, each knowing what the rows before it give.

    Attributes:
        formulas: by row ref.
        records: of streams by id, where they are known.
    """

    def __init__(
        self,
        graph: Graph,
        helpers: Mapping[str, HelperDef],
        tables: Mapping[str, Table],
        dropped: frozenset[str],
        report: Report,
    ) -> None:
        self.graph = graph
        self.helpers = helpers
        self.tables = tables
        self.dropped = dropped
        self.report = report
        self.formulas: dict[str, Formula] = {}
        self.records: dict[str, RecordType | None] = {}
        self.kinds: dict[str, str] = {}  # of streams that give nothing but numbers, say
        self._depths: dict[str, int] = {}  # how many timestamps stand within each other
        for stream in graph.streams.values():
            if stream.kind in (StreamKind.SENSOR, StreamKind.DONE) and stream.device:
                self.records[stream.id] = stream.device.type.payload
                if stream.device.type.payload is None:
                    self.kinds[stream.name] = "number"

    def add(self, step: Step) -> None:
        """Compile a row."""
        formula = None
        if step.row.on and step.row.formula and _takes_formula(step) and len(set(step.inputs)) == len(step.inputs):
            formula = self._compile(step)
            if formula is not None:
                self.formulas[step.ref] = formula
        nested = max((self._depths.get(i, 0) for i in step.inputs), default=0) + (step.connector.name == "timestamp")
        if nested > MOST_TIMESTAMPS:
            self.report.add("GRAPH015", step.row.connector.address, most=MOST_TIMESTAMPS)
            return
        self._depths[step.output] = 0 if formula else nested
        self.records[step.output] = record_of(step, self.graph, self.records, formula)

    def scope(self, inputs: Sequence[tuple[str, RecordType | None]]) -> Scope:
        """The names that a formula outside of the rows may use, in a test for instance."""
        return make_scope(inputs, self.helpers, tables=self.tables)

    def _compile(self, step: Step) -> Formula | None:
        cell = step.row.formula
        try:
            scope = make_scope(
                [(self.graph.streams[i].name, self.records.get(i)) for i in step.inputs],
                self.helpers,
                tables=self.tables,
                extra=step.connector.extra,
                kinds=self.kinds,
            )
            return compile_formula(helper_alone(cell, scope, len(step.inputs)), scope)
        except FormulaProblem as problem:
            if not _about_dropped(problem, self.dropped):
                tell(self.report, cell, problem)
            return None


def _takes_formula(step: Step) -> bool:
    return step.connector.parameter in (Parameter.FORMULA, Parameter.OPTIONAL_FORMULA)


def helper_alone(cell: Cell, scope: Scope, count: int) -> str:
    """A cell that holds only a helper's name applies it to the row's inputs in order."""
    text = cell.text
    helper = scope.helpers.get(key(text))
    if helper is None or not helper.parameters or key(text) in scope.inputs:
        return text
    if len(helper.parameters) != count:
        wanted = len(helper.parameters)
        takes = "one input" if wanted == 1 else f"{wanted} inputs"
        raise FormulaProblem("FORM014", name=helper.shown, takes=takes, gets="one" if count == 1 else count)
    return f"{argument_name(helper.shown)}({', '.join(scope.order[-count:])})"


def _about_dropped(problem: FormulaProblem, dropped: frozenset[str]) -> bool:
    """Whether a name is missing only because its helper is wrong, which was told there."""
    return problem.code in ("FORM004", "FORM005") and key(str(problem.details.get("name", ""))) in dropped
