"""Commands of operators to a run that goes on, carried out between two frames and reported to be recorded.

Whatever enters the run enters at a frame: a value that is sent in the next one, everything else after the one that is
over. So a trace says all that is needed to do it again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rrp_sheets.checks.check import folder_of
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import AFTER_SCENE_ROWS
from rrp_sheets.engine.engine import Engine, switch_text
from rrp_sheets.engine.live_edits import Editor
from rrp_sheets.engine.run_events import (
    CommandQueue,
    OperatorCommand,
    OperatorEvent,
    PauseEvent,
    RefusalEvent,
    RunObserver,
)
from rrp_sheets.engine.scene import SceneEntities
from rrp_sheets.engine.value_injector import ValueInjector
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import DeviceUse, OperatorAction, SceneAction
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import show, to_json
from rrp_sheets.model.workbook import Address, Cell, SceneRow
from rrp_sheets.scene.scene_sheet import parse_scene
from rrp_sheets.scene.scene_words import OPERATOR, choose_random_numbers
from rrp_sheets.texts import N_, sentences

if TYPE_CHECKING:
    from rrp_sheets.engine.runners import FrameRunner, RealtimeRunner

FARTHEST = 20.0  # m: nothing stands farther from the robot
SLOWEST, FASTEST = 0.1, 100.0
HELD_US = 1_000_000  # a touch that is held ends so long after it was last told of: whoever held it may have gone


@dataclass(slots=True)
class _Held:
    """Touch that somebody holds: since when, and until when if it is not told of again."""

    by: str
    began_us: int
    until_us: int


class CommandHandler:
    """Carries out the commands of operators between two frames, and tells the observer what was done or cannot be."""

    def __init__(
        self, engine: Engine, runner: FrameRunner | RealtimeRunner, observer: RunObserver, control: CommandQueue
    ) -> None:
        self._engine = engine
        self._runner = runner
        self._observer = observer
        self._control = control
        self._robot = engine.plan.checked.robot
        self._editor = Editor(engine, control)
        self._stimulus = ValueInjector(engine)
        self._entities = SceneEntities(engine.plan, engine.seed)
        self._buttons = {key(label_of(use)): label_of(use) for use in buttons(engine.plan.sensors)}
        self._held: dict[str, _Held] = {}  # by the zone
        self._do: dict[str, Callable[[int, OperatorCommand], OperatorAction | None]] = {
            "pause": self._pause, "resume": self._resume, "step": self._step, "speed": self._speed,
            "mark": self._mark, "switch": self._switch, "send": self._send, "press": self._press,
            "scene": self._scene, "put": self._put, "touch": self._touch, "apply": self._apply,
            "edited": self._editor.use, "look": self._look, "show": self._look,
        }  # fmt: skip

    def between(self, us: int) -> bool:
        """Carry out the commands that wait after the frame of `us`; returns whether there were any.

        Raises:
            RunBroken: when a device has broken.
        """
        commands = self._control.take()
        for zone in [zone for zone, held in self._held.items() if held.until_us <= us]:
            self._observer.handle(OperatorEvent(us, self._let_go(zone, self._held[zone].until_us)))
        for command in commands:
            if self._control.stopped:
                break
            try:
                action = self._do[command.kind](us, command)
            except RunBroken:
                raise
            except SheetsError as error:
                kind = "apply" if command.kind == "edited" else command.kind
                self._observer.handle(RefusalEvent(kind, error.message, error.remedy))
            else:
                if action is not None:
                    self._observer.handle(OperatorEvent(us, action))
        return bool(commands)

    # ---- the clock
    def _pause(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        if not self._runner.pause(us):
            return None
        self._observer.handle(PauseEvent(us, True))
        return OperatorAction("pause", N_("Paused."), command.by)

    def _resume(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        if not self._runner.resume(us):
            return None
        self._observer.handle(PauseEvent(us, False))
        return OperatorAction("resume", N_("Continues."), command.by)

    def _step(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        if self._runner.pause(us):
            self._observer.handle(PauseEvent(us, True))
        self._runner.step(us)
        return OperatorAction("step", N_("One step."), command.by)

    def _speed(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        factor = float(command.what["factor"])
        if factor and not SLOWEST <= factor <= FASTEST:
            remedy = N_("Choose a speed from {slowest:g} to {fastest:g} times real time, or as fast as possible.")
            raise SheetsError(
                N_("The speed {factor:g} is not possible.", factor=factor), N_(remedy, slowest=SLOWEST, fastest=FASTEST)
            )
        self._runner.speed(factor, us)
        words = N_("Speed {factor:g}.", factor=factor) if factor else N_("As fast as possible.")
        return OperatorAction("speed", words, command.by, {"factor": factor})

    # ---- the rows
    def _mark(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        return OperatorAction("mark", str(command.what["note"]).strip(), command.by)

    def _switch(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        name, on = str(command.what["behaviour"]), bool(command.what["on"])
        plan, behaviour = self._engine.plan, key(name)
        shown = {b.key: b.name for b in plan.checked.graph.behaviours}
        if behaviour not in plan.behaviours:
            if behaviour in shown:
                raise SheetsError(
                    N_("The behaviour {behaviour} is not part of this run.", behaviour=shown[behaviour]),
                    N_("Write its sheet's name in the field Run of the sheet Protocol, then run again."),
                )
            near = nearest(name, [shown[k] for k in plan.behaviours])
            remedy = N_("Did you mean {guess}?", guess=near) if near else ""
            raise SheetsError(N_("There is no behaviour “{name}”.", name=name), remedy)
        return switched(shown[behaviour], on, command.by) if self._engine.turn(behaviour, on) else None

    def _send(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        name, text = str(command.what["stream"]), str(command.what["text"])
        stream, value = self._stimulus.read(name, text, self._editor.checked)
        self._engine.stimulate(stream.id, value, command.by)
        detail = {"stream": stream.name, "text": text, "value": to_json(value)}
        return OperatorAction("send", f"{stream.name}: {show(value)}", command.by, detail)

    def _apply(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        self._editor.read(str(command.what["path"]), command.by)
        return None

    # ---- the world
    def _press(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        label = str(command.what["label"])
        if key(label) not in self._buttons:
            known = ", ".join(self._buttons.values())
            remedy = (
                N_("The buttons are: {names}.", names=known) if known
                else N_("Use an operator's button (Start button) in a row.")
            )  # fmt: skip
            raise SheetsError(N_("There is no button “{label}” in this run.", label=label), remedy)
        label = self._buttons[key(label)]
        self._runner.act((SceneAction(us, command.by or OPERATOR, "press", {"label": label}),))
        return OperatorAction("press", label, command.by, {"label": label})

    def _scene(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        parts = [str(command.what[name]).strip() for name in ("thing", "verb", "value")]
        here = Address("Scene")
        row = SceneRow(Cell("0", here), *(Cell(text, here) for text in parts))
        report = Report()
        actions = parse_scene((row,), report, self._robot, folder_of(self._engine.plan.checked.workbook))
        actions, _ = choose_random_numbers(actions, self._engine.seed + us)
        for finding in report:
            if finding.code not in AFTER_SCENE_ROWS:
                raise SheetsError(finding.message, finding.remedy)
        if "SCENE005" in [d.code for d in report]:
            self._require(parts[0])
        for action in actions:
            if action.verb == "press":
                return self._press(us, OperatorCommand("press", command.by, action.values))
        self._runner.act([replace(action, time_us=us, row=0) for action in actions])
        self._entities.add(actions)
        detail = dict(zip(("thing", "does", "value"), parts, strict=True))
        return OperatorAction("scene", " ".join(p for p in parts if p), command.by, detail)

    def _touch(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        zones = {key(zone): zone for zone in self._robot.touch_zones}
        zone, step = zones.get(key(str(command.what["zone"]))), str(command.what["step"])
        if zone is None:
            remedy = N_("It feels a touch on: {names}.", names=", ".join(zones.values()))
            raise SheetsError(N_("The robot feels nothing at “{zone}”.", zone=command.what["zone"]), remedy)
        if step == "end":
            if zone not in self._held:
                return None
            self._runner.act([SceneAction(us, self._held[zone].by, "touch", {"zone": zone, "seconds": 0.0})])
            return self._let_go(zone, us)
        seconds = {} if step == "once" else {"seconds": HELD_US / 1e6}
        self._runner.act([SceneAction(us, command.by or OPERATOR, "touch", {"zone": zone, **seconds})])
        detail = {"thing": command.by or OPERATOR, "does": "touches", "value": zone}
        if step == "once":
            return OperatorAction("scene", N_("Touch: {zone}", zone=zone), command.by, detail)
        if zone in self._held:  # a touch that goes on is no news
            self._held[zone].until_us = us + HELD_US
            return None
        self._held[zone] = _Held(command.by or OPERATOR, us, us + HELD_US)
        return OperatorAction("scene", N_("Touch begins: {zone}", zone=zone), command.by, detail)

    def _let_go(self, zone: str, us: int) -> OperatorAction:
        held = self._held.pop(zone)
        seconds = (us - held.began_us) / 1e6
        detail = {"thing": held.by, "does": "lets go", "value": zone, "seconds": seconds}
        words = N_("Touch ends: {zone}, after {seconds:.1f} s", zone=zone, seconds=seconds)
        return OperatorAction("scene", words, held.by, detail)

    def _put(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        thing, at = str(command.what["thing"]), tuple(float(c) for c in command.what["at"])
        if len(at) != 3 or not all(math.isfinite(c) and abs(c) <= FARTHEST for c in at):
            remedy = N_("Put it within {farthest:g} m of the robot.", farthest=FARTHEST)
            raise SheetsError(N_("{thing} cannot be placed there.", thing=thing), remedy)
        detail: dict[str, object] = {"thing": thing, "put": [round(c, 4) for c in at]}
        place = ", ".join(f"{c:.2f}" for c in at)
        actions = [SceneAction(us, thing, "move", {"to": at, "seconds": 0.0})]
        entry = None if self._is_there(thing) else self._entities.entry(thing)
        if entry is None:
            self._require(thing)
            words = N_("{thing} is placed at {place} m.", thing=thing, place=place)
        else:  # it comes as it is, and stands there at once
            actions.insert(0, replace(entry, time_us=us, row=0))
            words = N_("{thing} appears at {place} m.", thing=entry.thing, place=place)
            detail["appears"] = True
        self._runner.act(actions)
        return OperatorAction("scene", words, command.by, detail)

    def _is_there(self, thing: str) -> bool:
        present = self._runner.things()
        return present is None or key(thing) in {key(t) for t in present}

    def _require(self, thing: str) -> None:
        if not self._is_there(thing):
            present = self._runner.things()
            there = N_("There are: {names}.", names=", ".join(present)) if present else N_("Nothing is there.")
            remedy = sentences(N_("Let it appear first."), there)
            raise SheetsError(N_("“{thing}” is not in the scene now.", thing=thing), remedy)

    def _look(self, us: int, command: OperatorCommand) -> OperatorAction | None:
        self._runner.watch(**{("look" if command.kind == "look" else "wanted"): bool(command.what["wanted"])})
        return None


def switched(behaviour: str, on: bool, by: str = "") -> OperatorAction:
    """A behaviour was switched, by somebody or by a row."""
    return OperatorAction("switch", switch_text(behaviour, on), by, {"behaviour": behaviour, "on": on})


def buttons(sensors: Collection[DeviceUse]) -> list[DeviceUse]:
    """The operator's buttons among sensors."""
    return [use for use in sensors if use.device == "OperatorButton"]


def label_of(button: DeviceUse) -> str:
    """Return the label of an operator's button."""
    return str(button.settings.get("label") or button.name)
