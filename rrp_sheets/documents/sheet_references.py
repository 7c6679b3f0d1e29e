"""References of a workbook to its own sheets: tests, the Protocol's Run, switches of behaviours, tables in formulas."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from rrp_sheets.checks.tests import quoted_sheet
from rrp_sheets.formulas.problems import FormulaProblem
from rrp_sheets.formulas.tokens import Hole, Token, tokenize
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Address, Cell, Workbook
from rrp_sheets.robots import load_robot, robot_names
from rrp_sheets.workbook.sheet_readers import words

Texts = Callable[[Address], str]
"""Text of a cell, as it was typed."""
_SEPARATORS = re.compile(r"([,;\n])")


def renamed_cells(workbook: Workbook, texts: Texts, old: str, new: str) -> dict[Address, str]:
    """The cells that name a sheet, with what they say when it has another name; `texts` gives what was typed."""
    k = key(old)
    found: dict[Address, str] = {}
    for cell in _tests(workbook, k):
        text = texts(cell.address)
        head, bang, stream = text.rpartition("!")
        if bang:
            found[cell.address] = f"{_spaced(head, quoted_sheet(new))}!{stream}"
    for cell in _switches(workbook, k):
        found[cell.address] = _spaced(texts(cell.address), new)
    run = run_cell(workbook)
    if run is not None and any(key(name) == k for name in run_names(run.text)):
        found[run.address] = "".join(
            _spaced(part, new) if key(part) == k else part for part in _SEPARATORS.split(texts(run.address))
        )
    for cell in _formulas(workbook, k):
        text = texts(cell.address)
        if (changed := renamed_table(text, old, new)) != text:
            found[cell.address] = changed
    return {at: text for at, text in found.items() if text != texts(at)}


def _tests(workbook: Workbook, k: str) -> Iterator[Cell]:
    for test in workbook.tests:
        for row in test.rows:
            sheet, bang, _ = row.stream.text.rpartition("!")
            if bang and key(sheet.strip().strip("'")) == k:
                yield row.stream


def _switches(workbook: Workbook, k: str) -> Iterator[Cell]:
    name = workbook.protocol.robot
    robot = load_robot(name if name in robot_names() else "nao")
    for device in workbook.devices:
        found = robot.find(device.device.text)
        for setting, cell in device.settings.items():
            known = found.type.settings.get(setting) if found else None
            if known is not None and known.kind == "behaviour" and cell and key(cell.text) == k:
                yield cell


def _formulas(workbook: Workbook, k: str) -> Iterator[Cell]:
    """The formulas that may name a table; a name that is an input or a helper means that one."""
    if k not in workbook.tables or any(key(h.name.text) == k for h in workbook.helpers):
        return
    for behaviour in workbook.behaviours:
        yield from (r.formula for r in behaviour.rows if r.formula and not _has(r.inputs, k))
    yield from (h.formula for h in workbook.helpers if h.formula and not _has(h.inputs, k))


def users(workbook: Workbook, sheet: str) -> Iterator[Cell]:
    """The cells that use what a sheet makes: its streams, devices and helpers, by their names."""
    k = key(sheet)
    made = {key(r.output.text) for b in workbook.behaviours if key(b.name) == k for r in b.rows if r.output}
    yield from (r.stream for t in workbook.tests if key(t.name) != k for r in t.rows if key(r.stream.text) in made)
    streams = {key(d.stream.text) for d in workbook.devices if key(d.stream.address.sheet) == k}
    rows = [(b, r) for b in workbook.behaviours for r in b.rows if key(b.name) != k]
    yield from (cell for _, r in rows for cell in (*r.inputs, r.output) if cell and key(cell.text) in streams)
    helpers = {key(h.name.text) for h in workbook.helpers if key(h.name.address.sheet) == k}
    yield from (r.formula for _, r in rows if r.formula and helpers & words([r.formula.text]))


def _has(names: Sequence[Cell], k: str) -> bool:
    return any(key(argument_name(name.text)) == k for name in names)


def renamed_table(formula: str, old: str, new: str) -> str:
    """A formula in which a table has another name; one that cannot be understood stays as it is.

    >>> renamed_table('XLOOKUP(step; Steps[Steps]; Steps) & "Steps" & f"{ROWS(Steps)}"', "Steps", "My steps")
    'XLOOKUP(step; mySteps[Steps]; mySteps) & "Steps" & f"{ROWS(mySteps)}"'
    """
    keys = {key(old), key(argument_name(old))}
    name = new if new.isidentifier() else argument_name(new)
    try:
        tokens = tokenize(formula, lambda word: key(word) in keys)
    except FormulaProblem:
        return formula
    spans = sorted(_spans(tokens, keys), reverse=True)
    for start, end in spans:
        formula = formula[:start] + name + formula[end:]
    return formula


def _spans(tokens: Sequence[Token], keys: set[str]) -> Iterator[tuple[int, int]]:
    before = ""
    for token in tokens:
        if token.kind == "name" and key(token.text) in keys and before != ".":
            yield token.start, token.end
        elif token.kind == "column" and key(str(token.parts[0])) in keys:
            yield token.start, token.start + len(str(token.parts[0]))
        elif token.kind == "texts":
            for part in token.parts:
                if isinstance(part, Hole):
                    yield from _spans(part.tokens, keys)
        before = token.text


def run_cell(workbook: Workbook) -> Cell | None:
    """The Protocol's Run, when it lists names."""
    cell = workbook.protocol.fields.get("run")
    return cell if cell and key(cell.text) != "all" else None


def run_names(text: str) -> list[str]:
    """The names that it lists."""
    return [name for part in _SEPARATORS.split(text)[::2] if (name := part.strip())]


def _spaced(text: str, new: str) -> str:
    """A name instead of a text, with the text's spaces around it."""
    bare = text.strip()
    return text.replace(bare, new, 1) if bare else new
