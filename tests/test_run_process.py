"""Messages between a run's process and its watcher; a slow watcher costs the run nothing."""

from __future__ import annotations

import socket
import threading
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.diagnostics import Report
from rrp_sheets.engine.run_events import (
    FormulaFailure,
    FrameEnd,
    KeepAliveEvent,
    NoticeEvent,
    OperatorEvent,
    PauseEvent,
    PictureEvent,
    RefusalEvent,
    RunEvent,
    RunObserver,
    StateEvent,
    StreamEvent,
)
from rrp_sheets.errors import MissingPart, RunBroken, SheetsError, UnreadableFile
from rrp_sheets.model.exchange import Notice, OperatorAction, WorldState
from rrp_sheets.model.values import Failure, Record, record_from_mapping
from rrp_sheets.resources import bundled
from rrp_sheets.runs import RunSettings
from rrp_sheets.runs.engine_process import RunEventSender
from rrp_sheets.runs.run_data import FinishingEvent, RestedEvent, RunStart, StartEvent, Summary
from rrp_sheets.runs.run_process import RunProcess
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, NonBlockingWriter, encode

BOOK = bundled("workbooks", "simple-tracking.xlsx")

PLAIN = st.one_of(
    st.none(), st.booleans(), st.integers(-(10**15), 10**15), st.floats(-1e15, 1e15), st.text(max_size=20)
)
NAMES = st.text("abcdefgh", min_size=1, max_size=5)
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=4)
    | st.builds(record_from_mapping, st.text(max_size=8), st.dictionaries(NAMES, inner, max_size=4)), max_leaves=12,
)  # fmt: skip


def kinds(value):
    """Types in a value, with the names of its records."""
    if isinstance(value, Record):
        return (value.type.name, {n: kinds(v) for n, v in value.as_dict().items()})
    if isinstance(value, list):
        return [kinds(v) for v in value]
    return (type(value), value)


class Taken(RunObserver):
    """Takes everything down."""

    def __init__(self):
        self.got = []

    def event(self, *what):
        self.got.append(("event", *what))

    def error(self, *what):
        self.got.append(("error", *what))

    def notice(self, *what):
        self.got.append(("notice", *what))

    def frame(self, *what):
        self.got.append(("frame", *what))

    def finishing(self):
        self.got.append(("finishing",))

    def rested(self, summary, broken):
        self.got.append(("rested", summary, broken and (broken.message, broken.remedy)))

    def acted(self, *what):
        self.got.append(("acted", *what))

    def refused(self, *what):
        self.got.append(("refused", *what))

    def paused(self, *what):
        self.got.append(("paused", *what))

    def kept_alive(self, *what):
        self.got.append(("kept_alive", *what))

    def state(self, *what):
        self.got.append(("state", *what))

    def picture(self, *what):
        self.got.append(("picture", *what))

    def started(self, *what):
        self.got.append(("started", *what))


def pair():
    here, there = socket.socketpair()
    return NonBlockingWriter(here), MessageReader(there), there


def take(message, view):
    """Give a view an event that has been sent."""
    view.handle(unpack(RunEvent.kinds[message[0]], message))


def sent(thing):
    """An object as another process receives it."""
    here, there = socket.socketpair()
    here.sendall(encode(["it", pack(thing)]))
    [[_, got]] = MessageReader(there).receive()
    return unpack(type(thing), got)


@given(VALUES)
@settings(max_examples=60, deadline=None)
def test_a_value_arrives_as_what_it_is(value):
    box, lines, _ = pair()
    view = Taken()
    RunEventSender(box).handle(StreamEvent(5, "s", "T!2", value))
    box.finish()
    take(lines.receive()[0], view)
    [(kind, us, stream, row, got)] = view.got
    assert (kind, us, stream, row) == ("event", 5, "s", "T!2") and kinds(got) == kinds(value)


def test_everything_that_a_view_is_told_arrives_in_order():
    box, lines, _ = pair()
    here, there = Taken(), Taken()
    put = {"thing": "Red ball", "put": [1.0, 0.0, 0.4]}
    state = WorldState({"HeadYaw": 0.1}, (0.0, 0.5), (1.0, 0.0, 0.0), "Hi", {"Ball": (1.0, 0.0, 0.4)}, {"head": "T!4"})
    told = [
        StreamEvent(1, "redball", "", record_from_mapping("Red ball", {"x": 1})),
        FormulaFailure(2, "T!3", Failure("FORM101", "This formula divides by zero.", 3), (1, "a")),
        NoticeEvent(3, Notice("say", "Grüß dich", "say", "T!4", "say-001.wav")),
        FrameEnd(4),
        OperatorEvent(5, OperatorAction("scene", "Red ball is put …", "Anna", put)),
        RefusalEvent("send", "No such stream.", "Did you mean …?"),
        PauseEvent(5, True),
        KeepAliveEvent(5),
        StateEvent(6, state),
        PictureEvent(6, bytes(range(256))),
        StartEvent(
            RunStart("Book", 5, Path("run"), rows={2: "T!2"}, things=(("Ball", "ボール", "ball", (1.0, 0.0, 0.4)),))
        ),
        FinishingEvent(),
        RestedEvent(Summary({"Red ball": 3}, simulated=2.5, ended="stopped", stopped_by="Aya"), None),
        RestedEvent(Summary(), RunBroken("The simulator has ended.", "Run it again.")),
    ]
    assert {type(event).__name__ for event in told} == set(RunEvent.kinds), "there is one of each kind"
    for event in told:
        here.handle(event)
        RunEventSender(box).handle(event)
    box.finish()
    for message in lines.receive():
        take(message, there)
    assert there.got == here.got and len(there.got) == len(told)


def test_a_watcher_that_does_not_read_does_not_stop_the_run():
    box, lines, link = pair()
    reporter = RunEventSender(box)
    for us in range(20_000):  # some 10 MB: far more than a socket holds
        reporter.handle(StreamEvent(us, "s", "T!2", "x" * 500))
        reporter.handle(FrameEnd(us))
    waiting = len(box._waiting)
    reporter.handle(PictureEvent(20_000, bytes(20_000)))  # would be old when it is seen
    reporter.handle(OperatorEvent(20_000, OperatorAction("mark", "he laughs")))  # is never left out
    assert 0 < len(box._waiting) - waiting < 200
    reporter.handle(FinishingEvent())  # nor is this
    sending = threading.Thread(target=reporter.finish)
    sending.start()
    got = lines.receive()
    while got[-1][0] != "NoticeEvent":
        got += lines.receive()
    sending.join()
    assert ["FinishingEvent"] in got
    view = Taken()
    take(got[-1], view)
    [(_, us, notice)] = view.got
    shown = int(notice.text.split(" values came faster")[0].replace(",", ""))
    assert us == 19_999 and shown == 40_000 - sum(m[0] in ("StreamEvent", "FrameEnd") for m in got) > 1_000
    link.close()
    box.post(["more"])
    box.finish()
    assert box.gone  # and one that has gone is forgotten
    reporter.handle(StreamEvent(1, "s", "T!2", 1))
    reporter.handle(FrameEnd(1))


def test_findings_settings_and_errors_arrive_as_they_were():
    report = Report()
    report.add("FILE018", None, name="caf\udce9.xlsx", why="it hangs")
    [found] = report
    assert sent(found) == found
    chosen = RunSettings(seconds=2.5, fast=True, out=Path("/tmp/caf\udce9"), seed=7, participant="P1", film=False)
    assert sent(chosen) == chosen
    for error in (
        SheetsError("a", "b"),
        MissingPart("a", "b"),
        RunBroken("a", "b"),
        UnreadableFile("FILE001", "a", "b"),
    ):
        again = sent(error)
        assert (type(again), again.message, again.remedy) == (type(error), "a", "b")
        assert getattr(again, "code", "") == getattr(error, "code", "")


@pytest.mark.slow
def test_a_server_starts_a_run_gets_its_events_and_stops_it(process_start, tmp_path):
    pytest.importorskip("pybullet")

    class Stopper(Taken):
        def started(self, start):
            self.start = start

        def frame(self, us):
            if us > 500_000:
                run.stop()

    run = RunProcess(BOOK, RunSettings(out=tmp_path / "o", film=False))
    view = Stopper()
    ended = run.listen(view)
    assert ended.result is not None and ended.result.broken is None
    assert ended.result.summary.ended == "stopped" and 0.5 <= ended.result.summary.simulated < 15
    assert view.start.actuators["headtracker"] == "Head tracker" and view.start.folder == tmp_path / "o"
    balls = [value for kind, *rest in view.got if kind == "event" and rest[1] == "redball" for value in [rest[3]]]
    assert balls and balls[0].type.name == "Red ball"
    assert len(balls) == ended.result.summary.events["Red ball"]


def test_errors_of_the_workbook_and_unreadable_files_are_the_same_as_here(tmp_path):
    pytest.importorskip("pybullet")
    wrong = tmp_path / "b.md"
    wrong.write_text(
        "## T\n| Input | Connector | Formula | Output |\n|---|---|---|---|\n| Red bal | subscribe | | Say |\n"
    )
    ended = api.run_apart(wrong)
    assert ended.result is None and list(ended.findings) == list(api.check(wrong).report)
    with pytest.raises(UnreadableFile) as caught:
        api.run_apart(tmp_path / "gone.xlsx")
    assert caught.value.code == "FILE001"
