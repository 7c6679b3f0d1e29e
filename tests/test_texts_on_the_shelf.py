"""A Markdown file without sheets of ours, such as a README, is no workbook anywhere."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path

import pytest
from browser import GOOD, book, get, post, visit
from flask.testing import FlaskClient
from recorded import END, EVENT, HEADER, write_run

from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES

README = "# About\n\n## Who was there\n\n| Name | Day |\n|---|---|\n| Aya | Monday |\n"
DEVICES = "## Devices\n| Stream | Device |\n|---|---|\n| Ball | Red ball |\n"
NEARLY = GOOD.replace("| Connector |", "| Conector |")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("books")
    texts = {"good.md": GOOD, "README.md": README, "notes.markdown": "Only words.\n", "half.md": DEVICES,
             "nearly.md": NEARLY}  # fmt: skip
    for name, text in texts.items():
        (made / name).write_text(text, encoding="utf-8")
    run = write_run(made, "one", HEADER, EVENT, END)
    (run / "protocol.md").write_text(GOOD, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> FlaskClient:
    return visit(folder)


@pytest.mark.parametrize("address", ["/compare", "/book/good.md/print", "/runs/one/replay"])
def test_lists_of_workbooks_leave_texts_out(client: FlaskClient, address: str) -> None:
    offered = set(re.findall(r'<option value="book/([^"]+)"', get(client, address).text))
    own = {"good.md"} if address.endswith("print") else set()  # it is not compared with itself
    assert offered == {"good.md", "half.md", "nearly.md"} - own


def test_the_shelf_says_what_they_are(client: FlaskClient) -> None:
    text = get(client, "/").text
    assert "Not workbooks, as no sheet in them is a behaviour: notes.markdown, README.md" in text
    assert all(f'href="/book/{name}"' in text for name in ("good.md", "half.md", "nearly.md"))


@pytest.mark.parametrize("name", ["README.md", "notes.markdown"])
def test_no_address_opens_one(client: FlaskClient, name: str) -> None:
    for page in ("", "/run", "/print", "/print/protocol", "/versions"):
        answer = get(client, f"{book(name)}{page}")
        assert answer.status_code == 422 and f"“{name}” is not a workbook" in answer.text, page
    text = get(client, f"/compare?first=book/{name}&second=book/good.md").text
    assert f"“{name}” is not a workbook but a text for people." in text


def test_a_readme_that_shows_rows_is_still_a_text(tmp_path: Path) -> None:
    (tmp_path / "Readme.md").write_text(GOOD, encoding="utf-8")
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    client = visit(tmp_path)
    assert 'value="book/Readme.md"' not in get(client, "/compare").text
    assert get(client, book("Readme.md")).status_code == 422
    assert f'href="{book("Readme.md")}"' not in get(client, "/").text


def test_one_is_not_taken_in(client: FlaskClient, folder: Path) -> None:
    answer = post(client, "/shelf/upload", file=(BytesIO(README.encode()), "about.md"))
    assert "“about.md” is not a workbook" in answer.text and not (folder / "about.md").exists()


def test_upload_offers_every_kind_of_workbook(client: FlaskClient) -> None:
    (accept,) = re.findall(r'type="file" name="file" accept="([^"]+)"', get(client, "/").text)
    assert set(accept.split(",")) == {*WORKBOOK_SUFFIXES, ".zip"}


def test_a_file_that_becomes_a_workbook_is_one_from_then_on(tmp_path: Path) -> None:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    (tmp_path / "plan.md").write_text(README, encoding="utf-8")
    client = visit(tmp_path)
    assert 'value="book/plan.md"' not in get(client, "/compare").text
    (tmp_path / "plan.md").write_text(GOOD, encoding="utf-8")
    assert 'value="book/plan.md"' in get(client, "/compare").text
    assert get(client, book("plan.md")).status_code == 200
    (tmp_path / "plan.md").write_text(README, encoding="utf-8")  # its page is open: nothing is taken away from it
    assert get(client, book("plan.md")).status_code == 200
