"""The check of a whole workbook: graph, formulas, protocol, scene; all findings at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from rrp_sheets.checks.ambiguous_fixes import judge_proposals
from rrp_sheets.checks.facts import Fact
from rrp_sheets.checks.formulas import check_formulas
from rrp_sheets.checks.keeping import check_kept
from rrp_sheets.checks.lints import lint
from rrp_sheets.checks.material import check_device_material
from rrp_sheets.checks.protocol import RunPlan, check_protocol
from rrp_sheets.checks.scene import find_cues
from rrp_sheets.checks.tests import Case, MakeScope, check_tests, switchable
from rrp_sheets.connectors import connectors
from rrp_sheets.devices import Robot, load_robot, robot_names
from rrp_sheets.devices.gesture_sheet import parse_gestures
from rrp_sheets.devices.own_robot import own_robot
from rrp_sheets.devices.scene import check_presses, parse_scene
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.formulas import Formula, make_scope
from rrp_sheets.graph import Graph, Stream
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.names import nearest
from rrp_sheets.model.scene import SceneAction
from rrp_sheets.model.workbook import Workbook


@dataclass(frozen=True)
class Checked:
    """A workbook that was checked: what is needed to draw, explain and run it, and what was found.

    Attributes:
        formulas: by the row's ref (`Tracking!4`); missing where there is none or where it is wrong.
        scene: understood actions; None without a Scene sheet.
        run: what the Protocol says about running.
        tests: the test sheets, understood.
        facts: what is known about streams before the run, by stream id; of what a `subscribe` row sends, by its ref.
        cues: the streams that rows of the scene wait for.
        scope: makes the scope of a formula outside of the rows, with the workbook's helpers and tables.
    """

    workbook: Workbook
    robot: Robot
    graph: Graph
    formulas: Mapping[str, Formula]
    scene: tuple[SceneAction, ...] | None
    run: RunPlan
    tests: tuple[Case, ...]
    report: Report
    facts: Mapping[str, Fact] = field(default_factory=dict)
    scope: MakeScope = make_scope
    cues: tuple[Stream, ...] = ()


def check_workbook(workbook: Workbook, report: Report, *, lints: bool = True) -> Checked:
    """Check a workbook, adding to the report that reading it began.

    Args:
        workbook: as it was read.
        report: takes what is found.
        lints: whether warnings about rows that work, and which fixes are safe, are wanted as well.
    """
    robot = robot_of(workbook, report)
    graph = build_graph(workbook, robot, connectors(), report)
    compiled = check_formulas(workbook, robot, graph, report)
    scene = None if workbook.scene is None else parse_scene(workbook.scene, report, robot, folder_of(workbook))
    cues: tuple[Stream, ...] = ()
    if scene:
        scene, cues = find_cues(workbook.scene or (), scene, graph, report)
        check_presses(workbook.scene or (), scene, _buttons(workbook, graph, robot), report)
    check_device_material(workbook, robot, folder_of(workbook), report)
    run = check_protocol(workbook, report)
    tests = check_tests(workbook, robot, graph, run.behaviours, compiled.records, compiled.scope, report)
    if lints:
        lint(workbook, robot, graph, compiled, run.behaviours | switchable(graph), report)
        check_kept(workbook, robot, graph, run, report)
    report.drop_followers()
    if lints:
        judge_proposals(graph, robot, compiled, report)
    return Checked(
        workbook, robot, graph, compiled.formulas, scene, run, tests, report, compiled.facts, compiled.scope, cues
    )


def folder_of(workbook: Workbook) -> Path:
    """Where the files are that the workbook names."""
    source = Path(workbook.source)
    return source if source.is_dir() else source.parent


def _buttons(workbook: Workbook, graph: Graph, robot: Robot) -> list[str]:
    """The labels of the operator's buttons, declared or used by their names alone."""
    declared = [d for d in workbook.devices if (f := robot.find(d.device.text)) and f.type.name == "OperatorButton"]
    labels = [d.settings["label"].text if d.settings.get("label") else d.stream.text for d in declared]
    used = [s for s in graph.streams.values() if s.device and s.device.type.name == "OperatorButton"]
    return list(dict.fromkeys([*labels, *(str(s.settings["label"]) for s in used)]))


def robot_of(workbook: Workbook, report: Report) -> Robot:
    """The robot that a workbook is for, with the workbook's gestures; what is wrong with them goes into the report."""
    robot = _robot(workbook, report)
    return robot.with_gestures(parse_gestures(workbook.gestures, robot, report))


def _robot(workbook: Workbook, report: Report) -> Robot:
    name = workbook.protocol.robot
    if workbook.source and Path(workbook.source).exists() and (own := own_robot(folder_of(workbook), name)) is not None:
        return own
    if name in robot_names():
        return load_robot(name)
    address = workbook.protocol.fields["robot"].address
    guess = nearest(name, robot_names())
    remedy = (
        Phrase("Did you mean {guess}?", guess=guess)
        if guess
        else Phrase("The robots are: {names}.", names=", ".join(robot_names()))
    )
    report.add("PROT001", address, name=name, remedy=remedy)
    return load_robot("nao")
