"""Marble diagrams: what is on them, that every text is escaped, and that nothing overlaps. No layout is held."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from xml.etree import ElementTree as ET

import play
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded import recorded_engine

from rrp_sheets import api
from rrp_sheets.cli.show import marbles_command
from rrp_sheets.connectors import connectors
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.engine.trace import TraceWriter
from rrp_sheets.errors import SheetsError
from rrp_sheets.help.connectors import example_score
from rrp_sheets.model.exchange import DONE
from rrp_sheets.render.marble_diagram import (
    Bar,
    Group,
    Lane,
    Marble,
    MarbleDiagram,
    fitting,
    labels,
    marble_text,
    nice_step,
)
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.render.output import write_marbles
from rrp_sheets.render.style import LANDSCAPE, LEAST_SCALE, columns
from rrp_sheets.resources import bundled
from rrp_sheets.testing import run_tests
from rrp_sheets.testing.case_output import around_failures, scores

SVG = "{http://www.w3.org/2000/svg}"
ROWS = """
    | Red ball | map | 1 / redBall.x | Inverse |
    | Inverse | sample | 500 ms | Sampled |
    | Sampled | subscribe | | Say |
    | Red ball | map | redBall.colour & " <&> 赤" | Words |
    | Words, Inverse | merge | | Both |
    | Both | subscribe | | Print |
    | Say done | subscribe | | Print |
"""
TEST = """
## Test
| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | x=0 | |
| 300 | Red ball | x=0.25 | |
| 700 | Say done | completed=FALSE | |
| 1000 | Sampled | | 5 |
| 1200 | Inverse | | nothing |
"""


@pytest.fixture(scope="module")
def case():
    checked = play.check(play.rows(ROWS) + TEST)
    assert not checked.report.errors
    return checked, run_tests(checked).cases[0]


def drawn(score, **options):
    pages = draw_marbles([score], **options)
    return [ET.fromstring(page.svg) for page in pages]


def lanes(root):
    return {g.get("data-stream"): g for g in root.iter(SVG + "g") if (g.get("class") or "").startswith("lane")}


def said(element):
    return [t.text for t in element.iter(SVG + "text")]


def told(element):
    return [t.text for t in element.iter(SVG + "title")]


def test_a_line_for_each_stream_and_a_bar_for_each_row(case):
    (score,) = scores(*case)
    assert [(g.lane.label, g.lane.kind, [b.row for b in g.bars]) for g in score.groups] == [
        ("Red ball", "sensor", []), ("Say done", "done", []), ("Inverse", "stream", [2]), ("Sampled", "stream", [3]),
        ("Words", "stream", [5]), ("Both", "stream", [6]), ("Say", "actuator", [4]), ("Print", "actuator", [7, 8]),
    ]  # fmt: skip
    found = {}
    for root in drawn(score):
        found |= lanes(root)
    assert list(found) == [g.lane.label for g in score.groups]


def test_an_error_is_a_cross_with_its_reason(case):
    (score,) = scores(*case)
    (root, *_) = drawn(score)
    errors = [g for g in lanes(root)["Inverse"].iter(SVG + "g") if g.get("class") == "error"]
    assert len(errors) == 1
    assert any("divides by zero" in text for text in said(errors[0]))
    assert told(errors[0]) == ["0 s, T!2: This formula divides by zero."]


def test_ticks_of_a_clock_are_in_its_bar(case):
    (score,) = scores(*case)
    assert [b.ticks for g in score.groups for b in g.bars if b.connector == "sample"] == [(500_000, 1_000_000)]


def test_users_texts_are_escaped(case):
    (score,) = scores(*case)
    texts = [text for root in drawn(score) for text in said(root)]
    assert any("<&>" in text for text in texts)


def test_marks_point_at_the_rows_that_do_not_hold(case):
    checked, result = case
    assert not result.passed
    assert around_failures(checked, result).marks == ((1_000_000, "row 5"),)
    assert [lane.label for lane in around_failures(checked, result).lanes] == ["Red ball", "Inverse", "Sampled"]


def test_text_of_a_diagram(case):
    checked, result = case
    axis, ball, inverse, sampled, marks = marble_text(around_failures(checked, result), 64)
    assert axis.split() == ["0", "s", "0.5", "s", "1", "s"]
    assert ball.startswith("□ Red ball          x 0")
    assert re.fullmatch(r"○ Inverse +✗─+4─+", inverse)
    assert re.fullmatch(r"○ Sampled +─+4─+", sampled)
    assert axis.index("0.5 s") == sampled.index("4")
    assert marks.strip() == "▲ row 5" and marks.index("▲") == axis.index("1 s")


def made(values, kind="stream", span=1_000_000):
    marbles = tuple(Marble(us, value) for us, value in values)
    return MarbleDiagram("X", (Group((), Lane("a", "A", kind, marbles)),), 0, span)


def boxes(root):
    """The outer shape of every marble and band: left and right end, middle height."""
    found = []
    for g in root.iter(SVG + "g"):
        if g.get("class") in ("marble", "band"):
            rect = next(g.iter(SVG + "rect"))
            x, y, w, h = (float(rect.get(k)) for k in ("x", "y", "width", "height"))
            found.append((round(y + h / 2, 1), x, x + w))
    return sorted(found)


@pytest.mark.parametrize(("count", "shown"), [(2, "●2"), (9, "●9"), (10, "●+"), (40, "●+")])
def test_in_text_marbles_without_room_are_counted_up_to_nine(count, shown):
    score = made([(500_000, "a long value")] * count + [(850_000, 1)], span=5_000_000)
    lane = next(line for line in marble_text(score, 64) if "●" in line)
    assert shown in lane


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 5, 40, 120, 3000])
@pytest.mark.parametrize("kind", ["sensor", "stream", "actuator", "done", "anonymous"])
def test_marbles_do_not_overlap(count, kind):
    score = made([(i * 1_000_000 // count, i / 7) for i in range(count)], kind)
    for root in drawn(score, strips=1):
        for (line, _, right), (below, left, _) in pairwise(boxes(root)):
            assert line != below or left > right - 2.5


def test_what_comes_at_one_time_is_stacked():
    score = made([(500_000, text) for text in ("one", "two", "three")])
    (root,) = drawn(score)
    heights = [y for y, _, _ in boxes(root)]
    assert len(set(heights)) == 3
    many = made([(500_000, i) for i in range(9)])
    assert "+6" in [text for root in drawn(many) for text in said(root)]


def test_a_crowd_is_a_band_that_says_how_many():
    score = made([(i * 300, i) for i in range(3000)])
    (root,) = drawn(score, strips=1)
    bands = [g for g in root.iter(SVG + "g") if g.get("class") == "band"]
    assert len(bands) == 1
    assert "3000 values: 0 … 2999" in said(bands[0])


def test_a_long_run_is_cut_into_strips_and_pages_fit_a4():
    score = made([(i * 33_333, i) for i in range(600)], span=20_000_000)
    pages = draw_marbles([score])
    starts = {text for p in pages for text in said(ET.fromstring(p.svg)) if re.fullmatch(r"[\d.]+ s", text)}
    assert {"0 s", "10 s", "19 s"} <= starts
    assert len([b for p in pages for b in ET.fromstring(p.svg).iter(SVG + "g") if b.get("class") == "lane stream"]) >= 3
    assert all(p.width <= LANDSCAPE[0] and p.height <= LANDSCAPE[1] / LEAST_SCALE + 1 for p in pages)
    names = [f"S{i}" for i in range(60)]
    wide = MarbleDiagram(
        "Many", tuple(Group((Bar(i, ("a",), "map"),), Lane(n, n, "stream")) for i, n in enumerate(names)), 0, 10
    )
    parts = draw_marbles([wide])
    assert len(parts) > 3 and all(p.height <= LANDSCAPE[1] / LEAST_SCALE + 1 for p in parts)
    assert [n for p in parts for n in lanes(ET.fromstring(p.svg))] == names


def test_kinds_differ_in_shape_and_not_only_in_colour():
    looks = set()
    for kind in ("sensor", "stream", "actuator", "done"):
        (root,) = drawn(made([(500_000, 5)], kind))
        marble = next(g for g in root.iter(SVG + "g") if g.get("class") == "marble")
        rects = list(marble.iter(SVG + "rect"))
        looks.add((len(rects), rects[0].get("rx"), rects[0].get("stroke-dasharray")))
    assert len(looks) == 4


def test_a_blank_is_hollow():
    (root,) = drawn(made([(500_000, None)]))
    marble = next(g for g in root.iter(SVG + "g") if g.get("class") == "marble")
    assert next(marble.iter(SVG + "rect")).get("fill") == "#fff"
    assert "blank" in said(marble)


@pytest.mark.parametrize(
    ("value", "first"),
    [
        (DONE.make(value="Hello", completed=True, seconds=1), "Hello"),
        (DONE.make(value="Hello", completed=False, seconds=1), "stopped: Hello"),
        (play.example("Touch", zone="Head"), "Head, pressed TRUE"),
        ([1, 2], "(1, 2)"),
        (float("nan"), "nan"),
        (10**15, "1000000000000000"),
    ],
)
def test_what_stands_on_a_marble(value, first):
    assert next(labels(value)) == first


@given(st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=40)), st.integers(0, 30))
def test_what_stands_on_a_marble_fits(value, room):
    assert columns(fitting(value, room)) <= room


@given(st.floats(1e-3, 1e6), st.integers(2, 40))
def test_an_axis_has_room_for_its_labels(span, most):
    assert span / nice_step(span, most) <= most * 1.0001


marble_values = st.one_of(
    st.none(), st.floats(allow_nan=False), st.text(max_size=20), st.lists(st.integers(), max_size=3)
)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 999_999), marble_values), max_size=40), st.integers(20, 120))
def test_any_values_are_drawn(values, width):
    score = made(sorted(values, key=lambda v: v[0]))
    for root in drawn(score):
        assert root.tag == SVG + "svg"
    for line in marble_text(score, width):
        assert "\n" not in line


# ---- connectors' examples


@pytest.mark.slow
@pytest.mark.parametrize("connector", list(dict.fromkeys(connectors())), ids=lambda c: c.name)
def test_every_connector_has_a_picture_from_a_real_run(connector):
    score = example_score(connector)
    assert score.groups[-1].lane.marbles, "something comes out"
    assert not any(m.error for lane in score.lanes for m in lane.marbles)
    ET.fromstring(draw_marbles([score], strips=1)[0].svg)


def test_the_example_of_filter_is_what_filter_does():
    score = example_score(connectors().get("filter"))
    assert [m.value for m in score.lanes[0].marbles] == [1, 5, 2, 7]
    assert [m.value for m in score.lanes[-1].marbles] == [5, 7]


# ---- runs


@pytest.fixture
def trace(tmp_path):
    """A recorded run in virtual time, with the workbook beside its trace."""
    book = tmp_path / "book.md"
    book.write_text(play.rows(ROWS), encoding="utf-8")
    checked = api.check(book)
    folder = tmp_path / "run"
    folder.mkdir()
    plan = make_plan(checked)
    writer = TraceWriter(folder / "trace.jsonl", plan, {"name": "book.md"})
    engine = recorded_engine(plan, writer)
    for frame in range(61):
        sent = [("redball", play.example("Red ball", x=0.1 * (frame % 20)))] if frame % 10 == 0 else []
        engine.settle(frame * 1_000_000 // 30, sent)
    writer.close({"ended": "time"})
    api.convert(book, folder / "protocol.xlsx")
    return folder


def test_marbles_of_a_run_are_those_of_its_trace(trace):
    _, found = api.marbles(trace)
    (score,) = found
    lines = [json.loads(line) for line in (trace / "trace.jsonl").read_text(encoding="utf-8").splitlines()]
    sampled = [(round(e["t"] * 1e6), e["value"]) for e in lines if e.get("stream") == "T!Sampled" and "value" in e]
    lane = next(lane for lane in score.lanes if lane.label == "Sampled")
    assert [(m.us, m.value) for m in lane.marbles] == sampled != []
    inverse = next(lane for lane in score.lanes if lane.label == "Inverse")
    assert sum(bool(m.error) for m in inverse.marbles) == sum("error" in e for e in lines) > 0
    assert [b.row for g in score.groups for b in g.bars]


def test_a_trace_without_its_workbook_is_drawn_all_the_same(trace):
    (trace / "protocol.xlsx").unlink()
    _, found = api.marbles(trace / "trace.jsonl")
    assert {"Red ball", "Inverse", "Say"} <= {lane.label for lane in found[0].lanes}


@pytest.mark.parametrize(
    "line",
    [
        "no json", "[]", "3", '{"t":"x"}', '{"t":NaN}', '{"t":-1}', '{"t":1e300}', '{"t":null}',
        '{"type":"header","streams":5}', '{"t":1,"stream":["x"],"value":1}', "[" * 5000,
    ],
)  # fmt: skip
@pytest.mark.parametrize("beside", [True, False])
def test_a_file_that_is_no_trace_is_refused_or_drawn_and_never_breaks(trace, line, beside):
    if not beside:
        (trace / "protocol.xlsx").unlink()
    with (trace / "trace.jsonl").open("a", encoding="utf-8") as file:
        file.write(line + "\n")
    result = CliRunner().invoke(marbles_command, [str(trace)])
    assert result.exception is None or isinstance(result.exception, SheetsError), result.exception


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png", ".txt"])
def test_formats(trace, tmp_path, suffix):
    target = tmp_path / f"marbles{suffix}"
    result = CliRunner().invoke(marbles_command, [str(trace), "-o", str(target), "--from", "0.5s", "--to", "1.5 s"])
    assert result.exit_code == 0, result.output
    start = {".svg": b"<svg", ".pdf": b"%PDF", ".png": b"\x89PNG", ".txt": b"T"}[suffix]
    assert target.read_bytes().startswith(start)


def test_streams_and_times_are_chosen(trace):
    out = (
        CliRunner()
        .invoke(marbles_command, [str(trace), "--streams", "inverse, Say", "--from", "0.9s", "--to", "1.4s"])
        .output
    )
    signs = re.findall(r"^[□○▣◇·] (\w+)", out, re.MULTILINE)
    assert signs == ["Inverse", "Say"]
    assert len({columns(line) for line in out.splitlines() if "──" in line}) == 1, "lines are of one length"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--streams", "Inverze"], "Did you mean Inverse?"),
        (["--behaviour", "Tt"], "Did you mean T?"),
        (["--from", "5 min"], "The time goes from"),
        (["-o", "x.doc"], "Let the file's name end"),
    ],
)
def test_what_cannot_be_drawn_is_said(trace, arguments, words):
    result = CliRunner().invoke(marbles_command, [str(trace), *arguments])
    assert isinstance(result.exception, SheetsError)
    assert words in str(result.exception)


def test_a_time_that_is_none(trace):
    result = CliRunner().invoke(marbles_command, [str(trace), "--from", "noon"])
    assert result.exit_code == 2 and "not a time" in result.output


def test_marbles_of_a_workbook_are_those_of_its_tests(tmp_path):
    out = CliRunner().invoke(marbles_command, [str(bundled("workbooks") / "simple-tracking.xlsx")]).stdout
    assert out.startswith("Test: Tracking\n")
    assert "▣ Head tracker" in out


def test_a_workbook_without_tests_says_so(tmp_path):
    path = tmp_path / "book.md"
    path.write_text(play.rows(ROWS), encoding="utf-8")
    result = CliRunner().invoke(marbles_command, [str(path)])
    assert result.exit_code == 1 and "no tests" in result.output


def test_japanese_and_forbidden_letters_are_drawn(tmp_path):
    score = made([(0, "赤いボール"), (500_000, "a\x00b\u202ec")])
    for root in drawn(score):
        assert any("赤い" in text for text in said(root))
    assert write_marbles([score], tmp_path / "x.png") == []
