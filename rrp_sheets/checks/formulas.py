"""Compiles a workbook's helpers and the formulas of its rows, each with the facts about the row's inputs."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from rrp_sheets.checks.examples import Examples, Trouble
from rrp_sheets.checks.facts import NUMBER, TEXT, TRUTH, Fact, sensor_fact
from rrp_sheets.connectors import Parameter
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, Put, meant
from rrp_sheets.formulas import (
    Formula,
    FormulaProblem,
    HelperDef,
    Input,
    Scope,
    Table,
    compile_formula,
    make_scope,
    make_table,
    read_formula,
)
from rrp_sheets.formulas.functions import library
from rrp_sheets.formulas.hints import KEYWORDS, name_here
from rrp_sheets.formulas.hints import cell as is_cell
from rrp_sheets.formulas.limits import DEEPEST_HELPERS
from rrp_sheets.formulas.problems import together
from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.graph.build import after_needs
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import Proposals, argument_name, is_reserved, key
from rrp_sheets.model.values import RecordType
from rrp_sheets.model.workbook import Cell, Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_, sentences

MOST_TIMESTAMPS = 10


@dataclass
class Compiled:
    """The formulas of a workbook and what is known about its streams; the check adds row by row."""

    formulas: dict[str, Formula]  # by the row's ref; missing where there is none or where it is wrong
    facts: dict[str, Fact]  # by stream id; of actuator streams by the ref of the row that drives them
    troubles: dict[str, Trouble]  # by row ref, of formulas that fail on the examples
    helpers: Helpers
    examples: Examples  # evaluates formulas on further values, within the bounds of this check
    tables: Mapping[str, Table]  # by the sheet's key

    @property
    def records(self) -> dict[str, RecordType | None]:
        """The record types of streams by id, where they are known."""
        return {k: f.known.record for k, f in self.facts.items()}

    def scope(self, inputs: Sequence[tuple[str, RecordType | None]]) -> Scope:
        """Return the names that a formula outside of the rows may use, in a test for instance."""
        return make_scope(inputs, self.helpers.by_key, tables=self.tables, propose=self.helpers.propose)


def check_formulas(workbook: Workbook, robot: Robot, graph: Graph, report: Report) -> Compiled:
    """Compile every helper and every row's formula, and work out the examples."""
    names = {key(n): n for n in workbook.sheets}
    tables = {k: make_table(names.get(k, k), rows) for k, rows in workbook.tables.items()}
    given = (s for s in graph.streams.values() if s.kind in (StreamKind.SENSOR, StreamKind.DONE) and s.device)
    facts = {s.id: sensor_fact(s, robot) for s in given}
    compiled = Compiled({}, facts, {}, check_helpers(workbook, tables, report), Examples(graph), tables)
    compiler = _Compiler(graph, own_sheets(workbook), compiled, report, robot)
    for behaviour in graph.behaviours:
        for step in sorted(behaviour.steps, key=lambda s: s.rank):
            compiler.add(step)
    return compiled


class _Compiler:
    def __init__(self, graph: Graph, sheets: Sequence[str], compiled: Compiled, report: Report, robot: Robot) -> None:
        self.robot = robot
        self.graph = graph
        self.sheets = sheets  # names that may be meant for tables
        self.compiled = compiled
        self.report = report
        self._depths: dict[str, int] = {}  # how many timestamps stand within each other
        self._text_streams = _text_streams(graph)
        self._streams = frozenset(key(s.name) for s in graph.streams.values())

    def add(self, step: Step) -> None:
        """Compile a row's formula, and work out the fact about its output."""
        formula = None
        takes = step.connector.parameter in (Parameter.FORMULA, Parameter.OPTIONAL_FORMULA)
        if step.row.on and step.row.formula and takes and len(set(step.inputs)) == len(step.inputs):
            formula = self._compile(step)
            if formula is not None:
                self.compiled.formulas[step.ref] = formula
        nested = max((self._depths.get(i, 0) for i in step.inputs), default=0) + (step.connector.name == "timestamp")
        if nested > MOST_TIMESTAMPS:
            self.report.add("GRAPH015", step.row.connector.address, most=MOST_TIMESTAMPS)
            return
        self._depths[step.output] = 0 if formula else nested
        if not step.row.on or not step.inputs:
            return
        facts = [self.compiled.facts.get(i, Fact()) for i in step.inputs]
        fact, trouble = self.compiled.examples.work_out(step, facts, formula)
        self.compiled.facts[step.ref if step.connector.is_sink else step.output] = fact
        if trouble is not None and step.active:
            self.compiled.troubles[step.ref] = trouble

    def _compile(self, step: Step) -> Formula | None:
        cell, helpers = step.row.formula, self.compiled.helpers
        names = [self.graph.streams[i].name for i in step.inputs]
        known = [self.compiled.facts.get(i, Fact()).known for i in step.inputs]
        kinds = {n: k.kind for n, k in zip(names, known, strict=True) if k.kind in (NUMBER, TEXT, TRUTH)}
        scope = None
        try:
            scope = make_scope(
                zip(names, [k.record for k in known], strict=True), helpers.by_key, tables=self.compiled.tables,
                extra=step.connector.extra, kinds=kinds, propose=helpers.propose,
            )  # fmt: skip
            if key(cell.text) in helpers.dropped and key(cell.text) not in scope.inputs:
                return None  # a helper alone in the cell that is wrong, which was told there
            text = self._duration(step) or helper_alone(cell, scope, len(step.inputs))
            return compile_formula(text, scope, condition=step.connector.name == "filter")
        except FormulaProblem as problem:
            for one in problem.every:
                self._propose_sheet(one, scope)
                _propose_total(one, step)
            if any(map(is_reserved, names)):  # told of the name, where it is given
                return None
            if scope is not None and problem.code != "FORM002" and (quoted := self._quoted(step, scope)):
                self.report.add(
                    "FORM001", cell.address, span=(0, len(cell.text)), fixes=[rewrite("put-in-quotes", cell, quoted)],
                    reason=N_("a text needs quotes"), remedy=N_("Write {value}.", value=quoted),
                )  # fmt: skip
                return None
            told = [one for one in problem.every if not _about_dropped(one, helpers.dropped)]
            if told:
                tell(self.report, cell, together(told))
            return None

    def _duration(self, step: Step) -> str:
        """Return a time such as `8 s` that is sent to Wait as a text in quotes; else an empty text."""
        device, typed = self.graph.streams[step.output].device, step.row.formula.text.strip()
        waits = step.connector.is_sink and device is not None and device.type.name == "Wait"
        return f'"{typed}"' if waits and typed[-1:].isalpha() and parse_duration(typed) else ""

    def _quoted(self, step: Step, scope: Scope) -> str:
        """Return a row's formula in quotes where it is a text without them; empty where it is a formula, or may be."""
        text, robot = step.row.formula.text.strip(), self.robot
        target, device = self._text_streams.get(step.output, ""), self.graph.streams[step.output].device
        if step.connector.name not in _GIVING_TEXTS or not (target or device is None or device.type.name == "Print"):
            return ""
        moves = [*robot.gestures, *robot.postures, *japanese.MOVES]
        names = moves if target in ("Gesture", "Posture", "") else []
        name = next((n for n in names if key(n) == key(text)), "")
        unknown, known = _unknown_words(text, scope, self.compiled.helpers.dropped)
        if not name and (unknown < 1 + bool(known) + (not target) or key(text) in self._streams):
            return ""
        doubled = (name or text).replace('"', '""')
        return f'"{doubled}"'

    def _propose_sheet(self, problem: FormulaProblem, scope: Scope | None) -> None:
        """Propose a sheet for an unknown name: only sheets that a formula names correctly are read as tables."""
        name = str(problem.details.get("name", ""))
        if scope is None or problem.code != "FORM004":
            return
        guess = scope.propose(name, [*self.sheets, *scope.known()]) if self.sheets else None
        if guess is not None and guess in self.sheets:
            guess = argument_name(guess)
            remedy = N_('Did you mean {guess}? (A text needs quotes: "{name}".)', guess=guess, name=name)
            problem.advise(remedy, guess)


_TEXT_DEVICES = ("SayInput", "Gesture", "Posture", "EyeLedColor")
_GIVING_TEXTS = ("map", "combineLatest", "subscribe")
_QUOTED = re.compile('["“„][^"“”„]*["“”]')
_SENTENCE = re.compile(r"""(?:\w|\s|(?<=\w)['’-](?=\w)|(?<=[\w"”])[,.;:!?…]+(?=[\s"”]|$)|["“”„、。！？…「」])+""")
_OPERATOR_WORDS = KEYWORDS | {"and", "or", "not", "if", "then", "elseif", "between", "equal", "equals", "mod"}


def _text_streams(graph: Graph) -> dict[str, str]:
    """Return the device type of each stream that reaches an actuator taking texts, itself or by a row."""
    found: dict[str, str] = {}
    for step in (s for b in graph.behaviours for s in b.steps if s.connector.is_sink and s.row.on):
        device = graph.streams[step.output].device
        if device is not None and device.type.name in _TEXT_DEVICES:
            for stream in (step.output, *(() if step.row.formula else step.inputs)):
                found.setdefault(stream, device.type.name)
    return found


def _unknown_words(text: str, scope: Scope, dropped: Collection[str] = ()) -> tuple[int, int]:
    """Count the words of a sentence that mean nothing in a formula, and those that may be names in it.

    Both are 0 where something else than words and the signs of a sentence stands there. Operators, functions and
    numbers count as neither.
    """
    rest, quoted = _QUOTED.subn(" ", text.casefold())
    spelt_as_name = re.search(r"_|[^\W\d_A-Z][A-Z]", text)  # redBall, red_ball
    if spelt_as_name or re.search('["“”„]', rest) or not _SENTENCE.fullmatch(text):
        return 0, 0
    known = quoted
    for name in sorted((i.shown.casefold() for i in scope.inputs.values() if i.shown), key=len, reverse=True):
        rest, count = re.subn(rf"(?<!\w){re.escape(name)}(?!\w)", " ", rest)
        known += count
    fields = {k for i in scope.inputs.values() if i.record for k in i.record.keys}
    words = [w for w in re.findall(r"[^\W\d]\w*(?:['’-]\w+)*", rest) if w not in _OPERATOR_WORDS]
    names = {*map(key, scope.known()), *fields, *dropped, "true", "false", "blank"}
    unknown = 0
    for word in words[:50]:
        if key(word) in names or scope.propose(word, scope.known()):
            known += 1
        elif scope.functions.get(word) is None and name_here(key(word)) is None and not is_cell(word):
            unknown += 1
    return (0, known) if known and rest.split()[:1] == ["if"] else (unknown, known)


def rewrite(name: str, cell: Cell, text: str) -> Fix:
    """Return the fix that writes a formula in another way."""
    title = N_("Write {value}", value=text if len(text) <= 60 else f"{text[:59]}…")
    return Fix(name, title, (Put(cell.address, text, cell.original),))


def _corrected(cell: Cell, problem: FormulaProblem) -> tuple[Fix, ...]:
    """Return the fix that writes what a problem's remedy names; empty when the formula could not be read after it."""
    text: str = cell.text
    for _ in range(10):
        if not problem.written:
            break
        text = text[: problem.column] + problem.written + text[problem.column + problem.length :]
        try:
            read_formula(text)
        except FormulaProblem as other:
            problem = other
        else:
            return (rewrite("correct-formula", cell, text),)
    return ()


def _propose_total(problem: FormulaProblem, step: Step) -> None:
    """Set the remedy for an accumulate row: its output is called `total`, and counting needs no formula."""
    if step.connector.name != "accumulate":
        return
    name = key(str(problem.details.get("name", "")))
    formula = key(step.row.formula.text.strip("= ()"))
    if formula in ("count", "counter") and problem.code in ("FORM003", "FORM004"):
        problem.advise(N_("To count the values that arrive, leave the Formula blank."))
    elif formula == "count" and problem.code == "FORM006":
        problem.details["usage"] = N_("nothing: leave the Formula blank, and the values that arrive are counted")
    elif problem.code == "FORM003" and name == "count":  # without brackets
        problem.advise(N_("Write total for the count so far. Or leave the Formula blank: the row then counts."))
    elif problem.code == "FORM004" and step.row.output and name == key(step.row.output.text):
        problem.advise(N_("Did you mean total? In this row, it is the total so far."), "total")


def own_sheets(workbook: Workbook) -> list[str]:
    """Return the names of the user's own sheets: all but behaviours, tests and the sheets with a fixed name."""
    ours = {"devices", "helpers", "scene", "gestures", "protocol", "risks"}
    ours |= {key(b.name) for b in workbook.behaviours} | {key(t.name) for t in workbook.tests}
    return [name for name in workbook.sheets if key(name) not in ours]


def helper_alone(cell: Cell, scope: Scope, count: int) -> str:
    """Return a cell's formula; a helper's name alone becomes a call with the row's inputs in order."""
    text = cell.text
    helper = scope.helpers.get(key(text))
    if helper is None and re.fullmatch(r"\w+( \w+)+", text):
        guess = scope.propose(text, [h.shown for h in scope.helpers.values()])
        if guess and not {"if", "and", "or", "not", "in"} & set(text.casefold().split()):
            raise FormulaProblem("FORM005", 0, len(text), name=text, **meant(guess, ""))
    if helper is None or not helper.parameters or key(text) in scope.inputs:
        return text
    if len(helper.parameters) != count:
        wanted = len(helper.parameters)
        takes = N_("one input") if wanted == 1 else N_("{wanted} inputs", wanted=wanted)
        raise FormulaProblem("FORM014", name=helper.shown, takes=takes, gets=N_("one") if count == 1 else count)
    return f"{argument_name(helper.shown)}({', '.join(scope.order[-count:])})"


def _about_dropped(problem: FormulaProblem, dropped: frozenset[str]) -> bool:
    """Return whether a name is unknown only because its helper is wrong, which is reported at the helper."""
    return problem.code in ("FORM004", "FORM005") and key(str(problem.details.get("name", ""))) in dropped


@dataclass(frozen=True)
class Helpers:
    """The helpers of a workbook."""

    by_key: Mapping[str, HelperDef] = field(default_factory=dict)  # those that are in order
    dropped: frozenset[str] = frozenset()  # the keys of the others
    cells: Mapping[str, tuple[Cell, Cell]] = field(default_factory=dict)  # the name's and the formula's cell, by key
    # finds what may be meant by a name, for all formulas of the check together
    propose: Proposals = field(default_factory=Proposals)


def check_helpers(workbook: Workbook, tables: Mapping[str, Table], report: Report) -> Helpers:
    """Compile the helpers and report their problems."""
    helpers: dict[str, HelperDef] = {}
    cells: dict[str, Cell] = {}
    names: dict[str, Cell] = {}
    dropped: set[str] = set()
    for helper in workbook.helpers:
        k = key(argument_name(helper.name.text))
        if not k:
            report.add("FORM016", helper.name.address)
            continue
        if k in names:
            report.add("FORM013", helper.name.address, name=helper.name.text, other=str(names[k].address))
            continue
        names[k] = helper.name
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
    propose = Proposals()
    for k, definition in helpers.items():
        try:
            inputs_known = [(p.shown, None) for p in definition.parameters]
            scope = make_scope(inputs_known, helpers, tables=tables, propose=propose)
            definition.tree = compile_formula(cells[k].text, scope).tree
        except FormulaProblem as problem:
            for one in problem.every:
                _propose_input(one, definition, cells[k].text)
            if not any(is_reserved(p.shown) for p in definition.parameters):
                tell(report, cells[k], problem)
            dropped.add(k)
    calls = {k: _called(helper) for k, helper in helpers.items()}
    dropped |= _refused_calls(helpers, calls, cells, report)
    while callers := {k for k in calls.keys() - dropped if not dropped.isdisjoint(calls[k])}:
        dropped |= callers
    kept = {k: h for k, h in helpers.items() if k not in dropped}
    return Helpers(kept, frozenset(dropped), {k: (names[k], cells[k]) for k in kept}, propose)


def _propose_input(problem: FormulaProblem, helper: HelperDef, text: str) -> None:
    """Propose to declare an unknown name as an input of the helper."""
    if helper.parameters or problem.column < 0:
        return
    name = text[problem.column : problem.column + problem.length]
    bare = problem.code == "FORM003" and library().get(name) is not None
    if problem.code == "FORM004" or bare:
        remedy = N_("If {name} is an input of the helper, write it into the column Inputs.", name=name)
        problem.advise(sentences(remedy, problem.remedy))


def _called(helper: HelperDef) -> list[str]:
    """Return the keys of the helpers that a helper calls."""
    called = (getattr(node, "helper", None) for node in (ast.walk(helper.tree) if helper.tree else ()))
    return list(dict.fromkeys(key(other.shown) for other in called if other is not None))


def _refused_calls(
    helpers: Mapping[str, HelperDef], needs: Mapping[str, Sequence[str]], cells: Mapping[str, Cell], report: Report
) -> set[str]:
    """Report circles and overlong chains of calls, and return the keys of the helpers that cannot be used for that."""
    shown = {k: f"{helper.shown} ({cells[k].address.cell})" for k, helper in helpers.items()}
    places = {k: i for i, k in enumerate(helpers)}
    order = after_needs(needs, places.__getitem__)
    refused: set[str] = set()
    if len(order) < len(places):
        for first, way, members in _circles(needs):
            report.add("FORM011", cells[first].address, path=" → ".join(shown[k] for k in (*way, way[0])))
            refused |= members
        rest = {k: [n for n in called if n not in refused] for k, called in needs.items() if k not in refused}
        order = after_needs(rest, places.__getitem__)
    deep: dict[str, int] = {}
    for k in order:
        deep[k] = 1 + max((deep[other] for other in needs[k] if other in deep), default=0)
        if deep[k] == DEEPEST_HELPERS + 1:  # told where it becomes too deep, not for all that call it
            chain = [k]
            while calls := [other for other in needs[chain[-1]] if other in deep]:
                chain.append(max(calls, key=deep.__getitem__))
            path = " → ".join([*(shown[h] for h in chain[:3]), "…", shown[chain[-1]]])
            report.add("FORM025", cells[k].address, path=path, most=DEEPEST_HELPERS)
    return refused | {k for k, count in deep.items() if count > DEEPEST_HELPERS}


def _circles(needs: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, list[str], set[str]]]:
    """Yield the first helper of each group that call each other, one circle in it, and all helpers of the group."""
    import networkx as nx  # few workbooks have circles, and loading it takes longer than checking them

    graph = nx.DiGraph((k, other) for k, called in needs.items() for other in called)
    for circle in nx.strongly_connected_components(graph):
        first = next(k for k in needs if k in circle)
        if len(circle) > 1 or graph.has_edge(first, first):
            yield first, [k for k, _ in nx.find_cycle(graph.subgraph(circle), first)], circle


def tell(report: Report, cell: Cell, problem: FormulaProblem) -> None:
    """Report a formula's problem, and the others of the same formula, at its cell."""
    for one in problem.every:
        span = (one.column, one.column + one.length) if one.column >= 0 else None
        report.add(one.code, cell.address, span=span, fixes=_corrected(cell, one), **one.details)
