"""Arbitration of joints and resources: invariants over random commands, without a simulator."""

from __future__ import annotations

from dataclasses import dataclass, field

from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.sim.arbitration import Arbiter, Job

STREAMS = {  # what each uses, the joints it moves, how long it takes (None: endless)
    "say": ({"voice"}, (), 5), "other": ({"voice"}, (), 3), "yaw": ({"head"}, ("HeadYaw",), 4),
    "pitch": ({"head"}, ("HeadPitch",), 2), "track": ({"head"}, (), None), "body": ({"head", "legs"}, (), None),
    "arm": ({"left arm"}, (), None), "posture": ({"head", "left arm", "legs"}, (), 6), "eyes": (set(), (), 0),
}  # fmt: skip
STEPS = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(sorted(STREAMS)), st.integers(0, 2)),
        st.tuples(st.sampled_from(sorted(STREAMS)), st.none()),  # blank
        st.just(("", 0)),  # time passes
    ),
    max_size=60,
)


@dataclass
class Table:
    """An arbiter with jobs that know when they run; counts every command and every end."""

    now: int = 0
    number: int = 0
    going: dict[str, Job] = field(default_factory=dict)
    commanded: list[int] = field(default_factory=list)
    updates: dict[int, int] = field(default_factory=dict)  # of endless commands: by what the command was first
    told: list[Notice] = field(default_factory=list)
    ended: list[tuple[int, bool, float]] = field(default_factory=list)

    def __post_init__(self):
        self.arbiter = Arbiter({s: f"{s}done" for s in STREAMS}, self.told.append)

    def take(self, stream: str, priority: int) -> None:
        self.number += 1
        uses, joints, lasts = STREAMS[stream]
        order = Command(stream, self.number, f"T!{self.number}", (), float(priority))
        until = [0]

        def begin(order: Command, us: int) -> None:
            until[0] = until[0] or us + (lasts or 0)
            assert self.going.get(stream) in (None, job)
            self.going[stream] = job

        def cease(us: int) -> None:
            del self.going[stream]

        def over(us: int) -> bool | None:
            if lasts is None or us < until[0]:
                return None
            self.going.pop(stream, None)
            return True

        job = Job(order, frozenset(uses), begin, cease, over, frozenset(joints), lasts is None, "refused")
        if lasts == 0:
            self.arbiter.at_once(order)
        else:
            self.arbiter.take(job, self.now)
        self.commanded.append(self.number)

    def collect(self) -> None:
        for stream, done in self.arbiter.ended():
            assert stream.endswith("done")
            self.ended.append((done["value"], done["completed"], done["seconds"]))


def play(steps) -> Table:
    table = Table()
    for stream, priority in steps:
        if not stream:
            table.now += 1
            table.arbiter.go_on(table.now)
        elif priority is None:
            table.arbiter.stop(stream, table.now)
            assert stream not in table.going
        else:
            table.take(stream, priority)
        jobs = list(table.going.values())
        for i, one in enumerate(jobs):
            assert not any(one.meets(other) for other in jobs[i + 1 :])
        table.collect()
    return table


@settings(max_examples=200, deadline=None)
@given(steps=STEPS)
def test_every_command_ends_exactly_once_and_no_two_move_the_same(steps):
    table = play(steps)
    table.arbiter.stop(None, table.now)
    table.collect()
    assert table.going == {}
    ended = [value for value, _, _ in table.ended]
    assert len(ended) == len(set(ended))  # never twice
    endless = {
        n for n, (s, p) in enumerate((x for x in steps if x[0] and x[1] is not None), start=1) if STREAMS[s][2] is None
    }
    assert set(table.commanded) - endless <= set(ended) <= set(table.commanded)  # a repeated endless one is one command
    assert all(seconds >= 0 for _, _, seconds in table.ended)


@settings(max_examples=100, deadline=None)
@given(steps=STEPS)
def test_what_is_left_alone_comes_to_its_end(steps):
    table = play(steps)
    for _ in range(200):
        table.now += 1
        table.arbiter.go_on(table.now)
    assert all(job.endless for job in table.going.values())  # nothing hangs, nothing waits for ever
    table.collect()
    finite = [
        n
        for n, (s, p) in enumerate((x for x in steps if x[0] and x[1] is not None), start=1)
        if STREAMS[s][2] is not None
    ]
    assert set(finite) <= {value for value, _, _ in table.ended}


def test_an_outranked_one_resumes_when_the_last_that_is_in_its_way_ends():
    table = Table()
    table.take("body", 0)
    table.take("yaw", 1)
    table.take("pitch", 2)  # another joint of the head: both go on
    assert set(table.going) == {"yaw", "pitch"}
    for now, going in ((2, {"yaw"}), (4, {"body"})):
        table.now = now
        table.arbiter.go_on(now)
        assert set(table.going) == going


def test_of_two_outranked_ones_of_equal_priority_the_newer_stays():
    table = Table()
    table.take("posture", 5)
    table.take("track", 0)
    table.take("body", 0)
    table.collect()
    assert [(value, completed) for value, completed, _ in table.ended] == [(2, False)]
    table.now = 6
    table.arbiter.go_on(6)
    assert set(table.going) == {"body"}
    assert [h.row for h in table.told] == ["T!2", "T!3"]


def test_what_a_replaced_one_used_besides_is_free_again():
    table = Table()
    table.take("arm", 0)
    table.take("posture", 1)
    assert set(table.going) == {"posture"}
    table.take("yaw", 1)  # equal priority: it replaces the posture, which held the arm too
    assert set(table.going) == {"yaw", "arm"}
