"""Help in the browser: every connector has a picture of its example, in words too, in which nothing overlaps."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path

import pytest
from browser import get, visit
from flask.testing import FlaskClient

from rrp_sheets.connectors import connectors
from rrp_sheets.help.connectors import draw_example, example_score, marbles
from rrp_sheets.render.marble_diagram import Bar, Group, Lane, Marble, MarbleDiagram

NAMES = sorted({c.name for c in connectors()})


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> FlaskClient:
    folder: Path = tmp_path_factory.mktemp("books")
    return visit(folder)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_connector_has_its_picture(name: str, client: FlaskClient) -> None:
    connector = connectors().get(name)
    assert connector is not None
    text = get(client, f"/help?topic={name}").text
    picture = str(draw_example(example_score(connector)))
    assert picture in text and "one place is" not in text
    assert " rad" not in text, "its example is of plain values"
    root = ET.fromstring(picture)
    told = root.get("aria-label", "")
    shown = [e.text for e in root.iter("text") if e.get("class") == "value"]
    assert shown and all(f"{value} at " in told for value in shown) and name in told
    inputs = [line for label, line in marbles(connector)[:-1]]
    assert len(root.findall("g[@class]")) == len(inputs) + 2, "a line for each input, the connector, and the output"


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps(name: str) -> None:
    connector = connectors().get(name)
    assert connector is not None
    root = ET.fromstring(str(draw_example(example_score(connector))))
    for lane in root.findall("g[@class]"):
        found = [e for e in lane.iter("rect") if e.get("class") == "marble"]
        spans = sorted((float(e.get("x", 0)), float(e.get("x", 0)) + float(e.get("width", 0))) for e in found)
        assert all(a[1] < b[0] for a, b in pairwise(spans))
        assert all(a >= 52 and b <= float(root.get("width", 0)) for a, b in spans)


def test_errors_actuators_and_clock_ticks_are_drawn() -> None:
    sensor = Lane("a", "Input", "sensor", (Marble(0, 1.0), Marble(500_000, "<b>")))
    said = Lane("b", "Say", "actuator", (Marble(1_000_000, error="no number"),))
    bar = Bar(2, ("Input",), "sample", "", "0.5 s", ticks=(500_000, 1_000_000))
    root = ET.fromstring(str(draw_example(MarbleDiagram("", (Group((), sensor), Group((bar,), said)), 0, 1_000_000))))
    assert [e.text for e in root.iter("text") if e.get("class") == "value"] == ["1", "<b>", "!"]
    assert [e.get("rx") for e in root.iter("rect") if e.get("class") == "marble"] == ["12", "12", "2"]
    assert len([e for e in root.iter("path") if e.get("class") == "tick"]) == 2
    assert root.get("aria-label") == "Input: 1 at 0 s, <b> at 0.5 s; sample 0.5 s; Say: ! at 1 s"
