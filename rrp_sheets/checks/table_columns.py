"""Another name for a column of a table, in its header and in the formulas and tests that read it."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rrp_sheets.checks.renaming import Renaming
from rrp_sheets.diagnostics.report import Put
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas import FormulaProblem
from rrp_sheets.formulas.tokens import Hole, Token, tokenize
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Cell
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.checks.check import Checked

_OPENING = {")": "(", "]": "["}


def rename_column(checked: Checked, table: str, old: str, new: str, headers: Sequence[str]) -> Renaming:
    """Return the edits outside of a table's sheet that give one of its columns another name.

    Args:
        checked: the workbook with the old name.
        table: the name of its sheet.
        old: the header of the column.
        new: the wanted header.
        headers: all headers of the sheet.

    Raises:
        SheetsError: the new name cannot be used.
    """
    if not argument_name(new) or new[0] in "#='" or any(c in new for c in "\n[]"):
        message = N_("“{name}” cannot be a name: formulas could not use it.", name=new)
        raise SheetsError(message, N_("Write letters, digits and spaces, such as Far ball."))
    if key(new) != key(old) and key(new) in map(key, headers):
        message = N_("The table has a column “{name}” already.", name=new)
        raise SheetsError(message, N_("Choose another name."))
    sure, unsure = [], []
    for cell, certain, perhaps in _Places(checked, table, old, new).found():
        if certain != cell.original:
            sure.append(Put(cell.address, certain, cell.original))
        if perhaps != certain:
            unsure.append(Put(cell.address, perhaps, cell.original))
    return Renaming(tuple(sure), unsure=tuple(unsure))


@dataclass(frozen=True, slots=True)
class _Field:
    """A place in a formula that reads a column: where, the text that takes its place, and whether that is certain."""

    start: int
    end: int
    text: str
    sure: bool


class _Places:
    """Cells that may read a column, each with the text for the certain places and the one for all of them."""

    def __init__(self, checked: Checked, table: str, old: str, new: str) -> None:
        self.checked, self.workbook = checked, checked.workbook
        self.table, self.new = table, new
        self.keys = {key(table), key(argument_name(table))}
        self.column, self.field = key(old), key(argument_name(old))
        self.tables = {
            k for name in self.workbook.sheets if key(name) in self.workbook.tables
            for k in (key(name), key(argument_name(name)))
        }  # fmt: skip
        self.records = {id: fact.known.record for id, fact in checked.facts.items()}

    def found(self) -> Iterator[tuple[Cell, str, str]]:
        """Yield the cells."""
        steps = {(b.key, s.number): s.inputs for b in self.checked.graph.behaviours for s in b.steps}
        streams = self.checked.graph.streams
        for behaviour in self.workbook.behaviours:
            for row in behaviour.rows:
                ids = steps.get((key(behaviour.name), row.number), ())
                inputs = {key(argument_name(streams[i].name)): self._is_mine(i) for i in ids if i in streams}
                if len(ids) == 1:
                    inputs["value"] = self._is_mine(ids[0])
                inputs |= {
                    key(argument_name(c.text)): None for c in row.inputs if key(argument_name(c.text)) not in inputs
                }
                yield from self._formula(row.formula, inputs)
        for helper in self.workbook.helpers:
            yield from self._formula(helper.formula, {key(argument_name(c.text)): None for c in helper.inputs})
        for test in (row for sheet in self.workbook.tests for row in sheet.rows):
            name = key(test.stream.text.rpartition("!")[2])
            if any(self._is_mine(i) for i in self.records if i.rpartition("!")[2] == name):
                for cell in (test.send, test.expect):
                    text = re.sub(r"(?<![\w.])[^\W\d]\w*(?=\s*=)", self._test_field, cell.original)
                    yield cell, text, text

    def _test_field(self, match: re.Match[str]) -> str:
        return argument_name(self.new) if key(match[0]) == self.field else match[0]

    def _is_mine(self, stream: str) -> bool | None:
        """Return whether a stream carries rows of the table; None where that is not known."""
        record = self.records.get(stream)
        return None if record is None else key(record.name) == key(self.table)

    def _formula(self, cell: Cell, inputs: Mapping[str, bool | None]) -> Iterator[tuple[Cell, str, str]]:
        typed = cell.original
        try:
            tokens = tokenize(typed, lambda name: key(name) in self.tables)
        except FormulaProblem:
            return
        fields = sorted(self._fields(tokens, inputs), key=lambda field: field.start)
        if fields:
            yield cell, _replaced(typed, [f for f in fields if f.sure]), _replaced(typed, fields)

    def _fields(self, tokens: Sequence[Token], inputs: Mapping[str, bool | None]) -> Iterator[_Field]:
        owners = {**inputs, **self._loops(tokens)}
        for i, token in enumerate(tokens):
            if token.kind == "texts":
                for part in token.parts:
                    if isinstance(part, Hole):
                        yield from self._fields(part.tokens, owners)
            elif token.kind == "column" and key(str(token.parts[0])) in self.keys and key(token.text) == self.column:
                begin = token.start + len(str(token.parts[0])) + 1
                yield _Field(begin, token.end - 1, self.new, sure=True)
            elif token.kind == "name" and i > 1 and tokens[i - 1].text == "." and key(token.text) == self.field:
                mine = self._owned(tokens, i - 2, owners)
                if mine is not False:
                    yield _Field(token.start, token.end, argument_name(self.new), sure=mine is True)

    def _owned(self, tokens: Sequence[Token], at: int, owners: Mapping[str, bool | None]) -> bool | None:
        """Return whether what stands before a dot is a row of the table; None where that is not known."""
        token = tokens[at]
        if token.kind == "name" and (at == 0 or tokens[at - 1].text != "."):
            name = key(token.text)
            return True if name in self.keys else owners.get(name)
        if token.text in _OPENING:
            begin = _opening(tokens, at)
            owner = begin - 1 if begin > 0 and tokens[begin - 1].kind == "name" else begin
            return self._one_of_mine(tokens[owner:at])
        return None

    def _loops(self, tokens: Sequence[Token]) -> dict[str, bool | None]:
        """Return for each name that goes through a list whether that is the table."""
        found: dict[str, bool | None] = {}
        for i, token in enumerate(tokens[:-3]):
            if token.kind == "name" and token.text == "for" and tokens[i + 2].text == "in":
                ends = (j for j in range(i + 3, len(tokens)) if tokens[j].text in ("for", "if", "]"))
                found[key(tokens[i + 1].text)] = self._one_of_mine(tokens[i + 3 : next(ends, len(tokens))])
        return found

    def _one_of_mine(self, tokens: Collection[Token]) -> bool | None:
        """Return whether some tokens name the table as a whole, and no other one; None when they name none."""
        named = {key(t.text) for t in tokens if t.kind == "name" and key(t.text) in self.tables}
        if not named:
            return None
        return named <= self.keys if named.isdisjoint(self.keys) or named <= self.keys else None


def _opening(tokens: Sequence[Token], at: int) -> int:
    """The place of the bracket that the one at a place closes."""
    depth = 0
    for i in range(at, -1, -1):
        depth += {")": 1, "]": 1, "(": -1, "[": -1}.get(tokens[i].text if tokens[i].kind == "sign" else "", 0)
        if not depth:
            return i
    return 0


def _replaced(typed: str, fields: Sequence[_Field]) -> str:
    for field in reversed(fields):
        typed = typed[: field.start] + field.text + typed[field.end :]
    return typed
