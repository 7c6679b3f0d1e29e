"""Actions on a run that goes on: pause, step, speed, marks, switches, values, the scene."""

from __future__ import annotations

import textwrap
import threading
import time
from dataclasses import replace

import pytest
from acting import Run, Script, wish
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import example as also
from hypothesis import strategies as st
from play import check, example, rows

from rrp_sheets import api
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.realtime import FramePacer, SnapshotThrottle
from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.recording.marbles import trace_scores
from rrp_sheets.recording.table import tidy_table
from rrp_sheets.recording.trace_reader import TraceReader
from rrp_sheets.runs.run_process import Watchdog
from rrp_sheets.runs.running import start_of

BOOK = rows(
    """
    | Head yaw | accumulate | total + headYaw | Sum |
    | Sum | subscribe | | Print |
    | Head yaw | sample | 200 ms | Sampled |
    | Sampled | forgetAfter | 100 ms | Kept |
    | Red ball | map | redBall.distance * factor() | Distance |
    | Distance | subscribe | | Head tracker |
    | Start button | map | startButton.count | Presses |
    | Wait done | map | waitDone.seconds | Waited |
    | Presses | subscribe | | Wait |
    """,
    """
    ## Other
    | Input streams | Connector | Formula | Output stream |
    |---|---|---|---|
    | Head yaw | accumulate | total + 1 | Count |
    | Count | subscribe | | Say |
    """,
    """
    ## Devices
    | Stream | Device | Label | Time |
    |---|---|---|---|
    | Start button | OperatorButton | Start | |
    | Wait | Wait | | 300 ms |
    """,
    """
    ## Helpers
    | Name | Inputs | Formula |
    |---|---|---|
    | factor | | 2 |
    """,
)
EVENTS = [(n * 100, "headyaw", n) for n in range(10)]
FRAME = 33_333


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    """The workbook as .xlsx, which each run keeps as it is: to make it anew takes longer than most runs."""
    folder = tmp_path_factory.mktemp("book")
    (folder / "book.md").write_text(BOOK)
    return api.convert(folder / "book.md", folder / "book.xlsx")


@pytest.fixture(scope="module")
def untouched(tmp_path_factory, book):
    """The same run, when nobody does anything."""
    return Run(tmp_path_factory.mktemp("plain"), book, Script(), EVENTS)


# ---- the clock
@pytest.mark.slow
def test_a_pause_changes_nothing_but_is_recorded(tmp_path, untouched, book):
    script = Script({3: wish("pause")}, [(), wish("mark", note="he laughs"), wish("resume", "Bo")])
    made = Run(tmp_path, book, script, EVENTS)
    assert made.plain == untouched.plain
    assert script.pauses == [(100_000, True), (100_000, False)] and script.times == untouched.script.times
    told = [(line["happening"], line["text"], line["by"], line["t"]) for line in made.lines if "wall" in line]
    assert told == [
        ("pause", "Paused.", "Anna", 0.1),
        ("mark", "he laughs", "Anna", 0.1),
        ("resume", "Continues.", "Bo", 0.1),
    ]


def test_steps_go_on_one_frame_each(tmp_path, untouched, book):
    seen = []
    script = Script({0: [wish("pause"), wish("step")]})
    script.waiting = [lambda c: seen.append(script.number), wish("step"), lambda c: seen.append(script.number),
                      [wish("step"), wish("step")], lambda c: seen.append(script.number), wish("resume")]  # fmt: skip
    made = Run(tmp_path, book, script, EVENTS)
    assert seen == [1, 2, 4] and made.plain == untouched.plain
    assert len(made.happened("step")) == 4


def test_time_that_was_paused_is_not_caught_up_with_and_speeds_count_from_now():
    now = [100.0]
    pace = FramePacer(1.0, lambda: now[0])
    assert pace.left(500_000) == pytest.approx(0.5)
    now[0] += 0.2
    pace.pause()
    assert pace.stands
    now[0] += 60
    pace.resume(200_000)
    assert not pace.stands and pace.left(500_000) == pytest.approx(0.3)
    pace.speed(0.5, 200_000)
    assert pace.left(500_000) == pytest.approx(0.6)
    pace.speed(0, 200_000)
    assert pace.left(500_000) <= 0
    pace.speed(4, 300_000)
    assert pace.left(500_000) == pytest.approx(0.05)


@pytest.mark.slow
@pytest.mark.parametrize("before", ["running", "paused", "slow", "not begun"])
def test_stop_works_at_once_whatever_it_is_doing(before, tmp_path, book):
    asked = []

    def stop(control):
        asked.append(time.monotonic())
        control.stop("Bo")

    def later(control):
        threading.Timer(0.05, stop, [control]).start()

    frames = {
        "running": {2: stop},
        "paused": {2: [wish("pause"), later]},
        "slow": {2: [wish("speed", factor=0.1), later]},
    }
    script = Script(frames.get(before))
    script.waiting = [()] * 20
    if before == "not begun":
        stop(script.control)
    made = Run(tmp_path, book, script, EVENTS, seconds=20, paced=before == "slow")
    assert script.finished - asked[0] < 0.3 or before == "not begun"  # it is read and checked before
    summary = made.lines[-1]
    assert (summary["ended"], summary["stopped_by"]) == ("stopped", "Bo")
    assert script.number == (0 if before == "not begun" else 2)


def test_a_paused_run_is_not_taken_for_a_stuck_one():
    now = [100.0]
    dog = Watchdog([5, 0, -1], lambda: 0.0, lambda: now[0])

    def fails(seconds, every):
        """True when it is ended within some seconds; every so many looks there is a sign of life."""
        for n in range(round(seconds * 10)):
            now[0] += 0.1
            if dog.failure(heard=bool(every) and n % every == 0, rows={}):
                return True
        return False

    assert not fails(600, every=3)
    assert fails(40, every=0)


def test_a_speed_that_cannot_be_is_refused(tmp_path, book):
    script = Script({1: [wish("speed", factor=1000), wish("speed", factor=-1), wish("speed", factor=0)]})
    made = Run(tmp_path, book, script, EVENTS, seconds=0.2)
    assert [kind for kind, _, _ in script.refusals] == ["speed", "speed"] and "100 times" in script.refusals[0][2]
    assert [line["detail"] for line in made.happened("speed")] == [{"factor": 0.0}]


# ---- values
def test_values_are_sent_as_in_a_test_sheet_and_enter_in_the_next_frame(tmp_path, book):
    texts = {
        "": 0.5,
        "distance=0.25": 0.25,
        "distance=1/4; x = 0.3": 0.25,
        "x=0; y=0, width=1": 0.5,
        "distance = factor()": 2,
    }
    frames = dict(enumerate(texts, 4))
    script = Script({frame: wish("send", "Bo", stream="red ball", text=text) for frame, text in frames.items()})
    world = [((frame + 1) * FRAME / 1000, "redball", example("RedBall", distance=7 + frame)) for frame in frames]
    made = Run(tmp_path, book, script, world, seconds=0.5)
    sent = [line for line in made.lines if line.get("stimulated")]
    assert [(line["stream"], line["by"], line["t"], line["value"]["distance"]) for line in sent] == [
        ("Red ball", "Bo", (frame + 1) * 1_000_000 // 30 / 1e6, texts[text]) for frame, text in frames.items()
    ]
    values = [value for frame, text in frames.items() for value in (2 * (7 + frame), 2 * texts[text])]
    assert script.values("T!Distance") == values  # after what the world had: the newest
    assert [line["value"] for line in made.plain if line.get("stream") == "T!Distance"] == values
    assert [(act.kind, act.by, act.detail["stream"], act.detail["value"]["distance"]) for _, act in script.acts] == [
        ("send", "Bo", "Red ball", distance) for distance in texts.values()
    ]


def test_presses_are_counted_on_and_dones_know_their_command(tmp_path, book):
    script = Script({2: wish("send", stream="Start button", text=""), 4: wish("send", stream="Start button", text="label=\"Start\""),
                     6: wish("send", stream="Wait done", text="completed=FALSE")})  # fmt: skip
    made = Run(tmp_path, book, script, seconds=0.25)
    assert script.values("T!Presses") == [1, 2]
    [done] = [line["value"] for line in made.lines if line.get("stimulated") and line["stream"] == "Wait done"]
    assert done["completed"] is False and done["value"] == 2 and done["seconds"] == pytest.approx(0.066666, abs=0.04)


REFUSED = {
    "a wrong stream": ("Red bal", "", "No row of this run reads a sensor stream “Red bal”", "Did you mean Red ball?"),
    "no sensor": ("Distance", "1", "“Distance” is not a sensor stream", "Red ball"),
    "a wrong field": ("Red ball", "distanc=1", "has no field “distanc”", "Did you mean distance?"),
    "no formula": ("Red ball", "distance=", "cannot be sent", ""),
    "no fields": ("Red ball", "5", "is a single value", "Write its fields"),
    "a text for a number": ("Head yaw", "Hello", "“Hello” is not a number", "in quotes"),
    "no result": ("Head yaw", "1/0", "divides by zero", "send it again"),
    "fields of a number": ("Head yaw", "x = 1; x = 2", "", ""),
}


def test_what_cannot_be_sent_is_refused_with_a_remedy(tmp_path, book, untouched):
    script = Script({1: [wish("send", stream=stream, text=text) for stream, text, _, _ in REFUSED.values()]})
    made = Run(tmp_path, book, script, EVENTS)
    for (kind, message, told), (case, (_, _, words, remedy)) in zip(script.refusals, REFUSED.items(), strict=True):
        assert kind == "send" and words in message and remedy in told, case
    assert made.plain == untouched.plain and not script.acts


# ---- behaviours, buttons, the scene
def test_a_behaviour_is_switched_by_hand_and_forgets(tmp_path, book):
    script = Script({10: wish("switch", "Bo", behaviour="Other", on=False), 11: wish("switch", behaviour="other", on=False),
                     20: wish("switch", behaviour="Other", on=True), 21: wish("switch", behaviour="Othr", on=True)})  # fmt: skip
    made = Run(tmp_path, book, script, EVENTS)
    counts = [(us, value) for us, name, _, value in script.events if script.start.streams[name] == "Other!Count"]
    assert [value for _, value in counts] == [1, 2, 3, 4, 1, 2, 3]
    assert not any(10 * FRAME < us < 20 * FRAME for us, _ in counts)
    said = [(line["t"], line["value"]) for line in made.lines if line.get("stream") == "Say"]
    assert (0.333333, None) in said  # what it had its actuators do is stopped
    assert [(line["detail"], line["by"]) for line in made.happened("switch")] == [
        ({"behaviour": "Other", "on": False}, "Bo"), ({"behaviour": "Other", "on": True}, "Anna"),
    ]  # fmt: skip
    assert script.refusals == [("switch", "There is no behaviour “Othr”.", "Did you mean Other?")]


def test_a_behaviour_that_the_protocol_does_not_run_waits_to_be_switched_on(tmp_path):
    book = BOOK + "\n## Protocol\n| Field | Value |\n|---|---|\n| Run | T |\n"
    script = Script({20: wish("switch", behaviour="Other", on=True)})
    Run(tmp_path, book, script, EVENTS, everything=True)
    assert script.start.behaviours == (("T", True), ("Other", False))
    counts = [us for us, name, _, _ in script.events if script.start.streams[name] == "Other!Count"]
    assert counts and min(counts) > 20 * FRAME and not script.refusals


def test_buttons_things_and_the_words_of_a_scene(tmp_path, book):
    script = Script({
        1: [wish("press", "Bo", label="start"), wish("press", label="Stop")],
        2: [wish("scene", thing="Red ball", verb="move", value="to 0.5, 0.1, 0.4 in 0.1 s"),
            wish("scene", thing="Blue ball", verb="moves", value="to 0.5, 0.1, 0.4"),
            wish("scene", thing="Red ball", verb="jumps", value=""),
            wish("scene", thing="Red ball", verb="moves", value="there"),
            wish("scene", thing="Operator", verb="presses", value="Start")],
        3: [wish("put", thing="red ball", at=[0.1, 0.2, 0.3]), wish("put", thing="red ball", at=[0.4, 0.2, 0.3]),
            wish("put", thing="Ball", at=[0, 0, 0]), wish("put", thing="Red ball", at=[0, 0, float("nan")])],
    })  # fmt: skip
    made = Run(tmp_path, book, script, seconds=0.3)
    acted = made.worlds[0].acted
    assert [(a.thing, a.verb, a.time_us) for a in acted] == [
        ("Bo", "press", FRAME), ("Red ball", "move", 66_666), ("Anna", "press", 66_666), ("red ball", "move", 100_000)
    ]  # fmt: skip
    assert acted[1].values == {"to": (0.5, 0.1, 0.4), "seconds": 0.1} and acted[3].values["to"] == (0.4, 0.2, 0.3)
    assert [kind for kind, _, _ in script.refusals] == ["press", "scene", "scene", "scene", "put", "put"]
    messages = [f"{message} {remedy}" for _, message, remedy in script.refusals]
    for message, words in zip(
        messages, ["Start", "not in the scene", "appears, moves", "to 0.5", "Red ball", "20 m"], strict=True
    ):
        assert words in message
    assert [line["happening"] for line in made.lines if "wall" in line] == ["press", "scene", "press", "scene"]


def test_a_thing_that_is_away_comes_back_as_it_was_where_it_is_put(tmp_path):
    scene = """
    ## Scene
    | Time (s) | Thing | Does | Value |
    |---|---|---|---|
    | 0 | Blue ball | appears | at 1, 0.2, 0.4 size 10 cm |
    | 0 | Child | enters | at 1, 0, 0.7 id 3 name Emma |
    """
    script = Script({1: [wish("put", thing="blue ball", at=[0.4, 0.1, 0.3]), wish("put", thing="Child", at=[2, 1, 0.5]),
                         wish("put", thing="Green ball", at=[1, 0, 0])]})  # fmt: skip
    made = Run(tmp_path, BOOK + textwrap.dedent(scene), script, seconds=0.1)
    acted = [(a.verb, dict(a.values)) for a in made.worlds[0].acted]
    assert acted == [
        ("appear", {"at": (1.0, 0.2, 0.4), "size": 0.1, "colour": "blue"}),
        ("move", {"to": (0.4, 0.1, 0.3), "seconds": 0.0}),
        ("appear", {"at": (1.0, 0.0, 0.7), "id": 3, "name": "Emma"}),
        ("move", {"to": (2.0, 1.0, 0.5), "seconds": 0.0}),
    ]
    assert [n["text"] for n in made.happened("scene")] == [
        "Blue ball appears at 0.40, 0.10, 0.30 m.", "Child appears at 2.00, 1.00, 0.50 m.",
    ]  # fmt: skip
    assert [(kind, message) for kind, message, _ in script.refusals] == [
        ("put", "“Green ball” is not in the scene now.")
    ]


def test_a_touch_that_is_held_is_told_when_it_begins_and_when_it_ends(tmp_path, book):
    script = Script({1: wish("touch", zone="left hand", step="begin"), 10: wish("touch", zone="Left hand", step="on"),
                     20: wish("touch", zone="Left hand", step="end"), 21: wish("touch", zone="Left hand", step="end"),
                     22: wish("touch", zone="Head", step="once"), 23: wish("touch", "Bo", zone="Chest", step="on"),
                     24: wish("touch", zone="Nose", step="once")})  # fmt: skip
    made = Run(tmp_path, book, script, seconds=3)
    assert [(round(line["t"], 2), line["text"], line["by"]) for line in made.happened("scene")] == [
        (0.03, "Touch begins: Left hand", "Anna"), (0.67, "Touch ends: Left hand, after 0.6 s", "Anna"),
        (0.73, "Touch: Head", "Anna"), (0.77, "Touch begins: Chest", "Bo"),
        (1.77, "Touch ends: Chest, after 1.0 s", "Bo"),  # whoever held it has gone
    ]  # fmt: skip
    assert [(a.thing, *a.values.values()) for a in made.worlds[0].acted if a.verb == "touch"] == [
        ("Anna", "Left hand", 1.0), ("Anna", "Left hand", 1.0), ("Anna", "Left hand", 0.0), ("Anna", "Head"), ("Bo", "Chest", 1.0),
    ]  # fmt: skip
    assert [message for _, message, _ in script.refusals] == ["The robot feels nothing at “Nose”."]


def test_a_panel_is_told_all_it_needs_when_the_run_begins():
    plan = make_plan(check(BOOK))
    scene = (SceneAction(0, "Red ball", "appear", {"at": (1.0, 0.0), "size": 0.06, "colour": "red"}),
             SceneAction(2_000_000, "Emma", "appear", {"at": (1.0, 0.0, 0.6)}), SceneAction(0, "Operator", "press", {"label": "x"}))  # fmt: skip
    start = start_of(plan, scene, 1, plan.checked.robot.folder)
    assert start.behaviours == (("T", True), ("Other", True)) and start.buttons == (("Start button", "Start"),)
    assert start.things == (("Red ball", "Red ball", "ball", (1.0, 0.0, 0.0)), ("Emma", "Emma", "person", None))
    checked = replace(plan.checked, workbook=replace(plan.checked.workbook, language="ja"))
    own = start_of(replace(plan, checked=checked), scene, 1, plan.checked.robot.folder)
    assert [title for _, title, _, _ in own.things] == ["赤いボール", "Emma"]
    assert 0.9 < start.hfov < 1.1 and start.resources["headtracker"] == ("head",)
    sensors = {name: (device, text) for name, device, text in start.sensors}
    assert set(sensors) == {"Head yaw", "Red ball", "Start button", "Wait done"}
    assert sensors["Start button"] == ("OperatorButton", 'label="Start"; count=1') and sensors["Head yaw"][1] == "0.1"


def test_every_example_of_a_panel_can_be_sent_as_it_stands(tmp_path, book):
    script = Script()
    script.frames[1] = [
        lambda control: [control.ask(wish("send", stream=n, text=t)) for n, _, t in script.start.sensors]
    ]
    made = Run(tmp_path, book, script, seconds=0.2)
    assert not script.refusals and len([line for line in made.lines if line.get("stimulated")]) == len(
        script.start.sensors
    )


# ---- what is left of it
def test_the_table_and_the_marbles_of_a_run_tell_what_people_did(tmp_path, book):
    script = Script({3: wish("mark", note="he laughs"), 4: wish("send", "Bo", stream="Head yaw", text="5"),
                     5: [wish("put", thing="Red ball", at=[n / 10, 0, 0.4]) for n in range(3)]})  # fmt: skip
    made = Run(tmp_path, book, script, EVENTS)
    table = tidy_table([made.result.folder / "trace.jsonl"])
    header, lines = table.header, table.rows
    table = [dict(zip(header, line, strict=True)) for line in lines]
    assert [(line["kind"], line["message"], line["by"]) for line in table if line["by"]] == [
        ("mark", "he laughs", "Anna"), ("sent by hand", None, "Bo"), ("scene", "Red ball is placed at 0.20, 0.00, 0.40 m.", "Anna")
    ]  # fmt: skip
    assert "run.xlsx" in made.result.files and not made.result.problems
    [score, _] = trace_scores(made.result.folder)
    by_hand = score.groups[0].lane
    assert by_hand.label == "By hand"
    assert [m.value for m in by_hand.marbles] == [
        "he laughs", "sent: Head yaw", "Red ball is placed at 0.20, 0.00, 0.40 m."
    ]  # fmt: skip


def test_a_run_that_nobody_touched_has_no_column_for_people(untouched):
    assert "by" not in tidy_table([untouched.result.folder / "trace.jsonl"]).header
    assert not any("wall" in line or "stimulated" in line for line in untouched.lines)


ACTS = st.one_of(
    st.just(wish("pause")), st.just(wish("resume")), st.just(wish("step")),
    st.builds(lambda f: wish("speed", factor=f), st.sampled_from([0, 0.1, 1, 50, 1e9, -1])),
    st.builds(lambda n: wish("mark", note=n), st.text(max_size=20)),
    st.builds(lambda b, on: wish("switch", behaviour=b, on=on), st.sampled_from(["T", "Other", "x"]), st.booleans()),
    st.builds(lambda s, t: wish("send", stream=s, text=t), st.sampled_from(["Head yaw", "Red ball", "Wait done", "Say", ""]),
              st.sampled_from(["", "1", "x=1", "distance=0", "1/0", "(", "\"a\"", "blank", "completed=TRUE", "=" * 9])),
    st.builds(lambda label: wish("press", label=label), st.sampled_from(["Start", "", "x"])),
    st.builds(lambda *words: wish("scene", **dict(zip(("thing", "verb", "value"), words, strict=True))),
              st.sampled_from(["Red ball", "Emma", ""]), st.sampled_from(["moves", "enters", "says", ""]),
              st.sampled_from(["to 1, 0, 0", "at 1, 0", "hello", ""])),
    st.builds(lambda *at: wish("put", thing="Red ball", at=at), *[st.floats(-30, 30)] * 3),
    st.builds(lambda k, w: wish(k, wanted=w), st.sampled_from(["look", "show"]), st.booleans()),
)  # fmt: skip


@given(st.lists(st.tuples(st.integers(0, 12), ACTS), max_size=12))
@also([(1, wish("mark", note="two\x85\u2028lines"))])
@settings(
    max_examples=example_count(12),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_whatever_people_do_a_run_goes_to_its_end_and_can_be_read(tmp_path_factory, book, acts):
    frames: dict[int, list] = {}
    for number, act in acts:
        frames.setdefault(number, []).append(act)
    folder = tmp_path_factory.mktemp("acts")
    made = Run(folder, book, Script(frames), EVENTS[:4], seconds=0.4)
    assert (
        made.result.broken is None and made.lines[-1]["ended"] == "time" and made.lines[-1]["simulated_seconds"] == 0.4
    )
    assert [event.entry() for event in TraceReader(made.result.folder)] == made.lines[1:-1]
    assert not made.result.problems and [line["t"] for line in made.lines[1:-1]] == sorted(
        line["t"] for line in made.lines[1:-1]
    )


# ---- the display
def test_a_display_is_shown_the_world_by_the_wall_clock_and_again_after_a_change():
    now = [0.0]
    showing = SnapshotThrottle(lambda: now[0])
    assert showing.due() is None
    showing.want(True, None)
    due = []
    for n in range(1_000):  # a fast run: 1,000 frames a second
        now[0] = n / 1_000
        due.append(showing.due())
    assert 11 <= len([d for d in due if d is not None]) <= 14 and True not in due
    showing.want(None, True)
    due = []
    for n in range(30):  # 30 frames a second
        now[0] = 1 + n / 30
        due.append(showing.due())
    assert 9 <= len([d for d in due if d is not None]) <= 13 and 6 <= due.count(True) <= 9
    showing.cost(0.05)  # a slow machine: a display gets its share, and not more
    assert showing.due() is None
    showing.again()
    assert showing.due() is True


def test_while_it_is_paused_the_display_sees_what_is_moved(tmp_path, book):
    script = Script({0: [wish("show", wanted=True), wish("look", wanted=True)], 3: wish("pause")})
    counted = []

    def count(control):
        counted.append((len(script.states), len(script.pictures)))

    script.waiting = [count, count, wish("put", thing="Red ball", at=[1, 0, 0]), count]
    Run(tmp_path, book, script, EVENTS, seconds=0.3)
    assert counted[0] == counted[1] and min(counted[0]) >= 1
    assert counted[2] == (counted[1][0] + 1, counted[1][1] + 1)


def test_a_panel_is_told_when_a_row_switches_a_behaviour(tmp_path):
    book = rows(
        "| Head yaw | filter | headYaw = 2 | Two |\n| Two | subscribe | | Other off |\n",
        "## Other\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n| Head yaw | subscribe | | Print |\n",
        "## Devices\n| Stream | Device | Name | State |\n|---|---|---|---|\n| Other off | Behaviour | Other | Off |\n",
    )
    script = Script({12: wish("switch", behaviour="Other", on=True)})
    made = Run(tmp_path, book, script, EVENTS)
    assert [(us, act.by, act.detail["on"]) for us, act in script.acts] == [
        (200_000, "", False),
        (400_000, "Anna", True),
    ]
    assert len(made.happened("switch")) == 1 and len(made.happened("note")) == 1
