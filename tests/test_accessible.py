"""No page has a violation that axe-core finds, in light and dark, wide and narrow."""

from __future__ import annotations

from pathlib import Path

import pytest
from chromium import CHROMIUM, TOKEN, axe, browsing, serving, violations

from rrp_sheets.workbook.maker import make_workbook

if not CHROMIUM or not axe():
    pytest.skip("there is no Chromium, or axe-core cannot be fetched", allow_module_level=True)

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
ROWS = [["", "Red ball", "map", "redBall.distence", "Distance", ""], ["no", "Distance", "filter", "1", "Close", "off"]]


@pytest.fixture(scope="module")
def browser():
    with browsing() as found:
        yield found


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 400), ("dark", 400)])
def test_no_page_has_a_violation(browser, tmp_path: Path, scheme: str, width: int) -> None:
    make_workbook({"T": [HEADER, *ROWS]}, tmp_path / "b.xlsx")
    with serving(tmp_path) as url:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, bypass_csp=True)
        page = context.new_page()
        page.goto(f"{url}/?token={TOKEN}")
        assert violations(page) == []
        page.goto(f"{url}/book/b.xlsx")
        page.wait_for_selector(".problem-list li")
        page.wait_for_selector("td[aria-invalid=true]")
        assert violations(page) == []
        page.click("[data-do=name]")
        assert violations(page) == []
        page.screenshot(path=str(tmp_path / "page.png"))
        context.close()
