"""Another name for a stream or a helper in all cells of a workbook that have it."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

from rrp_sheets.connectors.combine_latest import COMBINATION
from rrp_sheets.diagnostics.report import Diagnostic, Fix, Put, Replace, Report, surely
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas import replace_names
from rrp_sheets.graph import BehaviourGraph, Graph
from rrp_sheets.graph.device_table import done_of
from rrp_sheets.model.names import argument_name, is_reserved, key
from rrp_sheets.model.workbook import Address, Behaviour, Cell, Row, Workbook
from rrp_sheets.scene.scene_sheet import read_time
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook.schema import SHEETS

if TYPE_CHECKING:
    from rrp_sheets.checks.check import Checked

_ANOTHER = N_("Choose another name.")


@dataclass(frozen=True)
class Renaming:
    """Edits that give a stream, a helper or a column of a table another name.

    Attributes:
        edits: one for each cell that has the name.
        unsafe: cells with formulas in which the name means something else too: they must be changed by hand.
        unsure: edits of cells where it is not known whether the name means this; of a cell that is also in `edits`,
            with all places changed.
    """

    edits: tuple[Put, ...]
    unsafe: tuple[Address, ...] = ()
    unsure: tuple[Put, ...] = ()

    def including(self, cells: Collection[str]) -> Renaming:
        """Return the renaming with the uncertain edits of some cells (`Helpers!C2`) among those that are made."""
        chosen = {e.address: e for e in self.unsure if str(e.address) in cells}
        edits = {e.address: e for e in self.edits} | chosen
        left = tuple(e for e in self.unsure if e.address not in chosen)
        return replace(self, edits=tuple(edits.values()), unsure=left)


def rename(checked: Checked, old: str, new: str, sheet: str = "", *, near: str = "") -> Renaming:
    """Return the edits that give a stream or a helper another name.

    Args:
        checked: the workbook with the old name.
        old: the name of a row's output, of a stream of the sheet Devices, or of a helper.
        new: the wanted name.
        sheet: where the name is given, if that is not clear: a behaviour, or the sheet Devices or Helpers.
        near: of several sheets that give the name this one is meant, or else that of the devices.

    Raises:
        SheetsError: nothing has that name, several sheets have it, or the new name cannot be used.
    """
    found = _givers(checked, old, new)
    if sheet and key(sheet) not in {key(name) for name in (*checked.workbook.sheets, *(one.sheet for one in found))}:
        raise SheetsError(N_("There is no sheet “{sheet}”.", sheet=sheet), N_("Look at the names of the sheets."))
    there = [one for one in found if one.there and key(sheet) in ("", key(one.sheet))]
    if len(there) > 1 and near:
        wanted = (key(near), key(SHEETS["devices"].title))
        there = [one for k in wanted for one in there if key(one.sheet) == k][:1] or there
    if len(there) > 1:
        sheets = listed([one.sheet for one in there], "and")
        message = N_("“{name}” is a name in {sheets}.", name=old, sheets=sheets)
        raise SheetsError(message, N_("Write which one: {example}.", example=f"{there[0].sheet}!{old}"))
    if not there:
        if checked.robot.find(old) is not None or done_of(old):
            message = N_("“{name}” is the robot’s own name.", name=old)
            raise SheetsError(message, N_("Add a row with a name of your own to the sheet Devices."))
        message = N_("No row, device or helper has the name “{name}”.", name=old)
        raise SheetsError(message, N_("Look at the column Output stream, and at Devices and Helpers."))
    # a first cell that begins with # makes its row a comment; = and ' mean something else to spreadsheet programs
    if not argument_name(new) or new[0] in "#='" or any(c in new for c in ",\n!") or is_reserved(new):
        message = N_("“{name}” cannot be a name: formulas could not use it.", name=new)
        raise SheetsError(message, N_("Write letters, digits and spaces, such as Far ball."))
    if key(new) != key(old):
        there[0].refuse()
    return _renaming(there[0].places())


def is_named(checked: Checked, name: str) -> bool:
    """Return whether a row, a device or a helper gives a name."""
    return any(one.there for one in _givers(checked, name, ""))


def _givers(checked: Checked, old: str, new: str) -> list[_Stream | _Helper]:
    found: list[_Stream | _Helper] = [_Stream(checked, b, old, new) for b in checked.graph.behaviours]
    return [*found, _Stream(checked, None, old, new), _Helper(checked, old, new)]


def offer_new_names(workbook: Workbook, graph: Graph, report: Report, check: Callable[[Workbook], Checked]) -> None:
    """Offer to use the new name of a stream everywhere, where it seems to have been typed over its old one.

    So it seems where one name is missing in a behaviour, and one output is used nowhere and does not depend on it. With
    `check` the workbook is checked as it was before, to find what had the old name. The name of another stream that is
    nearly the missing one comes first.
    """
    for behaviour, graphed in zip(workbook.behaviours, graph.behaviours, strict=True):
        missing = [d for d in report if d.code == "GRAPH001" and d.address and d.address.sheet == behaviour.name]
        if len(missing) == 1:
            old = str(missing[0].details["name"])
            outputs = _unused(workbook, behaviour, graphed, old)
            if len(outputs) == 1:
                _offer(workbook, behaviour, missing[0], outputs[0], report, check)


def _unused(workbook: Workbook, behaviour: Behaviour, graphed: BehaviourGraph, missing: str) -> list[Row]:
    """Return the rows whose output nothing uses, without those that depend on a missing stream."""
    named = {key(row.stream.text.rpartition("!")[2]) for sheet in workbook.tests for row in sheet.rows}
    named |= {i.rpartition("!")[2] for step in graphed.steps for i in step.inputs}
    followers: dict[str, list[str]] = {}
    for row in behaviour.rows:
        for cell in row.inputs:
            followers.setdefault(key(cell.text), []).append(key(row.output.text))
    after, left = {key(missing)}, [key(missing)]
    while left:
        more = [output for output in followers.get(left.pop(), ()) if output not in after]
        after.update(more)
        left += more
    return [row for row in behaviour.rows if row.on and row.output and not _acts(row) and row.inputs
            and key(row.output.text) not in named and key(row.output.text) not in after]  # fmt: skip


def _offer(
    workbook: Workbook, behaviour: Behaviour, finding: Diagnostic, row: Row, report: Report,
    check: Callable[[Workbook], Checked],
) -> None:  # fmt: skip
    old, new, at = str(finding.details["name"]), row.output.text, row.output.address
    same = [fix for fix in finding.fixes if any(isinstance(e, Replace) and key(e.new) == key(new) for e in fix.edits)]
    if same and sum(key(old) in (key(cell.text) for cell in one.inputs) for one in behaviour.rows) < 2:
        return  # one row has it misspelt
    rows = tuple(replace(one, output=Cell(old, at, old)) if one is row else one for one in behaviour.rows)
    behaviours = tuple(replace(b, rows=rows) if b is behaviour else b for b in workbook.behaviours)
    try:
        done = rename(check(replace(workbook, behaviours=behaviours)), old, new, behaviour.name)
    except SheetsError:
        return
    edits = tuple(edit for edit in done.edits if edit.address != at)
    use = Fix(
        "use-new-name", N_("Use the new name “{new}” everywhere", new=new), edits, safe=any(fix.safe for fix in same)
    )
    back = Fix("restore-name", N_("Call the output “{old}” again", old=old), (Put(at, old, row.output.original),))
    others = [fix for fix in finding.fixes if fix not in same]
    near = [fix for fix in others if any(isinstance(e, Replace) and surely(old, e.new) for e in fix.edits)]
    report.offer(finding, (*near, use, back, *(fix for fix in others if fix not in near)))


_Place = tuple[Cell, Callable[[str], str | None]]
"""A cell, and what gives its text with the new name: None for a formula in which that is not safe."""


def _renaming(places: Iterator[_Place]) -> Renaming:
    edits, unsafe = [], []
    for cell, renamed in places:
        text = renamed(cell.original)
        if text is None:
            unsafe.append(cell.address)
        elif text != cell.original:
            edits.append(Put(cell.address, text, cell.original))
    return Renaming(tuple(edits), tuple(unsafe))


def _in_formula(
    tables: Collection[str], names: Mapping[str, str], owners: Mapping[str, Mapping[str, str]], typed: str
) -> str | None:
    """Return a formula with names by their keys, and fields by the names of their records; None where not safe."""
    found = replace_names(typed, names, owners, tables)
    return typed if found is None and not any(name in key(typed) for name in names) else found


def _tables(workbook: Workbook) -> set[str]:
    """Return the keys by which formulas may call the tables."""
    return {
        k for name in workbook.sheets if key(name) in workbook.tables for k in (key(name), key(argument_name(name)))
    }


class _Helper:
    """A helper that gets another name."""

    def __init__(self, checked: Checked, old: str, new: str) -> None:
        self.workbook, self.new, self.sheet = checked.workbook, new, SHEETS["helpers"].title
        self.old = key(argument_name(old))
        self.names = {key(argument_name(h.name.text)) for h in self.workbook.helpers}
        self.there = bool(self.old) and self.old in self.names
        self.tables = _tables(checked.workbook)

    def refuse(self) -> None:
        """Raise SheetsError when the new name is taken, or a formula with the helper means something else by it."""
        new = key(argument_name(self.new))
        if new in self.names | self.tables or key(self.new) in {key(sheet) for sheet in self.workbook.sheets}:
            raise SheetsError(N_("A helper or sheet “{name}” already exists.", name=self.new), _ANOTHER)
        for cell, inputs in self._formulas():
            if replace_names(cell.text, {self.old: ""}) not in (None, cell.text) and not _is_free(new, cell, inputs):
                raise _means_otherwise(self.new, cell.address)

    def _formulas(self) -> Iterator[tuple[Cell, set[str]]]:
        """Yield the formulas that may use the helper, each with the keys of its inputs: these come before helpers."""
        found = [(helper.formula, helper.inputs) for helper in self.workbook.helpers]
        found += [(row.formula, row.inputs) for behaviour in self.workbook.behaviours for row in behaviour.rows]
        for formula, cells in found:
            inputs = {key(argument_name(cell.text)) for cell in cells}
            if self.old not in inputs:
                yield formula, inputs

    def places(self) -> Iterator[_Place]:
        """Yield all cells that may have the name."""
        names = (h.name for h in self.workbook.helpers if key(argument_name(h.name.text)) == self.old)
        yield from ((name, lambda text: self.new) for name in names)
        renamed = partial(_in_formula, self.tables, {self.old: argument_name(self.new)}, {})
        yield from ((cell, renamed) for cell, _ in self._formulas())


class _Stream:
    """A stream that gets another name: of a row of `giver`, or without a giver of the sheet Devices."""

    def __init__(self, checked: Checked, giver: BehaviourGraph | None, old: str, new: str) -> None:
        self.graph, self.workbook = checked.graph, checked.workbook
        self.robot, self.facts, self.tables = checked.robot, checked.facts, _tables(checked.workbook)
        self.giver, self.old, self.new = giver, old, new
        spelt = {old: new} if giver else {old: new, f"{old} done": f"{new} done"}
        self.names = {key(before): after for before, after in spelt.items()}
        self.arguments = {key(argument_name(before)): argument_name(after) for before, after in spelt.items()}
        self.ids = {f"{giver.key}!{k}" for k in self.names} if giver else set(self.names)
        behaviours = [b for b in self.workbook.behaviours if giver is None or key(b.name) == giver.key]
        self.rows = [(b, row) for b in behaviours for row in b.rows]
        self.given = {key(row.output.text) for _, row in self.rows if not _acts(row)}
        self.devices = {key(d.stream.text) for d in self.workbook.devices}
        self.there = key(old) in (self.given if giver else self.devices)
        self.sheet = giver.name if giver else SHEETS["devices"].title

    def refuse(self) -> None:
        """Raise SheetsError when the new name is taken."""
        k = key(self.new)
        taken = self.given | self.devices | self.graph.streams.keys()
        acts = [of for of in (self.new if self.giver else "", done_of(self.new)) if of and self._is_actuator(of)]
        if k in taken or acts:
            raise SheetsError(N_("A stream is already called “{name}”.", name=self.new), _ANOTHER)
        argument = key(argument_name(self.new))
        for behaviour, row in self.rows:
            others = {key(argument_name(c.text)) for c in row.inputs if key(c.text) not in self.names}
            if self._reads(behaviour, row) and not _is_free(argument, row.formula, others):
                raise _means_otherwise(self.new, row.formula.address)

    def _is_actuator(self, name: str) -> bool:
        declared = (d.device.text for d in self.workbook.devices if key(d.stream.text) == key(name))
        found = self.robot.find(next(declared, name))
        return found is not None and found.type.kind == "actuator"

    @cached_property
    def _steps(self) -> dict[tuple[str, int], tuple[str, ...]]:
        return {(b.key, s.number): s.inputs for b in self.graph.behaviours for s in b.steps}

    def _inputs(self, behaviour: Behaviour, row: Row) -> Collection[str]:
        """Return the ids of a row's inputs, also where the row is faulty."""
        prefix = f"{self.giver.key}!" if self.giver else ""
        known = self._steps.get((key(behaviour.name), row.number))
        return [f"{prefix}{key(c.text)}" for c in row.inputs] if known is None else known

    def _reads(self, behaviour: Behaviour, row: Row) -> bool:
        return not self.ids.isdisjoint(self._inputs(behaviour, row))

    def _owners(self, inputs: Collection[str]) -> dict[str, Mapping[str, str]]:
        """Return the inputs, as formulas call them, that are combinations with a field of the old name."""
        streams = self.graph.streams
        found = {key(argument_name(streams[i].name)): self.arguments for i in inputs if self._combines(i)}
        return {**found, "value": self.arguments} if found and len(inputs) == 1 else {**found}

    def _combines(self, stream: str) -> bool:
        fact = self.facts.get(stream)
        record = fact.known.record if fact and stream in self.graph.streams else None
        return record is not None and record.name == COMBINATION and not record.names.keys().isdisjoint(self.names)

    def places(self) -> Iterator[_Place]:
        """Yield all cells that may have the name."""
        if self.giver is None:
            yield from ((d.stream, self._in_list) for d in self.workbook.devices)
        for behaviour, row in self.rows:
            yield row.inputs_cell, self._in_list
            names = self.arguments if self._reads(behaviour, row) else {}
            owners = self._owners(self._inputs(behaviour, row))
            if names or owners:
                yield row.formula, partial(_in_formula, self.tables, names, owners)
            if _acts(row) is (self.giver is None):
                yield row.output, self._in_list
        yield from self._test_places()
        yield from self._scene_places()

    def _test_places(self) -> Iterator[_Place]:
        for row in (row for sheet in self.workbook.tests for row in sheet.rows):
            stream = self._id(row.stream.text)
            if stream in self.ids:
                yield row.stream, partial(self._sub, r"[^!]+$", self.names)
            if self._combines(stream):
                yield row.expect, partial(self._sub, r"(?<![\w.])[^\W\d]\w*(?=\s*=)", self.arguments)

    def _scene_places(self) -> Iterator[_Place]:
        labelled = self._is_label()
        for row in self.workbook.scene or ():
            when = read_time(row.time.text)
            if when is not None and when.cue and self._id(when.cue) in self.ids:
                yield row.time, partial(self._sub, r"[^!+]+(?=\+[^+]*$)", self.names)
            if labelled and key(row.does.text) in ("press", "presses"):
                yield row.value, self._in_list

    def _is_label(self) -> bool:
        """Return whether the name stands on a button: on one without a label of its own, and on no other."""
        buttons = [d for d in self.workbook.devices if (f := self.robot.find(d.device.text)) and f.type.is_button]
        labels = {key(str(d.settings.get("label") or "")) for d in buttons}
        mine = [d for d in buttons if key(d.stream.text) == key(self.old) and self.giver is None]
        return any(not d.settings.get("label") for d in mine) and key(self.old) not in labels

    def _id(self, text: str) -> str:
        """Return the id of the stream that a test or the scene names; of several the one in the first sheet."""
        sheet, mark, name = text.rpartition("!")
        k, sheet = key(name), key(sheet.strip().strip("'"))
        if mark:
            return f"{sheet}!{k}"
        if k in self.graph.streams or k in self.devices or k in self.ids:
            return k
        return next((i for b in self.graph.behaviours if (i := f"{b.key}!{k}") in self.graph.streams), "")

    def _in_list(self, text: str) -> str:
        return self._sub(r"[^,\n]+", self.names, text)

    @staticmethod
    def _sub(pattern: str, names: Mapping[str, str], text: str) -> str:
        def part(match: re.Match[str]) -> str:
            name = match[0].strip()
            return match[0].replace(name, names[key(name)]) if key(name) in names else match[0]

        return re.sub(pattern, part, text)


def _is_free(argument: str, formula: Cell, inputs: Collection[str]) -> bool:
    """Return whether a formula with these inputs calls nothing by a name, which is given as its key."""
    inside = replace_names(formula.text, {argument: "\0"})
    return argument not in inputs and (inside is None or "\0" not in inside)


def _means_otherwise(name: str, at: Address) -> SheetsError:
    return SheetsError(
        N_("“{name}” means something else in row {row}.", name=name, row=f"{at.sheet}!{at.row}"), _ANOTHER
    )


def _acts(row: Row) -> bool:
    return key(row.connector.text) == "subscribe"
