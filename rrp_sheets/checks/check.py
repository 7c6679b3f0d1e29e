"""The check of a whole workbook: graph, formulas, scene, devices' words and sounds, protocol, tests, and proposals.

It also gives the example values that are shown beside the rows.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rrp_sheets.checks.ethics import Study, check_ethics
from rrp_sheets.checks.facts import Fact
from rrp_sheets.checks.formulas import Compiled, check_formulas
from rrp_sheets.checks.lints import lint
from rrp_sheets.checks.protocol import RunPlan, check_kept, check_protocol
from rrp_sheets.checks.renaming import offer_new_names
from rrp_sheets.checks.tests import Case, MakeScope, check_tests, switchable
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.diagnostics.report import Fix, Replace, meant
from rrp_sheets.formulas import Formula, make_scope
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph import Graph, Stream, StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.graph.device_table import divided_phrase, doubtful_phrase, understand
from rrp_sheets.graph.names import DONE_DEVICE
from rrp_sheets.model.exchange import ROW_ABOVE, SceneAction
from rrp_sheets.model.names import Proposals, argument_name, count_typos, key, nearest
from rrp_sheets.model.workbook import SceneRow, Workbook
from rrp_sheets.robots import Robot, load_robot, robot_names
from rrp_sheets.robots.gesture_sheet import parse_gestures
from rrp_sheets.robots.media_files import SUFFIX, BadSoundError, check_sound, is_plain
from rrp_sheets.robots.own_robot import own_robot
from rrp_sheets.scene.scene_sheet import check_presses, parse_scene
from rrp_sheets.texts import N_

_ANY = N_("Write a stream that a row of this workbook reads or produces, or a done stream such as Say done.")
_PLAIN = (StreamKind.SENSOR, StreamKind.DONE, StreamKind.ORDINARY)
_ELSE = N_("Put it there, or leave the cell blank and choose a Sound.")
MOST_JUDGED = 300
"""A workbook with more mistakes is corrected step by step, each with a check of its own."""
MOST_COMPARED = 300_000  # pairs of names, for the same reason


@dataclass(frozen=True)
class Checked:
    """A checked workbook: everything needed to draw, explain and run it, and the findings."""

    workbook: Workbook
    robot: Robot
    graph: Graph
    formulas: Mapping[str, Formula]  # by the row's ref (`Tracking!4`); missing where there is none or where it is wrong
    scene: tuple[SceneAction, ...] | None  # None without a Scene sheet
    run: RunPlan
    tests: tuple[Case, ...]
    report: Report
    facts: Mapping[str, Fact] = field(default_factory=dict)  # by stream id; of what a `subscribe` row sends, by its ref
    # makes the scope of a formula outside of the rows, with the workbook's helpers and tables
    scope: MakeScope = make_scope
    cues: tuple[Stream, ...] = ()  # the streams that rows of the scene wait for

    @property
    def study(self) -> Study:
        """The workbook as an ethics board asks about it."""
        return Study(self.workbook, self.robot, self.graph, self.run, self.facts)


def check_workbook(workbook: Workbook, report: Report, *, lints: bool = True) -> Checked:
    """Check a workbook, adding to the report that reading it began.

    Without `lints`, nothing warns of rows that work, and no fix is judged whether it is safe.
    """
    robot, folder = robot_of(workbook, report), folder_of(workbook)
    graph = build_graph(workbook, robot, connectors(), report)
    compiled = check_formulas(workbook, robot, graph, report)
    scene = None if workbook.scene is None else parse_scene(workbook.scene, report, robot, folder)
    cues: tuple[Stream, ...] = ()
    if scene:
        scene, cues = find_cues(workbook.scene or (), scene, graph, report)
        check_presses(workbook.scene or (), scene, _buttons(workbook, graph, robot), report)
    check_device_material(workbook, robot, folder, report)
    run = check_protocol(workbook, report)
    tests = check_tests(workbook, robot, graph, run.behaviours, compiled.records, compiled.scope, report)
    if lints:
        lint(workbook, robot, graph, compiled, run.behaviours | switchable(graph), report)
        check_kept(workbook, robot, graph, run, report)
        check_ethics(Study(workbook, robot, graph, run, compiled.facts), report)
    report.drop_followers()
    if lints:
        judge_proposals(graph, robot, compiled, report)
        offer_new_names(workbook, graph, report, lambda before: check_workbook(before, Report(), lints=False))
    return Checked(
        workbook, robot, graph, compiled.formulas, scene, run, tests, report, compiled.facts, compiled.scope, cues
    )


def folder_of(workbook: Workbook) -> Path:
    """Return the folder of the files that the workbook names."""
    source = Path(workbook.source)
    return source if source.is_dir() else source.parent


def _buttons(workbook: Workbook, graph: Graph, robot: Robot) -> list[str]:
    """Return the labels of the operator's buttons, declared or used by their names alone."""
    declared = [d for d in workbook.devices if (f := robot.find(d.device.text)) and f.type.is_button]
    labels = [d.settings["label"].text if d.settings.get("label") else d.stream.text for d in declared]
    used = [s for s in graph.streams.values() if s.device and s.device.type.is_button]
    return list(dict.fromkeys([*labels, *(str(s.settings["label"]) for s in used)]))


def robot_of(workbook: Workbook, report: Report) -> Robot:
    """Return the workbook's robot with the workbook's gestures; problems with either go into the report."""
    name = workbook.protocol.robot
    names = robot_names()
    on_disk = workbook.source and Path(workbook.source).exists()
    robot = own_robot(folder_of(workbook), name) if on_disk else None
    if robot is None and name not in names:
        address = workbook.protocol.fields["robot"].address
        robots = N_("The robots are: {names}.", names=", ".join(names))
        report.add("PROT001", address, name=name, **meant(nearest(name, names), robots))
    robot = robot or load_robot(name if name in names else "nao")
    return robot.with_gestures(parse_gestures(workbook.gestures, robot, report))


def find_cues(
    rows: Sequence[SceneRow], scene: Sequence[SceneAction], graph: Graph, report: Report
) -> tuple[tuple[SceneAction, ...], tuple[Stream, ...]]:
    """Return the actions with the ids of the streams that they wait for, and those streams."""
    cells = {row.time.address.row: row.time for row in rows}
    waits = any(action.cue not in ("", ROW_ABOVE) for action in scene)
    known = _by_name(graph) if waits else {}
    propose = Proposals()
    found, streams = [], dict[str, Stream]()
    for action in scene:
        if action.cue in ("", ROW_ABOVE):
            found.append(action)
            continue
        sheet, mark, name = action.cue.partition("!")
        stream = known.get(f"{key(sheet)}!{key(name)}" if mark else key(sheet))
        if stream is None:
            guess = propose(action.cue, [s.name for s in known.values()])
            report.add("SCENE007", cells[action.row].address, name=action.cue, **meant(guess, _ANY))
            continue
        streams[stream.id] = stream
        found.append(replace(action, cue=stream.id))
    return tuple(found), tuple(streams.values())


def _by_name(graph: Graph) -> dict[str, Stream]:
    """Return the streams that a scene row may wait for, by the keys of their names; those of the first sheet win."""
    named: dict[str, Stream] = {}
    for stream in graph.streams.values():
        if stream.kind in _PLAIN and stream.active:
            named.setdefault(key(stream.name), stream)
            if stream.kind is StreamKind.ORDINARY:
                named.setdefault(f"{key(stream.address.sheet)}!{key(stream.name)}", stream)
        elif stream.kind is StreamKind.ACTUATOR and stream.active:
            done = f"{stream.id}done"
            made = Stream(done, f"{stream.name} done", StreamKind.DONE, stream.address, DONE_DEVICE, done_of=stream.id)
            named.setdefault(done, graph.streams.get(done, made))
    return named


def check_device_material(workbook: Workbook, robot: Robot, folder: Path, report: Report) -> None:
    """Report words that cannot be recognised, phrases with doubtful commas, and sound files that cannot be played."""
    for device in workbook.devices:
        found = robot.find(device.device.text)
        for k, cell in device.settings.items() if found else ():
            setting = found.type.settings.get(k) if found else None
            if setting is None or not cell:
                continue
            if setting.kind == "words":
                words, wrong = understand(setting, cell.text, robot)
                if wrong:
                    continue
                if unheard := [word for word in words or () if not can_be_heard(word)]:
                    report.add("DEV011", cell.address, word=unheard[0])
                if phrase := doubtful_phrase(cell.text):
                    report.add("DEV013", cell.address, phrase=phrase)
                whole, count = divided_phrase(cell.text)
                if whole:
                    report.add("DEV014", cell.address, phrase=whole, count=count)
            elif setting.kind == "sound file" and is_plain(name := cell.text.strip()):  # any other is told elsewhere
                try:
                    check_sound(folder, name)
                except BadSoundError as problem:
                    guess = None if (folder / name).is_file() else nearest(name, _sounds_in(folder))
                    report.add("DEV012", cell.address, name=name, problem=problem.args[0], **meant(guess, _ELSE))


def can_be_heard(word: str) -> bool:
    """Return whether a word is written as English is: Latin letters and digits, with signs between them.

    >>> [can_be_heard(w) for w in ("yes", "x-ray", "café", "7 up", "はい", "да", "?")]
    [True, True, True, True, False, False, False]
    """
    spoken = [c for c in unicodedata.normalize("NFKC", word) if c.isalnum()]
    return bool(spoken) and all(c in "0123456789" or unicodedata.name(c, "").startswith("LATIN ") for c in spoken)


def _sounds_in(folder: Path) -> list[str]:
    try:
        return [p.name for p in sorted(folder.iterdir())[:1_000] if p.suffix.casefold() == SUFFIX]
    except OSError:
        return []


def judge_proposals(graph: Graph, robot: Robot, compiled: Compiled, report: Report) -> None:
    """Mark a fix as unsafe when the corrected name is not the only one that may be meant."""
    if not any(d.fixes for d in report):
        return
    streams = {s.name for s in graph.streams.values() if s.name}
    devices = {f.name for f in robot.names.values() if f.offered}
    helpers = {h.shown for h in compiled.helpers.by_key.values()}
    names: dict[str, Collection[str]] = {
        "CONN002": {c.name for c in connectors()},
        "GRAPH001": streams | devices,
        "GRAPH006": streams | devices,
        "DEV001": devices,
        "FORM004": {argument_name(n) for n in streams} | helpers,
        "FORM005": {f.name for f in library()} | helpers,
    }
    judged, compared = MOST_JUDGED, MOST_COMPARED

    def judge(finding: Diagnostic, fix: Fix) -> Fix:
        nonlocal judged, compared
        edit = fix.edits[0] if len(fix.edits) == 1 else None
        if not fix.safe or not isinstance(edit, Replace) or finding.code not in names:
            return fix
        judged, compared = judged - 1, compared - len(names[finding.code])
        if judged < 0 or compared < 0:
            return replace(fix, safe=False)
        best = count_typos(edit.old, edit.new)
        near = {key(n) for n in names[finding.code] if count_typos(edit.old, n, best) <= best}
        return replace(fix, safe=not near - {key(edit.new)})

    report.judge_fixes(judge)


def row_examples(checked: Checked) -> dict[str, Fact]:
    """Return the fact about each row's output, by the row's ref (`Tracking!4`), in the order of the sheets.

    Rows without an example are missing: those that are off or wrong, and those of which nothing can be said.
    """
    found: dict[str, Fact] = {}
    for behaviour in checked.graph.behaviours:
        for step in behaviour.steps:
            fact = checked.facts.get(step.ref if step.connector.is_sink else step.output)
            if step.row.on and fact is not None and fact.has_example:
                found[step.ref] = fact
    return found
