"""Diagrams: nothing overlaps, nothing of a user's text becomes markup, every machine can draw."""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest
from busy import within
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets import api
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import Report
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph.build import build_graph
from rrp_sheets.model.workbook import Address, Behaviour, Cell, Row, Workbook
from rrp_sheets.render import boxes as layout_module
from rrp_sheets.render.boxes import Marks, binaries, dot_text, lay_out, make_drawing
from rrp_sheets.render.diagram import draw_diagram, split_steps, to_dot
from rrp_sheets.render.output import write_diagram
from rrp_sheets.render.style import LEAST_SCALE, WRAPPINGS, columns, wrap
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
DOT, PURE = "dot", "graphviz-pure"


def graph_of(*rows, sheet="T"):
    """The graph of rows given as (inputs, connector, formula, output[, on])."""
    made = []
    for n, row in enumerate(rows, 2):
        cells = [Cell(text, Address(sheet, n, c)) for c, text in enumerate(row[:4], 1)]
        inputs = tuple(replace(cells[0], text=part.strip()) for part in row[0].split(",") if part.strip())
        made.append(Row(n, inputs, *cells, on=row[4] if len(row) > 4 else True))
    book = Workbook("test", (Behaviour(sheet, tuple(made), Address(sheet, 1, 1)),))
    graph = build_graph(book, load_robot("nao"), connectors(), Report())
    assert len(graph.behaviours[0].steps) == len(rows)
    return graph


SIMPLE = (
    ("Red ball", "map", "redBall.distance", "Distance"),
    ("Distance", "filter", "distance < 0.5", "Close ball"),
    ("Close ball", "subscribe", "", "Head tracker"),
)
COMPLEX = (
    ("Red ball", "map", "redBall.distance", "Distance"),
    ("Distance", "filter", "distance < 0.5", "Close ball"),
    ("Distance", "filter", "AND(distance >= 0.5, distance < 2)", "Middle ball"),
    ("Distance", "filter", "distance >= 2", "Far ball", False),
    ("Far ball", "subscribe", "", "Head tracker"),
    ("Middle ball", "subscribe", "", "Head and body tracker"),
    ("Red ball", "timestamp", "", "Ball with time"),
    ("Head yaw", "timestamp", "", "Yaw with time"),
    ("Ball with time, Yaw with time", "combineLatest", "(ballWithTime.v.x + yawWithTime.v, 0)", "Angle and age"),
    ("", "filter", "ABS(angleAndAge[1]) < 0.2", ""),
    ("", "map", "value[0]", "Ball angle"),
    ("Close ball, Ball angle", "combineLatest", "ballAngle", "Near angle"),
    ("Near angle", "sample", "500 ms", "Calm angle"),
    ("Calm angle", "map", 'IF(calmAngle < 0, "right", "left")', "Arm"),
    ("Arm", "subscribe", "", "Arm tracker"),
)
JAPANESE = (
    ("Red ball", "map", "value.distance", "距離"),
    ("距離", "filter", "距離 < 0.5", "近いボールがあまりにも近くにあります"),
    ("近いボールがあまりにも近くにあります", "subscribe", "", "Say"),
)
BALLS = [f"{c} {n}" for c in ("Red", "Green", "Blue") for n in (1, 2, 3)]
FAN = (
    *((f"{name[:-2]} ball", "map", "value.x", name) for name in BALLS),
    (", ".join(BALLS), "merge", "", "All"),
    ("All", "subscribe", "", "Print"),
)


def chains(rows):
    """Chains of four rows each, with a cross-link from chain to chain."""
    out = []
    for n in range(rows // 4):
        first = "Red ball" if n % 3 else f"Far {n - 1}, Near {n - 1}" if n else "Green ball"
        kind = "merge" if "," in first else "filter"
        out += [
            (first, kind, "" if kind == "merge" else "TRUE", f"Distance {n}"),
            (f"Distance {n}", "filter", "value > 1", f"Far {n}"),
            (f"Distance {n}", "filter", "value <= 1", f"Near {n}"),
            (f"Near {n}", "subscribe", "", "Print"),
        ]
    return out


@pytest.fixture(params=binaries(), ids=lambda path: Path(path).name)
def binary(request):
    """Every Graphviz of this machine: the system's, where there is one, and the one that comes along."""
    return request.param


def bezier(points):
    for start in range(0, len(points) - 3, 3):
        p = points[start : start + 4]
        for t in (i / 12 for i in range(13)):
            w = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3)
            yield tuple(sum(w[k] * p[k][axis] for k in range(4)) for axis in (0, 1))


@pytest.mark.parametrize("rows", [SIMPLE, COMPLEX, FAN, chains(16)], ids=["simple", "complex", "fan", "chains"])
def test_no_boxes_overlap_and_no_arrow_runs_through_a_foreign_box(rows, binary):
    graph = graph_of(*rows)
    behaviour = graph.behaviours[0]
    drawing = make_drawing(graph, behaviour, behaviour.steps, wrapping=WRAPPINGS[0], marks=Marks(), notes={})
    layout = lay_out(dot_text(drawing, "T"), binary=binary)
    sides = {}
    for box in drawing.boxes.values():
        x, y = layout.places[box.id]
        sides[box.id] = (x - box.width / 2, y - box.height / 2, x + box.width / 2, y + box.height / 2)
    for (a, p), (b, q) in itertools.combinations(sides.items(), 2):
        assert p[2] <= q[0] + 0.1 or q[2] <= p[0] + 0.1 or p[3] <= q[1] + 0.1 or q[3] <= p[1] + 0.1, (a, b)
    for way in layout.ways:
        for x, y in bezier(way.points):
            for name, (left, top, right, bottom) in sides.items():
                inside = left + 1 < x < right - 1 and top + 1 < y < bottom - 1
                assert not inside or name in (way.tail, way.head), (way.tail, way.head, name)


def test_sensors_are_on_top_and_actuators_at_the_bottom(binary):
    graph = graph_of(*COMPLEX)
    behaviour = graph.behaviours[0]
    drawing = make_drawing(graph, behaviour, behaviour.steps, wrapping=WRAPPINGS[0], marks=Marks(), notes={})
    places = lay_out(dot_text(drawing, "T"), binary=binary).places
    heights = {
        k: [places[b.id][1] for b in drawing.boxes.values() if b.kind == k] for k in ("sensor", "row", "actuator")
    }
    assert max(heights["sensor"]) < min(heights["row"]) <= max(heights["row"]) < min(heights["actuator"])


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKBOOKS)
def test_the_dot_text_of_the_workbooks(name, golden):
    checked = api.check(bundled("workbooks") / f"{name}.xlsx")
    golden(f"{name}.dot", to_dot(checked.graph, checked.graph.behaviours))


def test_rows_streams_flags_and_switched_off_rows_can_be_found_in_the_picture():
    graph = graph_of(*COMPLEX)
    (page,) = draw_diagram(graph, graph.behaviours[0], problems={13: 4}, words={14: "changed"})
    root = ET.fromstring(page.svg)
    ids = {e.get("id"): e for e in root.iter() if e.get("id")}
    rows = {f"b{n}-r{step.number}" for n, behaviour in enumerate(graph.behaviours, 1) for step in behaviour.steps}
    assert rows <= ids.keys()
    assert ids["b1-r5"].get("class") == "row off" and "off" in "".join(ids["b1-r5"].itertext())
    assert ids["b1-r6"].get("class") == "row off"
    assert "4" in [e.text for e in ids["b1-r13"].iter()]
    assert "changed" in "".join(ids["b1-r14"].itertext())
    assert len(ids) == len([e for e in root.iter() if e.get("id")]), "an id stands twice"
    assert root[0].tag.endswith("title") and root[1].tag.endswith("desc") and "Head yaw" in root[1].text


HOSTILE = [
    'a < b & "c" <b>x</b>',
    'x" ]; evil [label="\\L',
    "<table><tr><td>y</td></tr></table>",
    "]]>\x00\x1b[31m",
    "\u202eabc",
]


def test_hostile_names_stay_text(binary):
    rows = [(HOSTILE[0], "map", HOSTILE[2], HOSTILE[1])]
    graph = graph_of(
        ("Red ball", "filter", '"</text><script>"', HOSTILE[0]), *rows, (HOSTILE[1], "subscribe", "", "Print")
    )
    streams = {k: replace(s, name=HOSTILE[4 - n % 5]) if n % 2 else s for n, (k, s) in enumerate(graph.streams.items())}
    graph = replace(graph, streams=streams)
    (page,) = draw_diagram(graph, graph.behaviours[0], title=HOSTILE[3], binary=binary)
    tags = {e.tag.rpartition("}")[2] for e in ET.fromstring(page.svg).iter()}
    assert tags <= {"svg", "title", "desc", "g", "path", "rect", "ellipse", "circle", "text"}
    assert "evil" not in {line.split()[0] for line in page.dot.splitlines()}
    assert "=<" not in page.dot and "\x1b" not in page.svg and "\u202e" not in page.svg


@pytest.mark.slow
@given(st.text(max_size=60), st.text(max_size=60))
@settings(max_examples=25, deadline=None)
def test_any_name_gives_a_well_formed_picture(name, formula):
    graph = graph_of(*SIMPLE)
    streams = {k: replace(s, name=name) for k, s in graph.streams.items()}
    behaviour = graph.behaviours[0]
    steps = tuple(replace(s, row=replace(s.row, formula=replace(s.row.formula, text=formula))) for s in behaviour.steps)
    behaviour = replace(behaviour, steps=steps)
    for page in draw_diagram(replace(graph, streams=streams, behaviours=(behaviour,)), behaviour, title=name):
        ET.fromstring(page.svg)


@given(st.text(max_size=200), st.integers(8, 30), st.integers(1, 4))
def test_wrapped_text_keeps_its_limits(text, most, lines):
    made = wrap(text, most, lines)
    assert 1 <= len(made) <= lines
    assert all(columns(line) <= most for line in made)


@pytest.mark.parametrize("times", [1, 8, 16])
def test_no_formula_is_cut(times):
    formula = " + ".join(
        ["IF(NOT(ISBLANK(redBall)); redBall.distance; IF(redBall.x > 1; 1; aNameThatIsFarTooLong))"] * times
    )
    graph = graph_of(("Red ball", "map", formula, "D"), ("D", "subscribe", "", "Print"))
    (page,) = draw_diagram(graph, graph.behaviours[0])
    drawn = "".join(e.text or "" for e in ET.fromstring(page.svg).iter("{http://www.w3.org/2000/svg}text"))
    assert "".join(formula.split()) in "".join(drawn.split()) and "…" not in drawn
    assert page.scale >= LEAST_SCALE and not page.landscape


def test_a_long_behaviour_is_drawn_in_parts_that_fit():
    graph = graph_of(*chains(40), ("Distance 0", "subscribe", "", "Say"))
    pages = draw_diagram(graph, graph.behaviours[0])
    assert len(pages) > 1 and all(p.scale >= LEAST_SCALE for p in pages)
    assert pages[0].rows[0] == 2 and pages[-1].rows[1] == 42
    assert all(a.rows[1] + 1 == b.rows[0] for a, b in itertools.pairwise(pages))
    assert any("to part" in p.svg for p in pages) and any("from part" in p.svg for p in pages)


def test_parts_do_not_cut_anonymous_streams_when_they_need_not():
    rows = [("Red ball", "map", "value.x", "")] + [("", "map", "value", "")] * 8 + [("", "subscribe", "", "Print")]
    graph = graph_of(*rows, *[("Green ball", "subscribe", "", "Print")] * 14)
    first, *_ = split_steps(graph, graph.behaviours[0].steps, 18)
    assert len(first) >= 10


@pytest.mark.slow
def test_a_hundred_rows_are_quick():
    graph = graph_of(*chains(100))
    with within(2):
        draw_diagram(graph, graph.behaviours[0])


@pytest.mark.soak
@pytest.mark.parametrize("whole", [False, True])
def test_a_thousand_rows_are_drawn_in_time(whole):
    graph = graph_of(*chains(1000))
    with within(20):
        pages = draw_diagram(graph, graph.behaviours[0], whole=whole)
    assert (len(pages) == 1) is whole


def test_without_dot_the_wheel_lays_out(monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert [b.rpartition("/")[2].removesuffix(".exe") for b in binaries()] == [PURE]
    graph = graph_of(*SIMPLE)
    assert draw_diagram(graph, graph.behaviours[0])[0].svg


def test_too_slow_a_layout_is_told(monkeypatch):
    def slow(command, **options):
        raise subprocess.TimeoutExpired(command, options["timeout"])

    monkeypatch.setattr(layout_module.subprocess, "run", slow)
    graph = graph_of(*SIMPLE)
    with pytest.raises(SheetsError, match="within 3 seconds"):
        draw_diagram(graph, graph.behaviours[0], timeout=3)


@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png"])
def test_files_are_written_whole_and_alike(tmp_path, suffix):
    graph = graph_of(*JAPANESE)
    pages = draw_diagram(graph, graph.behaviours[0])
    files = [tmp_path / f"図{n}{suffix}" for n in (1, 2)]
    for file in files:
        write_diagram(pages, file)
    first, second = (f.read_bytes() for f in files)
    starts = {".svg": b"<svg", ".pdf": b"%PDF", ".png": b"\x89PNG"}
    assert first.startswith(starts[suffix]) and first == second
    assert sorted(tmp_path.iterdir()) == files


@pytest.mark.parametrize("name", ["mixed-control", "story", "simple-tracking"])
def test_a_dot_file_is_one_graph_with_a_cluster_for_each_behaviour(tmp_path, name):
    file = tmp_path / "x.dot"
    checked, notes = api.draw(bundled("workbooks") / f"{name}.xlsx", file)
    text = file.read_text(encoding="utf-8")
    assert notes == [] and text.count("digraph") == 1
    for binary in binaries():
        done = subprocess.run(
            [binary, "-Kdot", "-Tjson"], input=text.encode(), capture_output=True, check=True, timeout=300
        )
        drawn = json.loads(done.stdout)
        assert done.stderr == b""
        titles = [o["label"] for o in drawn["objects"] if o["name"].startswith("cluster")]
        assert titles == [b.name for b in checked.graph.behaviours]
        rows = [o["label"].split()[0] for o in drawn["objects"] if o.get("label", "")[:1].isdigit()]
        assert sorted(map(int, rows)) == sorted(s.number for b in checked.graph.behaviours for s in b.steps)


def test_a_dot_file_of_a_workbook_without_rows_is_refused(tmp_path):
    (tmp_path / "w.md").write_text("## T\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n")
    with pytest.raises(SheetsError, match="nothing to draw"):
        api.draw(tmp_path / "w.md", tmp_path / "x.dot")


def test_an_unknown_suffix_is_refused(tmp_path):
    graph = graph_of(*SIMPLE)
    with pytest.raises(SheetsError, match=r"\.svg, \.pdf, \.png"):
        write_diagram(draw_diagram(graph, graph.behaviours[0]), tmp_path / "x.docx")
    with pytest.raises(SheetsError):
        write_diagram([], tmp_path / "x.svg")
    assert not list(tmp_path.iterdir())


def test_a_missing_japanese_font_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("rrp_sheets.render.style.FONTS", tmp_path / "none")
    graph = graph_of(*JAPANESE)
    (warning,) = write_diagram(draw_diagram(graph, graph.behaviours[0]), tmp_path / "x.png")
    assert "Japanese font" in warning


ASKING = (
    ("Head yaw", "map", '"How are you?"', "Question"),
    ("Question", "subscribe", "", "Say"),
    ("Say done", "map", '"blue"', "Colour"),
    ("Colour", "subscribe", "", "Eye colour"),
)


def test_the_way_through_the_world_is_dashed_and_moves_nothing(binary):
    graph = graph_of(*ASKING)
    (page,) = draw_diagram(graph, graph.behaviours[0], binary=binary)
    root = ET.fromstring(page.svg)
    names = {e.get("id"): e.get("data-name") or e.get("data-row") for e in root.iter() if e.get("id")}
    arrows = {(names[e.get("data-from")], names[e.get("data-to")]): e for e in root.iter() if e.get("data-from")}
    assert set(arrows) == {
        ("Head yaw", "2"), ("2", "Question"), ("Question", "3"), ("3", "Say"), ("Say", "Say done"),
        ("Say done", "4"), ("4", "Colour"), ("Colour", "5"), ("5", "Eye colour"),
    }  # fmt: skip
    dashed = {ends for ends, e in arrows.items() if e[0].get("stroke-dasharray")}
    assert dashed == {("Say", "Say done")}
    heights = {n: float(e[-1].get("y")) for e in root.iter() if (n := e.get("data-name")) and len(e)}
    assert heights["Say done"] < heights["Colour"] < heights["Say"]


@pytest.mark.parametrize("rows", [SIMPLE, COMPLEX, ASKING], ids=["simple", "complex", "asking"])
def test_a_panel_gets_a_narrow_drawing_with_room_for_values_and_boxes_that_can_be_chosen(rows):
    graph = graph_of(*rows)
    (printed,) = draw_diagram(graph, graph.behaviours[0], whole=True)
    (alive,) = draw_diagram(graph, graph.behaviours[0], whole=True, room=True)
    assert alive.width <= printed.width + 30
    assert "tabindex" not in printed.svg and 'role="img"' in printed.svg
    root = ET.fromstring(alive.svg)
    assert root.get("role") == "group"
    boxes = [e for e in root.iter() if e.get("role") == "button"]
    names = {e[0].text for e in boxes if e[0].tag.endswith("title")}
    assert len(names) == len(boxes) > len(rows)
    assert f"Row 2, {rows[0][1]}: {rows[0][2]}" in names
    for oval in (e for e in root.iter() if e.get("class") == "stream"):
        ellipse, value = oval[1], oval[-1]
        assert value.get("class") == "now" and not value.text
        middle, half = float(ellipse.get("cy")), float(ellipse.get("ry"))
        assert middle < float(value.get("y")) < middle + half - 2


def test_every_colour_of_the_drawing_is_one_of_the_page():
    css = (bundled("templates", "web") / "static" / "diagram.css").read_text(encoding="utf-8")
    graph = graph_of(*COMPLEX, *ASKING)
    (page,) = draw_diagram(graph, graph.behaviours[0], whole=True, room=True, problems={2: 1})
    used = {(a, c) for a in ("fill", "stroke") for c in re.findall(rf'{a}="(#\w+)"', page.svg)}
    assert len(used) > 12
    assert {pair for pair in used if f'[{pair[0]}="{pair[1]}"]' not in css} == set()
