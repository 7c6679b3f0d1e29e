"""The page that is printed: what it says, and what comes on paper."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from browser import GOOD, HEADER, book, get, visit
from chromium import let_in, violations

from rrp_sheets import api
from rrp_sheets.resources import bundled

HOSTILE = "<script>alert(1)</script>\"'"
LONG = "## Tracking\n" + HEADER + "| Red ball | map | redBall.distance | Distance 1 | | |\n" + "".join(
    f"| Distance {n - 1} | map | distance{n - 1} * 1.01 | Distance {n} | {'FALSE' if n == 30 else ''} | |\n"
    for n in range(2, 60)
) + "| Distance 59 | subscribe | | Head tracker | | |\n"  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("books")
    for name in ("complex-tracking", "say-ball-colour-ja"):
        shutil.copy(bundled("workbooks", f"{name}.xlsx"), made)
    (made / "long.md").write_text(LONG, encoding="utf-8")
    return made


def test_the_page_says_everything_that_the_workbook_says(folder: Path) -> None:
    text = get(visit(folder), f"{book('complex-tracking.xlsx')}/print").text
    digest = api.read(folder / "complex-tracking.xlsx").digest
    for expected in (
        "Complex tracking</p>", "<dt>Authors</dt><dd>The RRP Sheets authors", digest, "<b>Warning</b>", "Tracking!B10",
        "<h2>Tracking</h2>", '<td class="in-formula">redBall.distance</td>', "What it does", "<h2>Scene</h2>",
        "at 1.8, 0, 0.42", "hx-get=\"/book/complex-tracking.xlsx/print/1\"", "Test near and far",
    ):  # fmt: skip
        assert expected in text
    assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:", text)
    assert ">10</th>" in text  # rows have the numbers that they have in Excel


def test_diagrams_come_one_by_one(folder: Path) -> None:
    client = visit(folder)
    drawn = get(client, f"{book('complex-tracking.xlsx')}/print/1").text
    assert drawn.startswith("<figure") and 'data-row="10"' in drawn and " style=" not in drawn
    for number in ("0", "2", "x"):
        assert get(client, f"{book('complex-tracking.xlsx')}/print/{number}").status_code == 404


def test_the_foot_of_every_sheet_has_file_and_hash(folder: Path, tmp_path: Path) -> None:
    answer = get(visit(folder), f"{book('complex-tracking.xlsx')}/paper.css")
    digest = api.read(folder / "complex-tracking.xlsx").digest
    assert answer.mimetype == "text/css"
    assert (
        f"SHA-256 {digest[:4]} {digest[4:8]} " in answer.text and 'counter(page) " of " counter(pages)' in answer.text
    )
    name = 'a"; } * { color: red } \\ \n.md'
    (tmp_path / name).write_text(GOOD, encoding="utf-8")
    style = get(visit(tmp_path), f"{book(name)}/paper.css").text
    assert style.count("{") == style.count("}") == 4 and "color: red" not in style


def test_a_workbook_with_mistakes_is_printed_with_its_mistakes(tmp_path: Path) -> None:
    rows = "| Red ball | mapp | redBall.x | | | |\n| | subscribe | | Say | | |\n"
    (tmp_path / "wrong.md").write_text(f"## Tracking\n{HEADER}{rows}", encoding="utf-8")
    (tmp_path / "none.md").write_text(f"## Tracking\n{HEADER}", encoding="utf-8")
    client = visit(tmp_path)
    text = get(client, "/book/wrong.md/print").text
    assert "Did you mean map?" in text and ">mapp</td>" in text
    assert "There is no row in it yet." in get(client, "/book/none.md/print").text
    assert get(client, "/book/nothing.md/print").status_code == 404


def test_hostile_texts_are_shown_as_text(tmp_path: Path) -> None:
    rows = f"| Red ball | map | redBall.x + '{HOSTILE}' | {HOSTILE} | | {HOSTILE} |\n| {HOSTILE} | subscribe | | Say | | |\n"
    protocol = f"\n## Protocol\n| Field | Value |\n|---|---|\n| Title | {HOSTILE} |\n| {HOSTILE} | {HOSTILE} |\n"
    (tmp_path / "hostile.md").write_text(f"## A {HOSTILE}\n{HEADER}{rows}{protocol}", encoding="utf-8")
    client = visit(tmp_path)
    for address in ("/book/hostile.md/print", "/book/hostile.md/print/1"):
        answer = get(client, address)
        assert answer.status_code == 200 and "<script>" not in answer.text
        assert "&lt;script&gt;" in answer.text


# ---- on paper ----


@pytest.fixture(scope="module")
def page(browser: Any, url: str) -> Any:
    context = browser.new_context(viewport={"width": 1280, "height": 800}, color_scheme="dark")
    let_in(context, url)
    opened = context.new_page()
    opened.url_of = lambda name: f"{url}/book/{name}/print"
    return opened


def drawn(page: Any, name: str) -> None:
    page.goto(page.url_of(name))
    page.wait_for_selector("[data-print]:enabled", timeout=60_000)


@pytest.mark.parametrize("name", ["complex-tracking.xlsx", "say-ball-colour-ja.xlsx"])
def test_nothing_is_cut_on_either_paper(page: Any, name: str) -> None:
    drawn(page, name)
    assert violations(page) == []
    for paper, width in (("A4", 794 - 106), ("Letter", 816 - 106)):  # px at 96 dpi, without the margins of 14 mm
        assert len(re.findall(rb"/Type\s*/Page\b", page.pdf(format=paper))) in (2, 3, 4)
        page.emulate_media(media="print")
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert not page.locator(".topbar").is_visible() and page.locator(".drawn svg").is_visible()
        assert page.evaluate("getComputedStyle(document.querySelector('.paper-table')).display") == "table"
        assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
        page.emulate_media(media="screen")
        page.set_viewport_size({"width": 1280, "height": 800})


def test_sixty_rows_are_printed_whole(page: Any) -> None:
    drawn(page, "long.md")
    assert page.locator(".of-behaviour tbody tr").count() == 60
    assert page.locator(".of-behaviour tbody tr.off").count() == 1
    rows = page.evaluate("new Set([...document.querySelectorAll('.drawn [data-row]')].map((e) => e.dataset.row)).size")
    assert rows == 60
    page.emulate_media(media="print")
    high = page.evaluate(
        "Math.max(...[...document.querySelectorAll('.drawn')].map((e) => e.getBoundingClientRect().height))"
    )
    assert high < 263 * 96 / 25.4  # mm of A4 between its margins: no picture is cut by the end of a sheet
    page.emulate_media(media="screen")


def test_the_button_prints(page: Any) -> None:
    page.goto(page.url_of("say-ball-colour-ja.xlsx"))
    page.evaluate("window.print = () => { window.printed = true }")
    page.wait_for_selector("[data-print]:enabled", timeout=60_000)
    page.get_by_role("button", name="Print").click()
    assert page.evaluate("window.printed") is True
