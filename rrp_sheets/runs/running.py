"""Running a checked workbook on a robot: start, loop, stop, its folder, and the observer that records it."""

from __future__ import annotations

import socket
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.checks.check import folder_of
from rrp_sheets.checks.facts import sensor_fact
from rrp_sheets.engine.command_handler import buttons, label_of, switched
from rrp_sheets.engine.engine import Engine, EventEngine, FrameEngine
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.ports import Heartbeat, World
from rrp_sheets.engine.realtime import RealtimeAdapter
from rrp_sheets.engine.run_events import CommandQueue, NoticeEvent, OperatorEvent, RunEvent, RunObserver
from rrp_sheets.engine.runners import FrameRunner, RealtimeRunner
from rrp_sheets.engine.scene import scene_of
from rrp_sheets.engine.trace import TraceWriter, stream_label
from rrp_sheets.engine.value_injector import OPEN_KINDS
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import Notice, OperatorAction, SceneAction
from rrp_sheets.model.japanese import japanese_thing
from rrp_sheets.model.names import key
from rrp_sheets.model.run_files import TRACE, faces_file
from rrp_sheets.model.values import Failure, Record, Value, show
from rrp_sheets.recording.folder import RunFolder
from rrp_sheets.runs.run_data import FinishingEvent, RestedEvent, RunResult, RunSettings, RunStart, StartEvent, Summary
from rrp_sheets.scene.scene_sheet import scene_end_us
from rrp_sheets.texts import N_

if TYPE_CHECKING:
    from rrp_sheets.workbook import Reading


AFTER_SCENE_US = 5_000_000
WITHOUT_SCENE_US = 30_000_000

WorldMaker = Callable[[Plan, tuple[SceneAction, ...], int, Path], World]
Runner = FrameRunner | RealtimeRunner


def run(
    reading: Reading,
    checked: Checked,
    settings: RunSettings | None = None,
    view: RunObserver | None = None,
    world: WorldMaker | None = None,
    heartbeat: Heartbeat | None = None,
    control: CommandQueue | None = None,
    simulator: socket.socket | None = None,
    ending: Callable[[], str] | None = None,
) -> RunResult:
    """Run a checked workbook and leave a folder with trace, workbook, catalogue, table, diagram, film and speech.

    Args:
        reading: the workbook as it was read, for the copy that is kept.
        checked: it must have no errors.
        settings: how to run.
        view: gets everything as it happens; may stop the run.
        world: makes the robot's world; the simulated NAO when None.
        heartbeat: the engine's heartbeat, for a watchdog in another process.
        control: the operators' commands while it goes on.
        simulator: the connection to a simulator that somebody has started and supervises; None starts one here.
        ending: waits for the reason that its supervisor gives for the end of that simulator.

    Raises:
        SheetsError: when the workbook has errors or the folder cannot be used; then nothing is left.
        MissingPart: when the simulator is not installed here.
        RunBroken: when a device does not start; then nothing is left.
    """
    settings, view = settings or RunSettings(), view or RunObserver()
    plan = _plan(checked, settings)
    seed = checked.run.seed if settings.seed is None else settings.seed
    scene, drawn = scene_of(plan, seed)
    folder = RunFolder(reading, settings.out, settings.home)
    until = _until(checked, settings)
    recorder = Recorder(view, control or CommandQueue())
    try:
        make = world or partial(_simulated, settings=settings, simulator=simulator, ending=ending)
        runner = _begin(plan, make(plan, scene, seed, folder.path), recorder, seed, settings, heartbeat)
    except SheetsError:
        folder.drop()
        raise
    try:
        folder.make()
        folder.keep_workbook(checked)
        trace = TraceWriter(folder.path / TRACE, plan, _header(reading, checked, settings, seed))
        view.handle(StartEvent(start_of(plan, scene, until, folder.path)))  # from now on Stop closes the trace
        recorder.begin(trace, runner.engine)
        for row, text in drawn:
            recorder.handle(NoticeEvent(0, Notice("note", text, row=f"Scene!{row}")))
    except SheetsError:
        with suppress(RunBroken):  # what is told is why the run does not begin
            runner.stop()
        folder.drop()
        raise
    summary, broken = _go(runner, until, trace, recorder)
    view.handle(RestedEvent(summary, broken))
    files, problems = folder.finish(checked)
    return RunResult(folder.path, files, summary, broken, problems)


def _plan(checked: Checked, settings: RunSettings) -> Plan:
    """Return the plan of the rows that run; raise SheetsError when nothing can, or not in this way."""
    if checked.report.errors:
        raise SheetsError(N_("This workbook has errors and cannot run."), N_("See `rrp-sheets check`."))
    if settings.fast and checked.run.engine != "frame":
        raise SheetsError(
            N_("This workbook uses the engine “event loop”, which runs in real time and cannot run fast."),
            N_("Leave out --fast, or write frame in the field Engine of its Protocol."),
        )
    plan = make_plan(checked, everything=settings.everything)
    if not plan.steps:
        raise SheetsError(N_("No row of this workbook is switched on."), N_("Write TRUE in the On cells of some rows."))
    return plan


def _header(reading: Reading, checked: Checked, settings: RunSettings, seed: int) -> dict[str, Any]:
    return {
        "program": __version__, "workbook": reading.digest, "name": Path(reading.workbook.source).name,
        "robot": checked.robot.name, "engine": checked.run.engine, "frame_rate": checked.run.frame_rate,
        "language": checked.run.language, "mode": settings.mode, "seed": seed, "participant": settings.participant,
        "condition": settings.condition, "operator": settings.operator,
        "faces": "kept" if checked.run.keeps_faces else "forgotten",
        "began": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }  # fmt: skip


def _begin(
    plan: Plan, world: World, recorder: Recorder, seed: int, settings: RunSettings, heartbeat: Heartbeat | None
) -> Runner:
    """Start the devices and wire the rows, for the engine that the Protocol asks for."""
    if plan.checked.run.engine == "frame":
        wire = partial(FrameEngine, plan, recorder, seed, heartbeat)
        return FrameRunner(world, wire, paced=not settings.fast, control=recorder.control)
    live = RealtimeAdapter(world, plan.checked.run.frame_rate)
    return RealtimeRunner(plan, live, partial(EventEngine, plan, recorder, seed, heartbeat), recorder.control)


def _go(runner: Runner, until: int, trace: TraceWriter, recorder: Recorder) -> tuple[Summary, RunBroken | None]:
    """Run the loop between start and stop; whatever happens, the world is stopped and the trace is closed."""
    began = time.monotonic()
    broken: RunBroken | None = None
    ended, row, out_of_memory = "broken", "", False
    try:
        _, ended = runner.go(until, recorder)
        row = runner.engine.ended_by
    except RunBroken as error:
        broken = error
    except MemoryError:  # told below: while it is handled, what holds the memory is still held
        out_of_memory = True
    finally:
        if ended == "broken":
            row = runner.engine.row
        if out_of_memory:
            runner.engine.close()
            words = N_("The run needs more memory than a run may have.")
            if row:
                words = N_("The row {row} needs more memory than a run may have.", row=row)
            broken = RunBroken(words, N_("Store less in that row: fewer values, or shorter texts and lists."))
        wall = time.monotonic() - began
        try:
            recorder.view.handle(FinishingEvent())
        finally:
            try:
                for notice in (*runner.stop(), *runner.engine.triggers.left()):
                    recorder.handle(NoticeEvent(runner.engine.clock.us, notice))
            except RunBroken as error:
                broken, ended = broken or error, "broken"  # the first break is the cause
            finally:
                summary = _summary(runner.engine, recorder, wall, ended, row)
                if broken is not None:
                    summary.why, summary.remedy = broken.message, broken.remedy
                try:
                    trace.close(summary.as_dict(wall=False))
                except RunBroken as error:
                    broken = broken or error
    return summary, broken


def _summary(engine: Engine, recorder: Recorder, wall: float, ended: str, row: str) -> Summary:
    labels = {s.id: stream_label(s) for s in engine.plan.streams}
    counts = {labels[i]: s.arrived for i, s in engine.streams.items()}
    commands = {a.name: engine.streams[a.stream].arrived for a in engine.plan.actuators}
    errors = dict(engine.errors + recorder.unusable)
    by = recorder.control.stopped_by if ended == "stopped" else ""
    return Summary(counts, errors, commands, engine.clock.us / 1e6, wall, ended, row, by)


def _until(checked: Checked, settings: RunSettings) -> int:
    """Return the time at which the run ends, in microseconds."""
    if settings.seconds is not None:
        wanted = round(settings.seconds * 1e6)
    elif checked.scene:
        wanted = scene_end_us(checked.scene) + AFTER_SCENE_US
    else:
        wanted = WITHOUT_SCENE_US
    limit = checked.run.time_limit_us
    return wanted if limit is None else min(wanted, limit)


def _simulated(
    plan: Plan, scene: tuple[SceneAction, ...], seed: int, out: Path, *, settings: RunSettings,
    simulator: socket.socket | None, ending: Callable[[], str] | None,
) -> World:  # fmt: skip
    from rrp_sheets.drivers.simulated import SimulatedWorld
    from rrp_sheets.sim.process import require

    require()
    checked = plan.checked
    home = settings.home or Path(checked.workbook.source).absolute().parent
    return SimulatedWorld(
        checked.robot, plan.outer_sensors, plan.outer_actuators, scene, dones=plan.dones, seed=seed,
        frame_rate=checked.run.frame_rate, out=out, film=settings.film, record=True,
        camera=settings.camera and checked.run.keeps_pictures,
        title=checked.workbook.protocol.text("Title"), language=checked.workbook.language,
        beside=folder_of(checked.workbook).absolute(),
        faces=faces_file(home) if checked.run.keeps_faces else None, requests=simulator, ending=ending,
    )  # fmt: skip


Thing = tuple[str, str, str, tuple[float, float, float] | None]


def start_of(plan: Plan, scene: Sequence[SceneAction], until_us: int, folder: Path) -> RunStart:
    """Return the description of a run that its view gets at the beginning."""
    checked = plan.checked
    workbook, robot = checked.workbook, checked.robot
    names = {b.key: b.name for b in checked.graph.behaviours}
    streams = {s.id: s for s in plan.streams}
    resources = {
        a.stream: tuple(sorted(device.type.resources_for(a.settings)))
        for a in plan.actuators
        if (device := streams[a.stream].device)
    }
    camera: Mapping[str, float] = robot.data.get("camera", {}).get("top", {})
    return RunStart(
        title=workbook.protocol.text("Title") or Path(workbook.source).stem, until_us=until_us, folder=folder,
        findings=tuple(checked.report), language=checked.run.language,
        streams={s.id: stream_label(s) for s in plan.streams},
        actuators={a.stream: a.name for a in plan.actuators}, rows=plan.rows_by_rank(),
        behaviours=tuple((names[b], b in plan.on) for b in plan.behaviours),
        sensors=tuple(
            (s.name, s.device.type.name if s.device else "", example_text(sensor_fact(s, robot).example))
            for s in plan.streams if s.kind in OPEN_KINDS
        ),
        buttons=tuple((use.name, label_of(use)) for use in buttons(plan.sensors)),
        things=_things(scene, workbook.language),
        hfov=float(camera.get("hfov", 0.0)), vfov=float(camera.get("vfov", 0.0)),
        resources=resources,
    )  # fmt: skip


def example_text(value: Value) -> str:
    """Format a value as one would write it to send it.

    >>> from rrp_sheets.model.values import record_from_mapping
    >>> example_text(record_from_mapping("Touch", {"pressed": True, "zone": "Head", "force": None})), example_text(0.5)
    ('pressed=TRUE; zone="Head"', '0.5')
    """
    if isinstance(value, Record):
        told = ((name, v) for name, v in value.as_dict().items() if v is not None)
        return "; ".join(f"{name}={example_text(v)}" for name, v in told)
    return '"' + value.replace('"', '""') + '"' if isinstance(value, str) else show(value)


def _things(scene: Sequence[SceneAction], language: str) -> tuple[Thing, ...]:
    """Return the things that will be in the scene, each with its place if it is there at the beginning."""
    found: dict[str, Thing] = {}
    for action in scene:
        if action.verb in ("appear", "seen") and key(action.thing) not in found:
            place = None
            if action.time_us == 0 and not action.cue and "at" in action.values:
                x, y, *z = (float(c) for c in action.values["at"])
                place = x, y, z[0] if z else 0.0
            title = japanese_thing(action.thing) if language == "ja" else action.thing
            found[key(action.thing)] = action.thing, title, action.what, place
    return tuple(found.values())


_ROBOT = N_("the robot itself")  # where an error is counted that is no row's: it has fallen


class Recorder(RunObserver):
    """Observer of an engine and its loop that passes everything to the view and, from `begin` on, to the trace."""

    def __init__(self, view: RunObserver, control: CommandQueue) -> None:
        self.view = view
        self.control = control
        self.unusable: Counter[str] = Counter()  # how often an actuator could not use a row's value
        self._began = 0.0
        self._is_recording = False

    def begin(self, trace: TraceWriter, engine: Engine) -> None:
        """Start the wall clock and the recording into a trace."""
        self.trace, self.engine, self._began = trace, engine, time.monotonic()
        self._on = set(engine.on)  # the behaviours that the view knows to be on
        self._is_recording = True

    def handle(self, event: RunEvent) -> None:
        """Record an event, once the recording has begun, and pass it to the view."""
        if self._is_recording:
            super().handle(event)
        self.view.handle(event)

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """Record a value on a stream (its id)."""
        self.trace.event(us, stream, row, value, None if row else self.engine.sent_by)

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """Record that a formula failed."""
        self.trace.error(us, row, failure, values)

    def notice(self, us: int, notice: Notice) -> None:
        """Record a notice; one of kind `error` is counted for its row."""
        self.trace.notice(us, notice)
        if notice.kind == "error":  # an actuator cannot use its value: an error of that row like any other
            self.unusable[notice.row or notice.stream or _ROBOT] += 1

    def frame(self, us: int) -> None:
        """Flush the trace after a frame, and tell the view which behaviours a row has switched: a note in the trace."""
        self.trace.flush()
        if self.engine.on != self._on:
            for behaviour in self.engine.plan.checked.graph.behaviours:
                on = behaviour.key in self.engine.on
                if on != (behaviour.key in self._on):
                    self.view.handle(OperatorEvent(us, switched(behaviour.name, on)))
            self._on = set(self.engine.on)

    def acted(self, us: int, action: OperatorAction) -> None:
        """Record what an operator did."""
        self.trace.action(us, action, time.monotonic() - self._began)
        self.trace.flush()
        self._on = set(self.engine.on)

    def stopped(self) -> bool:
        """Return whether the run should stop now."""
        return self.view.stopped()
