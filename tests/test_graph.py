"""Names, done streams and order of rows; and that no sheet breaks the graph."""

from __future__ import annotations

import pytest
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st
from play import check, findings, play, rows

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.graph import StreamKind
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.workbook import Address, Behaviour, Cell, Device, Row, Workbook
from rrp_sheets.robots import load_robot

DEVICES = """
## Devices
| Stream | Device | Text |
|---|---|---|
| Ask the child | SayParameter | Hello |
"""


@pytest.mark.parametrize(
    "name", ["Ask the child done", "askTheChildDone", "ask_the_child_done", "ASK-THE-CHILD-DONE", "Ask the childDone"]
)
def test_the_done_stream_in_any_spelling(name):
    book = rows(
        f"| {name} | map | value.completed | X |\n| X | subscribe | | Print |\n| X | subscribe | | Ask the child |",
        DEVICES,
    )
    checked = check(book)
    assert not checked.report.errors
    (stream,) = [s for s in checked.graph.streams.values() if s.kind is StreamKind.DONE]
    assert (stream.id, stream.done_of, stream.name) == ("askthechilddone", "askthechild", "Ask the child done")


def test_the_done_stream_of_an_actuator_by_its_name_alone():
    book = rows("| Head tracker done | map | headTrackerDone.seconds | X |\n| X | subscribe | | Print |\n"
                "| Red ball | subscribe | | Head tracker |")  # fmt: skip
    checked = check(book)
    assert not checked.report.errors and checked.graph.streams["headtrackerdone"].done_of == "headtracker"


def test_rows_may_feed_each_other_through_the_world():
    book = rows("| Ask the child done | subscribe | | Ask the child |", DEVICES)
    assert "GRAPH010" not in [code for code, _ in findings(book)]


@pytest.mark.parametrize(
    "order", ["| Say it | Say |\n| Say it done | RedBall |", "| Say it done | RedBall |\n| Say it | Say |"]
)
def test_a_device_cannot_take_the_name_of_a_done_stream(order):
    book = rows("| Red ball | subscribe | | Print |", f"\n## Devices\n| Stream | Device |\n|---|---|\n{order}\n")
    line = 3 if order.startswith("| Say it |") else 2
    assert findings(book) == [("GRAPH016", f"A{line}")]


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("Red ball done", "Only actuators have a done stream; Red ball is a sensor."),
        ("Ask the chid done", "Did you mean Ask the child done?"),
        ("Head traker done", "Did you mean Head tracker done?"),
        ("Say finished", "Did you mean Say done?"),
        ("Head tracker is over", "Did you mean Head tracker done?"),
        ("ask_the_child_ended", "Did you mean Ask the child done?"),
    ],
)
def test_what_has_no_end(name, remedy):
    (found,) = check(rows(f"| {name} | subscribe | | Print |", DEVICES)).report
    assert (found.code, found.remedy) == ("GRAPH001", remedy)


def test_the_end_of_what_an_actuator_says_is_its_done_stream():
    told = "\n## Devices\n| Stream | Device | Text |\n|---|---|---|\n| Farewell | Say parameter | Good bye! |\n"
    (found,) = check(
        rows("| Good bye done | subscribe | | Print |\n| Red ball | subscribe | | Head tracker |", told)
    ).report
    assert (found.code, found.remedy) == ("GRAPH001", "Did you mean Farewell done?")
    twice = told + "| Parting | Say parameter | good bye |\n"
    (found,) = check(rows("| Good bye done | subscribe | | Print |", twice)).report
    assert found.code == "GRAPH001" and "Farewell" not in found.remedy


@pytest.mark.parametrize(
    ("row", "cell", "remedy"),
    [
        ("| Other!X | subscribe | | Print |", "A2", "Behaviours share only devices"),
        ("| T!X, Red ball | merge | | Y |\n| Y | subscribe | | Print |", "A2", "Write X."),
        ("| Red ball | map | redBall.x | Other!Y |", "D2", "Behaviours share only devices"),
    ],
)
def test_a_stream_of_another_sheet_is_for_tests_only(row, cell, remedy):
    other = rows("| Red ball | map | redBall.x | X |\n| X | subscribe | | Print |", sheet="Other")
    found = [d for d in check(rows(row, "\n" + other)).report if d.address.sheet == "T"]
    assert [(d.code, d.address.cell) for d in found] == [("GRAPH017", cell)]
    assert found[0].remedy.startswith(remedy)


def test_an_exclamation_mark_alone_is_no_sheet():
    book = rows("| Red ball | map | redBall.x | Wow! |\n| Wow! | subscribe | | Print |")
    assert findings(book) == []


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("scan", "accumulate"),
        ("distinct", "once"),
        ("debounce", "timeout"),
        ("accumulat", "accumulate"),
        ("dellay", "delay"),
    ],
)
def test_what_others_call_our_connectors(written, meant):
    (found,) = check(rows(f"| Head yaw | {written} | | X |\n| X | subscribe | | Print |")).report
    assert (found.code, found.remedy) == ("CONN002", f"Did you mean {meant}?")


def test_merge_passes_blanks():
    p = play(rows("| Head yaw, Head pitch | merge | | X |\n| X | subscribe | | Print |"),
             [(0, "Head yaw", None), (100, "Head pitch", 1), (200, "Head pitch", None)])  # fmt: skip
    assert p["X"] == [(0, None), (100, 1), (200, None)]


# ---- no sheet breaks the graph


NAMES = st.one_of(
    st.sampled_from([
        "", "A", "B", "a", "Red ball", "Say", "Say done", "say_done_done", "done", "Head yaw", "Wait", "Wait done", "Timer",
        "T!A", "T!", "!", "U!B", "Say parameter", "A done", "Ask", "Ask done", "#", "Touch", "End run", "赤い", "A, B",
    ]),
    st.text(max_size=6),
)  # fmt: skip
CONNECTORS = st.one_of(st.sampled_from([c.name for c in connectors()] + ["", "scan", "mapp"]), st.text(max_size=5))
FORMULAS = st.sampled_from(["", "value", "1 s", "0", "a + 1", "500 ms", "total + 1", "§$%", "9e99 s"])
ROWS = st.lists(
    st.tuples(st.lists(NAMES, max_size=3), CONNECTORS, FORMULAS, NAMES, st.booleans()), max_size=8,
)  # fmt: skip
DEVICE_NAMES = st.one_of(st.sampled_from([f.name for f in load_robot().names.values()] + [""]), NAMES)
SETTINGS = st.dictionaries(
    st.sampled_from(["name", "joint", "time", "words", "label", "state", "zone", "turn", "every", "text", "speed"]),
    st.one_of(st.sampled_from(["", "Nod", "T", "8 s", "30°", "yes, no", "Head", "On", "1e999"]), st.text(max_size=5)),
    max_size=4,
)


def workbook(rows_, devices) -> Workbook:
    def cell(sheet: str, row: int, column: int, text: str) -> Cell:
        return Cell(text.strip(), Address(sheet, row, column))

    made = []
    for number, (inputs, connector, formula, output, on) in enumerate(rows_, start=2):
        cells = tuple(cell("T", number, 1, i) for i in inputs if i.strip())
        made.append(Row(number, cells, cell("T", number, 1, ", ".join(inputs)), cell("T", number, 2, connector),
                        cell("T", number, 3, formula), cell("T", number, 4, output), on=on))  # fmt: skip
    listed = tuple(
        Device(cell("Devices", n, 1, stream), cell("Devices", n, 2, device),
               {k: cell("Devices", n, 3, v) for k, v in more.items()})
        for n, (stream, device, more) in enumerate(devices, start=2)
    )  # fmt: skip
    return Workbook("x", (Behaviour("T", tuple(made), Address("T", 1, 1)),), listed)


@settings(max_examples=example_count(150), deadline=None)
@given(rows_=ROWS, devices=st.lists(st.tuples(NAMES, DEVICE_NAMES, SETTINGS), max_size=4))
def test_random_rows_make_a_graph_or_findings_and_never_raise(rows_, devices):
    report = Report()
    graph = build_graph(workbook(rows_, devices), load_robot(), connectors(), report)
    (behaviour,) = graph.behaviours
    for step in behaviour.steps:
        assert {*step.inputs, step.output} <= graph.streams.keys()
        assert step.inputs
        if step.active and step.connector.is_sink:
            assert graph.streams[step.output].kind is StreamKind.ACTUATOR
    ranks = {s.output: s.rank for s in behaviour.steps if s.active and not s.connector.is_sink}
    assert report.errors or all(
        ranks.get(i, -1) < s.rank for s in behaviour.steps if s.active for i in s.inputs
    )  # fmt: skip
    assert len({s.rank for s in behaviour.steps}) == len(behaviour.steps)
    assert all(d.message and d.remedy for d in report)
