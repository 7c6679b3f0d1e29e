"""The two remedies for a stale combination, as rows to insert."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.checks.lints.material import Material
from rrp_sheets.checks.renaming import renamed
from rrp_sheets.diagnostics.fix import Fix, FixEdit, Insert, Put
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.graph import Step
from rrp_sheets.model.cells import Address
from rrp_sheets.model.names import argument_name, key

LONGEST_SECONDS = 1
LONGEST_AGE = f"{LONGEST_SECONDS} s"


def remedies(step: Step, rare: str, material: Material) -> list[Fix]:
    """Forgetting the old value, or timestamps; none for a row whose formula or names they could not follow."""
    formula = step.row.formula.text
    named = [material.graph.streams[i].name for i in step.inputs]
    if not formula or not all(named) or not step.row.inputs:
        return []
    made = [_forgetting(step, rare, material), _timing(step, material)]
    return [fix for fix in made if fix is not None]


def _forgetting(step: Step, rare: str, material: Material) -> Fix | None:
    old = material.graph.streams[rare].name
    recent = _free(f"Recent {old}", step, material)
    text = _opened(step, material)
    inner = renamed(text, {argument_name(old): argument_name(recent)})
    if inner is None:
        return None
    inputs = ", ".join(recent if key(c.text) == key(old) else c.text for c in step.row.inputs)
    formula = f"IF(ISBLANK({argument_name(recent)}); BLANK; {inner})"
    row = _Writer(step)
    row.insert(old, "forgetAfter", LONGEST_AGE, recent)
    if _only_sent(step, material):  # the blank stops the actuator
        row.put(inputs, formula, step.row.output.text)
    else:
        either = _free(f"{step.row.output.text or 'Joined'} or blank", step, material)
        row.put(inputs, formula, either)
        row.insert(either, "filter", f"NOT(ISBLANK({argument_name(either)}))", step.row.output.text, after=True)
    title = Phrase("Forget “{name}” {age} after its last value (forgetAfter)", name=old, age=LONGEST_AGE)
    return Fix(title, tuple(row.edits))


def _timing(step: Step, material: Material) -> Fix | None:
    names = [material.graph.streams[i].name for i in step.inputs]
    timed = {n: _free(f"{n} with time", step, material) for n in names}
    text = _opened(step, material)
    inner = renamed(text, {argument_name(n): f"{argument_name(t)}.v" for n, t in timed.items()})
    if inner is None:
        return None
    times = "; ".join(f"{argument_name(t)}.t" for t in timed.values())
    output = step.row.output.text or _free("Joined", step, material)
    pair, fresh = _free(f"{output} and age", step, material), _free(f"Fresh {output}", step, material)
    row = _Writer(step)
    for name, new in timed.items():
        row.insert(name, "timestamp", "", new)
    row.put(", ".join(timed.values()), f"({inner}, MAX({times}) - MIN({times}))", pair)
    row.insert(pair, "filter", f"{argument_name(pair)}[1] < {LONGEST_SECONDS}", fresh, after=True)
    row.insert(fresh, "map", f"{argument_name(fresh)}[0]", step.row.output.text, after=True)
    return Fix(Phrase("Join only what came within {age} of each other (timestamp)", age=LONGEST_AGE), tuple(row.edits))


class _Writer:
    """Edits around a row; what is inserted before it moves it down."""

    def __init__(self, step: Step) -> None:
        row = step.row
        self.sheet = row.output.address.sheet
        cells = (row.inputs_cell, row.connector, row.formula, row.output)
        self.columns = [c.address.column for c in cells]
        self.number = row.number
        self.below = 0  # rows inserted after it
        self.edits: list[FixEdit] = []

    def insert(self, *texts: str, after: bool = False) -> None:
        """Insert a row just before the row, or just after it."""
        cells = tuple((c, t) for c, t in zip(self.columns, texts, strict=True) if t)
        self.edits.append(Insert(self.sheet, self.number + self.below + 1 if after else self.number, cells))
        self.number += not after
        self.below += after

    def put(self, inputs: str, formula: str, output: str) -> None:
        """Change the row itself; what is the same already is left alone."""
        for column, text in zip((self.columns[0], *self.columns[2:]), (inputs, formula, output), strict=True):
            self.edits.append(Put(Address(self.sheet, self.number, column), text))


def _opened(step: Step, material: Material) -> str:
    """The row's formula; a helper's name alone becomes a call of it."""
    text = step.row.formula.text
    helper = material.compiled.helpers.by_key.get(key(text))
    if helper is None or not helper.parameters:
        return text.removeprefix("=")
    names = ", ".join(argument_name(material.graph.streams[i].name) for i in step.inputs)
    return f"{argument_name(helper.shown)}({names})"


def _only_sent(step: Step, material: Material) -> bool:
    """Whether all that take what the row gives send it on to actuators as it is."""
    readers = material.readers.get(step.output, [])
    return all(r.connector.is_sink and not r.row.formula for r in readers)


def _free(name: str, step: Step, material: Material) -> str:
    """A name that no stream of the workbook has."""
    sheet = key(step.row.output.address.sheet)
    streams: Mapping[str, object] = material.graph.streams
    taken, wanted, n = name, name, 2
    while key(taken) in streams or f"{sheet}!{key(taken)}" in streams:
        taken, n = f"{wanted} {n}", n + 1
    return taken
