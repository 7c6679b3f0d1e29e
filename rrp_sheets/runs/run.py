"""Running a workbook on a robot: check, start, loop, stop, and leave everything in a folder."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.devices.default_scene import default_scene
from rrp_sheets.devices.scene import scene_end_us
from rrp_sheets.errors import RunBroken, SheetsError
from rrp_sheets.model.exchange import Happening
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.values import Failure, Value
from rrp_sheets.runs.folder import RunFolder
from rrp_sheets.runtime.frame import FrameEngine
from rrp_sheets.runtime.loop import Summary, run_loop
from rrp_sheets.runtime.plan import Plan, make_plan
from rrp_sheets.runtime.ports import Arrivals, World
from rrp_sheets.runtime.trace import TraceWriter, stream_label

if TYPE_CHECKING:
    from rrp_sheets.workbook import Reading

AFTER_SCENE_US = 5_000_000
WITHOUT_SCENE_US = 30_000_000


@dataclass(frozen=True)
class RunSettings:
    """How to run.

    Attributes:
        seconds: of the run's clock; None: the last scene time plus 5 s, 30 s without a Scene sheet.
        fast: as fast as the machine can, instead of in real time.
        out: the folder to leave everything in; None: `runs/<time>-<name>/` beside the workbook.
        seed: None takes the Protocol's.
        mode: `simulated`, or `pilot` for a rehearsal whose data never counts as a session.
        participant, condition, operator: of the session, as codes.
        film: whether to film the robot.
    """

    seconds: float | None = None
    fast: bool = False
    out: Path | None = None
    seed: int | None = None
    mode: str = "simulated"
    participant: str = ""
    condition: str = ""
    operator: str = ""
    film: bool = True


class RunView:
    """What somebody who watches a run is told; subclass it. Nothing here may take long."""

    def started(self, plan: Plan, until_us: int, folder: Path) -> None:
        """The run begins."""

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        """A value on a stream (its id)."""

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        """A formula failed."""

    def happening(self, us: int, happening: Happening) -> None:
        """The robot speaks, clamps a command, notes something."""

    def frame(self, us: int) -> None:
        """A frame is over."""

    def finishing(self) -> None:
        """The robot is brought to rest and the files are written."""

    def stopped(self) -> bool:
        """Whether the run should stop now."""
        return False


@dataclass(frozen=True)
class RunResult:
    """What a run left.

    Attributes:
        folder: of the run.
        files: in it, with what each is.
        summary: counts and times.
        broken: what broke the run off; None when it ended by itself or by the user.
        problems: files that could not be made, in words.
    """

    folder: Path
    files: dict[str, str]
    summary: Summary
    broken: RunBroken | None = None
    problems: tuple[str, ...] = ()


@dataclass
class _Recorder:
    """An engine's observer: the trace and the view."""

    trace: TraceWriter
    view: RunView

    def event(self, us: int, stream: str, row: str, value: Value) -> None:
        self.trace.event(us, stream, row, value)
        self.view.event(us, stream, row, value)

    def error(self, us: int, row: str, failure: Failure, values: tuple[Value, ...]) -> None:
        self.trace.error(us, row, failure, values)
        self.view.error(us, row, failure, values)


def run(
    reading: Reading,
    checked: Checked,
    settings: RunSettings | None = None,
    view: RunView | None = None,
    world: Callable[[Plan, tuple[SceneAction, ...], int, Path], World] | None = None,
) -> RunResult:
    """Run a checked workbook and leave a folder with trace, workbook, catalogue, table, diagram, film and speech.

    Args:
        reading: the workbook as it was read, for the copy that is kept.
        checked: it must have no errors.
        settings: how to run.
        view: told of everything as it happens; may stop the run.
        world: makes the robot's world; the simulated NAO when None.

    Raises:
        SheetsError: when the workbook has errors or the folder cannot be used.
        MissingPart: when the simulator is not installed here.
        RunBroken: when a device does not start; then nothing is left.
    """
    settings, view = settings or RunSettings(), view or RunView()
    if checked.report.errors:
        raise SheetsError("This workbook has errors and cannot run.", "See `rrp-sheets check`.")
    plan = make_plan(checked)
    if not plan.steps:
        raise SheetsError("No row of this workbook is switched on.", "Write TRUE in the On cells of some rows.")
    scene = checked.scene if checked.scene is not None else default_scene(plan.sensors, checked.robot)
    seed = checked.run.seed if settings.seed is None else settings.seed
    folder = RunFolder(reading, settings.out)
    until = _until(checked, settings)
    live = (world or _simulated(settings))(plan, scene, seed, folder.path)
    view.started(plan, until, folder.path)
    arrivals = live.start()
    folder.make()
    folder.keep_workbook(checked)
    header = {
        "program": __version__, "workbook": reading.digest, "name": Path(reading.workbook.source).name,
        "robot": checked.robot.name, "engine": "frame", "frame_rate": checked.run.frame_rate, "mode": settings.mode,
        "seed": seed, "participant": settings.participant, "condition": settings.condition,
        "operator": settings.operator, "began": datetime.now(UTC).isoformat(timespec="milliseconds"),
    }  # fmt: skip
    trace = TraceWriter(folder.path / "trace.jsonl", plan, header)
    engine = FrameEngine(plan, _Recorder(trace, view))
    summary, broken = _go(engine, live, arrivals, until, trace, view, settings)
    files, problems = folder.finish(checked)
    return RunResult(folder.path, files, summary, broken, problems)


def _go(
    engine: FrameEngine,
    world: World,
    arrivals: Arrivals,
    until: int,
    trace: TraceWriter,
    view: RunView,
    settings: RunSettings,
) -> tuple[Summary, RunBroken | None]:
    """The loop between starting and stopping; whatever happens, the world is stopped and the trace is closed."""

    def tell(us: int, happening: Happening) -> None:
        if happening.kind == "error":  # an actuator cannot use its value: an error of that row like any other
            place = happening.row or happening.stream
            engine.errors[place] = engine.errors.get(place, 0) + 1
        view.happening(us, happening)

    began = time.monotonic()
    broken: RunBroken | None = None
    ended = "broken"
    try:
        _, ended = run_loop(engine, world, arrivals, until, trace=trace, paced=not settings.fast,
                            stopped=view.stopped, tell=tell, tick=view.frame)  # fmt: skip
    except RunBroken as error:
        broken = error
    finally:
        wall = time.monotonic() - began
        summary = _summary(engine, wall, ended)
        try:
            view.finishing()
        finally:
            try:
                world.stop()
            except RunBroken as error:
                broken = broken or error  # the first break is the cause
            finally:
                try:
                    trace.close(summary.as_dict(wall=False))
                except RunBroken as error:
                    broken = broken or error
    return summary, broken


def _summary(engine: FrameEngine, wall: float, ended: str) -> Summary:
    labels = {s.id: stream_label(s) for s in engine.plan.streams}
    counts = {labels[i]: s.arrived for i, s in engine.streams.items()}
    commands = {a.name: engine.streams[a.stream].arrived for a in engine.plan.actuators}
    return Summary(counts, dict(engine.errors), commands, engine.clock.us / 1e6, wall, ended)


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


def _simulated(settings: RunSettings) -> Callable[[Plan, tuple[SceneAction, ...], int, Path], World]:
    def make(plan: Plan, scene: tuple[SceneAction, ...], seed: int, out: Path) -> World:
        from rrp_sheets.drivers.simulated import SimulatedWorld
        from rrp_sheets.sim.process import require

        require()
        checked = plan.checked
        return SimulatedWorld(
            checked.robot, plan.sensors, plan.actuators, scene, seed=seed, frame_rate=checked.run.frame_rate, out=out,
            film=settings.film, title=checked.workbook.protocol.text("Title"),
        )  # fmt: skip

    return make
