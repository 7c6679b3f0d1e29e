"""The grid for those who hear it: names and roles, and what is told when."""

from __future__ import annotations

import pytest
from chromium import becomes, eventually
from grid_books import EMPTY, Books


@pytest.mark.slow
def test_cells_tell_column_row_and_text_the_cursor_tells_more_and_editing_rows_and_undo_are_told(shelf: Books) -> None:
    grid = shelf.open()
    role = grid.page.get_by_role
    grid.page.wait_for_function("() => document.getElementById('panels').ariaBusy !== 'true'")
    becomes(lambda: role("grid", name="T").count(), 1)
    becomes(lambda: role("columnheader", name="Formula, column D").count(), 1)
    becomes(lambda: role("gridcell", name="Formula, row 3: distance < 0.5").count(), 1)
    becomes(lambda: role("gridcell", name="Notes, row 2: blank").count(), 1)
    eventually(lambda: role("checkbox", name="Row 2 is on").is_checked())
    grid.page.wait_for_selector("td[aria-label='Input streams, row 2: sensor Red ball']")
    grid.go("D3")
    grid.wait_spoken("D3 Formula: distance < 0.5")
    grid.press("Shift+ArrowDown")
    grid.wait_spoken("2 cells selected")
    grid.go("D3")
    grid.write("distence < 0.5")
    grid.page.wait_for_selector("td[aria-invalid=true]")
    grid.go("D3")
    grid.wait_spoken("Error “distence” is not an input of this row. Did you mean distance?")
    eventually(lambda: grid.spoken.endswith("Write distance: Control point."))
    grid.press("Control+.")
    grid.status("Done: Write distance.")
    role("gridcell", name="Formula, row 3: distance < 0.5").wait_for()
    grid.go("F3")
    grid.press("F2")
    grid.wait_spoken("Editing Notes. Enter to save, Escape to cancel.")
    becomes(lambda: grid.page.get_by_role("textbox", name="Notes, row 3").count(), 1)
    grid.press("Escape")
    grid.wait_spoken("Cancelled. F3 Notes: near")
    grid.write("far")
    grid.wait_spoken("Saved. F4 Notes: blank")
    grid.press("Control++")
    grid.status("A row inserted.")
    becomes(lambda: grid.page.get_by_role("gridcell", name="Connector, row 5: subscribe").count(), 1)
    grid.press("Control+-")
    grid.status("The row is deleted.")
    grid.press("Control+z")
    grid.status("Undone: row 4 is back.")


@pytest.mark.slow
def test_the_grid_with_everything_open_has_no_fault_for_axe(shelf: Books) -> None:
    grid = shelf.open(EMPTY)
    grid.go("B2")
    grid.write("Rde bal")
    grid.page.wait_for_selector("td[aria-invalid=true]")
    grid.go("B2")
    grid.page.wait_for_selector(".mends:visible")
    assert grid.faults() == []
    grid.page.keyboard.type("re")
    grid.page.wait_for_selector("[role=option]")
    assert grid.faults() == []
