"""The event loop: starting in order, stopping in bounded time whatever hangs, values from many threads (4-streams)."""

from __future__ import annotations

import json
import threading
import time

import forked
import pytest
from busy import Span, crowded, within
from play import Played, check, rows
from typed import run

from rrp_sheets.engine import runners
from rrp_sheets.engine.engine import EventEngine
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.realtime import EventQueue, RealtimeAdapter
from rrp_sheets.engine.run_events import RunObserver
from rrp_sheets.engine.runners import ActuatorThread, RealtimeRunner
from rrp_sheets.errors import RunBroken
from rrp_sheets.model.exchange import Arrivals, Command, Notice

BOOK = """
| Head yaw | map | headYaw * 10 | A |
| Head yaw | map | headYaw + 1 | B |
| A, B | combineLatest | a + b | Both |
| Both | subscribe | | Print |
| Head pitch | subscribe | | Say |
"""


class Part:
    """A device that tells the test what happens to it; any of its steps may be replaced."""

    def __init__(self, name, log, **steps):
        self.name, self.log, self.steps = name, log, steps
        self.queue = None

    def _do(self, step, *arguments):
        self.log.append((step, self.name, *arguments))
        if step in self.steps:
            self.steps[step](*arguments)

    def start(self, queue=None):
        self.queue = queue
        self._do("start")

    def stop(self):
        self._do("stop")

    def rest(self):
        self._do("rest")

    def take(self, command):
        self._do("take", command.value)


class World:
    """Devices made by the test."""

    def __init__(self, **parts):
        self.log = []
        self.parts = {name: Part(name, self.log, **steps) for name, steps in parts.items()}
        self.queue = None

    def open(self, queue):
        self.queue = queue
        self.log.append(("open",))

    def sensor(self, use):
        return self.parts.setdefault(use.stream, Part(use.stream, self.log))

    actuator = sensor

    def close(self):
        self.log.append(("close",))


class Until(RunObserver):
    """Lets a loop run until the test says so."""

    def __init__(self):
        self.over = threading.Event()
        self.told = []

    def notice(self, us, notice):
        self.told.append(notice)

    def stopped(self):
        return self.over.is_set()


def runner(world, book=BOOK, observer=None):
    plan = make_plan(check(rows(book)))

    def wire():
        world.log.append(("wired",))
        return EventEngine(plan, observer)

    return RealtimeRunner(plan, world, wire)


def go(made, observer, until_us=600_000_000):
    ended = []
    thread = threading.Thread(target=lambda: ended.append(made.go(until_us, observer)), daemon=True)
    thread.start()
    return thread, ended


def hang(*ignored):
    threading.Event().wait(600)


def test_it_starts_sensors_connectors_actuators_and_stops_in_order():
    world = World()
    made = runner(world)
    assert world.log == [("open",), ("start", "headyaw"), ("start", "headpitch"), ("wired",), ("start", "print"),
                         ("start", "say")]  # fmt: skip
    world.log.clear()
    assert made.stop() == []
    steps = [entry[0] for entry in world.log]
    assert steps == ["stop", "stop", "rest", "rest", "close"]


@pytest.mark.parametrize(("which", "words"), [("headpitch", "sensor stream “Head pitch” (T!"), ("say", "actuator stream “Say” (T!")])  # fmt: skip
def test_a_device_that_does_not_start_is_told_with_its_cell_and_nothing_is_left_running(which, words):
    def fail():
        raise RunBroken("There is no such cable.", "Plug it in.")

    world = World(**{which: {"start": fail}})
    with pytest.raises(RunBroken) as caught:
        runner(world)
    assert words in caught.value.message and "no such cable" in caught.value.message
    assert ("stop", "headyaw") in world.log and world.log[-1] == ("close",)


def test_a_device_that_hangs_at_its_start_is_told(monkeypatch):
    monkeypatch.setattr(runners, "START_WITHIN", 0.2)
    world = World(headyaw={"start": hang})
    with pytest.raises(RunBroken, match="did not start within"):
        runner(world)


def test_values_of_many_threads_are_settled_one_by_one_in_order_of_arrival():
    class Seen(Played):
        pass

    checked = check(rows(BOOK))
    seen = Seen(checked)
    world = World()
    made = runner(world, observer=seen)
    observer = Until()
    thread, _ = go(made, observer)
    world.queue.begun.wait(300)

    def send(first):
        for i in range(200):
            world.queue.event("headyaw", first + i)

    senders = [threading.Thread(target=send, args=(1000 * n,)) for n in range(4)]
    for sender in senders:
        sender.start()
    for sender in senders:
        sender.join()
    deadline = time.monotonic() + 300
    while len(seen["Both"]) < 800 and time.monotonic() < deadline:
        threading.Event().wait(0.01)
    observer.over.set()
    thread.join(300)
    assert not thread.is_alive()
    made.stop()
    sent = seen.values("Head yaw")
    assert len(sent) == 800
    assert seen.values("Both") == [11 * v + 1 for v in sent]  # each diamond once, and of one value only
    for n in range(4):
        assert [v for v in sent if 1000 * n <= v < 1000 * n + 200] == list(range(1000 * n, 1000 * n + 200))
    times = [ms for ms, _ in seen["Head yaw"]]
    assert times == sorted(times)


def test_a_hanging_actuator_stops_neither_the_run_nor_stop(monkeypatch):
    monkeypatch.setattr(runners, "REST_WITHIN", 0.3 * crowded())
    taken = threading.Event()
    world = World(say={"take": hang}, print={"take": lambda value: taken.set()})
    made = runner(world)
    observer = Until()
    thread, ended = go(made, observer)
    world.queue.event("headpitch", 1)  # its actuator never comes back
    world.queue.event("headyaw", 1)
    assert taken.wait(300)
    observer.over.set()
    thread.join(300)
    assert [how for _, how in ended] == ["stopped"]
    with within(3):
        told = made.stop()
    assert [h.text for h in told] == ["Say did not stop in time."]
    assert ("rest", "print") in world.log and world.log[-1] == ("close",)


def test_a_hanging_sensor_does_not_keep_the_actuators_from_their_rest(monkeypatch):
    monkeypatch.setattr(runners, "STOP_WITHIN", 0.2 * crowded())
    world = World(headyaw={"stop": hang})
    made = runner(world)
    assert ["Head yaw" in h.text for h in made.stop()] == [True]
    assert {("rest", "print"), ("rest", "say"), ("close",)} <= set(world.log)


def test_what_waits_for_an_actuator_at_stop_is_dropped():
    inside, leave = threading.Event(), threading.Event()

    def slow(value):
        inside.set()
        leave.wait(300)

    part = Part("print", [], take=slow)
    hand = ActuatorThread("Print", part, EventQueue())
    hand.start()
    for value in range(5):
        hand.give(Command("print", value))
    assert inside.wait(300)
    stopping = threading.Thread(target=hand.rest)
    stopping.start()
    assert hand.resting.wait(300)
    leave.set()
    stopping.join(300)
    assert [entry[0] for entry in part.log] == ["start", "take", "rest"]


def test_a_device_that_breaks_ends_the_run():
    world = World()
    made = runner(world)
    failures = []

    def run():
        try:
            made.go(600_000_000, Until())
        except RunBroken as error:
            failures.append(error.message)

    thread = threading.Thread(target=run)
    thread.start()
    world.queue.broke(RunBroken("The cable is out.", "Plug it in."))
    thread.join(300)
    assert failures == ["The cable is out."]
    made.stop()


def test_a_wait_ends_and_the_run_ends_itself_without_any_event():
    book = "| Head yaw | subscribe | 0.05 | Wait |\n| Wait done | subscribe | | End run |"
    world = World()
    made = runner(world, book)
    observer = Until()
    world.queue.event("headyaw", 1)
    with within(5):
        at, how = made.go(600_000_000, observer)
    assert how == "end run" and made.engine.ended_by == "T!3" and at >= 50_000
    made.stop()


class Lockstep:
    """A world in lockstep that counts its steps."""

    def __init__(self):
        self.steps, self.got, self.stopped = [], [], False

    def start(self):
        return Arrivals([("headyaw", 0)], [Notice("note", "ready")])

    def advance(self, now_us, commands):
        self.steps.append(now_us)
        self.got += [(c.stream, c.value) for c in commands]
        return Arrivals([("headyaw", len(self.steps))])

    def stop(self):
        self.stopped = True


def test_a_world_in_lockstep_goes_with_the_wall_clock():
    world = Lockstep()
    plan = make_plan(check(rows(BOOK)))
    made = RealtimeRunner(plan, RealtimeAdapter(world, 30), lambda: EventEngine(plan))
    observer = Until()
    span = Span()
    assert made.go(500_000, observer) == (500_000, "time")
    assert 0.5 <= span.seconds() < 3 * span.crowded()
    made.stop()
    assert world.stopped and observer.told == [Notice("note", "ready")]
    assert world.steps == [n * 1_000_000 // 30 for n in range(1, len(world.steps) + 1)]
    took = span.seconds()  # it goes on until it is stopped, which may be late on a busy machine
    assert 2 <= len(world.steps) <= took * 30 + 1
    assert world.got[:2] == [("print", 1), ("print", 12)]


def test_a_workbook_that_asks_for_the_event_loop_runs_in_it(tmp_path):
    pytest.importorskip("pybullet")
    book = tmp_path / "b.md"
    book.write_text(rows(
        "| Red ball | map | redBall.distance | D |\n| D | sample | 300 ms | S |\n| S | subscribe | | Print |\n"
        "| Red ball | subscribe | | Head tracker |",
        "## Protocol\n| Field | Value |\n|---|---|\n| Engine | Event loop |\n",
    ))  # fmt: skip
    command = [*forked.COMMAND, "run", str(book), "--for", "1.5s", "--out", str(tmp_path / "o")]
    done = forked.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in (tmp_path / "o" / "trace.jsonl").read_text().splitlines()]
    assert lines[0]["engine"] == "event loop" and lines[-1]["ended"] == "time"
    ticks = [line["t"] for line in lines if line.get("stream") == "T!S"]
    assert ticks == sorted(set(ticks)) and len(ticks) >= 2  # a busy machine may give nothing new for a tick
    assert all(tick == pytest.approx(0.3 * round(tick / 0.3)) for tick in ticks)
    code, said = run("run", book, "--fast", "--out", tmp_path / "p")
    assert code == 2 and "frame" in said and not (tmp_path / "p").exists()
