"""Rows that are made for one page while others insert, delete and move rows of the same sheet."""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Iterator

import pytest

from rrp_sheets.documents.grid import Grid, GridColumn
from rrp_sheets.web.analysis import no_analysis
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, MoveRows

ROUNDS = 40


@pytest.fixture
def hurried() -> Iterator[None]:
    """Threads that take turns very often."""
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(usual)


@pytest.mark.usefixtures("hurried")
def test_rows_can_be_made_at_any_moment_and_those_that_stay_are_never_missing() -> None:
    grid = Grid("T", "behaviour", 2, (GridColumn(1, "Connector", "Connector"),))
    stay = grid.add_blank(20)
    renderer, over = RowRenderer(grid), threading.Event()

    def edit() -> None:
        while not over.is_set():
            grid.carry_out(InsertRows("T", 4, 5))
            grid.carry_out(MoveRows("T", 15, 5, 2))
            grid.carry_out(MoveRows("T", 2, 5, 20))
            grid.carry_out(DeleteRows("T", 4, 5))

    editor = threading.Thread(target=edit)
    editor.start()
    try:
        for _ in range(ROUNDS):
            ids = re.findall(r'<tr [^>]*id="([^"]+)"', renderer.rows(0, 100))
            assert set(stay) <= set(ids) and len(set(ids)) == len(ids)
            renderer.changed()
            assert set(renderer.html([*stay, "gone"])) == set(stay)
    finally:
        over.set()
        editor.join()
    assert grid.rows == stay


def test_rows_that_one_page_has_already_are_still_told_to_the_others() -> None:
    grid = Grid("T", "behaviour", 2, (GridColumn(1, "Connector", "Connector"),))
    row = grid.add_blank(3)[1]
    renderer = RowRenderer(grid)
    for locked in ({}, {("T", row, 1): ("c", "Aya")}):  # the second page is opened before the first one is told
        renderer.update(no_analysis(), locked)
        renderer.rows(0, 10)
    assert [changed for changed, _ in renderer.changed()] == [row]
    assert renderer.changed() == []
