"""What the pages that `serve` shows say, and that no text of a workbook becomes markup."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from browser import GOOD, HEADER, book, get, visit

from rrp_sheets.resources import bundled
from rrp_sheets.web.book import commands

HOSTILE = "<script>alert(1)</script>"
IMAGE = "\"><img src=x onerror='alert(1)'>"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


# ---- what the pages say ----


def test_the_shelf_tells_title_size_and_verdict(folder: Path) -> None:
    text = GOOD + "| Red ball | map | redBall.distence | Distance | | |\n\n## Protocol\n| Field | Value |\n|---|---|\n"
    (folder / "wrong.md").write_text(text + "| Title | My title |\n| Purpose | My purpose |\n", encoding="utf-8")
    shown = get(visit(folder), "/").text
    for expected in ("My title", "My purpose", "1 behaviour, 2 rows", "1 error", "no problems", "wrong.md"):
        assert expected in shown


def test_problems_stand_at_their_cells_with_their_remedy(folder: Path) -> None:
    rows = "| Red ball | map | redBall.distence | Distance | | |\n| Distance | subscribe | | Say | perhaps | |\n"
    (folder / "wrong.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    text = get(visit(folder), book("wrong.md")).text
    formula = re.search(r'<td class="formula flagged is-error" aria-describedby="p1 ">.*?</td>', text, re.DOTALL)
    assert formula and "redBall.distence" in formula[0] and '<span class="only-spoken">error </span>1' in formula[0]
    assert re.search(r'id="p1">.*?FORM007 in C2.*?Did you mean distance\?', text, re.DOTALL)
    assert re.search(r'<td class="on flagged is-error" aria-describedby="p2 ">', text)
    assert '<a href="#s1-2">Tracking!C2</a>' in text and 'id="s1-2"' in text


def test_rows_show_kinds_blanks_and_what_is_off(folder: Path) -> None:
    rows = (
        "| Red ball | map | redBall.x | | | |\n| | map | value | X | | |\n| X | subscribe | | Say | FALSE | my note |\n"
    )
    (folder / "rows.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    text = get(visit(folder), book("rows.md")).text
    for expected in (
        '<span class="name sensor"><span class="only-spoken">sensor </span>Red ball</span>',
        "↓ row below", "↑ row above", '<tr id="s1-4" class="off">', "my note", "#i-map",
    ):  # fmt: skip
        assert expected in text


def test_rows_that_hang_on_a_mistake_are_shown_all_the_same(folder: Path) -> None:
    rows = "| Red ball | mapp | redBall.x | | | |\n| | subscribe | | Say | | |\n| | map | value | X | FALSE | |\n"
    (folder / "hang.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    client = visit(folder)
    assert get(client, "/").status_code == 200
    assert "Did you mean map?" in get(client, book("hang.md")).text
    assert get(client, f"{book('hang.md')}/diagram/1.svg").text.startswith("<svg")


def test_a_page_has_words_other_sheets_and_the_command(folder: Path) -> None:
    more = (
        "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 1 | Red ball | appears | at 1, 0, 0 |\n"
    )
    mine = "\n## Budget\n| Euro |\n|---|\n| 7 |\n"
    (folder / "my book.md").write_text(GOOD + more + mine, encoding="utf-8")
    text = get(visit(folder), book("my book.md")).text
    for expected in (
        "In words", "Row by row", "at 1, 0, 0", "left alone: Budget", "rrp-sheets run", "does not edit", "a text editor",
    ):  # fmt: skip
        assert expected in text


def test_commands_are_quoted_and_name_no_option() -> None:
    lines = [commands(Path(name))[0].line for name in ("my book.xlsx", "-x.xlsx")]
    assert lines == ["rrp-sheets run 'my book.xlsx'", "rrp-sheets run ./-x.xlsx"] or sys.platform == "win32"


@pytest.mark.parametrize("path", sorted(bundled("workbooks").glob("*.xlsx")), ids=lambda p: p.stem)
def test_bundled_workbooks_are_shown_without_inline_script_or_style(path: Path) -> None:
    text = get(visit(path.parent), book(path.name)).text
    assert "no problems" in text and "Excel or LibreOffice" in text
    assert not re.search(r"<script|<style|\sstyle=|\son\w+=|javascript:", text)


def test_a_long_behaviour_is_cut_and_says_so(folder: Path) -> None:
    rows = "".join(f"| Red ball | map | redBall.x | X{n} | | |\n" for n in range(2010))
    (folder / "long.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    text = get(visit(folder), book("long.md")).text
    assert "… and 10 more rows" in text and "X1999" in text and "X2000<" not in text


# ---- no text becomes markup ----


@pytest.mark.skipif(sys.platform == "win32", reason="such names cannot be there")
def test_hostile_texts_are_shown_as_text(tmp_path: Path) -> None:
    name = f"{IMAGE} {{{{7*7}}}} #&?.md"
    cell = HOSTILE + IMAGE.replace("|", "")
    rows = f"| Red ball | map | redBall.x + '{cell}' | {cell} | {cell} | {cell} |\n| {cell} | {cell} | x | Say | | |\n"
    protocol = (
        f"\n## Protocol\n| Field | Value |\n|---|---|\n| Title | {cell} |\n| Purpose | {cell} |\n| {cell} | {cell} |\n"
    )
    devices = f"\n## Devices\n| Stream | Device | {cell} |\n|---|---|---|\n| {cell} | Say | {cell} |\n"
    text = f"## {cell}\n{HEADER}{rows}{protocol}{devices}"
    (tmp_path / name).write_text(text, encoding="utf-8")
    client = visit(tmp_path)
    shelf, page = get(client, "/"), get(client, book(name))
    for answer in (shelf, page):
        assert answer.status_code == 200
        assert "<script" not in answer.text and "<img src=x" not in answer.text
        assert "&lt;script&gt;" in answer.text
    assert "{{7*7}}" in page.text
    picture = get(client, f"{book(name)}/diagram/1.svg")
    assert picture.status_code == 200 and picture.mimetype == "image/svg+xml"
    tags = {element.tag.split("}")[1] for element in ElementTree.fromstring(picture.text).iter()}
    assert tags <= {"svg", "title", "desc", "g", "path", "text", "rect", "circle", "ellipse", "line"}


def test_a_diagram_that_is_not_there(folder: Path) -> None:
    client = visit(folder)
    assert get(client, "/book/good.md/diagram/1.svg").text.startswith("<svg")
    for number in ("0", "2", "x", "-1"):
        assert get(client, f"/book/good.md/diagram/{number}.svg").status_code == 404


def test_a_diagram_that_cannot_be_drawn_says_why(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rrp_sheets.render.layout.binaries", list)
    answer = get(visit(folder), "/book/good.md/diagram/1.svg")
    assert answer.status_code == 200 and "Diagrams need Graphviz" in answer.text
