"""Runs of our workbooks with the simulated robot, replayed without it: one every day, all of them in the soak."""

from __future__ import annotations

import pytest

from rrp_sheets import api
from rrp_sheets.replay.report import as_text
from rrp_sheets.resources import bundled

BOOKS = sorted(p.name for p in bundled("workbooks").glob("*.xlsx"))


def replayed(name, seconds, folder):
    settings = api.RunSettings(seconds=seconds, fast=True, film=False, out=folder / "run")
    ended = api.run_apart(bundled("workbooks", name), settings)
    assert ended.result is not None
    found = api.replay(folder / "run")
    assert found.same, as_text(found)
    return found


@pytest.mark.slow
def test_a_run_with_the_simulated_robot_comes_out_the_same(tmp_path):
    assert replayed("story.xlsx", 2.0, tmp_path).compared > 3


@pytest.mark.soak
@pytest.mark.parametrize("name", BOOKS)
def test_fifteen_seconds_of_every_workbook_come_out_the_same(name, tmp_path):
    assert replayed(name, 15.0, tmp_path).compared > 3
