"""Running a workbook on a robot: check, start, loop, stop, and leave everything in a folder."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.checks.check import folder_of
from rrp_sheets.devices.default_scene import default_scene
from rrp_sheets.devices.scene import scene_end_us
from rrp_sheets.devices.scene_draw import draw_scene
from rrp_sheets.engine.command_queue import CommandQueue
from rrp_sheets.engine.engine import Engine
from rrp_sheets.engine.events import EventEngine
from rrp_sheets.engine.frame import FrameEngine
from rrp_sheets.engine.frame_runner import FrameRunner
from rrp_sheets.engine.heartbeat import Heartbeat
from rrp_sheets.engine.observer import Runner
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.ports import World
from rrp_sheets.engine.realtime import RealtimeAdapter
from rrp_sheets.engine.realtime_runner import RealtimeRunner
from rrp_sheets.engine.trace import TraceWriter, stream_label
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import Notice
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.runs.folder import RunFolder, faces_file
from rrp_sheets.runs.recorder import Recorder
from rrp_sheets.runs.starting import start_of
from rrp_sheets.runs.view import RunResult, RunSettings, RunView, Summary

if TYPE_CHECKING:
    from rrp_sheets.workbook import Reading

AFTER_SCENE_US = 5_000_000
WITHOUT_SCENE_US = 30_000_000

WorldMaker = Callable[[Plan, tuple[SceneAction, ...], int, Path], World]


def run(
    reading: Reading,
    checked: Checked,
    settings: RunSettings | None = None,
    view: RunView | None = None,
    world: WorldMaker | None = None,
    cell: Heartbeat | None = None,
    control: CommandQueue | None = None,
    simulator: socket.socket | None = None,
    ending: Callable[[], str] | None = None,
) -> RunResult:
    """Run a checked workbook and leave a folder with trace, workbook, catalogue, table, diagram, film and speech.

    Args:
        reading: the workbook as it was read, for the copy that is kept.
        checked: it must have no errors.
        settings: how to run.
        view: told of everything as it happens; may stop the run.
        world: makes the robot's world; the simulated NAO when None.
        cell: where the engine is, for a watchdog in another process.
        control: what people want while it goes on.
        simulator: the connection to a simulator that somebody has started and supervises; None starts one here.
        ending: of that simulator: waits for what its supervisor says of its end.

    Raises:
        SheetsError: when the workbook has errors or the folder cannot be used; then nothing is left.
        MissingPart: when the simulator is not installed here.
        RunBroken: when a device does not start; then nothing is left.
    """
    settings, view = settings or RunSettings(), view or RunView()
    plan = _plan(checked, settings)
    seed = checked.run.seed if settings.seed is None else settings.seed
    scene, drawn = draw_scene(checked.scene or (), seed)
    if checked.scene is None:
        scene = default_scene(plan.outer_sensors, checked.robot)
    folder = RunFolder(reading, settings.out, settings.home)
    until = _until(checked, settings)
    recorder = Recorder(view, control or CommandQueue())
    try:
        live = (world or _simulated(settings, simulator, ending))(plan, scene, seed, folder.path)
        runner = _begin(plan, live, recorder, seed, settings, cell)
    except SheetsError:
        folder.drop()
        raise
    view.started(start_of(plan, scene, until, folder.path))
    try:
        folder.make()
        folder.keep_workbook(checked)
        trace = TraceWriter(folder.path / "trace.jsonl", plan, _header(reading, checked, settings, seed))
        recorder.begin(trace, runner.engine)
        for one in drawn:
            recorder.happening(0, Notice("note", one.text, row=f"Scene!{one.row}"))
    except SheetsError:
        with suppress(RunBroken):  # what is told is why the run does not begin
            runner.stop()
        folder.drop()
        raise
    summary, broken = _go(runner, until, trace, recorder)
    view.rested(summary, broken)
    files, problems = folder.finish(checked)
    return RunResult(folder.path, files, summary, broken, problems)


def _plan(checked: Checked, settings: RunSettings) -> Plan:
    """What runs; raises SheetsError when nothing can, or not in this way."""
    if checked.report.errors:
        raise SheetsError("This workbook has errors and cannot run.", "See `rrp-sheets check`.")
    if settings.fast and checked.run.engine != "frame":
        raise SheetsError(
            "This workbook asks for the engine “event loop”, which goes by the wall clock and cannot be fast.",
            "Leave out --fast, or write frame as the Engine of its Protocol.",
        )
    plan = make_plan(checked, everything=settings.everything)
    if not plan.steps:
        raise SheetsError("No row of this workbook is switched on.", "Write TRUE in the On cells of some rows.")
    return plan


def _header(reading: Reading, checked: Checked, settings: RunSettings, seed: int) -> dict[str, Any]:
    """The first line of the trace."""
    return {
        "program": __version__, "workbook": reading.digest, "name": Path(reading.workbook.source).name,
        "robot": checked.robot.name, "engine": checked.run.engine, "frame_rate": checked.run.frame_rate,
        "language": checked.run.language, "mode": settings.mode, "seed": seed, "participant": settings.participant,
        "condition": settings.condition, "operator": settings.operator,
        "faces": "kept" if checked.run.keeps_faces else "forgotten",
        "began": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }  # fmt: skip


def _begin(
    plan: Plan, world: World, recorder: Recorder, seed: int, settings: RunSettings, cell: Heartbeat | None
) -> Runner:
    """Start the devices and wire the rows, for the engine that the Protocol asks for."""
    if plan.checked.run.engine == "frame":
        return FrameRunner(
            world, lambda: FrameEngine(plan, recorder, seed, cell), paced=not settings.fast, control=recorder.control
        )
    pumped = RealtimeAdapter(world, plan.checked.run.frame_rate)
    return RealtimeRunner(plan, pumped, lambda: EventEngine(plan, recorder, seed, cell), recorder.control)


def _go(runner: Runner, until: int, trace: TraceWriter, recorder: Recorder) -> tuple[Summary, RunBroken | None]:
    """The loop between starting and stopping; whatever happens, the world is stopped and the trace is closed."""
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
            broken = RunBroken(
                f"{f'The row {row}' if row else 'The run'} needs more memory than a run may have.",
                "Keep less in that row: fewer values, or shorter texts and lists.",
            )
        wall = time.monotonic() - began
        try:
            recorder.view.finishing()
        finally:
            try:
                for happening in (*runner.stop(), *runner.engine.triggers.left()):
                    recorder.happening(runner.engine.clock.us, happening)
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
    errors = dict(engine.errors)
    for place, count in recorder.unusable.items():
        errors[place] = errors.get(place, 0) + count
    by = recorder.control.stopped_by if ended == "stopped" else ""
    return Summary(counts, errors, commands, engine.clock.us / 1e6, wall, ended, row, by)


def _until(checked: Checked, settings: RunSettings) -> int:
    """When the run ends, in microseconds."""
    if settings.seconds is not None:
        wanted = round(settings.seconds * 1e6)
    elif checked.scene:
        wanted = scene_end_us(checked.scene) + AFTER_SCENE_US
    else:
        wanted = WITHOUT_SCENE_US
    limit = checked.run.time_limit_us
    return wanted if limit is None else min(wanted, limit)


def _faces(settings: RunSettings, checked: Checked) -> Path | None:
    """The file that keeps faces beyond a run; None when none are kept."""
    beside = settings.home / "any" if settings.home else Path(checked.workbook.source)
    return faces_file(beside) if checked.run.keeps_faces else None


def _simulated(settings: RunSettings, simulator: socket.socket | None, ending: Callable[[], str] | None) -> WorldMaker:
    def make(plan: Plan, scene: tuple[SceneAction, ...], seed: int, out: Path) -> World:
        from rrp_sheets.drivers.simulated import SimulatedWorld
        from rrp_sheets.sim.process import require

        require()
        checked = plan.checked
        return SimulatedWorld(
            checked.robot, plan.outer_sensors, plan.outer_actuators, scene, dones=plan.dones, seed=seed,
            frame_rate=checked.run.frame_rate, out=out, film=settings.film, record=True,
            camera=settings.camera and checked.run.keeps_pictures,
            title=checked.workbook.protocol.text("Title"),
            beside=folder_of(checked.workbook).absolute(),
            faces=_faces(settings, checked), requests=simulator, ending=ending,
        )  # fmt: skip

    return make
