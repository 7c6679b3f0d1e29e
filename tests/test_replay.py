"""Recorded runs done again from what their sensors gave: the same events, or every difference."""

from __future__ import annotations

import gc
import json
import math
import shutil
from pathlib import Path

import pytest
from acting import Run, Script, wish
from play import rows
from recorded import END, EVENT, HEADER, write_run

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.help.connectors import ScriptedWorld
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.run_files import ORPHANED, RecordedEvent
from rrp_sheets.recording.metadata import metadata_of
from rrp_sheets.replay.record import read_record
from rrp_sheets.replay.replaying import replay
from rrp_sheets.replay.report import as_text
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunSettings
from rrp_sheets.runs.running import run as start_run
from rrp_sheets.workbook import read

ROWS = """
| Head yaw | accumulate | total + headYaw | Sum |
| Sum, Head pitch | combineLatest | sum * 10 + headPitch | Both |
| Both | subscribe | | Print |
| Head yaw | sample | 300 ms | Sampled |
| Sampled | map | double(sampled) | |
| | filter | value > 2 | Large |
| | | | |
| Large | subscribe | | Say |
| Head yaw | map | PICK("a"; "b"; "c") & LOOKUP_(headYaw) | Drawn |
| Drawn | subscribe | | Say |
| Head yaw | map | IF(headYaw > 4; "2 s"; "100 ms") | Long |
| Long | subscribe | | Pause |
| Pause done | map | pauseDone.seconds | Paused |
| Tick | map | tick.count | Ticks |
| Head yaw | map | 1 / (headYaw - 2) | Divided |
| Head yaw | delay | 150 ms | Late |
| Head yaw | timeout | 250 ms | Quiet |
| Head yaw | forgetAfter | 200 ms | Fresh |
| Say done | map | sayDone.value & "!" | Said |
| Say done | accumulate | | Ends |
| Divided, Late, Quiet, Fresh, Said, Ticks, Paused, Ends | merge | | All |
| All | subscribe | | Print |
| Head yaw | filter | headYaw = 3 | Three |
| Three | subscribe | | On other |
"""
OTHER = """
| Head pitch | accumulate | | Pitches |
| Pitches | subscribe | | Print |
"""
MORE = (
    "## Other\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n" + OTHER.lstrip("\n"),
    "## Devices\n| Stream | Device | Name | Every | State |\n|---|---|---|---|---|\n| Tick | Timer | | 170 ms | |\n"
    "| Pause | Wait | | | |\n| On other | Behaviour | Other | | on |\n",
    "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| double | x | x * 2 |\n| lookup_ | n | INDEX(Words[Word]; MOD(n; 2) + 1) |\n",
    "## Words\n| Word |\n|---|\n| red |\n| blue |\n",
    "## Protocol\n| Field | Value |\n|---|---|\n| Robot | nao |\n| Run | T |\n",
)


def said(value, completed=True, seconds=0.2):
    return DONE.make(value=value, completed=completed, seconds=seconds)


EVENTS = [
    *((n * 100, "headyaw", n % 7) for n in range(40)), *((n * 250, "headpitch", n) for n in range(16)),
    (700, "saydone", said("ared")), (1500, "saydone", said((1, 2))), (2900, "saydone", said("x", False)),
]  # fmt: skip


def apply(folder, text):
    def edit(control):
        (folder / "book.md").write_text(text)
        control.ask(wish("apply", "Bo", path=str(folder / "book.md")))

    return edit


def resume(script, control, edits):
    """Go on when so many edits were used; until then look again."""
    assert not script.refusals
    if sum(act.kind == "edit" for _, act in script.acts) == edits:
        control.ask(wish("resume"))
    else:
        script.waiting.insert(0, lambda control: resume(script, control, edits))


@pytest.fixture(scope="module")
def acted(tmp_path_factory) -> Run:
    """A run in which people edited, switched, sent, marked and paused."""
    folder = tmp_path_factory.mktemp("acted")
    book = rows(ROWS, *MORE)
    changed = book.replace("total + headYaw", "total + headYaw * 100").replace("300 ms", "200 ms")
    table = changed.replace("| blue |", "| green |").replace("| double | x | x * 2 |", "| double | y | y * 20 |")
    script = Script({
        10: [wish("pause"), apply(folder, changed)], 40: [wish("switch", behaviour="T", on=False)],
        44: [wish("mark", note="hm"), wish("switch", behaviour="T", on=True)],
        50: [wish("send", stream="Head yaw", text="3.5"), wish("send", stream="Say done", text="value=\"ared\"")],
        55: [wish("speed", factor=2)], 60: [wish("pause"), apply(folder, table)],
        70: [wish("switch", behaviour="Other", on=False), wish("switch", behaviour="Other", on=True)],
        80: [wish("pause"), wish("step"), wish("resume")], 90: [wish("switch", behaviour="Other", on=False)],
    })  # fmt: skip
    script.waiting = [
        lambda control: resume(script, control, 1), lambda control: resume(script, control, 2),
    ]  # fmt: skip
    made = Run(folder, book, script, EVENTS, seconds=4.0, everything=True)
    assert not script.refusals and len(made.happened("edit")) == 4 and len(made.happened("switch")) == 5
    return made


@pytest.fixture
def record(acted, tmp_path) -> Path:
    """A copy of its folder, to be spoilt."""
    return Path(shutil.copytree(acted.result.folder, tmp_path / "record"))


def lines_of(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / "trace.jsonl").read_text().splitlines()]


def write(folder: Path, lines) -> None:
    (folder / "trace.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


@pytest.mark.slow
def test_everything_comes_again(acted):
    found = api.replay(acted.result.folder)
    assert found.same and found.differences == () and found.remarks == ()
    told = [e for e in acted.lines if "value" in e or "error" in e or str(e.get("text")).startswith("The behaviour")]
    assert found.compared == sum("by" not in e or "value" in e for e in told) > 400
    assert as_text(found).startswith(f"The same: {found.compared:,} events in 4 s, as recorded.")
    failed = {c.row: c.came for c in found.counts if not c.stream and not c.came_row.startswith("Other")}
    assert failed["T!16"] == sum(e.get("row") == "T!16" and "error" in e for e in acted.lines) > 3


def test_the_trace_alone_is_told_and_the_workbook_may_be_named(acted, tmp_path):
    trace = tmp_path / "trace.jsonl"
    shutil.copy(acted.result.folder / "trace.jsonl", trace)
    with pytest.raises(SheetsError, match="The workbook of the run is not next to"):
        api.replay(trace)
    found = api.replay(trace, acted.result.folder / "protocol.xlsx")
    assert found.same and found.other == "protocol.xlsx"
    assert (
        found.remarks[0]
        == "The workbook of the run is not next to the recording, so streams are identified by their names alone."
    )


@pytest.mark.parametrize(("number", "change", "kind", "words"), [
    (0, {"value": -1}, "value", "T row 2 → Sum: it was {was} instead of -1"),
    (0, None, "extra", "T row 2 → Sum: {was} happened but was not recorded"),
    (3, {"value": -1}, "value", "T row 2 → Sum: it was {was} instead of -1"),
])  # fmt: skip
def test_one_event_that_is_different_is_found(record, number, change, kind, words):
    lines = lines_of(record)
    place = [i for i, e in enumerate(lines) if e.get("stream") == "T!Sum"][number]
    was = lines[place]["value"]
    lines[place : place + 1] = [{**lines[place], **change}] if change else []
    write(record, lines)
    found = api.replay(record)
    assert [(d.kind, d.stream, d.row) for d in found.differences] == [(kind, "T!Sum", "T!2")]
    assert words.format(was=was) in as_text(found)


def test_what_was_recorded_and_does_not_come_is_found(record):
    lines = lines_of(record)
    place = next(i for i, e in enumerate(lines) if e.get("stream") == "T!Late")
    write(record, [*lines[:place], {**lines[place], "value": "more"}, *lines[place:]])
    [one] = api.replay(record).differences
    assert (one.kind, one.recorded, one.came) == ("missing", "more", None)


def test_true_is_not_one_and_one_is_not_one_point_nothing(record):
    lines = lines_of(record)
    [first] = [i for i, e in enumerate(lines) if e.get("stream") == "T!Ends"][:1]
    assert lines[first]["value"] == 1
    for other in (True, 1.0):
        write(record, [*lines[:first], {**lines[first], "value": other}, *lines[first + 1 :]])
        assert [d.kind for d in api.replay(record).differences] == ["value"]


def test_another_order_in_one_moment_is_told(record):
    lines = lines_of(record)
    streams = [e.get("stream") for e in lines]
    place = next(i for i in range(len(lines)) if streams[i] == "T!Sum" and lines[i + 1].get("t") == lines[i]["t"]
                 and streams[i + 1] != streams[i] and "row" in lines[i + 1] and lines[i + 1]["row"])  # fmt: skip
    lines[place : place + 2] = lines[place : place + 2][::-1]
    write(record, lines)
    assert [d.kind for d in api.replay(record).differences] == ["order"]


def test_a_record_that_was_cut_off_is_replayed_up_to_there(record):
    whole = (record / "trace.jsonl").read_bytes()
    for part in (0.5, 0.503, 0.9):
        (record / "trace.jsonl").write_bytes(whole[: int(len(whole) * part)])
        found = api.replay(record)
        assert found.same and "The recording has no end. It stops at" in as_text(found)
    assert found.compared > 300


def test_a_run_that_broke_off_is_replayed_up_to_its_last_moment(record):
    lines = lines_of(record)
    lines = [e for e in lines if e.get("t", 0) <= 2.0]
    bad = {"t": 2.0, "stream": "T!Sum", "row": "T!2", "value": "half"}
    write(
        record,
        [*lines, bad, {"type": "summary", "ended": "broken", "why": "The disk is full.", "simulated_seconds": 2.0}],
    )
    found = api.replay(record)
    assert (
        found.same
        and "The run stopped unexpectedly at 2 s: The disk is full. That last moment is not replayed." in found.unknown
    )


@pytest.mark.parametrize("spoil", [
    lambda lines: [{"type": "header"}], lambda lines: [], lambda lines: [{**lines[0], "seed": "x"}, *lines[1:]],
    lambda lines: [*lines[:5], {"t": -3, "stream": "Head yaw", "row": "", "value": 1}],
    lambda lines: [*lines[:5], {"t": "soon", "stream": "Head yaw", "row": "", "value": 1}],
    lambda lines: [*lines[:5], {"t": 9.0, "stream": [], "row": "", "value": 1}],
    lambda lines: [*lines[:50], *lines[1:50]], lambda lines: [lines[0], [1, 2]],
    lambda lines: [*lines[:-1], {"t": 1e300, "stream": "Head yaw", "row": "", "value": 1}],
])  # fmt: skip
def test_what_is_no_trace_is_told(record, spoil):
    write(record, spoil(lines_of(record)))
    with pytest.raises(UnreadableFile, match="is not a recording"):
        api.replay(record)


def test_hostile_values_of_a_damaged_record_do_no_harm(record):
    lines = lines_of(record)
    odd = [{"t": 1.0, "stream": "Head yaw", "row": "", "value": v} for v in ({"a": {"b": []}}, [[1]], "x" * 5000, None)]
    odd += [{"t": 1.0, "stream": "Say done", "row": "", "value": 7}, {"t": 1.0, "stream": "Nobody", "row": "", "value": 1},
            {"t": 1.0, "happening": "switch", "detail": {"behaviour": "<b>", "on": True}, "wall": 1},
            {"t": 1.0, "happening": "edit", "detail": {"place": "T!99", "was": "", "now": "<script>"}, "wall": 2},
            {"t": 1.0, "happening": "edit", "detail": {"place": "Helpers!double", "now": "((("}, "wall": 3},
            {"t": 1.0, "happening": "edit", "detail": {"place": "T", "table": 3}, "wall": 4}]  # fmt: skip
    place = next(i for i, e in enumerate(lines) if e.get("t", 0) > 1.0)
    write(record, [*lines[:place], *odd, *lines[place:]])
    try:
        found = api.replay(record)
    except UnreadableFile:
        return
    assert not found.same and as_text(found)


def test_older_programs_and_changed_copies_are_told(record):
    lines = lines_of(record)
    write(record, [{**lines[0], "program": "0.1.0", "name": "book.xlsx"}, *lines[1:]])
    (record / "gestures.toml").write_text("# another one\n")
    found = api.replay(record)
    assert found.same
    words = " ".join(found.remarks)
    assert "recorded with version 0.1.0" in words and "is not the one that ran" in words
    assert "The robot's catalogue (gestures.toml) has changed" in words


def test_a_row_ends_the_run_again_at_its_time(tmp_path):
    book = rows("| Head yaw | filter | headYaw = 3 | Enough |\n| Enough | subscribe | | End run |")
    made = Run(tmp_path, book, Script(), EVENTS, seconds=4.0)
    assert made.lines[-1]["ended"] == "end run"
    found = api.replay(made.result.folder)
    assert found.same and found.seconds == pytest.approx(0.3)
    made.path.write_text(book.replace("= 3", "= 30"))
    other = api.replay(made.result.folder, made.path)
    assert other.ending == "T row 3 ended the run at 0.3 s. It would have continued." and not other.same
    made.path.write_text(book.replace("= 3", "= 1"))
    assert "The run would have ended at 0.1 s instead of 0.3 s." in as_text(api.replay(made.result.folder, made.path))


def test_what_goes_on_at_the_end_ends_without_any_row_having_seen_it(tmp_path):
    book = rows("| Head yaw | once | | First |\n| First | map | \"9 s\" | Long |\n| Long | subscribe | | Wait |\n"
                "| Wait done | accumulate | | Ends |\n| Ends | subscribe | | Print |")  # fmt: skip
    made = Run(tmp_path, book, Script(), EVENTS, seconds=1.0)
    ends = [e for e in made.lines if e.get("stream") == "Wait done"]
    assert len(ends) == 1 and not [e for e in made.lines if e.get("stream") == "T!Ends"]
    assert api.replay(made.result.folder).same


def test_an_event_loop_is_done_again_event_by_event(tmp_path):
    protocol = "## Protocol\n| Field | Value |\n|---|---|\n| Robot | nao |\n| Engine | event loop |\n| Run | T |\n"
    book = rows(ROWS, *MORE[:4], protocol)
    script = Script({8: [wish("send", stream="Head yaw", text="3.5"), wish("switch", behaviour="Other", on=True)],
                     20: [wish("switch", behaviour="T", on=False), wish("pause"), wish("resume")],
                     24: [wish("switch", behaviour="T", on=True)]})  # fmt: skip
    script.frames[32] = lambda control: control.stop("Aya")
    made = Run(tmp_path, book, script, EVENTS, seconds=5, paced=True, everything=True)
    assert not script.refusals and len(made.happened("switch")) >= 2 and made.lines[-1]["ended"] == "stopped"
    found = api.replay(made.result.folder)
    assert found.same, as_text(found)
    assert found.compared > 80 and found.engine == "event loop"
    assert "same microsecond" in " ".join(found.unknown)


def test_what_is_done_after_the_last_frame_is_done_again(tmp_path):
    book = rows("| Head yaw | subscribe | | Say |\n| Head yaw | subscribe | | Pause |",
                "## Devices\n| Stream | Device | Time |\n|---|---|---|\n| Pause | Wait | 9 s |\n")  # fmt: skip
    script = Script({20: [wish("switch", behaviour="T", on=False), lambda control: None]})
    script.frames[20].append(lambda control: script.frames.update({21: lambda c: c.stop("Aya")}))
    made = Run(tmp_path, book, script, EVENTS, seconds=4.0)
    assert made.happened("switch") and made.lines[-1]["ended"] == "stopped"
    assert api.replay(made.result.folder).same


# ---- long sessions


def a_session(folder: Path, seconds: int) -> Path:
    """Complex tracking with a ball and a head that move; without the simulator."""
    book = bundled("workbooks", "complex-tracking.xlsx")
    reading = read(book)
    checked = check_workbook(reading.workbook, reading.report)
    ball = checked.robot.find("Red ball").type.payload
    events = [
        (n * 100_000, "redball", ball.make(**{**ball.example().values, "distance": 1 + math.sin(n / 30)}))
        for n in range(seconds * 10)
    ]
    events += [(n * 60_000, "headyaw", round(math.sin(n / 11), 3)) for n in range(seconds * 16)]
    settings = RunSettings(seconds=seconds, fast=True, out=folder)
    start_run(reading, checked, settings, world=lambda plan, scene, seed, place: ScriptedWorld(events))
    return folder


@pytest.fixture(scope="module")
def long_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return a_session(tmp_path_factory.mktemp("long") / "run", 24)


@pytest.mark.slow
def test_the_lines_of_a_long_session_are_not_kept(long_session: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.xlsx"
    shutil.copy(bundled("workbooks", "complex-tracking.xlsx"), other)
    row = api.read(other).workbook.behaviours[0].rows[2]
    api.set_cell(other, f"Tracking!{row.formula.address.cell}", "0.9 <= distance < 1.5")
    for workbook in (None, other):
        alive: list[int] = []

        def count(_part: float, alive: list[int] = alive) -> None:
            alive.append(sum(isinstance(one, RecordedEvent) for one in gc.get_objects()))

        found = replay(long_session, workbook, count)
        alive.append(sum(isinstance(one, RecordedEvent) for one in gc.get_objects()))
        assert found.compared > 1_500 and found.same is (workbook is None)
        assert len(alive) > 1 and max(alive) < 200, alive
        assert sum(1 for _ in found.recorded) == found.compared  # they can be gone through again


def test_a_trace_that_changes_meanwhile_is_told(long_session: Path, tmp_path: Path) -> None:
    session = shutil.copytree(long_session, tmp_path / "run")
    trace = session / "trace.jsonl"

    def change(_part: float) -> None:
        lines = trace.read_text(encoding="utf-8").splitlines(keepends=True)
        trace.write_text("".join([*lines[:100], '{"t": "soon", "stream": 5}\n', *lines[100:]]), encoding="utf-8")

    with pytest.raises(UnreadableFile, match="is not a recording"):
        replay(session, told=change)


def test_a_second_header_is_a_line_like_others(tmp_path: Path) -> None:
    session = a_session(tmp_path / "run", 3)
    trace = session / "trace.jsonl"
    lines = trace.read_text(encoding="utf-8").splitlines(keepends=True)
    trace.write_text(
        "".join([*lines[:50], lines[0].replace("{", '{"t":' + str(json.loads(lines[50])["t"]) + ",", 1), *lines[50:]]),
        encoding="utf-8",
    )
    found = replay(session)
    assert found.same


def test_a_record_of_a_run_that_was_killed_says_so(tmp_path):
    """The same record is `killed` for the replay, the table and the list of runs."""
    for by, ended in ((ORPHANED, "killed"), ("Aya", "stopped")):
        place = write_run(tmp_path, by, HEADER, EVENT, END | {"ended": "stopped", "stopped_by": by})
        assert read_record(place).ended == metadata_of(place).ended == ended
