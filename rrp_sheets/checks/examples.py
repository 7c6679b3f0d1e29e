"""Example values: what every row gives for the examples of its inputs.

Formulas are evaluated by an interpreter of this check alone, so that nothing of it reaches a run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce

from rrp_sheets.checks.facts import (
    ANY,
    BLANK,
    CHANGE,
    EVENT,
    NUMBER,
    RECORD,
    TIMER,
    UNKNOWN,
    AbstractValue,
    Fact,
    Rate,
    either,
    exactly,
    fastest,
    known_of,
    not_blank,
    slower,
)
from rrp_sheets.connectors.combine_latest import together
from rrp_sheets.connectors.spec import Passing
from rrp_sheets.connectors.timestamp import TIMED
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.limits import STEPS
from rrp_sheets.formulas.problems import kind_of_value
from rrp_sheets.graph import Graph, Step
from rrp_sheets.model.values import Failure, Field, Record, RecordType, Value

MOST_STEPS = 1_000_000
"""Of all example evaluations of one check together: a workbook full of endless work is checked quickly all the same."""
MOST_OTHERS = 4


@dataclass(frozen=True, slots=True)
class Trouble:
    """A formula's failure on an example, and the values of its inputs by name."""

    failure: Failure
    values: tuple[tuple[str, Value], ...]


class Examples:
    """Evaluates the rows on example values, within one number of steps for the whole check."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._interpreter = GuardedInterpreter()
        self._left = MOST_STEPS
        self._prepared: dict[tuple[str, tuple[str, ...]], Callable[..., Value]] = {}

    def work_out(self, step: Step, facts: Sequence[Fact], formula: Formula | None) -> tuple[Fact, Trouble | None]:
        """Return the fact about a row's output, and the trouble if its formula fails, from the facts of its inputs."""
        name = step.connector.name
        if step.row.formula and formula is None and step.period_us is None:
            return Fact(), None  # its formula is wrong, which is told elsewhere
        if name == "accumulate":
            return self._accumulate(step, facts, formula)
        if name == "combineLatest" and formula is None:
            return self._together(step, facts), None
        if name == "merge":
            return _merged(facts), None
        if name == "timestamp":
            return _timed(facts[0]), None
        if name == "filter":
            return (Fact(), None) if formula is None else self._filter(formula, facts)
        if step.connector.passes is not None:
            return _passed(step.connector.passes, facts[0], step.period_us), None
        if formula is not None:
            return self._mapped(step, formula, facts)
        return (_merged(facts) if step.connector.is_sink else Fact()), None

    # ---- connectors with a formula
    def _mapped(self, step: Step, formula: Formula, facts: Sequence[Fact]) -> tuple[Fact, Trouble | None]:
        known = known_of(formula.tree, dict(zip(formula.names, [f.known for f in facts], strict=True)))
        rate = fastest([f.rate for f in facts]) if step.connector.name == "combineLatest" else facts[0].rate
        fact = Fact(known, rate=rate, sure=all(f.sure for f in facts))
        result, trouble = self._evaluate(formula, facts)
        if isinstance(result, Failure):
            # what would follow from a formula that fails only follows from that
            return (fact if trouble is None else replace(fact, known=UNKNOWN)), trouble
        return _with_example(fact, result), None

    def _filter(self, formula: Formula, facts: Sequence[Fact]) -> tuple[Fact, Trouble | None]:
        first = facts[0]
        result, trouble = self._evaluate(formula, facts)
        passes = type(result) in (bool, int, float) and bool(result)
        if not passes and first.known.blank and trouble is None:
            blank = replace(first, example=None, has_example=True)
            again, _ = self._evaluate(formula, [blank, *facts[1:]])
            if type(again) in (bool, int, float) and again:  # it lets only the blank pass
                return replace(blank, known=exactly(None), rate=Rate(EVENT)), None
        if passes and first.example is not None:
            known = not_blank(first.known) if self._refuses_blank(formula, facts) else first.known
            return replace(first, known=known), None
        return replace(first, sure=first.sure and passes), trouble

    def _refuses_blank(self, formula: Formula, facts: Sequence[Fact]) -> bool:
        """Return whether a filter never lets blank pass: its formula fails on it or does not hold."""
        if not facts[0].known.blank or not all(f.has_example for f in facts):
            return False
        result = self.value(formula, [None, *(f.example for f in facts[1:])])
        return isinstance(result, Failure) or not result

    def _accumulate(self, step: Step, facts: Sequence[Fact], formula: Formula | None) -> tuple[Fact, Trouble | None]:
        rate = fastest([f.rate for f in facts])
        if formula is None:
            return Fact(AbstractValue(NUMBER, low=1.0), True, 1, rate=rate), None
        names = formula.names[len(step.connector.extra) :]
        inputs = {n: replace(f.known, blank=True, choices=None) for n, f in zip(names, facts, strict=True)}
        known = known_of(formula.tree, {"value": UNKNOWN, **inputs, "total": AbstractValue(NUMBER)})
        if known.kind != NUMBER:
            known = known_of(formula.tree, {"value": UNKNOWN, **inputs, "total": UNKNOWN})
        fact = Fact(known, rate=rate, sure=all(f.sure for f in facts))
        trouble = None
        for place, input_fact in enumerate(facts):
            if not input_fact.has_example:
                continue
            arrived = [input_fact.example if i == place else None for i in range(len(facts))]
            values = [0 if n == "total" else input_fact.example for n in step.connector.extra] + arrived
            result = self.value(formula, values)
            if not isinstance(result, Failure):
                fact = fact if fact.has_example else _with_example(fact, result)
            elif trouble is None and input_fact.sure and not _from_holes(result, [input_fact]):
                trouble = Trouble(result, tuple(zip(formula.names, values, strict=True)))
        return fact, trouble

    def _together(self, step: Step, facts: Sequence[Fact]) -> Fact:
        record = together(tuple(self._graph.streams[i].name for i in step.inputs))
        fields = dict(zip(record.positions, [f.known for f in facts], strict=True))
        rate = fastest([f.rate for f in facts])
        fact = Fact(AbstractValue(RECORD, record, fields), rate=rate, sure=all(f.sure for f in facts))
        if not all(f.has_example for f in facts):
            return fact
        example = Record(record, dict(zip(record.positions, [f.example for f in facts], strict=True)))
        return replace(fact, has_example=True, example=example, holes=any(f.holes for f in facts))

    # ---- evaluating
    def _evaluate(self, formula: Formula, facts: Sequence[Fact]) -> tuple[Value, Trouble | None]:
        if not all(f.has_example for f in facts):
            return _UNKNOWN, None
        values = [f.example for f in facts]
        result = self.value(formula, values)
        if not isinstance(result, Failure) or not all(f.sure for f in facts) or _from_holes(result, facts):
            return result, None
        return result, Trouble(result, tuple(zip(formula.names, values, strict=True)))

    def value(self, formula: Formula, values: Sequence[Value]) -> Value:
        """Return what a formula gives for these values; a Failure without code when this check's steps are used up."""
        if self._left <= 0:
            return _UNKNOWN
        at = (formula.text, formula.names)
        if at not in self._prepared:
            self._prepared[at] = formula.prepare(self._interpreter)
        result = self._prepared[at](*values)
        self._left -= STEPS - max(self._interpreter.steps, 0)
        return result


_UNKNOWN = Failure("", "")
_NOT_FOUND = frozenset({"FORM106", "FORM111", "FORM112"})
"""Looking up what is not there is how a workbook says that nothing is to happen; the examples cannot know."""


def _from_holes(failure: Failure, facts: Sequence[Fact]) -> bool:
    """Return whether a failure may be due to the example: it lacks a field, or a look-up finds nothing."""
    return not failure.code or failure.code in _NOT_FOUND or (failure.code == "FORM102" and any(f.holes for f in facts))


def _with_example(fact: Fact, value: Value) -> Fact:
    """Return the fact with an example, from which the type of an otherwise unknown record is taken."""
    known = fact.known
    if known.kind == RECORD and known.record is None and isinstance(value, Record):
        known = replace(known, record=value.type)
    return Fact(known, True, value, fact.sure, kind_of_value(value) == ANY, (), fact.rate)


def _merged(facts: Sequence[Fact]) -> Fact:
    first = facts[0]
    others = [o for f in facts for o in f.others]
    if first.has_example:
        others += [f.example for f in facts[1:] if f.has_example and not alike(first.example, f.example)]
    return replace(
        first, known=reduce(either, [f.known for f in facts]), others=tuple(others[:MOST_OTHERS]),
        rate=fastest([f.rate for f in facts]), sure=all(f.sure for f in facts), holes=any(f.holes for f in facts),
    )  # fmt: skip


def alike(first: Value, second: Value) -> bool:
    """Return whether two values are of one kind, and records of one type; blank goes with every value."""
    if len({kind_of_value(first), kind_of_value(second)} - {BLANK}) > 1:
        return False
    return not (isinstance(first, Record) and isinstance(second, Record)) or first.type == second.type


def _timed(fact: Fact) -> Fact:
    value = Field("value", example=fact.example if isinstance(fact.example, Record) else None)
    record = RecordType(TIMED.name, (value, *TIMED.fields[1:]), TIMED.aliases, TIMED.positions)
    known = AbstractValue(RECORD, record, {"value": fact.known, "timestamp": AbstractValue(NUMBER, low=0.0, unit="s")})
    if not fact.has_example:
        return Fact(known, rate=fact.rate)
    example = Record(record, {"value": fact.example, "timestamp": 1.0})
    return replace(fact, known=known, example=example, others=())


def _passed(passing: Passing, fact: Fact, period_us: int | None) -> Fact:
    known = fact.known
    if passing.blanks:
        known = replace(known, blank=True, choices=None if known.choices is None else (*known.choices, None))
    limited, rare = slower(fact.rate, period_us), {"changes": Rate(CHANGE), "events": Rate(EVENT)}
    rates = {"same": fact.rate, "limited": limited, "ticks": replace(limited, kind=TIMER), **rare}
    return replace(fact, known=known, rate=rates[passing.rate])
