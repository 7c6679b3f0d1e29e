"""LINT005 and LINT016: texts in formulas and cells of tables that are never equal to what they are compared with."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import NoneType

from rrp_sheets.checks.facts import RECORD, AbstractValue, known_of
from rrp_sheets.checks.formulas import rewrite
from rrp_sheets.checks.lints.context import LintContext
from rrp_sheets.diagnostics.report import Fix, meant
from rrp_sheets.formulas import Formula, Table
from rrp_sheets.formulas.tree import texts_compared
from rrp_sheets.graph import Step
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import Cell
from rrp_sheets.texts import N_, listed

_LOOK_UP = frozenset({"XLOOKUP", "MATCH"})
_SHOWN = 12  # texts that are listed
_MOST_CALLS = 1_000  # of helpers that are followed
NEVER_PASSES = N_("No value can pass this filter")


@dataclass
class _Column:
    """A column of a table that is compared with something, and the texts that this can be."""

    table: Table
    name: str
    step: Step  # the first row that does so
    comes: dict[str, str] = field(default_factory=dict)  # by the text as it is compared
    anything: bool = False  # one row compares it with what may be any text
    varies: bool = False  # one row compares it with more than a text, of which LINT005 tells


def lint_unmatched(context: LintContext) -> None:
    """Report texts of a table that nothing can be equal to, where the sensors say what they can give."""
    columns: dict[tuple[str, str], _Column] = {}
    for step in context.steps():
        formula = context.compiled.formulas.get(step.ref)
        if formula is None:
            continue
        names = {name: context.fact(stream).known for name, stream in _inputs(formula, step).items()}
        for table, name, with_what, varies in _compared(formula.tree, names, context.compiled.tables):
            column = columns.setdefault((table.name, key(name)), _Column(table, name, step))
            column.anything, column.varies = column.anything or with_what.choices is None, column.varies or varies
            column.comes.update({c.casefold(): c for c in with_what.choices or () if isinstance(c, str)})
    for column in columns.values():
        if column.comes and column.varies and not column.anything:
            _tell(column, context)


def _inputs(formula: Formula, step: Step) -> dict[str, str]:
    """Return the input streams of a row by their names in its formula."""
    return dict(zip(formula.names[len(step.connector.extra) :], step.inputs, strict=False))


def _tell(column: _Column, context: LintContext) -> None:
    texts = dict.fromkeys(v for v in column.table.column(column.name) if isinstance(v, str))
    missing = [t for t in texts if t.casefold() not in column.comes]
    if not missing or column.step.ref in context.routes.dead:  # that nothing passes is told there
        return
    can = list(column.comes.values())
    guess = nearest(missing[0], can) if len(missing) == 1 else None
    remedy = meant(guess, N_("Write one of these, or add this value to the sensor."), quoted=True)
    context.report.add(
        "LINT016", column.step.row.formula.address, texts=_listed([f"“{t}”" for t in missing]), column=column.name,
        sheet=column.table.name, can=_listed(can), **remedy,
    )  # fmt: skip


def _listed(texts: Sequence[str], joiner: str = "") -> str:
    shown = listed(texts[:_SHOWN], joiner)
    return N_("{shown} and {n} more", shown=shown, n=len(texts) - _SHOWN) if len(texts) > _SHOWN else shown


def _compared(
    tree: ast.AST, names: Mapping[str, AbstractValue], tables: Mapping[str, Table]
) -> Iterator[tuple[Table, str, AbstractValue, bool]]:
    """Yield the columns that a formula compares, what is known about the other side, and if that is no fixed text."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
            sides = node.left, node.comparators[0]
            for cell, other in (sides, sides[::-1]):
                found = _cell(cell, names, tables)
                if found is not None and _cell(other, names, tables) is None:
                    yield *found, known_of(other, names), not isinstance(other, ast.Constant)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _LOOK_UP:
            found = _whole(node.args[1], tables)
            if found is not None:
                yield *found, known_of(node.args[0], names), True


def _cell(node: ast.AST, names: Mapping[str, AbstractValue], tables: Mapping[str, Table]) -> tuple[Table, str] | None:
    """Return the table's column that a field of its row belongs to, as in `part.zone`; None for other nodes."""
    if not isinstance(node, ast.Attribute):
        return None
    known = known_of(node.value, names)
    table = tables.get(key(known.record.name)) if known.kind == RECORD and known.record is not None else None
    if table is None or known.record != table.type or key(node.attr) not in table.type.keys:
        return None
    return table, next((f.name for f in table.type.fields if key(f.name) == key(node.attr)), node.attr)


def _whole(node: ast.AST, tables: Mapping[str, Table]) -> tuple[Table, str] | None:
    """Return the column of `Parts[Zone]`, found by its values, which stand in the tree instead; else None."""
    if not isinstance(node, ast.Constant) or not isinstance(node.value, list):
        return None
    columns = ((table, one.name) for table in tables.values() for one in table.type.fields)
    return next(((table, name) for table, name in columns if table.column(name) == node.value), None)


# ---- texts in formulas
def lint_never_equal(context: LintContext) -> None:
    """Report texts that are compared with a value that has others only, such as a colour that no sensor gives."""
    found: dict[tuple[Cell, str, str, bool, bool], list[AbstractValue]] = {}
    calls = 0

    def collect(tree: ast.AST, names: Mapping[str, AbstractValue], cell: Cell, dead: bool) -> None:
        nonlocal calls
        for what, text, _ in texts_compared(tree):
            name = what.id if isinstance(what, ast.Name) else what.attr
            of_field = isinstance(what, ast.Attribute)
            found.setdefault((cell, text, name, dead, of_field), []).append(known_of(what, names))
        for node in ast.walk(tree):
            helper = getattr(node, "helper", None)
            if helper is not None and helper.tree is not None and isinstance(node, ast.Call) and calls <= _MOST_CALLS:
                calls += 1
                given = {p.name: known_of(a, names) for p, a in zip(helper.parameters, node.args, strict=True)}
                collect(helper.tree, given, context.compiled.helpers.cells[key(helper.shown)][1], False)

    for step in context.steps():
        if (formula := context.compiled.formulas.get(step.ref)) is not None:
            inputs = _inputs(formula, step)
            known = {name: context.fact(stream).known for name, stream in inputs.items()}
            collect(formula.tree, known, step.row.formula, step.ref in context.routes.dead)
            _tell_translated(formula.tree, inputs, step, context)
    for (cell, text, name, dead, of_field), values in found.items() if calls <= _MOST_CALLS else ():
        can = [c for known in values for c in known.choices or (0,)]
        texts = list(dict.fromkeys(c for c in can if isinstance(c, str)))
        closed = all(isinstance(c, (str, NoneType)) for c in can)
        if texts and closed and text.casefold() not in map(str.casefold, texts):
            _tell_never_equal(cell, text, name, texts, dead, context, of_field=of_field)


def _tell_translated(tree: ast.AST, streams: Mapping[str, str], step: Step, context: LintContext) -> None:
    """Report Japanese texts compared with the value of a done stream, which has the robot's own word for them."""
    for what, text, _ in texts_compared(tree):
        if not isinstance(what, ast.Attribute) or not isinstance(what.value, ast.Name):
            continue
        done = context.graph.streams.get(streams.get(what.value.id, ""))
        device = context.graph.streams[done.done_of].device if done and done.done_of else None
        own = context.robot.standard(device.type.name, text) if device else text
        if own != text and japanese.standard(japanese.FIELDS, key(what.attr)) == "value":
            why = N_("a done stream has the robot’s own name, “{guess}”", guess=str(own))
            dead = step.ref in context.routes.dead
            _tell_never_equal(step.row.formula, text, what.attr, [str(own)], dead, context, why)


def _tell_never_equal(
    cell: Cell, text: str, name: str, can: Sequence[str], dead: bool, context: LintContext, why: str = "",
    of_field: bool = False,
) -> None:  # fmt: skip
    own = (japanese.standard(words, text) for words in japanese.CHOICES.values())
    words = japanese.CHOICES.get(key(japanese.standard(japanese.FIELDS, name)), {})
    typed = next((word for word in japanese.words_for(words, text) if word in cell.text), text)
    guess = can[0] if why else next((one for one in own if one in can), None) or nearest(text, can)
    remedy = meant(guess, N_("Compare it with the values that its input can have."), quoted=True)["remedy"]
    if of_field and not typed.isascii():  # a field is compared with its Japanese words, too
        can = japanese.japanese(words, can)
    values = _listed([N_("“{text}”", text=one) for one in can], "or")
    why = why or N_("“{name}” can only be {values}, so this never matches", name=name, values=values)
    what = NEVER_PASSES if dead else N_("“{text}” never occurs", text=typed)
    fixes = _corrected(cell, typed, guess) if guess else ()
    context.report.add("LINT005", cell.address, what=what, why=why, remedy=remedy, fixes=fixes)


def _corrected(cell: Cell, wrong: str, guess: str) -> tuple[Fix, ...]:
    """Return the fix that writes the text that is meant; empty where it is uncertain which of several texts that is."""
    written = guess.replace('"', '""')
    text = rf"""(?P<open>["“”„'])\s*{re.escape(wrong)}\s*(?P<close>["“”'])"""
    for pattern in (rf"(?P<before>[=>≠]\s*){text}", rf"(?P<before>){text}(?=\s*[=<!≠])", rf"(?P<before>){text}"):
        new, count = re.subn(pattern, lambda m: f"{m['before']}{m['open']}{written}{m['close']}", cell.text)
        if count == 1:
            return (rewrite("correct-text", cell, new),)
    return ()
