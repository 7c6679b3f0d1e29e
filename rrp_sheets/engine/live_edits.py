"""Edits of a workbook while it runs: they are read beside the frames, and compared with what the run can go on with."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.engine.engine import Engine
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.run_events import CommandQueue, OperatorCommand
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import Step
from rrp_sheets.model.exchange import OperatorAction
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Helper, Workbook
from rrp_sheets.texts import N_

REMEDY = N_("Restart the run to use them.")
SWITCH_SECONDS = 0.0005  # a tenth of Python's: a check beside the frames holds them up so long at a time


@dataclass(frozen=True)
class Edit:
    """Edited rows and formulas that a run uses from the next frame on.

    Attributes:
        steps: the rows as they are now, by the refs that they have in the run.
        renewed: those refs whose formula or period is another one.
        changes: what was changed, in the order of the sheets: place, was, now; of helpers and tables what they are.
    """

    checked: Checked
    steps: Mapping[str, Step]
    renewed: Sequence[str]
    changes: Sequence[Mapping[str, Any]]


class Editor:
    """Reads an edited workbook beside the frames, and lets the run go on with it; `checked` is what it uses now."""

    def __init__(self, engine: Engine, control: CommandQueue) -> None:
        self._engine = engine
        self._control = control
        self._plan = engine.plan
        self.checked = engine.plan.checked
        self._steps: Mapping[str, Step] = {s.ref: s for s in engine.plan.steps}
        self._thread: threading.Thread | None = None
        self._next: tuple[str, str] | None = None

    def read(self, path: str, by: str) -> None:
        """Read and check a workbook on a thread; the result comes as the command `edited`."""
        if self._thread is not None:
            self._next = path, by
            return
        self._thread = threading.Thread(target=self._work, args=(Path(path), by), name="edits", daemon=True)
        self._thread.start()

    def _work(self, path: Path, by: str) -> None:
        interval = sys.getswitchinterval()
        sys.setswitchinterval(min(interval, SWITCH_SECONDS))
        made: Edit | SheetsError = SheetsError(N_("The edited workbook could not be checked."), REMEDY)
        try:
            made = self._compared(path)
        except SheetsError as error:
            made = error
        except MemoryError:
            made = SheetsError(N_("The edited workbook needs more memory than a run may have."), REMEDY)
        finally:
            sys.setswitchinterval(interval)
            self._control.ask(OperatorCommand("edited", by, {"made": made}))

    def _compared(self, path: Path) -> Edit:
        from rrp_sheets.workbook import read

        reading = read(path)
        checked = check_workbook(reading.workbook, reading.report, lints=False)
        errors = checked.report.errors
        if errors:
            where = f" ({errors[0].address})" if errors[0].address else ""
            raise SheetsError(
                N_("The edited workbook has errors{where}: {message}", where=where, message=errors[0].message),
                N_("Fix them to use your edits. Until then, the run uses the old rows."),
            )
        return compare(self._plan, self.checked, self._steps, make_plan(checked, everything=self._plan.everything))

    def use(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        """Let the run go on with an edited workbook. Raises SheetsError when it cannot."""
        self._thread = None
        if self._next is not None:  # it was edited again meanwhile
            following, self._next = self._next, None
            self.read(*following)
            return None
        made = command.what["made"]
        if isinstance(made, SheetsError):
            raise made
        apply(self._engine, made)
        self.checked, self._steps = made.checked, made.steps
        places = list(dict.fromkeys(change["place"] for change in made.changes))
        words = (
            N_("Used from {seconds:g} s on: {places}.", seconds=us / 1e6, places=", ".join(places)) if places
            else N_("No running row has changed.")
        )  # fmt: skip
        return OperatorAction("edit", words, command.by, {"changes": list(made.changes), "rows": made.renewed})


def compare(plan: Plan, used: Checked, steps: Mapping[str, Step], edited: Plan) -> Edit:
    """Return what a run can take over from an edited workbook. Raises SheetsError when the graphs differ in shape.

    Args:
        plan: of the run.
        used: the workbook that it uses now.
        steps: its rows as they are used now, by the run's refs.
        edited: the plan of the edited workbook, which has no errors.
    """
    why = next(_differences(plan, edited), "")
    if why:
        raise SheetsError(N_("The run cannot use your changes: {reason}.", reason=why), REMEDY)
    rows = {  # paired by their order in the sheet, whatever their numbers are
        old.ref: new
        for behaviour, running in plan.behaviours.items()
        for old, new in zip(_in_sheet(running), _in_sheet(edited.behaviours[behaviour]), strict=True)
    }
    changes: list[Mapping[str, Any]] = list(_sheets_changed(used.workbook, edited.checked.workbook))
    everything = bool(changes)  # a helper may be in any formula
    renewed = []
    for ref, new in rows.items():
        old = steps[ref]
        was, now = old.row.formula.text, new.row.formula.text
        edit = was != now if new.ref in edited.checked.formulas else old.period_us != new.period_us
        if edit:
            changes.append({"place": ref, "was": was, "now": now})
        if edit or (everything and new.ref in edited.checked.formulas):
            renewed.append(ref)
    return Edit(edited.checked, rows, tuple(renewed), tuple(changes))


def apply(engine: Engine, edit: Edit) -> None:
    """Let an engine go on with edited rows."""
    for ref in edit.renewed:
        step = edit.steps[ref]
        engine.edit(ref, edit.checked.formulas.get(step.ref), step.period_us)


def _in_sheet(steps: Sequence[Step]) -> list[Step]:
    return sorted(steps, key=lambda s: s.number)


def _differences(plan: Plan, edited: Plan) -> Iterator[str]:
    """Yield the reasons why a run cannot go on with an edited plan, in words; only the first is shown."""
    was, now = plan.checked, edited.checked
    if was.robot.name != now.robot.name:
        yield N_("the Protocol names another robot")
    if (was.run.engine, was.run.frame_rate) != (now.run.engine, now.run.frame_rate):
        yield N_("the Protocol's Engine or Frame rate is different")
    if list(plan.behaviours) != list(edited.behaviours) or plan.on != edited.on:
        yield N_("other behaviours are selected to run")
        return
    for behaviour in plan.behaviours:
        yield from _rows_differ(plan, edited, behaviour)
    for one, other in zip_longest(_devices(plan), _devices(edited)):
        if one != other:
            yield N_("the device of {name} or its settings were changed", name=(one or other or ("",))[0])
    if _actions(was) != _actions(now):
        yield N_("the Scene was changed")
    if _gestures(was.workbook) != _gestures(now.workbook):
        yield N_("the Gestures were changed")


def _rows_differ(plan: Plan, edited: Plan, behaviour: str) -> Iterator[str]:
    old_rows, new_rows = _in_sheet(plan.behaviours[behaviour]), _in_sheet(edited.behaviours[behaviour])
    sheet = next(b.name for b in plan.checked.graph.behaviours if b.key == behaviour)
    pairs = list(zip(old_rows, new_rows, strict=False))
    # streams without a name are called by their rows, which may have moved
    names = {new.output: old.output for old, new in pairs if "!#" in old.output and "!#" in new.output}
    for old, new in pairs:
        where = N_("row {row}" if old.ref == new.ref else "row {row} (in the run {old})", row=new.ref, old=old.ref)
        if old.connector.name != new.connector.name:
            yield N_("{where} has a different connector", where=where)
        elif old.inputs != tuple(names.get(i, i) for i in new.inputs):
            yield N_("{where} has different inputs", where=where)
        elif old.output != names.get(new.output, new.output):
            yield N_("{where} has a different output", where=where)
        elif old.row.priority != new.row.priority:
            yield N_("{where} has a different priority", where=where)
        elif (old.ref in plan.checked.formulas) != (new.ref in edited.checked.formulas):
            yield N_("{where} has a new formula or no formula any more", where=where)
    if len(new_rows) > len(old_rows):
        yield N_("{sheet} has more active rows", sheet=sheet)
    elif len(new_rows) < len(old_rows):
        yield N_("{sheet} has fewer active rows", sheet=sheet)


def _devices(plan: Plan) -> list[tuple[str, str, object]]:
    return sorted(((u.name, u.device, dict(u.settings)) for u in (*plan.sensors, *plan.actuators)), key=lambda u: u[:2])


def _actions(checked: Checked) -> object:
    return None if checked.scene is None else [replace(action, row=0) for action in checked.scene]


def _gestures(workbook: Workbook) -> object:
    return [(g.name.text, g.time.text, {k: c.text for k, c in g.joints.items()}) for g in workbook.gestures]


def _sheets_changed(was: Workbook, now: Workbook) -> Iterator[dict[str, Any]]:
    """Yield the changes in the helpers, and in the user's own tables that formulas name, each with its new content."""
    old = {key(h.name.text): h for h in was.helpers}
    new = {key(h.name.text): h for h in now.helpers}
    for name in dict.fromkeys((*old, *new)):
        texts = [helper_text(h) if h else "" for h in (old.get(name), new.get(name))]
        if texts[0] != texts[1]:
            helper = new.get(name) or old[name]
            parts = {"inputs": [c.text for c in helper.inputs], "formula": helper.formula.text if texts[1] else ""}
            yield {"place": f"Helpers!{helper.name.text}", "was": texts[0], "now": texts[1], **parts}
    sheets = {key(s): s for s in (*was.sheets, *now.sheets)}
    for sheet in dict.fromkeys((*was.tables, *now.tables)):
        if was.tables.get(sheet) != now.tables.get(sheet):
            rows = [list(row) for row in now.tables.get(sheet, ())]
            yield {"place": sheets.get(sheet, sheet), "was": "", "now": "the table as it is now", "table": rows}


def helper_text(helper: Helper) -> str:
    """Return a helper as a change tells it."""
    inputs = ", ".join(cell.text for cell in helper.inputs)
    return f"({inputs}) {helper.formula.text}" if inputs else helper.formula.text
