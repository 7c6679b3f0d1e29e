"""Actions on a run in an event loop, and on one in another process with the simulated robot."""

from __future__ import annotations

import json
import os
import shutil
import signal
import threading
import time
from collections import Counter
from contextlib import nullcontext
from pathlib import Path

import pytest
from acting import wish
from busy import Span, within
from hypothesis import given, settings
from hypothesis import strategies as st
from play import check, rows

from rrp_sheets import api
from rrp_sheets.engine.engine import EventEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.realtime import RealtimeAdapter
from rrp_sheets.engine.run_events import CommandQueue, RunObserver
from rrp_sheets.engine.runners import RealtimeRunner
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Arrivals, WorldSnapshot, WorldState
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunSettings
from rrp_sheets.runs.run_process import RunProcess

BOOK = rows(
    """
    | Head yaw | accumulate | total + 1 | Sum |
    | Sum | sample | 100 ms | Ticks |
    | Ticks | subscribe | | Print |
    | Head pitch | subscribe | | Say |
    """
)


class Lockstep:
    """A world that counts its steps, and what people do to it."""

    def __init__(self):
        self.steps, self.got, self.acted, self.dies = [], [], [], False

    def start(self):
        return Arrivals([("headyaw", 0)])

    def advance(self, now_us, commands):
        self.steps.append(now_us)
        self.got += [(c.stream, c.value) for c in commands]
        return Arrivals([("headyaw", len(self.steps))])

    def act(self, actions):
        if self.dies:
            raise RunBroken("The simulator ended unexpectedly.", "")
        self.acted += actions

    def show(self, picture):
        return WorldSnapshot(WorldState({}, (), (), "", {"Red ball": (float(len(self.acted)), 0, 0)}))

    def stop(self):
        pass


class Live(RunObserver):
    """An event loop on a thread of its own."""

    def __init__(self, book=BOOK):
        self.world, self.control = Lockstep(), CommandQueue()
        self.acts, self.refusals, self.places, self.ended, self.changed = [], [], [], [], threading.Condition()
        self.frames = 0
        plan = make_plan(check(book))
        self.events = []
        self.course = RealtimeRunner(
            plan, RealtimeAdapter(self.world, 30), lambda: EventEngine(plan, self), self.control
        )
        self.thread = threading.Thread(target=self._go, daemon=True)
        self.thread.start()

    def _go(self):
        try:
            self.ended.append(self.course.go(600_000_000, self))
        except RunBroken as error:
            self.ended.append(error)

    def _note(self, place, what):
        with self.changed:
            place.append(what)
            self.changed.notify_all()

    def event(self, us, stream, row, value):
        self._note(self.events, (us, stream, value))

    def error(self, *what):
        raise AssertionError(what)

    def acted(self, us, act):
        self._note(self.acts, (us, act.kind))

    def refused(self, kind, message, remedy):
        self._note(self.refusals, (kind, message))

    def state(self, us, state):
        self._note(self.places, state.things["Red ball"][0])

    def frame(self, us):
        with self.changed:
            self.frames += 1
            self.changed.notify_all()

    def until(self, what, within=300.0):
        """Wait until something is so; the world's steps come without a notice, so it is looked at again and again."""
        last = time.monotonic() + within
        with self.changed:
            while not what():
                assert time.monotonic() < last
                self.changed.wait(0.05)

    def do(self, kind, **what):
        """Ask, and wait until it is done or refused."""
        before = len(self.acts) + len(self.refusals)
        self.control.ask(wish(kind, **what))
        self.until(lambda: len(self.acts) + len(self.refusals) > before)


@pytest.fixture
def live():
    made = Live()
    made.until(lambda: len(made.world.steps) > 5)
    yield made
    made.control.stop()
    made.thread.join(300)
    assert not made.thread.is_alive()
    with pytest.raises(RunBroken) if made.world.dies else nullcontext():
        made.course.stop()


def test_an_event_loop_stands_still_and_goes_on_from_there(live):
    live.do("pause")
    at = live.acts[-1][0]
    with live.changed:
        live.changed.wait(0.1)  # a step that had begun
        steps, ticks = len(live.world.steps), len(live.events)
        live.changed.wait_for(lambda: len(live.events) > ticks, 0.4)  # longer than any timer's period
        assert (len(live.world.steps), len(live.events)) == (steps, ticks)
    live.do("step")
    live.until(lambda: len(live.world.steps) > steps)
    with live.changed:
        live.changed.wait(0.15)
    assert steps < len(live.world.steps) <= steps + 2
    live.do("resume")
    ticks = len([e for e in live.events if e[1] == "t!ticks"])
    live.until(lambda: len([e for e in live.events if e[1] == "t!ticks"]) > ticks + 2)
    assert at <= live.acts[-1][0] < at + 100_000  # the clock went on for one tick only
    times = [us for us, stream, _ in live.events if stream == "t!ticks"]
    assert {us % 100_000 for us in times} == {0} and times == sorted(set(times))
    assert len(live.world.steps) <= times[-1] * 30 // 1_000_000 + 2  # nothing was caught up with


def test_values_switches_and_speeds_in_an_event_loop(live):
    live.do("send", stream="Head pitch", text="0.25")
    live.until(lambda: (live.events[-1][1:] == ("say", 0.25)) or ("say", 0.25) in [e[1:] for e in live.events])
    live.do("switch", behaviour="T", on=False)
    live.until(lambda: ("say", None) in live.world.got)
    live.do("speed", factor=2)
    live.do("send", stream="Say", text="1")
    assert [kind for kind, _ in live.refusals] == ["speed", "send"] and "event loop" in live.refusals[0][1]


def test_while_an_event_loop_stands_still_things_can_be_moved_and_seen(live):
    live.control.ask(wish("show", wanted=True))
    live.until(lambda: live.places)
    live.do("pause")
    live.do("put", thing="Red ball", at=[1, 0, 0])
    live.until(lambda: live.places[-1] == 1.0)
    live.do("put", thing="Blue ball", at=[1, 0, 0])
    assert live.refusals and len(live.world.acted) == 1
    with within(0.3):
        live.control.stop("Bo")
        live.thread.join(300)
    assert live.ended[0][1] == "stopped"


def test_a_world_that_breaks_while_it_stands_still_ends_the_run(live):
    live.do("pause")
    live.world.dies = True
    live.do("scene", thing="Red ball", verb="appears", value="at 1, 0, 0")
    live.thread.join(300)
    assert "ended unexpectedly" in live.ended[0].message


# ---- in a process of its own, with the robot
class Panel(RunObserver):
    """A panel: everything with the wall's time."""

    def __init__(self):
        self.changed = threading.Condition()
        self.told = []
        self.values = Counter()  # how many came, by stream

    def event(self, us, stream, row, value):
        self.values[stream] += 1

    def _note(self, kind, *what):
        with self.changed:
            self.told.append((kind, time.monotonic(), *what))
            self.changed.notify_all()

    def started(self, start):
        self.start = start
        self._note("started")

    def frame(self, us):
        self._note("frame", us)

    def acted(self, us, act):
        self._note("acted", us, act)

    def refused(self, kind, message, remedy):
        self._note("refused", kind, message)

    def paused(self, us, is_paused):
        self._note("paused", us, is_paused)

    def kept_alive(self, us):
        self._note("kept_alive", us)

    def state(self, us, state):
        self._note("state", us, state)

    def picture(self, us, jpeg):
        self._note("picture", us, jpeg)

    def finishing(self):
        self._note("finishing")

    def of(self, kind):
        return [entry for entry in self.told if entry[0] == kind]

    def until(self, what, within=300.0):
        with self.changed:
            assert self.changed.wait_for(what, within), self.told[-5:]


def begin(book, **settings):
    pytest.importorskip("pybullet")
    panel = Panel()
    run = RunProcess(book, RunSettings(**{"film": False, "seconds": 600, **settings}))
    ended = []
    thread = threading.Thread(target=lambda: ended.append(run.listen(panel)), daemon=True)
    thread.start()
    return run, panel, thread, ended


@pytest.mark.slow
def test_a_panel_in_another_process_does_it_all(tmp_path):
    run, panel, thread, ended = begin(bundled("workbooks", "simple-tracking.xlsx"), out=tmp_path / "o")
    run.command("look", wanted=True)
    panel.until(lambda: len(panel.of("picture")) >= 3 and len(panel.of("state")) >= 5)
    assert panel.of("picture")[-1][3][:3] == b"\xff\xd8\xff" and panel.start.sensors[0][0] == "Red ball"
    state = panel.of("state")[-1][3]
    assert len(state.joints) == 26 and len(state.base) == 6
    panel.until(lambda: any(entry[3].driving.get("head") == "Tracking!4" for entry in panel.of("state")))
    run.command("pause", "Anna")
    panel.until(lambda: panel.of("paused"))
    frames = len(panel.of("frame"))
    run.command("put", "Bo", thing="Red ball", at=(0.8, 0.3, 0.4))
    panel.until(lambda: panel.of("state")[-1][3].things["Red ball"] == (0.8, 0.3, 0.4))
    run.command("send", "Bo", stream="Red ball", text="distance=0.3")
    run.command("send", "Bo", stream="Red ball", text="distanc=0.3")
    run.command("mark", "Anna", note="she smiles")
    panel.until(lambda: len(panel.of("acted")) == 4 and len(panel.of("kept_alive")) >= 2)
    assert len(panel.of("frame")) == frames and panel.of("refused")[0][3].endswith("“distanc”.")
    edited = shutil.copy(bundled("workbooks", "simple-tracking.xlsx"), tmp_path / "b.xlsx")
    api.set_cell(Path(edited), "C3", "distance >= 0.9", sheet="Tracking")
    run.command("apply", "Bo", path=str(Path(edited).absolute()))
    panel.until(lambda: len(panel.of("acted")) == 5)
    assert panel.of("acted")[-1][3].text.endswith("on: Tracking!3.")
    run.command("speed", factor=4)
    run.command("resume", "Anna")
    us = panel.of("frame")[-1][2]
    panel.until(lambda: panel.of("frame")[-1][2] > us + 1_000_000)
    span = Span()
    run.stop("Bo")
    panel.until(lambda: panel.of("finishing"))
    assert panel.of("finishing")[0][1] - span.began < 0.5 * span.crowded()
    thread.join(300)
    lines = [json.loads(line) for line in (tmp_path / "o" / "trace.jsonl").read_text().splitlines()]
    assert [line["by"] for line in lines if line.get("stimulated")] == ["Bo"]
    assert [line["happening"] for line in lines if "wall" in line] == [
        "pause",
        "scene",
        "mark",
        "edit",
        "speed",
        "resume",
    ]
    assert (lines[-1]["ended"], lines[-1]["stopped_by"]) == ("stopped", "Bo") and ended[0].result.broken is None


@pytest.mark.slow
def test_who_only_looks_changes_nothing(tmp_path):
    traces = []
    for look in (False, True):
        run, panel, thread, _ = begin(
            bundled("workbooks", "greeter.xlsx"), out=tmp_path / str(look), fast=True, seconds=3
        )
        run.command("look", wanted=look)
        thread.join(300)
        assert bool(panel.of("picture")) is look
        traces.append((tmp_path / str(look) / "trace.jsonl").read_text().split("\n", 1)[1])
    assert traces[0] == traces[1]


@pytest.mark.slow
def test_stop_is_heard_while_events_flood_the_wire(tmp_path):
    book = tmp_path / "b.md"
    body = "| Again done | subscribe | | Again |\n| Red ball | subscribe | | Again |\n| Red ball | subscribe | | Head tracker |"
    many = "\n".join(
        f'| Again done | map | "{"x" * 60}" & {n} | M{n} |\n| M{n} | subscribe | | Print |' for n in range(15)
    )
    book.write_text(rows(body + "\n" + many, "## Devices\n| Stream | Device | Time |\n|---|---|---|\n| Again | Wait | 1 ms |\n",
                         "## Protocol\n| Field | Value |\n|---|---|\n| Engine | event loop |\n"))  # fmt: skip
    run, panel, thread, ended = begin(book, out=tmp_path / "o")
    panel.until(lambda: panel.values["print"] > 300)  # the flood has come
    span = Span()
    run.stop()
    panel.until(lambda: panel.of("finishing"))
    assert panel.of("finishing")[0][1] - span.began < 1.0 * span.crowded()
    thread.join(300)
    assert ended[0].result.summary.ended == "stopped"


def test_a_simulator_that_is_killed_while_a_run_is_paused_is_told(tmp_path):
    run, panel, thread, ended = begin(bundled("workbooks", "simple-tracking.xlsx"), out=tmp_path / "o")
    panel.until(lambda: panel.of("frame"))
    run.command("pause")
    panel.until(lambda: panel.of("paused"))
    os.kill(run.simulator_pid, signal.SIGKILL)
    thread.join(300)
    assert "ended unexpectedly (signal 9)" in ended[0].result.broken.message
    assert not panel.of("finishing"), "no rest is claimed"
    last = json.loads((tmp_path / "o" / "trace.jsonl").read_text().splitlines()[-1])
    assert last["ended"] == "broken" and "ended unexpectedly" in last["why"] and last["remedy"]


def test_a_run_that_is_stopped_before_it_begins_leaves_nothing(tmp_path):
    run, panel, thread, ended = begin(bundled("workbooks", "simple-tracking.xlsx"), out=tmp_path / "o")
    run.command("pause")
    run.stop("Bo")
    thread.join(300)
    assert ended[0].result is None and not panel.of("frame") and not (tmp_path / "o").exists()


LIVELY = st.sampled_from([
    wish("pause"), wish("resume"), wish("step"), wish("speed", factor=0), wish("mark", note="x"),
    wish("switch", behaviour="T", on=False), wish("switch", behaviour="T", on=True), wish("press", label="x"),
    wish("send", stream="Head yaw", text="1"), wish("send", stream="Head pitch", text=""), wish("send", stream="x", text="("),
    wish("put", thing="Red ball", at=[0, 0, 0]), wish("scene", thing="Emma", verb="says", value="yes"),
    wish("show", wanted=True), wish("look", wanted=True),
])  # fmt: skip


@given(st.lists(LIVELY, max_size=10))
@settings(max_examples=12, deadline=None)
def test_whatever_people_do_an_event_loop_stops_when_it_is_told(acts):
    live = Live()
    for act in acts:
        live.control.ask(act)
    live.control.ask(wish("resume"))
    frames = live.frames
    live.until(lambda: live.frames > frames)
    live.control.stop("Bo")
    live.thread.join(300)
    assert not live.thread.is_alive() and live.ended[0][1] == "stopped"
    assert live.course.stop() == []
    assert [us for us, _, _ in live.events] == sorted(us for us, _, _ in live.events)
