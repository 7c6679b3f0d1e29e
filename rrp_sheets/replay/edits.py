"""Edits that were made during a run, applied again in its replay, from the trace to the rows of the workbook."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.diagnostics import Report
from rrp_sheets.engine.engine import Engine
from rrp_sheets.engine.live_edits import apply, compare, helper_text
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import Step
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address, Cell, Helper, Workbook
from rrp_sheets.replay.report import in_words
from rrp_sheets.texts import N_, sentences

_HELPERS = "Helpers!"
_HELPER = re.compile(r"\(([^()]*)\) (.*)", re.DOTALL)
Change = Mapping[str, Any]


class Editions:
    """State of the workbook that is played, while edits are applied to it.

    Args:
        plan: of the workbook that is played.
        rows: the places of rows in the workbook that is played, by their places in the one that ran.
        ran: the workbook that ran, when another one is played: tables that differ in that one are left as they are.
    """

    def __init__(self, plan: Plan, rows: Mapping[str, str] | None = None, ran: Workbook | None = None) -> None:
        self._plan = plan
        self._ran = ran
        self._rows = rows
        self._checked: Checked = plan.checked
        self._steps: Mapping[str, Step] = {s.ref: s for s in plan.steps}
        self._left: dict[str, list[str]] = {}

    @property
    def left_out(self) -> list[str]:
        """Edits that could not be applied, in words: the first of each place, and the number of others there."""
        more = {1: "", 2: N_("Another edit at this place is skipped, too.")}
        return [
            sentences(
                words[0],
                more[n] if (n := len(words)) in more else N_("{n} more edits at this place are skipped, too.", n=n - 1),
            )
            for words in self._left.values()
        ]

    def _leave(self, place: str, words: str) -> None:
        self._left.setdefault(place, []).append(words)

    def use(self, engine: Engine, changes: Sequence[Change]) -> None:
        """Apply the changes of one edit to the run that is played; what does not fit is left out."""
        edited = self._checked.workbook
        for change in changes:
            edited = self._changed(edited, change)
        if edited is self._checked.workbook:
            return
        checked = check_workbook(edited, Report(), lints=False)
        try:
            if checked.report.errors:
                raise SheetsError(checked.report.errors[0].message)
            plan = make_plan(checked, everything=self._plan.everything)
            made = compare(self._plan, self._checked, self._steps, plan)
        except SheetsError as error:
            places = ", ".join(str(c.get("place")) for c in changes)
            words = N_("An edit at {places} is skipped: {message}", places=places, message=error.message)
            self._leave(places, words)
            return
        apply(engine, made)
        self._checked, self._steps = checked, made.steps

    def _changed(self, workbook: Workbook, change: Change) -> Workbook:
        place, was, now = (str(change.get(n) or "") for n in ("place", "was", "now"))
        if "table" in change:
            return self._table(workbook, change)
        if place.startswith(_HELPERS):
            return self._helper(workbook, place.removeprefix(_HELPERS), was, change)
        ref = place if self._rows is None else self._rows.get(place, "")
        row = next((r for b in workbook.behaviours for r in b.rows if f"{b.name}!{r.number}" == ref), None)
        if row is None:
            words = N_("The edit of {row} is skipped: this workbook has no such row.", row=in_words(place))
        elif self._rows is not None and row.formula.text != was:
            told = N_("The edit of {row} (“{was}” → “{now}”) is skipped: this workbook has “{here}” there.")
            words = N_(told, row=in_words(place), was=was, now=now, here=row.formula.text)
        else:
            changed = replace(row, formula=Cell(now, row.formula.address, now))
            behaviours = [
                replace(b, rows=tuple(changed if r is row else r for r in b.rows)) for b in workbook.behaviours
            ]
            return replace(workbook, behaviours=tuple(behaviours))
        self._leave(place, words)
        return workbook

    def _helper(self, workbook: Workbook, name: str, was: str, change: Change) -> Workbook:
        mine = next((h for h in workbook.helpers if key(h.name.text) == key(name)), None)
        if self._rows is not None and was != (helper_text(mine) if mine else ""):
            words = N_("The edit of the helper {name} is skipped: this workbook has another formula for it.", name=name)
            self._leave(_HELPERS + name, words)
            return workbook
        others = tuple(h for h in workbook.helpers if h is not mine)
        made = _helper_of(name, change)
        place = len(others) if mine is None else workbook.helpers.index(mine)
        return replace(workbook, helpers=(*others[:place], *made, *others[place:]))

    def _table(self, workbook: Workbook, change: Change) -> Workbook:
        name, told = str(change.get("place")), change["table"]
        if not isinstance(told, list) or not all(isinstance(row, list) for row in told):
            words = N_(
                "The edit of the table {name} is skipped: the recording does not contain the new table.", name=name
            )
            self._leave(name, words)
            return workbook
        rows = tuple(tuple(str(text) for text in row) for row in told)
        if self._ran is not None and self._ran.tables.get(key(name)) != workbook.tables.get(key(name)):
            self._leave(
                name, N_("The edit of the table {name} is skipped: this workbook has other contents in it.", name=name)
            )
            return workbook
        tables = {k: cells for k, cells in workbook.tables.items() if k != key(name)}
        sheets = workbook.sheets
        if rows:
            tables[key(name)] = rows
            sheets = sheets if key(name) in map(key, sheets) else (*sheets, name)
        return replace(workbook, tables=tables, sheets=sheets)


def _helper_of(name: str, change: Change) -> tuple[Helper, ...]:
    """Return the helper as it is after a change; empty when it was removed."""
    here = Address("Helpers")
    now = str(change.get("now") or "")
    if not now:
        return ()
    if isinstance(change.get("inputs"), list):
        inputs, formula = [str(i) for i in change["inputs"]], str(change.get("formula") or "")
    else:  # of an older version: `(a, b) formula`
        found = _HELPER.fullmatch(now)
        inputs, formula = ([i.strip() for i in found[1].split(",")], found[2]) if found else ([], now)
    cells = tuple(Cell(i, here, i) for i in inputs)
    return (Helper(Cell(name, here, name), cells, Cell(formula, here, formula)),)
