"""Every device of the catalogue has an example, which its help shows: in order, its test holds, and it runs."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from rrp_sheets import api
from rrp_sheets.checks import Checked
from rrp_sheets.graph import StreamKind
from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.topics import text_on
from rrp_sheets.model.names import key
from rrp_sheets.robots import load_robot
from rrp_sheets.testing import run_tests

ROBOT = load_robot()
DEVICES = sorted(d.name for d in ROBOT.devices.values())
NOT_SIMULATED = "DEV009"


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Checked]:
    folder = tmp_path_factory.mktemp("examples")

    def written(name: str) -> Checked:
        path = folder / f"{name}.md"
        path.write_text(ROBOT.devices[key(name)].example, encoding="utf-8")
        return api.check(path)

    return cache(written)


@pytest.mark.parametrize("name", DEVICES)
def test_it_is_in_order_uses_the_device_and_its_test_holds(name: str, checked: Callable[[str], Checked]) -> None:
    book = checked(name)
    assert [d.code for d in book.report if d.code != NOT_SIMULATED] == []
    used = {s.device.type.name for s in book.graph.streams.values() if s.device and s.kind is not StreamKind.DONE}
    assert name in used
    report = run_tests(book)
    assert report.cases and report.passed


@pytest.mark.slow
@pytest.mark.parametrize("name", DEVICES)
def test_its_help_shows_it_whole(name: str, checked: Callable[[str], Checked]) -> None:
    title = ROBOT.devices[key(name)].example.partition("\n")[0].removeprefix("# ")
    assert len(title) > 10
    text = as_text(text_on(name))
    assert f"For example: {title}" in " ".join(text.split())
    shown = text.partition("For example: ")[2]
    assert "…" not in shown and "Expect" not in shown
    for behaviour in checked(name).workbook.behaviours:
        for row in behaviour.rows:
            assert row.formula.text in shown


@pytest.mark.soak
@pytest.mark.parametrize("name", DEVICES)
def test_it_runs_and_its_device_does_something(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"{name}.md"
    path.write_text(ROBOT.devices[key(name)].example, encoding="utf-8")
    checked, result = api.run(path, api.RunSettings(fast=True, out=tmp_path, film=False))
    assert result is not None and result.broken is None
    assert result.summary.errors == ({"the robot itself": 1} if name == "Orientation" else {})  # which is pushed over
    streams = [s for s in checked.graph.streams.values() if s.device and s.device.type.name == name]
    came = [n for n in {**result.summary.events, **result.summary.commands} if key(n) in {key(s.name) for s in streams}]
    assert any(result.summary.events.get(n) or result.summary.commands.get(n) for n in came)
