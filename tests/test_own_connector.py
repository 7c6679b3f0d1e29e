"""A connector of another distribution is known by its entry point alone: in checks, words, drawings and the grid."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
from browser import get, visit
from play import check, rows

from rrp_sheets import registry
from rrp_sheets.connectors import Connector, Parameter, connectors
from rrp_sheets.connectors.filter import FILTER
from rrp_sheets.connectors.map import MAP
from rrp_sheets.connectors.spec import Passing
from rrp_sheets.documents.grid import make_grid
from rrp_sheets.render.diagram import draw_diagram, draw_legend
from rrp_sheets.render.sentences import explain
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.web.statics import build_id, icons
from rrp_sheets.workbook.reading import read
from rrp_sheets.workbook.schema import recognise

SETTLE = Connector(
    name="settle",
    min_inputs=1,
    max_inputs=1,
    parameter=Parameter.PERIOD,
    icon='<path d="M1 6.3h4"/><circle cx="9" cy="6" r="2" class="f"/>',
    help="Passes a value on when nothing has come for the period after it.",
    sentence="{Input} becomes {output} when no newer one arrives for {period}.",
    legend="the last of several",
    build=lambda wiring: wiring.inputs[0],
    passes=Passing("events", later=True),
)
BARE = replace(SETTLE, icon="", legend="", passes=None, sentences={"ja": "{input}が落ち着くと{output}になります。"})
BOOK = rows("""
    | Red ball  | settle    | 1 s               | Calm ball |
    | Calm ball | map       | calmBall.distance | Distance  |
    | Distance  | subscribe |                   | Print     |
""")
Provide = Callable[[Connector], None]


@pytest.fixture
def provide(monkeypatch: pytest.MonkeyPatch) -> Iterator[Provide]:
    def provided(connector: Connector) -> None:
        point = SimpleNamespace(load=lambda: lambda: [(connector.name, connector)])
        monkeypatch.setattr(registry, "entry_points", lambda group: [point] if group == "rrp_sheets.connectors" else [])
        forget()

    def forget() -> None:
        for kept in (connectors, icons, build_id):
            kept.cache_clear()

    yield provided
    monkeypatch.undo()
    forget()


def explained(language: str = "en", formula: str = "1 s") -> list[str]:
    checked = check(BOOK.replace("1 s", formula))
    (said,) = explain(checked.graph, checked.workbook, language=language)
    return [row.text for row in said.rows]


def test_example_and_rate_pass_through_an_own_connector(provide: Provide) -> None:
    provide(SETTLE)
    checked = check(BOOK)
    assert not checked.report.errors
    calm, distance = (checked.facts[step.output] for step in checked.graph.behaviours[0].steps[:2])
    assert (calm.rate.kind, calm.has_example) == ("event", True)
    assert (distance.known.kind, distance.known.unit) == ("number", "m")


def test_own_connector_is_explained(provide: Provide) -> None:
    provide(SETTLE)
    assert explained()[0] == "“Red ball” becomes “Calm ball” when no newer one arrives for 1 s."


@pytest.mark.parametrize(
    ("like", "formula", "text"),
    [
        (MAP, "redBall.distance", "When the robot sees a red ball, set “Calm ball” to its distance."),
        (
            FILTER,
            "redBall.distance < 1",
            "When the robot sees a red ball, if its distance is under 1 m, send “Calm ball”.",
        ),
        (replace(FILTER, variants={}), "TRUE", "When `TRUE` is true, send “Calm ball”."),
    ],
)
def test_own_connector_says_what_its_formula_does(provide: Provide, like: Connector, formula: str, text: str) -> None:
    provide(replace(like, name="settle"))
    assert text in explained(formula=formula)[0]


def test_own_connector_is_drawn_with_its_icon_and_in_the_legend(provide: Provide) -> None:
    provide(SETTLE)
    graph = check(BOOK).graph
    (page,) = draw_diagram(graph, graph.behaviours[0])
    assert 'd="M1 6.3h4"' in page.svg
    for language in ("en", "ja"):
        legend, _, _ = draw_legend(language)
        assert 'd="M1 6.3h4"' in legend and "the last of several" in legend


def test_grid_shows_the_icon_of_an_own_connector(provide: Provide, tmp_path: Path) -> None:
    version = build_id()
    provide(SETTLE)
    assert build_id() != version  # pages ask for the icons anew
    path = tmp_path / "own.md"
    path.write_text(BOOK, encoding="utf-8")
    (sheet,) = read(path).sheets
    assert 'data-icon="settle"' in RowRenderer(make_grid(sheet, recognise(sheet), "behaviour")).rows(0, 10)
    client = visit(tmp_path)
    first = get(client, "/static/icons.svg")
    symbols = ElementTree.fromstring(first.text).findall("{*}symbol")
    (settle,) = (symbol for symbol in symbols if symbol.get("id") == "i-settle")
    assert first.mimetype == "image/svg+xml" and settle[0].get("d") == "M1 6.3h4"
    assert get(client, "/static/icons.svg", If_None_Match=first.headers["ETag"]).status_code == 304
    assert get(client, f"/static/{build_id()}/icons.svg").cache_control.immutable


def test_connector_without_legend_and_flow_is_explained_all_the_same(provide: Provide) -> None:
    legend = draw_legend()
    provide(BARE)
    checked = check(BOOK)
    assert not checked.report.errors
    assert not checked.facts[checked.graph.behaviours[0].steps[0].output].has_example
    assert explained()[0].startswith("“Red ball” becomes “Calm ball”")
    assert explained("ja")[0].startswith("「Red ball」が落ち着くと")
    assert draw_legend() == legend and '<circle cx="6" cy="6" r="4"/></symbol>' in icons().decode()
