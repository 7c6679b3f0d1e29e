"""Texts of the pages that `serve` shows; no text of a workbook becomes markup."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from browser import GOOD, HEADER, HOME, book, checked, get, post, visit
from flask.testing import FlaskClient

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.web.services import make_services
from rrp_sheets.workers.worker_process import WorkerClosed

LIBRARY = sorted(bundled("workbooks").glob("*.xlsx"))
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
    text = checked(visit(folder), book("wrong.md"))
    formula = re.search(r'<td [^>]*class="formula flagged is-error"[^>]*aria-describedby="(p\d+)"[^>]*>.*?</td>', text)
    assert formula and "redBall.distence" in formula[0] and "Did you mean distance?" in formula[0]
    assert re.search(r'data-cell="C2">Tracking!C2</a></span><p>[^<]*<small class="code">FORM007', text)
    assert re.search(r'<td [^>]*class="on flagged is-error"', text)


def test_rows_show_kinds_blanks_and_what_is_off(folder: Path) -> None:
    rows = (
        "| Red ball | map | redBall.x | | | |\n| | map | value | X | | |\n| X | subscribe | | Say | FALSE | my note |\n"
    )
    (folder / "rows.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    text = checked(visit(folder), book("rows.md"))
    for expected in (
        '<span class="name sensor"><span class="only-spoken">sensor </span>Red ball</span>',
        "↓ row below", 'aria-rowindex="4" class="off"', "my note", 'data-icon="map"',
    ):  # fmt: skip
        assert expected in text


def test_rows_that_hang_on_a_mistake_are_shown_all_the_same(folder: Path) -> None:
    rows = "| Red ball | mapp | redBall.x | | | |\n| | subscribe | | Say | | |\n| | map | value | X | FALSE | |\n"
    (folder / "hang.md").write_text("## Tracking\n" + HEADER + rows, encoding="utf-8")
    client = visit(folder)
    assert get(client, "/").status_code == 200
    assert "Did you mean map?" in checked(client, book("hang.md"))
    assert get(client, f"{book('hang.md')}/diagram/1.svg").text.startswith("<svg")


def test_a_page_has_words_tabs_and_sheets_of_ones_own(folder: Path) -> None:
    more = (
        "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 1 | Red ball | appears | at 1, 0, 0 |\n"
    )
    mine = "\n## Budget\n| Euro |\n|---|\n| 7 |\n"
    (folder / "my book.md").write_text(GOOD + more + mine, encoding="utf-8")
    client = visit(folder)
    text = checked(client, book("my book.md"))
    for expected in ("In words", ">Scene</span></a>", "edit it in Excel or LibreOffice", ">Budget</span></a>"):
        assert expected in text
    assert "at 1, 0, 0" in get(client, f"{book('my book.md')}/sheet/Scene").text


def test_a_browser_asks_for_each_script_and_style_once(folder: Path) -> None:
    client = visit(folder)
    addresses = re.findall(r'<(?:script|link)\b[^>]* (?:src|href)="([^"]+)"', get(client, book("good.md")).text)
    assert any("htmx" in address for address in addresses)
    assert [address for address in addresses if not get(client, address).cache_control.immutable] == []
    scripts = bundled("templates", "web", "static").rglob("*.js")
    assert [path.name for path in scripts if re.search(r'(?:from |import\()"/', path.read_text(encoding="utf-8"))] == []


def test_a_page_is_told_once_of_a_check_that_ended_before_its_event_stream(folder: Path) -> None:
    client = visit(folder)
    session = client.application.extensions["services"].open_workbooks.session(folder / "good.md")
    before = session.backlog.number.partition(".")[0] + ".0"
    checked(client, book("good.md"))
    told = session.join("late.1", "Aya", had=before).messages
    assert len([message for message in told if "event: checked" in message]) == 1


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> FlaskClient:
    """A visitor of all workbooks that come along."""
    folder = tmp_path_factory.mktemp("library")
    for path in LIBRARY:
        (folder / path.name).write_bytes(path.read_bytes())
    return visit(folder)


@pytest.mark.slow
@pytest.mark.parametrize("path", LIBRARY, ids=lambda p: p.stem)
def test_bundled_workbooks_are_shown_without_inline_script_or_style(path: Path, library: FlaskClient) -> None:
    text = checked(library, book(path.name))
    assert 'class="badge error"' not in text
    assert not re.search(
        r"<script(?! type=.application/json| type=.module. src| src)|<style|\sstyle=|\son\w+=|javascript:", text
    )


# ---- the shelf's actions ----


def test_a_new_workbook_a_copy_another_name_the_archive(tmp_path: Path) -> None:
    client = visit(tmp_path)
    made = post(client, "/shelf/new", name="mine", template="simple-tracking")
    assert "Created mine.xlsx" in made.text and made.headers["HX-Redirect"] == book("mine.xlsx")
    assert "Created mine (2).xlsx" in post(client, "/shelf/copy", book="mine.xlsx").text
    assert "mine (2).xlsx is now other.xlsx" in post(client, "/shelf/rename", book="mine (2).xlsx", name="other").text
    assert "in the folder archive" in post(client, "/shelf/archive", book="other.xlsx").text
    assert sorted(p.name for p in tmp_path.rglob("*.xlsx")) == ["mine.xlsx", "other.xlsx"]
    assert (tmp_path / "archive" / "other.xlsx").is_file()


@pytest.mark.parametrize("name", ["../x", "a/b", ".hidden", "", "x" * 200, "good.md", "a\nb", "con:x", "NUL"])
def test_names_that_cannot_be_are_refused_in_words(folder: Path, name: str) -> None:
    before = sorted(folder.rglob("*"))
    text = post(visit(folder), "/shelf/new", name=name, template="guided").text
    assert "cannot be the name of a file" in text or "There is already a file" in text
    assert [p for p in sorted(folder.rglob("*")) if ".rrp-sheets" not in str(p)] == before


def test_only_workbooks_can_be_uploaded(folder: Path) -> None:
    client = visit(folder)
    good = bundled("workbooks", "simple-tracking.xlsx").read_bytes()
    assert "is uploaded" in post(client, "/shelf/upload", file=(io.BytesIO(good), "up.xlsx")).text
    for content in (b"", b"PK\x03\x04 broken", b"MZ" * 100):
        text = post(client, "/shelf/upload", file=(io.BytesIO(content), "bad.xlsx")).text
        assert "notice is-error" in text and not (folder / "bad.xlsx").exists()
    assert post(client, "/shelf/upload", file=(io.BytesIO(b"0" * 9_000_000), "big.xlsx")).status_code == 413


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
    checked(client, book(name))
    shelf, page = get(client, "/"), get(client, book(name))
    for answer in (shelf, page):
        assert answer.status_code == 200
        assert "<script>" not in answer.text and "<img src=x" not in answer.text
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
    monkeypatch.setattr("rrp_sheets.render.boxes.binaries", list)
    answer = get(visit(folder), "/book/good.md/diagram/1.svg")
    assert answer.status_code == 200 and "Diagrams need Graphviz" in answer.text


def test_settings_that_a_device_does_not_take_are_marked(folder: Path) -> None:
    devices = (
        "\n## Devices\n| Stream | Device | Text | Joint |\n|---|---|---|---|\n| Hello | Say | Hi | |\n| X | | | |\n"
    )
    (folder / "devices.md").write_text(GOOD + devices, encoding="utf-8")
    text = checked(visit(folder), f"{book('devices.md')}/sheet/Devices")
    rows = re.findall(r'<tr role="row".*?</tr>', text)
    assert rows[1].count(' untaken"') == 1 and 'data-v="Hi"' in rows[1]
    assert "untaken" not in rows[2]


def test_an_edit_gives_its_cell_free_and_tells_where_the_cursor_goes(folder: Path) -> None:
    client = visit(folder)
    session = client.application.extensions["services"].open_workbooks.session(folder / "good.md")
    page = session.join("mine.1", "Aya")
    row, below = session.document.grids["Tracking"].rows[:2]

    def send(action: str, person: str, **more: Any) -> Any:
        sent = {"client": f"{person}.1", "name": person, "sheet": "Tracking", "tag": "1", **more}
        return client.post(
            f"{book('good.md')}/{action}", base_url=HOME, headers={"X-RRP": "grid", "Origin": HOME}, json=sent
        )

    cell = {"row": row, "column": 6}
    cells = [{**cell, "text": "a note", "was": ""}]
    assert send("lock", "mine", **cell).json == {}
    assert "mine is editing" in send("lock", "Ben", **cell).json["message"]
    for wrong in ("x", {"row": row}, {"row": 1, "column": 6}):
        assert send("cells", "mine", cells=cells, unlock=wrong).status_code == 400
        assert send("cells", "mine", cells=cells, stand=wrong).status_code == 400
    assert "message" not in send("cells", "mine", cells=cells, unlock=cell, stand={"row": below, "column": 6}).json
    assert page.place == ("Tracking", below, 6)
    assert send("lock", "Ben", **cell).json == {}


@pytest.mark.slow
def test_services_that_are_closed_leave_no_process_and_start_none(tmp_path: Path) -> None:
    made = make_services(tmp_path)
    workers = [service._worker for service in vars(made).values() if isinstance(service, QueryWorker)]
    request = ["rrp_sheets.services.query_worker.course", str(tmp_path / "none"), "en"]
    for worker in workers:
        with pytest.raises(SheetsError, match="cannot be read"):
            worker.ask(request, 60)
    assert len(workers) > 3 and all(worker.pid for worker in workers)
    made.close()
    for worker in workers:
        assert worker.pid is None
        with pytest.raises(WorkerClosed):
            worker.ask(request, 60)
